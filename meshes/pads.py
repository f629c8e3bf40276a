"""Makes the example pads `dome.msh`, `slotted.msh`, `pillars.msh`, `box.msh`: python meshes/pads.py [DIR].

Needs sits-mech[mesh]. Half of each, y >= 0, in tetrahedra; lengths in metres, ground at z = 0, groups `ground`,
`target`, `free`, `symmetry`. How fine: a quarter of the thickness at the target's edge (and at the ground's below it,
where the pad ends flush), 0.6 more for each length away from it, up to 0.9 of the thickness; `box` shows it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pygmsh

Size = Callable[[int, int, float, float, float], float]


def dome(geometry: pygmsh.occ.Geometry) -> Size:
    """Base 16 mm across, flat top 8 mm across and 3 mm high, a quarter ellipse between them."""
    axis, foot, rim, top = ([0, 0, 0], [8, 0, 0], [4, 0, 3], [0, 0, 3])
    a, b, c, d = (geometry.add_point(point) for point in (axis, foot, rim, top))
    middle = geometry.add_point([4, 0, 0])
    side = geometry.add_ellipse_arc(b, middle, b, c)
    lines = [geometry.add_line(a, b), side, geometry.add_line(c, d), geometry.add_line(d, a)]
    section = geometry.add_plane_surface(geometry.add_curve_loop(lines))
    geometry.revolve(section, [0, 0, 1], [0, 0, 0], np.pi)
    return lambda dim, tag, x, y, z, *_: 0.7 + 0.6 * min(1.5, np.hypot(np.hypot(x, y) - 4.0, z - 3.0))


def slotted(geometry: pygmsh.occ.Geometry) -> Size:
    """Box of 20 x 20 x 2 mm, three slots 1 mm wide and 1 mm deep along y in its lower face; target 12 x 12 mm."""
    box = geometry.add_box([-10, 0, 0], [20, 10, 2])
    cut = [geometry.add_box([x - 0.5, -1, -1], [1, 12, 2]) for x in (-4, 0, 4)]
    whole = geometry.boolean_difference(box, cut)
    geometry.boolean_fragments(whole, geometry.add_rectangle([-6, 0, 2], 12, 6))
    return lambda dim, tag, x, y, z, *_: 1.0 + 0.5 * min(2.0, abs(max(abs(x), y) - 6.0))


def pillars(geometry: pygmsh.occ.Geometry) -> Size:
    """Three by three pillars, 3 mm across and 2 mm high, 4.5 mm apart on a slab of 15 x 15 x 1 mm."""
    parts = [geometry.add_box([-7.5, 0, 0], [15, 7.5, 1])]
    for x in (-4.5, 0.0, 4.5):
        parts += [geometry.add_cylinder([x, y, 0.5], [0, 0, 2.5], 1.5) for y in (0.0, 4.5)]
    whole = geometry.boolean_union(parts)
    geometry.boolean_intersection([whole, geometry.add_box([-8, 0, -1], [16, 8, 5])])
    return lambda dim, tag, x, y, z, *_: 1.0 if z > 0.9 else 1.8


def box(geometry: pygmsh.occ.Geometry) -> Size:
    """Box of 20 x 20 x 2 mm under 15 x 15 mm, which the package meshes in hexahedra by itself: to compare."""
    whole = geometry.add_box([-10, 0, 0], [20, 10, 2])
    geometry.boolean_fragments(whole, geometry.add_rectangle([-7.5, 0, 2], 15, 7.5))
    return lambda dim, tag, x, y, z, *_: min(1.8, 0.5 + 0.6 * float(np.hypot(max(abs(x), y) - 7.5, z - 2.0)))


PADS: dict[str, tuple[Callable[[pygmsh.occ.Geometry], Size], float, float]] = {
    "dome": (dome, 3.0, 4.0),
    "slotted": (slotted, 2.0, 6.0),
    "pillars": (pillars, 3.0, 7.5),
    "box": (box, 2.0, 7.5),
}
"""Drawing, height, and how far the target reaches [mm]."""


def drawn(name: str) -> meshio.Mesh:
    """Return one pad, meshed, with its groups."""
    draw, height, reach = PADS[name]
    with pygmsh.occ.Geometry() as geometry:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        size = draw(geometry)
        geometry.set_mesh_size_callback(size, ignore_other_mesh_sizes=True)
        mesh = geometry.generate_mesh(dim=3)
    tetrahedra = mesh.cells_dict["tetra"].astype(int)
    used, tetrahedra = np.unique(tetrahedra, return_inverse=True)
    points, tetrahedra = mesh.points[used], tetrahedra.reshape(-1, 4)
    faces = outer(tetrahedra)
    x, y, z = np.moveaxis(points[faces], 2, 0)
    far = np.hypot(x, y) if name == "dome" else np.maximum(np.abs(x), y)
    on_target = np.all(np.abs(z - height) < 1e-6, axis=1) & np.all(far < reach + 1e-6, axis=1)
    groups = [np.all(np.abs(z) < 1e-6, axis=1), on_target, np.all(np.abs(y) < 1e-6, axis=1)]
    tags = np.select(groups, [1, 2, 4], 3)
    cells = [("triangle", faces), ("tetra", tetrahedra)]
    marks = [tags, np.full(len(tetrahedra), 5)]
    found = meshio.Mesh(1e-3 * points, cells, cell_data={"gmsh:physical": marks, "gmsh:geometrical": marks})
    for tag, group in enumerate(("ground", "target", "free", "symmetry"), start=1):
        found.field_data[group] = np.array([tag, 2])
    found.field_data["pad"] = np.array([5, 3])
    return found


def outer(tetrahedra: np.ndarray) -> np.ndarray:
    """Return the faces that belong to one tetrahedron only."""
    faces = np.sort(tetrahedra[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), axis=1)
    found, count = np.unique(faces, axis=0, return_counts=True)
    return found[count == 1]


def main(folder: Path) -> None:
    """Write all of them."""
    for name in PADS:
        meshio.write(folder / f"{name}.msh", drawn(name), file_format="gmsh22", binary=False)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
