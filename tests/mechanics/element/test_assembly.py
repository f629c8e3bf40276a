"""Stiffnesses assembled straight into the equations: against the dense product with the map of the target's motion."""

import numpy as np
import pytest

from sits_mech.mechanics.element.assembly import factored, pattern
from sits_mech.mechanics.element.target import work_of_load
from sits_mech.mechanics.pad.section import Fineness, bonded_body
from sits_mech.mechanics.rest.body import rest
from sits_mech.mechanics.rest.newton import _factored, _gradient, target_stiffness
from sits_mech.mechanics.rest.path import follow
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def state():
    """A sheared, pressed layer with guard and contact."""
    body = bonded_body(load_sensor("biorob2018"), Fineness(2, 1.5, fan=True, guard=0.5, depth=1e-3))
    return body, follow(body, rest(body), (np.zeros(3), np.array([0.3, 5.0, 0.1]))).state


def test_equations_are_the_product_with_the_map_of_the_target(state):
    body, state = state
    n, found = state.u.size, _factored(body, state, _gradient(body, state))
    rows = np.concatenate([body.rows, *(part(state.u, state.q).rows for part in body.parts)])
    columns = np.concatenate([body.columns, *(part(state.u, state.q).columns for part in body.parts)])
    K = np.zeros((n + 6, n + 6))
    np.add.at(K, (rows, columns), found.values)
    P = np.zeros((n + 6, len(body.free) + 3))
    P[body.pattern.free, np.arange(len(body.free))] = 1.0
    P[body.pattern.border, -3:] = found.T[:, :3]
    A = P.T @ K @ P
    inner, side, corner = body.pattern.equations(found.values, found.T[:, :3])
    np.testing.assert_allclose(inner.toarray(), A[:-3, :-3], atol=1e-11 * np.abs(A).max())
    np.testing.assert_allclose(side, A[:-3, -3:], atol=1e-11 * np.abs(A).max())
    np.testing.assert_allclose(corner, A[-3:, -3:], atol=1e-11 * np.abs(A).max())
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


def test_singular_equations_have_no_answer():
    rows, columns = np.indices((3, 3)).reshape(2, -1)
    found = pattern(rows, columns, np.arange(2), np.array([2]))
    K, _, corner = found.equations(np.ones(9), np.ones((1, 3)))
    assert factored(K) is None
    np.testing.assert_array_equal(corner, np.ones((3, 3)))
