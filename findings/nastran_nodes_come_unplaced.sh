#!/usr/bin/env bash
# Guess:    meshio reads the nodes of a Nastran file where they stand: a GRID gives its coordinates in the system that its
#           third field names, which the file defines.
# Happens:  the numbers come as they are written, whatever system they are in: a plate in a system that is moved by 3 and
#           turned by a quarter lies at the origin, unturned; nodes in a cylindrical system come with degrees as metres.
#           INCLUDE is passed over too, with the cells that stand there. Nothing is reported.
# Version:  meshio 5.3.5; pyNastran 1.4.1 places them.
# Users:    whoever takes a target's outline, or a pad, from Femap, HyperMesh or Patran, which keep the part's own system.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check meshio==5.3.5 pyNastran==1.4.1 numpy==1.26.4 scipy==1.17.1
cat >show.py <<'PYTHON'
import meshio
import numpy as np
from pyNastran.bdf.bdf import BDF

SYSTEMS = {
    "basic": "",
    "moved, turned": "CORD2R,7,,0.,0.,3.,0.,0.,4.\n,0.,1.,3.\n",  # its x along y
    "cylindrical": "CORD2C,7,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
}


def deck(definition, each):
    grids = [f"GRID,{k + 1},{each},{x},{y},0." for k, (x, y) in enumerate([(1.0, 0.0), (2.0, 0.0), (2.0, 90.0)])]
    return "\n".join(["CEND", "BEGIN BULK", definition + "\n".join(grids), "CTRIA3,1,1,1,2,3",
                      "PSHELL,1,1,0.1", "MAT1,1,1.+7,,0.3", "ENDDATA", ""])


def places(text):
    with open("plate.bdf", "w") as file:
        file.write(text)
    model = BDF(debug=False)
    model.read_bdf("plate.bdf")
    right = np.array([model.nodes[k].get_position() for k in (1, 2, 3)])
    return meshio.read("plate.bdf").points, right


def row(points):
    return " ".join("(" + " ".join(f"{x + 0:g}" for x in point.round(9)) + ")" for point in points)


decks = {name: deck(text, 7 if text else "") for name, text in SYSTEMS.items()}
for name, text in decks.items():
    came, right = places(text)
    print(f"{name}: meshio {row(came)}; pyNastran {row(right)}")

head, tail = decks["basic"].split("CTRIA3")
with open("cells.bdf", "w") as file:
    file.write("CTRIA3" + tail.split("PSHELL")[0])
came, right = places(head + "INCLUDE 'cells.bdf'\nPSHELL" + tail.split("PSHELL")[1])
print("cells by INCLUDE: meshio", len(meshio.read("plate.bdf").cells), "blocks of cells")
PYTHON
env/bin/python show.py 2>&1 | tee seen
diff seen - <<'SEEN'
basic: meshio (1 0 0) (2 0 0) (2 90 0); pyNastran (1 0 0) (2 0 0) (2 90 0)
moved, turned: meshio (1 0 0) (2 0 0) (2 90 0); pyNastran (0 1 3) (0 2 3) (-90 2 3)
cylindrical: meshio (1 0 0) (2 0 0) (2 90 0); pyNastran (1 0 0) (2 0 0) (0 2 0)
cells by INCLUDE: meshio 0 blocks of cells
SEEN
