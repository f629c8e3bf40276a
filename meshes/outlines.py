"""Makes the example outlines `slotted_disc.msh` and `cross.msh`: python meshes/outlines.py [DIR]."""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np

from sits_mech.geometry.outline import Outline, outline_plan
from sits_mech.geometry.sheet_plan import Grading


def slotted_disc(radius: float = 4e-3, slot: float = 0.4e-3, depth: float = 3.5e-3, corners: int = 48) -> Outline:
    """A disc [m] cut from the rim towards the centre: the eddy currents cannot run around it."""
    half = np.arcsin(slot / 2 / radius)
    angles = np.linspace(half, 2 * np.pi - half, corners + 1)
    rim = [(float(radius * np.cos(a)), float(radius * np.sin(a))) for a in angles]
    return Outline(((*rim, (radius - depth, -slot / 2), (radius - depth, slot / 2)),))


def cross(arm: float = 4e-3, half_width: float = 1.5e-3) -> Outline:
    """A plus sign [m]: two arms of one width, from the centre."""
    a, b = arm, half_width
    upper = ((a, -b), (a, b), (b, b), (b, a), (-b, a), (-b, b))
    return Outline(((*upper, *((-x, -y) for x, y in upper)),))


def main(folder: Path) -> None:
    """Write both meshes: triangles and quadrilaterals in the plane z = 0, lengths in metres."""
    for name, outline in (("slotted_disc", slotted_disc()), ("cross", cross())):
        plan = outline_plan(outline, Grading(first=0.2e-3, growth=2.0, largest=0.6e-3))
        triangle = plan.cells[:, 2] == plan.cells[:, 3]
        cells = [("quad", plan.cells[~triangle]), ("triangle", plan.cells[triangle][:, :3])]
        tags = [np.ones(len(block), dtype=int) for _, block in cells]
        points = np.column_stack([plan.nodes, np.zeros(len(plan.nodes))])
        mesh = meshio.Mesh(points, cells, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
        mesh.field_data["target"] = np.array([1, 2])
        meshio.write(folder / f"{name}.msh", mesh, file_format="gmsh22", binary=False)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
