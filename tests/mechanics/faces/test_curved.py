"""Gaps before quadratic faces: the distance from a circle and a grid of points, two derivatives, rigid motions."""

import numpy as np
import pytest
from skfem import MeshHex, MeshTet

from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, section_mesh, solid_mesh
from sits_mech.mechanics.faces.curved import before, gaps, nearest_on, shapes
from sits_mech.mechanics.faces.skin import section_skin, solid_skin
from sits_mech.rotations import rotation_matrix


def faces(kind):
    """Shape functions of one face with its nodes, bent a little, and the number of its sides."""
    rng = np.random.default_rng(3)
    if kind == "edge":
        mesh = section_mesh(np.linspace(0.0, 1.0, 2), np.linspace(0.0, 1.0, 2))
        lines = [np.flatnonzero(np.abs(mesh.nodes[:, 0] - end) < 1e-9) for end in (0.0, 1.0)]
        skin = section_skin(mesh, [line[np.argsort(mesh.nodes[line, 1])] for line in lines])
    else:
        mesh, element = (MeshHex(), BRICK) if kind == "quadrilateral" else (MeshTet(), TETRAHEDRON)
        skin = solid_skin(solid_mesh(mesh, element)[1], mesh.boundary_facets())
    nodes = skin.nodes[skin.surface.nodes[0]]
    return skin.form[:1], nodes + 0.05 * rng.normal(size=nodes.shape), skin.corner[0], skin.sides


KINDS = ("edge", "triangle", "quadrilateral")


@pytest.mark.parametrize("kind", KINDS)
def test_shape_functions_are_one_in_their_node_and_follow_their_slopes(kind):
    form, _, corner, _ = faces(kind)
    every = np.repeat(form, len(corner), axis=0)
    if kind != "triangle":  # whose corners and sides have a share of the bubble
        np.testing.assert_allclose(shapes(every, corner).value, np.eye(len(corner)), atol=1e-12)
    place, h = 0.3 * np.ones((1, corner.shape[1])), 1e-5
    here = shapes(form, place)
    for a, step in enumerate(h * np.eye(corner.shape[1])):
        up, down = shapes(form, place + step), shapes(form, place - step)
        np.testing.assert_allclose(here.slope[:, a], (up.value - down.value) / (2 * h), atol=1e-9)
        np.testing.assert_allclose(here.curvature[:, a], (up.slope - down.slope) / (2 * h), atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_nearest_points_are_nearer_than_any_of_a_grid(kind):
    form, nodes, corner, sides = faces(kind)
    rng, count, (p, d) = np.random.default_rng(0), 60, (corner.shape[1], nodes.shape[1])
    middle = np.full((1, p), 1.0 / 3.0 if sides == 3 else 0.5)
    share = rng.uniform(size=(4000, p))
    share = share[share.sum(axis=1) <= 1.0] if sides == 3 else share
    surface = shapes(np.repeat(form, len(share), axis=0), share).value @ nodes
    x = surface[rng.integers(len(surface), size=count)] + 0.1 * rng.normal(size=(count, d))
    every, own = np.repeat(form, count, axis=0), np.repeat(nodes[None], count, axis=0)
    near = nearest_on(x, every, own, np.repeat(middle, count, axis=0), sides)
    away, front, _ = before(x, shapes(every, near.place), own)
    grid = np.linalg.norm(x[:, None] - surface, axis=2).min(axis=1)
    assert np.all(away <= grid + 1e-9) and np.max(grid - away) < 0.05
    assert (front > 0.0).any() and (front < 0.0).any() and set(near.free) >= {p, p - 1}


def test_an_edge_that_follows_a_circle_has_its_distance():
    """Radius 1, an arc of 0.2 rad: the quadratic through three of its points misses it by 8e-6."""
    form, _, _, _ = faces("edge")
    angle = np.array([-0.1, 0.0, 0.1])
    nodes = np.stack([np.sin(-angle), np.cos(angle)], axis=1)  # outward normals
    angles, radii = np.meshgrid([-0.07, 0.0, 0.05], [0.8, 0.97, 1.2])
    x = np.stack([(radii * np.sin(angles)).ravel(), (radii * np.cos(angles)).ravel()], axis=1)
    every, own = np.repeat(form, len(x), axis=0), np.repeat(nodes[None], len(x), axis=0)
    near = nearest_on(x, every, own, np.full((len(x), 1), 0.5), 1)
    _, front, _ = before(x, shapes(every, near.place), own)
    np.testing.assert_allclose(np.abs(front), np.abs(radii.ravel() - 1.0), atol=1e-5)
    assert np.all(near.free == 1) and len(set(np.sign(front * (radii.ravel() - 1.0)))) == 1


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("kind", KINDS)
def test_gaps_have_two_exact_derivatives_and_turn_with_the_face(kind, side):
    """Inside, before a side and before a corner, of a point between two nodes."""
    form, nodes, corner, sides = faces(kind)
    d, p, h, rng = nodes.shape[1], corner.shape[1], 1e-5, np.random.default_rng(1)
    shape, seen = np.array([[0.3, 0.7]]), set()
    for place in ([0.3, 0.2], [0.3, 0.0], [0.0, 0.0]):
        there = shapes(form, np.array([place[:p]]))
        _, _, normal = before(np.zeros((1, d)), there, nodes[None])
        out = sum((0.1 * (there.slope[0, a] @ nodes) for a in range(p) if place[a] == 0.0), np.zeros(d))
        x = (there.value @ nodes)[0] + 0.1 * side * normal[0] - out
        start = np.concatenate([rng.normal(size=(2, d)), nodes])
        start[1] = (x - 0.3 * start[0]) / 0.7

        def gap(moved, place=place):
            point, own = shape @ moved[:2], moved[None, 2:]
            near = nearest_on(point, form, own, np.array([place[:p]]), sides)
            return gaps(point, shapes(form, near.place), near, own, shape), near.free[0]

        v = rng.normal(size=start.shape)
        (here, count), (up, _), (down, _) = (gap(start + step * v) for step in (0.0, h, -h))
        seen.add(count)
        assert np.sign(here.value[0]) == side
        assert (up.value - down.value)[0] / (2 * h) == pytest.approx(here.slope[0] @ v.ravel(), rel=1e-6)
        np.testing.assert_allclose(here.curvature[0] @ v.ravel(), (up.slope - down.slope)[0] / (2 * h), atol=1e-5)
        if d == 3:
            turn = rotation_matrix(np.array([0.4, -0.3, 0.8]))
            assert gap(start @ turn.T + 0.3)[0].value[0] == pytest.approx(here.value[0], rel=1e-9)
    assert {0, p} <= seen
