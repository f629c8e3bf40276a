"""Patches: the cells at rims, the displacements that are theirs alone, a stiffness that is a piece of the layer's."""

from functools import cache

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import element_stiffness
from sits_mech.mechanics.pad.families import pad_family
from sits_mech.scene.sensor import load_sensor


@cache
def layer(level):
    """A level of a pad whose target is narrower than it is."""
    return pad_family(load_sensor("biorob2018", ['elastomer.contact="never"']))[0].maker(level)


@pytest.mark.parametrize("level", [1, 2])
def test_cells_touch_a_rim_or_are_parts_of_one_that_does(level):
    """Target's edge and the foot of the sides; on the third level to the depth of the second one's first cells."""
    body = layer(level)
    cells = body.mesh.nodes[body.mesh.cells]
    half = np.abs(body.X).max(axis=0)[:2]
    beside = np.max(np.abs(cells[..., :2]) - half, axis=-1)  # 0 on the target's edge
    edge = (cells[..., 2] > 1.0 - 1e-9) & (np.abs(beside) < 1e-9)
    assert np.all(body.patch.cells[edge.any(axis=1)])
    inside = np.max(np.abs(cells[..., :2]), axis=-1).max(axis=1) < half.min() - 0.5
    assert not np.any(body.patch.cells & inside)


def test_the_third_level_takes_the_parts_of_the_cells_that_it_cuts():
    """All others are cells of the second level, where its state goes on exactly."""
    second, third = (layer(level) for level in (1, 2))
    volume = [float(body.mesh.inside.weights[body.patch.cells].sum()) for body in (second, third)]
    assert volume[1] == pytest.approx(volume[0])
    assert np.count_nonzero(third.patch.cells) > 2 * np.count_nonzero(second.patch.cells)
    assert layer(0).patch is None  # it has no other cells


@pytest.mark.parametrize("level", [1, 2])
def test_displacements_are_those_that_no_other_cell_touches(level):
    body = layer(level)
    patch = body.patch
    np.testing.assert_array_equal(body.free[patch.own], patch.inner)
    assert not np.isin(body.mesh.dofs[~patch.cells], patch.inner).any()
    others = np.setdiff1d(np.intersect1d(patch.mesh.dofs, body.free), patch.inner)
    assert np.isin(others, body.mesh.dofs[~patch.cells]).all()


def test_its_stiffness_is_a_piece_of_the_layers():
    """Solved for a load on the patch's own displacements, by its own pattern."""
    body = layer(1)
    patch, u, p = body.patch, np.zeros(body.mesh.nodes.size), np.zeros(body.mesh.chi.shape[:2])
    whole = body.pattern.matrix((element_stiffness(body.mesh, body.laws, u, p),))
    piece = whole[patch.own][:, patch.own].toarray()
    load = np.random.default_rng(1).normal(size=len(patch.inner))
    own = (element_stiffness(patch.mesh, body.laws, u, p[patch.cells]),)
    found = patch.pattern.factored(own).solve(load)
    np.testing.assert_allclose(found, np.linalg.solve(piece, load), rtol=1e-6, atol=1e-9)


def test_the_laplacian_measures_gradients():
    """Of a displacement linear in the place, in every component, and of none that is constant."""
    mesh, patch = layer(1).mesh, layer(1).patch
    slope = np.random.default_rng(2).normal(size=(3, 3))
    for shift in (0.0, 1.0):
        u = (mesh.nodes @ slope.T + shift).ravel()[patch.mesh.dofs]
        energy = np.einsum("ei,eij,ej->", u, patch.laplacian, u)
        assert energy == pytest.approx(np.sum(slope**2) * patch.mesh.inside.weights.sum())
