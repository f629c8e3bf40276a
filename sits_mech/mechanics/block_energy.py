"""The pad's law in three dimensions, by the names that the pad's files have for silicone/energy.py.

``H = cof F = dJ/dF`` and ``L = dH/dF``, components numbered ``3 i + j``; energies in initial shear moduli.
"""

from __future__ import annotations

from typing import NamedTuple

from sits_mech.quantities import Array
from sits_mech.silicone.energy import Energy, isochoric_energy
from sits_mech.silicone.kinematics import in_space

SolidEnergy = Energy
solid_energy = isochoric_energy


class SolidState(NamedTuple):
    """A deformation: F and ``H = dJ/dF``, shape (..., 9), ``L = dH/dF``, shape (..., 9, 9), and J, shape (...)."""

    F: Array
    H: Array
    L: Array
    J: Array


def turning(F: Array) -> Array:
    """Return ``L(F) = dH/dF``, shape (..., 9, 9), of F, shape (..., 9)."""
    return in_space(F).L


def cofactor(F: Array) -> Array:
    """Return ``H = dJ/dF`` of F, both of shape (..., 9)."""
    return in_space(F).H


def stress_and_tangent(law: SolidEnergy, F: Array) -> tuple[Array, Array, Array, SolidState]:
    """Return energy density (...), stress P (..., 9) and tangent A (..., 9, 9) of a law at F, and the deformation.

    Parameters
    ----------
    law : callable
        From `solid_energy`.
    F : ndarray, shape (..., 9)
        Deformation gradient; ``det F > 0``.
    """
    point = in_space(F)
    return *law(point), SolidState(F, point.H, point.L, point.J)
