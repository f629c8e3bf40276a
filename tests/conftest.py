"""What all tests share: one BLAS thread, no display, and a hypothesis profile that is the same in every run."""

import gc
import os
from collections.abc import Generator
from functools import cache
from pathlib import Path

import pytest

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ["SITS_MECH_CACHE"] = "off"
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")


@cache
def _same_in_every_run() -> None:
    """Load the profile; hypothesis takes seconds to come."""
    from hypothesis import settings

    settings.register_profile("same", derandomize=True, deadline=None, database=None)
    settings.load_profile("same")


def pytest_collectstart() -> None:
    """Load it before any test is imported, in the processes that import tests: the one that deals them out does not."""
    _same_in_every_run()


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Search for no garbage among what is collected, then or later: tests and modules stay to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(scope="session")
def three_forces(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a calibration over F_x, F_z, F_y under a moment, made of the small one: L_v grows with F_y^2."""
    import numpy as np

    from sits_mech.readout.loads import over_loads
    from sits_mech.report.folder import read_calibration
    from sits_mech.report.written import write_calibration

    sensor, data = read_calibration(calibrated)
    data = data.drop_dims(["part", "cause"])  # a table that tells no parts of its errors
    F_y = np.array([-0.4, 0.0, 0.4])
    each = {name: data[name].expand_dims({"F_y": F_y}, data[name].get_axis_num("F_z") + 1) for name in over_loads(data)}
    wide = data.drop_vars(list(each)).assign(each).assign_coords(M=1e-3)
    wide["L_v_percent"] = wide["L_v_percent"] + wide["F_y"] ** 2
    for name, slope in (("d_y", 1e-4), ("alpha_x", -1e-2), ("alpha_z", 1e-3)):
        wide[name] = slope * wide["F_y"] + 0.0 * wide["d_v"]
        wide[f"error_{name}"] = wide["error_d_h"]
    folder = tmp_path_factory.mktemp("three") / "made"
    (folder / "cases").mkdir(parents=True)
    write_calibration(sensor, wide.transpose("F_x", "F_z", "F_y", "coil", "coil_2"), folder)
    return folder


@pytest.fixture(scope="session")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a small calibration of biorob2018-w15, as the command leaves it: 5 shears, 4 normal forces."""
    from sits_mech.cli.main import run

    folder = tmp_path_factory.mktemp("calibrated") / "made"
    loads = ("--fx", "-1 N:1 N:5", "--fz", "0 N:3 N:4", "--mechanics", "planar")
    assert run(["calibrate", "biorob2018-w15", *loads, "--magnetics", "planar", "-o", str(folder)]) == 0
    return folder
