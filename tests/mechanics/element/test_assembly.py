"""Stiffnesses assembled straight into the equations: against the dense product with the map of the target's motion."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.element.assembly import factor, pattern
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.element.mesh import section_mesh
from sits_mech.mechanics.element.target import work_of_load
from sits_mech.mechanics.equilibrium.body import deformed_state, rest
from sits_mech.mechanics.equilibrium.linearisation import factored, residuals_of
from sits_mech.mechanics.equilibrium.newton import target_stiffness
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def state():
    """A sheared, pressed layer with guard and contact."""
    body = bonded_body(load_sensor("biorob2018"), SectionFineness(2, 1.5, fan=True, guard=0.5, depth=1e-3))
    return body, advance(body, rest(body), Path((np.zeros(3), np.array([0.3, 5.0, 0.1])))).state


def whole_matrix(numbers, values, n):
    """The dense sum of stiffnesses."""
    K = np.zeros((n, n))
    for rows, each in zip(numbers, values, strict=True):
        np.add.at(K, (rows[:, :, None], rows[:, None]), each)
    return K


def test_equations_are_the_product_with_the_map_of_the_target(state):
    body, state = state
    n, factor = state.u.size, factored(body, state, residuals_of(body, state))
    found, own = factor.made, body.pattern.following(factor.made.numbers)
    K, m = whole_matrix(found.numbers, found.values, n + 6), len(body.free)
    P = np.zeros((n + 6, m + 3))
    P[body.free, np.arange(m)] = 1.0
    P[own.border[:-1], -3:] = found.T[:-1, :3]  # the last is the height of what presses on a cover
    A = P.T @ K @ P
    close = {"atol": 1e-11 * np.abs(A).max()}
    C, D = own.sides(found.values, found.T[:, :3])
    np.testing.assert_allclose(own.matrix(found.values).toarray(), A[:m, :m], **close)
    np.testing.assert_allclose(own.product(found.values, np.eye(m)), A[:m, :m], **close)
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
        load = advance(body, state, Path((state.q, q), held)).state.load
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


@pytest.mark.parametrize("own", [0.0, 1e-13])
def test_a_matrix_without_a_pivot_inside_of_a_front_is_factored_all_the_same(own):
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
    values[alone[:, :, None] & alone[:, None]] = own
    assert (factor(found.dissection, (values,)) is None) == (own == 0.0)
    b = np.random.default_rng(3).normal(size=(len(free), 2))
    x = found.factored((values,)).solve(b)
    expected = np.linalg.solve(whole_matrix((mesh.dofs,), (values,), len(free)), b)
    np.testing.assert_allclose(x, expected, rtol=1e-7, atol=1e-9 * np.abs(x).max())


def test_a_deformation_is_known_of_its_own_displacements_alone(state):
    body, state = state
    other = replace(state, u=0.5 * state.u)
    assert state.known is not None and deformed_state(body, state) is state.known
    np.testing.assert_array_equal(deformed_state(body, other).F, deformation(body.mesh, other.u)[0])


def test_a_stiffness_that_is_no_number_has_no_answer():
    found, numbers = one_square(3, 8)
    assert found.factored(stiffness(numbers, {(3, 3): 1.0, (8, 8): np.nan})) is None
    assert found.factored(stiffness(numbers, {(3, 3): -1.0, (8, 8): np.inf})) is None


def chain():
    """A row of squares, and symmetric stiffnesses of which as many eigenvalues are negative as positive."""
    mesh = section_mesh(np.linspace(0.0, 1.0, 61), np.array([0.0, 1.0]))
    free = np.arange(6, mesh.nodes.size)
    values = np.random.default_rng(4).normal(size=(len(mesh.cells), 18, 18))
    return mesh, free, values + values.swapaxes(1, 2)


def test_an_indefinite_matrix_is_solved_to_rounding_and_its_inertia_told():
    mesh, free, values = chain()
    found = pattern(mesh, (mesh.dofs,), free, np.array([mesh.nodes.size])).factored((values,))
    K = whole_matrix((mesh.dofs,), (values,), mesh.nodes.size)[np.ix_(free, free)]
    assert found.negative == np.count_nonzero(np.linalg.eigvalsh(K) < 0.0) > 100
    b = np.random.default_rng(5).normal(size=len(free))
    np.testing.assert_allclose(K @ found.solve(b), b, atol=1e-10)


def test_what_touches_in_one_state_need_not_touch_in_the_next():
    """Springs between far nodes, other ones in each state; the pattern of the same ones is itself."""
    mesh, free, values = chain()
    values = values @ values
    one, other = (np.array([[8, mesh.nodes.size - k], [9, mesh.nodes.size - k + 1]]) for k in (4, 40))
    spring = np.tile(50.0 * np.array([[1.0, -1.0], [-1.0, 1.0]]), (2, 1, 1))
    first = pattern(mesh, (mesh.dofs, one), free, np.array([mesh.nodes.size]))
    assert first.following((mesh.dofs, one.copy())) is first
    b = np.random.default_rng(5).normal(size=len(free))
    for numbers in ((mesh.dofs, one), (mesh.dofs, other), (mesh.dofs,)):
        each = (values, spring)[: len(numbers)]
        x = first.following(numbers).factored(each).solve(b)
        K = whole_matrix(numbers, each, mesh.nodes.size)[np.ix_(free, free)]
        np.testing.assert_allclose(K @ x, b, atol=1e-9)
