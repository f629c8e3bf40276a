"""Fill the space between given closed outlines with triangles. The one file that knows pygmsh and gmsh.

The outlines' vertices become nodes of the mesh exactly as given: no edge of an outline is divided. Inside, triangles
grow from the edges of the outlines towards those of the outer boundary. gmsh runs on the main thread of a process only.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from types import ModuleType

import numpy as np
from scipy.spatial import cKDTree

from sits_mech.quantities import Array, Integers

DEBIAN_PACKAGES = "libglu1-mesa libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1 libgl1 libegl1 libgl1-mesa-dri"


class MesherMissing(ValueError):
    """The mesh generator cannot be used here; the message says what to do."""


def mesh_generator() -> ModuleType:
    """Return pygmsh; MesherMissing if it, gmsh or gmsh's system libraries are missing, or off the main thread."""
    if threading.current_thread() is not threading.main_thread():
        raise MesherMissing("mesh generator: gmsh must run on the main thread of a process; got another thread")
    try:
        import pygmsh
    except ImportError as error:
        raise MesherMissing(
            "mesh generator: pygmsh and gmsh must be installed (pip install '.[mesh]' in a clone) with the libraries "
            f"that gmsh loads (on Debian: apt-get install {DEBIAN_PACKAGES}); got {error}"
        ) from None
    except OSError as error:
        raise MesherMissing(
            f"mesh generator: gmsh needs system libraries (on Debian: apt-get install {DEBIAN_PACKAGES}); got {error}"
        ) from None
    return pygmsh  # type: ignore[no-any-return]


def fill_between(outer: Array, holes: Sequence[Array]) -> tuple[Array, Integers]:
    """Return points (p, 2) and triangles (m, 3) that fill `outer` (n, 2) but for the `holes` (k, 2), not closed [m].

    Points are the corners of `outer`, then of each hole, in the order given, then the inner nodes. MesherMissing if
    gmsh cannot be used here, ValueError if it cannot mesh these outlines.
    """
    generator = mesh_generator()
    given = np.vstack([outer, *holes])
    centre, scale = outer.mean(axis=0), float(np.ptp(outer, axis=0).max())
    with generator.geo.Geometry() as geometry:
        _set_options()
        # as Python does: gmsh lets broken pipes end the process, without a word
        if (number := getattr(signal, "SIGPIPE", None)) is not None:  # Windows has none
            signal.signal(number, signal.getsignal(number))
        loops = [_loop(geometry, (outline - centre) / scale) for outline in (outer, *holes)]
        geometry.add_plane_surface(loops[0], holes=loops[1:])
        try:
            mesh = geometry.generate_mesh(dim=2)
        except Exception as error:  # gmsh raises bare Exception
            raise ValueError(f"mesh: gmsh must be able to mesh the air between the conductors; got {error}") from None
    triangles = np.vstack([block.data for block in mesh.cells if block.type == "triangle"]).astype(np.int64)
    return _given_first(given, np.asarray(mesh.points[:, :2]) * scale + centre, triangles)


def _set_options() -> None:
    """Silence, double precision down to small edges, a mesher that bears strong grading."""
    import gmsh

    for name, number in (
        ("General.Terminal", 0), ("General.NumThreads", 1), ("Geometry.Tolerance", 1e-13), ("Mesh.Algorithm", 5),
        ("Mesh.MeshSizeMin", 0), ("Mesh.MeshSizeFromPoints", 0), ("Mesh.MeshSizeExtendFromBoundary", 1),
    ):
        gmsh.option.setNumber(name, number)


def _loop(geometry: object, outline: Array) -> object:
    """Return one closed loop of straight edges that are not to be divided."""
    kernel: ModuleType = geometry  # type: ignore[assignment]
    sizes = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    points = [kernel.add_point([x, z, 0.0], mesh_size=size) for (x, z), size in zip(outline, sizes, strict=True)]
    lines = [kernel.add_line(p, q) for p, q in zip(points, points[1:] + points[:1], strict=True)]
    for line in lines:
        kernel.set_transfinite_curve(line, 2, "Progression", 1.0)
    return kernel.add_curve_loop(lines)


def _given_first(given: Array, points: Array, triangles: Integers) -> tuple[Array, Integers]:
    """Number the nodes anew, the given ones first and where they were given."""
    used, triangles = np.unique(triangles, return_inverse=True)
    points = points[used]
    distance, index = cKDTree(points).query(given)
    edge = np.linalg.norm(np.roll(given, -1, axis=0) - given, axis=1)
    if np.unique(index).size != len(given) or np.any(distance > 1e-2 * edge):
        raise ValueError("mesh: gmsh must keep every given node of the outlines; it moved or merged some")
    number = np.full(len(points), -1)
    number[index] = np.arange(len(given))
    inner = number < 0
    number[inner] = len(given) + np.arange(inner.sum())
    return np.vstack([given, points[inner]]), number[triangles.reshape(-1, 3)]
