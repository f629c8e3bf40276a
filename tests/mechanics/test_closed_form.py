"""Closed forms of a bonded strip: their limits, tabulated strips, and the layer model against them."""

from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq

from sits_mech.mechanics.closed_form import compression_modulus, shear_stiffness, small_strain_bound, tilt_modulus
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.material import silicone_from


def strip(S, K, w=None):
    """A flush strip one metre thick and long, of unit shear modulus, loaded at the bonded face."""
    width = 2.0 * S if w is None else w
    material = f'elastomer.material={{law="neo-hookean", shear_modulus=1.0, bulk_modulus={K}}}'
    sizes = [f"elastomer.width={width}", "elastomer.thickness=1.0", f"target.width={width}"]
    return load_sensor("biorob2018", ["elastomer.length=1.0", "target.load_height=0", material, *sizes])


def corner_exponent(poisson):
    """The exponent k of the displacement ``r**k`` at a right angle between a clamped and a free face, plane strain.

    M. L. Williams, J. Appl. Mech. 19 (1952) 526.
    """
    kappa = 3.0 - 4.0 * poisson

    def gap(k):
        return np.sin(0.5 * k * np.pi) ** 2 - ((kappa + 1.0) ** 2 / 4.0 - k**2) / kappa

    return brentq(gap, 0.0, 1.0, xtol=1e-14)


# Graded P2-P1 linear FEM, incompressible, in shear moduli (2e-5 or better at S = 2): S, E_c, E_b.
@pytest.mark.parametrize(("S", "E_c", "E_b"), [(7.5, 225.1, 48.119), (15, 895.5, 181.61)])
def test_thin_limits_are_off_by_the_edges_only(S, E_c, E_b):
    assert compression_modulus(1.0, np.inf, S) == pytest.approx(E_c, rel=1 / S)
    assert tilt_modulus(1.0, np.inf, S) == pytest.approx(E_b, rel=1 / S)


def test_compressible_forms_join_their_limits():
    for form in (compression_modulus, tilt_modulus):
        assert form(1.0, 1e9, 3.0) == pytest.approx(form(1.0, np.inf, 3.0), rel=1e-6)
        assert form(1.0, 100.0, 1e5) == pytest.approx(100.0, rel=1e-3)  # wide: K alone
        K = 12.0 / np.array([0.99, 1.01]) ** 2 * 1e4  # each side of the branch of compression_modulus
        below, above = (form(1.0, k, 1.0) for k in K)
        assert above == pytest.approx(below, rel=1e-4)


@pytest.mark.parametrize("form", [compression_modulus, tilt_modulus])
def test_series_meets_the_formula_at_the_branch(form):
    y = np.array([0.00999, 0.01001, 0.02999, 0.03001])
    values = np.array([form(1.0, 12.0 / v**2, 1.0) for v in y])
    leading = form(1.0, np.inf, 1.0)
    slope = 0.4 if form is compression_modulus else 2.0 / 21.0
    np.testing.assert_allclose(values, leading * (1.0 - slope * y**2), rtol=1e-6)


@pytest.mark.parametrize("K", [1e3, 1e5])
def test_layer_reaches_the_thin_limit(K):
    S = 40.0
    k = linear_layer(strip(S, K), 1e-3).stiffness[0]
    assert k[1, 1] / (2 * S) == pytest.approx(compression_modulus(1.0, K, S), rel=1.5 / S)
    turn = np.array([0.5, 0.0, 1.0])
    assert 12 * turn @ k @ turn / (2 * S) ** 3 == pytest.approx(tilt_modulus(1.0, K, S), rel=3 / S)


@pytest.mark.parametrize("w", [2.0, 8.0, 40.0])
def test_layer_in_shear(w):
    k = linear_layer(strip(0.0, 1e6, w), 1e-3).stiffness[0]
    assert k[0, 0] == pytest.approx(shear_stiffness(1.0, w, 1.0), rel=1e-3)


def test_corner_exponent():
    assert corner_exponent(0.5) == pytest.approx(0.5946, abs=5e-5)  # Williams (1952), incompressible right angle
    k, nu = corner_exponent(0.3), 0.3
    kappa = 3.0 - 4.0 * nu
    assert kappa * np.sin(k * np.pi / 2) ** 2 == pytest.approx((kappa + 1) ** 2 / 4 - k**2, rel=1e-10)


@pytest.mark.parametrize("grading", [1.5, 2.5])
def test_corner_and_grading_set_the_rate(grading):
    """Stiffnesses of an incompressible strip: order 2 k beta (2.97 at the strong grading, 1.78 at the mild one).

    Uniform meshes show 2 k only beyond 32 cells: the errors of displacement and pressure have opposite signs.
    """
    sensor = strip(1.0, 1e6)
    bodies = [bonded_body(sensor, SectionFineness(cells, grading)) for cells in (8, 16, 32)]
    values = np.array([np.diag(np.linalg.inv(small_strain_compliance(body)[0])) for body in bodies])
    order = np.log2((values[0] - values[1]) / (values[1] - values[2]))
    promised = 2.0 * grading * corner_exponent(0.5)
    assert order[1] == pytest.approx(promised, rel=0.1)  # compression: the singular mode that is strongest
    assert np.all(order > 0.9 * promised)


@pytest.mark.slow
def test_split_corners_show_the_rate_of_the_singularity_on_uniform_meshes():
    """An incompressible clamped corner: 2 k = 1.189; squares show it only beyond 32 cells, triangles at once."""
    sensor = strip(1.0, 1e6)
    bodies = [bonded_body(sensor, SectionFineness(cells, 1.0, fan=True)) for cells in (16, 32, 64)]
    values = np.array([np.diag(np.linalg.inv(small_strain_compliance(body)[0])) for body in bodies])
    order = np.log2((values[0] - values[1]) / (values[1] - values[2]))
    np.testing.assert_allclose(order, 2.0 * corner_exponent(0.5), atol=0.1)


def test_refusals():
    with pytest.raises(ValueError, match="positive"):
        compression_modulus(1.0, -1.0, 2.0)


def test_holding_moment_holds():
    """Held by its exact moment about the plate, a neo-Hookean block does not turn.

    The two plates carry equal moments by symmetry, at any strain for any law, and the block is in balance.
    """
    layer = planar_layer(strip(2.5, 1e3), 2e-2)
    F_x, F_z, M, found = 0.4, 2.0, 0.0, None
    for _ in range(8):
        found = layer.equilibrium(Wrench(F_x, F_z, M), start=found)
        M = -0.5 * (found.wrench.F_x * found.pose.d_v + found.wrench.F_z * found.pose.d_h)
    assert abs(found.pose.d_h) > 0.05
    assert abs(found.pose.alpha) < 1e-7


def test_the_bound_of_small_strain_is_the_sum_of_each_displacements():
    """Of either sign, none of them free: for a law of constant modulus; one that stiffens adds what it stiffens by."""
    own = {"shear_modulus": 2e4, "bulk_modulus": 2e7}
    plain = silicone_from({"law": "neo-hookean", **own})
    stiffening = silicone_from({"law": "yeoh", "c10": 1e4, "c20": 1e3, "c30": 0.0, "bulk_modulus": 2e7})
    bounds = [partial(small_strain_bound, each, (1e5, 1e5), uneven=0.4) for each in (plain, stiffening)]
    moved = (0.02, 0.0, 0.0), (0.0, 0.03, 0.0), (0.0, 0.0, 0.01)
    for bound in bounds:
        assert bound(0.0, 0.0, 0.0) == pytest.approx(0.0, abs=1e-6)
        assert bound(-0.02, 0.03, -0.01) == bound(0.02, -0.03, 0.01) == bound(0.02, 0.03, 0.01)
    each = [bounds[0](*one) for one in moved]
    assert min(each) > 1e-3 and bounds[0](0.02, 0.03, 0.01) == pytest.approx(sum(each), rel=1e-6)
    assert all(bounds[1](*one) > alone for one, alone in zip(moved, each, strict=True))
