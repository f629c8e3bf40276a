"""What is given of the target: a force, or a place? Any mix of the two.

Of each pair (F_x, d_h), (F_z, sink), (M, alpha) one is given, the other is found. A layer whose load has a largest
value (it buckles, or softens) is followed past it with places given; a target held upright is ``alpha = 0`` with M
found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.mechanics.newton import Held
from sits_mech.quantities import Array, Wrench

_PAIRS = (("F_x", "d_h"), ("F_z", "sink"), ("M", "alpha"))


@dataclass(frozen=True)
class Control:
    """What is given of each pair; of a pair of which nothing is given the force is zero.

    Attributes
    ----------
    F_x, F_z, M : float or None
        Forces and moment, as of `Wrench` [N, N m].
    d_h, sink, alpha : float or None
        Shear along +x, downward displacement [m], clockwise rotation [rad] of the target's bottom face.
    """

    F_x: float | None = None
    F_z: float | None = None
    M: float | None = None
    d_h: float | None = None
    sink: float | None = None
    alpha: float | None = None

    def __post_init__(self) -> None:
        """Refuse a pair of which both are given, and what is no number."""
        for force, place in _PAIRS:
            given = [value for value in (getattr(self, force), getattr(self, place)) if value is not None]
            if len(given) > 1:
                raise ValueError(f"control: of {force} and {place} one must be given, got both")
            if given and not np.isfinite(given[0]):
                name = force if getattr(self, place) is None else place
                raise ValueError(f"control: {name} must be a finite number, got {given[0]}")

    @property
    def held(self) -> Held:
        """Which places are given instead of the forces, shape (3,)."""
        return np.array([getattr(self, place) is not None for _, place in _PAIRS])

    def goal(self, thickness: float, unit: float) -> Array:
        """Return what is given, scaled as in body.py: a force, or d_h, d_z = -sink, alpha where held.

        Parameters
        ----------
        thickness : float
            [m].
        unit : float
            Force that scales to one [N].
        """
        forces = np.array([getattr(self, force) or 0.0 for force, _ in _PAIRS]) / unit / [1.0, 1.0, thickness]
        places = np.array([getattr(self, place) or 0.0 for _, place in _PAIRS]) / [thickness, -thickness, 1.0]
        return np.where(self.held, places, forces)


def under(wrench: Wrench) -> Control:
    """Return the control that gives all forces."""
    return Control(F_x=wrench.F_x, F_z=wrench.F_z, M=wrench.M)
