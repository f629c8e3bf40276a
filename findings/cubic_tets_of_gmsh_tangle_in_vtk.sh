#!/usr/bin/env bash
# Guess:    a mesh of third-order tetrahedra that Gmsh writes as .vtk has its volume in PyVista (VTK), as one of first or
#           second order has.
# Happens:  the cells have VTK's type for Lagrange tetrahedra, but nodes in Gmsh's order: those of the edges at the fourth
#           corner run the other way. Each cell is tangled, straight ones too: a ball has -0.06 of its volume, one of fourth
#           order -0.25. Nothing is reported. Bricks of third order are right.
# Version:  gmsh 4.15.2, pyvista 0.49.1, vtk 9.7.2.
# Users:    whoever curves a domed pad or a round can to third order, so that a few cells do, and looks at it in ParaView or
#           integrates there.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check gmsh==4.15.2 pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6
cat >show.py <<'PYTHON'
import gmsh
import numpy as np
import pyvista

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)


def volumes():
    """Of the mesh by quadrature of the determinants that Gmsh gives, and by VTK."""
    kinds = gmsh.model.mesh.getElementTypes(3)
    points, weights = gmsh.model.mesh.getIntegrationPoints(kinds[0], "Gauss6")
    determinants = np.reshape(gmsh.model.mesh.getJacobians(kinds[0], points)[1], (-1, len(weights)))
    gmsh.write("solid.vtk")
    return (determinants @ weights).sum(), pyvista.read("solid.vtk").volume


for shape in ("ball", "brick"):
    for order in (1, 2, 3, 4):
        gmsh.clear()
        if shape == "ball":
            gmsh.model.occ.addSphere(0, 0, 0, 1)
            gmsh.model.occ.synchronize()
            gmsh.option.setNumber("Mesh.MeshSizeMax", 0.7)
        else:
            gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
            gmsh.model.occ.synchronize()
            gmsh.model.mesh.setTransfiniteAutomatic()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        own, seen = volumes()
        print(f"{shape}, order {order}: Gmsh's cells {own:.2f}, the file in PyVista {seen:.2f}")
PYTHON
env/bin/python show.py 2>&1 | tee seen
diff seen - <<'SEEN'
ball, order 1: Gmsh's cells 4.04, the file in PyVista 4.04
ball, order 2: Gmsh's cells 4.19, the file in PyVista 4.15
ball, order 3: Gmsh's cells 4.19, the file in PyVista -0.27
ball, order 4: Gmsh's cells 4.19, the file in PyVista -1.07
brick, order 1: Gmsh's cells 1.00, the file in PyVista 1.00
brick, order 2: Gmsh's cells 1.00, the file in PyVista 1.00
brick, order 3: Gmsh's cells 1.00, the file in PyVista 1.00
brick, order 4: Gmsh's cells 1.00, the file in PyVista 1.00
SEEN
