"""Bricks and tetrahedra: derivatives against differences, and the patch test, for all laws."""

import numpy as np
import pytest
from skfem import MeshHex, MeshTet

from sits_mech.mechanics.element.kernel import Laws, deformation, element_forces, law_of
from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, solid_mesh
from sits_mech.silicone.kinematics import in_space
from sits_mech.silicone.material import silicone_from
from tests.mechanics.derivatives import check_elements

K = {"bulk_modulus": 3e7}
LAWS = {
    "neo-hookean": {"law": "neo-hookean", "shear_modulus": 3e4, **K},
    "mooney-rivlin": {"law": "mooney-rivlin", "c10": 1e4, "c01": 5e3, **K},
    "yeoh": {"law": "yeoh", "c10": 1.5e4, "c20": -300.0, "c30": 40.0, **K},
    "gent": {"law": "gent", "shear_modulus": 3e4, "j_m": 20.0, **K},
    "ogden": {"law": "ogden", "mu": [2e4, 1e4], "alpha": [1.7, -2.6], **K},
}
LINES = np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.8]), np.array([0.0, 0.6, 1.0])


@pytest.fixture(params=[*LAWS])
def laws(request):
    return Laws((law_of(silicone_from(LAWS[request.param]))._replace(K=1e3),))


def brick():
    """A box of six bricks."""
    return solid_mesh(MeshHex.init_tensor(*LINES), BRICK)[0]


def tetrahedra():
    """The same box in tetrahedra."""
    return solid_mesh(MeshTet.init_tensor(*LINES), TETRAHEDRON)[0]


@pytest.fixture(scope="module", params=[brick, tetrahedra])
def mesh(request):
    return request.param()


def test_forces_and_tangent_are_derivatives_of_the_energy(mesh, laws):
    rng = np.random.default_rng(5)
    check_elements(mesh, laws, 0.01 * rng.normal(size=mesh.nodes.size), rng.normal(size=mesh.nodes.size))


def test_uniform_deformation_is_exact(mesh, laws):
    """Patch test: u = (G - 1) x gives F = G and J = det G everywhere, and no force on inner nodes."""
    G = np.array([[1.1, 0.2, -0.1], [0.05, 0.9, 0.1], [-0.1, 0.0, 1.05]])
    u = (mesh.nodes @ (G - np.eye(3)).T).ravel()
    F, J = deformation(mesh, u)
    np.testing.assert_allclose(F, np.broadcast_to(G.ravel(), F.shape), atol=1e-12)
    np.testing.assert_allclose(J, np.linalg.det(G), rtol=1e-12)
    found = element_forces(mesh, laws, u)
    low, high = mesh.nodes.min(axis=0) + 1e-9, mesh.nodes.max(axis=0) - 1e-9
    inner = np.all((mesh.nodes > low) & (mesh.nodes < high), axis=1)
    assert inner.sum() > 0
    np.testing.assert_allclose(found.forces.reshape(-1, 3)[inner], 0.0, atol=1e-10 * np.abs(found.forces).max())
    w = laws.stress(in_space(G.reshape(1, 9)))[0][0]
    assert found.energy == pytest.approx(0.8 * (w + 500.0 * (np.linalg.det(G) - 1.0) ** 2), rel=1e-12)
