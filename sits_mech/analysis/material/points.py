"""Measured points of a silicone's tests in uniform states, with their weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import principal_stretches


@dataclass(frozen=True)
class MeasuredPoints:
    """Measured points."""

    stretches: Array  # principal, (n, 3)
    stress: Array  # engineering, (n,) [Pa]
    weight: Array  # square root of the weight, (n,)
    specimen: Array  # of each point, 0, 1, ... (n,); all 0 where a mode has one alone

    @property
    def scale(self) -> float:
        """Secant modulus at the largest stretch [Pa]."""
        last = int(np.argmax(self.stretches[:, 0]))
        return float(self.stress[last] / (self.stretches[last, 0] - 1.0))

    @property
    def excess(self) -> Array:
        """I1 - 3 of every point, shape (n,)."""
        found: Array = (self.stretches**2).sum(axis=1) - 3.0
        return found

    @property
    def tension_alone(self) -> bool:
        """Whether all points are of uniaxial tension."""
        return bool(np.allclose(self.stretches[:, 1], self.stretches[:, 2]))

    def ends(self) -> dict[str, tuple[float, float]]:
        """Return the uniaxial and planar stretches with the largest I1 of the points."""
        most = float(self.excess.max())

        def beyond(stretch: float, mode: str) -> float:
            """Return a state's I1 less the largest."""
            return float((principal_stretches(mode, np.array([stretch])) ** 2).sum()) - 3.0 - most

        reach = 2.0 + np.sqrt(most)
        return {
            mode: (brentq(beyond, 1e-3 / reach**2, 1.0, (mode,)), brentq(beyond, 1.0, reach, (mode,)))
            for mode in ("uniaxial", "planar")
        }
