"""Bound a flat plate by closed lines: rim and holes, as corners or as the border of the cells in a mesh file.

A loop is a tuple of corners (x, y) in order, not closed [m]; the rim comes first.
"""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sits_mech.quantities import Array, Mask
from sits_mech.units import SLACK, SceneError, printable, shown

Loop = tuple[tuple[float, float], ...]
_KINDS = ("triangle", "quad")
_CORNERS = 128  # of a circle
_SYSTEM = r"[^,*\n]{16} {0,7}|(?=\w+\*)[^,\n]{24} {0,15}|[^,\n]*,[^,\n]*, *"  # small, large, free fields before it
_PASSED_OVER = re.compile(rf"^(?:INCLUDE|(?=GRID|GRDSET)(?:{_SYSTEM})[1-9]).*", re.MULTILINE)


def signed_area(loops: Array) -> Array:
    """Return the areas of polygons (..., k, 2), positive where they go counter-clockwise [m^2]."""
    after = np.roll(loops, -1, axis=-2)
    return np.asarray((loops[..., 0] * after[..., 1] - loops[..., 1] * after[..., 0]).sum(-1) / 2)


def circle(radius: float) -> Loop:
    """Return the corners of a circle about the centre, on it, counter-clockwise [m]."""
    angle = 2.0 * np.pi * np.arange(_CORNERS) / _CORNERS
    return tuple(zip((radius * np.cos(angle)).tolist(), (radius * np.sin(angle)).tolist(), strict=True))


def edges(loops: Sequence[Array]) -> tuple[Array, Array]:
    """Return the starts and the ends of all edges of polygons, shape (n, 2) each [m]."""
    return np.vstack(loops), np.vstack([np.roll(loop, -1, axis=0) for loop in loops])


def inside_loops(loops: Sequence[Array], points: Array) -> Mask:
    """Return which points (n, 2) have an odd number of the loops' edges to their right."""
    a, b = edges(loops)
    y = points[:, 1, None]
    between = (a[:, 1] > y) != (b[:, 1] > y)
    x = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    return np.asarray((between & (x > points[:, 0, None])).sum(1) % 2 == 1)


def polygon(loops: Sequence[ArrayLike]) -> Any:
    """Return rim and holes as a polygon of shapely."""
    import shapely

    return shapely.Polygon(loops[0], loops[1:])


def lines_crossing(lines: Sequence[Array]) -> tuple[float, float] | None:
    """Return a place where polylines (k, 2) cross or touch, other than one's end the next one's beginning [m]."""
    import shapely

    ends = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    step, pieces = ends[:, 1] - ends[:, 0], shapely.linestrings(ends)
    still = np.flatnonzero(~step.any(axis=1))
    if len(still):
        return float(ends[still[0], 0, 0]), float(ends[still[0], 0, 1])
    i, j = shapely.STRtree(pieces).query(pieces, "dwithin", SLACK * np.hypot(*step.T))
    order = np.lexsort((j, i))
    i, j = i[order], j[order]
    joined = np.all(ends[i, 1] == ends[j, 0], axis=1) | np.all(ends[i, 0] == ends[j, 1], axis=1)
    cross, dot = step[i, 0] * step[j, 1] - step[i, 1] * step[j, 0], (step[i] * step[j]).sum(axis=1)
    folded = (dot < 0.0) & (np.abs(cross) <= -SLACK * dot)
    met = np.flatnonzero((i < j) & (~joined | folded))
    if not len(met):
        return None
    place = shapely.shortest_line(pieces[i[met[0]]], pieces[j[met[0]]]).coords[0]
    return float(place[0]), float(place[1])


def first_crossing(loops: Sequence[ArrayLike]) -> tuple[float, float] | None:
    """Return where two edges of an outline cross or touch beyond the corner they share [m]; None if none do."""
    return lines_crossing([np.vstack([loop, np.asarray(loop)[:1]]) for loop in loops])


def check_rims(points: Loop | None, holes: tuple[Loop, ...]) -> None:
    """Refuse an outline without area, holes without a rim around them, and rims that cross themselves or each other.

    Raises SceneError in one line: `points` or `holes`, what they must be, what came.
    """
    if points is None:
        if holes:
            raise SceneError(f'holes must come with shape = "outline" and points; got {len(holes)} without')
        return
    if any(len(hole) < 3 for hole in holes):
        raise SceneError("holes must be at least three corners each; got fewer")
    met = first_crossing((points, *holes)) if len(points) > 3 or holes else None
    if met is not None:
        x, y = met
        raise SceneError(f"points and holes must be rims that do not cross or touch; they do at ({x:.4g}, {y:.4g}) m")
    if len(points) < 3 or not abs(signed_area(np.array(points))) > 0.0:
        raise SceneError(f"points must be at least three corners around an area; got {shown(points)}")


def with_rims_of_mesh(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a target's table with corners and holes instead of the keys `mesh` and `mesh_group`, if it has them.

    Raises SceneError as `read_loops`, or when the table has an outline besides.
    """
    if not {"mesh", "mesh_group"} & set(given):
        return given
    path, group = given.get("mesh"), given.get("mesh_group", "target")
    if not isinstance(path, str) or not isinstance(group, str):
        raise SceneError(f"mesh and mesh_group must be a file and a name; got {shown(path)} and {shown(group)}")
    if given.get("shape") != "outline" or {"points", "holes"} & set(given):
        raise SceneError(f'mesh must come with shape = "outline" and without points or holes; got {shown(path)}')
    rim, *holes = read_loops(path, group)
    rest = {key: item for key, item in given.items() if key not in ("mesh", "mesh_group")}
    return rest | {"points": rim, "holes": tuple(holes)}


def read_loops(path: str | Path, group: str | None = None) -> tuple[Loop, ...]:
    """Return the border of the cells in a mesh file, or of a named group of them, in the file's own unit (metres).

    Raises SceneError in one line: the file is no mesh, has no such cells or group, or no single piece with simple rims.
    """
    mesh = read_mesh(path)
    blocks = [(k, block.data.astype(np.int64)) for k, block in enumerate(mesh.cells) if block.type in _KINDS]
    if not blocks:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "no cells"
        raise SceneError(f"{path}: must hold triangles or quadrilaterals; got {kinds}")
    cells = [block if group is None else block[_of_group(mesh, k, group, path)] for k, block in blocks]
    points = np.asarray(mesh.points, dtype=float)[:, :2]
    loops = sorted((points[loop] for loop in _border(cells, path)), key=lambda loop: -abs(float(signed_area(loop))))
    return tuple(tuple((float(x), float(y)) for x, y in _straightened(loop)) for loop in loops)


def read_mesh(path: str | Path) -> Any:
    """Read a mesh by meshio; SceneError where meshio would print its reason and end the program, or misplace nodes."""
    import meshio

    nastran = Path(path).is_file() and Path(path).suffix.lower() in (".bdf", ".fem", ".nas")
    if nastran and (line := _PASSED_OVER.search(Path(path).read_text(errors="replace"))):
        what = "must give all nodes itself, in the basic system, as meshio passes over others"
        raise SceneError(f"{path}: {what}; got {' '.join(printable(line[0]).split())}")
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(path)
    except ModuleNotFoundError as error:
        what = f"must be read with {error.name}: pip install {error.name}, or save it as .msh"
        raise SceneError(f"{path}: {what}; got no {error.name}") from None
    except (Exception, SystemExit) as error:  # a reader of damaged files raises anything
        reason = " ".join((str(error) if not isinstance(error, SystemExit) else printed.getvalue()).split())
        came = printable(reason) or type(error).__name__
        came += ", which meshio does not know" if isinstance(error, KeyError) else ""
        raise SceneError(f"{path}: must be a mesh file that meshio reads, such as .msh; got: {came}") from None


def _of_group(mesh: Any, block: int, group: str, path: str | Path) -> Mask:
    """Return which cells of a block belong to a named group: a set of cells, or a physical group of gmsh."""
    sets = {name: parts for name, parts in mesh.cell_sets.items() if not name.startswith("gmsh:")}
    inside = np.zeros(len(mesh.cells[block].data), dtype=bool)
    if group in sets:
        inside[np.asarray(sets[group][block], dtype=np.int64)] = True
    elif group in mesh.field_data and "gmsh:physical" in mesh.cell_data:
        inside[:] = np.asarray(mesh.cell_data["gmsh:physical"][block]) == mesh.field_data[group][0]
    else:
        known = ", ".join(sorted({*sets, *mesh.field_data})) or "none"
        raise SceneError(f'{path}: must name a group of cells "{group}"; its groups are {known}')
    return inside


def _border(cells: list[NDArray[np.int64]], path: str | Path) -> list[list[int]]:
    """Return chains of nodes around the cells' border."""
    edges: set[tuple[int, int]] = set()
    for block in cells:
        edges.update(zip(block.ravel().tolist(), np.roll(block, -1, axis=1).ravel().tolist(), strict=True))
    after = {a: b for a, b in edges if (b, a) not in edges}
    if not after or len(after) != sum((b, a) not in edges for a, b in edges):
        raise SceneError(f"{path}: must hold cells that all turn the same way, with rims that do not touch themselves")
    loops = []
    while after:
        start, node = after.popitem()
        loop = [start]
        while node != start:
            loop.append(node)
            node = after.pop(node)
        loops.append(loop)
    return loops


def _straightened(loop: Array) -> Array:
    """Return a loop without nodes on straight stretches."""
    u, v = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    turn = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return np.asarray(loop[turn > 1e-9 * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)])
