"""Solve some loads of a grid, and interpolate the poses of the others.

Which loads are solved, and what stands between them, is decided by `maps.grid`: the map of the poses must be within the
tolerance of the range of each of their components, the target's edges included, and of the signals (plans/goal.py). The
error of the map is added to the solver's, which is linear from load to load, as its signed parts are. A grid is solved
whole where it is small, where a load fails, or where nothing is known of its error. A model of several meshes solves
more than a few loads on the first of them; what finer ones change, and what is left of their errors, is taken from one
or two loads (corrections.py).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.cases import Progress, no_progress
from sits_mech.chain.corrections import comparable, corrected_loads, mild_load
from sits_mech.chain.plans.goal import Goal
from sits_mech.chain.plans.prices import COMPARED, FOURTH, MANY_ON_THREE
from sits_mech.chain.propagation import levers, poses_of, unloaded_pose
from sits_mech.maps.grid import Axes, SolvedPart, interpolated, likely_part, solve_part
from sits_mech.mechanics.loads import RefinedModel, Settled, allowed_by_symmetry, first_key, settle, settled_again
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import (
    POSE,
    TOUCH,
    WRENCH,
    Array,
    Equilibrium,
    MechanicalModel,
    Pose,
    SolveReport,
    Wrench,
    load_at,
)
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.units import shown

BETWEEN = 0.4
"""Of the tolerance, what the map between solved loads is given: neighbours do not share its error."""
_SIGNALS = 0.5  # of that, what the map is given of the signals; chosen: w15 reaches 1.00 % by default, with 1 1.04 %
_UNSEEN = 0.1  # of the largest error, what a component has at least: symmetry may hide it from all loads solved
_SAME = 1e-9  # of the largest value of a component: what is closer is twice the same


@dataclass(frozen=True)
class LayerGrid:
    """Loads of a grid on a layer."""

    sensor: Sensor
    layer: MechanicalModel
    axes: Axes  # values of components, and of a touch's place, by name [N, N m, m]; others are zero
    symmetry: Symmetry
    tolerance: float
    keep: tuple[Path | None, str] = (None, "")  # as of `settle`
    progress: Progress = no_progress
    listed: tuple[Wrench, ...] = ()  # loads in place of a grid's, each of which is solved

    @cached_property
    def loads(self) -> list[Wrench]:
        """The loads, of a grid the last component running fastest."""
        return list(self.listed) or loads_of(self.axes, self.place)

    @property
    def place(self) -> tuple[float, float]:
        """The touched point that loads are taken about [m]."""
        return self.sensor.touched_point

    @cached_property
    def few(self) -> bool:
        """Whether so few are solved that each of them is on all meshes."""
        return len(self.symmetry.without_images(self.loads)) <= COMPARED + 1


def poses_on_grid(
    grid: LayerGrid, *, after: Callable[[Iterable[Settled]], Goal | None] | None = None,
    begun: Mapping[Wrench, Settled] | None = None,
) -> dict[Wrench, Settled]:
    """Return what comes of every load of a grid, solved or interpolated.

    The tolerance is of the poses, or of the goal that `after` returns for solved loads and that finer meshes are taken
    for; `begun` holds loads solved before on the first meshes. Interpolated rests have a note of that kind, no
    state, no seconds.
    """
    goal_of = (lambda _: None) if after is None else after
    layer, (folder, key) = grid.layer, grid.keep
    refined = layer if isinstance(layer, RefinedModel) and (after is not None or not grid.few) else None
    first = layer if refined is None else refined.rough
    own = (folder, key if first is layer else first_key(key))
    solved = partial(settle, first, symmetry=grid.symmetry, keep=own, progress=grid.progress, begun=begun)
    found, asked = dict[Wrench, Settled](), list[Wrench]()

    def poses(points: Sequence[tuple[float, ...]]) -> Array:
        """Return the poses at points of the grid; NaN where there is none, or nothing is known of its error."""
        loads = [load_at(dict(zip(grid.axes, point, strict=True)), grid.place) for point in points]
        asked.extend(loads)
        found.update(solved(asked, known=found))
        rests, unknown = [found[load].rest for load in loads], np.full(len(POSE), np.nan)
        return np.array([
            rest.pose.components if rest and np.isfinite(rest.report.estimated_error) else unknown for rest in rests
        ])

    sizes, aim = levers(grid.sensor), goal_of(begun.values()) if begun else None
    weighed = None if aim is None else aim.weights / _SIGNALS
    part = None
    if not grid.listed:
        asked_of_map = partial(_tolerance, BETWEEN * grid.tolerance, found, aim)
        part = solve_part(poses, grid.axes, tolerance=asked_of_map, weights=sizes, goal=weighed)
    whole = found if part is not None else solved(grid.loads, known=found)
    drawn = whole if part is None else _between(part, whole, grid, sizes)
    if refined is not None:
        finer = _finer(grid, refined, whole, drawn, goal_of(whole.values()))
        drawn = finer if part is None or finer is drawn else _between(part, finer, grid, sizes)
    if part is not None:
        grid.progress(len(grid.loads), len(grid.loads))
    return {load: drawn[load] for load in grid.loads}


def _tolerance(asked: float, settled: Mapping[Wrench, Settled], goal: Goal | None) -> float:
    """Return the tolerance of a map, at least the largest error of loads not to be compared: poses jump by as much."""
    left = [one for one in settled.values() if one.rest and one.rest.state.size and not comparable(one.rest)]
    return asked if goal is None else max(asked, worst(left, goal))


def _finer(
    grid: LayerGrid, layer: RefinedModel, rough: dict[Wrench, Settled], drawn: dict[Wrench, Settled], goal: Goal | None
) -> dict[Wrench, Settled]:
    """Return what comes of loads with what finer meshes change; all `drawn` where the first are good enough."""
    wanted, most = 0.0 if goal is None else goal.left(grid.tolerance), worst(drawn.values(), goal)
    if most <= wanted:
        return drawn

    def again(load: Wrench, deepest: int = 99) -> Settled:
        """Solve a load again on as many finer meshes as the worst load's error requires."""
        share = wanted if grid.few or goal is None else wanted / most * worst([rough[load]], goal)
        model = grid.layer if goal is None else layer.towards(goal.weights, share, deepest)
        own = (grid.keep[0], grid.keep[1] if grid.few else f"{grid.keep[1]} {share:.3g} {deepest}")
        return allowed_by_symmetry(settled_again(model, rough, load, own), grid.symmetry, load)

    if grid.few:  # derivatives of poses stay those of the first meshes
        known = {load: one for load, one in rough.items() if grid.symmetry.standard(load)[0] == load}
        for load, one in known.items():
            if one.rest and (finer := again(load)).rest:
                known[load] = replace(finer, rest=replace(finer.rest, slopes=one.rest.slopes))
        return settle(layer.rough, rough, symmetry=grid.symmetry, known=known)
    way = levers(grid.sensor), unloaded_pose(grid.sensor).components
    if (mild := mild_load(rough, *way)) is not None:
        rough = settle(layer.rough, [mild], symmetry=grid.symmetry, known=rough)
    found = rough
    for deepest in (99,) if grid.tolerance < MANY_ON_THREE else (3, 4):
        found = corrected_loads(rough, partial(again, deepest=deepest), *way, mild)
        if not wanted < worst(found.values(), goal) <= wanted / FOURTH:
            break
    return found


def worst(settled: Iterable[Settled], goal: Goal | None) -> float:
    """Return the largest error of any load at rest, over the goal's full scale; infinite without a goal."""
    if goal is None:
        return np.inf
    return max((goal.mechanics(poses_of([one.rest])) for one in settled if one.rest), default=0.0)


def checked_values(name: str, values: float | Sequence[float]) -> list[float]:
    """Return the values of a component in ascending order; raise SceneError for bad ones."""
    try:
        given = np.sort(np.atleast_1d(np.asarray(values, dtype=float)))
    except (TypeError, ValueError):
        given = np.full(1, np.nan)
    largest = np.max(np.abs(given), initial=0.0)
    if given.ndim > 1 or not given.size or not np.all(np.isfinite(given)) or np.any(np.diff(given) <= _SAME * largest):
        what = {"M": "moments [N m]", "t": "places [m]"}.get(name[0], "forces [N]")
        raise SceneError(f"{name} must be one or more different finite {what}; got {shown(values)}")
    rounded = (given != -given[::-1]) & (np.abs(given + given[::-1]) <= _SAME * largest)  # two images are one solve
    return [float(f"{value:.14g}") if own else float(value) for value, own in zip(given, rounded, strict=True)]


def loads_of(grid: Axes, place: Sequence[float] = (0.0, 0.0)) -> list[Wrench]:
    """Return the loads of a grid about a touched point, the last component running fastest; missing ones are zero."""
    return [load_at(dict(zip(grid, load, strict=True)), place) for load in itertools.product(*grid.values())]


def solved_likely(
    loads: Sequence[Wrench], axes: Axes | None = None, place: Sequence[float] = (0.0, 0.0)
) -> list[Wrench]:
    """Return about which loads are solved: of a grid, known by its `axes` or found, the part that usually suffices."""
    if axes is not None and set(axes) & set(TOUCH):
        return list(dict.fromkeys(load_at(dict(zip(axes, point, strict=True)), place) for point in likely_part(axes)))
    axes = {name: sorted({float(getattr(load, name)) for load in loads}) for name in WRENCH}
    if np.prod([len(values) for values in axes.values()]) != len(set(loads)):
        return list(loads)
    return [Wrench(**dict(zip(axes, point, strict=True))) for point in likely_part(axes)]


def _between(part: SolvedPart, settled: dict[Wrench, Settled], grid: LayerGrid, levers: Array) -> dict[Wrench, Settled]:
    """Return what comes of a grid's loads, those between solved ones interpolated."""
    loads, missed = grid.loads, part.error_at.reshape(-1, len(POSE))
    missed = np.maximum(missed, _UNSEEN * np.max(missed * levers, axis=1, keepdims=True) / levers)
    solved = [one.rest for one in settled.values() if one.rest]
    count, slopes = min(len(rest.shared) for rest in solved), min(len(rest.slopes) for rest in solved)

    def on_grid(numbers: Callable[[Equilibrium], Sequence[Any]], **degree: int) -> Array:
        """Interpolate numbers of the solved loads to the whole grid, shape (load, n); missing ones are 1."""
        known = np.ones((len(loads), len(numbers(solved[0]))))
        for k, load in enumerate(loads):
            rest = settled[load].rest if load in settled else None
            if rest is not None:
                known[k] = np.nan_to_num(np.asarray(numbers(rest), dtype=float), nan=1.0)
        return interpolated(part, known.reshape(*part.values.shape[:-1], -1), **degree).reshape(len(loads), -1)

    end, own = len(POSE), np.array([rest.error.components for rest in solved])
    places = on_grid(lambda r: [*r.pose.components, r.report.min_J, *r.slopes[:slopes].ravel()])
    straight = on_grid(lambda r: [*r.error.components, r.report.stretch, *r.shared[:count].ravel()], degree=1)
    for name, numbers in (("min_J", places), ("stretch", straight)):
        if not np.all(np.isfinite(np.array([getattr(rest.report, name) for rest in solved], dtype=float))):
            numbers[:, end] = np.nan  # not known of one, it is of none between
    sizes = np.clip(straight[:, :end], own.min(axis=0), own.max(axis=0)) + missed
    plane = np.arange(end) < 3
    sizes = np.where(plane | np.array([load.out_of_plane != () for load in loads])[:, None], sizes, 0.0)
    most = max(rest.report.estimated_error for rest in solved)
    bent = [note for rest in solved for note in rest.report.notes if note.kind is NoteKind.BENT]
    notes = (Note(NoteKind.INTERPOLATED), *sorted(bent, key=lambda note: note.known["deflection"])[-1:])
    report = SolveReport("interpolated", 0, 0, 0.0, most, 0.0, notes=notes)
    return settled | {
        load: allowed_by_symmetry(Settled(Equilibrium(
            load, Pose.of(place[:end]), Pose.of(size), np.zeros(0),
            replace(report, min_J=float(place[end]), stretch=float(line[end])),
            line[end + 1 :].reshape(-1, end), slopes=place[end + 1 :].reshape(-1, end),
        )), grid.symmetry, load)
        for load, place, size, line in zip(loads, places, sizes, straight, strict=True) if load not in settled
    }
