"""Write the coils as a footprint of KiCad 7 or later; tracks as copper arcs, or lines of rectangles, polygons and Ds.

A coil of n layers is n spirals r(theta) in series (`geometry.windings`; of straight lines, two at most, as of
`scene.turns`), on F.Cu, inner layers, B.Cu from the top down, all turning the same way seen from above. Two
neighbouring layers make a pair: inwards, through a via inside the coil, outwards. Pairs follow each other through vias
outside the coil, each pair turned on by an angle, so that no via meets another. Pads 2 i - 1 and 2 i are start and end
of coil i: a positive current enters at the first. With an odd number of layers the end stays inside the coil.

The board's y axis points down. Copper of a footprint belongs to no net: each coil's pads are declared a net tie.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sits_mech.export.source import Source
from sits_mech.geometry.outline import target_outline
from sits_mech.geometry.windings import turn_radii
from sits_mech.quantities import Array
from sits_mech.scene.files import write_text
from sits_mech.scene.parts.turns import spiral_turns, turn
from sits_mech.scene.sensor import Coil, SceneError, Sensor
from sits_mech.units import MM, shown
from sits_mech.units import millimetres as mm

_ARCS = 12  # per turn
_SIDE = {"rectangle": np.pi / 2, "hexagon": np.pi / 3, "octagon": np.pi / 4, "D": np.pi / 2}  # from one to the next
_STRAIGHT = 2  # layers of straight lines: at a corner there is no room for the vias of more
_VIA, _DRILL = 0.4e-3, 0.2e-3  # diameters of vias [m]
_PAD, _HOLE = 1.0e-3, 0.6e-3  # of the pads at a coil's ends [m]


@dataclass(frozen=True)
class TrackRun:
    """A run of copper on one layer: arcs through points, shape (2 m + 1, 2), or straight lines along them [m]."""

    layer: str
    points: Array
    arcs: bool
    width: float


@dataclass(frozen=True)
class PlatedHole:
    """A plated hole with its copper ring; ``number`` is "" for a via [m]."""

    place: Array
    diameter: float
    drill: float
    number: str = ""


@dataclass(frozen=True)
class Winding:
    """A coil on the board: tracks and holes, in the sensor's coordinates x, y."""

    tracks: tuple[TrackRun, ...]
    holes: tuple[PlatedHole, ...]


def write_kicad(source: Source, path: Path) -> tuple[str, ...]:
    """Write the footprint of all coils, one centre for the whole sensor.

    Raise SceneError when vias have no room, the substrate is curved, numbers of layers differ or the write fails.
    """
    sensor = source.sensor
    windings = [winding(sensor, number) for number in range(len(sensor.coils))]
    write_text(path, _footprint(sensor, windings, path.stem))
    holes = f"vias {MM * _VIA:g}/{MM * _DRILL:g} mm, pads {MM * _PAD:g}/{MM * _HOLE:g} mm"
    layers = ", ".join(layers_of_coil(sensor.coils[0].layers))
    return (f"{holes}; layers of the board, from the top: {layers}; for KiCad 7 or later",)


def layers_of_coil(count: int) -> tuple[str, ...]:
    """Return the board's names of a coil's layers, from the top down."""
    return ("F.Cu", *(f"In{k}.Cu" for k in range(1, count - 1)), "B.Cu")[: max(count, 1)]


def winding(sensor: Sensor, number: int) -> Winding:
    """Return tracks and holes of a flat coil, its ends leading away from the others; raise as `write_kicad`."""
    coil = sensor.coils[number]
    inner = _check(sensor, coil)
    turned = 1.1 * (_VIA + coil.track_gap) / max(inner, 1e-9)  # from one pair to the next: their vias keep the gap
    first, pairs = _away(sensor, number), (coil.layers + 1) // 2
    if not coil.is_round:  # from the middle of a side, where leads go straight out
        first = coil.alpha_z + _SIDE[coil.shape] * round((first - coil.alpha_z) / _SIDE[coil.shape])
    if pairs > 1 and pairs * turned > np.pi:
        raise SceneError(f"coils.{coil.name}.layers: must have room for a via for each two of them; got {coil.layers}")
    outside = _outer_ends(coil, first, turned, number)
    tracks = []
    holes = list({(hole.place[0], hole.place[1]): hole for hole in outside}.values())
    for k, layer in enumerate(layers_of_coil(coil.layers)):
        angle, inwards = first + (k // 2) * turned, k % 2 == 0
        via = _polar(np.array([inner]), np.array([angle]))
        spiral = _spiral(coil, angle, inwards)
        out = [outside[k].place[None]] if k < len(outside) else []
        before, after = (out, [via]) if inwards else ([via], out)
        for line, arcs in (
            ([*before, spiral[:1]], False), ([spiral], coil.is_round), ([spiral[-1:], *after], False)
        ):
            tracks += [TrackRun(layer, np.vstack(line), arcs, coil.track_width)] if sum(map(len, line)) > 1 else []
        if inwards:
            last = str(2 * number + 2) if k == coil.layers - 1 else ""
            holes.append(PlatedHole(via[0], _VIA, _DRILL, last))
    centre = np.asarray(coil.centre)
    return Winding(
        tuple(replace(item, points=item.points + centre) for item in tracks),
        tuple(replace(item, place=item.place + centre) for item in holes),
    )


def _spiral(coil: Coil, angle: float, inwards: bool) -> Array:
    """Return a layer's spiral about the middle from an angle on, counter-clockwise."""
    if not coil.is_round:
        if not inwards:
            return spiral_turns(coil, angle)
        image = coil.model_copy(update={"alpha_z": -coil.alpha_z})  # in the x axis
        return spiral_turns(image, -angle)[::-1] * (1.0, -1.0)
    theta = np.linspace(0.0, 2.0 * np.pi * coil.turns, 2 * _ARCS * coil.turns + 1)
    start, stop = _reach(coil)[::-1] if inwards else _reach(coil)
    return _polar(start + (stop - start) * theta / theta[-1], angle + theta)


def _reach(coil: Coil) -> tuple[float, float]:
    """Return the least radius at which spirals start, and the largest at which they stop [m]."""
    half = (coil.track_width + coil.track_gap) / 2
    if not coil.is_round:
        away = coil.track_width + (coil.turns - 1) * 2 * half
        inside, around = turn(coil, coil.track_width / 2 - half), turn(coil, away - coil.track_width / 2 + half)
        return _nearest(inside), float(np.hypot(*around.T).max())
    radii = turn_radii(coil)
    return float(radii[0] - half), float(radii[-1] + half)


def _nearest(rim: Array) -> float:
    """Return the distance of a closed line (m, 2) from the middle [m]."""
    step = np.roll(rim, -1, axis=0) - rim
    share = np.clip(-(rim * step).sum(axis=1) / (step**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(rim + share[:, None] * step).T).min())


def _outer_ends(coil: Coil, first: float, turned: float, number: int) -> list[PlatedHole]:
    """Return where each layer ends outside the coil, about its centre: pads for the coil's ends, vias between pairs."""
    edge = _reach(coil)[1] + coil.track_width / 2 + coil.track_gap
    far = edge + _PAD / 2
    aside = (0.5 * _PAD + coil.track_gap) / far
    found = []
    for k in range(coil.layers):
        angle = first + (k // 2) * turned
        if k in (0, coil.layers - 1) and (k == 0 or k % 2):
            place = _polar(far, angle + (aside if k else -aside))[0]
            found.append(PlatedHole(place, _PAD, _HOLE, str(2 * number + 1 + (k > 0))))
        else:
            between = first + ((k + 1) // 2 - 0.5) * turned
            found.append(PlatedHole(_polar(edge + _VIA / 2, between)[0], _VIA, _DRILL))
    return found


def _check(sensor: Sensor, coil: Coil) -> float:
    """Return the radius that the inner vias stand at [m]; refuse what has no room for them."""
    if sensor.substrate_radius is not None:
        raise SceneError("substrate_radius: must not be given for --to kicad: a footprint is flat")
    _check_shape(coil)
    if len({item.layers for item in sensor.coils}) > 1:
        raise SceneError("coils: must have one number of layers for --to kicad, which are the board's")
    inner = _reach(coil)[0] - coil.track_width / 2 - coil.track_gap - _VIA / 2
    if inner < 0.0:
        sizes = {key: getattr(coil, key) for key in ("inner_diameter", "inner_width", "inner_length")}
        key, size = min(((key, size) for key, size in sizes.items() if size), key=lambda each: each[1])
        raise SceneError(
            f"coils.{coil.name}.{key}: must be at least {mm(size - 2.0 * inner)} for a via; got {mm(size)}"
        )
    return float(inner)


def _check_shape(coil: Coil) -> None:
    """Refuse a coil that is not drawn by its turns."""
    if coil.shape == "path":
        raise SceneError(f'coils.{coil.name}.shape: must have turns for --to kicad; got "path", as boards have it')
    if not coil.is_round and coil.layers > _STRAIGHT:
        most = f"at most {_STRAIGHT} of a {coil.shape} for --to kicad"
        raise SceneError(f"coils.{coil.name}.layers: must be {most}; got {coil.layers}")
    for key in ("layer_z", "directions", "corner_radius"):
        if getattr(coil, key) != type(coil).model_fields[key].default:
            got = shown(getattr(coil, key))
            raise SceneError(f"coils.{coil.name}.{key}: must not be given for --to kicad; got {got}")


def _away(sensor: Sensor, number: int) -> float:
    """Return the direction in which a coil's ends lead away from the other coils [rad]; towards -y for one alone."""
    centres = np.array([coil.centre for coil in sensor.coils])
    out = centres[number] - centres.mean(axis=0)
    return float(np.arctan2(out[1], out[0])) if np.hypot(*out) > 1e-9 else -np.pi / 2


def _polar(radius: Array | float, angle: Array | float) -> Array:
    """Return points x, y at radii and angles."""
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def _footprint(sensor: Sensor, windings: list[Winding], name: str) -> str:
    """Return the file's text."""
    places = np.vstack([track.points for item in windings for track in item.tracks])
    places = np.vstack([places, *(hole.place[None] for item in windings for hole in item.holes)])
    low, high = places.min(axis=0) - _PAD, places.max(axis=0) + _PAD
    ties = " ".join(f'"{2 * i + 1},{2 * i + 2}"' for i in range(len(windings)))
    lines = [
        f'(footprint "{_quoted(name)}" (version 20221018) (generator sits_mech)',
        '  (layer "F.Cu")',
        f'  (descr "Coils of: {_quoted(sensor.name)}")',
        "  (attr exclude_from_pos_files exclude_from_bom)",
        f"  (net_tie_pad_groups {ties})",
        _text("reference", "REF**", (low[0], high[1]), "F.SilkS"),
        _text("value", name, (low[0], low[1]), "F.Fab"),
        _drawn(f"fp_rect (start {_point(low)}) (end {_point(high)})", "F.CrtYd", 0.05e-3),
    ]
    if sensor.target is not None:
        corners = " ".join(f"(xy {_point(point)})" for point in target_outline(sensor.target).rim)
        lines.append(_drawn(f"fp_poly (pts {corners})", "Dwgs.User", 0.1e-3))
    for item in windings:
        lines += sum(map(_copper, item.tracks), list[str]())
        lines += map(_hole, item.holes)
    return "\n".join([*lines, ")", ""])


def _copper(track: TrackRun) -> list[str]:
    """Return the lines of one run of copper."""
    end = f'(stroke (width {_number(track.width)}) (type solid)) (layer "{track.layer}"))'
    p = [_point(point) for point in track.points]
    if track.arcs:
        arcs = zip(p[:-2:2], p[1:-1:2], p[2::2], strict=True)
        return [f"  (fp_arc (start {a}) (mid {b}) (end {c}) {end}" for a, b, c in arcs]
    return [f"  (fp_line (start {a}) (end {b}) {end}" for a, b in zip(p[:-1], p[1:], strict=True)]


def _hole(hole: PlatedHole) -> str:
    """Return the line of a pad or a via."""
    size = _number(hole.diameter)
    mask = ' "*.Mask"' if hole.number else ""
    return (
        f'  (pad "{hole.number}" thru_hole circle (at {_point(hole.place)}) (size {size} {size}) '
        f'(drill {_number(hole.drill)}) (layers "*.Cu"{mask}))'
    )


def _text(kind: str, text: str, place: tuple[float, float], layer: str) -> str:
    """Return the line of a text."""
    at = _point(np.array(place))
    font = "(effects (font (size 1 1) (thickness 0.15)) (justify left))"
    return f'  (fp_text {kind} "{_quoted(text)}" (at {at}) (layer "{layer}") {font})'


def _drawn(shape: str, layer: str, width: float) -> str:
    """Return the line of a closed shape that is not filled."""
    return f'  ({shape} (stroke (width {_number(width)}) (type solid)) (fill none) (layer "{layer}"))'


def _point(point: Array) -> str:
    """Return a point on the board, y down [mm]."""
    return f"{_number(point[0])} {_number(-point[1])}"


def _number(metres: float) -> str:
    """Return a length in millimetres to the board's nanometre."""
    return f"{MM * metres + 0.0:.6f}".rstrip("0").rstrip(".").replace("-0", "0", int(abs(metres) < 5e-10))


def _quoted(text: str) -> str:
    """Return a text that may stand in quotes."""
    return text.replace("\\", "/").replace('"', "'").replace("\n", " ")
