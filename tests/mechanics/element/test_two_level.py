"""Equations of refined meshes solved from the coarse one: the direct solution, in few steps, nearly incompressible."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import MeshHex, MeshQuad, MeshQuad2, MeshTet

from sits_mech.mechanics.element.kernel import Law, element_stiffness
from sits_mech.mechanics.element.mesh import BRICK, SQUARE, TETRAHEDRON, plane_mesh, solid_mesh
from sits_mech.mechanics.element.prolongation import prolongation
from sits_mech.mechanics.element.two_level import two_level
from sits_mech.meshing.refinement import refined
from sits_mech.silicone.energy import isochoric_energy, isochoric_stress
from sits_mech.silicone.material import silicone_from

X, Z = np.array([-1.0, 0.2, 1.0]), np.array([0.0, 0.6, 1.0])
QUADS = MeshQuad.init_tensor(3.0 * X, Z)
MESHES = {
    "section": (MeshQuad2.from_mesh(MeshQuad(QUADS.p, QUADS.t[[0, 3, 2, 1]])), SQUARE),
    "bricks": (MeshHex.init_tensor(X, X, Z), BRICK),
    "tetrahedra": (MeshTet.init_tensor(X, X, Z), TETRAHEDRON),
}


def equations(mesh, element, K):
    """Mixed mesh at rest, bonded below and above: element stiffnesses, assembled ones, free displacements."""
    own = plane_mesh(mesh) if element is SQUARE else solid_mesh(mesh, element)[0]
    silicone = silicone_from({"law": "neo-hookean", "shear_modulus": 3e4, "bulk_modulus": 3e4 * K})
    law = Law(isochoric_energy(silicone), isochoric_stress(silicone))
    each = element_stiffness(own, law, K, np.zeros(own.nodes.size), np.zeros(own.chi.shape[:2]))
    rows, columns = (np.broadcast_to(own.dofs[at], each.shape).ravel() for at in (np.s_[:, :, None], np.s_[:, None]))
    whole = sparse.coo_matrix((each.ravel(), (rows, columns)), shape=(own.nodes.size,) * 2).tocsc()
    z = own.nodes[:, -1]
    free = np.flatnonzero(np.repeat((z > 1e-9) & (z < 1.0 - 1e-9), own.nodes.shape[1]))
    return own, each, whole, free


def both(name, K):
    """The equations of a mesh divided once, their assembled matrix, its free displacements."""
    mesh, element = MESHES[name]
    refinement = refined(mesh, 1)
    first, _, coarse, inner = equations(mesh, element, K)
    fine, each, whole, free = equations(refinement.mesh, element, K)
    factor = splu(coarse[np.ix_(inner, inner)])

    def solved(b):
        x = np.zeros_like(b)
        x[inner] = factor.solve(b[inner])
        return x

    onto = prolongation(first, fine, refinement, element)
    return two_level(fine, refinement, element, each, free, (onto, solved)), whole, free


@pytest.mark.parametrize("name", MESHES)
def test_solution_is_the_direct_one(name):
    """Two right-hand sides, one of them zero but for one entry inside a cell."""
    system, whole, free = both(name, 1e3)
    b = np.zeros((whole.shape[0], 2))
    b[:, 0] = np.random.default_rng(1).normal(size=len(b))
    b[free[-1], 1] = 1.0
    found = system.solve(b, 1e-10)
    direct = np.zeros_like(b)
    direct[free] = splu(whole[np.ix_(free, free)]).solve(b[free])
    np.testing.assert_allclose(found.x, direct, atol=1e-7 * np.abs(direct).max())
    assert found.left <= 1e-10


@pytest.mark.parametrize("name", MESHES)
def test_steps_do_not_grow_without_bound_with_the_bulk_modulus(name):
    """From K/mu = 1,000 to 100,000 by less than a third."""
    steps = []
    for K in (1e3, 1e5):
        system, whole, _ = both(name, K)
        steps.append(system.solve(np.random.default_rng(1).normal(size=(whole.shape[0], 1)), 1e-6).steps)
    assert steps[1] < 1.33 * steps[0] < 133


def test_a_mesh_divided_twice_takes_the_approximation_of_the_one_before():
    """Three levels take at most four times the steps of two."""
    mesh, element = MESHES["section"]
    once, _, _ = both("section", 1e3)
    first, second = refined(mesh, 1), refined(refined(mesh, 1).mesh, 1)
    coarse = equations(first.mesh, element, 1e3)[0]
    fine, each, whole, free = equations(second.mesh, element, 1e3)
    onto = prolongation(coarse, fine, second, element)
    b = np.random.default_rng(1).normal(size=(whole.shape[0], 1))
    found = two_level(fine, second, element, each, free, (onto, once.approximated)).solve(b, 1e-8)
    before = once.solve(np.random.default_rng(1).normal(size=(coarse.nodes.size, 1)), 1e-8)
    np.testing.assert_allclose(whole[free] @ found.x, b[free], atol=1e-6 * np.abs(b).max())
    assert found.steps < 4 * before.steps


def test_an_indefinite_matrix_is_told():
    mesh, element = MESHES["bricks"]
    refinement = refined(mesh, 1)
    first = equations(mesh, element, 1e3)[0]
    fine, each, _, free = equations(refinement.mesh, element, 1e3)
    onto = prolongation(first, fine, refinement, element)
    system = two_level(fine, refinement, element, -each, free, (onto, np.zeros_like))
    assert system.solve(np.ones((fine.nodes.size, 1)), 1e-6).left == np.inf
