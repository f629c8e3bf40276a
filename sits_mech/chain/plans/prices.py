"""Predict error and seconds of loads at finite strain from their first two meshes.

Two meshes (0.1 to 0.5 s in space) have their own estimate e of the error. Where that is small enough the answer is
theirs. Otherwise a third mesh and a fourth follow, which take so many times the seconds of the first two and leave so
many times their error. Of many loads two are solved on these and correct all others. Those of pads are medians of 72
scenes and loads by chance, those of layers in the plane of ten, those of tables of nine; `benchmarks/promises.py` draws
other sixty, and compares predictions with results. Seconds are of processor time on one core of the machine that
`benchmarks/solve_costs.py` ran on, within a factor of some three elsewhere.

Rims in space that crease take no third mesh (`Levels.creased`, by J on two).

Of a grid those loads count that a smooth map is solved at (maps/grid.py). Loads in contact, or whose rims crease, are
not compared (corrections.py): where the largest load is one, its error is that of the table.

Before anything is solved a load is counted: the unknowns n of its first meshes, and its increments k by linear theory.
Two meshes then take some

    10 k^2.5 iterations of n 8e-6 (n/3674)^0.6 s,        k = max(1, |q|/1.5),

|q| the displacement of the target's edge in thicknesses (`biorob2018` under 3 N, 8 N and under 40 N, which linear
theory moves by 3.4 and 4.3, took 134 and 178), no more than the limit of time; and more by contact where the silicone
that the target displaces, sink min(w/2, sqrt(K/(12 mu))) for each of its sides, fills the half circle that a free wall
beside it bulges to before it folds onto ground and target. What presses on a cover is let in whatever its force: of it
iterations are counted, on meshes that are made.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from sits_mech.mechanics.closed_form import plain_pad
from sits_mech.mechanics.equilibrium.newton import LONGEST
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.models import strains_of
from sits_mech.mechanics.pad.families import pad_family
from sits_mech.mechanics.pad.planar import layer_family
from sits_mech.mechanics.pad.shapes import shape_of
from sits_mech.memory import SECONDS
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Equilibrium, MechanicalModel, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, shape_on_cover

_IN_PLANE = ((1.5, 0.25), (15.0, 0.02))
_FURTHER = {"block": ((2.7, 0.25), (8.0, 0.2)), "planar": _IN_PLANE, "axisymmetric": _IN_PLANE}
"""By model, a mesh more and all there are: seconds over those of two meshes, and error over theirs."""
_NONE = ((0.0, 1.0),)  # of a model with one set of meshes
_ONCE, _EACH = 0.05, 8e-6  # seconds of two meshes, and for each iteration and unknown of the finer one
_WANDERED = 24  # iterations of two meshes beyond which no finer one was seen to settle
_MEAN, COMPARED = 0.65, 2  # of the largest load's seconds, those of a load of a table; loads that are compared
SURE = 3.0
"""Times a predicted error: of 74 loads none reached less than 0.39 of it, so that what is farther away is missed."""
OF_ALL = 0.4
"""Of the largest error, what loads compared on a third mesh leave of all of a table: 0.18 to 0.39 of five."""
MANY_ON_THREE = 3e-3
"""Tolerance from which on many loads take three meshes, and a fourth if it promises that tolerance."""
FOURTH = 0.7
"""Of the error of three meshes in space, what a fourth leaves at most: 0.36 to 0.71 of five loads of two pads."""
_TOUCHING = NoteKind.FACE_TOUCHES, NoteKind.FACES_TOUCH
_PRESSED = 3.5e-4  # for each unknown where faces touch: the way there is by contact that grows harder
_FIRST, _FARTHER = 10, 2.5  # iterations of two meshes under a load within reach, and how they grow with increments
_ROUND = 24  # iterations of two meshes under a round shape on a cover
_SIZE, _POWER = 3674, 0.6  # unknowns from which on an iteration takes longer for each of them, and how
_BULGED = math.pi / 8.0  # of the thickness squared, what a wall bulges by to a half circle
_SOFTER = 8  # increments of a leg of a path with friction
_QUICK = 1000  # unknowns of a first mesh on which a refusal takes 1.5 s at most: 130 iterations of 1.2e-5 s for each


class LoadForecast(NamedTuple):
    """What a load is to take at finite strain, by counts alone."""

    unknowns: tuple[int, int]  # of its first two meshes
    increments: int  # of the load
    touching: bool  # whether free faces are to be pressed against ground or target
    seconds: float  # of processor time, by these two meshes
    most: float  # with finer ones, and contact


def forecast_touch(sensor: Sensor, load: Wrench, model: str) -> LoadForecast | None:
    """Return what a load takes of a shape that presses on a cover, whose first meshes are made; None of other touches.

    Two meshes then take some 24 iterations of a round shape, 10 of a flat one: of 13 scenes and loads 16 to 38, 10.
    """
    touch = shape_on_cover(sensor)
    if touch is None or touch.shape == "pressure" or model not in _FURTHER:
        return None
    whole = bool(load.out_of_plane)
    levels = layer_family(sensor, True) if model == "axisymmetric" else pad_family(sensor, whole=whole)[0]
    first, second = (len(levels.maker(level).free) for level in (0, 1))
    size = second * max(second / _SIZE, 1.0) ** _POWER
    seconds = min(_ONCE + (_FIRST if touch.radius is None else _ROUND) * _EACH * size, SECONDS.get())
    return LoadForecast((first, second), 1, False, seconds, min(_FURTHER[model][-1][0] * seconds, SECONDS.get()))


def forecast_load(sensor: Sensor, loads: Sequence[Wrench]) -> LoadForecast:
    """Return what the last of some loads on a path [N, N m] takes of a pad in space; nothing is meshed or solved."""
    levels, share = pad_family(sensor)
    whole = 1.0 / share if any(load.out_of_plane for load in loads) else 1.0
    first, second = (round(whole * _unknowns(levels.cells(level))) for level in (0, 1))
    length, touching = _motion_ahead(sensor, loads[-1])
    rough = sensor.elastomer is not None and sensor.elastomer.friction > 0.0
    parts = max(length / LONGEST, _SOFTER * len(loads) if rough else 1.0)
    size = second * max(second / _SIZE, 1.0) ** _POWER
    pressed = _PRESSED * size
    seconds = _ONCE + _FIRST * parts ** (1.0 if rough else _FARTHER) * _EACH * size + touching * pressed
    most = _FURTHER["block"][-1][0] * (seconds + (not touching) * pressed)
    seconds, most = (min(each, SECONDS.get()) for each in (seconds, most))
    return LoadForecast((first, second), math.ceil(parts), touching, seconds, most)


def _unknowns(cells: tuple[int, ...]) -> int:
    """Return about how many displacements cells with a node in each middle have, held at one face."""
    *across, through = cells
    return 3 * math.prod(2 * count + 1 for count in across) * 2 * through


def _motion_ahead(sensor: Sensor, load: Wrench) -> tuple[float, bool]:
    """Return the displacement of a target's edge by linear theory [thicknesses], and whether free walls are to fold."""
    plain = plain_pad(sensor)
    if plain is None:
        return 0.0, False
    target, elastomer = plain
    sink, shear, edge = strains_of(target, elastomer, load)
    half = 0.5 * min(*target.extent, *elastomer.extent) / elastomer.thickness
    reach = min(half, math.sqrt(elastomer.bulk_modulus / (12.0 * elastomer.shear_modulus)))
    near = shape_of(target, elastomer).low_corner and elastomer.contact != "never" and load.F_z > 0.0
    return math.hypot(sink + edge, shear), near and sink * reach > _BULGED


class MeshForecast(NamedTuple):
    """Relative error to expect of a load's answer, processor seconds, and notes that speak against it.

    The error is infinite where the load is not carried; `magnetics` is the error beside it, where known.
    """

    error: float
    seconds: float
    notes: tuple[Note, ...] = ()
    magnetics: float | None = None


def first_rest(layer: MechanicalModel, load: Wrench) -> Equilibrium | MeshForecast | None:
    """Return the rest under a load [N, N m] on a model's first meshes, None of a model that has none.

    Where the load is not carried, what to expect of it.
    """
    if not isinstance(layer, RefinedModel):
        return None
    try:
        return layer.rough.equilibrium(load)
    except SolveFailed as failure:
        return _not_carried(failure)


def refused_or(ahead: LoadForecast, sensor: Sensor, load: Wrench) -> MeshForecast | LoadForecast:
    """Return what to expect of a load that the first mesh of a pad refuses; the counts `ahead` of any other.

    Those of dear meshes, and of loads out of the plane or with friction, too.
    """
    from sits_mech.mechanics.block import block_pad

    quick = ahead.unknowns[0] <= _QUICK and shape_on_cover(sensor) is None
    try:
        if quick and not (load.out_of_plane or depends_on_path(sensor)):
            block_pad(sensor).check_load(load)
    except SolveFailed as failure:
        return _not_carried(failure)
    return ahead


def _not_carried(failure: SolveFailed) -> MeshForecast:
    """Return what to expect of a load that is refused."""
    note = Note.of(NoteKind.NOT_CARRIED, text=str(failure))
    return MeshForecast(math.inf, _seconds(failure.report), (note,))


def predicted(first: SolveReport, error: float, tolerance: float, count: int = 1) -> MeshForecast:
    """Return what to expect of `count` loads from the answer and error of the largest one's first two meshes."""
    each = _seconds(first) * (1.0 if count == 1 else _MEAN)
    if error <= tolerance:
        return MeshForecast(error, count * each, _known(first))
    finer, times, left = further(first, error, tolerance, count)
    seconds = (count + finer * times) * each
    beyond = Note.of(NoteKind.OUT_OF_REACH, tolerance=tolerance, reached=left)
    return MeshForecast(left, seconds, (*_known(first), *([beyond] if left > tolerance else [])))


def further(first: SolveReport, error: float, tolerance: float, count: int) -> tuple[int, float, float]:
    """Return how many of `count` loads finer meshes are for, by the answer and error of the largest one's first two.

    With it what they take over the first two, and the error that they leave.
    """
    shares: Sequence[tuple[float, float]] = _FURTHER.get(first.model, _NONE)
    if count == 1 and first.creased:
        return count, 0.0, error
    if count > 1:
        left = zip(shares, (OF_ALL, FOURTH * OF_ALL), strict=False)
        stays = float(first.creased | touches(first))
        ways = [(COMPARED, times, max(share, of_all, stays) * error) for (times, share), of_all in left]
    elif first.iterations > _WANDERED:
        ways = [(count, shares[0][0], error)]
    else:
        ways = [(count, times, share * error) for times, share in shares]
    last = ways[0 if count > 1 and tolerance >= MANY_ON_THREE else -1]
    return next((way for way in ways if way[-1] <= tolerance), last)


def _known(report: SolveReport) -> tuple[Note, ...]:
    """Return notes that speak against a load."""
    return tuple(note for note in report.notes if note.kind is NoteKind.DATA_END)


def _seconds(report: SolveReport) -> float:
    """Estimate the time of the first two meshes from size and iterations, so that a plan is reproducible."""
    return _ONCE + (_PRESSED if touches(report) else _EACH * report.iterations) * report.unknowns


def touches(report: SolveReport) -> bool:
    """Whether free faces touch something under a load."""
    return any(note.kind in _TOUCHING for note in report.notes)
