#!/usr/bin/env bash
# Guess:    `mesh.write("pad.msh")` of meshio writes Gmsh's format: it read the mesh from a .msh of Gmsh, names and all.
# Happens:  it writes ANSYS Fluent's .msh, which ends alike and comes first in its table, without a word. Names of
#           groups are gone when meshio reads it back, and Gmsh stops at line 1. With file_format="gmsh" both are right;
#           with "gmsh22" the names' table is kept, but no cell belongs to a name.
# Version:  meshio 5.3.5, gmsh 4.15.2.
# Users:    whoever reads a pad from Gmsh, moves its nodes in Python and writes it again for a solver that asks for
#           named faces.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check meshio==5.3.5 gmsh==4.15.2 numpy==2.4.6
cat >show.py <<'PYTHON'
import gmsh, meshio

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], name="pad")
gmsh.model.addPhysicalGroup(2, [5], name="ground")
gmsh.model.mesh.generate(3)
gmsh.write("pad.msh")

mesh = meshio.read("pad.msh")
print("read from Gmsh:", sorted(set(mesh.cell_sets) - {"gmsh:bounding_entities"}))
for words in ({}, {"file_format": "gmsh"}, {"file_format": "gmsh22"}):
    mesh.write("again.msh", **words)
    with open("again.msh", "rb") as file:
        first = file.readline().decode().strip()
    try:
        gmsh.open("again.msh")
        opened = "opens"
    except Exception:
        opened = "does not open"
    names = sorted(set(meshio.read("again.msh").cell_sets) - {"gmsh:bounding_entities"})
    print(f"write(again.msh, {words}): first line {first}; names {names}; Gmsh: {opened}")
PYTHON
env/bin/python show.py 2>/dev/null | grep . | tee seen
diff seen - <<'SEEN'
read from Gmsh: ['ground', 'pad']
write(again.msh, {}): first line (1 "meshio 5.3.5"); names []; Gmsh: does not open
write(again.msh, {'file_format': 'gmsh'}): first line $MeshFormat; names ['ground', 'pad']; Gmsh: opens
write(again.msh, {'file_format': 'gmsh22'}): first line $MeshFormat; names []; Gmsh: opens
SEEN
