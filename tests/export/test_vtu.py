"""The series for ParaView: read back by meshio, the layer as it was solved."""

import json
import re
from pathlib import Path

import meshio
import numpy as np
import pytest

from sits_mech.export.formats import export
from sits_mech.export.source import Source
from sits_mech.report.folder import read_calibration


def test_series(calibrated: Path, tmp_path: Path) -> None:
    """One file for each converged load, in order; target and layer move together where they are bonded; tracks stay."""
    sensor, data = read_calibration(calibrated)
    data = data.isel(F_x=[2, 4], F_z=[0, 2, 3]).copy(deep=True)
    data["status"][0, 2] = "stalled"
    path, notes = export(Source(sensor, data), "vtu", tmp_path / "layer.pvd")
    listed = re.findall(r'timestep="(\d+)".*file="(.*)"', path.read_text())
    assert listed == [(str(k), f"layer_{k:04d}.vtu") for k in range(5)] and notes == ()
    for (_, file), (x, z) in zip(listed, [(0, 0), (0, 1), (1, 0), (1, 1), (1, 2)], strict=True):
        mesh = meshio.read(tmp_path / file)
        part, quads = mesh.cell_data["part"][0], mesh.cells[0].data
        moved = mesh.point_data["displacement"]
        plate = mesh.points[quads[part == 1].ravel()]
        row = data.isel(F_x=x, F_z=z)
        bottom = plate[[0, 1]].mean(axis=0)
        np.testing.assert_allclose(bottom[[0, 2]], [float(row["d_h"]), float(row["d_v"])], atol=2e-7)
        rest = mesh.points - moved
        bonded = (np.abs(rest[:, 2] - 2e-3) < 1e-9) & (np.abs(rest[:, 0]) <= 7.5e-3 * (1 + 1e-9))
        top = rest[bonded]
        turn = float(row["alpha"])
        expected = np.column_stack([top[:, 0] * np.cos(turn), -top[:, 0] * np.sin(turn)]) + bottom[[0, 2]]
        np.testing.assert_allclose(mesh.points[bonded][:, [0, 2]], expected, atol=1e-6)
        assert np.all(moved[quads[part == 2].ravel()] == 0.0) and np.count_nonzero(part == 2) == 96
        assert mesh.cell_data["J"][0].min() == pytest.approx(min(1.0, float(row["min_J"])), rel=1e-3)
        assert np.all(mesh.points[:, 1] == 0.0)


def test_a_vtu_of_its_own(calibrated: Path, tmp_path: Path) -> None:
    """The last load stands in the file that was named, the list beside it."""
    sensor, data = read_calibration(calibrated)
    path, notes = export(Source(sensor, data.isel(F_x=[2], F_z=[0, 1])), "vtu", tmp_path / "layer.vtu")
    assert path.read_bytes() == (tmp_path / "layer_0001.vtu").read_bytes() and "holds the last load" in notes[0]
    assert "layer_0000.vtu" in (tmp_path / "layer.pvd").read_text()


def test_section_of_a_solid(calibrated: Path, tmp_path: Path) -> None:
    """A calibration by the 3D pad is shown by it: the section through its middle, the bonded face with the target."""
    sensor, data = read_calibration(calibrated)
    request = json.loads(data.attrs["request"]) | {"mechanics": "block", "tolerance": 0.05}
    data = data.isel(F_x=[2], F_z=[0, 2]).assign_attrs(request=json.dumps(request))
    _, notes = export(Source(sensor, data), "vtu", tmp_path / "pad.pvd")
    rest, loaded = (meshio.read(tmp_path / f"pad_000{k}.vtu") for k in range(2))
    assert notes == () and np.abs(rest.point_data["displacement"]).max() < 1e-9
    part, quads, moved = loaded.cell_data["part"][0], loaded.cells[0].data, loaded.point_data["displacement"]
    before = loaded.points - moved
    layer = np.unique(quads[part == 0])
    assert before[layer, 0].min() == pytest.approx(-10e-3) and before[layer, 2].max() == pytest.approx(2e-3)
    sunk = moved[quads[part == 1].ravel(), 2].mean()
    bonded = layer[(np.abs(before[layer, 2] - 2e-3) < 1e-9) & (np.abs(before[layer, 0]) < 7.4e-3)]
    assert sunk < -1e-5 and len(bonded) >= 5
    np.testing.assert_allclose(moved[bonded, 2], moved[bonded[0], 2], rtol=1e-9)
    assert moved[bonded[0], 2] == pytest.approx(sunk, rel=0.05)  # the pose is extrapolated from two meshes, to 5 %
