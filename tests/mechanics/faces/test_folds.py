"""Free faces held against each other: derivatives, balance, blocks that a gap parts, slots of a user's mesh."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq
from skfem import MeshHex

from sits_mech.geometry.meshing.store import read_solid
from sits_mech.mechanics.element.kernel import element_forces, summed
from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, section_mesh, solid_mesh
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.outcome import Path as LoadPath
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.faces.face_contact import contacts, face_contact, face_notes
from sits_mech.mechanics.faces.folds import SelfContact
from sits_mech.mechanics.faces.skin import section_skin, solid_skin
from sits_mech.mechanics.pad.shapes import outlines
from sits_mech.mechanics.pad.solid import numbered, solid
from sits_mech.notes import Note, NoteKind
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import load_sensor

SLOTTED = Path(__file__).parents[3] / "meshes" / "slotted.msh"
DEPTH = 0.05


def two_bricks(gap, cells=2):
    """Two unit cubes above each other, a gap between them; the skin is the faces before the gap."""
    line = np.linspace(0.0, 1.0, cells + 1)
    low = MeshHex.init_tensor(line, line, line)
    high = MeshHex.init_tensor(line, line, 1.0 + gap + np.linspace(0.0, 1.0, 2 * cells + 1))
    section, basis = solid_mesh(MeshHex(*joined(low, high)), BRICK)
    z = basis.mesh.p[2, basis.mesh.facets]
    facets = np.flatnonzero(np.all((z > 1.0 - 1e-9) & (z < 1.0 + gap + 1e-9), axis=0))
    return section, solid_skin(basis, facets)


def joined(one, other):
    """Points and cells of two meshes."""
    return np.hstack([one.p, other.p]), np.hstack([one.t, other.t + one.p.shape[1]])


def slotted():
    """The slotted pad of the meshes' folder, its walls drawn over each other a little."""
    mesh = read_solid(SLOTTED, ("ground", "target", "free")).mesh.scaled(1e3)
    section, basis = solid_mesh(mesh, TETRAHEDRON)
    x, _, z = section.nodes.T
    drawn = np.where((np.abs(x) < 2.0) & (z < 1.0), 0.52 * np.minimum(1.0, (2.0 - np.abs(x)) / 1.5), 0.0)
    u = np.zeros_like(section.nodes)
    u[:, 0] = -np.sign(x) * drawn * np.sqrt(np.maximum(1.0 - z, 0.0))
    return section, solid_skin(basis, mesh.boundaries["free"]), u.ravel()


def folded():
    """A section whose right face is folded upon itself."""
    mesh = section_mesh(np.linspace(0.0, 2.0, 3), np.linspace(0.0, 1.0, 13))
    sides = [np.flatnonzero(np.abs(mesh.nodes[:, 0] - end) < 1e-9) for end in (0.0, 2.0)]
    lines = [side[np.argsort(mesh.nodes[side, 1])] for side in sides]
    s = mesh.nodes[:, 1] - 0.5
    u = np.zeros_like(mesh.nodes)
    on = mesh.nodes[:, 0] > 1.9
    u[on, 0] = 0.7 * np.abs(s[on])
    u[on, 1] = (-0.01 * np.sign(s) - 1.02 * s)[on] * (np.abs(s[on]) > 0.1)
    return mesh, section_skin(mesh, lines), u.ravel()


def pressed_cubes():
    section, skin = two_bricks(0.1)
    u = np.zeros_like(section.nodes)
    u[section.nodes[:, 2] > 1.05] = 0.13, 0.07, -0.12
    return section, skin, u.ravel()


@pytest.mark.parametrize("state", [pressed_cubes, pytest.param(slotted, marks=pytest.mark.slow), folded])
def test_contact_is_exact_and_in_balance(state):
    """Two derivatives; no force and no moment on the whole; nothing on other faces than the pairs'."""
    section, skin, u = state()
    rng, n, d, q, h = np.random.default_rng(0), u.size, section.nodes.shape[1], np.zeros(6), 1e-6
    u = u + 1e-3 * rng.normal(size=n)
    contact, v = SelfContact(skin, DEPTH).near(u), rng.normal(size=n + 6)
    found, up, down = (contact(u + step * v[:n], q) for step in (0.0, h, -h))
    assert found.energy > 0.0 and contact.near(u) is contact and SelfContact(skin, DEPTH)(u, q).energy == found.energy
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(found.forces @ v, rel=1e-5)
    product = summed(found.numbers, found.stiffness @ v[found.numbers][..., None], n + 6)
    np.testing.assert_allclose(product, (up.forces - down.forces) / (2 * h), atol=1e-4 * np.abs(product).max())
    own = found.stiffness
    np.testing.assert_allclose(own, own.swapaxes(1, 2), atol=1e-12 * np.abs(own).max())
    forces, places = found.forces[:n].reshape(-1, d), section.nodes + u.reshape(-1, d)
    size = np.abs(forces).sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-13 * size)
    for a in range(d):
        for b in range(a):
            assert abs((places[:, a] * forces[:, b] - places[:, b] * forces[:, a]).sum()) < 1e-12 * size


@pytest.mark.slow
def test_faces_at_rest_hold_nothing():
    for state in (pressed_cubes, slotted, folded):
        _, skin, u = state()
        assert SelfContact(skin, DEPTH)(np.zeros(u.size), np.zeros(6)).energy == 0.0


def scene(width, length):
    """A pad of some thicknesses under a target as large, 1 mm thick, K = 50 shear moduli."""
    sizes = [f'elastomer.{side}="{value} mm"' for side, value in (("width", width), ("length", length))]
    sizes += [f'target.{side}="{value} mm"' for side, value in (("width", width), ("length", length))]
    law = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=1.5e6}'
    return load_sensor("biorob2018", ["target.load_height=0", 'elastomer.thickness="1 mm"', law, *sizes])


def pad_of(mesh, sensor, depth, half=False):
    """A body on bricks between z = 0 and z = 1."""
    section, basis = solid_mesh(mesh, BRICK)
    _, y, z = section.nodes.T
    where = np.stack([z < 1e-9, z > 1.0 - 1e-9, (np.abs(y) < 1e-9) & half])
    plate, _ = outlines(sensor.target, sensor.elastomer)
    own = numbered(section, where, basis, plate, half=bool(np.any(where[2])), convex=False)
    if half:  # whose faces do not reach the plane of symmetry
        faces = replace(own.faces, mirror=0.0)
        own = replace(own, faces=faces, surfaces=(*own.surfaces, ("mirror", own.faces.skin.surface)))
    return solid(sensor, own, 0.0, depth).body


def before_gap(body, depth):
    """The self-contact of a body, of those faces alone that look up or down: the sides of two blocks stay in line."""
    skin = body.parts[-1].skin
    on = np.abs(skin.rest[2][:, 2]).reshape(len(skin.facets), -1).min(axis=1) > 0.5
    return (SelfContact(skin.some(on), depth),)


def held_at(body, *places):
    """The state at the last of some places of the target, all components held."""
    k = body.components
    state, before = rest(body), np.zeros(k)
    for place in places:
        end = np.array(place + (0.0,) * (k - 3))
        found = advance(body, state, LoadPath((before, end), np.ones(k, dtype=bool)))
        assert found.reached == 1.0 and found.state.min_J > 0.0
        state, before = found.state, end
    return state


def confined(counts, layers, depth, *sinks):
    """The force on two blocks of some cells across, a gap of 0.1 between them, that have no room to the sides."""
    lines = [np.linspace(-0.5, 0.5, count + 1) for count in counts]
    levels = (np.linspace(0.0, 0.45, layers + 1), np.linspace(0.55, 1.0, layers + 1))
    blocks = [MeshHex.init_tensor(line, line, level) for line, level in zip(lines, levels, strict=True)]
    body = pad_of(MeshHex(*joined(*blocks)), scene(1.0, 1.0), 1e-4)
    parts = before_gap(body, depth)
    body = replace(body, free=body.free[body.free % 3 == 2], parts=parts, shared=None, hidden=None)
    return held_at(body, *((0.0, -sink, 0.0) for sink in sinks)).load[1]


def uniaxial(sink, depth, gap=0.1, K=50.0):
    """The same force in closed form, silicone and contact by their laws."""

    def stress(s):  # of isochoric neo-Hookean silicone with K/2 (J - 1)^2
        return -(s ** (1.0 / 3.0) * (2.0 / 3.0) * (1.0 - s**-2.0) + K * (s - 1.0))

    def left(p):  # both faces press over the depth d: p = 2 (d/h - 1/2)
        d = depth * ((p + 1.0) / 2.0 if p > 1.0 else np.sqrt(p))
        return stress(1.0 - (sink - gap - d) / 0.9) - p

    return brentq(left, 1e-6, 100.0)


@pytest.mark.slow
def test_two_blocks_become_one_where_the_gap_has_closed():
    """Pressed without room to the sides, by 0.7 and 1.6 shear moduli: uniaxial strain."""
    assert abs(confined((3, 3), 1, 1e-2, 0.09)) < 1e-9
    for sink in (0.12, 0.14):
        assert confined((3, 3), 1, 1e-2, 0.09, 0.11, sink) == pytest.approx(uniaxial(sink, 1e-2), rel=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("depth", [pytest.param(1e-2, marks=pytest.mark.slow), 1e-4])
def test_blocks_of_meshes_that_do_not_match_become_one(depth):
    """Of 2 and of 3 cells across: an even pressure stays one, whatever the depth of contact."""
    assert confined((2, 3), 1, depth, 0.09, 0.11, 0.12) == pytest.approx(uniaxial(0.12, depth), rel=3e-3)


@pytest.mark.slow
def test_meshes_that_do_not_match_converge():
    expected = uniaxial(0.12, 1e-2)
    rough, fine = (confined(counts, n, 1e-2, 0.09, 0.11, 0.12) for counts, n in (((2, 3), 1), ((4, 5), 2)))
    assert abs(expected - fine) < 0.3 * abs(expected - rough) < 1e-3 * expected


def test_an_even_pressure_is_even_on_the_nodes_of_a_section_that_does_not_match():
    """Faces of 2 and of 3 edges stand behind each other throughout; loads of a pressure on quadratic edges: 1, 4, 1.

    Five points on an edge leave up to 7 % of a node's load with its neighbours.
    """
    z, other = np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1.0, 7)
    nodes = np.concatenate([np.stack([1.0 + 0 * z, z], axis=1), np.stack([1.0 + 0 * other, other], axis=1)])
    skin = section_skin(SimpleNamespace(nodes=nodes, hoop=False), [5 + np.arange(7), np.arange(5)])
    u = np.zeros_like(nodes)
    u[:5, 0] = 0.01  # the face on the left looks to the right
    found = SelfContact(skin, 0.01)(u.ravel(), np.zeros(6))
    forces = found.forces[:-6].reshape(-1, 2)
    np.testing.assert_allclose(forces[:5, 0], 2 * 0.5 / 12.0 * np.array([1, 4, 2, 4, 1]), rtol=0.08)
    np.testing.assert_allclose(forces[5:, 0], -2 * 0.5 / 18.0 * np.array([1, 4, 2, 4, 2, 4, 1]), rtol=0.08)
    np.testing.assert_allclose(forces[:, 1], 0.0, atol=1e-12)


@pytest.mark.parametrize("state", [pressed_cubes, pytest.param(slotted, marks=pytest.mark.slow)])
def test_contact_turns_with_the_pad(state):
    """Energy stays and forces turn in any rigid motion."""
    section, skin, u = state()
    turn, move = rotation_matrix(np.array([0.5, -0.3, 1.1])), np.array([0.3, -0.2, 0.1])
    turned = ((section.nodes + u.reshape(-1, 3)) @ turn.T + move - section.nodes).ravel()
    here, there = (SelfContact(skin, DEPTH)(each, np.zeros(6)) for each in (u, turned))
    assert there.energy == pytest.approx(here.energy, rel=1e-9)
    forces = here.forces[:-6].reshape(-1, 3) @ turn.T
    np.testing.assert_allclose(there.forces[:-6].reshape(-1, 3), forces, atol=1e-8 * np.abs(forces).max())


@pytest.mark.slow
def test_what_passes_through_without_contact_is_seen_and_named():
    """As in "never", and by what decides that "auto" solves it again."""
    gap, sensor = 0.05, scene(1.0, 1.7)
    both = MeshHex(*joined(block_of((gap, 0.85)), block_of((-0.85, -gap))))
    body = pad_of(both, sensor, 0.0)
    u, q = np.zeros(body.mesh.nodes.shape), np.zeros(6)
    found = face_contact(body.faces, body.mesh, body.parts, u.ravel(), q)
    assert not (found.crossing or found.missed or found.touch)
    y, z = body.mesh.nodes[:, 1:].T
    u[:, 1] = -0.3 * np.sign(y) * z * (1.0 - z)
    found = face_contact(body.faces, body.mesh, body.parts, u.ravel(), q)
    assert found.crossing and found.missed and found.touch and not found.held
    notes = face_notes(body.faces, body.mesh, body.parts, u.ravel(), q, 0.1)
    assert any(note.kind is NoteKind.FACES_CROSS for note in notes)
    parts = contacts(body.faces, (), 1e-4)
    notes = face_notes(body.faces, body.mesh, parts, u.ravel(), q, 0.1)
    assert notes == (Note(NoteKind.FACES_TOUCH),)


def block_of(ends):
    """Bricks over x in (-0.5, 0.5), y between the ends, z in (0, 1)."""
    y = np.linspace(*ends, 4)
    return MeshHex.init_tensor(np.linspace(-0.5, 0.5, 4), y, np.array([0.0, 0.15, 0.35, 0.65, 0.85, 1.0]))


@pytest.mark.slow
def test_blocks_that_bulge_into_each_other_are_one_that_meets_its_image():
    """Two mirror images against each other, six components of motion, and half of it against the plane between."""
    sensor, gap, place = scene(1.0, 1.7), 0.05, ((0.0, -0.2, 0.0), (0.05, -0.22, 0.01))
    both = MeshHex(*joined(block_of((gap, 0.85)), block_of((-0.85, -gap))))
    half = 2.0 * held_at(pad_of(block_of((gap, 0.85)), sensor, 1e-4, half=True), *place).load[:3]
    apart = held_at(replace(pad_of(both, sensor, 0.0), parts=()), *place)
    whole = held_at(pad_of(both, sensor, 1e-4), *place)
    assert np.max(np.abs(whole.load[3:])) < 1e-4 * whole.load[1]  # its own mirror image
    away = np.max(np.abs(whole.load[:3] - half)) / half[1]
    assert away < 0.003  # what the depth of contact is worth
    assert half[1] - apart.load[1] > 4.0 * away * half[1]  # contact stiffens by more


@pytest.mark.slow
def test_work_is_the_energy_stored_between_two_blocks():
    sensor, gap, h = scene(1.0, 1.7), 0.05, 1e-4
    both = MeshHex(*joined(block_of((gap, 0.85)), block_of((-0.85, -gap))))
    body, place = pad_of(both, sensor, 1e-4), np.array([0.05, -0.22, 0.0])
    middle, way = held_at(body, (0.0, -0.2, 0.0), tuple(place)), np.array([0.5, -1.0, 0.3])
    on = body.near(middle.u)
    assert on.parts[-1](middle.u, middle.q).energy > 1e-5
    energies = []
    for s in (1, -1):
        corners = (middle.q, np.concatenate([place + s * h * way, np.zeros(3)]))
        state = advance(body, middle, LoadPath(corners, np.ones(6, dtype=bool))).state
        parts = sum(part(state.u, state.q).energy for part in body.parts)
        energies.append(element_forces(body.mesh, body.laws, state.u).energy + parts)
    forces = middle.load[:3] * [1.0, -1.0, 1.0]
    assert (energies[0] - energies[1]) / (2 * h) == pytest.approx(forces @ way, rel=1e-5)
