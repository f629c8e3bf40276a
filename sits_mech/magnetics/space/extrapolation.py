"""Extrapolate a sequence of ever finer discretisations to its limit, and estimate the error.

On levels with cells divided into m_1 < m_2 < m_3 parts along each axis a result behaves like ``y_m = y + a m^-p``, with
differences d_1 and d_2 and the limit

    q = d_1 / d_2 = (m_1^-p - m_2^-p) / (m_2^-p - m_3^-p),    Y = y_3 + d_2 / ((m_3/m_2)^p - 1).

The limit is linear in the levels, so that it is as smooth over poses and frequencies as they are. How far the
differences are from showing the order p is in its error.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.quantities import Array

_MISSED, _NEXT = 0.5, 0.15  # error over what the last difference is off the order, and over what is added


def added(values: Sequence[Array], sizes: Sequence[float], order: float) -> tuple[Array, Array]:
    """Return the extrapolated rest ``Y - y_3`` of three levels, coarsest first, and its error, entry by entry.

    Where the first two of the m in `sizes` are equal, no order is shown, and the error is all of the rest.
    """
    d1, d2 = (after - before for before, after in zip(values[:-1], values[1:], strict=True))
    more = np.asarray(d2 / ((sizes[2] / sizes[1]) ** order - 1.0))
    if sizes[0] == sizes[1]:
        return more, np.abs(more)
    a, b, c = np.asarray(sizes, dtype=float) ** np.full(3, -order)
    missed = d2 - d1 / ((a - b) / (b - c))
    return more, np.asarray(_MISSED * np.abs(missed) + _NEXT * np.abs(more))
