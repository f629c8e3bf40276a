"""Summarize a search for a designer: the recommendation, its price, and why the others lost.

The front holds the designs that carry the overload, have one load for each reading, and that no other solved one beats
in every figure that is asked for. Designs of two choices that differ by less than their errors do not beat each other;
those of one choice have most of their errors in common, and go by their figures. What is around the recommended
design stands in around.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.around import Changes, Landscape, Price
from sits_mech.synthesis.required.kinds import INVERSE, STRAIN, figure_words, kind_of, shown_as
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.space import Space
from sits_mech.synthesis.search import Search
from sits_mech.synthesis.solved.answered import LEAST_INVERSE, Answered, Task, over

_MANY = 4096  # sensors made
_APART = 0.1  # of the box: tied designs that are nearer are one
_DIFFERS = 0.05  # of a figure: what tells designs apart
_NOTHING = 2e-3  # of a limit: a guard that is none


@dataclass(frozen=True)
class Figure:
    """A figure with its limit."""

    name: str
    value: float  # [unit]
    error: float  # nan where not known [unit]
    unit: str  # "%" for shares
    limit: float | None  # at most, or for some kinds at least [unit]
    holds: str  # "yes", "no", "within its error", or "" without a limit


@dataclass(frozen=True)
class Lost:
    """A value of a list that was not taken: its best design and why."""

    key: str
    value: str
    design: str
    why: str


class Share(NamedTuple):
    """A share of the sensors made, and its bounds by the errors of the figures; nan without tolerances."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class DesignAnswer:
    """What a search recommends.

    Attributes
    ----------
    task : Task
        What tells figures and excess of its designs.
    feasible : bool
        Whether the recommended design holds all limits by its figures; where none does, it is the nearest one.
    undecided : tuple of str
        Limits that are nearer to their figures than these are known: whether they hold is open.
    best : Answered
        Of round numbers, solved anew.
    values : dict
        What it sets, by key of the scene, as written.
    figures : tuple of Figure
    share : Share
        Of the sensors made, that hold every limit.
    held : dict
        Share of them that hold each limit of a figure which scatters.
    binding : tuple of Price
    sensitivities, ten_percent : dict
        Figure -> number of the scene -> relative change of the figure, by a tenth of the bounds' distance and by ten
        percent more of the number.
    front, known : tuple of Answered
        The front; all that was solved.
    lost : tuple of Lost
    tied : tuple of str
        Designs that may be as good or better within the errors, in words; at the end what tells them apart.
    solves : int
        Chains solved.
    landscape : Landscape or None
        None without numbers between bounds.
    notes : tuple of str
    guards : dict
        Figure -> value [SI] that it may have by itself, so that the asked share of the sensors made hold its limit.
    causes : tuple of str
        What figures beyond their limits come from, and which limits contradict each other, in words.
    """

    task: Task
    feasible: bool
    undecided: tuple[str, ...]
    best: Answered
    values: dict[str, Any]
    figures: tuple[Figure, ...]
    share: Share
    held: dict[str, float]
    binding: tuple[Price, ...]
    sensitivities: Changes
    ten_percent: Changes
    front: tuple[Answered, ...]
    known: tuple[Answered, ...]
    lost: tuple[Lost, ...]
    tied: tuple[str, ...]
    solves: int
    landscape: Landscape | None = None
    notes: tuple[str, ...] = ()
    guards: dict[str, float] = field(default_factory=dict)
    causes: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """Whether the limits hold, in words."""
        open_ = f"; within its error: {', '.join(self.undecided)}" if self.undecided else ""
        return f"{'every limit holds' if self.feasible else 'no solved design holds every limit'}{open_}"


def words_of(task: Task, found: Answered) -> str:
    """Return the figures of a solved design that are asked for, for a reader, and which limits they exceed."""
    if not found.carried:
        return found.reason
    figures = task.figures(found)
    over_ = [name for name, limit in task.limits.items() if name in figures and over(name, figures[name], limit) > 0.0]
    names = (name for name in {**task.minimised, **task.limits} if name in figures)
    each = (f"{name} {figure_words(name, figures[name])}" for name in names)
    return f"{', '.join(each)}; {'beyond limits: ' + ', '.join(over_) if over_ else 'within the limits'}"


def figures_of(task: Task, found: Answered) -> tuple[Figure, ...]:
    """Return the figures of a solved design with their limits."""
    figures, rows = task.figures(found), []
    for name, value in figures.items():
        unit, scale = shown_as(name)
        limit, error = task.limits.get(name), found.error.get(name, 0.0 if kind_of(name).exact else np.nan)
        holds = ""
        if limit is not None:
            holds = "no" if over(name, value, limit) > 0.0 else "yes"
            holds = "within its error" if abs(value - limit) < error else holds
        rows.append(Figure(name, scale * value, scale * error, unit, None if limit is None else scale * limit, holds))
    return tuple(rows)


def front_of(task: Task, known: Sequence[Answered]) -> tuple[Answered, ...]:
    """Return the designs that no other one beats in all figures that are asked for."""
    asked = [name for name in {**task.limits, **task.minimised} if name not in (STRAIN, INVERSE)]
    rows = []
    for each in known:
        figures = task.figures(each) if each.carried else {}
        if not each.carried or figures.get(INVERSE, 1.0) < LEAST_INVERSE or figures.get(STRAIN, 0.0) > 1.0:
            continue
        names = [name for name in asked if name in figures]
        own = np.array([kind_of(name).sign * figures[name] for name in names])
        rows.append((each, own, np.array([each.error.get(name, 0.0) for name in names])))

    def beats(other: tuple[Answered, Array, Array], one: tuple[Answered, Array, Array]) -> bool:
        """Return whether a design is in no figure worse than another, and in one better beyond their errors."""
        hidden = 0.0 if other[0].design.choice == one[0].design.choice else other[2] + one[2]
        return bool(np.all(other[1] <= one[1]) and np.any(other[1] < one[1] - hidden))

    return tuple(row[0] for row in rows if not any(beats(other, row) for other in rows))


def firsts(known: Sequence[Answered], merit: Callable[[Answered], float]) -> list[Answered]:
    """Return the design of least merit of each choice, the best choice first."""
    found: dict[tuple[int, ...], Answered] = {}
    for each in sorted(known, key=merit):
        if each.carried:
            found.setdefault(each.design.choice, each)
    return list(found.values())


def lost_values(
    asked: Requirements, search: Search, known: Sequence[Answered], finals: Sequence[Answered]
) -> tuple[Lost, ...]:
    """Return why other values of the lists were not taken; `finals` were solved finer, the best one first."""
    found, space, best = [], asked.space, finals[0]
    judged = {each.design.choice for each in finals}
    every = [*finals, *(each for each in known if each.design.choice not in judged)]
    for place, (key, values) in enumerate(space.lists.items()):
        for number, value in enumerate(values):
            own = [each for each in every if each.design.choice[place] == number]
            if own and number != best.design.choice[place]:
                first = min(own, key=lambda each: (search.merit(each), each.plain.get(STRAIN, np.inf)))
                found.append(Lost(key, str(value), space.words(first.design), why_not(search, first, best)))
    return tuple(found)


def why_not(search: Search, other: Answered, best: Answered) -> str:
    """Explain why a design is not taken for the best one."""
    if not other.carried:
        return other.reason
    task = search.task
    figures = task.figures(other)
    excess = task.excess(figures, other.table)
    known = [each for each in excess if each != "yield" and excess[each] > 0.0] or [*excess]
    name = max(known, key=lambda each: excess[each]) if excess else ""
    if name and excess[name] > 0.0:
        if name == "yield":
            shares = held_shares(task, other)
            rarest = min(shares, key=lambda each: shares[each])
            words = f"fewer than {100.0 * task.judge.share:.3g} % of the sensors made hold the limits"
            return f"{words}, {rarest} least: {100.0 * shares[rarest]:.3g} %"
        error = other.error.get(name, 0.0)
        unsure = f" +- {figure_words(name, error)}" if error > 0.0 else ""
        return f"{name} {figure_words(name, figures[name])}{unsure} against {figure_words(name, task.limits[name])}"
    own, least = task.objective(figures), task.objective(task.figures(best))
    if own - least < task.doubt(other) + task.doubt(best):
        return f"holds the limits, and is as good within the errors: what is minimised is {_more(own, least)}"
    words, promise = f"holds the limits, but what is minimised is {_more(own, least)}", _promised(search, other, best)
    more = f"{_more(promise, least)} is predicted of its best, which was not searched"
    return words if search.as_good(own, promise) else f"{words}; {more}"


def _promised(search: Search, found: Answered, best: Answered) -> float:
    """Return the merit that the choice of a design that was not taken may reach, by predictions.

    A step from it within its trust region, or as its solved designs compare with the best choice at the same places.
    """
    own, lead = map(search.branch_of, (found, best))
    there = [(search.merit(each), search.predicted(lead.prediction, each.point)) for each in own.prediction.solved]
    shares = [one / other for one, other in there if min(one, other) > 0.0]
    step = (own.promise or search.propose(own)).merit
    return min(step, search.merit(best) * min(shares)) if own is not lead and shares else step


def _more(value: float, least: float) -> str:
    """Return in words how much more a value is than the least one."""
    side = "more" if value > least else "less"
    return f"{100.0 * abs(value - least) / abs(least):.3g} % {side}" if least else "no less"


def tied_with(search: Search, others: Sequence[Answered], best: Answered, space: Space) -> tuple[str, ...]:
    """Return designs that are as good as the best one within the errors, in words, what each is best in, what differs.

    Of other choices those that their errors leave open; of its own those within what answers are known by, a tenth of
    the box apart.
    """
    task, found = search.task, list[Answered]()
    for each in others if task.minimised else ():
        own = each.design.choice == best.design.choice
        far = min(float(np.max(np.abs(each.point - one.point), initial=0.0)) for one in (best, *found)) > _APART
        if search.as_good(search.merit(each), search.merit(best)) and far if own else search.may_beat(each, best):
            found.append(each)
    every, words = [best, *found], list[str]()
    titles = _titles(task, every, space)
    for k, each in enumerate(found, 1):
        remarks = titles.get(k, []) + [f"{name} within its error" for name in task.undecided(each)]
        words.append(space.words(each.design) + (f" ({', '.join(remarks)})" if remarks else ""))
    return (*words, *([_apart(task, every)] if found else []))


def _titles(task: Task, tied: Sequence[Answered], space: Space) -> dict[int, list[str]]:
    """Return what each of tied designs is best in, by its number."""
    titles: dict[int, list[str]] = {}
    pads = [space.sensor(each.design).elastomer for each in tied]
    rows = {
        "thinnest": [each.plain["height"] for each in tied],
        "least silicone": [0.0 if pad is None else float(np.prod(pad.extent)) * pad.thickness for pad in pads],
        "farthest from limits": [task.worst(each) for each in tied],
    }
    for title, values in rows.items():
        titles.setdefault(int(np.argmin(values)), []).append(title)
    return titles


def _apart(task: Task, tied: Sequence[Answered]) -> str:
    """Return in words which figures tell tied designs apart, those that differ most beyond their errors."""
    rows, found = [task.figures(each) for each in tied], []
    for name in rows[0]:
        values = [row[name] for row in rows if name in row]
        error = max(each.error.get(name, 0.0) for each in tied)
        spread = float(np.ptp(values)) - 2.0 * error
        if name != INVERSE and spread > _DIFFERS * max(map(abs, values)):
            found.append((spread / max(map(abs, values)), name, values))
    first = sorted(found, key=lambda each: -each[0])[:3]
    named = [f"{name} {figure_words(name, min(own))} to {figure_words(name, max(own))}" for _, name, own in first]
    return f"told apart by {', '.join(named)}" if named else "told apart by a finer tolerance or a bench alone"


def made_share(task: Task, best: Answered) -> Share:
    """Return the share of the sensors made that hold every limit."""
    if best.table is None or not len(task.judge.deviations):
        return Share(np.nan, np.nan, np.nan)
    figures, each = task.figures(best), task.judge.excesses(best.table, _MANY)
    fixed = [name for name in figures if name not in each and not kind_of(name).scatters and name in task.limits]
    if any(over(name, figures[name], task.limits[name]) > 0.0 for name in fixed):
        return Share(0.0, 0.0, 0.0)
    off, none = task.errors(best), np.full(_MANY, -1.0)

    def held(side: float) -> float:
        """Return the share with every figure worse by its error, or better."""
        moved = (own + side * off.get(name, 0.0) for name, own in each.items())
        return float(np.mean(np.max([none, *moved], axis=0) <= 0.0))

    return Share(held(0.0), held(1.0), held(-1.0))


def guards(task: Task, best: Answered) -> dict[str, float]:
    """Return how much each figure that scatters may be by itself, so that the share `yield` of those made hold it.

    As far from the limit as the sensors made around the best design scatter: sizes by so much, others by such a share
    of themselves. An error, which is of that share, has none.
    """
    if best.table is None or not len(task.judge.deviations):
        return {}
    figures, found = task.figures(best), {}
    for name, own in task.judge.excesses(best.table, _MANY).items():
        here = figures[name] / task.limits[name]
        most = float(np.quantile(own + 1.0, task.judge.share))
        share = 1.0 - (most - here) if name.startswith(("height", "footprint")) else here / most
        if not name.startswith("error.") and share < 1.0 - _NOTHING:
            found[name] = share * task.limits[name]
    return found


def causes(asked: Requirements, task: Task, best: Answered) -> tuple[str, ...]:
    """Return in words what limits come from that are exceeded: noise by its parts, and what it must be for them."""
    repeated, found = asked.tolerance.get("repeatability"), []
    if best.table is None or repeated is None or not len(best.converter):
        return ()
    parts = task.judge.resolution_parts(best.table, best.converter)
    for name, (own, other) in parts.items():
        limit, value = task.limits.get(name, np.inf), float(np.hypot(own, other))
        if value <= limit:
            continue
        words = f"{name} {figure_words(name, value)}: {figure_words(name, other)} of it by repeatability, "
        words += f"{figure_words(name, own)} by the converter"
        if own < limit:
            most = 100.0 * repeated * float(np.sqrt(limit**2 - own**2)) / other
            unit = 10.0 ** (np.floor(np.log10(most)) - 1.0)  # two digits, rounded down: never a limit that does not do
            most = float(np.floor(most / unit) * unit)
            words += f"; for {figure_words(name, limit)} tolerance.repeatability must be at most {most:g} %"
        found.append(words)
    return tuple(found)


def held_shares(task: Task, best: Answered) -> dict[str, float]:
    """Return the share of the sensors made that hold each limit of a figure which scatters."""
    if best.table is None or not len(task.judge.deviations):
        return {}
    return {name: float(np.mean(own <= 0.0)) for name, own in task.judge.excesses(best.table, _MANY).items()}
