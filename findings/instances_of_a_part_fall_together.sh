#!/usr/bin/env bash
# Guess:    meshio reads an Abaqus assembly with two instances of one part, one of them moved by 3, as two blocks.
# Happens:  it reads the part once, where it was drawn: *INSTANCE and its translation are passed over without a word.
#           A part that stands once but moved comes at the place of its sketch.
# Version:  meshio 5.3.5.
# Users:    whoever brings a pad from Abaqus/CAE, which writes parts and instances unless it is told to write flat files.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check meshio==5.3.5 numpy==2.4.6
cat >two.inp <<'INPUT'
*HEADING
two blocks side by side
*PART, NAME=BLOCK
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*ELEMENT, TYPE=C3D8, ELSET=PAD
1, 1, 2, 3, 4, 5, 6, 7, 8
*END PART
*ASSEMBLY, NAME=SENSOR
*INSTANCE, NAME=LEFT, PART=BLOCK
*END INSTANCE
*INSTANCE, NAME=RIGHT, PART=BLOCK
3., 0., 0.
*END INSTANCE
*END ASSEMBLY
INPUT
cat >show.py <<'PYTHON'
import meshio

mesh = meshio.read("two.inp")
print(sum(len(each) for each in mesh.cells), "block of 2, from x =", mesh.points[:, 0].min(), "to", mesh.points[:, 0].max(), "of 0 to 4")
PYTHON
env/bin/python show.py 2>&1 | tee seen
diff seen - <<'SEEN'
1 block of 2, from x = 0.0 to 1.0 of 0 to 4
SEEN
