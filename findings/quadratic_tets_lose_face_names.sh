#!/usr/bin/env bash
# Guess:    scikit-fem loads the second-order mesh of a pad with the same names as the first-order mesh of the same pad.
# Happens:  volumes keep their names, faces lose theirs: `boundaries` is None, and "Failure to parse tags from meshio."
#           says neither which nor why. `MeshTet2.from_mesh` of a mesh with names drops both kinds without a word.
# Version:  scikit-fem 12.0.2, meshio 5.3.5, gmsh 4.15.2.
# Users:    whoever meshes a domed or round layer with curved (second-order) tetrahedra in Gmsh and clamps "ground".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check scikit-fem==12.0.2 meshio==5.3.5 gmsh==4.15.2 numpy==2.4.6 scipy==1.17.1
cat >show.py <<'PYTHON'
import gmsh
from skfem import MeshTet
from skfem.mesh import MeshTet2

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], name="pad")
gmsh.model.addPhysicalGroup(2, [5], name="ground")
gmsh.model.mesh.generate(3)
gmsh.write("first.msh")
gmsh.model.mesh.setOrder(2)
gmsh.write("second.msh")


def names(groups):
    return sorted(set(groups) - {"gmsh:bounding_entities"}) if groups else groups


for label, mesh in (
    ("order 1, loaded", first := MeshTet.load("first.msh")),
    ("order 2, loaded", MeshTet2.load("second.msh")),
    ("order 2, from order 1", MeshTet2.from_mesh(first)),
):
    print(f"{label}: boundaries {names(mesh.boundaries)}, subdomains {names(mesh.subdomains)}")
PYTHON
env/bin/python show.py 2>&1 | grep . | tee seen
diff seen - <<'SEEN'
Failure to parse tags from meshio.
order 1, loaded: boundaries ['ground'], subdomains ['pad']
order 2, loaded: boundaries None, subdomains ['pad']
order 2, from order 1: boundaries None, subdomains None
SEEN
