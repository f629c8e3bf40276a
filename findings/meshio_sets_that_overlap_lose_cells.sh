#!/usr/bin/env bash
# One would guess: cell_sets_to_data() keeps which cells belong to which set, or says where it cannot.
# What happens: a cell has one number, that of the last set that holds it; the sets before lose it without a word. Meshes
# that gmsh wrote as .msh 4.1 have such a set beside the named groups as meshio reads them, "gmsh:bounding_entities",
# which takes some of their cells.
# Version: meshio 5.3.5 (numpy 2.2.6). Met by all who carry boundary names from .msh to .vtu: loads on fewer faces.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q --disable-pip-version-check meshio==5.3.5 numpy==2.2.6
cd "$work"

"$work/venv/bin/python" - <<'END'
import meshio
import numpy as np

points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
cells = [("triangle", np.array([[0, 1, 2], [0, 2, 3]]))]
mesh = meshio.Mesh(points, cells, cell_sets={"ground": [np.array([0, 1])], "rim": [np.array([1])]})
print("cells of ground, as a set:          ", mesh.cell_sets["ground"][0].tolist())
mesh.cell_sets_to_data()
mesh.write("box.vtu")
back = meshio.read("box.vtu")
number = back.cell_data["ground-rim"][0]
print("cells of ground, by the .vtu's data:", np.flatnonzero(number == 0).tolist())
assert number.tolist() == [0, 1]
END
