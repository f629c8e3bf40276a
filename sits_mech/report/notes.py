"""Say notes in words: one sentence for each, by its kind; numbers of it in units that are read easily."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.mechanics.equilibrium.outcome import PathEnd
from sits_mech.mechanics.levels.words import WORDS
from sits_mech.memory import memory_words
from sits_mech.notes import Note, NoteKind, unpacked
from sits_mech.quantities import POSE, UNITS
from sits_mech.report.left_out import bare_words

if TYPE_CHECKING:
    import xarray as xr

Numbers = Mapping[str, Any]

_SURFACES = {
    "ground": "the ground",
    "target": "the target's plane, taken to extend beyond the target",
    "sides": "the target's sides",
}
_ENDS = {
    PathEnd.BUCKLED: "buckling",
    PathEnd.SIDEWAYS: "buckling sideways",
    PathEnd.INVERTED: "folding: the mesh turns inside out at a corner",
}
"""Limits of a pad by the end of a load path; all others are limit loads."""


def _touched(known: Numbers) -> str:
    """Say which surface a face touches, and how that is solved."""
    rough = known["friction"]
    how = f"contact with friction {rough:g}" if rough > 0.0 else "frictionless contact"
    return f"a free face touches {_SURFACES[known['surface']]}: {how}"


def _skin(known: Numbers) -> str:
    """Say in which skin regime a plate is, and what carries it."""
    depths = known["depths"]
    regime = "thin" if depths < 1.0 else "thick" if depths > 3.0 else "intermediate"
    return (
        f"{regime} skin regime: thickness is {depths:.3g} skin depths; {known['sheets']} sheets joined at the rim"
    )


def _faces_free(known: Numbers) -> str:
    """Say how many faces of a mesh are in no group, and where the first is."""
    first = ", ".join(f"{1e3 * known[name] + 0.0:.4g}" for name in "xyz")
    return (
        f"{known['mesh']}: {known['count']} of {known['of']} faces of the surface are in no group and taken as free, "
        f"the first about ({first}) mm"
    )


def _path(known: Numbers) -> str:
    """Say along which path of loads friction was followed."""
    way = "straight from zero load" if known["legs"] == 1 else "along the given loads"
    return (
        f"friction: load path {way}, {known['parts']} steps per leg; half as many change this by {known['change']:.1g}"
    )


def _plate(known: Numbers) -> str:
    """Say that a plate's finer division takes too much memory."""
    size = f"{1e3 * known['width']:.3g} x {1e3 * known['length']:.3g} mm"
    takes = memory_words(known["needed"], known["limit"])
    return (
        f"memory: {known['cells']:.0f} cells of the plate of {size} take {takes}: a coarser division is taken, whose "
        "error is the estimated one"
    )


def _placed(known: Numbers) -> str:
    """Say which parts of a pose a scene has no place for."""
    parts = (f"{name} {known[name]:.3g} {UNITS[name]}" for name in POSE if name in known)
    return f"in the table, not in the scene: {', '.join(parts)}"


_TEMPLATES: Mapping[NoteKind, str] = {
    NoteKind.TOLERANCE_MISSED: "estimated error {error:.2g}: the tolerance {tolerance:g} is missed",
    NoteKind.SIGNALS_MISSED: (
        "above the tolerance by errors, of the signals' full scale, of the pose ({pose:.2g} %, most by {component}), "
        "the magnetic model ({model:.2g} %) and what is left out ({left_out:.2g} %); largest in {coil}"
    ),
    NoteKind.STATED: "{text}",
    NoteKind.NO_HISTORY: (
        "the silicone has neither prony nor mullins: its rate and softening are unknown, and left out"
    ),
    NoteKind.NO_LOOP: (
        "no loop: the silicone has neither prony nor mullins, so it is elastic; widths other than zero are rounding"
    ),
    NoteKind.FACE_RISES: "silicone rises above the target's top face: its sides are taken to extend upwards",
    NoteKind.FACES_TOUCH: "free faces touch each other: frictionless contact",
    NoteKind.FACES_CROSS: (
        "free faces pass through one another: this contact is not in the answer, the true pad is stiffer"
    ),
    NoteKind.CONTACT_LOST: (
        "contact could not be followed to this load: the estimated error is the whole displacement"
    ),
    NoteKind.EDGE_SHARP: "the target's edge stays sharp: no side face of the layer ends there that could have a radius",
    NoteKind.EDGE_LEFT_OUT: (
        "elastomer.edge_radius is left out: the edges of this model are sharp, or as its mesh has them"
    ),
    NoteKind.NODES_MERGED: "{mesh}: {count} duplicated nodes were merged, as elastomer.weld asks",
    NoteKind.INTERPOLATED: "pose interpolated between solved loads by a smooth map",
    NoteKind.PATH_PART: "reached {part:.1%} of the path",
    NoteKind.TIMES: "history: {count} times on {meshes} meshes; error of the time steps {error:.1g}",
    NoteKind.AS_A_WHOLE: "rate: relaxation of the pad as a whole, component by component",
    NoteKind.SLIP_LEFT_OUT: (
        "elastomer.friction: every load comes straight from rest; what slips there and back is not in the loop"
    ),
    NoteKind.RINGS: "disc as {rings} rings, extrapolated from {levels} levels of division",
    NoteKind.SPIRALS_AS_RINGS: "spiral windings taken as rings",
    NoteKind.SPIRALS: "spiral windings: L0 differs from that of rings by up to {share:.2%}",
    NoteKind.PERMEABLE: "permeable, mu_r = {permeability:g}, {depths:.3g} skin depths thick: saturation is left out",
    NoteKind.FIELD_ON: (
        "permeable: the coils' own field on it is up to {field:.2g} A/m per ampere; compare it with its saturation"
    ),
    NoteKind.GAP_SMALL: "the gap is small for so wide a plate: {share:.1%} of the coils' field is not resolved",
    NoteKind.LARGE_LOAD: (
        "a large load for this pad: small strain would be off by {bound:.2g}; some pads became unstable in shear from "
        "{held:g}, in compression from about 1.5: only a solve can tell, and a refusal says how much holds"
    ),
    NoteKind.NOT_CARRIED: "a large load for this pad: {text}",
    NoteKind.OUT_OF_REACH: "the tolerance {tolerance:g} cannot be reached at this load, about {reached:.1g} can",
    NoteKind.NO_CODES: "no codes: {text}",
    NoteKind.ADAPTED: "adapted to {count} readings of {source}",
    NoteKind.LIMIT_DATA: "stretch beyond {stretch:.3g}, the end of the silicone's data",
    NoteKind.LIMIT_ERROR: "error of the pose beyond {tolerance:g} of the displacement",
    NoteKind.LIMIT_FOLD: "folding: free faces pass through one another",
    NoteKind.LIMIT_LOST: "no equilibrium found beyond: it may carry more",
    NoteKind.NO_LIMIT: "no limit was met up to {most:g} times",
}
_MADE: Mapping[NoteKind, Callable[[Numbers], str]] = {
    NoteKind.BENT: lambda known: (
        f"the target bends by up to {1e6 * known['deflection']:.2g} um, which is solved: the pose is that of a rigid "
        f"one that the coils read alike{bare_words(known.get('bare'))}"
    ),
    NoteKind.FACE_TOUCHES: _touched,
    NoteKind.FACE_FOLDS: lambda known: (
        f"a free face folds onto {_SURFACES[known['surface']]}: this contact is not in the answer, the true layer is "
        "stiffer"
    ),
    NoteKind.BELOW_GROUND: lambda known: (
        f"the target's rim is {1e3 * known['depth']:.3g} mm below the ground that the layer stands on: it would lie on "
        "the substrate there, which is not solved: the error is the whole displacement"
    ),
    NoteKind.EDGE_RADIUS: lambda known: (
        f"edge radius {1e3 * known['radius']:.3g} mm: moves the target by {1e6 * known['d_h']:+.3g} um along x, "
        f"{-1e6 * known['d_v']:+.3g} um down, {math.degrees(known['alpha']):+.3g} deg, against sharp edges "
        "(small strain)"
    ),
    NoteKind.FACES_FREE: _faces_free,
    NoteKind.MESH_TOO_LARGE: lambda known: (
        f"a finer mesh would take {memory_words(known['needed'], known['limit'])}: raise it for a smaller error"
    ),
    NoteKind.FRICTION_PATH: _path,
    NoteKind.FREE_TRACKS: lambda known: (
        f"{known['coil']}: free tracks, without {1e3 * known['vias']:.3g} mm of vias and {1e3 * known['back']:.3g} mm "
        "of way back"
    ),
    NoteKind.SKIN: _skin,
    NoteKind.PLATE_TOO_LARGE: _plate,
    NoteKind.PLACED: _placed,
    NoteKind.LIMIT_COILS: lambda known: (
        "contact with the coils or a fixed plate" if known["plates"] else "coil contact"
    ),
    NoteKind.OVERHANG: lambda known: (
        f"the target reaches {1e3 * known['over']:.3g} mm over its elastomer: there it is rigid and bonded to nothing, "
        "silicone that bulges lies on it, the ground does not stop its rim, and the coils see all of it"
    ),
    NoteKind.LIMIT_LOAD: lambda known: _ENDS.get(PathEnd(known["end"]), "limit load"),
}


def sentence(note: Note) -> str:
    """Return a note in words: of which part of the scene and at which frequency, where it names them, and what."""
    known = note.known
    if note.kind in WORDS:
        words = WORDS[note.kind](note)
    elif note.kind in _MADE:
        words = _MADE[note.kind](known)
    else:
        words = _TEMPLATES[note.kind].format(**known)
    part = f"{known['part']}: " if isinstance(known.get("part"), str) else ""
    return (f"at {known['at_frequency']:.4g} Hz: " if "at_frequency" in known else "") + part + words


def sentences(notes: Iterable[Note]) -> list[str]:
    """Return notes in words."""
    return list(map(sentence, notes))


def kept_sentences(text: str) -> list[str]:
    """Return the notes that a table keeps as text, in words."""
    return sentences(unpacked(text))


def joined_words(text: str) -> str:
    """Return the notes that a table keeps as text, as one line."""
    return "; ".join(kept_sentences(text))


def with_words(data: xr.Dataset) -> xr.Dataset:
    """Return a table with its notes on each row, in variables that begin with "notes", in words."""
    in_words = np.vectorize(joined_words, otypes=[object])
    kept = [name for name in data.data_vars if str(name).startswith("notes")]
    return data.assign({name: (data[name].dims, in_words(data[name].to_numpy().astype(object))) for name in kept})
