"""A plate's surface: permeable and superconducting cubes in a uniform field, nothing of air, no net flux."""

import numpy as np
import pytest
from scipy.constants import mu_0

from sits_mech.geometry.sheet_plan import CellPlan, Grading, disc_plan, rectangle_plan
from sits_mech.magnetics.permeable.shells import HalfSurface, ShellClass, shell_classes, surface

MM = 1e-3


def moments(half: float, parts: int, mu: float, axis: int) -> float:
    """Moment over volume and field of a cube along an axis, mu 0 of a superconductor."""
    size = half / parts
    part = surface(rectangle_plan(2 * half, 2 * half, Grading(size, 1.0 + 1e-9, size)), np.linspace(0, half, parts + 1))
    a, b = (axis + 1) % 3, (axis + 2) % 3

    def potential(x: np.ndarray) -> np.ndarray:
        A = np.zeros_like(x)
        A[..., a], A[..., b] = -x[..., b] / 2, x[..., a] / 2
        return A

    return energy(part, shell_classes(part), potential(part.points[0]), mu) * mu_0 / (2 * half) ** 3


def energy(part: HalfSurface, classes: list[ShellClass], A: np.ndarray, mu: float) -> float:
    """Delta L of what makes A at the surface's points [H]."""
    loads, total = part.loads(A[..., None]), 0.0
    for each in classes:
        b = each.projected(loads)
        total += (b.conj().T @ each.response(mu * each.inner) @ b).real.item()
    return total


@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("mu, exact", [(0.0, -1.6388), (1e9, 3.6442), (1.0, 0.0), (1.01, 0.01 / (1 + 0.01 / 3))])
def test_a_cube_in_a_uniform_field(mu: float, exact: float, axis: int) -> None:
    """Polarisabilities of a cube, A. Sihvola (2007): 3.6442 and -1.6388; extrapolated; weak chi: N = 1/3."""
    coarse, fine = (moments(1 * MM, parts, mu, axis) for parts in (2, 4))
    found = fine + (fine - coarse) / 3
    assert found == pytest.approx(exact, rel=1e-2, abs=1e-9)
    assert abs(fine - exact) <= abs(coarse - exact) + 1e-5


@pytest.mark.parametrize("plan", [rectangle_plan(8 * MM, 5 * MM, Grading(0.5 * MM, 1.5, 1 * MM)),
                                  disc_plan(8 * MM, Grading(0.5 * MM, 1.5, 1 * MM), orders=15)])
def test_a_closed_surface_takes_no_net_flux(plan: CellPlan) -> None:
    """Of a potential that bends; S_i takes no constant, S does; both are positive."""
    part = surface(plan, np.linspace(0.0, 0.5 * MM, 3))
    x, y, z = np.moveaxis(part.points[0], -1, 0)
    loads = part.loads(np.stack([y * y * z, x * z - x * y, x**3 + y], axis=-1)[..., None])
    assert loads.shape[:2] == (len(part.images), len(part.nodes))
    assert abs(loads.sum()) < 1e-12 * np.abs(loads).sum()
    for each in shell_classes(part):
        if each.net.any():
            one = np.linalg.lstsq(each.free.toarray(), np.ones(len(part.nodes)), rcond=None)[0]
            assert abs(each.inner @ one).max() < 1e-2 * abs(each.S @ one).max()
        for operator in (each.S, each.inner):
            assert np.linalg.eigvalsh(operator).min() > -1e-9 * np.abs(operator).max()
