"""How good is the sensor? Range, linearity, sensitivity, crosstalk, resolution in newtons, condition, hysteresis.

Of a calibration L(F) with the slopes dL/dF, over the loads where it has an inverse:

    full scale       least and greatest force of the table
    linearity        largest distance of a signal along its own force, the others nearest zero, from the best straight
                     line, over the signal's range there
    crosstalk        force that a plane-fitted readout, F = A (L - L(0)), would be wrong by: share of the full scale of
                     each force that the other one feigns at its own full scale
    resolution       standard deviation of each force for the given noise of the inductances, by the slopes
    condition        of the slopes, forces over their full scale and inductances over the larger range: how much worse
                     the poorer direction is seen than the better one
    hysteresis       largest difference of a force between loading and unloading branches at one load, where both are
                     given

Numbers only: measured tables go the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import Array
from sits_mech.readout.calibration import OK, Calibration, check_enough
from sits_mech.readout.signals import combine, weights_of

_FINE = 33  # loads along each force


@dataclass(frozen=True)
class Quality:
    """Figures of a sensor; d forces, n coils.

    Attributes
    ----------
    forces, coils : tuple of str
    full_scale : ndarray, shape (d, 2)
        Least and greatest force [N].
    signal_range : ndarray, shape (n,)
        Range of each inductance, over its free-space value [-].
    linearity : ndarray, shape (d,)
        Of the signal that belongs to each force, over its range [-].
    sensitivity : ndarray, shape (n, d)
        Slopes at the least loads, over the free-space value [1/N].
    crosstalk : ndarray, shape (d, d)
        Row: the force that is read; column: the force that is applied at full scale; over the row's full scale [-].
    resolution : ndarray, shape (d, 3)
        Least, median and greatest standard deviation of each force over the table [N].
    condition : tuple of float
        Least and greatest [-].
    valid_share : float
        Of the loads that have an inverse [-].
    no_inverse : tuple of str
        The others, named.
    map_error : float
        Over full scale [-].
    hysteresis : ndarray, shape (d,)
        Over the full scale of each force; NaN where no branches are given [-].
    """

    forces: tuple[str, ...]
    coils: tuple[str, ...]
    full_scale: Array
    signal_range: Array
    linearity: Array
    sensitivity: Array
    crosstalk: Array
    resolution: Array
    condition: tuple[float, float]
    valid_share: float
    no_inverse: tuple[str, ...]
    map_error: float
    hysteresis: Array


def quality(
    cal: Calibration, noise: ArrayLike, *, positions: Sequence[float] = (-1.0, 1.0),
    branches: tuple[ArrayLike, ArrayLike] | None = None,
) -> Quality:  # fmt: skip
    """Return the figures of a sensor.

    Parameters
    ----------
    cal : Calibration
        With at least as many coils as forces.
    noise : array_like, shape (n,)
        Standard deviation of each inductance [unit].
    positions : sequence of float
        x of each coil, for the shear signal [m].
    branches : tuple of array_like, optional
        Inductances (m, n) at the same loads, loading and unloading [unit].

    Raises
    ------
    ValueError
        When there are fewer coils than forces, or the noise is not one positive number for each coil.
    """
    noise = np.asarray(noise, dtype=float)
    check_enough(cal.coils, cal.forces)
    if noise.shape != (len(cal.coils),) or not np.all(noise > 0.0):
        raise ValueError(f"noise: must be {len(cal.coils)} positive numbers [{cal.unit}]; got {noise}")
    loads = _loads(cal)
    spread = cal.force_noise(loads, noise)
    valid = cal.domain.valid(cal.map.scaled(loads)) & cal.domain.holds(cal.map.scaled(loads), 0.0)
    spread = spread[valid] if valid.any() else np.full((1, len(cal.forces)), np.nan)
    span = cal.high - cal.low
    whole = np.linalg.svd(cal.map.slopes(loads[valid]) * span / cal.full_scale.max(), compute_uv=False)
    condition = whole[:, 0] / np.maximum(whole[:, -1], 1e-300)
    return Quality(
        cal.forces, cal.coils, np.stack([cal.low, cal.high], -1), cal.full_scale / cal.L0, _linearity(cal, positions),
        cal.map.slopes(_least(cal)) / cal.L0[:, None], _crosstalk(cal),
        np.stack([spread.min(axis=0), np.median(spread, axis=0), spread.max(axis=0)], -1),
        (float(condition.min()), float(condition.max())), cal.domain.share, cal.domain.regions, cal.error,
        _hysteresis(cal, branches),
    )  # fmt: skip


def _loads(cal: Calibration) -> Array:
    """Return a fine grid of loads (m, d)."""
    axes = [np.linspace(a, b, _FINE) for a, b in zip(cal.low, cal.high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))


def _least(cal: Calibration) -> Array:
    """Return the load of the table nearest to none."""
    return np.asarray(np.clip(0.0, cal.low, cal.high))


def _signal(cal: Calibration, L: Array, force: str, positions: Sequence[float]) -> Array:
    """Return the signal that answers a force: the sum for a normal one, left less right for the others."""
    if len(cal.coils) == 1:
        return L[..., 0]
    places = np.column_stack([positions, np.zeros(len(positions))])
    each = combine(L, weights_of(places, 1e-9))
    normal, shear = (3, 4) if len(positions) == 2 else (0, 1)
    return np.asarray(each[..., normal if force == "F_z" else shear])


def _linearity(cal: Calibration, positions: Sequence[float]) -> Array:
    """Return the largest distance of each force's signal from its best line, over the signal's range."""
    found = []
    for k, name in enumerate(cal.forces):
        line = np.tile(_least(cal), (_FINE, 1))
        line[:, k] = np.linspace(cal.low[k], cal.high[k], _FINE)
        y = _signal(cal, cal.map.at(line), name, positions)
        straight = np.polynomial.Polynomial.fit(line[:, k], y, 1)(line[:, k])
        found.append(np.max(np.abs(y - straight)) / max(float(np.ptp(y)), 1e-300))
    return np.array(found)


def _crosstalk(cal: Calibration) -> Array:
    """Return what a linear readout, fitted over the whole table, reads of each force at the other's full scale."""
    loads = _loads(cal)
    L = cal.map.at(loads)
    design = np.hstack([L - L.mean(axis=0), np.ones((len(L), 1))]) / np.r_[cal.full_scale, 1.0]
    read = design @ np.linalg.lstsq(design, loads, rcond=None)[0]
    span = cal.high - cal.low
    found = np.zeros((len(span), len(span)))
    wrong = (read - loads).reshape(*(_FINE,) * len(span), len(span))
    for j in range(len(span)):
        moved = wrong - np.take(wrong, [int(np.argmin(np.abs(np.linspace(cal.low[j], cal.high[j], _FINE))))], axis=j)
        found[:, j] = np.max(np.abs(moved).reshape(-1, len(span)), axis=0) / span
    return found


def _hysteresis(cal: Calibration, branches: tuple[ArrayLike, ArrayLike] | None) -> Array:
    """Return the largest difference of the forces that two branches show, over full scale."""
    if branches is None:
        return np.full(len(cal.forces), np.nan)
    up, down = (cal.inverse(branch) for branch in branches)
    both = (up.status == OK) & (down.status == OK)
    if not np.any(both):
        return np.full(len(cal.forces), np.nan)
    return np.asarray(np.max(np.abs(up.forces - down.forces)[both], axis=0) / (cal.high - cal.low))
