"""The series for ParaView: read back by meshio, the layer as it was solved."""

import re
from pathlib import Path

import meshio
import numpy as np

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
        assert 0.9 < mesh.cell_data["J"][0].min() <= 1.0 and np.all(mesh.points[:, 1] == 0.0)
