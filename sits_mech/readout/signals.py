"""Combine inductances to signals by the places of the coils, in percent of the mean inductance L0.

    dL_v = 100 sum_i (L_i - L0_i) / sum_i L0_i              answers a normal force
    dL_x = 100 sum_i w_i (L_i - L0_i) / mean_i L0_i         answers a shear force along x; dL_y alike
    w_i = -(x_i - mean x) / max(max_j |x_j - mean x|, r)    r half the largest coil's outer radius

L0 are the inductances without target. Two coils whose centres differ along an axis by less than r overlap in it: there
the weights go to zero with the distance, so that each signal is continuous in the places of the coils.

One or two coils show the published pair besides, L_v = L1 + L2 and L_h = L1 - L2, in percent of the mean L0: dL_x is
L_h but for the offset of free space. Numbers only: measured inductances go the same way as computed ones.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import Array

SIGNALS = ("dL_v", "dL_x", "dL_y")
"""Names of the signals that every sensor has."""
COMBINED = ("L_v", "L_h")
"""Names of the published signals of one or two coils; with ``_percent`` those over L0."""
Value = float | Array
_ROUNDING = 1e-9  # of L0 [%]: signals that symmetry cancels come out as 1e-13


@dataclass(frozen=True)
class Signals:
    """The signals and their estimated absolute errors, numbers or arrays of one shape.

    Attributes
    ----------
    dL_v, dL_x, dL_y : float or ndarray
        Change of the mean inductance and its first moments [% of the mean L0].
    L_v, L_h : float, ndarray or None
        Sum and difference of a pair, in the unit of the inductances; None for three and more coils.
    L_v_percent, L_h_percent : float, ndarray or None
        Relative to L0 [%].
    error_dL_v, error_dL_x, ... : float, ndarray or None
        Estimated absolute error of each.
    """

    dL_v: Value
    dL_x: Value
    dL_y: Value
    error_dL_v: Value = 0.0
    error_dL_x: Value = 0.0
    error_dL_y: Value = 0.0
    L_v: Value | None = None
    L_h: Value | None = None
    L_v_percent: Value | None = None
    L_h_percent: Value | None = None
    error_L_v: Value | None = None
    error_L_h: Value | None = None
    error_L_v_percent: Value | None = None
    error_L_h_percent: Value | None = None

    @property
    def known(self) -> dict[str, Value]:
        """Signals that the coils have, with their errors, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


def changes(values: Array, errors: Array) -> bool:
    """Return whether a signal changes by more than its errors and rounding, all in percent of L0."""
    return bool(np.ptp(values) > 2.0 * max(float(np.max(errors)), _ROUNDING))


def shown_signals(names: Container[Any]) -> tuple[str, ...]:
    """Return the signals of a table that reports show, relative to L0: the published pair where the table has it."""
    pair = tuple(f"{name}_percent" for name in COMBINED)
    return pair if pair[0] in names else SIGNALS


def weights_of(centres: ArrayLike, radius: float) -> Array:
    """Return the weights of dL_v, dL_x and dL_y in units of the mean L0, shape (3, n), of coils' axes (n, 2) [m].

    `radius` is the outer one of the largest coil [m].
    """
    places = np.asarray(centres, dtype=float)
    away = (places - places.mean(axis=0)).T
    reach = np.maximum(np.abs(away).max(axis=1, keepdims=True), 0.5 * radius)
    return np.vstack([np.full(len(places), 1.0 / len(places)), -away / reach])


def rows_of(weights: Array) -> Array:
    """Return the weights of all signals: those of `weights_of`, and of one or two coils those of L_v and L_h."""
    pair = {1: [[1.0], [0.0]], 2: [[1.0, 1.0], [1.0, -1.0]]}.get(weights.shape[1])
    return weights if pair is None else np.vstack([weights, pair])


def combine(L: Array, weights: Array) -> Array:
    """Return the combinations of inductances (..., n) that the signals are made of, shape (..., r), in the unit of L.

    r is 3, and 5 for one or two coils.
    """
    return L @ rows_of(weights).T


def signal_changes(change: Array, L0: Array, weights: Array) -> dict[str, Array]:
    """Return what changes of the inductances, shape (..., n), make of each signal, shape (...), by its name."""
    known, before = signals(L0 + change, L0, weights).known, signals(L0, L0, weights).known
    return {name: np.asarray(value - before[name]) for name, value in known.items() if not name.startswith("error_")}


def signals(L: Array, L0: Array, weights: Array, errors: ArrayLike = 0.0) -> Signals:
    """Return the signals of inductances L (..., n), L0 (n,), with `errors` (..., r) of what `combine` returns.

    ValueError when the numbers of coils differ or L0 is not positive.
    """
    if L.shape[-1] != len(L0) or weights.shape[-1] != len(L0):
        counts = f"{L.shape[-1]}, {len(L0)} and {weights.shape[-1]}"
        raise ValueError(f"L, L0 and weights must be of one number of coils; got {counts}")
    if not np.all(L0 > 0.0):
        raise ValueError(f"L0 must be positive; got {L0}")
    percent, free = 100.0 / float(np.mean(L0)), len(SIGNALS)
    absolute, offset = combine(L, weights), combine(L0, weights)
    wrong = np.broadcast_to(np.asarray(errors, dtype=float), absolute.shape)
    found = {name: percent * (absolute[..., k] - offset[k]) for k, name in enumerate(SIGNALS)}
    found |= {f"error_{name}": percent * wrong[..., k] for k, name in enumerate(SIGNALS)}
    for k, name in enumerate(COMBINED[: absolute.shape[-1] - free], free):
        found |= {name: absolute[..., k], f"{name}_percent": percent * absolute[..., k]}
        found |= {f"error_{name}": wrong[..., k], f"error_{name}_percent": percent * wrong[..., k]}
    return Signals(**found)
