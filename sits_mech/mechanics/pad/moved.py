"""Change the sizes of a pad a little: the same cells, their nodes moved.

With X' the nodes of the changed pad, all cells go by the shape functions of the displacements, ``x' = sum_a N_a X'_a``,
so that with ``G = dx'/dx``, H its cofactors and J its determinant

    grad' N = H/J grad N,        weights' = J weights,

exactly, without a basis made anew; pressures are the polynomials of the moved places. What the law, the bulk modulus
and the place of the load are follows from the changed scene. Lengths in thicknesses of the layer each.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from skfem import MeshHex, MeshHex2
from skfem.element import Element, ElementHex1
from skfem.quadrature import get_quadrature

from sits_mech.mechanics.element.kernel import gradients, kinematics
from sits_mech.mechanics.element.mesh import BRICK, ORDER, MixedMesh, Points, pressures
from sits_mech.mechanics.pad.shapes import half_bricks, shape_of
from sits_mech.mechanics.pad.solid import as_in, pad_parts
from sits_mech.mechanics.rest.body import Bonded
from sits_mech.meshing.copies import both_halves
from sits_mech.meshing.refinement import shape_values
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError, Sensor


def moved_block(body: Bonded, sensor: Sensor, fineness: tuple[int, float, int], guard: float = 0.0) -> Bonded | None:
    """Return a pad without contact with the sizes of a changed scene; None where that takes other cells.

    `body` is from `bonded_block`; `fineness` its parts, grading and layers.
    """
    try:
        bricks, _ = half_bricks(shape_of(*pad_parts(sensor)), *fineness)
    except SceneError:
        return None
    nodes = _nodes(bricks if body.components == 3 else both_halves(bricks), body.mesh)
    if nodes is None:
        return None
    X = nodes[body.bonded[:, 0] // 3] * (1.0, 1.0, 0.0)
    mesh = body.mesh if np.array_equal(nodes, body.mesh.nodes) else moved_mesh(body.mesh, nodes, BRICK)
    return replace(as_in(sensor, body, guard), mesh=mesh, X=X)


def moved_mesh(mesh: MixedMesh, nodes: Array, element: Element) -> MixedMesh:
    """Return a mesh of solid cells with its nodes at other places, shape (n, 3) [thicknesses]."""
    slope, weights = mesh.inside
    e, q, d, _ = slope.shape
    G = kinematics(gradients(mesh, nodes.ravel()))
    new = Points((G.H / G.J[..., None]).reshape(e, q, d, d) @ slope, weights * G.J)
    places = np.moveaxis(_values(element) @ nodes[mesh.cells], -1, 0)
    return MixedMesh(nodes, mesh.cells, new, pressures(places, new.weights, mesh.chi.shape[1] == 1))


def _nodes(bricks: MeshHex, mesh: MixedMesh) -> Array | None:
    """Return the nodes of bricks in the order of a mesh, corners first in both; None where cells differ."""
    if bricks.t.shape[1] != len(mesh.cells) or not np.array_equal(bricks.t.T, mesh.cells[:, : len(bricks.t)]):
        return None
    if isinstance(bricks, MeshHex2):  # its own nodes
        return np.ascontiguousarray(bricks.doflocs.T)
    nodes = np.empty_like(mesh.nodes)
    nodes[mesh.cells] = _corners() @ bricks.p.T[bricks.t.T]
    return nodes


@cache
def _corners() -> Array:
    """Return the matrix from a brick's corners to its nodes, shape (27, 8)."""
    return shape_values(ElementHex1(), BRICK.doflocs)


@cache
def _values(element: Element) -> Array:
    """Return the shape functions at the quadrature points, shape (q, k)."""
    return shape_values(element, get_quadrature(element, ORDER)[0].T)
