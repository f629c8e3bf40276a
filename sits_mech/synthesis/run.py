"""Design a sensor from requirements: search, round, solve anew, answer.

The search solves coarsely (`COARSE`); its best design is moved to round numbers, of which those that promise most are
solved at the finer tolerance. So are the best designs of other choices, as far as the errors leave open that they are
better, those that may be best first, `_FINALS` in all. One whose figures are nearer to their limits than their errors
is solved once more, finer still, before it is judged. What then stays open is reported: limits as undecided, designs as
tied. Everything that was solved is kept, so that a run that was stopped goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.mechanics.models import strain_bound
from sits_mech.quantities import Array, Wrench
from sits_mech.scene.sensor import SceneError
from sits_mech.synthesis.answer import (
    DesignAnswer,
    figures_of,
    firsts,
    front_of,
    held_shares,
    lost_values,
    made_share,
    rounded,
    said_of,
    tied_with,
)
from sits_mech.synthesis.answered import Answered
from sits_mech.synthesis.around import landscape_of, prices, sensitivities
from sits_mech.synthesis.requirements import Requirements, read_requirements, requirements_of
from sits_mech.synthesis.search import MOST, Search
from sits_mech.synthesis.solve import Solver
from sits_mech.synthesis.space import Design

COARSE, FINE, FINEST = 5e-2, 1e-2, 3e-3
"""Tolerances of the chain: of the search, of the recommended design, and where that is not enough."""
_TRIES = 3  # round designs of a choice that are solved
_FINALS = 3  # choices whose best designs are solved finer

Told = Callable[[int, int, str], None]
"""Called with the number of designs solved, the most there will be, and the last one and its figures in words."""


def design(
    requirements: Requirements | Mapping[str, Any] | str | Path, *, folder: Path | None = None, most: int = MOST,
    seed: int = 0, told: Told | None = None, executor: Executor | None = None,
) -> DesignAnswer:
    """Return the best sensor for some requirements.

    Parameters
    ----------
    requirements : Requirements, mapping, or path
        As of `requirements.py`: its tables, or a TOML file of them.
    folder : Path, optional
        Where solved designs are kept, and looked for first.
    most : int
        Designs that the search solves at most.
    seed : int
        Of its starts.
    told : callable, optional
        For progress.
    executor : Executor, optional
        Where the first designs of all choices are solved side by side; in this process by default. No answer depends on
        it.

    Raises
    ------
    SceneError
        For requirements that are none, or loads that no design within the bounds carries.

    Examples
    --------
    >>> asked = {
    ...     "scene": "biorob2018",
    ...     "loads": {"F_z": ["0 N", "0.2 N"]},
    ...     "vary": {"elastomer.thickness": ["2 mm", "7 mm"]},
    ...     "require": {"height": "4 mm"},
    ...     "goal": {"minimise": "feasible"},
    ... }
    >>> found = sm.design(asked)
    >>> found.feasible
    True
    """
    check_most(most)
    asked = _asked(requirements)
    run = _Run(asked, folder, most, told)
    if executor is not None:
        first = [Design(choice, tuple(run.middle.tolist())) for choice in asked.space.choices[:most]]
        run.ahead = {each: executor.submit(run.coarse, each) for each in first}
    search = Search(run.coarse.task, asked.space.choices, len(asked.space.variables), run.solve, run.start, most, seed)
    known = search.run()
    good = [each for each in known if each.carried]
    if not good:
        least = min(known, key=lambda each: min(each.plain.values(), default=np.inf))
        words = f"{asked.space.words(least.design)}: {least.reason}"
        raise SceneError(f"loads: no design within the bounds answers them; {words}")
    finals = run.finals(search, known)
    best, task, space = finals[0], search.task, asked.space
    branch = next(each for each in search.branches if each.choice == best.design.choice)
    share = made_share(task, best)
    open_ = [name for name in task.undecided(best) if name != "yield"]
    open_ += ["yield"] if share.low < asked.least_yield <= share.high else []
    feasible = search.merit(best) <= task.aim(task.own_figures(best)) and not share[0] < asked.least_yield
    judged = {each.design.choice for each in finals}
    others = [each for each in firsts(known, search.at_best) if each.design.choice not in judged]
    return DesignAnswer(
        task, feasible, tuple(open_), best, space.values(best.design), figures_of(task, best), share,
        held_shares(task, best), prices(search, branch, best),
        *sensitivities(task, branch.prediction, best.point, space.variables),
        front_of(task, [*finals, *known]), tuple(known), lost_values(asked, search, known, finals),
        tied_with(search, [*finals, *others], best, space.words), run.count,
        landscape_of(asked, search, branch.prediction, best), run.notes(best),
    )


def check_most(most: int) -> None:
    """Refuse a search of no designs."""
    if most < 1:
        raise SceneError(f"most: must be one or more designs; got {most}")


def _asked(requirements: Requirements | Mapping[str, Any] | str | Path) -> Requirements:
    """Return requirements, read where they are a file's."""
    if isinstance(requirements, Requirements):
        return requirements
    if isinstance(requirements, Mapping):
        return requirements_of(requirements)
    return read_requirements(Path(requirements))


@dataclass
class _Run:
    """A run: its solvers and its state."""

    asked: Requirements
    folder: Path | None
    most: int
    told: Told | None
    count: int = 0
    ahead: dict[Design, Future[Answered]] = field(default_factory=dict)

    @property
    def middle(self) -> Array:
        """The point where every choice begins."""
        return np.full(len(self.asked.space.variables), 0.5)

    @cached_property
    def coarse(self) -> Solver:
        """The solver of the search."""
        return Solver(self.asked, COARSE, self.folder)

    def solve(self, wanted: Design, tolerance: float = COARSE) -> Answered:
        """Solve a design, and report progress."""
        begun = self.ahead.pop(wanted, None) if tolerance == COARSE else None
        found = replace(self.coarse, tolerance=tolerance)(wanted) if begun is None else begun.result()
        self.count += 1
        if self.told is not None:
            words = f"{self.asked.space.words(wanted)}: {said_of(self.coarse.task, found)}"
            self.told(self.count, self.most + (_TRIES + 1) * _FINALS, words)
        return found

    def start(self, choice: tuple[int, ...], attempt: int) -> Array | None:
        """Return where a choice begins: the middle, then the corner of least strain by linear theory."""
        middle = self.middle
        if attempt == 0:
            return middle
        if attempt > 1 or not len(middle):
            return None
        ends = {name: self.asked.overload * max(pair, key=abs) for name, pair in self.asked.loads.items()}
        corners = [middle, *(middle + side * 0.45 * row for row in np.eye(len(middle)) for side in (1.0, -1.0))]
        bounds = []
        for x in corners:
            try:
                sensor = self.asked.space.sensor(Design(choice, tuple(x.tolist())))
            except SceneError:
                bounds.append(np.inf)
            else:
                bounds.append(strain_bound(sensor, [Wrench(**ends)]))
        slope = [np.sign(bounds[2 + 2 * k] - bounds[1 + 2 * k]) for k in range(len(middle))]
        return np.asarray(np.clip(middle + 0.45 * np.nan_to_num(np.array(slope)), 0.0, 1.0))

    def finals(self, search: Search, known: Sequence[Answered]) -> list[Answered]:
        """Return the best designs of the choices that may win, rounded and solved finer, the best one first."""
        first = min(known, key=search.merit)
        found, sharpest = [self.refined(search, first)], set[Design]()
        for other in firsts(known, search.at_best):
            new = other.design.choice != first.design.choice and len(found) < _FINALS
            if new and search.may_beat(other, min(found, key=search.merit)):
                found.append(self.refined(search, other))
        while True:
            found.sort(key=search.merit)
            open_ = [
                each for each in found if each.design not in sharpest and search.task.undecided(each)
                and (each is found[0] or search.may_beat(each, found[0]))
            ]
            if not open_:
                return found
            sharpest.add(open_[0].design)
            finer = self.solve(open_[0].design, FINEST)
            found[found.index(open_[0])] = finer if finer.carried else open_[0]

    def refined(self, search: Search, best: Answered) -> Answered:
        """Return the best design of a choice, rounded and solved finer; itself where no rounded one is carried."""
        branch = next(each for each in search.branches if each.choice == best.design.choice)
        tries = sorted(
            rounded(self.asked, best.design),
            key=lambda each: search.predicted(branch.prediction, np.array(each.x, dtype=float)),
        )
        found = []
        for wanted in tries[:_TRIES]:
            new = self.solve(wanted, FINE)
            if search.task.holds(new) and not made_share(search.task, new).value < self.asked.least_yield:
                return new
            found.append(new)
        chosen = min(found, key=search.merit)
        return chosen if chosen.carried else best

    def notes(self, best: Answered) -> tuple[str, ...]:
        """Return notes on the answer for a designer."""
        layer, found = self.asked.space.sensor(best.design).elastomer, list[str]()
        silicone = None if layer is None else layer.silicone
        if silicone is not None and silicone.spread:
            found.append(
                f"the sources of {silicone.name or 'the silicone'} differ by {1.0 + silicone.spread:.3g} in stress: "
                "forces may be off by as much; measure the own silicone"
            )
        if silicone is not None and silicone.mode_spread:
            known = f"by its tests loads of the silicone are known within {100.0 * silicone.mode_spread:.2g} % only"
            found.append(f"{known}; a test of another mode narrows it")
        return tuple(found)
