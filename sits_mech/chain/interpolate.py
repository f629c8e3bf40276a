"""Find the target's pose over a grid of loads while only as many are solved as predict the others.

Which loads are solved, and what stands between them, is decided by `maps.grid`: the map of the poses must be within the
tolerance of the range of each of their components, the target's edges included, and of the signals (goal.py). The error
of the map is added to the solver's, which is linear from load to load, as its signed parts are. A grid is solved whole
where it is small, where a load fails, or where nothing is known of its error. A model of several meshes solves more
than a few loads on the first of them; what finer ones change, and what is left of their errors, is taken from two loads
(corrections.py).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sits_mech.cases import Progress, Row
from sits_mech.chain.corrections import corrected
from sits_mech.chain.goal import Goal
from sits_mech.chain.pose_errors import levers, unloaded
from sits_mech.chain.prices.forecast import MANY_ON_THREE
from sits_mech.maps.grid import Axes, SolvedPart, interpolated, likely_part, solve_part
from sits_mech.mechanics.loads import (
    ERRORS,
    RefinedModel,
    first_key,
    settle,
    settled_again,
    shared_of,
    slopes_of,
    upright,
    with_shared,
    with_slopes,
)
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.quantities import POSE, WRENCH, Array, MechanicalModel, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.status import OK

_BETWEEN = 0.4  # of the tolerance, what the map between solved loads is given: neighbours do not share its error
_SIGNALS = 0.5  # of that, what the map is given of the signals; chosen: w15 reaches 1.00 % by default, with 1 1.04 %
_UNSEEN = 0.1  # of the largest error, what a component has at least: symmetry may hide it from all loads solved
_FEW = 3  # loads that are solved on all meshes each: one more than are compared
INTERPOLATED = "pose between solved loads, by a smooth map through them"


def poses_on_grid(
    sensor: Sensor,
    layer: MechanicalModel,
    grid: Axes,
    *,
    symmetry: Symmetry,
    tolerance: float,
    keep: tuple[Path | None, str] = (None, ""),
    progress: Progress | None = None,
    after: Callable[[Iterable[Row]], Goal | None] | None = None,
    begun: Mapping[Wrench, Row] | None = None,
) -> dict[Wrench, Row]:
    """Return a row for every load of a grid, solved or interpolated.

    `grid` holds values of components by name [N, N m], others are zero; `tolerance` is of the poses, or of the goal
    that `after` returns for solved rows and that finer meshes are taken for; `begun` holds rows solved before on the
    first meshes; other arguments as `settle`. Interpolated rows have the note `INTERPOLATED`, no state, no seconds.
    """
    rows: dict[Wrench, Row] = {}
    asked: list[Wrench] = []
    few = len(symmetry.without_images(loads_of(grid))) <= _FEW
    first = layer.rough if isinstance(layer, RefinedModel) and (after is not None or not few) else layer
    folder, key = keep
    own = (folder, key if first is layer else first_key(key))

    def poses(points: Sequence[tuple[float, ...]]) -> Array:
        """Return the poses at points of the grid; NaN where there is none, or nothing is known of its error."""
        loads = [Wrench(**dict(zip(grid, point, strict=True))) for point in points]
        asked.extend(loads)
        rows.update(settle(first, asked, symmetry=symmetry, keep=own, known=rows, progress=progress, begun=begun))
        found = [rows[load] for load in loads]
        good = [row["status"] == OK and np.isfinite(row["error_mechanics"]) for row in found]
        return np.array([[row[name] if own else np.nan for name in POSE] for row, own in zip(found, good, strict=True)])

    sizes = levers(sensor)
    aim = after(begun.values()) if after and begun else None
    weighed = None if aim is None else aim.weights / _SIGNALS
    part = solve_part(poses, grid, tolerance=_BETWEEN * tolerance, weights=sizes, goal=weighed)
    loads = loads_of(grid)
    if part is None:
        rows.update(settle(first, loads, symmetry=symmetry, keep=own, known=rows, progress=progress, begun=begun))
    if isinstance(layer, RefinedModel) and first is not layer:
        rough, goal = rows, None if after is None else after([row for row in rows.values() if row["status"] == OK])
        wanted, most = 0.0 if goal is None else goal.left(tolerance), worst(rows, goal)

        def again(load: Wrench) -> Row:
            """Return the row of a solved load on as many finer meshes as the worst load's error requires."""
            share = wanted if few or goal is None else wanted / most * worst({load: rough[load]}, goal)
            deepest = 99 if few or tolerance < MANY_ON_THREE else 3
            model = layer if goal is None else layer.towards(goal.weights, share, deepest)
            own = (folder, key if few else f"{key} {share:.3g}")
            return upright(settled_again(model, rough, load, own), load, symmetry)

        if most > wanted:
            rest = unloaded(sensor).components
            rows = _each(first, rough, again, symmetry) if few else corrected(rough, again, sizes, rest)
    if part is not None:
        error = np.maximum(part.error, _UNSEEN * np.max(part.error * sizes) / sizes)
        rows.update(_between(replace(part, error=error), rows, symmetry))
        if progress is not None:
            progress(len(loads), len(loads))
    return {load: rows[load] for load in loads}


def _each(
    layer: MechanicalModel, rows: Mapping[Wrench, Row], again: Callable[[Wrench], Row], symmetry: Symmetry
) -> dict[Wrench, Row]:
    """Return the rows of loads, solved ones again on finer meshes, and their images from these.

    Derivatives of poses stay those of the first meshes.
    """
    own = {load: row for load, row in rows.items() if symmetry.standard(load)[0] == load}
    finer = {load: with_slopes(again(load), slopes_of(row)) for load, row in own.items() if row["status"] == OK}
    known = own | {load: row for load, row in finer.items() if row["status"] == OK}
    return settle(layer, rows, symmetry=symmetry, known=known)


def worst(rows: Mapping[Wrench, Row], goal: Goal | None) -> float:
    """Return the largest error of any load at rest, over the goal's full scale; infinite without a goal."""
    if goal is None:
        return np.inf
    good = [row for row in rows.values() if row["status"] == OK]
    return max((goal.mechanics(np.array([row[name] for name in ERRORS]), shared_of(row)) for row in good), default=0.0)


def loads_of(grid: Axes) -> list[Wrench]:
    """Return the loads of a grid, the last component running fastest; missing components are zero."""
    return [Wrench(**dict(zip(grid, load, strict=True))) for load in itertools.product(*grid.values())]


def solved_likely(loads: Sequence[Wrench]) -> list[Wrench]:
    """Return about which loads are solved: of a grid the part that usually suffices."""
    axes = {name: sorted({float(getattr(load, name)) for load in loads}) for name in WRENCH}
    if np.prod([len(values) for values in axes.values()]) != len(set(loads)):
        return list(loads)
    return [Wrench(**dict(zip(axes, point, strict=True))) for point in likely_part(axes)]


def _between(part: SolvedPart, rows: Mapping[Wrench, Row], symmetry: Symmetry) -> dict[Wrench, Row]:
    """Return the rows of a grid's loads between the solved ones."""
    loads = loads_of(part.axes)

    solved = [row for row in rows.values() if row["status"] == OK]
    count, slopes = (min(len(of(row)) for row in solved) for of in (shared_of, slopes_of))

    def on_grid(names: Sequence[str], **degree: int) -> Array:
        """Interpolate numbers of the solved loads and the shared parts to the whole grid; missing ones are 1."""
        own = np.ones((len(loads), len(names) + (count + slopes) * len(POSE)))
        for k, load in enumerate(loads):
            if load in rows:
                beside = (shared_of(rows[load])[:count], slopes_of(rows[load])[:slopes])
                own[k] = [*(rows[load].get(name, np.nan) for name in names), *np.concatenate(beside).ravel()]
        known = np.nan_to_num(own, nan=1.0).reshape(*part.values.shape[:-1], -1)
        return interpolated(part, known, **degree).reshape(len(loads), -1)

    worst = max(row["error_mechanics"] for row in solved)
    own = np.array([[row[name] for name in ERRORS] for row in solved])
    places, straight = on_grid((*POSE, "min_J")), on_grid((*ERRORS, "stretch"), degree=1)
    if not all(np.isfinite(row.get("stretch", np.nan)) for row in solved):
        straight[:, len(POSE)] = np.nan  # not known of one, it is of none between
    sizes = np.clip(straight[:, : len(POSE)], own.min(axis=0), own.max(axis=0)) + part.error
    plane = np.arange(len(POSE)) < 3
    sizes = np.where(plane | np.array([load.beside != () for load in loads])[:, None], sizes, 0.0)
    more: dict[Wrench, Row] = {}
    end = len(POSE) * (1 + count)
    for load, place, size, shared in zip(loads, places, sizes, straight[:, len(POSE) : 1 + end], strict=True):
        if load not in rows:
            row = with_shared({"status": OK, "reason": "", "lasting": True}, shared[1:])
            row = with_slopes(row, place[1 + end :].reshape(-1, len(POSE)))
            row |= dict(zip((*POSE, "min_J", *ERRORS), (*place[: 1 + len(POSE)].tolist(), *size.tolist()), strict=True))
            row |= {"stretch": float(shared[0]), "error_mechanics": worst, "iterations": 0}
            row |= {"notes": INTERPOLATED, "seconds": 0.0}
            more[load] = upright(row, load, symmetry)
    return more
