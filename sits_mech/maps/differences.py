"""How does a smooth function change, by a few of its values? Differences of the fourth order, and their error.

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
    """Places, and what their values are multiplied by.

    Of numbers alone; scene/parameters.py has the scenes at such places.

    Attributes
    ----------
    places : tuple of int
        m.
    weights : tuple of float
        w, times 12.
    trust : float
        a: more than a jump between any two places makes of the slope over the fourth difference; 0 where there is none.
    """

    places: tuple[int, ...]
    weights: tuple[float, ...]
    trust: float = 0.0

    @property
    def shares(self) -> dict[int, float]:
        """What the value at each place adds to a slope, for a step of one: w."""
        return {place: weight / 12.0 for place, weight in zip(self.places, self.weights, strict=True)}

    def slope(self, values: Mapping[int, Array], step: float | Array) -> Array:
        """Return the slope of values by their places, `step` apart."""
        return np.asarray(sum(share * values[place] for place, share in self.shares.items()) / step)

    def error(self, values: Mapping[int, Array], step: float | Array) -> Array:
        """Return how far that may be off."""
        fourth = sum(c * values[place] for place, c in zip(self.places, _FOURTH, strict=True)) if self.trust else 0.0
        return np.asarray(self.trust * np.abs(fourth) / step)


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


def best_slopes(
    parts: Sequence[Mapping[int, Array]], step: float, sizes: Sequence[float]
) -> tuple[Array, float]:  # fmt: skip
    """Return slopes by the stencil of the fourth order that has the least error, and its worst error over the sizes.

    Parameters
    ----------
    parts : sequence of mapping
        Values of k functions by their places, some or all of those that the stencils take.
    step : float
    sizes : sequence of float
        What the errors of each function are measured by.

    Returns
    -------
    ndarray, shape (2 k, ...), and float
        Slopes, then their errors.
    """
    found: list[tuple[float, Array]] = []
    for stencil in (CENTRAL, WIDE, FORWARD, BACKWARD):
        if all(place in parts[0] for place in stencil.places):
            error = [stencil.error(part, step) for part in parts]
            worst = max(float(own.max()) / size for own, size in zip(error, sizes, strict=True))
            found.append((worst, np.stack([*(stencil.slope(part, step) for part in parts), *error])))
    worst, best = min(found, key=lambda one: one[0])
    return best, worst
