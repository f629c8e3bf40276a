"""Charges of magnetised boxes: Aharoni's demagnetising factors, the sum of the factors, dipoles far away, symmetry."""

import numpy as np
import pytest

from sits_mech.magnetics.space.boxes import PAIRS, box_charges
from sits_mech.quantities import Array


def factor(a: float, b: float, c: float) -> float:
    """Along c of a bar of half sides a, b, c: A. Aharoni, J. Appl. Phys. 83 (1998) 3432, equation 1."""
    r, ab, bc, ac = np.sqrt(a * a + b * b + c * c), np.hypot(a, b), np.hypot(b, c), np.hypot(a, c)
    total = (b * b - c * c) / (2 * b * c) * np.log((r - a) / (r + a))
    total += (a * a - c * c) / (2 * a * c) * np.log((r - b) / (r + b))
    total += b / (2 * c) * np.log((ab + a) / (ab - a)) + a / (2 * c) * np.log((ab + b) / (ab - b))
    total += c / (2 * a) * np.log((bc - b) / (bc + b)) + c / (2 * b) * np.log((ac - a) / (ac + a))
    total += 2 * np.arctan(a * b / (c * r)) + (a**3 + b**3 - 2 * c**3) / (3 * a * b * c)
    total += (a * a + b * b - 2 * c * c) / (3 * a * b * c) * r + c / (a * b) * (ac + bc)
    return float((total - (ab**3 + bc**3 + ac**3) / (3 * a * b * c)) / np.pi)


@pytest.mark.parametrize("sides", [(1.0, 1.0, 1.0), (1.0, 1.5, 0.4), (1.0, 1.0, 0.02)])
def test_demagnetising_factors_of_bars(sides: tuple[float, float, float]) -> None:
    """Whole bars of uneven boxes, in metres and in micrometres; of a cube a third each."""
    axes = [side * np.array([0.0, 0.3, 0.8, 1.0]) for side in sides]
    exact = [factor(*(sides[k] for k in order)) for order in ((1, 2, 0), (0, 2, 1), (0, 1, 2))]
    for scale in (1.0, 1e-6):
        K = box_charges(*(scale * axis for axis in axes))
        found = [K[PAIRS.index((k, k))].sum() / (scale**3 * np.prod(sides)) for k in range(3)]
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8)
    if sides == (1.0, 1.0, 1.0):
        np.testing.assert_allclose(exact, 1 / 3, rtol=1e-12)


def boxes() -> tuple[Array, Array, Array]:
    """Half axes with thin and wide cells."""
    return np.array([0.0, 1.0, 6.0, 6.1]), np.array([0.0, 2.0, 5.0]), np.array([0.0, 0.05, 0.2])


def test_trace_is_the_volume_of_a_box_with_itself_and_nothing_else() -> None:
    """Poisson's equation; dipoles have it exactly, differences to the digits that they lose."""
    axes = boxes()
    K = box_charges(*axes)
    x, y, z = (np.diff(axis) for axis in axes)
    volume = (x[:, None, None] * y[:, None] * z).ravel()
    trace = sum(K[PAIRS.index((k, k))] for k in range(3))
    expected = np.zeros_like(trace)
    expected[0, 0, 0] = np.diag(volume)
    np.testing.assert_allclose(trace, expected, rtol=0, atol=1e-9 * volume.max())


def test_mixed_components_against_points() -> None:
    """Far boxes as 1 / r^5 between Gauss points in both; K_xy is odd, and symmetric with its image."""
    axes = (np.array([0.0, 0.1, 4.0, 4.3]), np.array([0.0, 0.2, 3.0, 3.2]), np.array([0.0, 0.3]))
    K = box_charges(*axes)
    s, w = np.polynomial.legendre.leggauss(4)
    points = []
    for box in ((0, 0, 0), (2, 2, 0)):
        sides = [(axis[k], axis[k + 1]) for axis, k in zip(axes, box, strict=True)]
        grid = np.meshgrid(*((low + high) / 2 + (high - low) / 2 * s for low, high in sides), indexing="ij")
        weight = np.einsum("i,j,k->ijk", w, w, w).ravel() * np.prod([(high - low) / 2 for low, high in sides])
        points.append((np.stack(grid, axis=-1).reshape(-1, 3), weight))
    (p, u), (q, v) = points
    for octant, signs in (((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (-1, 1, 1)), ((0, 1, 1), (1, -1, -1))):
        R = p[:, None] - q * signs
        r = np.linalg.norm(R, axis=-1)
        for k, (a, b) in enumerate(PAIRS):
            exact = ((float(a == b) - 3 * R[..., a] * R[..., b] / r**2) / r**3 * u[:, None] * v).sum() / (4 * np.pi)
            assert K[(k, *octant, 0, 8)] == pytest.approx(exact, rel=1e-6)
