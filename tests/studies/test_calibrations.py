"""References of calibrations: the error of a refinement, the stored file."""

import numpy as np
import pytest
import xarray as xr
from benchmarks.reference_calibrations import left_by
from common.calibrations import CALIBRATIONS, FX, FZ, SIGNALS, errors, reference, table


def test_the_error_is_what_a_geometric_series_leaves() -> None:
    """Exact for 1 + r^k with r above a quarter; below it the quarter stands; without an order the own estimate."""
    for ratio in (0.5, 0.3):
        rungs = [np.array([1.0 + ratio**k]) for k in range(3)]
        assert left_by(*rungs, 9.0)[0] == pytest.approx(ratio**2)  # of the last rung from the limit, 1
    rungs = [np.array([1.0 + 0.1**k]) for k in range(3)]
    assert left_by(*rungs, 9.0)[0] == pytest.approx(0.09 / 3.0) and 0.09 / 3.0 > 0.1**2
    assert left_by(np.array([1.0]), np.array([2.0]), np.array([2.9]), 9.0)[0] == 9.0
    assert left_by(np.array([1.0]), np.array([1.0]), np.array([1.0]), 9.0)[0] == 9.0


def test_stored_signals_are_those_of_the_cases() -> None:
    """A value for each load, mirror images of each other: shear the other way swaps the coils."""
    for case in CALIBRATIONS:
        for signal, sign in zip(SIGNALS, (1.0, -1.0), strict=True):
            known, error = reference(case, signal)
            assert known.shape == (len(FX), len(FZ)) and 0.0 < error < 1e-2
            assert known[::-1] == pytest.approx(sign * known, abs=error * float(np.ptp(known)))


@pytest.mark.slow
def test_stored_signals_are_those_of_today() -> None:
    """A coarse table is as far from them as it says: they are made anew when what is modelled changes."""
    for case in CALIBRATIONS:
        data = table(case, 3e-2)
        for signal in SIGNALS:
            known, error = reference(case, signal)
            true, estimated = errors(data, signal, known)
            assert true < estimated + error


def test_errors_are_of_full_scale() -> None:
    """The largest over the loads."""
    known = np.array([[0.0, 1.0], [2.0, 4.0]])
    data = xr.Dataset({"L_v_percent": (("x", "y"), known + [[0.0, -0.4], [0.0, 0.2]])})
    data["error_L_v_percent"] = (("x", "y"), np.full((2, 2), 0.8))
    assert errors(data, "L_v", known) == pytest.approx((0.1, 0.2))
