"""Loops and rings against closed forms, an independent finite-element code, limits and invariants."""

import numpy as np
import pytest
from scipy.constants import mu_0
from scipy.special import ellipe, ellipk

from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import (
    coil_inductances,
    mutual_loops,
    mutual_side_by_side,
    ring_inductance,
    ring_mutual,
)
from sits_mech.scene.sensor import Coil

MM = 1e-3


def coil(name: str = "C", x: float = 0.0, y: float = 0.0) -> Coil:
    return Coil(
        name=name, centre=(x, y), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def ring(radius: float, width: float, height: float, z: float = 0.0) -> Sections:
    return Sections(*(np.array([value]) for value in (radius, z, width, height)))


@pytest.mark.parametrize(
    ("a", "b", "d", "expected"),
    [  # elliptic integrals, from tables of coaxial loops
        (0.25, 0.25, 0.1, 3.376847185e-07),
        (0.2, 0.1, 0.05, 9.593293994e-08),
        (0.00115, 0.00335, 0.001, 7.01934432e-10),
        (0.0034, 0.0034, 0.002, 3.226370606e-09),
    ],
)
def test_coaxial_loops_equal_published_values(a, b, d, expected):
    assert mutual_loops(a, b, d) == pytest.approx(expected, rel=1e-9, abs=0)


def test_coaxial_loops_equal_first_form_with_complete_elliptic_integrals():
    a, b, d = 2.0, np.array([0.5, 1.0, 1.9, 2.5]), np.array([0.3, 1.0, 0.1, 2.0])
    m = 4 * a * b / ((a + b) ** 2 + d**2)
    k = np.sqrt(m)
    expected = mu_0 * np.sqrt(a * b) * ((2 / k - k) * ellipk(m) - 2 / k * ellipe(m))
    np.testing.assert_allclose(mutual_loops(a, b, d), expected, rtol=1e-12)


def test_far_loops_are_dipoles_without_loss_of_digits():
    a, b, d = 1e-3, 5e-6, 10.0
    assert mutual_loops(a, b, d) == pytest.approx(mu_0 * np.pi * a**2 * b**2 / (2 * d**3), rel=1e-7, abs=0)


def test_thin_square_ring_has_the_self_inductance_of_its_mean_distance():
    # Grover: L = mu0 a (ln(8 a / g) - 2) to order (w/a)^2, g = 0.44705 w for a square section
    a, w = 1.0, 1e-3
    expected = mu_0 * a * (np.log(8 * a / (0.44704917 * w)) - 2)
    assert float(ring_inductance(ring(a, w, w))[0, 0]) == pytest.approx(expected, rel=1e-6)


def test_ring_is_the_mean_over_its_quarters():
    whole = ring(1.0, 0.3, 0.2)
    quarters = Sections(
        np.array([0.925, 1.075, 0.925, 1.075]), np.array([-0.05, -0.05, 0.05, 0.05]), np.full(4, 0.15), np.full(4, 0.1)
    )
    assert float(ring_inductance(whole)[0, 0]) == pytest.approx(float(ring_inductance(quarters).mean()), rel=1e-5)
    near = ring(1.4, 0.1, 0.1, 0.05)
    assert float(ring_mutual(whole, near)[0, 0]) == pytest.approx(float(ring_mutual(quarters, near).mean()), rel=1e-5)


def test_quadrature_of_the_regular_part_converges():
    rings = coil_sections(coil())
    fine = ring_inductance(rings, points=(5, 5)).sum()
    errors = [abs(ring_inductance(rings, points=(n, n)).sum() / fine - 1) for n in (1, 2, 3)]
    assert errors[0] < 1e-4 and errors[1] < 1e-8 and errors[2] < 1e-8


def test_coils_equal_finite_elements():
    # NGSolve 6.2: axisymmetric p = 6 for L0 (1e-6); 3D for the mutual of coils 8 mm apart, printed to 1e-4 nH
    L = coil_inductances([coil("C1", -4 * MM), coil("C2", 4 * MM)])
    np.testing.assert_allclose(np.diag(L), 2.507569757e-06, rtol=1e-6)
    assert L[0, 1] == pytest.approx(-47.4298e-9, rel=1e-5, abs=0)
    assert L[0, 1] == L[1, 0]


def test_side_by_side_tends_to_coaxial_and_to_dipoles():
    small, large = ring(0.2, 0.01, 0.01), ring(1.0, 0.02, 0.02, 0.3)
    coaxial = float(ring_mutual(small, large)[0, 0])
    assert mutual_side_by_side(small, large, 0.0) == pytest.approx(coaxial, rel=1e-7, abs=0)
    assert mutual_side_by_side(small, large, 1e-6) == pytest.approx(coaxial, rel=1e-7, abs=0)
    far = mutual_side_by_side(ring(0.2, 1e-3, 1e-3), ring(0.1, 1e-3, 1e-3), 100.0, error=1e-22)
    assert far == pytest.approx(-mu_0 * np.pi * 0.2**2 * 0.1**2 / (4 * 100.0**3), rel=1e-4, abs=0)


def test_side_by_side_is_reciprocal():
    first, second = coil_sections(coil()), ring(1 * MM, 0.2 * MM, 0.1 * MM, 0.4 * MM)
    forth = mutual_side_by_side(first, second, 6 * MM, error=1e-18)
    back = mutual_side_by_side(second, first, 6 * MM, error=1e-18)
    assert forth == pytest.approx(back, rel=1e-8, abs=0)


def test_array_of_four_is_symmetric_positive_and_scales_with_length():
    places = [(-4, -4), (4, -4), (-4, 4), (4, 4)]
    L = coil_inductances([coil(f"C{i}", x * MM, y * MM) for i, (x, y) in enumerate(places)], tolerance=1e-6)
    np.testing.assert_allclose(L, L.T, rtol=0, atol=0)
    assert np.linalg.eigvalsh(L).min() > 0
    assert L[0, 1] == pytest.approx(L[0, 2], rel=1e-5)
    assert abs(L[0, 3]) < abs(L[0, 1])
    rings = coil_sections(coil())
    doubled = Sections(*(2 * value for value in (rings.radius, rings.z, rings.width, rings.height)))
    assert ring_inductance(doubled).sum() == pytest.approx(2 * ring_inductance(rings).sum(), rel=1e-12, abs=0)
