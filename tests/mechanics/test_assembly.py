"""Stiffnesses assembled straight into the equations: against the dense product with the map of the target's motion."""

import numpy as np
import pytest

from sits_mech.mechanics.assembly import pattern, solved_in_order
from sits_mech.mechanics.newton import felt, linearised
from sits_mech.mechanics.pad import Fineness, bonded_body
from sits_mech.mechanics.path import follow, rest
from sits_mech.mechanics.target import load_potential
from sits_mech.sensor import load_sensor


@pytest.fixture(scope="module")
def state():
    """A sheared, pressed layer with guard and contact."""
    body = bonded_body(load_sensor("biorob2018"), Fineness(2, 1.5, fan=True, guard=0.5, give=1e-3))
    return body, follow(body, rest(body), (np.zeros(3), np.array([0.3, 5.0, 0.1]))).state


def test_equations_are_the_product_with_the_map_of_the_target(state):
    body, state = state
    n, found = state.u.size, linearised(body, state)
    rows = np.concatenate([body.rows, *(part(state.u, state.q).rows for part in body.parts)])
    columns = np.concatenate([body.columns, *(part(state.u, state.q).columns for part in body.parts)])
    K = np.zeros((n + 3, n + 3))
    np.add.at(K, (rows, columns), found.values)
    P = np.zeros((n + 3, len(body.free) + 3))
    P[body.pattern.free, np.arange(len(body.free))] = 1.0
    P[body.pattern.border, -3:] = found.T
    A = P.T @ K @ P
    inner, side, corner = body.pattern.equations(found.values, found.T)
    np.testing.assert_allclose(inner.toarray(), A[:-3, :-3], atol=1e-11 * np.abs(A).max())
    np.testing.assert_allclose(side, A[:-3, -3:], atol=1e-11 * np.abs(A).max())
    np.testing.assert_allclose(corner, A[-3:, -3:], atol=1e-11 * np.abs(A).max())
    A[-1, -1] += found.turning
    S = np.linalg.inv(np.linalg.inv(A)[-3:, -3:])
    np.testing.assert_allclose(felt(body, state), S, rtol=1e-7, atol=1e-7 * np.abs(S).max())


def test_felt_stiffness_is_the_change_of_the_forces_that_hold_the_target(state):
    body, state = state
    h, held = 1e-5, np.ones(3, dtype=bool)

    def forces(q):
        """What acts on d_h, d_z and alpha, by the load that holds the target there."""
        load = follow(body, state, (state.q, q), held=held).state.load
        return -load_potential(load, body.height, q)[1]

    S = felt(body, state)
    fixed = load_potential(state.load, body.height, state.q)[2] * np.diag([0.0, 0.0, 1.0])
    for k, unit in enumerate(np.eye(3)):
        change = (forces(state.q + h * unit) - forces(state.q - h * unit)) / (2 * h)
        np.testing.assert_allclose(S[:, k] - fixed[:, k], change, rtol=1e-4, atol=1e-5 * np.abs(S).max())


def test_singular_equations_have_no_answer():
    rows, columns = np.indices((3, 3)).reshape(2, -1)
    found = pattern(rows, columns, np.arange(2), np.array([2]))
    K, side, corner = found.equations(np.ones(9), np.ones((1, 3)))
    assert solved_in_order(K, side) is None
    np.testing.assert_array_equal(corner, np.ones((3, 3)))
