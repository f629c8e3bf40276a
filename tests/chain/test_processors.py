"""Does a calibration depend on the processor? The linear algebra of others, as far as this one can run it."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

FLAGS = {"HASWELL": "avx2", "ZEN": "avx2", "SKYLAKEX": "avx512f"}  # what each core type of OpenBLAS needs


def core_types() -> list[str]:
    """Return the core types that this processor can run."""
    described = Path("/proc/cpuinfo")
    known = set(described.read_text().split()) if described.exists() else set()
    return [name for name, flag in FLAGS.items() if flag in known]


def calibrated(core_type: str, folder: Path) -> xr.Dataset:
    """Return the default calibration as a core type finds it."""
    words = [sys.executable, "-m", "sits_mech", "calibrate", "biorob2018-w15", "--accept", "-o", str(folder)]
    environment = os.environ | {"OPENBLAS_CORETYPE": core_type, "OPENBLAS_NUM_THREADS": "1"}
    subprocess.run(words, env=environment, check=True, capture_output=True, timeout=600)
    return xr.load_dataset(folder / "result.nc")


@pytest.mark.slow
@pytest.mark.skipif(len(core_types()) < 2, reason="one kind of linear algebra only")
def test_the_default_calibration_is_the_same_on_every_processor(tmp_path: Path) -> None:
    """To a thousandth of its own stated error, and the errors to a thousandth as well; zero by symmetry to rounding."""
    first, *others = (calibrated(name, tmp_path / name) for name in core_types())
    for other in others:
        for name in ("d_h", "d_v", "alpha", "L", "R", "L_v", "L_h"):
            error = first[f"error_{name}"].to_numpy()
            rounding = 1e-9 * np.abs(first[name].to_numpy()).max()
            assert np.all(np.abs(other[name] - first[name]) <= 1e-3 * error + rounding)
            np.testing.assert_allclose(other[f"error_{name}"], error, rtol=1e-3, atol=rounding)
