#!/usr/bin/env bash
# One would guess: tetrahedra written to a Tecplot file are tetrahedra when they are read, with or without faces beside.
# What happens: with triangles of the surface beside them the file's zone is of quadrilaterals, and the tetrahedra come
# back as quadrilaterals: a solid becomes a surface. Alone they come back as tetrahedra. The warning is of something
# else, that the triangles are left out.
# Version: meshio 5.3.5 (numpy 2.2.6). Met by all who hand a mesh with named faces to Tecplot or to readers of its files.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q --disable-pip-version-check meshio==5.3.5 numpy==2.2.6
cd "$work"

"$work/venv/bin/python" - <<'END'
import meshio
import numpy as np

points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
faces, solid = ("triangle", np.array([[0, 2, 1]])), ("tetra", np.array([[0, 1, 2, 3], [1, 2, 3, 4]]))
kinds = []
for cells in ([solid], [faces, solid]):
    meshio.Mesh(points, cells).write("box.dat")
    zone = next(line for line in open("box.dat") if "ZONETYPE" in line).strip()
    kinds.append([block.type for block in meshio.read("box.dat").cells])
    print("written:", [kind for kind, _ in cells], "| file:", zone, "| read:", kinds[-1])
assert kinds == [["tetra"], ["quad"]]
END
