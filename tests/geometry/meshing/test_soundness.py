"""Solids that are watertight pass; each defect is refused by name, with how many and where."""

import numpy as np
import pytest
from skfem import MeshHex, MeshTet

from sits_mech.geometry.meshing.soundness import check_sound, connected_cells, faces_of, merged_corners

MM = 1e-3
LINES = np.array([0.0, 1.0, 2.5])
VTK = [0, 1, 4, 2, 3, 5, 7, 6]


def hexahedra(x=LINES, y=LINES, z=LINES):
    """Points [m] and cells in the order of VTK of a box [mm]."""
    mesh = MeshHex.init_tensor(x, y, z)
    return mesh.p.T * MM, mesh.t[VTK].T.astype(np.int64)


def tetrahedra():
    mesh = MeshTet.init_tensor(LINES, LINES, LINES)
    return mesh.p.T * MM, mesh.t.T.astype(np.int64)


def together(*parts):
    """Several solids in one, no nodes shared."""
    points, cells = zip(*parts, strict=True)
    first = np.cumsum([0, *(len(own) for own in points[:-1])])
    return np.vstack(points), np.vstack([own + k for own, k in zip(cells, first, strict=True)])


def cut(solid, axis=0, at=1.0):
    """The solid cut in two by duplicated nodes in a plane."""
    points, cells = solid
    there = np.abs(points[:, axis] - at * MM) < 1e-9
    copy = np.where(there, len(points) - 1 + np.cumsum(there), np.arange(len(points)))
    beyond = points[cells].mean(axis=1)[:, axis] > at * MM
    return np.vstack([points, points[there]]), np.where(beyond[:, None], copy[cells], cells)


@pytest.mark.parametrize("solid", [hexahedra, tetrahedra])
def test_watertight_solids_pass(solid):
    """Thin ones as well, and two that stand apart."""
    points, cells = solid()
    check_sound("box", points, cells)
    check_sound("film", points * [1.0, 1.0, 1e-3], cells)
    check_sound("two", *together((points, cells), (points + 3.0 * MM, cells)))
    assert connected_cells(2, np.zeros((2, 0), dtype=int)).max() == 1


def test_faces_are_the_surface_and_the_inside():
    """A box of 2 x 2 x 2 bricks: 24 faces outside, 12 inside; all of a cell around alike."""
    points, cells = hexahedra()
    faces = faces_of(cells)
    assert (np.count_nonzero(faces.outer), len(faces.times)) == (24, 36)
    for each, own in ((faces, cells), (faces_of(tetrahedra()[1]), tetrahedra()[1])):
        at = points[each.corners]
        normal = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
        out = ((at.mean(axis=1) - points[own].mean(axis=1)[each.cell]) * normal).sum(axis=1)
        assert np.all(np.sign(out).reshape(len(own), -1) == np.sign(out).reshape(len(own), -1)[:, :1])


@pytest.mark.parametrize("solid", [hexahedra, tetrahedra])
def test_cuts_are_found_and_merged(solid):
    """Along x = 1 mm: nine nodes twice; merged they are what they were."""
    points, cells = cut(solid())
    faces = 2 * (4 if cells.shape[1] == 8 else 8)
    with pytest.raises(ValueError, match=rf"cut by duplicated nodes; {faces} faces .*9 nodes.*about \(1, ") as caught:
        check_sound("cut", points + 1e-9, cells)
    assert "--weld" in str(caught.value) and "\n" not in str(caught.value)
    same = merged_corners(points, cells)
    assert np.count_nonzero(same != np.arange(len(points))) == 9
    check_sound("cut", points, same[cells])


def test_a_gap_that_is_open_is_no_cut():
    """A slot of a tenth of a cell stays one, a film's two sides are not one place."""
    left, right = hexahedra(), hexahedra(LINES + 2.6)
    check_sound("slot", *together(left, right))
    with pytest.raises(ValueError, match="cut by duplicated nodes"):
        check_sound("slot", *together(left, hexahedra(LINES + 2.5)))


def hanging():
    """Two cells beside one cell as high."""
    return together(hexahedra(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0])),
                    hexahedra(np.array([1.0, 2.0]), np.array([0.0, 1.0]), np.array([0.0, 0.4, 1.0])))


def unlike():
    """A hexahedron's side against two triangles."""
    points, cells = hexahedra(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    mesh = MeshTet.init_tensor(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    one = mesh.p.T * MM, mesh.t.T.astype(np.int64)
    other = one[0] * [-1.0, 1.0, 1.0], one[1]
    turned = np.column_stack([other[0][:, 0], other[0][:, 2], MM - other[0][:, 1]])  # the other diagonal
    return together(one, (turned, one[1]))


def thrice():
    """Three tetrahedra on one face."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1], [1, 1, 1]]) * MM
    return points, np.array([[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]])


def folded():
    """Two tetrahedra on one side of the face they share."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0.8]]) * MM
    return points, np.array([[0, 1, 2, 3], [0, 1, 2, 4]])


def hinged():
    """Two boxes that share an edge."""
    points, cells = hexahedra()
    middle = points[cells].mean(axis=1)
    kept = (middle[:, 0] > MM) == (middle[:, 1] > MM)
    used, cells = np.unique(cells[kept], return_inverse=True)
    return points[used], cells.reshape(-1, 8)


DEFECTS = {
    r"2 nodes hang in the middle of a face or edge, the first about \(1, 0, 0.4\) mm": hanging,
    "faces of the surface lie on others that do not match": unlike,
    r"one cell or two; 3 faces belong to more, the first about \(0.3333, 0.3333, 0\) mm": thrice,
    "two sides of the face that they share; 1 faces have both on one side": folded,
    r"hold together by faces; 3 nodes alone hold two together, the first about \(1, 1, 0\) mm": hinged,
}


@pytest.mark.parametrize("said", DEFECTS)
def test_defects_are_refused(said):
    with pytest.raises(ValueError, match=said) as caught:
        check_sound("bad.msh", *DEFECTS[said]())
    assert str(caught.value).startswith("bad.msh: ") and "\n" not in str(caught.value)
