#!/usr/bin/env bash
# Guess:    meshio turns the nodes of MED's solid cells into the order that its other formats have, and back when it writes.
# Happens:  MED numbers a tetrahedron and a brick the other way round than VTK and Gmsh. meshio passes nodes on as they
#           stand: what SALOME's library or Gmsh wrote is inside out, by -1 times its volume in PyVista, and what meshio
#           writes is so for SALOME. Names of groups come through, nothing is reported.
# Version:  meshio 5.3.5, medcoupling 9.15.0, gmsh 4.15.2, pyvista 0.46.4.
# Users:    whoever meshes a silicone pad in SALOME, or keeps a mesh of Gmsh as .med, and integrates over it elsewhere:
#           volumes, stiffness and pressure change sign where a code does not take the size of the determinant.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check meshio==5.3.5 h5py==3.16.0 medcoupling==9.15.0 gmsh==4.15.2 \
    pyvista==0.46.4 numpy==2.4.6
cat >show.py <<'PYTHON'
import gmsh
import medcoupling
import meshio
import pyvista

grid = medcoupling.MEDCouplingCMesh()
grid.setCoords(*(medcoupling.DataArrayDouble([0.0, 1.0, size]) for size in (12.0, 10.0, 3.0)))
bricks = grid.buildUnstructured()
bricks.setName("pad")
bricks.write("bricks.med")

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 12, 10, 3)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], name="pad")
gmsh.model.mesh.generate(3)
gmsh.write("tets.msh")
gmsh.write("tets.med")


def volume(name):
    """Integrate one over the solid cells that meshio reads, by PyVista."""
    read = meshio.read(name)
    solid = [block for block in read.cells if block.type in ("tetra", "hexahedron")]
    meshio.write("solid.vtu", meshio.Mesh(read.points, solid))
    return pyvista.read("solid.vtu").compute_cell_sizes()["Volume"].sum()


print(f"bricks.med, by medcoupling: {bricks.getMeasureField(False).accumulate()[0]:.1f}")
print(f"bricks.med, by meshio:      {volume('bricks.med'):.1f}")
print(f"tets.msh, by meshio:        {volume('tets.msh'):.1f}")
print(f"tets.med, by meshio:        {volume('tets.med'):.1f}")
read = meshio.read("tets.msh")
meshio.write("again.med", meshio.Mesh(read.points, {"tetra": read.cells_dict["tetra"]}))
again = medcoupling.ReadMeshFromFile("again.med")
print(f"again.med, by medcoupling:  {again.getMeasureField(False).accumulate()[0]:.1f}")
PYTHON
env/bin/python show.py 2>/dev/null | grep by | tee seen
diff seen - <<'SEEN'
bricks.med, by medcoupling: 360.0
bricks.med, by meshio:      -360.0
tets.msh, by meshio:        360.0
tets.med, by meshio:        -360.0
again.med, by medcoupling:  -360.0
SEEN
