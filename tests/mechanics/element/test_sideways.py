"""Bodies about an axis: even strain, volume, and what rigid motions meet in the first harmonic."""

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import deformation, element_forces, summed
from sits_mech.mechanics.element.sideways import harmonic_stiffness
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.scene.sensor import load_sensor

SHARP = 'elastomer={material="ecoflex-00-30", diameter="10 mm", thickness="2 mm"}'
ROUNDED = 'elastomer={material="ecoflex-00-30", diameter="10 mm", thickness="2 mm", edge_radius="0.4 mm"}'
DISC = 'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}'


@pytest.fixture(scope="module", params=[SHARP, ROUNDED], ids=["sharp", "rounded"])
def body(request):
    return bonded_body(load_sensor("biorob2018", [request.param, DISC]), SectionFineness(4, 2.0, fan=True, axial=True))


def harmonic_forces(body, u, motion):
    """Forces (n, 3) of a motion (n, 3) of m, n, c."""
    pressure = element_forces(body.mesh, body.laws, u).pressure
    numbers = (3 * body.mesh.cells[:, None, :] + np.arange(3)[:, None]).reshape(len(body.mesh.cells), -1)
    each = harmonic_stiffness(body.mesh, body.laws, u, pressure) @ motion.ravel()[numbers][..., None]
    return summed(numbers, each, motion.size).reshape(motion.shape)


def test_even_strain_has_one_hoop_and_no_forces_inside(body):
    """u_r = a r, u_z = b z, on the axis and in the corners' triangles, too."""
    mesh, (a, b) = body.mesh, (0.03, -0.05)
    u = (mesh.nodes * (a, b)).ravel()
    for at in (mesh.inside, mesh.nodal):
        F, J = deformation(mesh, u, at)
        np.testing.assert_allclose(F - [1 + a, 0, 0, 0, 1 + a, 0, 0, 0, 1 + b], 0.0, atol=1e-12)
        np.testing.assert_allclose(J, (1 + a) ** 2 * (1 + b), rtol=1e-12)
    found = element_forces(mesh, body.laws, u)
    surface = body.faces.skin.surface.nodes
    inner = np.setdiff1d(body.free, np.concatenate([2 * surface.ravel(), 2 * surface.ravel() + 1]))
    assert np.abs(found.forces[inner]).max() < 1e-9 * np.abs(found.forces).max()


def test_weights_are_those_of_full_turns():
    body = bonded_body(load_sensor("biorob2018", [SHARP, DISC]), SectionFineness(4, 2.0, fan=True, axial=True))
    assert body.mesh.inside.weights.sum() == pytest.approx(np.pi * 2.5**2, rel=1e-12)
    side = 2 * np.pi * 2.5 + np.pi * (2.5**2 - 2.0**2)
    assert body.faces.skin.surface.weight.sum() == pytest.approx(side, rel=1e-12)


def test_rigid_motions_meet_no_force_at_rest(body):
    r, z = body.mesh.nodes.T
    zero = np.zeros_like(r)
    shifted, turned = np.stack([zero + 1, zero, zero], axis=1), np.stack([z, zero, -r], axis=1)
    for motion in (shifted, turned):
        assert np.abs(harmonic_forces(body, np.zeros(2 * len(r)), motion)).max() < 1e-11 * body.laws.K.max()


def test_a_shift_meets_no_force_and_a_turn_turns_the_forces_that_act(body):
    """As the deformed body turns by alpha along y its forces f turn with it: in their mean over a turn, too."""
    mesh = body.mesh
    u = (mesh.nodes * (0.02, -0.06)).ravel()
    forces = element_forces(mesh, body.laws, u).forces
    (r, z), (f_r, f_z), zero = (mesh.nodes * (1.02, 0.94)).T, forces.reshape(-1, 2).T, np.zeros(len(mesh.nodes))
    assert np.abs(harmonic_forces(body, u, np.stack([zero + 1, zero, zero], axis=1))).max() < 1e-11 * body.laws.K.max()
    found = harmonic_forces(body, u, np.stack([z, zero, -r], axis=1))
    np.testing.assert_allclose(found, 0.5 * np.stack([2 * f_z, zero, -f_r], axis=1), atol=1e-11 * body.laws.K.max())
