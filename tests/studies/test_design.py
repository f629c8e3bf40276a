"""Figures of a table made by hand."""

import numpy as np
import pytest
import xarray as xr
from common.design import table_row

from sits_mech.scene.sensor import load_sensor


def table(slope_x: float = 1.0, slope_z: float = -2.0, leak: float = 0.0) -> xr.Dataset:
    """Return a calibration whose signals are linear in the forces [% of L0], in henry."""
    F_x, F_z = np.linspace(-1.0, 1.0, 5), np.linspace(0.0, 4.0, 5)
    x, z = np.meshgrid(F_x, F_z, indexing="ij")
    L_h, L_v = slope_x * x, 200.0 + slope_z * z + leak * x
    L0, L = np.eye(2) * 2.5e-6, np.zeros((5, 5, 2, 2))
    L[..., 0, 0], L[..., 1, 1] = (L_v + L_h) * 1.25e-8, (L_v - L_h) * 1.25e-8
    dims = ("F_x", "F_z")
    flat = {"d_v": 2e-3 - 1e-4 * z, "min_J": 1.0 - 0.01 * z, "seconds": np.full((5, 5), 0.1)}
    flat |= {"L_v_percent": L_v, "L_h_percent": L_h, "status": np.full((5, 5), "ok", dtype=object)}
    flat |= {"error_L_v_percent": np.full((5, 5), 0.02), "error_L_h_percent": np.full((5, 5), 0.01)}
    coordinates = {"F_x": F_x, "F_z": F_z, "coil": ["C1", "C2"]}
    data = xr.Dataset({name: (dims, item) for name, item in flat.items()}, coordinates)
    for name, item in (("L", L), ("error_L", 1e-4 * L), ("R", 1e4 * np.abs(L)), ("error_R", 0.0 * L)):
        data[name] = ((*dims, "coil", "coil_2"), item)
    data["L0"] = (("coil", "coil_2"), L0)
    return data.assign_attrs(unit_L="H", frequency=5e6)


@pytest.mark.slow
def test_figures_of_a_linear_sensor() -> None:
    """Ranges and crosstalk by hand; resolution is the noise over the slope, alike in all loads."""
    row = table_row(load_sensor("biorob2018"), table(leak=0.4))
    assert row["L_v_range"] == pytest.approx(8.8) and row["L_h_range"] == pytest.approx(2.0)
    assert row["crosstalk_v"] == pytest.approx(100 * 0.4 / 8.0) and row["crosstalk_h"] == pytest.approx(0.0, abs=1e-9)
    assert row["error"] == pytest.approx(0.01 / 2.0) and row["least_gap"] == pytest.approx(1.6e-3)
    finer = table_row(load_sensor("biorob2018"), table(slope_x=2.0))
    coarse = table_row(load_sensor("biorob2018"), table(slope_x=1.0))
    assert coarse["resolution_x"] / finer["resolution_x"] == pytest.approx(2.0, rel=0.05)
    assert coarse["resolution_z"] == pytest.approx(finer["resolution_z"], rel=0.05)


def test_a_load_that_failed_leaves_no_figures() -> None:
    """They are NaN, not those of the other loads."""
    data = table()
    data["status"][4, 4] = "failed"
    row = table_row(load_sensor("biorob2018"), data)
    assert row["failed_loads"] == 1 and np.isnan(row["resolution_x"])
