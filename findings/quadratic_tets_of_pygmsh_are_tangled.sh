#!/usr/bin/env bash
# Guess:    `generate_mesh(order=2)` of pygmsh returns a meshio mesh whose second-order tetrahedra are numbered as meshio
#           numbers them, as those that meshio reads from a file of Gmsh are.
# Happens:  the last two middle nodes stand in Gmsh's order, each on the other's edge, in straight and in curved cells
#           alike, without a word. A unit cube, written to .vtu, has a quarter of its volume in PyVista; scikit-fem stops with
#           "Zero Jacobian determinant", which names no reason. Through a file of Gmsh the same mesh is right.
# Version:  pygmsh 7.1.17, meshio 5.3.5, gmsh 4.15.2, scikit-fem 12.0.2, pyvista 0.49.1.
# Users:    whoever meshes a pad with pygmsh for quadratic elements, which rubber needs, and hands it over in memory.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check pygmsh==7.1.17 meshio==5.3.5 gmsh==4.15.2 scikit-fem==12.0.2 \
    pyvista==0.49.1 numpy==2.4.6 scipy==1.17.1
cat >show.py <<'PYTHON'
import logging

import gmsh
import meshio
import numpy as np
import pygmsh
import pyvista
from skfem import Basis, ElementTetP1
from skfem.io.meshio import from_meshio

logging.disable(logging.WARNING)
with pygmsh.occ.Geometry() as geometry:
    geometry.characteristic_length_max = 0.5
    geometry.add_box([0, 0, 0], [1, 1, 1])
    in_memory = geometry.generate_mesh(dim=3, order=2)
    gmsh.write("box.msh")
tetra = {"in memory": in_memory, "through a file": meshio.read("box.msh")}
edges = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
for name, mesh in tetra.items():
    cells = mesh.get_cells_type("tetra10")
    x = mesh.points[cells]
    wrong = [4 + k for k, (a, b) in enumerate(edges) if not np.allclose(x[:, 4 + k], (x[:, a] + x[:, b]) / 2)]
    solid = meshio.Mesh(mesh.points, {"tetra10": cells})
    solid.write("solid.vtu")
    try:
        volume = f"{Basis(from_meshio(solid), ElementTetP1(), intorder=4).dx.sum():.2f}"
    except Exception as error:
        volume = str(error)
    seen = pyvista.read("solid.vtu").volume
    print(f"{name}: nodes off their edges {wrong}, volume in PyVista {seen:.2f}, scikit-fem: {volume}")
PYTHON
env/bin/python show.py | grep edges | tee printed
diff printed - <<'EXPECTED'
in memory: nodes off their edges [8, 9], volume in PyVista 0.25, scikit-fem: Zero Jacobian determinant
through a file: nodes off their edges [], volume in PyVista 1.00, scikit-fem: 1.00
EXPECTED
