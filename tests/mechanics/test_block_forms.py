"""The laws and bricks of the 3D pad: derivatives against differences, plane strain as a special case, patch test."""

import numpy as np
import pytest
from skfem import MeshHex, MeshTet

from sits_mech.mechanics.block_energy import cofactor, solid_energy, stress_and_tangent, turning
from sits_mech.mechanics.block_forms import BRICK, TETRAHEDRON, solid_deformation, solid_mesh, solid_tangent
from sits_mech.mechanics.energy import plane_energy
from sits_mech.silicone.material import silicone_from

K = {"bulk_modulus": 3e7}
LAWS = {
    "neo-hookean": {"law": "neo-hookean", "shear_modulus": 3e4, **K},
    "mooney-rivlin": {"law": "mooney-rivlin", "c10": 1e4, "c01": 5e3, **K},
    "yeoh": {"law": "yeoh", "c10": 1.5e4, "c20": -300.0, "c30": 40.0, **K},
    "gent": {"law": "gent", "shear_modulus": 3e4, "j_m": 20.0, **K},
    "ogden": {"law": "ogden", "mu": [2e4, 1e4], "alpha": [1.7, -2.6], **K},
}
GUARD = 2.0


@pytest.fixture(params=[*LAWS])
def silicone(request):
    return silicone_from(LAWS[request.param])


def deformations():
    """Random deformations with J > 0; the undeformed one, and one with two equal stretches, among them."""
    F = np.eye(3) + 0.25 * np.random.default_rng(3).normal(size=(30, 3, 3))
    return np.concatenate([F[np.linalg.det(F) > 0.2], [np.eye(3), np.diag([0.8, 1.3, 0.8])]]).reshape(-1, 9)


def differences(function, F):
    """Central differences of a function of F, last axis the component of F."""
    h = 1e-6 * np.eye(9)
    return np.stack([(function(F + step) - function(F - step)) / 2e-6 for step in h], axis=-1)


def test_cofactor_and_its_derivative():
    F = deformations()
    np.testing.assert_allclose(cofactor(F), differences(lambda G: np.linalg.det(G.reshape(-1, 3, 3)), F), atol=1e-8)
    np.testing.assert_allclose(turning(F), differences(cofactor, F), atol=1e-8)


def test_stress_and_tangent_are_derivatives_of_the_energy(silicone):
    law, F = solid_energy(silicone, GUARD), deformations()
    _, P, A, _ = stress_and_tangent(law, F)
    slope = differences(lambda G: stress_and_tangent(law, G)[0], F)
    np.testing.assert_allclose(P, slope, rtol=1e-6, atol=1e-7 * np.abs(P).max())
    np.testing.assert_allclose(A, differences(lambda G: stress_and_tangent(law, G)[1], F), atol=1e-6 * np.abs(A).max())
    np.testing.assert_allclose(A, np.swapaxes(A, 1, 2), atol=1e-12 * np.abs(A).max())


def test_rest_is_free_of_stress_with_unit_shear_modulus(silicone):
    law = solid_energy(silicone, GUARD)
    w, P, A, _ = stress_and_tangent(law, np.eye(3).reshape(1, 9))
    assert w[0] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(P, 0.0, atol=1e-12)
    shear = np.array([0, 1.0, 0, 1.0, 0, 0, 0, 0, 0])
    assert shear @ A[0] @ shear == pytest.approx(4.0, rel=1e-12)  # 2 mu e:e with e_12 = 1


def test_plane_strain_is_the_planar_law(silicone):
    G = deformations().reshape(-1, 3, 3)[:, :2, :2]
    G = G[np.linalg.det(G) > 0.2]
    F = np.zeros((len(G), 3, 3))
    F[:, :2, :2], F[:, 2, 2] = G, 1.0
    J = np.linalg.det(G)
    plane = plane_energy(silicone)((G**2).sum(axis=(1, 2)), J).w + GUARD * (J - 1.0 - np.log(J))
    solid = stress_and_tangent(solid_energy(silicone, GUARD), F.reshape(-1, 9))[0]
    np.testing.assert_allclose(solid, plane, rtol=1e-12, atol=1e-13)


def test_turning_the_body_costs_nothing(silicone):
    law, F = solid_energy(silicone), deformations()
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turned = (turn * np.linalg.det(turn) @ F.reshape(-1, 3, 3)).reshape(-1, 9)
    np.testing.assert_allclose(stress_and_tangent(law, turned)[0], stress_and_tangent(law, F)[0], atol=1e-12)


LINES = np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.8]), np.array([0.0, 0.6, 1.0])


def brick():
    """A box of six bricks."""
    return solid_mesh(MeshHex.init_tensor(*LINES), BRICK)[0]


def tetrahedra():
    """The same box in tetrahedra."""
    return solid_mesh(MeshTet.init_tensor(*LINES), TETRAHEDRON)[0]


@pytest.fixture(scope="module", params=[brick, tetrahedra])
def mesh(request):
    return request.param()


def test_forces_and_tangent_are_derivatives_of_the_energy(mesh, silicone):
    rng = np.random.default_rng(5)
    u, v = 0.01 * rng.normal(size=mesh.nodes.size), rng.normal(size=mesh.nodes.size)
    law, bulk, h = solid_energy(silicone), 1e3, 1e-6
    found = solid_tangent(mesh, law, bulk, u)
    up, down = (solid_tangent(mesh, law, bulk, u + s * h * v) for s in (1, -1))
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(found.forces @ v, rel=1e-6)
    product = np.zeros(mesh.nodes.size)
    np.add.at(product, mesh.dofs, np.einsum("eij,ej->ei", found.stiffness, v[mesh.dofs]))
    difference = (up.forces - down.forces) / (2 * h)
    np.testing.assert_allclose(product, difference, rtol=1e-5, atol=1e-6 * np.abs(difference).max())


def test_uniform_deformation_is_exact(mesh, silicone):
    """Patch test: u = (G - 1) x gives F = G and J = det G everywhere, and no force on inner nodes."""
    G = np.array([[1.1, 0.2, -0.1], [0.05, 0.9, 0.1], [-0.1, 0.0, 1.05]])
    u = (mesh.nodes @ (G - np.eye(3)).T).ravel()
    F, J = solid_deformation(mesh, u)
    np.testing.assert_allclose(F, np.broadcast_to(G.ravel(), F.shape), atol=1e-12)
    np.testing.assert_allclose(J, np.linalg.det(G), rtol=1e-12)
    found = solid_tangent(mesh, solid_energy(silicone), 1e3, u)
    low, high = mesh.nodes.min(axis=0) + 1e-9, mesh.nodes.max(axis=0) - 1e-9
    inner = np.all((mesh.nodes > low) & (mesh.nodes < high), axis=1)
    assert inner.sum() > 0
    np.testing.assert_allclose(found.forces.reshape(-1, 3)[inner], 0.0, atol=1e-10 * np.abs(found.forces).max())
    w = stress_and_tangent(solid_energy(silicone), G.reshape(1, 9))[0][0]
    assert found.energy == pytest.approx(0.8 * (w + 500.0 * (np.linalg.det(G) - 1.0) ** 2), rel=1e-12)
