"""States carried to finer meshes: quadratic displacements and linear pressures exactly, energies of affine cells."""

from functools import cache

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad, MeshQuad2, MeshTet

from sits_mech.geometry.meshing.bricks import PlateOutline, ring_bricks
from sits_mech.geometry.meshing.refinement import refined
from sits_mech.mechanics.element.kernel import deformation, gradients
from sits_mech.mechanics.element.mesh import BRICK, SQUARE, TETRAHEDRON, plane_mesh, solid_mesh
from sits_mech.mechanics.element.prolongation import prolongation

X, Z = np.array([0.0, 0.4, 1.0, 1.3]), np.array([0.0, 0.7, 1.0])
QUADS = MeshQuad.init_tensor(X, Z)


def curved_section():
    """Quadrilaterals with parabolas for sides."""
    mesh = MeshQuad2.from_mesh(MeshQuad(QUADS.p, QUADS.t[[0, 3, 2, 1]]))
    x, z = mesh.doflocs
    return MeshQuad2(np.stack([x + 0.2 * z * (1.0 - z), z]), mesh.t)


def rings():
    """Half a cylinder under a disc."""
    lines = np.array([0.0, 0.6, 1.0])
    return ring_bricks(PlateOutline(1.0, 1.0, True), PlateOutline(1.4, 1.4, True), (lines, lines, Z), 1)[0]


MESHES = {
    "section": (MeshQuad2.from_mesh(MeshQuad(QUADS.p, QUADS.t[[0, 3, 2, 1]])), SQUARE),
    "curved section": (curved_section(), SQUARE),
    "bricks": (MeshHex.init_tensor(X, Z, Z), BRICK),
    "rings": (rings(), BRICK),
    "tetrahedra": (MeshTet.init_tensor(X, Z, Z), TETRAHEDRON),
}
AFFINE = ("section", "bricks", "tetrahedra")


def arrays(mesh, element):
    """The mixed mesh of a mesh."""
    return plane_mesh(mesh) if element is SQUARE else solid_mesh(mesh, element)[0]


@cache
def carried(name):
    """Coarse mesh, fine mesh of twice divided cells, and what carries states over."""
    mesh, element = MESHES[name]
    refinement = refined(mesh, 2)
    coarse, fine = arrays(mesh, element), arrays(refinement.mesh, element)
    return coarse, fine, prolongation(coarse, fine, refinement, element)


def quadratic(nodes):
    """A quadratic displacement of every component."""
    d = nodes.shape[1]
    powers = np.column_stack([np.ones(len(nodes)), nodes, *(nodes[:, [i]] * nodes[:, i:] for i in range(d))])
    return (powers @ np.random.default_rng(3).normal(size=(powers.shape[1], d))).ravel()


@pytest.mark.parametrize("name", MESHES)
def test_places_of_nodes_are_exact(name):
    coarse, fine, onto = carried(name)
    np.testing.assert_allclose(onto.displacements(coarse.nodes.ravel()), fine.nodes.ravel(), atol=1e-13)


@pytest.mark.parametrize("name", AFFINE)
def test_quadratic_displacements_are_exact(name):
    coarse, fine, onto = carried(name)
    found = onto.displacements(quadratic(coarse.nodes))
    np.testing.assert_allclose(found, quadratic(fine.nodes), atol=1e-12)


def test_columns_are_carried_one_by_one():
    coarse, _, onto = carried("bricks")
    u = np.random.default_rng(1).normal(size=(coarse.nodes.size, 2))
    np.testing.assert_array_equal(onto.displacements(u)[:, 1], onto.displacements(u[:, 1].copy()))


@pytest.mark.parametrize(("name", "within"), [("section", 1e-12), ("bricks", 1e-12), ("curved section", 1e-3),
                                              ("rings", 1e-3)])
def test_any_displacement_of_bricks_keeps_its_deformation(name, within):
    """The coarse functions are among the fine ones, on curved cells as well: the same volume, as far as integrated."""
    coarse, fine, onto = carried(name)
    u = 0.02 * np.random.default_rng(1).normal(size=coarse.nodes.size)
    volume, same = (
        (mesh.inside.weights * deformation(mesh, v)[1]).sum()
        for mesh, v in ((coarse, u), (fine, onto.displacements(u)))
    )
    assert same == pytest.approx(volume, rel=within)


@pytest.mark.parametrize("name", AFFINE)
def test_energies_agree_where_cells_are_affine(name):
    """Of gradients, which both integrate exactly: of any displacement of bricks, of quadratic ones of tetrahedra."""
    coarse, fine, onto = carried(name)
    any_one = np.random.default_rng(1).normal(size=coarse.nodes.size)
    u = quadratic(coarse.nodes) if name == "tetrahedra" else any_one
    energy, same = (
        (mesh.inside.weights[..., None] * gradients(mesh, v) ** 2).sum()
        for mesh, v in ((coarse, u), (fine, onto.displacements(u)))
    )
    assert same == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("name", MESHES)
def test_linear_pressures_are_exact(name):
    """The pressure 1 is 1; any one has the same mean and square over each cell, if that is integrated exactly."""
    coarse, fine, onto = carried(name)
    within = 1e-11 if name in AFFINE else 0.01
    first = np.zeros(coarse.chi.shape[:2])
    first[:, 0] = np.sqrt(coarse.inside.weights.sum(axis=1))
    one = onto.pressures(first)
    np.testing.assert_allclose(one[:, 0], np.sqrt(fine.inside.weights.sum(axis=1)), rtol=1e-12)
    np.testing.assert_allclose(one[:, 1:], 0.0, atol=1e-12)
    p = np.random.default_rng(2).normal(size=first.shape)
    found = onto.pressures(p)
    squares, totals = (np.bincount(onto.parents[0], each) for each in (
        (found**2).sum(axis=1), (found[:, None] @ fine.chi)[:, 0].sum(axis=1)
    ))
    np.testing.assert_allclose(squares, (p**2).sum(axis=1), rtol=within)
    np.testing.assert_allclose(totals, (p[:, None] @ coarse.chi)[:, 0].sum(axis=1), rtol=within, atol=0.1 * within)
