"""Design a sensor from requirements: bounds, search, round, solve anew, answer.

Choices that linear theory or sizes rule out cost nothing. The search solves coarsely (`COARSE`); of the designs of its
best choice that are as good as its best one, within what they are known, the thinnest is moved to round numbers, of
which those that promise most are solved at the finer tolerance (`FINE`). So are the best designs of other choices, as
far as the errors leave open that they are better, `_FINALS` in all. A solved design that holds every limit comes before
one that does not. What stays open is reported: limits as undecided, designs as tied. Everything that was solved is
kept, so that a run that was stopped goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError, silicones_of, untested_notes
from sits_mech.synthesis.answer import (
    DesignAnswer,
    causes,
    figures_of,
    firsts,
    front_of,
    guards,
    held_shares,
    lost_values,
    made_share,
    tied_with,
    words_of,
)
from sits_mech.synthesis.around import Preview, landscape_of, preview_of, prices, sensitivities
from sits_mech.synthesis.bounds import begin_again, begin_at, bounds_of, expected_designs, refused
from sits_mech.synthesis.required.requirements import Requirements, read_requirements, requirements_of
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.search import MOST, Branch, Search
from sits_mech.synthesis.solved.answered import Answered, Task
from sits_mech.synthesis.solved.solve import COARSE, FINE, Solver

_TRIES = 2  # round designs of a choice that are solved
_FIRST = 3  # designs of a preview
_FINALS = 3  # choices whose best designs are solved finer

Report = Callable[[int, int, str], None]
"""Called with the number of designs solved, the most there will be, and the last one and its figures in words."""


@checked_arguments
def design(
    requirements: Requirements | Mapping[str, Any] | str | Path, *, folder: Path | None = None, most: int = MOST,
    seed: int = 0, report: Report | None = None, executor: Executor | None = None,
) -> DesignAnswer:
    """Return the best sensor for some requirements.

    Parameters
    ----------
    requirements : Requirements, mapping, or path
        As of `required/requirements.py`: its tables, or a TOML file of them.
    folder : Path, optional
        Where solved designs are kept, and looked for first.
    most : int
        Designs that the search solves at most.
    seed : int
        Of its starts.
    report : callable, optional
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
    >>> result = sm.design(asked)
    >>> result.feasible
    True
    """
    check_most(most)
    asked = _asked(requirements)
    run = _Run(asked, folder, most, report)
    if executor is not None:
        run.begin_ahead(executor)
    search = run.search(most, seed)
    known = search.run()
    good = [each for each in known if each.carried]
    if not good:
        raise refused(asked, known)
    finals = run.finals(search, known)
    best, task, space = finals[0], search.task, asked.space  # as learned from the finals
    branch = search.branch_of(best)
    share = made_share(task, best)
    open_ = [name for name in task.undecided(best) if name != "yield"]
    open_ += ["yield"] if share.low < asked.least_yield <= share.high else []
    feasible = search.merit(best) <= task.objective(task.figures(best)) and not share[0] < asked.least_yield
    judged = {each.design.choice for each in finals}
    others = [each for each in firsts(known, search.at_best) if each.design.choice not in judged]
    return DesignAnswer(
        task, feasible, tuple(open_), best, space.values(best.design), figures_of(task, best), share,
        held_shares(task, best), prices(search, branch, best),
        *sensitivities(task, branch.prediction, best.point, space.variables),
        front_of(task, [*finals, *known]), tuple(known), lost_values(asked, search, known, finals),
        tied_with(search, [*finals, *others, *branch.known], best, space), run.count,
        landscape_of(asked, search, branch.prediction, best), run.notes(best), guards(task, best),
        _causes(asked, search, best, () if feasible else [*finals, *known]),
    )


def _causes(asked: Requirements, search: Search, best: Answered, lost: Sequence[Answered]) -> tuple[str, ...]:
    """Return in words why limits are exceeded, and of designs none of which hold them which no design can."""
    beyond = search.beyond if lost else ""
    pairs = search.task.contradicting(search.seen(lost)) if lost and not beyond else ()
    return (*((beyond,) if beyond else ()), *causes(asked, search.task, best), *pairs)


def previewed(requirements: Requirements, *, folder: Path | None = None, report: Report | None = None) -> Preview:
    """Return what the first `_FIRST` designs of a search predict; `design` goes on from them.

    Raises SceneError as `design`.
    """
    run = _Run(requirements, folder, _FIRST, report)
    search = run.search(_FIRST, 0)
    known = search.run()
    if not any(each.carried for each in known):
        raise refused(requirements, known)
    return preview_of(requirements, search)


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
    report: Report | None
    count: int = 0
    ahead: dict[Design, Future[Answered]] = field(default_factory=dict)
    last: Answered | None = None  # that was solved

    @cached_property
    def coarse(self) -> Solver:
        """The solver of the search."""
        return Solver(self.asked, COARSE, self.folder)

    def begin_ahead(self, executor: Executor) -> None:
        """Begin the first designs of all choices side by side."""
        starts = {choice: self.start(choice, 0) for choice in self.asked.space.choices[: self.most]}
        first = [Design(choice, tuple(x.tolist())) for choice, x in starts.items() if isinstance(x, np.ndarray)]
        self.ahead = {each: executor.submit(self.coarse, each) for each in first}

    def search(self, most: int, seed: int) -> Search:
        """Return the search, the least strained choices first where the first design within the limits will do."""
        space = self.asked.space
        choices = space.choices
        if not self.asked.minimised:
            bounds = {choice: bounds_of(self.coarse, choice)[1] for choice in choices}
            choices = tuple(sorted(choices, key=lambda each: min((one.strain for one in bounds[each]), default=np.inf)))
        return Search(
            self.coarse.task, choices, len(space.variables), self.solve, self.start, most, seed, space.silicone,
            space.growth,
        )

    def solve(self, wanted: Design, tolerance: float = COARSE) -> Answered:
        """Solve a design, and report progress."""
        begun = self.ahead.pop(wanted, None) if tolerance == COARSE else None
        found = replace(self.coarse, tolerance=tolerance)(wanted) if begun is None else begun.result()
        self.count, self.last = self.count + 1, found
        if self.report is not None:
            words = f"{self.asked.space.words(wanted)}: {words_of(self.coarse.task, found)}"
            self.report(self.count, max(self.count, min(self.most, expected_designs(self.asked))), words)
        return found

    def start(self, choice: tuple[int, ...], attempt: int) -> Array | Answered | None:
        """Return where a choice begins, or why none of its designs can hold, by sizes and linear theory alone.

        First the possible point nearest to the middle that holds both, or is nearest to it; then the same with strains
        as the last one's.
        """
        if attempt > 1 or attempt and not self.asked.space.variables:
            return None
        known = bounds_of(self.coarse, choice)
        return begin_again(known, self.last) if attempt and self.last else begin_at(known)

    def finals(self, search: Search, known: Sequence[Answered]) -> list[Answered]:
        """Return the best designs of the choices that may win, rounded and solved finer, the best one first.

        Where nothing is minimised, and a round one is decided, or none can hold the limits, no finer one tells more.
        """
        first = min(known, key=search.merit)
        if search.beyond or not search.task.minimised and self.decided(search.task, first):
            return [first]
        found = [self.refined(search, first)]
        for other in firsts(known, search.at_best):
            new = other.design.choice != first.design.choice and len(found) < _FINALS
            if new and search.may_beat(other, min(found, key=search.merit)):
                found.append(self.refined(search, other))
        for each in found:
            search.learn(each)
        return sorted(found, key=lambda each: (not self.holds(search, each), search.merit(each)))

    def decided(self, task: Task, found: Answered) -> bool:
        """Return whether a round design holds every limit, or exceeds one, whatever its errors are."""
        share, round_ = made_share(task, found), found.design in self.asked.space.rounded(found.design)
        open_ = share.low < self.asked.least_yield <= share.high
        return round_ and not task.undecided(found) and not open_

    def holds(self, search: Search, found: Answered) -> bool:
        """Return whether a solved design and enough of those made of it hold every limit."""
        return search.task.holds(found) and not made_share(search.task, found).value < self.asked.least_yield

    def refined(self, search: Search, best: Answered) -> Answered:
        """Return the best design of a choice, rounded and solved finer; itself where no rounded one is carried.

        The simplest one that is predicted to be as good; where that does not come true, the best known one as well.
        """
        branch = search.branch_of(best)
        found = self.rounded(search, branch, search.simplest(branch, best))
        enough = search.worth(best) if self.holds(search, found) else 0.0
        if search.merit(found) - search.merit(best) > enough:
            found = min(found, self.rounded(search, branch, best.point), key=search.merit)
        return found if found.carried else best

    def rounded(self, search: Search, branch: Branch, point: Array) -> Answered:
        """Return the best of the round designs at a point that promise most, solved finer.

        The next one is solved where what it is predicted to gain over this one would make it hold the limits.
        """
        tries = sorted(
            self.asked.space.rounded(Design(branch.choice, tuple(point.tolist()))),
            key=lambda each: search.predicted(branch.prediction, np.array(each.x, dtype=float), slack=0.0),
        )
        points = (np.array(each.x, dtype=float) for each in tries[:_TRIES])
        found, worst = [], [search.task.worst(branch.prediction.at(x)) for x in points]
        for k, wanted in enumerate(tries[:_TRIES]):
            new = self.solve(wanted, FINE)
            if self.holds(search, new):
                return new
            found.append(new)
            if new.carried and search.task.worst(new) > worst[k] - min(worst[k + 1 :], default=np.inf):
                break
        return min(found, key=search.merit)

    def notes(self, best: Answered) -> tuple[str, ...]:
        """Return notes on the answer for a designer."""
        sensor = self.asked.space.sensor(best.design)
        found = list(untested_notes(sensor))
        for silicone in silicones_of(sensor):
            if silicone.spread:
                found.append(
                    f"the sources of {silicone.name or 'the silicone'} differ by {1.0 + silicone.spread:.3g} in stress:"
                    " forces may be off by as much; measure the own silicone"
                )
            if silicone.mode_spread:
                known = f"by its tests loads of the silicone are known within {100.0 * silicone.mode_spread:.2g} % only"
                found.append(f"{known}; a test of another mode narrows it")
        return tuple(found)
