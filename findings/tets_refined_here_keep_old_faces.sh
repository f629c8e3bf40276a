#!/usr/bin/env bash
# Guess:    refining some tetrahedra of a scikit-fem mesh carries its named boundaries over to the new facets, or drops
#           them with a warning, as refining all tetrahedra or some triangles does.
# Happens:  the names stay, with the numbers of the *old* facets: "ground" then names facets inside the body or on other
#           faces, and a condition set on it holds the wrong nodes. No warning.
# Version:  scikit-fem 12.0.2.
# Users:    whoever refines a bonded edge of a meshed layer, where strains are singular, and clamps its ground by name.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check scikit-fem==12.0.2 numpy==2.4.6 scipy==1.17.1
cat >show.py <<'PYTHON'
import numpy as np
from skfem import MeshTet, MeshTri


def row(label, mesh):
    if not mesh.boundaries:
        print(f"{label}: no boundaries")
        return
    named = mesh.boundaries["ground"]
    right = np.isclose(mesh.p[-1, mesh.facets[:, named]], 0).all(axis=0)
    whole = (np.isclose(mesh.p[-1, mesh.facets], 0).all(axis=0)).sum()
    print(f"{label}: 'ground' names {len(named)} facets, {right.sum()} of the {whole} on the ground")


for kind in MeshTri, MeshTet:
    mesh = kind().refined(1).with_boundaries({"ground": lambda x: x[-1] == 0})
    row(f"{kind.__name__}", mesh)
    row(f"{kind.__name__}, all cells refined", mesh.refined(1))
    row(f"{kind.__name__}, four cells refined", mesh.refined([0, 1, 2, 3]))
PYTHON
env/bin/python show.py 2>&1 | tee seen
diff seen - <<'SEEN'
MeshTri1: 'ground' names 2 facets, 2 of the 2 on the ground
MeshTri1, all cells refined: 'ground' names 4 facets, 4 of the 4 on the ground
Named boundaries invalidated by a call to Mesh.refined()
MeshTri1, four cells refined: no boundaries
MeshTet1: 'ground' names 8 facets, 8 of the 8 on the ground
Named boundaries invalidated by a call to Mesh.refined()
MeshTet1, all cells refined: no boundaries
MeshTet1, four cells refined: 'ground' names 8 facets, 0 of the 10 on the ground
SEEN
