"""Bound designs before one is solved: by their sizes, which are exact, and by the strain of linear theory.

Looked at are the middle of a choice's box, its corners and points between. Where each of them exceeds a size, or is
surely strained beyond the silicone's data under the overload (solved/overload.py), the choice is left out. Designs are
counted by

    N = choices + v + 1,      3 where the first design within the limits will do,

of v numbers between bounds, the last one solved finer where something is minimised; of the three, which were one to
four, the seconds are of two. Each takes the loads of its table that are no images of others, each by its own increments
(chain/plans/prices.py), a load more for the overload, and a factor more on each mesh of a load for derivatives; a finer
one the overload on all meshes and two loads on a third. Plates are prepared once for all designs that only the pad
tells apart, with half of it again for derivatives. For the first design that will do the loads are those of the choice
that linear theory strains least.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.stats import norm, qmc

from sits_mech.chain.interpolate import loads_of
from sits_mech.chain.plans.plan import table_seconds
from sits_mech.quantities import WRENCH, Array
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.synthesis.required.kinds import STRAIN, figure_words
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.space import Design, size_of
from sits_mech.synthesis.solved.answered import Answered, over
from sits_mech.synthesis.solved.solve import COARSE, FINE, Solver

_BETWEEN, _CORNERS = 16, 4  # points of a box that are looked at; the most variables whose corners are
_LIKELY = 1.2  # strain by linear theory that a start may have: there finer meshes have 0.6 to 0.9 (a fingertip, skins)
_WITHIN = 0.9  # of the data, where a start after a failed one is expected to be
_BEGUN = 4.0  # seconds of what a process imports and prepares once
_ALL_MESHES = 8.0  # times a load's seconds, those of the overload on finer meshes (chain/plans/prices.py)
_COMPARED = 2 * 1.7  # times that: two loads of a finer table on a third mesh, that takes 1.7 of two (prices.py)
_FACTORS, _AGAIN = 1.25, 1.5  # with derivatives: seconds of a load, with two factors of some eight more; of magnetics
_NOT_OF_PLATES = ("elastomer", "readout")  # parts of a scene that leave plates as they are prepared


@dataclass(frozen=True)
class Bound:
    """A point and what is known of it beforehand."""

    design: Design
    sizes: dict[str, float]
    strain: float  # by linear theory, over what is known of the silicone; zero where no theory holds
    end: float  # strain by linear theory from which on the silicone is surely beyond its data
    guard: dict[str, float]  # of sizes, what the tolerances are to leave

    def excess(self, limits: dict[str, float], likely: float) -> float:
        """Return by how much sizes and strain exceed their limits at most, over these."""
        held = {name: size + self.guard.get(name, 0.0) for name, size in self.sizes.items()}
        found = [over(name, size, limits[name]) for name, size in held.items() if name in limits]
        return max([*found, self.strain - likely])


def bounds_of(solver: Solver, choice: tuple[int, ...]) -> tuple[Requirements, list[Bound]]:
    """Return requirements, and what is known beforehand of possible points of a choice, the middle first."""
    space = solver.requirements.space
    v, found = len(space.variables), list[Bound]()
    points = [np.full(v, 0.5)]
    if v:
        points += [np.array(ends) for ends in product((0.0, 1.0), repeat=v)] if v <= _CORNERS else []
        points += list(qmc.Sobol(v, rng=np.random.default_rng(0)).random(_BETWEEN))
    designs = [Design(choice, tuple(x.tolist())) for x in points]
    for design in (designs[0], *(space.rounded(each)[0] for each in designs[1:])):
        try:
            sensor = space.sensor(design)
        except SceneError:
            continue
        guard = found[0].guard if found else _guard(solver, sensor)
        strain, end = np.nan_to_num(solver.expected(sensor), posinf=0.0).tolist()
        found.append(Bound(design, size_of(sensor), strain, end, guard))
    return solver.requirements, found


def _guard(solver: Solver, sensor: Sensor) -> dict[str, float]:
    """Return how far sizes are to stay from their limits, so that the asked share of the sensors made hold them."""
    here, share = size_of(sensor), float(norm.ppf(solver.requirements.least_yield))
    moved = [size_of(each) for each in solver.scattered(sensor)]
    return {name: share * float(np.linalg.norm([own[name] - size for own in moved])) for name, size in here.items()}


def begin_at(known: tuple[Requirements, Sequence[Bound]]) -> Array | Answered:
    """Return the point nearest to the middle that may hold, or that exceeds least; or why none holds."""
    asked, bounds = known
    refusal = _left_out(asked, bounds) if bounds else None
    return _nearest(asked, bounds, _LIKELY) if refusal is None else refusal


def begin_again(known: tuple[Requirements, Sequence[Bound]], failed: Answered) -> Array:
    """Return `begin_at` with strains over those of linear theory as a failed design has them; or the least strained."""
    asked, bounds = known
    own = next((each.strain for each in bounds if each.design == failed.design), 0.0)
    found = _nearest(asked, bounds, _WITHIN * own / failed.plain.get(STRAIN, np.inf))
    return strained_least(known) if np.array_equal(found, failed.point) else found


def _nearest(asked: Requirements, bounds: Sequence[Bound], likely: float) -> Array:
    """Return the point nearest to the middle that holds sizes and a strain by linear theory, or exceeds least."""

    def order(each: Bound) -> tuple[float, float]:
        """Those that may hold first, the nearest first."""
        return max(each.excess(asked.limits, likely), 0.0), float(np.abs(np.array(each.design.x) - 0.5).sum())

    return np.array(min(bounds, key=order).design.x) if bounds else np.full(len(asked.space.variables), 0.5)


def strained_least(known: tuple[Requirements, Sequence[Bound]]) -> Array:
    """Return the point of least strain by linear theory, the edge of the box a little away; or the middle."""
    asked, bounds = known
    if not bounds:
        return np.full(len(asked.space.variables), 0.5)
    return np.clip(min(bounds, key=lambda each: each.strain).design.x, 0.05, 0.95)


def _left_out(asked: Requirements, bounds: Sequence[Bound]) -> Answered | None:
    """Return why no point of a choice can hold; None where one may."""
    least = min(bounds, key=lambda each: each.strain)
    words = ""
    if all(each.strain > each.end for each in bounds):
        words = f"left out: strained to {least.strain:.2g} times the silicone's data at least, by linear theory"
    for name in least.sizes:
        size = min(each.sizes[name] for each in bounds)
        if name in asked.limits and over(name, size, asked.limits[name]) > 0.0:
            words = f"left out: {name} {figure_words(name, size)} at least against "
            words += figure_words(name, asked.limits[name])
    if not words:
        return None
    v = len(least.design.x)
    return Answered(least.design, words, None, np.zeros((v, 0, 0)), least.sizes | {STRAIN: least.strain}, {})


def expected_designs(asked: Requirements, choices: int | None = None) -> int:
    """Return how many designs a search solves, of all choices or of so many that may hold."""
    count = len(asked.space.choices) if choices is None else choices
    return count + len(asked.space.variables) + 1 if asked.minimised else 3


@dataclass(frozen=True)
class DesignPlan:
    """What a search is to solve; figures that no design goes below, sizes and strain, of all choices that may hold."""

    designs: int
    seconds: float  # of the processor, within a factor of some two
    first_seconds: float  # to the end of the first design: all where it shows that none can hold the limits
    least: dict[str, float]  # [SI]
    not_solved: dict[str, str]  # why, by choice in words


def plan_of(asked: Requirements) -> DesignPlan:
    """Return what a search is to solve; nothing is meshed or solved.

    Raises SceneError where no choice may hold, with the one that comes nearest.
    """
    solver = Solver(asked, COARSE)
    bounds = {choice: bounds_of(solver, choice)[1] for choice in asked.space.choices}
    starts = {choice: begin_at((asked, each)) for choice, each in bounds.items()}
    left = [each for each in starts.values() if isinstance(each, Answered)]
    good = {choice: bounds[choice] for choice, each in starts.items() if not isinstance(each, Answered)}
    if not good:
        raise refused(asked, left)
    count = expected_designs(asked, len(good))
    points = sorted((own[0] for own in good.values() if own), key=lambda each: each.strain)
    points = points[: None if asked.minimised else 1]
    solved = count if asked.minimised else 2
    (each, coils), (finer, _) = (
        np.mean([_seconds(one, point.design) for point in points], axis=0) for one in (solver, Solver(asked, FINE))
    )
    keys = (*asked.space.names, *asked.space.lists)
    plates = solved if any(key.partition(".")[0] not in _NOT_OF_PLATES for key in keys) else 1
    seconds = _BEGUN + (solved - 1) * each + (finer if asked.minimised else each) + plates * coils
    rows = [each.sizes | {STRAIN: each.strain} for own in good.values() for each in own]
    least = {name: min(row[name] for row in rows) for name in (rows or [{}])[0]}
    words = {asked.space.words(each.design): each.reason for each in left}
    return DesignPlan(count, float(seconds), float(_BEGUN + each + coils), least, words)


def refused(asked: Requirements, known: Sequence[Answered]) -> SceneError:
    """Return the refusal of requirements that no design answers: the nearest one, and how much of the loads it may."""
    nearest = min(known, key=lambda each: each.plain.get(STRAIN, np.inf))
    strain = nearest.plain.get(STRAIN, np.nan)
    most = f"; it carries some {100.0 / strain:.2g} % of the loads" if strain > 1.0 else ""
    return SceneError(
        f"loads: no design within the bounds answers them; {asked.space.words(nearest.design)}: {nearest.reason}{most}"
    )


def _seconds(solver: Solver, design: Design) -> tuple[float, float]:
    """Return the processor seconds that a design takes of the mechanics, and of the coils with their plates."""
    sensor, axes = solver.requirements.space.sensor(design), solver.solved
    if not solver.needs_table:
        axes = axes._replace(axes=tuple(axis[-1:] for axis in axes.axes))
    grid = dict(zip(axes.names, axes.axes, strict=True))
    loads = loads_of({name: [*grid.get(name, [0.0])] for name in WRENCH})
    each, *coils = table_seconds(sensor, loads, solver.tolerance)
    finely = solver.tolerance < COARSE
    overload = max(each) * (_ALL_MESHES if finely else 1.0)
    if not solver.needs_table:
        return overload, 0.0
    return overload + _FACTORS * sum(each) + finely * _COMPARED * max(each), _AGAIN * sum(coils)
