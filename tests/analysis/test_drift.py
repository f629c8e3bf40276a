"""Drift of zero and gain of sensors whose drift is known by hand."""

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.drift import drift
from sits_mech.readout.calibration import Calibration, calibration_of

A = np.array([[2e-8, -3e-9], [-2e-8, -3e-9]])  # dL/d(F_x, F_z) [H/N]
X, Z = np.linspace(-1, 1, 7), np.linspace(0, 4, 7)


def made() -> tuple[Calibration, np.ndarray]:
    """L = 2 uH + A F."""
    F = np.stack(np.meshgrid(X, Z, indexing="ij"), -1)
    L = 2e-6 + F.reshape(-1, 2) @ A.T
    return calibration_of(F.reshape(-1, 2), L, forces=("F_x", "F_z"), coils=("C1", "C2"), free=("H", [2e-6] * 2)), F


def slopes(F: np.ndarray, **causes: tuple[list[float], list[list[float]]]) -> xr.DataArray:
    """Slopes that are A (zero + gain F), by each cause."""
    parts = [A @ np.asarray(zero) + F @ (A @ np.asarray(gain)).T for zero, gain in causes.values()]
    places = {"F_x": X, "F_z": Z, "thermal_cause": list(causes), "coil": ["C1", "C2"]}
    return xr.DataArray(np.stack(parts, axis=2), places, dims=tuple(places))


def test_zero_and_gain_are_what_was_put_in() -> None:
    """A pad that lifts the target by 10 mN/K of F_z; a modulus that takes 0.3 % of all forces a kelvin."""
    cal, F = made()
    found = drift(cal, slopes(F, pad=([0.0, 0.01], [[0, 0], [0, 0]]), modulus=([0, 0], [[-3e-3, 0], [0, -3e-3]])))
    assert found.causes == ("pad", "modulus") and found.forces == ("F_x", "F_z")
    np.testing.assert_allclose(found.zero, [[0.0, 0.0], [0.01, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found.gain, [[0.0, -3e-3], [0.0, -3e-3]], atol=1e-9)


def test_loads_without_slopes_are_left_out_and_no_zero_is_refused() -> None:
    """A corner that failed counts in no figure; the load nearest to none must be there."""
    cal, F = made()
    own = slopes(F, pad=([0.0, 0.01], [[1e-3, 0], [0, 2e-3]]))
    own[3, -1] = np.nan
    np.testing.assert_allclose(drift(cal, own).gain[:, 0], [1e-3, 2e-3], atol=1e-9)
    own[3, 0] = np.nan
    with pytest.raises(ValueError, match="drift: the load nearest to none must have slopes"):
        drift(cal, own)
