"""Explain a reading that belongs to no load of a calibration: a coil that is off, or another kind of load.

With more coils than forces a reading L has a part that no force of the table explains,

    r = P W (L - L(F)),    P = 1 - Q Q^T,    W dL/dF = Q R at the nearest load F, W the coils' weights.

A component of the load that the table does not vary is a cause where its own slopes, P W s, point along r and its size
is one that the sensor may meet; a coil is one where the others, without it, belong to a load of the table. Several
causes that explain it cannot be resolved: with one coil more than forces r has one direction only. Slopes s are those
at rest (`wrenches`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from sits_mech.analysis.wrenches import table_slopes
from sits_mech.quantities import WRENCH, Array, SolveFailed, shown_unit
from sits_mech.readout.calibration import OK, OUTSIDE, Calibration, without_coil
from sits_mech.readout.inversion import INCONSISTENT
from sits_mech.readout.loads import varied
from sits_mech.scene.sensor import Sensor

_ALONG = 0.97  # cosine of the angle between the residual and what a component makes of the coils
_SEEN = 0.03  # of a component's slopes: what is smaller lies in the table's own directions
_LESS = 0.25  # of the residual: what may remain without a coil that is off
_MOST = 2.0  # times the largest load of the table: beyond it a component is no cause


def component_slopes(sensor: Sensor, data: xr.Dataset) -> tuple[tuple[str, ...], Array, Array]:
    """Return the components that a table does not vary, slopes of L over L0 by them at rest, and their usual sizes.

    Names (p), slopes (n, p) [1/N, 1/(N m)], sizes (p) [N, N m]: `_MOST` times the table's largest force, and half
    the target's side times this. Empty where the models in space cannot hold the scene.
    """
    others = tuple(name for name in WRENCH if name not in varied(data))
    try:
        slopes = table_slopes(sensor, data)
    except (ValueError, KeyError, SolveFailed):
        return (), np.zeros((len(sensor.coils), 0)), np.zeros(0)
    largest = max((float(np.abs(data[name]).max()) for name in varied(data) if name.startswith("F")), default=1.0)
    lever = 1.0 if sensor.target is None else 0.5 * max(sensor.target.extent)
    sizes = [_MOST * largest * (1.0 if name.startswith("F") else lever) for name in others]
    return others, slopes[:, [WRENCH.index(name) for name in others]], np.array(sizes)


def suspicion(cal: Calibration, reading: Array, others: tuple[Sequence[str], Array, Array]) -> str:
    """Explain in words a reading (n,) that belongs to no load; empty where nothing can be known.

    `others` are components that the table does not vary: names (p), slopes of the reading (n, p) [unit/N], sizes (p).
    """
    if len(cal.coils) == len(cal.forces) or not np.all(np.isfinite(reading)):
        return ""
    near = cal.inverse(reading)
    if near.status == OUTSIDE and near.residual <= INCONSISTENT:
        return ""
    loads, coils = _components(cal, reading, others), _coils(cal, reading, float(near.residual))
    off = f"coils contradict each other by {100.0 * float(near.residual):.2g} % of the range"
    causes = [*loads, *coils]
    if not causes and near.status == OUTSIDE:
        return ""
    if not causes:
        return f"{off}: neither one coil alone nor another component of the load explains it"
    if not coils:
        return f"{off}: the residual points along {' or '.join(loads)}"
    if len(causes) == 1:
        return f"{off}: {coils[0]} alone is off, the other coils fit a load of the table"
    return f"{off}: {', '.join(causes[:-1])} or {causes[-1]} would explain it"


def _components(cal: Calibration, reading: Array, others: tuple[Sequence[str], Array, Array]) -> list[str]:
    """Return the components of a load that explain a reading, each with its size."""
    near = cal.map.unscaled(cal.search.solved(reading[None], np.zeros((3, len(reading))))[0][0])
    rest = _off_table(cal, cal.rest)  # where the slopes of the others are known
    here, found = _off_table(cal, near), []
    r = here @ ((reading - cal.map.at(near)) * cal.weights)
    for name, slopes, most in zip(others[0], np.transpose(others[1]), others[2], strict=True):
        s = slopes * cal.weights
        along, least = here @ s, _SEEN * np.linalg.norm(s)
        size = float(along @ r / max(float(along @ along), 1e-300))
        cosine = abs(along @ r) / max(float(np.linalg.norm(along) * np.linalg.norm(r)), 1e-300)
        seen = min(float(np.linalg.norm(along)), float(np.linalg.norm(rest @ s))) > least
        if seen and cosine > _ALONG and abs(size) <= most:
            found.append(f"{name} (about {size:.2g} {shown_unit(name)})")
    return found


def _off_table(cal: Calibration, forces: Array) -> Array:
    """Return the projection (n, n) of weighted readings onto what the table's forces do not change."""
    Q = np.linalg.qr(cal.map.slopes(forces) * cal.weights[:, None])[0]
    return np.asarray(np.eye(len(Q)) - Q @ Q.T)


def _coils(cal: Calibration, reading: Array, residual: float) -> list[str]:
    """Return the coils without which the others belong to a load of the table, each with its deviation."""
    found = []
    for k, name in enumerate(cal.coils):
        others = np.delete(reading, k)
        part = without_coil(cal, k)
        answer = part.inverse(others) if not part.unresolved else None
        if answer is not None and answer.status == OK and answer.residual <= _LESS * residual:
            off = 100.0 * (reading[k] / cal.map.at(answer.forces)[k] - 1.0)
            found.append(f"coil {name} ({off:+.2g} %)")
    return found
