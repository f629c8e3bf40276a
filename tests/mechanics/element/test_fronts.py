"""Fronts against dense algebra: solutions, inertia, indefinite and singular matrices."""

import numpy as np
import pytest
from skfem import MeshHex

from sits_mech.mechanics.element.assembly import factor
from sits_mech.mechanics.element.dissection import dissected
from sits_mech.mechanics.element.mesh import BRICK, section_mesh, solid_mesh

LINES = np.arange(9.0), np.arange(3.0)


@pytest.fixture(scope="module", params=["section", "solid"])
def numbered(request):
    """A mesh with displacements held at its first nodes, and which of the free ones its elements have."""
    lines = (*LINES, np.arange(2.0)) if request.param == "solid" else LINES
    mesh = solid_mesh(MeshHex.init_tensor(*lines), BRICK)[0] if request.param == "solid" else section_mesh(*lines)
    place = np.full(mesh.nodes.size, -1)
    place[10:] = np.arange(mesh.nodes.size - 10)
    return mesh, place[mesh.dofs], mesh.nodes.size - 10


def made(own, count, shift, seed=3):
    """Random symmetric stiffnesses with eigenvalues around a shift, and their dense sum."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(*own.shape, own.shape[1]))
    values = values @ values.swapaxes(1, 2) / own.shape[1] + shift * np.eye(own.shape[1])
    K = np.zeros((count + 1, count + 1))
    np.add.at(K, (own[:, :, None], own[:, None]), values)
    return values, K[:count, :count]


@pytest.mark.parametrize("shift", [0.01, -0.3, -2.0, -5.0])
def test_solutions_and_inertia_are_those_of_the_dense_matrix(numbered, shift):
    mesh, own, count = numbered
    values, K = made(own, count, shift)
    found = factor(dissected(mesh, (own,), count), (values,))
    assert found.negative == np.count_nonzero(np.linalg.eigvalsh(K) < 0.0)
    assert found.safe == (found.negative == 0)
    b = np.random.default_rng(1).normal(size=(count, 3))
    expected = np.linalg.solve(K, b)
    rounding = 1e-13 * np.linalg.cond(K) * np.abs(expected).max()
    np.testing.assert_allclose(found.solve(b), expected, rtol=0.0, atol=rounding)
    np.testing.assert_allclose(found.solve(b[:, 1]), expected[:, 1], rtol=0.0, atol=rounding)


def test_stiffnesses_between_far_elements_are_taken_up(numbered):
    mesh, own, count = numbered
    values, K = made(own, count, 0.1)
    far = np.array([[0, count - 1, -1], [count // 2, 1, count - 2]])
    more = np.array([np.eye(3), 2.0 * np.eye(3)]) + 0.5
    whole = np.zeros((count + 1, count + 1))
    np.add.at(whole, (far[:, :, None], far[:, None]), more)
    K = K + whole[:count, :count]
    b = np.random.default_rng(1).normal(size=count)
    x = factor(dissected(mesh, (own, far), count), (values, more)).solve(b)
    np.testing.assert_allclose(x, np.linalg.solve(K, b), rtol=0.0, atol=1e-12 * np.linalg.cond(K) * np.abs(x).max())


def test_a_matrix_of_zeros_has_no_factor(numbered):
    mesh, own, count = numbered
    assert factor(dissected(mesh, (own,), count), (np.zeros((*own.shape, own.shape[1])),)) is None


def test_the_same_digits_each_time(numbered):
    mesh, own, count = numbered
    values, _ = made(own, count, 0.01)
    b = np.random.default_rng(1).normal(size=(count, 3))
    first, again = (factor(dissected(mesh, (own,), count), (values,)).solve(b) for _ in range(2))
    np.testing.assert_array_equal(first, again)
