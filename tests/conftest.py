"""What all tests share: one BLAS thread, no display, and a hypothesis profile that is the same in every run."""

import os
from pathlib import Path

import pytest

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")

from hypothesis import settings  # noqa: E402

settings.register_profile("same", derandomize=True, deadline=None, database=None)
settings.load_profile("same")


@pytest.fixture(scope="session")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a small calibration of biorob2018-w15, as the command leaves it: 5 shears, 4 normal forces."""
    from sits_mech.cli import run

    folder = tmp_path_factory.mktemp("calibrated") / "made"
    loads = ("--fx", "-1 N:1 N:5", "--fz", "0 N:3 N:4", "--mechanics", "planar")
    assert run(["calibrate", "biorob2018-w15", *loads, "--magnetics", "planar", "-o", str(folder)]) == 0
    return folder
