"""Find how a readout drifts as the sensor gets warmer: drift of zero and of gain, and the share of each cause.

Readings L(F) of a calibration change by s_c(F) = dL/dT_c with the temperature, by some causes c. At a load F that is
held, an inverse F(L) that knows nothing of it then answers

    dF_c/dT = dF/dL s_c(F),

which along one component, the others nearest to none, is given as a line through its values at the loads of the table,
by least squares with the load nearest to none held:

    drift of zero   its value there [N/K],
    drift of gain   its slope by the component [1/K], a share of what is read.

Both are sums over the causes. Numbers only: slopes that were measured go the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from sits_mech.quantities import Array
from sits_mech.readout.calibration import Calibration, check_resolved
from sits_mech.readout.inversion import OK

_ROUNDING = 1e-12  # of the range of a component per kelvin: what symmetry forbids


@dataclass(frozen=True)
class Drift:
    """Drift of a readout with temperature: d components of a load, c causes."""

    forces: tuple[str, ...]
    causes: tuple[str, ...]
    zero: Array  # (d, c) at the load nearest to none [N/K, N m/K]
    gain: Array  # (d, c) of each component [1/K]; NaN where it has one value alone


def drift(cal: Calibration, slopes: xr.DataArray) -> Drift:
    """Return the drift of zero and gain of a calibration's inverse.

    `slopes`, dims (*forces, thermal_cause, coil), are of the readings [unit of the calibration per K], NaN where a load
    has none. ValueError when the components are not resolved, or the load nearest to none has no slopes or no inverse.
    """
    check_resolved(cal)
    axes = [slopes[name].to_numpy() for name in cal.forces]
    values = slopes.transpose(*cal.forces, "thermal_cause", "coil").to_numpy()
    centre = tuple(int(np.argmin(np.abs(axis))) for axis in axes)
    zero = _answers(cal, axes, values, [centre])[0]
    if not np.all(np.isfinite(zero)):
        raise ValueError("drift: the load nearest to none must have slopes and an inverse; it has none")
    gain = np.full(zero.shape, np.nan)
    for k, axis in enumerate(axes):
        if len(axis) < 2:
            continue
        line = [(*centre[:k], i, *centre[k + 1 :]) for i in range(len(axis))]
        own, away = _answers(cal, axes, values, line)[:, k] - zero[k], axis - axis[centre[k]]
        good = np.isfinite(own).all(axis=1)
        gain[k] = away[good] @ own[good] / max(float(away[good] @ away[good]), 1e-300)
    size = np.array([np.ptp(axis) or 1.0 for axis in axes])[:, None]
    zero = np.where(np.abs(zero) > _ROUNDING * size, zero, 0.0)
    return Drift(cal.forces, tuple(str(name) for name in slopes["thermal_cause"].to_numpy()), zero, gain)


def _answers(cal: Calibration, axes: list[Array], values: Array, places: list[tuple[int, ...]]) -> Array:
    """Return the forces read by each cause, shape (p, d, c) [N/K]; NaN where there is no inverse."""
    loads = np.array([[axis[i] for axis, i in zip(axes, place, strict=True)] for place in places])
    own = np.array([values[place] for place in places])  # (p, c, n)
    found = np.einsum("pdn,pcn->pdc", cal.answers(loads), own)
    found[cal.inverse(cal.forward(loads)).status != OK] = np.nan
    return np.asarray(found)
