"""The series for ParaView: read back by meshio, the layer as it was solved."""

import json
import re
from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr

from sits_mech.export.formats import export
from sits_mech.export.source import Source
from sits_mech.readout.loads import over_loads
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import Sensor


def test_series(calibrated: Path, tmp_path: Path) -> None:
    """A folder: one file for each converged load, in order; target and layer move together; tracks stay."""
    sensor, data = read_calibration(calibrated)
    data = data.isel(F_x=[2, 4], F_z=[0, 2, 3]).copy(deep=True)
    data["status"][0, 2] = "failed"
    path, notes = export(Source(sensor, data), "vtu", tmp_path / "layer")
    listed = re.findall(r'timestep="(\d+)".*file="(.*)"', (path / "layer.pvd").read_text())
    assert listed == [(str(k), f"load_{k:04d}.vtu") for k in range(5)] and notes == ()
    assert list(tmp_path.iterdir()) == [path] and len(list(path.iterdir())) == 6
    for (_, file), (x, z) in zip(listed, [(0, 0), (0, 1), (1, 0), (1, 1), (1, 2)], strict=True):
        mesh = meshio.read(path / file)
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


def test_the_folder(calibrated: Path, tmp_path: Path) -> None:
    """Written again it holds the new series alone; a file is no folder."""
    sensor, data = read_calibration(calibrated)
    path, _ = export(Source(sensor, data.isel(F_x=[2], F_z=[0, 1])), "vtu", tmp_path / "made" / "layer")
    (path / "notes.txt").write_text("kept")
    export(Source(sensor, data.isel(F_x=[2], F_z=[0])), "vtu", path)
    assert sorted(file.name for file in path.iterdir()) == ["layer.pvd", "load_0000.vtu", "notes.txt"]
    (tmp_path / "file").write_text("")
    for name in ("layer.pvd", "layer.vtu", "file"):
        with pytest.raises(ValueError, match=rf"--output: must name a folder for --to vtu; got '{name}'"):
            export(Source(sensor, data), "vtu", tmp_path / name)


def by_block(calibrated: Path, picked: dict[str, list[int]]) -> tuple[Sensor, xr.Dataset]:
    """A sensor and some loads of its table, as if the 3D pad had made it."""
    sensor, data = read_calibration(calibrated)
    request = json.loads(data.attrs["request"]) | {"mechanics": "block", "tolerance": 0.05}
    return sensor, data.isel(picked).assign_attrs(request=json.dumps(request))


def solid(file: Path) -> tuple[meshio.Mesh, np.ndarray, np.ndarray]:
    """A file of a pad in space, places of its nodes at rest, and which of them the target's lower face is bonded to."""
    mesh = meshio.read(file)
    rest = mesh.points - mesh.point_data["displacement"]
    pad = np.unique(mesh.cells_dict["hexahedron"])
    bonded = pad[(np.abs(rest[pad, 2] - 2e-3) < 1e-9) & np.all(np.abs(rest[pad, :2]) < [7.4e-3, 3.9e-3], axis=1)]
    return mesh, rest, bonded


def volume(points: np.ndarray, cells: np.ndarray) -> float:
    """Volume of hexahedra by five tetrahedra each, all of one sign [m^3]."""
    found = 0.0
    for a, b, c, d in ((0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (1, 4, 5, 6), (3, 4, 6, 7)):
        sides = [points[cells[:, k]] - points[cells[:, a]] for k in (b, c, d)]
        each = np.einsum("ij,ij->i", np.cross(sides[0], sides[1]), sides[2]) / 6.0
        assert np.all(each > 0.0)
        found += float(each.sum())
    return found


@pytest.mark.slow
def test_a_pad_in_space(calibrated: Path, tmp_path: Path) -> None:
    """A calibration by the 3D pad is shown whole: volume at rest, bonded face with the target, coils as rings."""
    sensor, data = by_block(calibrated, {"F_x": [2], "F_z": [0, 2]})
    path, notes = export(Source(sensor, data), "vtu", tmp_path / "pad")
    still, (mesh, rest, bonded) = solid(path / "load_0000.vtu")[0], solid(path / "load_0001.vtu")
    assert notes == () and np.abs(still.point_data["displacement"]).max() < 1e-9
    assert volume(rest, mesh.cells_dict["hexahedron"]) == pytest.approx(20e-3 * 20e-3 * 2e-3, rel=1e-9)
    J = mesh.cell_data_dict["J"]["hexahedron"]
    assert 0.5 < J.min() < J.max() < 1.1 and np.all(mesh.cell_data_dict["J"]["quad"] == 1.0)
    moved, part = mesh.point_data["displacement"], mesh.cell_data_dict["part"]["quad"]
    target, coils = (np.unique(mesh.cells_dict["quad"][part == k]) for k in (1, 2))
    sunk = moved[target, 2].mean()
    assert sunk < -1e-5 and len(bonded) >= 9 and np.all(moved[coils] == 0.0)
    np.testing.assert_allclose(moved[bonded, 2], moved[bonded[0], 2], rtol=1e-9)
    assert moved[bonded[0], 2] == pytest.approx(sunk, rel=0.05)  # the pose is extrapolated from two meshes, to 5 %
    reach = [np.abs(rest[coils, k]).max() for k in (0, 1)]
    outer = sensor.coils[0].outer_diameter / 2
    assert reach == pytest.approx([4e-3 + outer, outer], rel=1e-9)


@pytest.mark.slow
def test_loads_beside_the_plane(calibrated: Path, tmp_path: Path) -> None:
    """A shear along y: the target moves there and so does the bonded face, one rigid motion of both."""
    sensor, data = by_block(calibrated, {"F_x": [2], "F_z": [1]})
    each = {name: data[name].expand_dims({"F_y": [0.0, 0.3]}, 2) for name in over_loads(data)}
    path, notes = export(Source(sensor, data.drop_vars(list(each)).assign(each)), "vtu", tmp_path / "pad")
    assert notes == () and "F_y = 0.3 N" in (path / "pad.pvd").read_text()
    motions = []
    for k in range(2):
        mesh, rest, bonded = solid(path / f"load_{k:04d}.vtu")
        moved = mesh.point_data["displacement"]
        target = np.unique(mesh.cells_dict["quad"][mesh.cell_data_dict["part"]["quad"] == 1])
        for own in (bonded, target):  # to first order: d + w x r
            away = rest[own] - [0.0, 0.0, 2e-3]
            turns = [np.cross(np.eye(3)[axis], away) for axis in range(3)]
            system = np.concatenate([np.tile(np.eye(3), (len(own), 1, 1)), np.stack(turns, -1)], axis=-1)
            q = np.linalg.lstsq(system.reshape(-1, 6), moved[own].ravel(), rcond=None)[0]
            assert np.abs(system @ q - moved[own]).max() < 2e-6
            motions.append(q)
    assert np.abs(motions[0][[1, 3, 5]]).max() < 1e-9 and motions[2][1] > 1e-4 and abs(motions[2][3]) > 1e-3
    np.testing.assert_allclose(motions[2][[1, 3]], motions[3][[1, 3]], rtol=0.08)  # the pad is that of the second mesh
