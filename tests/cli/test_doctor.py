"""What the doctor says: versions, and a try of what may lack system libraries."""

import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest

from sits_mech.cli import doctor
from sits_mech.geometry.meshing.unstructured import DEBIAN_PACKAGES
from sits_mech.report.pictures import spatial

PYVISTA = pytest.mark.skipif(find_spec("pyvista") is None, reason="pyvista is not installed")


def test_core_is_there_and_missing_parts_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """A part of the core that is missing makes the whole unhealthy; one of an extra does not."""
    parts = [("numpy", "2.0", "core"), ("gmsh", "missing", "meshes of any outline")]
    assert doctor.healthy(parts) and not doctor.healthy([("numpy", "missing", "core")])
    monkeypatch.setattr(doctor, "find_spec", lambda name: None if name == "gmsh" else find_spec(name))
    monkeypatch.setattr(doctor, "renders", lambda: None)
    monkeypatch.setattr(doctor, "mesh_generator", lambda: None)
    found = {name: version for name, version, _ in doctor.examine()}
    assert found["gmsh"] == "missing" and found["numpy"] != "missing"
    assert found["render off screen"] == found["mesh generator"] == "works"


def test_every_dependency_is_looked_at() -> None:
    """Those of the core, and of the extras that commands need."""
    asked = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = asked["optional-dependencies"]
    names = {kind: {re.match(r"[\w-]+", line)[0] for line in lines} for kind, lines in extras.items()}
    core = {re.match(r"[\w-]+", line)[0] for line in asked["dependencies"]}
    assert core == {name for name, purpose in doctor._PARTS.items() if purpose == "core"}
    for kind in ("mesh", "view", "cluster", "excel", "studio"):
        assert names[kind] - {"sits-mech"} <= doctor._PARTS.keys()


@PYVISTA
def test_a_render_that_ends_its_process_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """A segmentation fault in the trial process: the sentence that names the packages."""
    ended = subprocess.CompletedProcess([sys.executable], -11, "", "")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: ended)
    spatial.renders.cache_clear()
    name, state, reason = next(part for part in doctor.examine() if part[0] == "render off screen")
    assert state == "fails" and DEBIAN_PACKAGES in reason and "signal 11" in reason
    spatial.renders.cache_clear()


def test_a_generator_without_its_libraries_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the loader says, and what to install."""
    monkeypatch.setitem(sys.modules, "pygmsh", None)
    monkeypatch.setattr(doctor, "renders", lambda: None)
    name, state, reason = next(part for part in doctor.examine() if part[0] == "mesh generator")
    assert state == "fails" and DEBIAN_PACKAGES in reason
