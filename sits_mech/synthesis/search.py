"""Search the best design: solve where predictions promise most, by a trust region in every choice of the lists.

With a(x) what is minimised and c_j(x) <= 0 the limits, over themselves, of one choice,

    minimise  a(x) + W s,     c_j(x) <= s,   s >= 0,   |x - x_best| <= r,

on predictions (prediction.py) by sequential quadratic programming from the best of many points; W s leads back where
limits do not hold. The point is solved, becomes part of the predictions, and the radius r follows how well it was
predicted. Every choice is solved once; after that the one whose prediction promises most is next, so that choices which
cannot win are left as they are. A choice rests when its next point is one that was solved, or promises less than what
answers are known to: their tolerance, the error of what is minimised. That last point is not lost: of it the finer
answer is made.

Source: N. M. Alexandrov, J. E. Dennis, R. M. Lewis, V. Torczon, Struct. Optim. 15 (1998) 16, trust regions for
predictions; D. Kraft, DFVLR-FB 88-28 (1988), the programming.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, minimize
from scipy.stats import qmc

from sits_mech.quantities import Array
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.reach import out_of_reach
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.solved.answered import Answered, Task

Solve = Callable[[Design], Answered]
MOST = 60
"""Designs that a search solves."""
_WEIGHT = 30.0  # of an exceeded limit, against what is minimised
_HELD = 2e-3  # excess of a limit that is none to a search: less than figures are known to
_CLOSE = 1e-3  # of the box: a point as near to a solved one is solved; less than what brings a limit to hold
_GAIN = 1e-2  # of what is minimised: less is not worth a solve, however well answers are known
_LOOKED_AT, _STARTS = 8, 2  # points of a box and starts of programming among them, for one number; doubled by each more
_AT_MOST = 64, 4  # of either
_THINNER = 0.02  # of a height: what is less is no simpler design
_WIDER, _NARROWER = 2.0, 0.4  # the radius of trust after a good step, and after a bad one
_GOOD, _BAD = 0.75, 0.25  # of what was promised came true
_RADIUS, _LEAST_RADIUS = 0.35, 0.004  # of trust, of the box


@dataclass(frozen=True)
class Proposal:
    """A point with its predicted merit."""

    x: Array
    merit: float
    excess: float = -1.0  # of the limit exceeded most, over itself


@dataclass
class Branch:
    """The search of one choice: its solved designs, radius of trust, whether it rests."""

    choice: tuple[int, ...]
    known: list[Answered] = field(default_factory=list)
    radius: float = _RADIUS
    done: bool = False
    promise: Proposal | None = None

    @property
    def prediction(self) -> Prediction:
        """The predictions of the choice."""
        solved = [each for each in self.known if each.carried]
        return Prediction(solved, [each for each in self.known if not each.carried and each.plain])


@dataclass
class Search:
    """A search over choices."""

    task: Task
    choices: Sequence[tuple[int, ...]]  # as of `Space.choices`
    count: int  # of the variables
    solve: Solve
    start: Callable[[tuple[int, ...], int], Array | Answered | None]  # first point by choice and attempt, if there is
    # one, or why there can be none
    most: int = MOST
    seed: int = 0  # of the starts
    silicone: int | None = None  # place of the silicone in a choice
    growth: Array = field(default_factory=lambda: np.zeros(0))  # (v,), as of `Space.growth`
    branches: list[Branch] = field(default_factory=list)
    solved: int = 0
    missed: list[float] = field(default_factory=list)  # by what first promises were off, limits aside

    def run(self) -> list[Answered]:
        """Search, and return all solved designs, and why choices have none."""
        self.branches = list(map(Branch, self.choices))
        for branch in self.branches:
            if not self.enough:
                self._begin(branch)
            branch.done = branch.done or not branch.known
        while self.solved < self.most and (open_ := [each for each in self.branches if not each.done]):
            for each in open_:
                each.promise = each.promise or self.propose(each)
            branch = min(open_, key=self._hope)
            if self.enough or self._rests(branch):
                branch.done = True
            else:
                self._step(branch)
        return self.known

    @property
    def enough(self) -> bool:
        """Whether nothing is minimised and a design holds."""
        return not self.task.minimised and min(map(self.merit, self.known), default=np.inf) <= 0.0

    def branch_of(self, found: Answered) -> Branch:
        """Return the search of a design's choice."""
        return next(each for each in self.branches if each.choice == found.design.choice)

    @property
    def known(self) -> list[Answered]:
        """All solved designs."""
        return [each for branch in self.branches for each in branch.known]

    def merit(self, found: Answered) -> float:
        """Return what is minimised of a solved design, exceeded limits added; infinite of one without a table."""
        return self._merit(found) if found.carried else np.inf

    def at_best(self, found: Answered) -> float:
        """Return the merit of a solved design with all its figures better by their errors."""
        if not found.carried:
            return np.inf
        task = self.task
        figures, off = task.figures(found), task.errors(found)
        left = [value - off.get(name, 0.0) for name, value in task.excess(figures, found.table).items()]
        return task.objective(figures) - task.doubt(found) + _exceeded(max(left, default=0.0))

    def may_beat(self, other: Answered, best: Answered) -> bool:
        """Return whether another design may be better than the best one within the errors."""
        return self.at_best(other) < self.merit(best) + self.task.doubt(best)

    def predicted(self, prediction: Prediction, x: Array, slack: float = _HELD) -> float:
        """Return the predicted merit of a point."""
        return self._merit(prediction.at(x), slack)

    def _merit(self, found: Answered, slack: float = _HELD) -> float:
        """Return the merit of a design, solved or predicted."""
        figures = self.task.figures(found)
        worst = max(self.task.excess(figures, found.table).values(), default=0.0)
        return self.task.objective(figures) + _exceeded(worst, slack)

    def as_good(self, merit: float, least: float) -> bool:
        """Return whether a merit is the least one of its own choice, within what is worth a solve."""
        return merit <= least + _GAIN * abs(least)

    def worth(self, best: Answered) -> float:
        """Return the gain over a design that is worth a solve: what answers are known to, and what is minimised."""
        return max(max(_GAIN, self.task.tolerance) * abs(self.merit(best)), self.task.doubt(best), 1e-12)

    def simplest(self, branch: Branch, best: Answered) -> Array:
        """Return the thinnest point of a choice that is predicted to be as good as its best one, solved or promised.

        Without minimised figures the solved one.
        """
        if not self.task.minimised or not self.count:
            return best.point
        prediction, promise = branch.prediction, branch.promise or self.propose(branch)
        x, least = min((promise.x, promise.merit), (best.point, self.merit(best)), key=lambda pair: pair[1])
        height = prediction.plain(x)["height"]
        thin = {tuple(each): prediction.plain(each)["height"] for each in (*self._unit, *_toward(prediction, x))}
        for each in sorted(thin, key=lambda each: thin[each]):
            if thin[each] > (1.0 - _THINNER) * height:
                break
            there = np.array(each)
            near = prediction.distance(there) < _RADIUS
            if near and self.as_good(self.predicted(prediction, there, slack=0.0), least):
                return there
        return x

    def out_of_reach(self, branch: Branch) -> str:
        """Return in words which resolution no design of a choice, or of one of another silicone, can reach, or ""."""
        alike = (each for each in self.branches if all(
            a == b or k == self.silicone for k, (a, b) in enumerate(zip(each.choice, branch.choice, strict=True))))
        growth = self.growth if len(self.growth) else np.zeros(self.count)
        return out_of_reach(self.task, [each.prediction for each in alike], growth)

    @property
    def beyond(self) -> str:
        """Which limit no design of any choice can hold, by the choice that comes nearest, in words; or ""."""
        words = [self.out_of_reach(each) for each in self.branches if each.prediction.solved]
        return words[0] if words and all(words) else ""

    def seen(self, known: Sequence[Answered]) -> list[dict[str, float]]:
        """Return the figures of solved designs, and those predicted at corners of the box and points between."""
        corners = product((0.0, 1.0), repeat=self.count) if 2**self.count <= _AT_MOST[0] else ()
        points = [*corners, *self._unit] if self.count else []
        some = [each.prediction.at(np.array(x)) for each in self.branches if each.prediction.solved for x in points]
        return [*map(self.task.figures, [*known, *some])]

    def _begin(self, branch: Branch) -> None:
        """Solve a choice at its start; where that fails, at the next one. What is out of reach of any is not begun."""
        beyond = self.out_of_reach(branch)
        if beyond:
            design, none = Design(branch.choice, (0.5,) * self.count), np.zeros((self.count, 0, 0))
            branch.known.append(Answered(design, f"left out: {beyond}", None, none, {}, {}))
            branch.done = True
            return
        for attempt in range(3):
            x = self.start(branch.choice, attempt)
            if isinstance(x, Answered):
                branch.known.append(x)
            if x is None or isinstance(x, Answered) or self.solved >= self.most:
                break
            self._add(branch, x)
            if branch.known[-1].carried:
                break
        branch.done = not branch.prediction.solved or self.count == 0

    def _add(self, branch: Branch, x: Array) -> Answered:
        """Solve a point of a choice."""
        found = self.solve(Design(branch.choice, tuple(float(each) for each in x)))
        branch.known.append(found)
        branch.promise, self.solved = None, self.solved + 1
        self.learn(found)
        return found

    def learn(self, found: Answered) -> None:
        """Take the sizes and errors of a solved design into the task."""
        if found.carried:
            self.task = self.task.learned(found)

    def _hope(self, branch: Branch) -> float:
        """Return the merit a choice may reach: its promise, improved by the error of first promises."""
        promise = np.inf if branch.promise is None else branch.promise.merit
        first = len(branch.prediction.solved) == 1 and self.missed
        return promise - (float(np.mean(self.missed)) if first else 0.0)

    def _rests(self, branch: Branch) -> bool:
        """Return whether a choice promises no gain."""
        if branch.promise is None or branch.prediction.distance(branch.promise.x) < _CLOSE:
            return True
        if self.out_of_reach(branch):
            return True
        best = min(self.known, key=self.merit)
        return self.merit(best) - self._hope(branch) < self.worth(best)

    def _step(self, branch: Branch) -> None:
        """Solve the proposal of a choice, and adapt its trust radius."""
        if branch.promise is None:
            return
        before, promise = min(self.merit(each) for each in branch.known), branch.promise
        single = len(branch.prediction.solved) == 1
        found = self._add(branch, promise.x)
        promised, came = before - promise.merit, before - self.merit(found)
        if single and found.carried:
            objective = self.task.objective(self.task.figures(found))
            self.missed.append(abs(objective - promise.merit + _exceeded(promise.excess)))
        if came >= _GOOD * promised:
            branch.radius = min(_WIDER * branch.radius, 1.0)
        elif came < _BAD * promised:
            branch.radius *= _NARROWER
        branch.done = branch.radius < _LEAST_RADIUS

    @property
    def _unit(self) -> Array:
        """Points of the unit box that are looked at, shape (m, v)."""
        count = min(_LOOKED_AT * 2**self.count, _AT_MOST[0])
        return np.asarray(qmc.Sobol(self.count, rng=np.random.default_rng(self.seed)).random(count))

    def propose(self, branch: Branch) -> Proposal:
        """Return the best predicted point of a choice within its trust radius."""
        prediction = branch.prediction
        best = min(prediction.solved, key=self.merit)
        bounds = [(max(0.0, x - branch.radius), min(1.0, x + branch.radius)) for x in best.point]
        low, high = np.array(bounds).T
        points = (best.point, *(low + (high - low) * self._unit))
        seen = [Proposal(x, self.predicted(prediction, x)) for x in points]
        count = min(_STARTS * 2 ** (self.count - 1), _AT_MOST[1])
        starts = [seen[0], *sorted(seen[1:], key=lambda each: each.merit)[: count - 1]]
        found = [self._minimised(prediction, start.x, bounds) for start in starts]
        return min([*seen, *found], key=lambda each: each.merit)

    def _minimised(self, prediction: Prediction, start: Array, bounds: list[tuple[float, float]]) -> Proposal:
        """Return where sequential quadratic programming on predictions ends."""

        last: dict[bytes, tuple[float, Array]] = {}

        def seen(x: Array) -> tuple[float, Array]:
            """Return the objective and the limits, both needed at every point."""
            key = x.tobytes()
            if key not in last:
                there = prediction.at(x)
                figures = self.task.figures(there)
                over = np.array(list(self.task.excess(figures, there.table).values()) or [-1.0])
                last[key] = self.task.objective(figures), np.clip(over, -1.0, 1e3)
            return last[key]

        def aimed(z: Array) -> float:
            """Return the objective with the slack."""
            return seen(z[:-1])[0] + _WEIGHT * float(z[-1])

        def left(z: Array) -> Array:
            """Return the margins of the limits with the slack."""
            return np.asarray(z[-1] - seen(z[:-1])[1])

        slack = max(0.0, float(seen(start)[1].max()))
        low, high = np.array([*bounds, (0.0, np.inf)]).T
        result = minimize(
            aimed, np.append(start, slack), method="SLSQP", bounds=Bounds(low, high),
            options={"maxiter": 25, "ftol": 1e-6}, constraints=[NonlinearConstraint(left, 0.0, np.inf)],
        )
        x = np.clip(result.x[:-1], *np.array(bounds).T)
        objective, over = seen(x)
        return Proposal(x, objective + _exceeded(float(over.max())), float(over.max()))


def _toward(prediction: Prediction, x: Array) -> list[Array]:
    """Return points on the way from each solved design to a point, quarters of it apart."""
    return [solved.point + share * (x - solved.point) for solved in prediction.solved for share in np.arange(4) / 4]


def _exceeded(worst: float, slack: float = _HELD) -> float:
    """Return the penalty of the limit that is exceeded most."""
    return _WEIGHT * max(worst - slack, 0.0)
