"""Free faces to each other: where their normals point, which may meet, the area that their points hold."""

import numpy as np
import pytest
from skfem import MeshHex

from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, section_mesh, solid_mesh
from sits_mech.mechanics.faces.curved import before, shapes
from sits_mech.mechanics.faces.skin import section_skin, solid_skin


def step(tetrahedra):
    """Two cubes and one on top of the first: an inner corner along x = 1, z = 1; all of its faces."""
    line = np.array([0.0, 1.0, 2.0])
    whole = MeshHex.init_tensor(line, line, line)
    x, _, z = whole.p[:, whole.t].mean(axis=1)
    mesh = whole.remove_elements(np.flatnonzero((x > 1.0) & (z > 1.0)))
    mesh = mesh.to_meshtet() if tetrahedra else mesh
    return solid_skin(solid_mesh(mesh, TETRAHEDRON if tetrahedra else BRICK)[1], mesh.boundary_facets())


@pytest.mark.parametrize("tetrahedra", [False, True])
def test_normals_point_outwards_and_points_hold_the_area(tetrahedra):
    skin = step(tetrahedra)
    f, p, _ = skin.surface.shape.shape
    middle, corner = np.full((f, 2), 1.0 / 3.0 if tetrahedra else 0.5), np.zeros((f, 2))
    nodes = skin.nodes[skin.surface.nodes]
    _, _, n = before(np.zeros((f, 3)), shapes(skin.form, middle), nodes)
    area, at = skin.surface.weight.sum(axis=1), (shapes(skin.form, corner).value[:, None] @ nodes)[:, 0]
    assert area.sum() == pytest.approx(4 + 3 + 3 + 4 + 2 + 4 + 2)
    assert (area * (at * n).sum(axis=1)).sum() / 3.0 == pytest.approx(6.0)  # the volume, by the divergence theorem
    np.testing.assert_allclose(np.abs(n).max(axis=1), 1.0)
    np.testing.assert_allclose(skin.own // skin.facets.shape[1], np.repeat(np.arange(f), p))
    inside = (shapes(skin.form, middle).value[:, None] @ nodes)[:, 0]
    np.testing.assert_allclose(inside, skin.rest[0].reshape(f, p, 3).mean(axis=1), atol=0.1)


@pytest.mark.parametrize("tetrahedra", [False, True])
def test_faces_meet_in_an_inner_corner_and_not_through_the_silicone(tetrahedra):
    skin = step(tetrahedra)
    (f, p, _), m = skin.surface.shape.shape, skin.facets.shape[1]
    points, facets = (each.ravel() for each in np.meshgrid(np.arange(f * p), np.arange(f * m), indexing="ij"))
    may = skin.apart(points, facets)
    n = skin.rest[2].reshape(f, m, 3).mean(axis=1)
    y = skin.rest[1].reshape(f, m, 3).mean(axis=1)
    wall, tread = (np.flatnonzero((np.abs(y[:, a] - 1.0) < 1e-9) & (n[:, a] > 0.9)) for a in (0, 2))
    one, other = points[may] // p, facets[may] // m
    meeting = (n[one] * n[other]).sum(axis=1) < 0.5
    assert set(one[meeting]) == set(other[meeting]) == {*wall, *tread}
    assert not np.any(one == other)


def test_edges_of_a_section_have_outward_normals():
    mesh = section_mesh(np.linspace(0.0, 2.0, 3), np.linspace(0.0, 1.0, 4))
    sides = [np.flatnonzero(np.abs(mesh.nodes[:, 0] - end) < 1e-9) for end in (0.0, 2.0)]
    skin = section_skin(mesh, [side[np.argsort(mesh.nodes[side, 1])] for side in sides])
    nodes = skin.nodes[skin.surface.nodes]
    _, _, n = before(np.zeros((6, 2)), shapes(skin.form, np.full((6, 1), 0.5)), nodes)
    np.testing.assert_allclose(n, [[-1.0, 0.0]] * 3 + [[1.0, 0.0]] * 3, atol=1e-12)
    assert skin.surface.weight.sum() == pytest.approx(2.0) and skin.surface.weight.shape[1] == 5
    np.testing.assert_allclose(skin.places[:2, :, 0], [[0.0, 0.5], [0.5, 1.0]])
