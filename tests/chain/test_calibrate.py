"""Tables over any components of a load: against single loads, mirror images, and by models known by hand."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.cases import read_table, save_table
from sits_mech.chain import models
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.simulate import simulate
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.readout.calibration import calibration
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

GRID = {"F_x": [-0.3, 0.3], "F_z": [0.5, 1.0], "F_y": [-0.2, 0.0, 0.2]}
SLOPES = np.array([4e-4, -1e-4, 1.0, 4e-4, 1.0, 1.0])  # of the pose by the load
REST = np.array([0.0, 2e-3, 0.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Springs:
    """Six springs, one for each component; errors of a thousandth."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose in closed form."""
        moved, report = SLOPES * wrench.components, SolveReport("springs", 6, 1, 0.0, 1e-3, 0.0, min_J=0.9)
        return Equilibrium(wrench, Pose.of(REST + moved), Pose.of(np.abs(moved) / 1000), np.zeros(1), report)


@dataclass(frozen=True)
class Linear:
    """L1, L2 = 1 + 100 d_v + alpha_x +- (20 d_h + d_y + alpha_z)."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        d_h, d_v, _, d_y, alpha_x, alpha_z = np.moveaxis(pose.components, -1, 0)
        common, odd = 1.0 + 100.0 * d_v + alpha_x, 20.0 * d_h + d_y + alpha_z
        zero = np.zeros_like(common)
        L = np.stack([np.stack([common + odd, zero], -1), np.stack([zero, common - odd], -1)], -2)
        error, report = np.full(L.shape, 1e-6), SolveReport("linear", 1, 1, 0.0, 1e-6, 0.0)
        return Impedance(frequency, L, np.zeros_like(L), 2.0 * np.eye(2), np.ones(2), error, error, "H", report)


@pytest.fixture
def fakes(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Put the models by hand behind the names."""
    monkeypatch.setattr(models, "MECHANICS", dict.fromkeys(("planar", "block"), lambda *_: Springs()))
    monkeypatch.setattr(models, "MAGNETICS", dict.fromkeys(("planar", "sheets"), lambda *_: Linear()))
    yield


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def table(sensor: Sensor) -> xr.Dataset:
    """The real chain on a small grid that leaves the plane."""
    return calibrate(sensor, **GRID, tolerance=5e-2)


@pytest.mark.parametrize("load", [(0.3, 1.0, 0.2), (-0.3, 0.5, -0.2), (0.3, 0.5, 0.0)])
def test_a_table_holds_what_single_loads_show(sensor: Sensor, table: xr.Dataset, load: tuple[float, ...]) -> None:
    """The same models: to a hundredth of the stated errors, mirror images and loads in the plane included."""
    F_x, F_z, F_y = load
    single, row = simulate(sensor, Wrench(F_x, F_z, F_y=F_y), tolerance=5e-2), table.sel(F_x=F_x, F_z=F_z, F_y=F_y)
    for name in POSE:
        found, error = float(getattr(single.equilibrium.pose, name)), float(row[f"error_{name}"])
        assert abs(float(row[name]) - found) <= 1e-2 * error + 1e-15
    for name in ("L", "R"):
        off = np.abs(row[name].to_numpy() - getattr(single.impedance, name))
        assert np.all(off <= 1e-2 * row[f"error_{name}"].to_numpy())
    assert float(row["L_h"]) == pytest.approx(float(single.signals.L_h), abs=1e-2 * float(row["error_L_h"]))


def test_both_mirrors_hold(table: xr.Dataset) -> None:
    """Shear along -y shows the same and moves the other way; along -x it swaps the coils; without it, straight."""
    assert np.all(table["status"] == "converged")
    L = table["L"].transpose("F_x", "F_z", "F_y", "coil", "coil_2").to_numpy()
    np.testing.assert_allclose(L[:, :, ::-1], L, rtol=1e-9)
    np.testing.assert_allclose(L[::-1, ..., ::-1, ::-1], L, rtol=1e-9)
    for name, in_x, in_y in zip(POSE, (-1, 1, -1, 1, 1, -1), (1, 1, 1, -1, -1, -1), strict=True):
        values = table[name].transpose("F_x", "F_z", "F_y").to_numpy()
        np.testing.assert_array_equal(values[::-1], in_x * values)
        np.testing.assert_array_equal(values[:, :, ::-1], in_y * values)
    assert np.all(table["d_y"].sel(F_y=0.2) > 0.0) and np.all(table["error_d_y"].sel(F_y=0.0) == 0.0)


def test_a_table_beside_the_plane_comes_back_from_its_file(table: xr.Dataset, tmp_path: Path) -> None:
    """netCDF holds every dimension and variable."""
    save_table(table, tmp_path / "result.nc")
    assert read_table(tmp_path / "result.nc").identical(table)


@pytest.mark.usefixtures("fakes")
def test_every_component_at_its_place(sensor: Sensor, tmp_path: Path) -> None:
    """Sequences are dimensions in the order of a wrench, numbers coordinates where they are not zero."""
    data = calibrate(sensor, F_z=[1.0, 0.0], M_z=[2e-3], F_x=[-0.3, 0.3], F_y=[-0.2, 0.2], M=1e-3, M_x=0.0)
    assert data["status"].dims == ("F_x", "F_z", "F_y", "M_z") and data["L"].dims[-2:] == ("coil", "coil_2")
    assert float(data["M"]) == 1e-3 and data["M"].dims == () and "M_x" not in data.coords
    for F_x, F_z, F_y in itertools.product(*(data[name].to_numpy() for name in ("F_x", "F_z", "F_y"))):
        row = data.sel(F_x=F_x, F_z=F_z, F_y=F_y, M_z=2e-3)
        pose: Array = REST + SLOPES * [F_x, F_z, 1e-3, F_y, 0.0, 2e-3]
        np.testing.assert_allclose([float(row[name]) for name in POSE], pose, rtol=1e-14, atol=0.0)
        odd = 20.0 * pose[0] + pose[3] + pose[5]
        assert float(row["L"].sel(coil="C1", coil_2="C1")) == pytest.approx(1.0 + 100.0 * pose[1] + odd, rel=1e-14)
    save_table(data, tmp_path / "result.nc")
    assert read_table(tmp_path / "result.nc").identical(data)
    cal = calibration(data)
    assert cal.forces == ("F_x", "F_z", "F_y")


@pytest.mark.usefixtures("fakes")
def test_a_table_in_the_plane_knows_nothing_beside_it(sensor: Sensor) -> None:
    """Neither dimensions nor variables, with a moment in the plane either; one number of F_x is a dimension as well."""
    data = calibrate(sensor, F_x=0.1, F_z=[0.0, 1.0], M=[-1e-3, 1e-3])
    assert data["status"].dims == ("F_x", "F_z", "M") and dict(data.sizes)["F_x"] == 1
    assert not {*POSE[3:], *(f"error_{name}" for name in POSE[3:]), *WRENCH[3:]} & set(data.variables)


def test_what_cannot_leave_the_plane_is_refused_by_name(sensor: Sensor) -> None:
    """The model that can is named; values that are none likewise, with their unit."""
    with pytest.raises(SceneError, match="must be auto or block for F_y, M_z; got planar"):
        calibrate(sensor, F_x=[0.0], F_z=[1.0], F_y=[0.0, 0.1], M_z=1e-3, mechanics="planar")
    with pytest.raises(SceneError, match="must be auto or sheets for F_y; got planar"):
        calibrate(sensor, F_x=[0.0], F_z=[1.0], F_y=0.1, magnetics="planar")
    with pytest.raises(SceneError, match=r"M_x must be one or more different finite moments \[N m\]"):
        calibrate(sensor, F_x=[0.0], F_z=[1.0], M_x=[1e-3, 1e-3])
