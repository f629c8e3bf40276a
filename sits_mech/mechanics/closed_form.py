"""Closed forms of a bonded layer: thin limits, edge corrections, the corner, one exact moment.

A strip of width w and thickness t between two rigid plates, plane strain, small strain, shape factor ``S = w/(2 t)``.
Where the layer is thin (S large) the pressure follows the lubrication equation of a slightly compressible solid,

    p/K - t**2/(12 mu) p'' = e(x),        p = 0 at x = +-w/2,

with the local compression ``e = sink/t`` or ``e = theta x/t``. With ``y = sqrt(12 mu/K) S`` its solutions give

    E_c = K (1 - tanh(y)/y)                      -> 4 mu S**2      for K -> infinity
    E_b = 3 K (1/3 - coth(y)/y + 1/y**2)         -> 4/5 mu S**2
    k_x = mu (w - 0.2308 t)/t

E_c is force over (w sink/t), E_b moment over (w**3/12 theta/t), k_x force over shear displacement with the tilt held,
all per depth. Neglected in E_c and E_b: terms of relative order 1/S from the edges, and mu beside K.

Sources: A. N. Gent, P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111; J. M. Kelly, Earthquake-Resistant Design with
Rubber (1997), chapters 4 and 5; M. L. Williams, J. Appl. Mech. 19 (1952) 526 for the corner. The length 0.2308 t of
the shear edges comes from graded P2-P1 finite elements.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Sensor

SHEAR_EDGES = 0.2308  # thicknesses by which the two free edges shorten an incompressible strip in shear
LONG = 10.0
"""Least length over width of a pad, or of a target, for a planar model."""


def compression_modulus(shear_modulus: float, bulk_modulus: float, shape_factor: float) -> float:
    """Return the apparent modulus of a thin bonded strip in compression, force over ``w sink/t`` [Pa].

    `bulk_modulus` may be infinite; the thin limit is off by terms of relative order 1/shape_factor (half
    width/thickness).
    """
    y = _decay(shear_modulus, bulk_modulus, shape_factor)
    if y < 1e-2:
        return 4.0 * shear_modulus * shape_factor**2 * (1.0 - 0.4 * y**2)
    return bulk_modulus * (1.0 - float(np.tanh(y)) / y)


def tilt_modulus(shear_modulus: float, bulk_modulus: float, shape_factor: float) -> float:
    """Return the apparent modulus of a thin strip in tilt about mid-height, moment over ``w**3/12 theta/t`` [Pa].

    `bulk_modulus` may be infinite; the thin limit is off by terms of relative order 1/shape_factor (half
    width/thickness).
    """
    y = _decay(shear_modulus, bulk_modulus, shape_factor)
    if y < 3e-2:
        return 0.8 * shear_modulus * shape_factor**2 * (1.0 - 2.0 / 21.0 * y**2)
    return 3.0 * bulk_modulus * (1.0 / 3.0 - 1.0 / (y * float(np.tanh(y))) + 1.0 / y**2)


def shear_stiffness(shear_modulus: float, width: float, thickness: float) -> float:
    """Return the shear stiffness of an incompressible bonded strip, tilt held, per depth [Pa]; width >= thickness."""
    return shear_modulus * (width / thickness - SHEAR_EDGES)


def corner_exponent(poisson: float, angle: float = 0.5 * np.pi) -> float:
    """Return the exponent k of the displacement ``r**k`` at a corner between a clamped and a free face, plane strain.

    The smallest root of ``sin(k angle)**2 = ((kappa + 1)**2/4 - k**2 sin(angle)**2)/kappa`` with ``kappa = 3 - 4 nu``;
    stresses grow as ``r**(k - 1)``, and a quantity of the energy converges as ``h**(2 k)`` on uniform meshes. Raise
    ValueError for nu outside 0..0.5, an angle above pi/2, or a corner that is not singular.
    """
    from scipy.optimize import brentq

    if not 0.0 <= poisson <= 0.5 or not 0.0 < angle <= 0.5 * np.pi:
        raise ValueError(f"corner: Poisson's ratio 0..0.5 and angle 0..pi/2 are covered, not {poisson} and {angle}")
    kappa = 3.0 - 4.0 * poisson

    def gap(k: float) -> float:
        return float(np.sin(k * angle) ** 2 - ((kappa + 1.0) ** 2 / 4.0 - (k * np.sin(angle)) ** 2) / kappa)

    if gap(1.0) <= 0.0:
        raise ValueError(f"corner: not singular at Poisson's ratio {poisson} and angle {angle}")
    return float(brentq(gap, 0.0, 1.0, xtol=1e-14))


def small_strain_bound(sink: float, shear: float, edge: float) -> float:
    """Bound the relative error of one linear compliance; displacements over the layer's thickness.

    `edge` is the displacement of the target's ends by its tilt. The neglected terms are of first order in the strain;
    the factors are checked against finite strain by the plan's test.
    """
    return 3.0 * abs(sink) + 0.5 * (abs(shear) + abs(edge))


def holding_moment(wrench: Wrench, d_h: float, gap: float) -> float:
    """Return the moment about the plate's centre that holds the tilt of a centrally symmetric block at zero [N m].

    Exact at any strain for any law: the two plates carry equal moments by symmetry, and the block is in balance. Forces
    act at the centre of the bonded face; `d_h` and `gap` (distance from the ground) are those of the deformed state
    [m].
    """
    return -0.5 * (wrench.F_x * gap + wrench.F_z * d_h)


def _decay(shear_modulus: float, bulk_modulus: float, shape_factor: float) -> float:
    """Return the half width over the decay length of the pressure in a thin layer."""
    if not shear_modulus > 0.0 or not bulk_modulus > 0.0 or not shape_factor > 0.0:
        raise ValueError(
            "strip: moduli and shape factor must be positive, "
            f"got mu = {shear_modulus}, K = {bulk_modulus}, S = {shape_factor}"
        )
    return float(np.sqrt(12.0 * shear_modulus / bulk_modulus) * shape_factor)


def finite_strain_model(sensor: Sensor) -> str:
    """Return the model for finite strains: "planar" for a long pad, "block" for any other."""
    elastomer = sensor.elastomer
    return "planar" if elastomer is None or elastomer.extent[1] >= LONG * elastomer.extent[0] else "block"
