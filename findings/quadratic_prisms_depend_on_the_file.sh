#!/usr/bin/env bash
# Guess:    meshio reads prisms of second order that Gmsh wrote alike from each format, as it does tetrahedra and bricks.
# Happens:  prisms of 18 nodes are right from .vtk, and tangled from Gmsh's own .msh: eight of nine middles of edges stand
#           on other edges, and a cube has an eighth of its volume. Prisms of 15 nodes come from neither: KeyError.
# Version:  meshio 5.3.5, gmsh 4.15.2, pyvista 0.49.1.
# Users:    whoever extrudes a thin layer of silicone in Gmsh, which gives prisms, with quadratic elements for rubber.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check meshio==5.3.5 gmsh==4.15.2 pyvista==0.49.1 numpy==2.4.6
cat >show.py <<'PYTHON'
import gmsh
import meshio
import numpy as np
import pyvista

EDGES = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))  # of VTK and meshio
for nodes in (18, 15):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(nodes == 15))
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.extrude([(2, square)], 0, 0, 1, numElements=[2], recombine=True)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1], name="layer")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    for kind in ("msh", "vtk"):
        gmsh.write(f"layer.{kind}")
        try:
            mesh = meshio.read(f"layer.{kind}")
        except Exception as error:
            print(f"{nodes} nodes, .{kind}: {type(error).__name__} {error}")
            continue
        cells = mesh.get_cells_type(f"wedge{nodes}")
        x = mesh.points[cells]
        off = sum(not np.allclose(x[:, 6 + k], (x[:, a] + x[:, b]) / 2) for k, (a, b) in enumerate(EDGES))
        meshio.Mesh(mesh.points, {f"wedge{nodes}": cells}).write("read.vtu")
        volume = pyvista.read("read.vtu").volume
        print(f"{nodes} nodes, .{kind}: {off} of 9 middles off their edges, volume {volume:.2f} of 1")
    gmsh.finalize()
PYTHON
env/bin/python show.py | grep nodes | tee printed
diff printed - <<'EXPECTED'
18 nodes, .msh: 8 of 9 middles off their edges, volume 0.12 of 1
18 nodes, .vtk: 0 of 9 middles off their edges, volume 1.00 of 1
15 nodes, .msh: KeyError 'wedge15'
15 nodes, .vtk: KeyError 'wedge15'
EXPECTED
