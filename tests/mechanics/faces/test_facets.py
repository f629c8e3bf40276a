"""Free faces that pass through one another: a pad rolled up, slots that close, and what may not be called so."""

from pathlib import Path

import numpy as np
import pytest
from skfem import MeshHex

from sits_mech.geometry.meshing.store import read_solid
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, solid_mesh
from sits_mech.mechanics.faces.facets import is_monotone, skin, triangles_cross

SLOTTED = Path(__file__).parents[3] / "meshes" / "slotted.msh"


@pytest.fixture(scope="module")
def bar():
    """A bar of 10 x 1 x 1, its faces but the lower and the upper one."""
    mesh = MeshHex.init_tensor(np.linspace(0.0, 10.0, 9), np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.5, 1.0]))
    section, basis = solid_mesh(mesh, BRICK)
    facets = mesh.boundary_facets()
    return section, skin(basis, facets)


def rolled(nodes, turns):
    """A bar rolled up by some turns, to one side a little so that its ends pass each other by half their width."""
    radius = 10.0 / (2.0 * np.pi * turns) + nodes[:, 2] - 0.5
    angle = nodes[:, 0] * 2.0 * np.pi * turns / 10.0
    x, z = radius * np.sin(angle), radius * np.cos(angle)
    return np.stack([x, nodes[:, 1] + 0.05 * nodes[:, 0], z], axis=1)


@pytest.mark.parametrize(("turns", "crossing"), [(0.5, False), (0.95, False), (1.05, True)])
def test_a_bar_rolled_up_crosses_itself_from_one_turn_on(bar, turns, crossing):
    """Every cell keeps its orientation: no other check can see it."""
    section, faces = bar
    place = rolled(section.nodes, turns)
    F, J = deformation(section, (place - section.nodes).ravel())
    assert J.min() > 0.0 and not is_monotone(F)
    assert triangles_cross(faces, place) == crossing


def test_what_no_two_points_can_have_met_in_is_known(bar):
    """Sheared and pressed, by less than makes the symmetric part of F lose its sign."""
    section, faces = bar
    for shear, crushed in ((0.5, 0.3), (1.2, 0.0), (0.0, -0.9)):
        place = section.nodes @ np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [shear, 0.1, 1.0 - crushed]])
        assert is_monotone(deformation(section, (place - section.nodes).ravel())[0])
        assert not triangles_cross(faces, place)


@pytest.mark.parametrize(("moved", "crossing"), [(0.4, False), (0.6, True)])
def test_walls_of_a_slot_that_pass_each_other(moved, crossing):
    """Half a pad of 20 x 20 x 2 mm; the slot in its middle is 1 mm wide, and each wall goes `moved` mm."""
    mesh = read_solid(SLOTTED, ("ground", "target", "free")).mesh.scaled(1e3)
    section, basis = solid_mesh(mesh, TETRAHEDRON)
    faces = skin(basis, mesh.boundaries["free"])
    x, _, z = section.nodes.T
    near = np.abs(x) < 2.0
    drawn = np.where(near & (z < 1.0), moved * (1.0 - z) * np.minimum(1.0, (2.0 - np.abs(x)) / 1.5), 0.0)
    place = section.nodes - np.stack([np.sign(x) * drawn, 0.0 * x, 0.0 * x], axis=1)
    assert not triangles_cross(faces, section.nodes, plane=0.0)
    assert triangles_cross(faces, place, plane=0.0) == crossing


def test_half_a_pad_meets_its_image(bar):
    """Where it is cut, which need not be y = 0 to the last digit."""
    section, faces = bar
    assert not triangles_cross(faces, section.nodes - [0.0, 0.01, 0.0], plane=-0.01)
    assert triangles_cross(faces, section.nodes - [0.0, 0.01, 0.0], plane=0.0)
    assert not triangles_cross(faces, section.nodes - [0.0, 0.01, 0.0])


def test_slender_faces_are_compared_in_blocks(bar, monkeypatch):
    """A bar stretched to a hair has each triangle within reach of all others, and crosses nothing."""
    from sits_mech.mechanics.faces import facets

    section, faces = bar
    most: list[int] = []
    own = facets._passes
    monkeypatch.setattr(facets, "_BLOCK", 8)
    monkeypatch.setattr(facets, "_passes", lambda a, b, c: most.append(len(a)) or own(a, b, c))
    assert not triangles_cross(faces, section.nodes * [1.0, 1.0, 1e4])
    assert max(most) <= 8 * faces.size // 3
