"""Friction of free faces: its potential by differences, what Coulomb's law asks of a point, the contact with it."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.element.target import moved
from sits_mech.mechanics.faces.contact import Contact, Grip, gripped
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.scene.sensor import load_sensor
from tests.mechanics.derivatives import check_faces, shaken

NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
SLIP = 0.02


def points(m=40, reach=0.015):
    """A grip of m points in all directions, some of which stick and some slip, and the places of its points."""
    rng = np.random.default_rng(3)
    normal = rng.normal(size=(m, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return Grip(rng.uniform(0.1, 2.0, m), rng.normal(size=(m, 3)), normal, SLIP), reach * rng.normal(size=(m, 3))


def test_slope_and_curvature_are_those_of_the_energy():
    grip, away = points()
    y, h = grip.anchor + away, 1e-6
    energy, slope, curvature = grip(y)
    assert np.all(energy > 0.0)
    for axis in np.eye(3):
        up, down = grip(y + h * axis), grip(y - h * axis)
        np.testing.assert_allclose((up[0] - down[0]) / (2 * h), slope @ axis, atol=1e-7)
        np.testing.assert_allclose((up[1] - down[1]) / (2 * h), curvature @ axis, atol=1e-5 / SLIP)
    np.testing.assert_allclose(curvature, curvature.swapaxes(1, 2), atol=1e-12)
    assert np.linalg.eigvalsh(curvature).min() > -1e-9


def test_traction_is_along_the_surface_and_within_the_cone():
    """|tau| <= f p, equal where the slip is longer than the elastic one, along the slip, and never along the normal."""
    grip, away = points()
    tau = grip.traction(grip.anchor + away)
    along = away - (away * grip.normal).sum(axis=1)[:, None] * grip.normal
    size, slides = np.linalg.norm(tau, axis=1), np.linalg.norm(along, axis=1) > SLIP
    assert 5 < slides.sum() < 35  # both kinds are looked at
    assert np.all(size <= grip.largest * (1.0 + 1e-12))
    np.testing.assert_allclose(size[slides], grip.largest[slides], rtol=1e-12)
    np.testing.assert_allclose((tau * grip.normal).sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose((tau * along).sum(axis=1), size * np.linalg.norm(along, axis=1), rtol=1e-12)


def test_an_increment_begins_with_the_traction_of_the_last_one_as_far_as_the_pressure_holds_it():
    """A point that is pressed harder keeps its traction; one that is let go of keeps f p of it."""
    rng = np.random.default_rng(4)
    normal, place = np.tile([0.0, 0.0, 1.0], (3, 1)), rng.normal(size=(3, 3))
    before = np.tile([0.3, -0.4, 0.0], (3, 1))
    grip = gripped(np.array([1.0, 0.5, 0.1]), (place, before), normal, SLIP)
    np.testing.assert_allclose(grip.traction(place), before * np.array([1.0, 1.0, 0.2])[:, None], rtol=1e-12)


def held_contact(part, u, q):
    """A contact with friction in the midst of an increment: other places and tractions at its beginning."""
    y, p, normal = part.looked_at(u, q)
    rng = np.random.default_rng(5)
    start = (y + 0.02 * rng.normal(size=y.shape), 0.1 * rng.normal(size=y.shape))
    return replace(part, friction=0.7, grip=gripped(0.7 * p, start, normal, SLIP))


PLANES = [("ground", -0.3), ("plane", 0.1), ("wall", 0.008)]


@pytest.mark.parametrize(("plane", "lift"), PLANES)
def test_contact_with_friction_has_an_exact_tangent_at_any_turn(plane, lift):
    """Forces along du, dc and dw are the slope of the energy, and their change in the fixed frame the stiffness."""
    sizes = [f'elastomer.{key}="{size} mm"' for key, size in (("width", 8), ("length", 6), ("thickness", 2))]
    if plane == "wall":
        sizes += ['target.width="5 mm"', 'target.length="3 mm"']
    body = bonded_block(load_sensor("biorob2018", [NEO_HOOKEAN, *sizes]), 2, 1.5, 0.0, 0.05).body
    u, v = shaken(body, plane, lift)
    q = np.array([0.02, -0.01, 0.002, -0.01, 0.003, -0.2])
    bare = next(part for part in body.parts if isinstance(part, Contact) and part.plane == plane)
    assert check_faces(held_contact(bare, u, q), u, q, v, moved, rel=1e-5).energy > bare(u, q).energy > 0.0


def test_moving_with_its_surface_meets_no_friction():
    """A layer and its target that turn and shift together: what the target's plane does depends on neither."""
    sensor = load_sensor("biorob2018", [NEO_HOOKEAN, 'elastomer.width="8 mm"', 'target.width="8 mm"'])
    body = bonded_body(sensor, SectionFineness(4, 1.5, depth=0.05))
    part = next(part for part in body.parts if isinstance(part, Contact) and part.plane == "plane")
    u = np.tile([0.0, 0.05], len(body.mesh.nodes))
    contact, turn = held_contact(part, u, np.zeros(3)), 0.3
    R = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])  # clockwise in the x-z picture
    X = body.mesh.nodes - (0.0, 1.0)
    place = (X + (0.0, 0.05)) @ R.T + (0.2, 1.1)
    turned = contact((place - body.mesh.nodes).ravel(), np.array([0.2, 0.1, turn]))
    assert turned.energy == pytest.approx(contact(u, np.zeros(3)).energy, rel=1e-9)
