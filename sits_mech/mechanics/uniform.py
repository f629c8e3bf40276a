"""Strain a wide bonded layer as if it had no edges, at any strain: what films do.

Far from its edges, many thicknesses, silicone between two plates moves with its height alone,

    F = 1 + g e_x e_z + (l - 1) e_z e_z,        J = l,        P_xz(g, l) = F_x/A,    P_zz(g, l) = -F_z/A,

P = P_iso + K (J - 1) dJ/dF (element/kernel.py), A the area bonded to both plates. Of silicones i of thickness t_i, all
under one stress,

    d_h = sum_i t_i g_i,        sink = sum_i t_i (1 - l_i),

at small strain ``g = F_x/(A mu)``, ``1 - l = F_z/(A (K + 4/3 mu))``. Shear lifts the plate as well, by mu g**2/3 over
K + 4/3 mu. Both are found from small strain by Powell's method.

Edges, by small strain e_0 = q - (d_h, -sink), do at finite strain up to a share less or more. In 80 sections, 40 to 400
thicknesses wide, of neo-Hooke and of Yeoh's law of two silicones, sheared to 1, pressed by 80 mu and pulled by 5 mu,

    |e - e_0| <= 0.81 max|e_0|  of flush layers,    0.44 max|e_0|  of targets half as wide as their pads.

Range: boxes and cylinders under rectangles and discs of which one lies within the other, at least 30 thicknesses wide,
without swelling; stresses under which the law is stable. Neglected: edges, tilt. Source: R. S. Rivlin, Phil. Trans. R.
Soc. A 241 (1948) 379, for simple shear and its normal stress.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.closed_form import edges_share, is_film, plain_pad
from sits_mech.quantities import Array, Wrench
from sits_mech.scene.sensor import Elastomer, Sensor, Target
from sits_mech.silicone.energy import isochoric_energy
from sits_mech.silicone.kinematics import in_plane
from sits_mech.silicone.material import Silicone
from sits_mech.units import SLACK


class Uniform(NamedTuple):
    """Motion of the upper plate over a layer without edges, with that of small strain."""

    moved: Array  # d_h, d_z upwards, alpha, (3,) [m, rad]
    linear: Array  # alike
    each: tuple[float, ...]  # largest stretch, or reciprocal, of each silicone, from the ground up
    min_J: float
    share: float  # of what edges and tilt add at small strain, by which finite strain may change it


def uniform_layer(sensor: Sensor, load: Wrench, *, flat: bool = False) -> Uniform | None:
    """Return how a load in the plane moves the target over a layer without edges; None where none stands for the pad.

    `flat`: the load is spread over the pad's length, not the target's.
    """
    plain = plain_pad(sensor)
    if plain is None or not is_film(*plain):
        return None
    target, elastomer = plain
    area = min(target.extent[0], elastomer.extent[0]) * elastomer.extent[1] if flat else bonded_area(target, elastomer)
    if area is None:
        return None
    stress = np.array([load.F_x, -load.F_z]) / area
    moved, linear, stretches, J = np.zeros(3), np.zeros(3), list[float](), list[float]()
    for layer in elastomer.stack:
        mu, K = layer.silicone.shear_modulus, layer.silicone.bulk_modulus
        strain = uniform_strain(layer.silicone, stress)
        if strain is None:
            return None
        shear, height = strain[0], 1.0 + strain[1]
        moved[:2] += layer.thickness * strain
        linear[:2] += layer.thickness * stress / (mu, K + 4.0 / 3.0 * mu)
        within = in_plane(np.array([1.0, shear, 0.0, height])).principal().stretch
        stretches.append(float(np.max([within, 1.0 / within])))
        J.append(float(height))
    return Uniform(moved, linear, tuple(stretches), min(J), edges_share(target, elastomer))


def bonded_area(target: Target, elastomer: Elastomer) -> float | None:
    """Return the area bonded to target and ground [m^2]; None where neither outline lies within the other."""
    own, other = target.extent, elastomer.extent
    round_target, round_pad = target.is_round, elastomer.is_round
    if round_target == round_pad:
        a, b = map(min, own, other)
        return 0.25 * math.pi * a * b if round_target else a * b
    rectangle, diameter = (other, own[0]) if round_target else (own, other[0])
    if diameter <= min(rectangle):
        return 0.25 * math.pi * diameter**2
    return rectangle[0] * rectangle[1] if math.hypot(*rectangle) <= diameter else None


def uniform_strain(silicone: Silicone, stress: Array) -> Array | None:
    """Return g and l - 1 under the stresses P_xz and P_zz, shape (2,) [Pa]; None where the silicone holds less."""
    from scipy.optimize import root

    mu, K = silicone.shear_modulus, silicone.bulk_modulus / silicone.shear_modulus
    energy, own = isochoric_energy(silicone), [1, 3]

    def forces(strain: Array) -> tuple[Array, Array]:
        """Return the stress beyond what is given [mu] and the tangent."""
        _, P, A = energy(in_plane(np.array([[1.0, strain[0], 0.0, 1.0 + strain[1]]])))
        return P[0, own] + (0.0, K * strain[1]) - stress / mu, A[0][np.ix_(own, own)] + np.diag([0.0, K])

    with np.errstate(all="ignore"):
        found = root(forces, stress / mu / (1.0, K + 4.0 / 3.0), jac=True)
        left, tangent = forces(found.x)
    stands = np.linalg.norm(left) <= SLACK and np.linalg.eigvalsh(tangent)[0] > 0.0
    return np.asarray(found.x) if stands else None
