#!/usr/bin/env bash
# Guess:    a file that meshio cannot read raises meshio.ReadError, as its documentation says; `except Exception` around
#           a batch of meshes catches it, and the next mesh is read.
# Happens:  where the extension is known, `meshio.read` prints the reason and calls sys.exit(1): SystemExit is no
#           Exception, so that the batch ends there. Gmsh's own second-order Abaqus file does it ("CPS6"), and a plain
#           .inp that meshio itself has written from a mesh with names of Gmsh ("Unknown cell set").
# Version:  meshio 5.3.5, gmsh 4.15.2.
# Users:    whoever lets a script read the meshes of a folder, or shows "cannot be read" in a program of their own.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check meshio==5.3.5 gmsh==4.15.2 numpy==2.4.6
cat >show.py <<'PYTHON'
import gmsh
import meshio

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], name="pad")
gmsh.model.addPhysicalGroup(2, [5], name="ground")
gmsh.model.mesh.generate(3)
gmsh.write("pad.msh")
gmsh.model.mesh.setOrder(2)
gmsh.write("second.inp")
meshio.read("pad.msh").write("again.inp")

for name in "second.inp", "again.inp":
    try:
        meshio.read(name)
        print(name, "is read")
    except Exception as error:
        print(name, "raises", type(error).__name__)
    except SystemExit as error:
        print(name, "passes `except Exception`:", repr(error))
PYTHON
env/bin/python show.py 2>/dev/null | grep SystemExit | tee seen
diff seen - <<'SEEN'
second.inp passes `except Exception`: SystemExit(1)
again.inp passes `except Exception`: SystemExit(1)
SEEN
