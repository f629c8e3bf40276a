#!/usr/bin/env bash
# One would guess: names of faces (cell_sets) survive a .msh file, gmsh's own, whose physical groups meshio reads as sets.
# What happens: meshio writes .msh without physical groups and without a word; read back, the mesh has no set. (.inp
# keeps them, .vtu turns them into data and says so.)
# Version: meshio 5.3.5 (numpy 2.2.6). Met by all who convert a mesh with boundary names to .msh for another solver.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q --disable-pip-version-check meshio==5.3.5 numpy==2.2.6
cd "$work"

"$work/venv/bin/python" - <<'END' 2>&1 | tee said
import meshio
import numpy as np

points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
cells = [("triangle", np.array([[0, 2, 1], [0, 1, 3]])), ("tetra", np.array([[0, 1, 2, 3]]))]
sets = {"ground": [np.array([0]), np.array([], int)], "free": [np.array([1]), np.array([], int)]}
for suffix in ("inp", "msh"):
    meshio.Mesh(points, cells, cell_sets=sets).write(f"box.{suffix}")
    back = meshio.read(f"box.{suffix}")
    print(f"sets read back from .{suffix}:", sorted(back.cell_sets), "names:", sorted(back.field_data))
assert not back.cell_sets and not back.field_data and "PhysicalNames" not in open("box.msh", errors="replace").read()
END
[ "$(wc -l <said)" = 2 ] # no warning beside the two lines
