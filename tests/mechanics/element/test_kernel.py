"""The mixed element: forces and tangent against differences of the energy, the condensed pressure, the rigid target."""

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import Laws, element_forces
from sits_mech.mechanics.element.target import (
    between,
    bonded_displacement,
    bonded_tangent,
    moved,
    turning,
    work_of_load,
)
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.scene.sensor import load_sensor
from tests.mechanics.derivatives import check_elements


@pytest.fixture(scope="module", params=[False, True], ids=["plane", "axis"])
def body(request):
    return bonded_body(load_sensor("biorob2018"), SectionFineness(2, 1.5, fan=True, axial=request.param))


def test_forces_and_tangent_are_derivatives_of_the_energy(body):
    rng = np.random.default_rng(5)
    n = 2 * len(body.mesh.nodes)
    stiffness = check_elements(body.mesh, body.laws, 0.01 * rng.normal(size=n), rng.normal(size=n))
    np.testing.assert_allclose(stiffness, stiffness.transpose(0, 2, 1), atol=1e-9 * body.laws.K.max())


def test_silicone_that_is_larger_than_its_mesh_is_at_ease_when_it_fills_its_volume(body):
    """Stretched evenly to its volume it bears no pressure; held at the mesh's it does, K (1 - J_0) of its own K."""
    grown, zero = 1.02, np.zeros(2 * len(body.mesh.nodes))
    J_0 = grown ** (3 if body.mesh.hoop else 2)
    K, (law,) = float(body.laws.K.max()), body.laws.each
    laws = Laws((law._replace(K=K / J_0**2, swelling=J_0),))
    even = element_forces(body.mesh, laws, (grown - 1.0) * body.mesh.nodes.ravel())
    assert np.abs(even.pressure).max() < 1e-9 * K
    held = element_forces(body.mesh, laws, zero)
    volume = body.mesh.inside.weights.sum()
    assert held.energy == pytest.approx(0.5 * K * (1.0 / J_0 - 1.0) ** 2 * volume, rel=1e-12)


def test_forces_of_swelling_are_derivatives_of_the_energy(body):
    rng = np.random.default_rng(7)
    n = 2 * len(body.mesh.nodes)
    u, v, h = 0.01 * rng.normal(size=n), rng.normal(size=n), 1e-6
    laws = Laws((body.laws.each[0]._replace(swelling=1.05),))
    up, here, down = (element_forces(body.mesh, laws, u + s * h * v) for s in (1, 0, -1))
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(here.forces @ v, rel=1e-6)


def test_inverted_element_has_no_energy(body):
    u = np.zeros(2 * len(body.mesh.nodes))
    u[1::2] = -1.5 * body.mesh.nodes[:, 1]
    assert np.isinf(element_forces(body.mesh, body.laws, u).energy)


def test_rigid_target_keeps_its_length_and_sinks_at_its_right_edge():
    x, q = np.linspace(-2.0, 2.0, 9), np.array([0.3, -0.2, 0.4])
    X = np.column_stack([x, np.zeros((9, 2))])
    place = bonded_displacement(X, q) + X
    np.testing.assert_allclose(np.linalg.norm(np.diff(place, axis=0), axis=1), np.diff(x), rtol=1e-12)
    assert place[-1, 2] < place[0, 2]  # clockwise
    np.testing.assert_array_equal(place[:, 1], 0.0)


# in the plane, turned far in space, and upright
MOTIONS = [(0.3, -0.2, 0.4), (0.3, -0.2, 0.7, 0.1, -1.1, 1.6), (0.0,) * 6]
LOAD, HEIGHT = np.array([0.7, 1.3, -0.2, 0.4, 0.6, -0.5]), 0.1


def steps(k, h=1e-6):
    """Steps along each of k components, up and down."""
    return [(h * unit, -h * unit) for unit in np.eye(k)]


@pytest.mark.parametrize("q", MOTIONS, ids=["plane", "space", "rest"])
def test_tangent_of_the_rigid_target_is_exact(q):
    X, q, h = np.random.default_rng(2).normal(size=(7, 3)), np.array(q), 1e-6
    found = bonded_tangent(X, q)
    for k, (up, down) in enumerate(steps(len(q), h)):
        difference = (bonded_displacement(X, moved(q, up)) - bonded_displacement(X, moved(q, down))) / (2 * h)
        np.testing.assert_allclose(found[:, :, k], difference, atol=1e-9)


@pytest.mark.parametrize("q", MOTIONS, ids=["plane", "space", "rest"])
def test_turning_is_how_the_moments_of_fixed_forces_change(q):
    rng, q, h = np.random.default_rng(2), np.array(q), 1e-6
    X, forces, k = rng.normal(size=(7, 3)), rng.normal(size=(7, 3)), len(q)

    def on_target(q):
        """What bonded nodes' forces and the load leave on all six components."""
        return np.einsum("nik,ni->k", bonded_tangent(X, q), forces) - work_of_load(LOAD[:k], HEIGHT, q)

    found = turning(forces, X, LOAD[:k], HEIGHT, q)
    for column, (up, down) in enumerate(steps(k, h)):
        difference = (on_target(moved(q, up)) - on_target(moved(q, down))) / (2 * h)
        np.testing.assert_allclose(found[:, column], difference, atol=1e-8)


@pytest.mark.parametrize("q", MOTIONS[1:], ids=["space", "rest"])
def test_step_between_two_motions_leads_from_one_to_the_other(q):
    q, end = np.array(q), np.array([-0.2, 0.1, 0.5, 0.3, 0.9, -0.4])
    np.testing.assert_allclose(moved(q, between(q, end)), end, atol=1e-12)
    step = between(q, end)
    np.testing.assert_allclose(between(q, moved(q, step)), step, atol=1e-12)


def test_in_the_plane_a_dead_load_has_a_potential():
    """Lowered by the work: along F what the force's point moves, at `HEIGHT` above the face, and M times the turn."""
    load, q, h = LOAD[:3], np.array([0.3, -0.2, 0.4]), 1e-6

    def potential(q):
        d_h, d_z, alpha = q
        return -(load @ [d_h + HEIGHT * np.sin(alpha), -(d_z + HEIGHT * np.cos(alpha)), alpha])

    found = work_of_load(load, HEIGHT, q)
    for k, (up, down) in enumerate(steps(3, h)):
        assert -(potential(q + up) - potential(q + down)) / (2 * h) == pytest.approx(found[k], rel=1e-8)
    np.testing.assert_array_equal(found[3:], 0.0)


def test_a_dead_load_works_with_the_motion_of_its_point():
    """Virtual work in space: F by the displacement of a point of the target, M by the turn about fixed axes."""
    q, h = np.array(MOTIONS[1]), 1e-6
    F, M = LOAD[[0, 3, 1]] * [1, 1, -1], LOAD[[4, 2, 5]]
    point, found = np.array([[0.0, 0.0, HEIGHT]]), work_of_load(LOAD, HEIGHT, q)
    for k, (up, down) in enumerate(steps(6, h)):
        along = (bonded_displacement(point, moved(q, up)) - bonded_displacement(point, moved(q, down)))[0] / (2 * h)
        turn = np.zeros(6)
        turn[[4, 2, 5]] = M
        assert found[k] == pytest.approx(F @ along + turn[k], rel=1e-8, abs=1e-9)
