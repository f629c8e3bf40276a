"""Cells divided into 2^d: sizes, shapes, groups and places of the pieces."""

import numpy as np
import pytest
from skfem import Basis, MeshHex, MeshHex2, MeshQuad, MeshQuad2, MeshTet, MeshTet2, MeshTri
from skfem.element import ElementHex2, ElementQuad2, ElementTetP2

from sits_mech.geometry.meshing.refinement import quadratic_points, refined, shape_values

LINES = np.array([0.0, 0.3, 1.0])


def bent(mesh, kind):
    """The quadratic mesh with its nodes moved smoothly."""
    curved = kind.from_mesh(mesh)
    x, *_, z = curved.doflocs
    moved = curved.doflocs.copy()
    moved[-1] = z * (1.0 + 0.2 * x * (1.0 - x))
    return kind(moved, curved.t)


MESHES = {
    "hexahedra": (MeshHex.init_tensor(LINES, LINES, LINES), ElementHex2()),
    "tetrahedra": (MeshTet.init_tensor(LINES, LINES, LINES), ElementTetP2()),
    "quadrilaterals": (MeshQuad.init_tensor(LINES, LINES), ElementQuad2()),
    "curved hexahedra": (bent(MeshHex.init_tensor(LINES, LINES, LINES), MeshHex2), ElementHex2()),
    "curved tetrahedra": (bent(MeshTet.init_tensor(LINES, LINES, LINES), MeshTet2), ElementTetP2()),
    "curved quadrilaterals": (bent(MeshQuad.init_tensor(LINES, LINES), MeshQuad2), ElementQuad2()),
}


def grouped(mesh):
    """The mesh with its lowest faces, and with those at x = 0, in groups."""
    top = mesh.p.shape[0] - 1
    return mesh.with_boundaries({"low": lambda x: np.abs(x[top]) < 1e-9, "left": lambda x: np.abs(x[0]) < 1e-9})


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("times", [0, 1, 2])
def test_cells_are_divided(name, times):
    """2^d pieces of each, as large together as the whole, conforming, whatever curves they have."""
    mesh, element = MESHES[name]
    found = refined(mesh, times)
    d = mesh.dim()
    assert type(found.mesh) is type(mesh)
    np.testing.assert_array_equal(found.parents, np.repeat(np.arange(mesh.t.shape[1]), 2 ** (d * times)))
    whole, parts = (Basis(each, element, intorder=6).dx.sum(axis=1) for each in (mesh, found.mesh))
    np.testing.assert_allclose(np.bincount(found.parents, parts), whole, rtol=1e-12)
    assert len(found.mesh.boundary_facets()) == len(mesh.boundary_facets()) * 2 ** ((d - 1) * times)


@pytest.mark.parametrize("name", MESHES)
def test_places_in_the_parent_are_those_in_space(name):
    """The nodes of a piece, by its own map and by that of its parent."""
    mesh, element = MESHES[name]
    found = refined(mesh, 2)
    (coarse, cells), (fine, pieces) = quadratic_points(mesh), quadratic_points(found.mesh)
    values = np.stack([shape_values(element, points) for points in found.within(element.doflocs)])
    np.testing.assert_allclose(values[found.kinds] @ coarse[cells[found.parents]], fine[pieces], atol=1e-13)


@pytest.mark.parametrize("name", MESHES)
def test_groups_are_carried_along(name):
    """Each keeps its faces: as many pieces of each as a face has, all where the group was."""
    mesh = grouped(MESHES[name][0])
    found = refined(mesh, 2).mesh
    assert set(found.boundaries) == {"low", "left"}
    for group, row in (("low", -1), ("left", 0)):
        assert len(found.boundaries[group]) == len(mesh.boundaries[group]) * 4 ** (mesh.dim() - 1)
        assert np.abs(found.p[row, found.facets[:, found.boundaries[group]]]).max() < 1e-12


def test_tetrahedra_keep_their_shape():
    """Ten times finer pieces are no flatter than the first: those of a cube's corner have three shapes at most."""
    corner = MeshTet(np.vstack([np.zeros(3), np.eye(3)]).T, np.arange(4)[:, None])

    def flatness(mesh):
        """Volume over the cube of the longest edge, of each."""
        at = mesh.p.T[mesh.t.T]
        edges = np.linalg.norm(at[:, :, None] - at[:, None], axis=-1).max(axis=(1, 2))
        return np.abs(np.linalg.det(at[:, 1:] - at[:, :1])) / edges**3

    once, often = (np.unique(np.round(flatness(refined(corner, times).mesh), 9)) for times in (1, 4))
    assert len(often) <= 3 and often.min() >= once.min() - 1e-9


def test_other_meshes_are_refused():
    with pytest.raises(ValueError, match="must be one of MeshTet"):
        refined(MeshTri(), 1)
