"""The mixed element: forces and tangent against differences of the energy, the condensed pressure, the rigid target."""

import numpy as np
import pytest

from sits_mech.mechanics.forms import stored_energy, tangent
from sits_mech.mechanics.pad import Fineness, bonded_body
from sits_mech.mechanics.target import bonded_displacement, bonded_tangent, load_potential
from sits_mech.sensor import load_sensor


@pytest.fixture(scope="module")
def body():
    return bonded_body(load_sensor("biorob2018"), Fineness(2, 1.5, fan=True))


def test_forces_and_tangent_are_derivatives_of_the_energy(body):
    rng = np.random.default_rng(5)
    n = 2 * len(body.mesh.nodes)
    u, v = 0.01 * rng.normal(size=n), rng.normal(size=n)
    found, h = tangent(body.mesh, body.law, body.K, u), 1e-6
    up, down = (tangent(body.mesh, body.law, body.K, u + s * h * v) for s in (1, -1))
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(found.forces @ v, rel=1e-6)
    assert found.energy == pytest.approx(stored_energy(body.mesh, body.law, body.K, u), rel=1e-12)
    product = np.zeros(n)
    np.add.at(product, body.mesh.dofs, np.einsum("eij,ej->ei", found.stiffness, v[body.mesh.dofs]))
    difference = (up.forces - down.forces) / (2 * h)
    np.testing.assert_allclose(product, difference, rtol=1e-5, atol=1e-6 * np.abs(difference).max())
    np.testing.assert_allclose(found.stiffness, found.stiffness.transpose(0, 2, 1), atol=1e-9 * body.K)


def test_inverted_element_has_no_energy(body):
    u = np.zeros(2 * len(body.mesh.nodes))
    u[1::2] = -1.5 * body.mesh.nodes[:, 1]
    assert np.isinf(stored_energy(body.mesh, body.law, body.K, u))


def test_rigid_target_keeps_its_length_and_its_tangent_is_exact():
    X, q = np.linspace(-2.0, 2.0, 9), np.array([0.3, -0.2, 0.4])
    place = bonded_displacement(X, q) + np.column_stack([X, np.zeros(9)])
    np.testing.assert_allclose(np.linalg.norm(np.diff(place, axis=0), axis=1), np.diff(X), rtol=1e-12)
    assert place[-1, 1] < place[0, 1]  # clockwise: the right edge sinks
    first, second = bonded_tangent(X, 0.4)
    h = 1e-6
    for k in range(3):
        step = h * np.eye(3)[k]
        difference = (bonded_displacement(X, q + step) - bonded_displacement(X, q - step)) / (2 * h)
        np.testing.assert_allclose(first[:, :, k], difference, atol=1e-9)
    turned = (bonded_tangent(X, 0.4 + h)[0] - bonded_tangent(X, 0.4 - h)[0])[:, :, 2] / (2 * h)
    np.testing.assert_allclose(second, turned, atol=1e-8)


def test_load_potential_derivatives():
    load, height, q, h = np.array([0.7, 1.3, -0.2]), 0.1, np.array([0.3, -0.2, 0.4]), 1e-6
    _, gradient, curvature = load_potential(load, height, q)
    for k in range(3):
        step = h * np.eye(3)[k]
        up, down = load_potential(load, height, q + step), load_potential(load, height, q - step)
        assert (up[0] - down[0]) / (2 * h) == pytest.approx(gradient[k], rel=1e-8)
    assert (up[1][2] - down[1][2]) / (2 * h) == pytest.approx(curvature, rel=1e-7)
