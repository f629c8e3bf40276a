"""Differentiate a smooth function from a few values: differences of the fourth order, with their error.

With values y_m at m steps h from where the slope is asked,

    y' = sum_m w_m y_m / h,    error: a y_4 / h,    y_4 = sum_m c_m y_m,

where y_4 is the fourth difference: of order h^4 where y is smooth, so that the error is far above that of the slope,
h^4 y'''''; of noise, or of a jump between two of the places, it is their size, and the error holds what they do to the
slope. A jump on one side leaves the slope of the other side. `FIRST` is the simple quotient, of first order;
`SECOND_ORDER` are those of three places, on both sides and on each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array

_FOURTH = (1.0, -4.0, 6.0, -4.0, 1.0)  # c


@dataclass(frozen=True)
class Stencil:
    """A difference formula; scene/parameters.py has the scenes at its places."""

    places: tuple[int, ...]  # m
    weights: tuple[float, ...]  # 12 w
    trust: float = 0.0  # a: slope error of a jump between places over the fourth difference; 0 if none

    @property
    def shares(self) -> dict[int, float]:
        """Weights w of the values for a step of one."""
        return {place: weight / 12.0 for place, weight in zip(self.places, self.weights, strict=True)}

    def slope(self, values: Mapping[int, Array], step: float | Array) -> Array:
        """Return the slope of values by their places, `step` apart."""
        return np.asarray(sum(share * values[place] for place, share in self.shares.items()) / step)

    def error(self, values: Mapping[int, Array], step: float | Array) -> Array:
        """Return the error of the slope."""
        fourth = sum(c * values[place] for place, c in zip(self.places, _FOURTH, strict=True)) if self.trust else 0.0
        return self.trust * np.abs(fourth) / step


FIRST = Stencil((0, 1), (-12.0, 12.0))
SECOND_ORDER = (
    Stencil((-1, 0, 1), (-6.0, 0.0, 6.0)),
    Stencil((0, 1, 2), (-18.0, 24.0, -6.0)),
    Stencil((0, -1, -2), (18.0, -24.0, 6.0)),
)
CENTRAL = Stencil((-2, -1, 0, 1, 2), (1.0, -8.0, 0.0, 8.0, -1.0), 0.25)
WIDE = Stencil((-4, -2, 0, 2, 4), (0.5, -4.0, 0.0, 4.0, -0.5), 0.125)
FORWARD = Stencil((0, 1, 2, 3, 4), (-25.0, 48.0, -36.0, 16.0, -3.0), 2.5)
BACKWARD = Stencil((0, -1, -2, -3, -4), (25.0, -48.0, 36.0, -16.0, 3.0), 2.5)


def best_slopes(parts: Sequence[Mapping[int, Array]], step: float, sizes: Sequence[float]) -> tuple[Array, float]:
    """Return slopes, then errors, (2 k, ...), of the fourth-order stencil of least error, and its worst error.

    `parts`: values of k functions by place, some or all of those the stencils take; `sizes` scale the errors of each.
    """
    found: list[tuple[float, Array]] = []
    for stencil in (CENTRAL, WIDE, FORWARD, BACKWARD):
        if all(place in parts[0] for place in stencil.places):
            error = [stencil.error(part, step) for part in parts]
            worst = max(float(own.max()) / size for own, size in zip(error, sizes, strict=True))
            found.append((worst, np.stack([*(stencil.slope(part, step) for part in parts), *error])))
    worst, best = min(found, key=lambda one: one[0])
    return best, worst
