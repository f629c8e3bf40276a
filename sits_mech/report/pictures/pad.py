"""Points and cells of a deformed pad for pictures, from an equilibrium of the block model."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import cKDTree

from sits_mech.mechanics.block import BlockPad, of_both_halves, solved_body
from sits_mech.mechanics.element.kernel import deformation, most_stretched
from sits_mech.mechanics.element.mesh import BRICK, DeformedSection, MixedMesh
from sits_mech.mechanics.pad.shapes import PadShape
from sits_mech.mechanics.pad.solid import pad_parts, pad_shape
from sits_mech.quantities import Array, Equilibrium, Integers

_ROUND = [0, 1, 3, 2, 4, 5, 7, 6]  # corners of a brick by z, y, x -> each face around
_GRID = (64, 12)  # pieces of a section for pictures, across and up


def deformed_section(model: BlockPad, equilibrium: Equilibrium, angle: float = 0.0) -> DeformedSection:
    """Return the deformed pad in the upright plane through the z axis at `angle` [rad] to x.

    In the plane y = 0 the quads are quarters of the cells' faces, elsewhere those of an even grid; other planes take an
    equilibrium that leaves y = 0.
    """
    _, elastomer = pad_parts(model.sensor)
    body = solved_body(model, equilibrium)
    mesh, middle = body.mesh, body.faces.middle
    if middle is None:
        raise ValueError("mesh: must know its faces in the plane y = 0")
    u = equilibrium.state[1 : 1 + mesh.nodes.size].reshape(-1, 3)
    if angle == 0.0:
        places, bent = (mesh.nodes + u, mesh.nodes), middle[:, 3] != middle[:, 4]
        points, rest = (each[:, [0, 2]] for each in places)
        quads = np.concatenate([_quarters(mesh.nodes, middle[bent, 1:]), middle[~bent, 1:]])
        cells = np.concatenate([np.repeat(middle[bent, 0], 4), middle[~bent, 0]])
    else:
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        (points, rest), quads, cells = _slanted(mesh, u, way, pad_shape(model.sensor))
    points, rest = (each * elastomer.thickness + (0.0, elastomer.standoff) for each in (points, rest))
    J, stretch = deformation(mesh, u.ravel())[1].min(axis=1), most_stretched(mesh, u.ravel()).max(axis=1)
    return DeformedSection(points, quads, J[cells], stretch[cells], rest)


def _slanted(mesh: MixedMesh, u: Array, way: Array, shape: PadShape) -> tuple[tuple[Array, Array], Integers, Integers]:
    """Return points along a direction and up, deformed and before, quads of a grid, and each one's cell.

    The grid is even, with a line at each interface and at the faces of target and cover besides.
    """
    across, lines = _GRID[0], np.union1d(np.linspace(0.0, 1.0, _GRID[1] + 1), [each.height for each in shape.between])
    if shape.cover is not None:
        low, high = shape.cover.levels
        above = [np.linspace(*ends, 1 + _GRID[1] // 3) for ends in ((1.0, low), (low, high))]
        lines = np.union1d(lines, np.concatenate(above))
    up = len(lines) - 1
    moved = LinearNDInterpolator(mesh.nodes, u)
    rays = np.linspace(0.0, np.linalg.norm(mesh.nodes[:, :2], axis=1).max(), 20 * across)
    reach = rays[np.isfinite(moved(rays[:, None] * way + (0.0, 0.0, 1e-6))[:, 0])].max()
    s, z = np.meshgrid(np.linspace(-reach, reach, across + 1), lines, indexing="ij")
    grid = s.ravel()[:, None] * way + z.ravel()[:, None] * (0.0, 0.0, 1.0)
    places = grid + moved(grid)
    first = ((up + 1) * np.arange(across)[:, None] + np.arange(up)).ravel()
    quads = first[:, None] + np.array([0, up + 1, up + 2, 1])
    quads = quads[np.isfinite(places[quads]).all(axis=(1, 2)) & shape.holds(grid[quads].mean(axis=1))]
    corners = mesh.nodes[mesh.cells]
    low, high = corners.min(axis=1), corners.max(axis=1)
    away = np.abs(grid[quads].mean(axis=1)[:, None] - (low + high) / 2) / (high - low)
    moved_and_rest = np.column_stack([places @ way, places[:, 2]]), np.column_stack([grid @ way, grid[:, 2]])
    return moved_and_rest, quads, np.argmin(away.max(axis=2), axis=1)


def deformed_pad(model: BlockPad, equilibrium: Equilibrium) -> tuple[Array, Integers, Array]:
    """Return the whole deformed pad: points (n, 3) [m] in the sensor's frame, cells, smallest J (m,) of each.

    Cells (m, 8) are eighths of bricks, lower face and upper face counter-clockwise, or (m, 4) tetrahedra.
    """
    _, elastomer = pad_parts(model.sensor)
    if solved_body(model, equilibrium).mesh is model.half[int(equilibrium.state[0])].fine.mesh:
        equilibrium = of_both_halves(model, equilibrium)
    mesh = model.whole[int(equilibrium.state[0])].fine.mesh
    u = equilibrium.state[1 : 1 + mesh.nodes.size].reshape(-1, 3)
    points = (mesh.nodes + u) * elastomer.thickness + (0.0, 0.0, elastomer.standoff)
    least = deformation(mesh, u.ravel())[1].min(axis=1)
    if mesh.cells.shape[1] < len(BRICK.doflocs):
        return points, mesh.cells[:, :4], least
    order = np.lexsort(BRICK.doflocs.T).reshape(3, 3, 3)  # nodes of a brick by z, y, x
    eighths = [order[k : k + 2, j : j + 2, i : i + 2].ravel()[_ROUND] for k, j, i in np.ndindex(2, 2, 2)]
    cells = mesh.cells[:, np.array(eighths)].reshape(-1, 8)
    a, b, c = (mesh.nodes[cells[:, k]] - mesh.nodes[cells[:, 0]] for k in (1, 3, 4))
    inverted = np.einsum("ij,ij->i", np.cross(a, b), c) < 0.0  # in the image of half a pad
    cells[inverted] = cells[inverted][:, [4, 5, 6, 7, 0, 1, 2, 3]]
    return points, cells, np.repeat(least, 8)


def _quarters(nodes: Array, faces: Integers) -> Integers:
    """Return the quarters of quadrilateral faces in the plane y = 0, with mid-side nodes: they may be bent."""
    own = np.flatnonzero(np.abs(nodes[:, 1]) < 1e-9)
    tree = cKDTree(nodes[own][:, [0, 2]])
    corners = nodes[faces][..., [0, 2]]
    mid_side = own[tree.query(0.5 * (corners + np.roll(corners, -1, axis=1)))[1]]
    middle = own[tree.query(corners.mean(axis=1))[1]]
    parts = [faces, mid_side, np.repeat(middle[:, None], 4, axis=1), np.roll(mid_side, 1, axis=1)]
    return np.stack(parts, axis=-1).reshape(-1, 4)
