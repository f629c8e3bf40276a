"""Fields of coils and of bodies far away: bounds on these, in closed form.

A flat loop of 1 A is a sheet of dipoles over its area. No dipole m has more than m/(2 pi d^3) at a distance d, so that
at R from the middle of rings of radius a_k, the farthest of which is b away from there,

    |H| <= sum_k pi a_k^2 / (2 pi (R - b)^3).                                                               (1)

A body stands in a field as the ellipsoids and the ball around it; their alpha and N_i are those of `remote`.

Source: Jackson, Classical Electrodynamics, section 5.6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0
from scipy.special import elliprd

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.ring_field import coil_potential
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil, Conductor, Target

_STRETCH = (1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 9.0, 17.0, 33.0)  # (height of an ellipsoid over the plate's)^2
ROUND, _UP = 16, 8  # points on a ball


def coil_field(coil: Coil, points: Array, step: float) -> Array:
    """Return H of a coil for 1 A at points, from its vector potential a step to all sides, shape (n, 3) [1/m]."""
    far = coil.outer_diameter / 4.0
    slope = [
        (coil_potential(coil, points + way, far) - coil_potential(coil, points - way, far)) / (2.0 * step * mu_0)
        for way in step * np.eye(3)
    ]
    (_, y_x, z_x), (x_y, _, z_y), (x_z, y_z, _) = (each.T for each in slope)
    return np.column_stack([z_y - y_z, x_z - z_x, y_x - x_y])


def field_bound(coil: Coil, distance: float) -> float:
    """Return the largest |H| of a round coil at and beyond a distance from the middle of its top [1/m], by formula (1).

    Infinite where the distance is within the coil, or the coil is not round.
    """
    reach = math.hypot(0.5 * coil.outer_diameter, coil.height)
    if not coil.is_round or distance <= reach:
        return math.inf
    return float((coil_sections(coil).radius ** 2).sum()) / (2.0 * (distance - reach) ** 3)


@dataclass(frozen=True)
class Body:
    """What stands for a body: alpha of some ellipsoids (e, 3) [m^3], the ball's radius [m], whether it is permeable."""

    alpha: Array
    radius: float
    permeable: bool

    @property
    def volume(self) -> float:
        """Volume of the ball [m^3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

    def strength(self, middle: Array, others: Array, weight: Array) -> Array:
        """Return formula (1) of `remote` over sqrt(mu0), from the field at the middle (..., 3), on it (..., n, 3)."""
        uniform = np.sqrt((middle**2 @ self.alpha.T).min(axis=-1))
        mean = ((others - middle[..., None, :]) ** 2).sum(axis=-1) @ weight
        return np.asarray(uniform + np.sqrt((1.5 if self.permeable else 1.0) * self.volume * mean))


def ball_of(radius: float, permeable: bool) -> Body:
    """Return a ball as a body."""
    return Body(np.full((1, 3), (4.0 if permeable else 2.0) * np.pi * radius**3), radius, permeable)


def body_around(plate: Target | Conductor) -> Body:
    """Return the ellipsoids and the ball around a plate; the ball alone of one that is turned."""
    stretch, is_round = np.array(_STRETCH), plate.diameter is not None
    lateral = stretch / (stretch - 1.0) * (1.0 if is_round else 2.0)
    half = 0.5 * np.array([*plate.extent, plate.thickness])
    a, b, c = half[:, None] * np.sqrt(np.stack([lateral, lateral, stretch]))
    N = a * b * c / 3.0 * np.stack([elliprd(b**2, c**2, a**2), elliprd(c**2, a**2, b**2), elliprd(a**2, b**2, c**2)])
    permeable = plate.metal.relative_permeability != 1.0
    radius = math.hypot(*half[1 if is_round else 0 :])
    if isinstance(plate, Conductor) and plate.is_turned:
        return ball_of(radius, permeable)
    share = np.maximum(1.0 / (1.0 - N), 1.0 / N if permeable else 0.0)
    return Body((4.0 / 3.0 * np.pi * a * b * c * share).T, radius, permeable)


def sphere() -> tuple[Array, Array]:
    """Return points on the unit ball, shape (n, 3), and their weights, which add up to 1."""
    up, weight = np.polynomial.legendre.leggauss(_UP)
    angle = np.tile(2.0 * np.pi * np.arange(ROUND) / ROUND, _UP)
    z = np.repeat(up, ROUND)
    flat = np.sqrt(1.0 - z**2)
    return np.column_stack([flat * np.cos(angle), flat * np.sin(angle), z]), np.repeat(weight, ROUND) / (2 * ROUND)


def dipole_field(m: Array, r: Array) -> Array:
    """Return H of a moment at the origin at places r, both shape (..., 3)."""
    square = (r**2).sum(axis=-1, keepdims=True)
    return np.asarray((3.0 * (m * r).sum(axis=-1, keepdims=True) * r / square - m) / (4.0 * np.pi * square**1.5))
