"""What does the sensor show? Two signals of its coils' inductances, absolute and relative to free space.

    L_v = sum_i L_i                (two coils: L1 + L2), answers a normal force
    L_h = sum_i w_i L_i            (two coils: L1 - L2), answers a shear force

Both are quoted as a percentage of L0, the mean of the coils' inductances without target: at rest a pair shows a little
less than 200 % and 0 %. Numbers only: measured inductances go the same way as computed ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array


@dataclass(frozen=True)
class Signals:
    """The two signals and their estimated absolute errors, numbers or arrays of one shape.

    Attributes
    ----------
    L_v, L_h : float or ndarray
        In the unit of the inductances.
    L_v_percent, L_h_percent : float or ndarray
        Relative to L0 [%].
    error_L_v, error_L_h, error_L_v_percent, error_L_h_percent : float or ndarray
        Estimated absolute error of each.
    """

    L_v: float | Array
    L_h: float | Array
    L_v_percent: float | Array
    L_h_percent: float | Array
    error_L_v: float | Array = 0.0
    error_L_h: float | Array = 0.0
    error_L_v_percent: float | Array = 0.0
    error_L_h_percent: float | Array = 0.0


def shear_weights(positions: Sequence[float]) -> Array:
    """Return the weights w of L_h for coils at `positions` along x [m]: +1 and -1 for a pair, else left minus right."""
    return np.array([1.0, -1.0]) if len(positions) == 2 else -np.sign(np.asarray(positions, dtype=float))


def combine(L: Array, weights: Array) -> tuple[Array, Array]:
    """Return L_v and L_h.

    Parameters
    ----------
    L : ndarray, shape (..., n)
        Inductance of each coil.
    weights : ndarray, shape (n,)
        Of L_h, as from `shear_weights`.

    Returns
    -------
    tuple of ndarray, shape (...)
        In the unit of L.
    """
    return np.sum(L, axis=-1), np.asarray(L @ weights)


def signals(L: Array, L0: Array, weights: Array, errors: tuple[Array | float, Array | float] = (0.0, 0.0)) -> Signals:
    """Return the signals with their errors.

    Parameters
    ----------
    L : ndarray, shape (..., n)
        Inductance of each coil.
    L0 : ndarray, shape (n,)
        The same without target.
    weights : ndarray, shape (n,)
        Of L_h.
    errors : tuple of float or ndarray, shape (...)
        Estimated absolute errors of L_v and L_h.

    Returns
    -------
    Signals
        Of shape (...).

    Raises
    ------
    ValueError
        When the numbers of coils differ or L0 is not positive.
    """
    if L.shape[-1] != len(L0) or len(weights) != len(L0):
        counts = f"{L.shape[-1]}, {len(L0)} and {len(weights)}"
        raise ValueError(f"L, L0 and weights must be of one number of coils; got {counts}")
    if not np.all(L0 > 0.0):
        raise ValueError(f"L0 must be positive; got {L0}")
    percent = 100.0 / float(np.mean(L0))
    L_v, L_h = combine(L, weights)
    error_v, error_h = errors
    return Signals(L_v, L_h, percent * L_v, percent * L_h, error_v, error_h, percent * error_v, percent * error_h)
