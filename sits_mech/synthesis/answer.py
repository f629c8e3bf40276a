"""What came out of a search, for a designer? The recommendation, what it costs, and why the others lost.

Prices are those of the predictions around the recommended design: what is minimised, with one limit a tenth looser.
Sensitivities are the change of a figure by a tenth of the bounds' distance. The front holds the designs that carry the
overload, have one load for each reading, and that no other solved one beats in every figure that is asked for. Two
designs that differ by less than their errors are as good as each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sits_mech.quantities import Array, shown_unit
from sits_mech.synthesis.answered import LEAST_INVERSE, STRAIN, Answered, Task, over
from sits_mech.synthesis.figures import INVERSE, Table
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.requirements import BY_FORCE, LEAST, PLAIN, Requirements
from sits_mech.synthesis.search import Search
from sits_mech.synthesis.space import Design

_LOOSER = 0.1  # of a limit
_STEP = 0.1  # of the bounds' distance
_BINDS = 0.03  # of a limit: what is nearer binds
_MANY = 4096  # sensors made
_KNOWN = 0.25  # of the box: predictions further from what was solved are not shown
_FINE, _COARSE = 101, 25  # points of a picture along one variable, and along each of two


@dataclass(frozen=True)
class Figure:
    """A figure with its limit.

    Attributes
    ----------
    name : str
    value, error : float
        Error nan where it is not known [unit].
    unit : str
        "%" for shares.
    limit : float or None
        At most, or for what is in `LEAST` at least [unit].
    holds : str
        "yes", "no", "within its error", or "" without a limit.
    """

    name: str
    value: float
    error: float
    unit: str
    limit: float | None
    holds: str


@dataclass(frozen=True)
class Price:
    """A limit that binds, by how much it is exceeded, and the relative change of what is minimised were it looser."""

    name: str
    excess: float
    gain: float


@dataclass(frozen=True)
class Lost:
    """A value of a list that was not taken: its best design and why."""

    key: str
    value: str
    design: str
    why: str


@dataclass(frozen=True)
class Landscape:
    """What the predictions show around the recommended design over one or two variables, the others as they are.

    Attributes
    ----------
    names : tuple of str
        Keys of the scene.
    axes : tuple of ndarray
        Values of each, as written.
    units : tuple of str
    aim, excess : ndarray
        What is minimised, and the limit that is exceeded most, over itself; shape of the axes, nan far from all that
        was solved.
    worst : ndarray of str
        Which limit that is.
    """

    names: tuple[str, ...]
    axes: tuple[Array, ...]
    units: tuple[str, ...]
    aim: Array
    excess: Array
    worst: NDArray[np.str_]


@dataclass(frozen=True)
class DesignAnswer:
    """What a search recommends.

    Attributes
    ----------
    task : Task
        What tells figures and excess of its designs.
    feasible : bool
        Whether the recommended design holds all limits; where none does, it is the nearest one.
    best : Answered
        Of round numbers, solved anew.
    values : dict
        What it sets, by key of the scene, as written.
    figures : tuple of Figure
    share : float
        Of the sensors made, that hold every limit; nan without tolerances.
    binding : tuple of Price
    sensitivities : dict
        Figure -> variable -> change of the figure, over it.
    front, known : tuple of Answered
        The front; all that was solved.
    lost : tuple of Lost
    tied : tuple of str
        Designs that are as good within their errors.
    solves : int
        Chains solved.
    landscape : Landscape or None
        None without numbers between bounds.
    notes : tuple of str
    """

    task: Task
    feasible: bool
    best: Answered
    values: dict[str, Any]
    figures: tuple[Figure, ...]
    share: float
    binding: tuple[Price, ...]
    sensitivities: dict[str, dict[str, float]]
    front: tuple[Answered, ...]
    known: tuple[Answered, ...]
    lost: tuple[Lost, ...]
    tied: tuple[str, ...]
    solves: int
    landscape: Landscape | None = None
    notes: tuple[str, ...] = ()


def unit_of(name: str) -> tuple[str, float]:
    """Return the unit that a figure is shown in, and what it is of the SI unit."""
    kind, _, part = name.partition(".")
    if kind == "resolution":
        unit = shown_unit(part)
        return f"m{unit}", 1e3
    if kind == "footprint" or PLAIN.get(name) == "m":
        return "mm", 1e3
    return ("Hz", 1.0) if name == "rate" else ("", 1.0) if name == INVERSE else ("%", 100.0)


def figure_words(name: str, value: float) -> str:
    """Return a figure for a reader."""
    unit, scale = unit_of(name)
    return f"{scale * value:.3g} {unit}".strip()


def figures_of(task: Task, found: Answered) -> tuple[Figure, ...]:
    """Return the figures of a solved design with their limits."""
    figures, rows = task.figures(found.table, found.plain), []
    for name, value in figures.items():
        unit, scale = unit_of(name)
        limit, unknown = task.limits.get(name), np.nan if name.partition(".")[0] in BY_FORCE else 0.0
        error = found.error.get(name, unknown)
        holds = ""
        if limit is not None:
            holds = "no" if over(name, value, limit) > 0.0 else "yes"
            holds = "within its error" if abs(value - limit) < error else holds
        rows.append(Figure(name, scale * value, scale * error, unit, None if limit is None else scale * limit, holds))
    return tuple(rows)


def prices(search: Search, branch: Any, best: Answered) -> tuple[Price, ...]:
    """Return the limits that bind at a design, with their prices; `branch` is that of its choice."""
    task = search.task
    figures = task.figures(best.table, best.plain)
    found = []
    for name, excess in task.excess(figures, best.table).items():
        if excess < -_BINDS or name == "yield" and len(task.excess(figures, best.table)) > 1 and excess < 0.0:
            continue
        gain = np.nan
        if name in task.limits and task.goal and branch.prediction.solved and len(best.design.x):
            other, aim = replace(search, task=_looser(task, name)), search.propose(branch).merit
            gain = (other.propose(branch).merit - aim) / abs(aim) if aim else np.nan
        found.append(Price(name, excess, float(gain)))
    return tuple(sorted(found, key=lambda price: -price.excess))


def _looser(task: Task, name: str) -> Task:
    """A task with one limit a tenth looser, what is minimised weighed as before."""
    factor = 1.0 - _LOOSER if name in (*LEAST, INVERSE) else 1.0 + _LOOSER
    limits = task.limits | {name: task.limits[name] * factor}
    judge = replace(task.judge, limits={key: limits[key] for key in task.judge.limits})
    return replace(task, judge=judge, limits=limits, weighed=task.weighed or task.limits)


def landscape_of(asked: Requirements, search: Search, prediction: Prediction, best: Answered) -> Landscape | None:
    """Return what the predictions of a choice show around its best design."""
    some = asked.space.variables[:2]
    if not some or not prediction.solved:
        return None
    count = _FINE if len(some) == 1 else _COARSE
    unit = np.linspace(0.0, 1.0, count)
    shape = (count,) * len(some)
    aim, excess, worst = np.zeros(shape), np.zeros(shape), np.full(shape, "", dtype="<U40")
    for index in np.ndindex(shape):
        x = best.point.copy()
        x[: len(some)] = unit[list(index)]
        if prediction.distance(x) > _KNOWN:
            aim[index] = excess[index] = np.nan
            continue
        table, plain = prediction.table(x), prediction.plain(x)
        figures = search.task.figures(table, plain)
        beyond = search.task.excess(figures, table)
        aim[index] = search.task.aim(figures)
        excess[index], worst[index] = max(((value, name) for name, value in beyond.items()), default=(-1.0, ""))
    axes = tuple(np.array([each.value(x) for x in unit]) for each in some)
    return Landscape(tuple(each.key for each in some), axes, tuple(each.unit for each in some), aim, excess, worst)


def sensitivities(task: Task, best: Answered, names: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return how the figures of a design go with its variables, by its own tangent."""
    here = task.figures(best.table, best.plain)
    found: dict[str, dict[str, float]] = {}
    for k, key in enumerate(names):
        step = np.zeros(len(names))
        step[k] = -_STEP if best.design.x[k] > 0.5 else _STEP
        table = best.table
        if table is not None:
            table = Table(table.L + np.tensordot(step, best.by_x, 1), table.by_tolerance, table.noise)
        plain = dict(best.plain)
        for name, slope in best.plain_by_x.items():
            plain[name] += float(slope @ step)
        there = task.figures(table, plain)
        for name, value in here.items():
            if value and (name in best.plain_by_x or name not in best.plain):
                found.setdefault(name, {})[key] = float((there[name] - value) / value * np.sign(step[k]))
    return found


def front_of(task: Task, known: Sequence[Answered]) -> tuple[Answered, ...]:
    """Return the designs that no other one beats in all figures that are asked for."""
    asked = [name for name in {**task.limits, **task.goal} if name not in (STRAIN, INVERSE)]
    rows = []
    for each in known:
        figures = task.figures(each.table, each.plain) if each.carried else {}
        if not each.carried or figures.get(INVERSE, 1.0) < LEAST_INVERSE or figures.get(STRAIN, 0.0) > 1.0:
            continue
        signs = {name: -1.0 if name in LEAST else 1.0 for name in asked if name in figures}
        rows.append((each, np.array([sign * figures[name] for name, sign in signs.items()])))
    return tuple(
        each for each, own in rows if not any(np.all(other <= own) and np.any(other < own) for _, other in rows)
    )  # fmt: skip


def lost_values(asked: Requirements, search: Search, known: Sequence[Answered], best: Answered) -> tuple[Lost, ...]:
    """Return why other values of the lists were not taken."""
    found, space = [], asked.space
    for place, (key, values) in enumerate(space.lists.items()):
        for number, value in enumerate(values):
            if number == best.design.choice[place]:
                continue
            own = [each for each in known if each.design.choice[place] == number]
            if own:
                first = min(own, key=search.merit)
                found.append(Lost(key, str(value), space.words(first.design), why_not(search, first, best)))
    return tuple(found)


def why_not(search: Search, other: Answered, best: Answered) -> str:
    """Return in words why a design is not taken for the best one."""
    if not other.carried:
        return other.reason
    task = search.task
    figures = task.figures(other.table, other.plain)
    excess = task.excess(figures, other.table)
    name = max(excess, key=lambda each: excess[each]) if excess else ""
    if name and excess[name] > 0.0:
        if name == "yield":
            return f"fewer than {100.0 * task.judge.share:.3g} % of the sensors made hold the limits"
        return f"{name} {figure_words(name, figures[name])} against {figure_words(name, task.limits[name])}"
    own, least = task.aim(figures), task.aim(task.figures(best.table, best.plain))
    more = f"{100.0 * (own - least) / abs(least):.3g} % more" if least else "no less"
    return f"holds the limits, but what is minimised is {more}"


def tied_with(asked: Requirements, search: Search, known: Sequence[Answered], best: Answered) -> tuple[str, ...]:
    """Return designs of other choices that are as good as the best one within their errors."""
    task, found = search.task, []
    size = task.sizes | task.limits

    def doubt(each: Answered) -> float:
        """Error of what is minimised."""
        return sum(weight * each.error.get(name, 0.0) / abs(size.get(name, 1.0)) for name, weight in task.goal.items())

    least = search.merit(best)
    for choice in dict.fromkeys(each.design.choice for each in known):
        own = [each for each in known if each.design.choice == choice and each.carried]
        if choice == best.design.choice or not own or not task.goal:
            continue
        first = min(own, key=search.merit)
        if search.merit(first) - least < doubt(first) + doubt(best):
            found.append(asked.space.words(first.design))
    return tuple(found)


def made_share(task: Task, best: Answered) -> float:
    """Return the share of the sensors made that hold every limit; nan without tolerances."""
    if best.table is None or not len(task.judge.deviations):
        return np.nan
    figures = task.figures(best.table, best.plain)
    fixed = [name for name in figures if name.partition(".")[0] not in BY_FORCE]
    if any(over(name, figures[name], task.limits[name]) > 0.0 for name in fixed if name in task.limits):
        return 0.0
    return float(np.mean(task.judge.excess(best.table, _MANY) <= 0.0))


def rounded(asked: Requirements, design: Design) -> list[Design]:
    """Return designs of round numbers beside one, the nearest first."""
    found: list[tuple[float, ...]] = [()]
    for variable, x in zip(asked.space.variables, design.x, strict=True):
        found = [(*own, each) for own in found for each in variable.round_neighbours(x)][:64]
    return [Design(design.choice, x) for x in found]
