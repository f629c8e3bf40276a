#!/usr/bin/env bash
# Guess:    a solid that NGSolve writes by `VTKOutput` has its volume in PyVista (VTK), and integrals of fields over it
#           are those of NGSolve.
# Happens:  tetrahedra and bricks are written inside out: volume and integrals come with the wrong sign, normals of the
#           surface point inwards. With `subdivision=1` a tetrahedron becomes five and a prism, some of them inside out
#           and some not: the parts cancel, and a ball has 0.9 of its 3.8 m^3, a number that looks like one.
# Version:  ngsolve 6.2.2608, pyvista 0.49.1, vtk 9.7.2.
# Users:    whoever integrates pressure, energy or eddy losses of a reference of NGSolve in ParaView or PyVista, or colours
#           by the angle between surface and field.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check ngsolve==6.2.2608 pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6
cat >show.py <<'PYTHON'
import numpy as np
import pyvista
from netgen.occ import OCCGeometry, Pnt, Sphere
from ngsolve import CF, Integrate, Mesh, VTKOutput, z
from ngsolve.meshes import MakeStructured3DMesh

ball = Mesh(OCCGeometry(Sphere(Pnt(0, 0, 0), 1)).GenerateMesh(maxh=0.5))
for name, mesh, subdivision in (
    ("bricks", MakeStructured3DMesh(nx=2, ny=2, nz=2), 0), ("tetrahedra", ball, 0), ("tetrahedra in parts", ball, 1)
):
    VTKOutput(mesh, coefs=[1 + z], names=["f"], filename="solid", subdivision=subdivision).Do()
    solid = pyvista.read("solid.vtu")
    sizes = solid.compute_cell_sizes()["Volume"]
    integral = solid.integrate_data()["f"][0]
    print(
        f"{name}: volume {Integrate(CF(1), mesh):.1f} in NGSolve, {solid.volume:.1f} in PyVista; "
        f"int 1 + z {Integrate(1 + z, mesh):.1f} and {integral:.1f}; inside out {np.mean(sizes < 0):.0%}"
    )
PYTHON
env/bin/python show.py | grep volume | tee printed
diff printed - <<'EXPECTED'
bricks: volume 1.0 in NGSolve, -1.0 in PyVista; int 1 + z 1.5 and -1.5; inside out 100%
tetrahedra: volume 3.8 in NGSolve, -3.8 in PyVista; int 1 + z 3.8 and -3.8; inside out 100%
tetrahedra in parts: volume 3.8 in NGSolve, 0.9 in PyVista; int 1 + z 3.8 and 0.8; inside out 50%
EXPECTED
