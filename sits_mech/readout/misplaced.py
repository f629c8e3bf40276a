"""Find what forces are read wrong by where the place of a touch is not known.

A reader takes the touch to be at p_0 and reads the forces f, weighted least squares over the coils, from inductances
that the touch at p shows:

    f' = argmin sum_c w_c^2 (L_c(f', p_0) - L_c(f, p))^2,      error = max |f' - f|   over f and |p - p_0| <= d,

each axis of p for itself within d, over loads and places of the table. To first order in p it is the place's own column
of the Jacobian, read as forces. Gauss-Newton from f; numbers only.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sits_mech.quantities import TOUCH, tensor_grid
from sits_mech.readout.calibration import Calibration
from sits_mech.units import SLACK

_LOADS, _PLACES = 9, 9  # values of each force, and of each axis of the place, an odd number
_STEPS = 12  # of Gauss-Newton


def misplaced(cal: Calibration, place: Mapping[str, float], within: float) -> dict[str, float]:
    """Return the largest error of each force where a touch at `place` by axis is unknown `within` a distance [m].

    Raise ValueError where the table has no places, none that far away, or too few coils for its forces.
    """
    axes = [name for name in cal.forces if name in TOUCH]
    forces = [k for k, name in enumerate(cal.forces) if name not in TOUCH]
    if not axes or len(forces) > len(cal.coils):
        what = f"a table over places of a touch, of at most {len(cal.coils)} forces besides"
        raise ValueError(f"within: must be asked of {what}; got {', '.join(cal.forces)}")
    _check_within(cal, axes, place, within)
    at = np.array([place.get(name, 0.0) for name in cal.forces])
    reach = np.where([name in TOUCH for name in cal.forces], within, 0.0)
    each = [
        np.linspace(p - d, p + d, _PLACES) if d else np.linspace(low, high, _LOADS)
        for p, d, low, high in zip(at, reach, cal.low, cal.high, strict=True)
    ]
    points = tensor_grid(*each).reshape(-1, len(at))
    read = np.where(reach > 0.0, at, points)
    shown = cal.map.at(points)
    ends = 1.5 * cal.low - 0.5 * cal.high, 1.5 * cal.high - 0.5 * cal.low  # half a table's range beyond it
    for _ in range(_STEPS):
        J = cal.map.slopes(read)[:, :, forces] * cal.weights[:, None]
        step = np.einsum("mkn,mn->mk", np.linalg.pinv(J), (shown - cal.map.at(read)) * cal.weights)
        read[:, forces] = np.clip(read[:, forces] + step, ends[0][forces], ends[1][forces])
    off = np.abs(read - points)[:, forces].max(axis=0)
    return {cal.forces[k]: float(value) for k, value in zip(forces, off, strict=True)}


def _check_within(cal: Calibration, axes: list[str], place: Mapping[str, float], within: float) -> None:
    """Refuse a distance that leads out of the table."""
    for name in axes:
        k = cal.forces.index(name)
        most = min(cal.high[k] - place[name], place[name] - cal.low[k])
        if not 0.0 < within <= most * (1.0 + SLACK):
            why = f"as {name} goes from {cal.low[k]:.4g} to {cal.high[k]:.4g} m"
            raise ValueError(f"within: must be above 0 and up to {most:.4g} m, {why}; got {within:.4g} m")
