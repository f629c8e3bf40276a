"""Stiffnesses assembled straight into the equations: against the dense product with the map of the target's motion."""

import numpy as np
import pytest

from sits_mech.mechanics.element.assembly import pattern
from sits_mech.mechanics.element.fronts import factor
from sits_mech.mechanics.element.mesh import section_mesh
from sits_mech.mechanics.element.target import work_of_load
from sits_mech.mechanics.pad.section import Fineness, bonded_body
from sits_mech.mechanics.rest.body import rest
from sits_mech.mechanics.rest.linearisation import factored, gradient
from sits_mech.mechanics.rest.newton import target_stiffness
from sits_mech.mechanics.rest.path import follow
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def state():
    """A sheared, pressed layer with guard and contact."""
    body = bonded_body(load_sensor("biorob2018"), Fineness(2, 1.5, fan=True, guard=0.5, depth=1e-3))
    return body, follow(body, rest(body), (np.zeros(3), np.array([0.3, 5.0, 0.1]))).state


def whole_matrix(numbers, values, n):
    """The dense sum of stiffnesses."""
    K = np.zeros((n, n))
    for rows, each in zip(numbers, values, strict=True):
        np.add.at(K, (rows[:, :, None], rows[:, None]), each)
    return K


def test_equations_are_the_product_with_the_map_of_the_target(state):
    body, state = state
    n, factor = state.u.size, factored(body, state, gradient(body, state))
    found = factor.made
    K, m = whole_matrix(found.numbers, found.values, n + 6), len(body.free)
    P = np.zeros((n + 6, m + 3))
    P[body.free, np.arange(m)] = 1.0
    P[body.pattern.border, -3:] = found.T[:, :3]
    A = P.T @ K @ P
    close = {"atol": 1e-11 * np.abs(A).max()}
    C, D = body.pattern.sides(found.values, found.T[:, :3])
    np.testing.assert_allclose(body.pattern.matrix(found.values).toarray(), A[:m, :m], **close)
    np.testing.assert_allclose(body.pattern.product(found.values, np.eye(m)), A[:m, :m], **close)
    np.testing.assert_allclose(C, A[:m, m:], **close)
    np.testing.assert_allclose(D, A[m:, m:], **close)
    np.testing.assert_allclose(A[:m, :m] @ factor.by_q, -C, atol=1e-9 * np.abs(C).max())
    A[-3:, -3:] += found.turning[:3, :3]
    S = np.linalg.inv(np.linalg.inv(A)[-3:, -3:])
    np.testing.assert_allclose(target_stiffness(body, state)[0], S, rtol=1e-7, atol=1e-7 * np.abs(S).max())


def test_target_stiffness_is_the_change_of_the_forces_that_hold_the_target(state):
    body, state = state
    h, held = 1e-5, np.ones(3, dtype=bool)

    def forces(q):
        """What acts on d_h, d_z and alpha, by the load that holds the target there."""
        load = follow(body, state, (state.q, q), held=held).state.load
        return work_of_load(load, body.height, q)[:3]

    def fixed(q):
        """What acts there by the load of the middle."""
        return work_of_load(state.load, body.height, q)[:3]

    S, hidden = target_stiffness(body, state)
    assert hidden is None
    for k, unit in enumerate(np.eye(3)):
        up, down = state.q + h * unit, state.q - h * unit
        change = (forces(up) - forces(down) - fixed(up) + fixed(down)) / (2 * h)
        np.testing.assert_allclose(S[:, k], change, rtol=1e-4, atol=1e-5 * np.abs(S).max())


def one_square(*free):
    """The pattern of an element whose displacements are held but for a few."""
    mesh = section_mesh(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    return pattern(mesh, (mesh.dofs,), np.array(free), np.array([17])), mesh.dofs[0]


def stiffness(numbers, entries):
    """An element's stiffness with some entries."""
    found = np.zeros((1, 18, 18))
    for (row, column), value in entries.items():
        found[0, numbers == row, numbers == column] = value
    return (found,)


def test_singular_equations_have_no_answer():
    found, numbers = one_square(3, 8)
    values = stiffness(numbers, dict.fromkeys([(3, 3), (3, 8), (8, 3), (8, 8), (17, 17)], 1.0))
    assert found.factored(values) is None
    np.testing.assert_array_equal(found.sides(values, np.ones((1, 3)))[1], np.ones((3, 3)))


def test_a_matrix_without_a_pivot_inside_of_a_front_is_factored_all_the_same():
    """One displacement of the first front is held by the front's border alone, as a constraint by its multiplier."""
    mesh = section_mesh(np.linspace(0.0, 1.0, 41), np.linspace(0.0, 1.0, 5))
    free = np.arange(mesh.nodes.size)
    found = pattern(mesh, (mesh.dofs,), free, np.array([mesh.nodes.size]))
    first, order = found.dissection.fronts[0], found.dissection.order
    border = np.isin(mesh.dofs, order[first.border])
    pivots = np.isin(mesh.dofs, order[first.start : first.stop])
    alone = mesh.dofs == mesh.dofs[pivots & border.any(axis=1)[:, None]][0]
    values = np.random.default_rng(2).normal(size=(len(mesh.cells), 18, 18))
    values = values + values.swapaxes(1, 2)
    values[(alone[:, :, None] & ~border[:, None]) | (~border[:, :, None] & alone[:, None])] = 0.0
    assert factor(found.dissection, (values,)) is None
    b = np.random.default_rng(3).normal(size=(len(free), 2))
    x = found.factored((values,))(b)
    expected = np.linalg.solve(whole_matrix((mesh.dofs,), (values,), len(free)), b)
    np.testing.assert_allclose(x, expected, rtol=1e-7, atol=1e-9 * np.abs(x).max())
