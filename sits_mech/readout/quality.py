"""Find a sensor's figures: range, linearity, sensitivity, crosstalk, resolution, condition, hysteresis.

Of a calibration L(F) with the slopes dL/dF, over the loads where it has an inverse; F are any components of a load:

    full scale       least and greatest value of each component in the table
    linearity        largest distance of a component's own signal along it, the others nearest zero, from the best
                     straight line, over the signal's range there; of one without a signal of its own by geometry, the
                     sum of the inductances that a linear readout takes for it
    crosstalk        what a readout is wrong by: share of the full scale of each component that another one feigns, at
                     most, at its own; of a plane-fitted readout, F = A (L - mean L), and of the inverse at the loads
                     that were solved (of each component's own signal: see `crosstalk`)
    resolution       standard deviation of each component for the given noise of the inductances, by the slopes
    error by model   the most that the estimated errors of the loads' inductances allow, and those of the map; of errors
                     the signed parts that coils, and loads, have in common count with their signs (crosstalk.py)
    condition        of the slopes, components over full scale and inductances over the larger range: how much worse the
                     poorest direction is seen than the best one
    hysteresis       largest difference of a component between loading and unloading branches at one load, where both
                     are given

Where not all components are resolved there is no inverse: those that are not are named, figures of others stand.
Numbers only: measured tables go the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from sits_mech.quantities import Array, tensor_grid
from sits_mech.readout.budget import budget
from sits_mech.readout.calibration import OK, Calibration
from sits_mech.readout.crosstalk import FORCES, nearest_none, response, slope_doubt
from sits_mech.readout.observability import Observability, observability
from sits_mech.readout.table_errors import error_parts, table_errors

_FINE = {1: 33, 2: 33, 3: 17, 4: 9}  # loads along each component, by their number
SEEN = 1e-2
"""Of what the loads move together: sums of inductances that they move less are no signal of a linear readout."""
_READS = 1e-3  # of the largest possible weight: below it the coils share a coordinate, and no signal is along it


@dataclass(frozen=True)
class Quality:
    """Figures of a sensor; d components of a load ("forces"), n coils.

    Figures by the errors of the table's inductances (error_range, error_sensitivity, crosstalk_error, by_model) and
    crosstalk_after are NaN without a table. Crosstalk: row the force that is read, column the one that is applied at
    full scale; over the row's full scale.
    """

    forces: tuple[str, ...]
    coils: tuple[str, ...]
    full_scale: Array  # (d, 2) least and greatest [N, N m]
    signal_range: Array  # (n,) range of each inductance, over its free-space value [-]
    error_range: Array  # (n,) of it [-]
    linearity: Array  # (d,) of the signal that belongs to each force, over its range [-]
    sensitivity: Array  # (n, d) slopes at the least loads, over the free-space value [1/N, 1/(N m)]
    error_sensitivity: Array  # (n, d) of them, by differences of the table's loads [1/N, 1/(N m)]
    crosstalk: Array  # (d, d) of a linear readout [-]
    crosstalk_error: Array  # (d,) of it [-]
    crosstalk_after: Array  # (d, d) of the inverse [-]
    resolution: Array  # (d, 3) least, median, greatest deviation by noise, infinite where not resolved [N, N m]
    by_model: Array  # (d, 3) least, median, greatest error of each force [N, N m]
    by_map: Array  # (d,) greatest that the map's error allows; NaN where there is no inverse [N, N m]
    force_error: Array  # (d, 3) least, median, greatest half width that holds 90 % of readings (`budget`) [N, N m]
    condition: tuple[float, float]  # least and greatest; infinite where there are more forces than coils [-]
    seen: Observability  # which of the forces the coils resolve, in the middle of the table
    valid_share: float  # of the loads that have an inverse [-]
    no_inverse: tuple[str, ...]  # the others, named
    map_error: float  # over full scale of a coil [-]
    hysteresis: Array  # (d,) over the full scale of each force; NaN where no branches are given [-]


def quality(
    cal: Calibration, noise: ArrayLike, *, table: xr.Dataset | None = None,
    branches: tuple[ArrayLike, ArrayLike] | None = None,
) -> Quality:
    """Return the figures of a sensor; `noise` (n,) is the standard deviation of each inductance [unit].

    `table` has ``L`` and ``error_L`` over (*forces, coil), NaN where a load has none [unit]; ``weights`` (signal, coil)
    of the signals of F_z, F_x and F_y, as from `weights_of`; signed parts of the errors, ``shared_L`` (part, ...) and
    ``alone_L`` (cause, ...), where they are known. `branches` are inductances (m, n) at the same loads, loading and
    unloading [unit]. ValueError when the noise is not one positive number for each coil.
    """
    noise = np.asarray(noise, dtype=float)
    if noise.shape != (len(cal.coils),) or not np.all(noise > 0.0):
        raise ValueError(f"noise: must be {len(cal.coils)} positive numbers [{cal.unit}]; got {noise}")
    loads, span = _loads(cal), cal.high - cal.low
    flat, valid = loads.to_numpy().reshape(-1, len(span)), _valid(cal)
    inside = flat[cal.domain.holds(cal.map.scaled(flat), 0.0)]
    seen = observability(cal.forces, cal.map.slopes(cal.middle), noise, span)
    fine = np.tile(seen.resolution[:, None], 3)
    by_map = np.full(len(span), np.nan)
    if len(valid):
        fine = _spread(cal.force_noise(valid, noise))
        by_map = np.max(cal.force_error(valid, cal.map.error), axis=0)
    known = None if table is None else table_errors(table, cal.forces)
    whole = reading_errors(replace(cal, noise=noise, table_errors=cal.table_errors or known))
    sums = _linear_sums(cal, flat)
    sums[[name not in seen.resolved for name in cal.forces]] = np.nan  # what no coil answers has no readout
    read = loads.copy(data=((cal.map.at(flat) - cal.map.at(flat).mean(axis=0)) @ sums.T).reshape(loads.shape))
    after, by_model = _at_the_loads(cal, table)
    return Quality(
        cal.forces, cal.coils, np.stack([cal.low, cal.high], -1), cal.full_scale / cal.L0,
        _linear_error(table, np.eye(len(cal.L0))) / cal.L0, _linearity(cal, _own_sums(cal, table, sums)),
        cal.map.slopes(cal.rest) / cal.L0[:, None], _slope_errors(cal, table),
        _misread(read - loads, span), _linear_error(table, sums) / span, after, fine, by_model, by_map, whole,
        _condition(cal, valid if len(valid) else inside), seen, cal.share, cal.no_inverse, cal.error,
        _hysteresis(cal, branches),
    )


def reading_errors(cal: Calibration) -> Array:
    """Return least, median, greatest half width that holds 90 % of the true forces, over loads that have an inverse.

    By `budget`, with the calibration's noise and table errors; shape (d, 3) [N, N m], NaN without an inverse.
    """
    valid = _valid(cal)
    return _spread(budget(cal, valid).total) if len(valid) else np.full((len(cal.forces), 3), np.nan)


def _valid(cal: Calibration) -> Array:
    """Return the loads of a fine grid that have an inverse, shape (m, d)."""
    flat = _loads(cal).to_numpy().reshape(-1, len(cal.forces))
    scaled = cal.map.scaled(flat)
    return flat[cal.domain.holds(scaled, 0.0) & cal.domain.valid(scaled) & (cal.share > 0.0)]


def _loads(cal: Calibration) -> xr.DataArray:
    """Return a fine grid of loads over the forces and their names."""
    count = _FINE.get(len(cal.forces), 5)
    return _named_loads(cal, [np.linspace(a, b, count) for a, b in zip(cal.low, cal.high, strict=True)])


def _named_loads(cal: Calibration, axes: list[Array]) -> xr.DataArray:
    """Return the loads of a grid over the forces and their names."""
    coords = dict(zip(cal.forces, axes, strict=True)) | {"force": list(cal.forces)}
    return xr.DataArray(tensor_grid(*axes), coords, [*cal.forces, "force"])


def _spread(values: Array) -> Array:
    """Return least, median and greatest over loads (m, d), shape (d, 3)."""
    return np.stack([values.min(axis=0), np.median(values, axis=0), values.max(axis=0)], -1)


def _condition(cal: Calibration, loads: Array) -> tuple[float, float]:
    """Return the least and the greatest condition of the slopes over loads."""
    if len(cal.forces) > len(cal.coils):
        return np.inf, np.inf
    span = cal.high - cal.low
    whole = np.linalg.svd(cal.map.slopes(loads) * span / cal.full_scale.max(), compute_uv=False)
    condition = whole[:, 0] / np.maximum(whole[:, -1], 1e-300)
    return float(condition.min()), float(condition.max())


def _linear_sums(cal: Calibration, loads: Array) -> Array:
    """Return the sums of the inductances (d, n) that read each force best over loads, less its mean [N / unit].

    Of sums that the loads move: two coils that no asked force tells apart differ by rounding and errors alone.
    """
    L = cal.map.at(loads)
    design = np.hstack([L - L.mean(axis=0), np.ones((len(L), 1))]) / np.r_[cal.full_scale, 1.0]
    found = np.linalg.lstsq(design, loads, rcond=SEEN)[0]
    return np.asarray(found[:-1].T / cal.full_scale)


def _linear_error(table: xr.Dataset | None, sums: Array) -> Array:
    """Return how far differences of sums (k, n) of inductances can be off by the errors of a table, shape (k,)."""
    if table is None:
        return np.full(len(sums), np.nan)
    shared, alone, rest = error_parts(table, tuple(str(name) for name in table["error_L"].dims[:-1]))
    good = np.isfinite(rest).all(axis=-1)
    rest = rest[good]
    known = shared[:, good] @ sums.T, alone[:, good] @ sums.T
    own = np.max(np.abs(known[1]).sum(axis=0) + rest @ np.abs(sums).T, axis=0)
    return np.asarray((np.sqrt(2.0) if len(shared) else 2.0) * own + np.ptp(known[0], axis=1).sum(axis=0))


def _slope_errors(cal: Calibration, table: xr.Dataset | None) -> Array:
    """Return how far the slopes at the smallest loads can be off by the errors of a table, shape (n, d)."""
    if table is None:
        return np.full((len(cal.coils), len(cal.forces)), np.nan)
    at = {name: nearest_none(table, name) for name in cal.forces}
    each = [slope_doubt(table, "L", name).isel(at).to_numpy() for name in cal.forces]
    return np.stack(each, -1) / cal.L0[:, None]


def _own_sums(cal: Calibration, table: xr.Dataset | None, sums: Array) -> Array:
    """Return the weights of each force's own signal, those of a linear readout where geometry gives it none."""
    given = {} if table is None else dict(zip(FORCES, table["weights"].to_numpy(), strict=True))
    own = [given.get(name, np.zeros(len(cal.coils))) for name in cal.forces]
    return np.array([row if np.abs(row).max() > _READS else other for row, other in zip(own, sums, strict=True)])


def _linearity(cal: Calibration, own: Array) -> Array:
    """Return the largest distance of each force's signal from its best line, over the signal's range."""
    found = []
    for k in range(len(cal.forces)):
        line = np.tile(cal.rest, (_FINE[1], 1))
        line[:, k] = np.linspace(cal.low[k], cal.high[k], len(line))
        y = cal.map.at(line) @ own[k]
        if not np.isfinite(y).all():
            found.append(np.nan)
            continue
        straight = np.polynomial.Polynomial.fit(line[:, k], y, 1)(line[:, k])
        found.append(np.max(np.abs(y - straight)) / max(float(np.ptp(y)), 1e-300))
    return np.array(found)


def _misread(wrong: xr.DataArray, span: Array) -> Array:
    """Return how much of each force's error (row) every force (column) makes at full scale, over full scale."""
    names = [str(name) for name in wrong["force"].to_numpy()]
    each = [abs(response(wrong, name)).max([dim for dim in wrong.dims if dim != "force"]) for name in names]
    return np.stack([one.to_numpy() for one in each], -1) / span[:, None]


def _at_the_loads(cal: Calibration, table: xr.Dataset | None) -> tuple[Array, Array]:
    """Return crosstalk of the inverse, and what the errors of the inductances are worth, at the loads of a table."""
    d = len(cal.forces)
    none = np.full((d, d), np.nan), np.full((d, 3), np.nan)
    if table is None or cal.share == 0.0:
        return none
    loads = _named_loads(cal, [table[name].to_numpy() for name in cal.forces])
    found = cal.inverse(table["L"].transpose(*cal.forces, "coil").to_numpy())
    good = found.status == OK
    if not good.any():
        return none
    at, (shared, alone, rest) = loads.to_numpy()[good], error_parts(table, cal.forces)
    known = np.concatenate([shared, alone])[:, good]
    worth = cal.force_error(at, rest[good])
    worth += np.abs(np.einsum("mdn,kmn->kmd", cal.answers(at), known)).sum(axis=0)
    return _misread(loads.copy(data=found.forces) - loads, cal.high - cal.low), _spread(worth)


def _hysteresis(cal: Calibration, branches: tuple[ArrayLike, ArrayLike] | None) -> Array:
    """Return the largest difference of the forces that two branches show, over full scale."""
    none = np.full(len(cal.forces), np.nan)
    if branches is None or cal.share == 0.0:
        return none
    up, down = (cal.inverse(branch) for branch in branches)
    both = (up.status == OK) & (down.status == OK)
    if not np.any(both):
        return none
    return np.asarray(np.max(np.abs(up.forces - down.forces)[both], axis=0) / (cal.high - cal.low))
