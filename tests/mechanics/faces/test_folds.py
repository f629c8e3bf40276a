"""Free faces held against each other: derivatives, balance, blocks that a gap parts, slots of a user's mesh."""

from pathlib import Path

import numpy as np
import pytest
from skfem import MeshHex

from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, section_mesh, solid_mesh
from sits_mech.mechanics.faces.folds import SelfContact, section_skin, solid_skin
from sits_mech.meshing.store import read_solid

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
    mesh = read_solid(SLOTTED, ("ground", "target", "free")).scaled(1e3)
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


@pytest.mark.parametrize("state", [pressed_cubes, slotted, folded])
def test_contact_is_exact_and_in_balance(state):
    """Two derivatives; no force and no moment on the whole; nothing on other faces than the pairs'."""
    section, skin, u = state()
    rng, n, d, q, h = np.random.default_rng(0), u.size, section.nodes.shape[1], np.zeros(6), 1e-6
    u = u + 1e-3 * rng.normal(size=n)
    contact, v = SelfContact(skin, DEPTH).near(u), rng.normal(size=n + 6)
    found, up, down = (contact(u + step * v[:n], q) for step in (0.0, h, -h))
    assert found.energy > 0.0 and contact.near(u) is contact and SelfContact(skin, DEPTH)(u, q).energy == found.energy
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(found.forces @ v, rel=1e-5)
    product = summed(found.rows, found.values * v[found.columns], n + 6)
    np.testing.assert_allclose(product, (up.forces - down.forces) / (2 * h), atol=1e-4 * np.abs(product).max())
    back = summed(found.columns, found.values * v[found.rows], n + 6)
    np.testing.assert_allclose(back, product, atol=1e-10 * np.abs(product).max())
    forces, places = found.forces[:n].reshape(-1, d), section.nodes + u.reshape(-1, d)
    size = np.abs(forces).sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-13 * size)
    for a in range(d):
        for b in range(a):
            assert abs((places[:, a] * forces[:, b] - places[:, b] * forces[:, a]).sum()) < 1e-12 * size


def test_faces_at_rest_hold_nothing():
    for state in (pressed_cubes, slotted, folded):
        _, skin, u = state()
        assert SelfContact(skin, DEPTH)(np.zeros(u.size), np.zeros(6)).energy == 0.0
