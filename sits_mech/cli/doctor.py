"""Check the installation: versions of dependencies, what each missing part would be needed for, and a try.

gmsh and OpenGL can be installed and yet not work for want of system libraries: one is loaded, the other renders once.
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from importlib import metadata
from importlib.util import find_spec

from sits_mech.disk_cache import folder, kept_files
from sits_mech.geometry.meshing.unstructured import mesh_generator
from sits_mech.report.pictures.spatial import renders
from sits_mech.version import __version__

_PARTS = {
    "numpy": "core", "scipy": "core", "scikit-fem": "core", "meshio": "core", "pydantic": "core", "pint": "core",
    "xarray": "core", "netCDF4": "core", "cyclopts": "core", "shapely": "core",
    "rich": "core", "threadpoolctl": "core", "platformdirs": "core",
    "matplotlib": "pictures: pip install '.[view]' in a clone",
    "pyvista": "3D views: pip install '.[view]' in a clone",
    "gmsh": "meshes of any outline: pip install '.[mesh]' in a clone",
    "pygmsh": "meshes of any outline: pip install '.[mesh]' in a clone",
    "openpyxl": "workbooks: pip install '.[excel]' in a clone",
    "nicegui": "the studio: pip install '.[studio]' in a clone",
    "distributed": "runs on a cluster: pip install '.[cluster]' in a clone",
}
_MODULES = {"scikit-fem": "skfem"}


def examine() -> list[tuple[str, str, str]]:
    """Return name, version ("missing" where it is not installed) and purpose of each part, the package itself first."""
    found = [("sits-mech", __version__, ""), ("python", platform.python_version(), "3.11 or later")]
    for name, purpose in _PARTS.items():
        found.append((name, _version(name), purpose))
    return [*found, _kept(), _tried("mesh generator", mesh_generator), _tried("render off screen", renders)]


def _kept() -> tuple[str, str, str]:
    """Say how much is kept of preparations, and where."""
    files = kept_files()
    size = sum(path.stat().st_size for path in files) / 2**20
    return "kept preparations", f"{size:.1f} MB", f"{len(files)} files in {folder()}; --clear removes them"


def _tried(name: str, use: Callable[[], object]) -> tuple[str, str, str]:
    """Say whether something that may lack system libraries works, or the sentence that names them."""
    try:
        use()
    except ValueError as error:
        return name, "fails", str(error)
    return name, "works", ""


def _version(name: str) -> str:
    """Return the version of an installed distribution, or "missing"."""
    if find_spec(_MODULES.get(name, name)) is None:
        return "missing"
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "of unknown version"


def healthy(parts: list[tuple[str, str, str]]) -> bool:
    """Tell whether nothing of the core is missing."""
    return all(version != "missing" for _, version, purpose in parts if purpose.startswith("core"))
