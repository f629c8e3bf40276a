#!/usr/bin/env bash
# One would guess: writing a mesh to a file leaves the mesh in memory as it is.
# What happens: writing .vtu (or .vtk) turns the mesh's own cell_sets and point_sets into data, so that an .inp which is
# written after it has no sets any more, while one written before has them. The .vtu's message says "Converting".
# Version: meshio 5.3.5 (numpy 2.2.6). Met by all who write one mesh with named faces for ParaView and for a solver.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q --disable-pip-version-check meshio==5.3.5 numpy==2.2.6
cd "$work"

"$work/venv/bin/python" - <<'END'
import meshio
import numpy as np

points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
cells = [("triangle", np.array([[0, 2, 1], [0, 1, 3]])), ("tetra", np.array([[0, 1, 2, 3]]))]
sets = {"ground": [np.array([0]), np.array([], int)], "free": [np.array([1]), np.array([], int)]}
mesh = meshio.Mesh(points, cells, cell_sets=sets)
mesh.write("before.inp")
mesh.write("view.vtu")
mesh.write("after.inp")
before, after = (list(meshio.read(name).cell_sets) for name in ("before.inp", "after.inp"))
print("sets of the .inp written before the .vtu:", before)
print("sets of the .inp written after the .vtu: ", after)
print("sets of the mesh in memory:              ", list(mesh.cell_sets))
assert set(before) == {"ground", "free"} and after == [] and not mesh.cell_sets
END
