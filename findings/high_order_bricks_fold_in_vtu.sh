#!/usr/bin/env bash
# Guess:    a mesh of Lagrange bricks that FElupe makes is the same solid in PyVista, whether it is handed over in memory, as
#           .vtk or as .vtu; and what PyVista writes is read back by meshio, by which FElupe reads and writes.
# Happens:  in memory and as .vtk it is right. As .vtu a cube has 0.75 of its volume (order 2), 0.78, 0.81 (3, 4): meshio marks
#           its file as version 0.1, of a time when two upright edges were numbered the other way, and VTK, which reads
#           that, exchanges them. PyVista marks its own file as 2.3, which meshio refuses.
# Version:  felupe 11.3.0, meshio 5.3.5, pyvista 0.49.1, vtk 9.7.2.
# Users:    whoever solves rubber with bricks of higher order in FElupe, and looks at the result, or integrates it, from .vtu.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check felupe==11.3.0 meshio==5.3.5 pyvista==0.49.1 vtk==9.7.2 \
    numpy==2.4.6 scipy==1.17.1 h5py==3.16.0
cat >show.py <<'PYTHON'
import felupe
import meshio
import numpy as np
import pyvista

for order in (2, 3, 4):
    mesh = felupe.mesh.CubeArbitraryOrderHexahedron(order=order)
    cells = np.hstack([np.full((len(mesh.cells), 1), mesh.cells.shape[1]), mesh.cells])
    memory = pyvista.UnstructuredGrid(cells.ravel(), [pyvista.CellType.LAGRANGE_HEXAHEDRON] * len(cells), mesh.points)
    volumes = {"memory": memory.volume}
    for suffix in ("vtk", "vtu"):
        mesh.as_meshio().write(f"cube.{suffix}")
        volumes[suffix] = pyvista.read(f"cube.{suffix}").volume
    print(f"order {order}: " + ", ".join(f"{name} {volume:.4f}" for name, volume in volumes.items()))
memory.save("own.vtu")
print("of PyVista, back in PyVista:", round(pyvista.read("own.vtu").volume, 4))
try:
    meshio.read("own.vtu")
except SystemExit:
    print("of PyVista, in meshio: refused")
PYTHON
env/bin/python show.py 2>&1 | grep . | tee seen
diff seen - <<'SEEN'
order 2: memory 1.0000, vtk 1.0000, vtu 0.7500
order 3: memory 1.0000, vtk 1.0000, vtu 0.7778
order 4: memory 1.0000, vtk 1.0000, vtu 0.8125
of PyVista, back in PyVista: 1.0
Unknown VTU file version '2.3'.
Error: Couldn't read file own.vtu as vtu
of PyVista, in meshio: refused
SEEN
