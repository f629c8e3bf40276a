"""Explore by predictions: prices of limits, sensitivities, a map of two numbers, a search that has only begun.

All by the predictions of its choice (prediction.py), beside which a design's own figures are solved finer:

    price           what is minimised, with one limit a tenth looser, over what it is: negative is a gain
    sensitivity     change of a figure, over it, where a number goes up by a tenth of its bounds' distance
    ten percent     the same where the number itself goes up by a tenth, whatever its bounds
    landscape       what is minimised and what is exceeded, over the first two numbers
    preview         the best prediction of a search that was stopped; the error of a figure is the largest of those of
                    solved designs, and of what each of the choice differs from its prediction by the others of it
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.required.kinds import INVERSE, kind_of
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.space import Design, Variable
from sits_mech.synthesis.search import Branch, Search
from sits_mech.synthesis.solved.answered import Answered, Task, over

_LOOSER = 0.1  # of a limit
_STEP = 0.1  # of the bounds' distance, or of a number
_BINDS = 0.03  # of a limit: what is nearer binds, and what is nearer than its error
_KNOWN = 0.2  # of the box: predictions further from what was solved are not shown
_FINE, _COARSE = 101, 25  # points of a picture along one variable, and along each of two

Changes = dict[str, dict[str, float]]
"""Figure -> number of the scene -> relative change of the figure."""


@dataclass(frozen=True)
class Price:
    """A limit that binds, and what it costs."""

    name: str
    excess: float  # over the limit
    gain: float  # relative change of what is minimised with the limit a tenth looser; nan if unknown


@dataclass(frozen=True)
class Landscape:
    """Predictions around the recommended design over one or two variables, the others fixed."""

    names: tuple[str, ...]  # keys of the scene
    axes: tuple[Array, ...]  # values of each, as written
    units: tuple[str, ...]
    objective: Array  # what is minimised; nan far from all that was solved, or not invertible
    excess: Array  # of the limit exceeded most, over itself; nan far from all that was solved


def prices(search: Search, branch: Any, best: Answered) -> tuple[Price, ...]:
    """Return the limits that bind at a design, with their prices; `branch` is that of its choice."""
    task = search.task
    figures, off = task.figures(best), task.errors(best)
    found = []
    every, objective = task.excess(figures, best.table), np.nan
    for name, excess in every.items():
        if excess < -max(_BINDS, off.get(name, 0.0)) or name == "yield" and len(every) > 1 and excess < 0.0:
            continue
        gain = np.nan
        if name in task.limits and task.minimised and branch.prediction.solved and len(best.design.x):
            objective = search.propose(branch).merit if np.isnan(objective) else objective
            limits = task.limits | {name: task.limits[name] * (1.0 + kind_of(name).sign * _LOOSER)}
            judge = replace(task.judge, limits={key: limits[key] for key in task.judge.limits})
            eased = replace(task, judge=judge, limits=limits, weighed=task.weighed or task.limits)  # scales as before
            loose = replace(search, task=eased).propose(branch).merit
            gain = (loose - objective) / abs(objective) if objective else np.nan
        found.append(Price(name, excess, float(gain)))
    return tuple(sorted(found, key=lambda price: -price.excess))


def landscape_of(asked: Requirements, search: Search, prediction: Prediction, best: Answered) -> Landscape | None:
    """Return the predictions of a choice around its best design; None without numbers between bounds."""
    some = asked.space.variables[:2]
    if not some or not prediction.solved:
        return None
    count = _FINE if len(some) == 1 else _COARSE
    unit = np.linspace(0.0, 1.0, count)
    shape = (count,) * len(some)
    objective, excess = np.zeros((2, *shape))
    for index in np.ndindex(shape):
        x = best.point.copy()
        x[: len(some)] = unit[list(index)]
        if prediction.distance(x) > _KNOWN:
            objective[index] = excess[index] = np.nan
            continue
        there = prediction.at(x)
        figures = search.task.figures(there)
        beyond = search.task.excess(figures, there.table)
        objective[index] = np.nan if beyond.get(INVERSE, 0.0) > 0.0 else search.task.objective(figures)
        excess[index] = max(beyond.values(), default=-1.0)
    axes = tuple(np.array([*map(each.value, unit)]) for each in some)
    return Landscape(tuple(each.key for each in some), axes, tuple(each.unit for each in some), objective, excess)


def sensitivities(
    task: Task, prediction: Prediction, x: Array, variables: Sequence[Variable]
) -> tuple[Changes, Changes]:
    """Return relative changes of the figures by each number: by a tenth of its bounds' distance, and of itself."""
    if not len(x) or not prediction.solved:
        return {}, {}
    here, found = _figures(task, prediction, x), (dict[str, dict[str, float]](), dict[str, dict[str, float]]())
    for k, variable in enumerate(variables):
        tenth = variable.value(float(x[k])) / (variable.high - variable.low)  # of the number, for one of the bounds
        for changes, size in zip(found, (_STEP, _STEP * tenth), strict=True):
            there = _figures(task, prediction, x + size * np.eye(len(x))[k])
            for name, value in here.items():
                if value:
                    changes.setdefault(name, {})[variable.key] = float((there[name] - value) / value)
    return found


def _figures(task: Task, prediction: Prediction, x: Array) -> dict[str, float]:
    """Return the predicted figures of a point; where sensors scatter, also the share that holds all limits."""
    there = prediction.at(x)
    found = task.figures(there)
    if there.table is not None and len(task.judge.deviations):
        found["yield"] = float(np.mean(task.judge.excess(there.table) <= 0.0))
    return found


@dataclass(frozen=True)
class Preview:
    """Predicted design and figures."""

    values: dict[str, Any]  # by key of the scene, as written
    figures: dict[str, tuple[float, float]]  # value and error [SI]; the error nan where it is not known
    limits: Mapping[str, float]  # [SI]
    solved: int

    @property
    def exceeded(self) -> tuple[str, ...]:
        """The limits that the prediction exceeds."""
        return tuple(
            name for name, limit in self.limits.items()
            if name in self.figures and over(name, self.figures[name][0], limit) > 0.0
        )


def preview_of(asked: Requirements, search: Search) -> Preview:
    """Return the best prediction of a search that was stopped after a few designs."""
    branches = [each for each in search.branches if each.prediction.solved]
    points = {each.choice: search.propose(each) if search.count else None for each in branches}

    def merit(branch: Branch) -> float:
        """Return what the choice promises, or where nothing varies has."""
        point = points[branch.choice]
        return min(map(search.merit, branch.known)) if point is None else point.merit

    best = min(branches, key=merit)
    point = points[best.choice]
    x = best.prediction.solved[0].point if point is None else point.x
    figures = search.task.figures(best.prediction.at(x))
    error = errors(search.task, best.prediction)
    rows = {name: (value, error.get(name, np.nan)) for name, value in figures.items()}
    design = Design(best.choice, tuple(x.tolist()))
    return Preview(asked.space.values(design), rows, search.task.limits, search.solved)


def errors(task: Task, prediction: Prediction) -> dict[str, float]:
    """Return the error of each predicted figure."""
    found: dict[str, float] = {}
    for k, each in enumerate(prediction.solved):
        own = task.figures(each)
        others = [*prediction.solved[:k], *prediction.solved[k + 1 :]]
        there = task.figures(Prediction(others, ()).at(each.point)) if others else {}
        off = {name: abs(value - own[name]) for name, value in there.items()}
        for name in own:
            known = [size for size in (each.error.get(name), off.get(name), found.get(name)) if size is not None]
            if known:
                found[name] = max(known)
    return found
