"""Hold what is known of solved designs, and judge them by limits and goals.

A design that carries the overload has a table of inductances with its derivatives by the numbers between bounds and by
the tolerances; one that does not has a reason. ``plain`` are figures that no table is needed for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.required.kinds import figure_words, kind_of
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.solved.figures import Judge, Table

_ROUNDING = 1e-9  # of a limit: sizes are sums and differences of written numbers
LEAST_INVERSE = 0.05
"""Of the figure `INVERSE`: what is below is one load for each reading by luck."""


@dataclass(frozen=True)
class Answered:
    """A design with its solution."""

    design: Design
    reason: str  # why it has no table; "" where it has one
    table: Table | None
    by_x: Array  # (v, g, n), derivatives of L by coordinates of the unit box [H]
    plain: dict[str, float]  # figures without a table, `STRAIN` among them
    plain_by_x: dict[str, Array]  # their derivatives (v,), where known
    error: dict[str, float] = field(default_factory=dict)  # of each figure, where known
    seconds: float = 0.0  # of the processor
    converter: Array = field(default_factory=lambda: np.zeros(0))  # (n,) noise of the converter alone [H]

    @property
    def carried(self) -> bool:
        """Whether it was solved, with no reason against it."""
        return not self.reason

    @cached_property
    def point(self) -> Array:
        """The coordinates in the unit box, shape (v,)."""
        return np.array(self.design.x, dtype=float)


@dataclass(frozen=True)
class Task:
    """The limits and minimised figures of a search."""

    judge: Judge
    limits: dict[str, float]  # of figures, `STRAIN` and `INVERSE` among them
    minimised: dict[str, float]  # weights of figures that are minimised; empty: any design within all limits
    sizes: dict[str, float] = field(default_factory=dict)  # figures of any design, scales of those without a limit
    weighed: dict[str, float] = field(default_factory=dict)  # limits that scale the others; those above by default
    floors: dict[str, float] = field(default_factory=dict)  # of minimised figures: errors, below which none ranks
    tolerance: float = 0.0  # relative, of the figures that are searched by

    def figures(self, found: Answered) -> dict[str, float]:
        """Return all figures of a design, solved or predicted."""
        return found.plain | ({} if found.table is None else self.judge.figures(found.table))

    def excess(self, figures: dict[str, float], table: Table | None) -> dict[str, float]:
        """Return by how much each limit is exceeded, over the limit; not positive where it holds.

        Where sensors made scatter, the share of those that hold the limits of resolution and error must reach
        ``yield``.
        """
        found = {name: over(name, figures[name], limit) for name, limit in self.limits.items() if name in figures}
        if table is not None and len(self.judge.deviations):
            found["yield"] = float(np.quantile(self.judge.excess(table), self.judge.share))
        return found

    def errors(self, found: Answered) -> dict[str, float]:
        """Return the error of each excess, where known; the yield's by the worst of its limits."""
        each = {name: found.error.get(name, 0.0) / abs(limit) for name, limit in self.limits.items()}
        scattering = [name for name in each if kind_of(name).scatters]
        return each | {"yield": max((each[name] for name in scattering), default=0.0)}

    def undecided(self, found: Answered) -> tuple[str, ...]:
        """Return the limits within the errors of a solved design's figures."""
        off, excess = self.errors(found), self.excess(self.figures(found), found.table)
        return tuple(name for name, value in excess.items() if abs(value) < off.get(name, 0.0))

    def doubt(self, found: Answered) -> float:
        """Return the error of what is minimised."""
        each = (weight * found.error.get(name, 0.0) / self.scale(name) for name, weight in self.minimised.items())
        return float(sum(each))

    def scale(self, name: str) -> float:
        """Return what a minimised figure is taken over: its limit, else its size."""
        return abs((self.sizes | (self.weighed or self.limits)).get(name, 1.0))

    def worst(self, found: Answered) -> float:
        """Return the excess of the limit that a solved design exceeds most, over it; not positive where all hold."""
        return max(self.excess(self.figures(found), found.table).values(), default=-1.0)

    def holds(self, found: Answered) -> bool:
        """Return whether a solved design holds every limit."""
        return found.carried and self.worst(found) <= 0.0

    def objective(self, figures: dict[str, float]) -> float:
        """Return what is minimised: figures over their limits, or over their sizes, by their weights.

        A figure below its own error counts as that: which of two such ones is less is not known.
        """
        known = {name: max(figures[name], self.floors.get(name, -np.inf)) for name in self.minimised}
        return sum(w * kind_of(name).sign * known[name] / self.scale(name) for name, w in self.minimised.items())

    def contradicting(self, rows: Sequence[dict[str, float]]) -> tuple[str, ...]:
        """Return in words the pairs of limits that some designs hold each, and none both, by figures of them."""
        held = {
            name: [row for row in rows if name in row and over(name, row[name], limit) <= 0.0]
            for name, limit in self.limits.items()
        }
        words = list[str]()
        for one, other in combinations((name for name, own in held.items() if own), 2):
            reached = [row[other] for row in held[one] if other in row]
            if reached and not any(row in held[other] for row in held[one]):
                limit = self.limits[other]
                nearest = min(reached, key=lambda value: over(other, value, limit))
                least = f"with the first {other} comes to {figure_words(other, nearest)} against"
                both = "no design holds both, solved or predicted"
                words.append(f"{one} and {other}: {both}; {least} {figure_words(other, limit)}")
        return tuple(words)

    def learned(self, found: Answered) -> Task:
        """Return the task with what a solved design tells: the sizes of figures, and their errors."""
        sizes = self.sizes or self.figures(found)
        floors = {name: error for name in self.minimised if np.isfinite(error := found.error.get(name, np.nan))}
        floors = {name: min(error, self.floors.get(name, error)) for name, error in floors.items()}
        return replace(self, sizes=sizes, floors=self.floors | floors)


def over(name: str, value: float, limit: float) -> float:
    """Return by how much a figure exceeds its limit, over the limit; nothing where that is rounding."""
    if not np.isfinite(value):
        return 1e3
    excess = kind_of(name).sign * float(value - limit) / abs(limit)
    return excess if abs(excess) > _ROUNDING else 0.0
