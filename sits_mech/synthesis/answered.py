"""What is known of a design that was solved, and of one that was not?

A design that carries the overload has a table of inductances with its derivatives by the numbers between bounds and by
the tolerances; one that does not has a reason. ``plain`` are figures that no table is needed for.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.figures import INVERSE, Judge, Table
from sits_mech.synthesis.requirements import LEAST, SCATTERING
from sits_mech.synthesis.space import Design

STRAIN = "strain"
"""Largest strain of the silicone under the overload, over what is known of it: at most one."""
LEAST_INVERSE = 0.05
"""Of the figure `INVERSE`: what is below is one load for each reading by luck."""


@dataclass(frozen=True)
class Answered:
    """A design with what came of it.

    Attributes
    ----------
    design : Design
    reason : str
        Why it has no table; "" where it has one.
    table : Table or None
    by_x : ndarray, shape (v, g, n)
        Derivatives of the table's inductances by the coordinates of the unit box [H].
    plain : dict
        Figures without a table, `STRAIN` among them.
    plain_by_x : dict
        Their derivatives, shape (v,), where they are known.
    error : dict
        Estimated error of each figure, where it is known.
    seconds : float
        Of the processor.
    """

    design: Design
    reason: str
    table: Table | None
    by_x: Array
    plain: dict[str, float]
    plain_by_x: dict[str, Array]
    error: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0

    @property
    def carried(self) -> bool:
        """Whether it was answered."""
        return not self.reason

    @cached_property
    def point(self) -> Array:
        """Coordinates in the unit box, shape (v,)."""
        return np.array(self.design.x, dtype=float)


@dataclass(frozen=True)
class Task:
    """What a search is for.

    Attributes
    ----------
    judge : Judge
    limits : dict
        Of figures, `STRAIN` and `INVERSE` among them.
    goal : dict
        Weights of the figures that are minimised; empty: any design that holds all limits.
    sizes : dict
        Figures of any design, over which those without a limit are weighed.
    weighed : dict
        Limits over which the others are weighed; those above by default.
    """

    judge: Judge
    limits: dict[str, float]
    goal: dict[str, float]
    sizes: dict[str, float] = field(default_factory=dict)
    weighed: dict[str, float] = field(default_factory=dict)

    def figures(self, table: Table | None, plain: dict[str, float]) -> dict[str, float]:
        """Return all figures of a design, known or predicted."""
        return plain | ({} if table is None else self.judge.figures(table))

    def excess(self, figures: dict[str, float], table: Table | None) -> dict[str, float]:
        """Return by how much each limit is exceeded, over the limit; not positive where it holds.

        Where sensors made scatter, so many must hold the limits of resolution and error, ``yield``, as the share says.
        """
        found = {name: over(name, figures[name], limit) for name, limit in self.limits.items() if name in figures}
        if table is not None and len(self.judge.deviations):
            found["yield"] = float(np.quantile(self.judge.excess(table), self.judge.share))
        return found

    def errors(self, found: Answered) -> dict[str, float]:
        """Return how far each excess may be off, where that is known; the yield's by the worst of its limits."""
        each = {name: found.error.get(name, 0.0) / abs(limit) for name, limit in self.limits.items()}
        scattering = [name for name in each if name.partition(".")[0] in SCATTERING]
        return each | {"yield": max((each[name] for name in scattering), default=0.0)}

    def undecided(self, found: Answered) -> tuple[str, ...]:
        """Return the limits of which the errors of a solved design leave open whether they hold."""
        off, excess = self.errors(found), self.excess(self.figures(found.table, found.plain), found.table)
        return tuple(name for name, value in excess.items() if abs(value) < off.get(name, 0.0))

    def doubt(self, found: Answered) -> float:
        """Return the error of what is minimised."""
        size = self.sizes | (self.weighed or self.limits)
        each = (weight * found.error.get(name, 0.0) / abs(size.get(name, 1.0)) for name, weight in self.goal.items())
        return float(sum(each))

    def holds(self, found: Answered) -> bool:
        """Say whether a solved design holds every limit."""
        excess = self.excess(self.figures(found.table, found.plain), found.table)
        return found.carried and max(excess.values(), default=-1.0) <= 0.0

    def aim(self, figures: dict[str, float]) -> float:
        """Return what is minimised: figures over their limits, or over their sizes, by their weights."""
        size = self.sizes | (self.weighed or self.limits)
        return sum(
            weight * (-1.0 if name in LEAST else 1.0) * figures[name] / abs(size.get(name, 1.0))
            for name, weight in self.goal.items()
        )  # fmt: skip


def over(name: str, value: float, limit: float) -> float:
    """Return by how much a figure exceeds its limit, over the limit."""
    if not np.isfinite(value):
        return 1e3
    lower = name in LEAST or name == INVERSE
    return float((limit - value if lower else value - limit) / abs(limit))
