"""Fit a Prony series to a relaxation test: non-negative least squares, as many branches as the data hold.

A specimen is strained in a finite time and held. Its engineering stress is linear in c and in ``a_i = c g_i``,

    P(t) = c P_0(t) + sum_i a_i B(t; tau_i),    w_i = a_i/(c + sum_j a_j),

with the elastic answer P_0 of a law to the *measured* strain and the convolution B of one branch with it
(uniaxial.py): no step is ideal, and what relaxes during the ramp is counted. c is the slow stress over that of the law.
Only the hold is compared; its samples are averaged over equal parts of the logarithm of time, so that the sampling rate
plays no part.

For n = 1, 2, ... branches the times begin evenly in their logarithm and are refined (least squares over ln tau, c and
a_i by non-negative least squares at each: variable projection). A further branch must lower the Bayesian criterion
``N ln(rss/N) + (2 n + 1) ln N`` by 6, and there are no more than decades between the shortest and the longest time that
the test can see: a third of the ramp, or a sample, and the hold. Fits with a branch without weight, or with two of one
time, do not count.

Slow load is *identified* where the hold lasts at least three times the longest branch; if not, what relaxes later stays
in c. Nor is it where the stress over that of the law rises from its least to the end of the hold by more than 2 %, and
more than noise makes it: no weights above zero do that; a load cell that drifts, a specimen that warms or cures does.
Confidence: 95 % half-widths as in fitted.py.

Source: C. L. Lawson, R. J. Hanson, Solving Least Squares Problems (1974); G. H. Golub, V. Pereyra, SIAM J. Numer. Anal.
10 (1973) 413; G. Schwarz, Ann. Stat. 6 (1978) 461; R. E. Kass, A. E. Raftery, J. Am. Stat. Assoc. 90
(1995) 773. Range: one level of strain. Neglected: dependence of G on strain.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares, nnls

from sits_mech.analysis.material.least_squares import half_widths
from sits_mech.analysis.material.tensile import Record
from sits_mech.analysis.material.uniaxial import branch_stress, softened_stress, subdivided
from sits_mech.quantities import Array
from sits_mech.silicone.material import Silicone

_PER_DECADE = 20  # parts of the hold that samples are averaged over
_GRID = 24  # times per decade at which B is computed; between them it is interpolated
_HELD = 0.05  # of the strain: more change during the hold is none
_LONG = 3.0  # longest branches that a hold must last to show slow load
_LEAST_WEIGHT = 1e-4  # of a branch
_APART = 1.5  # least ratio of two times
_STRONG = 6.0  # less of the criterion is strong evidence of a further branch
_LEAST = 8  # rows of a hold
_RISE = 0.02  # of the stress: a hold in which it rises by more shows something else
_WINDOW = 5  # parts that are averaged to see a rise
_SURE = 6.0  # standard deviations of such an average, which noise does not reach
_FLOOR = 1e-9  # of the stress: a residual of rounding is no reason for a branch


@dataclass(frozen=True)
class Relaxation:
    """A Prony series fitted to a relaxation test.

    `confidence`: 95 % half-widths, as `prony`; None where the data do not determine it.
    """

    prony: tuple[tuple[float, float], ...]  # share of the instantaneous stiffness, time [s], by time
    confidence: tuple[tuple[float | None, float | None], ...]
    factor: float | None  # slow stress over the law's; None without a law
    slow_identified: bool  # test long enough, stress does not rise
    range: tuple[float, float]  # relaxation times the test can see [s]
    strain: float  # engineering strain held
    rms: float  # of the engineering stress [Pa]
    source: str  # file of the data
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Hold:
    """Averages over the hold, with the relaxation times it sees [s]."""

    stress: Array  # (n,) [Pa]
    elastic: Array  # of the law, (n,) [Pa]
    branch: CubicSpline  # B by ln tau, (n,) [Pa]
    shortest: float
    longest: float

    def columns(self, x: Array) -> Array:
        """Return the stresses of the law and of branches of times exp(x), shape (n, 1 + branches)."""
        return np.column_stack([self.elastic, *self.branch(x)])

    def solved(self, x: Array) -> tuple[Array, Array]:
        """Return c and a_i of branches of times exp(x), and the residual [Pa]."""
        columns, scale = self.columns(x), np.abs(self.stress).max()
        found = nnls(columns / scale, self.stress / scale)[0]
        return found, columns @ found - self.stress


def fit_relaxation(record: Record, silicone: Silicone | None = None) -> Relaxation:
    """Fit a Prony series to a timed record of one ramp and one hold.

    The elastic stress is that of `silicone`, or neo-Hookean, which then counts during the ramp alone. Raise ValueError
    if the record is no relaxation test.
    """
    hold, level = _hold(record, silicone)
    x, values, residual = _best(hold)
    c, a = float(values[0]), values[1:]
    total = c + a.sum()
    weights, times = a / total, np.exp(x)
    widths = _widths(hold, x, values, residual)
    rise = _rise(hold)
    identified = bool(rise == 0.0 and c > 0.0 and (not len(x) or hold.longest >= _LONG * times[-1]))
    return Relaxation(
        prony=tuple(zip(weights.tolist(), times.tolist(), strict=True)),
        confidence=tuple(zip(widths[: len(x)], widths[len(x) :], strict=True)),
        factor=None if silicone is None else c,
        slow_identified=identified,
        range=(hold.shortest, hold.longest),
        strain=level,
        rms=float(np.sqrt(np.mean(residual**2))),
        source=Path(record.source).name,
        notes=_notes(hold, times, identified, rise),
    )


def _rise(hold: _Hold) -> float:
    """Return the rise of stress over the law's from its least to the end, over that least; 0 if it does not rise."""
    ratio = hold.stress / hold.elastic
    if len(ratio) < 2 * _WINDOW:
        return 0.0
    means = np.convolve(ratio, np.full(_WINDOW, 1.0 / _WINDOW), mode="valid")
    noise = np.median(np.abs(np.diff(ratio, 2))) / (0.6745 * np.sqrt(6.0))  # of a part: 6 = 1 + 4 + 1
    least = float(means.min())
    rise = float(means[-1]) - least
    return rise / least if rise > max(_RISE * abs(least), _SURE * noise / np.sqrt(_WINDOW)) else 0.0


def _notes(hold: _Hold, times: Array, identified: bool, rise: float) -> tuple[str, ...]:
    """Return notes on a series."""
    if rise:
        why = f"the stress rises by {100.0 * abs(rise):.3g} % during the hold, where silicone relaxes"
        return (f"slow load is not identified: {why}; drift of the load cell, warming or curing?",)
    if not len(times):
        return ("no relaxation beyond what the data leave",)
    if identified:
        return ()
    longest = f"the hold of {hold.longest:.3g} s is shorter than {_LONG:g} times the longest branch, {times[-1]:.3g} s"
    return (f"slow load is not identified: {longest}; what relaxes later counts as slow",)


def _hold(record: Record, silicone: Silicone | None) -> tuple[_Hold, float]:
    """Return averages over the hold, and the strain held; refuse a record that is no relaxation test."""
    peak, ramp = _ramp(record)
    after, level = record.time[peak:] - record.time[peak], float(np.mean(record.strain[peak:]))
    shortest, longest = float(max(ramp / 3.0, np.median(np.diff(after[:8])))), float(after[-1])
    if not longest > 3.0 * shortest:
        raise ValueError(f"{record.source}: must be held for longer than its ramp of {ramp:.3g} s; got {longest:.3g} s")
    law, constants = ("neo-hookean", {"shear_modulus": 1.0}) if silicone is None else (silicone.law, silicone.constants)
    fine, path, samples = subdivided(record.time, record.strain)
    elastic = softened_stress(Silicone("", law, constants, np.inf), path)
    x = np.linspace(np.log(shortest), np.log(longest), 2 + int(_GRID * np.log10(longest / shortest)))
    every = branch_stress(np.exp(x), fine, path, elastic)[samples][peak:]
    parts = np.floor(_PER_DECADE * np.log10(np.maximum(after / shortest, 1.0))).astype(int)
    _, first, count = np.unique(parts, return_index=True, return_counts=True)

    def mean(values: Array) -> Array:
        """Average over each part."""
        return (np.add.reduceat(values, first).T / count).T

    branch = CubicSpline(x, mean(every).T)
    return _Hold(mean(record.stress[peak:]), mean(elastic[samples][peak:]), branch, shortest, longest), level


def _ramp(record: Record) -> tuple[int, float]:
    """Return the first sample of the hold, and the duration of the ramp [s]."""
    time, strain, source = record.time, record.strain, record.source
    level = float(strain[int(np.argmax(np.abs(strain)))])
    if not abs(level) > 0.0:
        raise ValueError(f"{source}: must strain the specimen; got no strain")
    start, peak = (int(np.argmax(strain / level >= share)) for share in (0.01, 0.99))
    held, stress = float(np.min(strain[peak:] / level)), float(np.mean(record.stress[peak:]))
    if not held > 1.0 - _HELD:
        raise ValueError(f"{source}: must hold its strain within {_HELD:.0%} of the peak; it goes to {held:.3g} of it")
    if len(time) - peak < _LEAST:
        raise ValueError(f"{source}: must have {_LEAST} rows while the strain is held; got {len(time) - peak}")
    if not stress / level > 0.0:
        raise ValueError(f"{source}: stress must have the sign of the strain; got {stress:.3g} Pa at {level:.3g}")
    return peak, float(time[peak] - time[max(start - 1, 0)])


def _best(hold: _Hold) -> tuple[Array, Array, Array]:
    """Return ln tau, c with a_i, and the residual of as many branches as the data hold."""
    values, residual = hold.solved(np.zeros(0))
    found, count = (np.zeros(0), values, residual), len(hold.stress)
    least = _criterion(residual, 1, hold)
    for number in range(1, max(1, round(np.log10(hold.longest / hold.shortest))) + 1):
        if count <= 2 * number + 1:
            break
        x = np.sort(_refined(hold, number))
        values, residual = hold.solved(x)
        thin = values[1:] < _LEAST_WEIGHT * values.sum()
        if thin.any() or np.any(np.diff(x) < np.log(_APART)):
            continue
        criterion = _criterion(residual, 2 * number + 1, hold)
        if criterion < least - _STRONG:
            least, found = criterion, (x, values, residual)
    return found


def _criterion(residual: Array, unknowns: int, hold: _Hold) -> float:
    """Return Schwarz's criterion of a fit."""
    count, floor = len(residual), (_FLOOR * np.abs(hold.stress).max()) ** 2
    return float(count * np.log(np.mean(residual**2) + floor) + unknowns * np.log(count))


def _refined(hold: _Hold, number: int) -> Array:
    """Return the ln tau of least residual near evenly spaced ones."""
    low, high = np.log(hold.shortest), np.log(hold.longest)
    start = low + (high - low) * (np.arange(number) + 0.5) / number
    scale = np.abs(hold.stress).max()

    def left(x: Array) -> Array:
        """Return the residual."""
        return np.asarray(hold.solved(x)[1] / scale)

    found = least_squares(left, start, bounds=(low, high), xtol=1e-12, ftol=1e-14, gtol=1e-14, max_nfev=400)
    return found.x


def _widths(hold: _Hold, x: Array, values: Array, residual: Array) -> list[float | None]:
    """Return half-widths of the weights and then of the times [s]."""
    number, total = len(x), values.sum()
    if not number:
        return []
    slopes = np.column_stack([hold.columns(x), (hold.branch(x, 1) * values[1:, None]).T])
    by_value = np.eye(number, number + 1, 1) / total - (values[1:, None] / total**2)
    free = np.zeros((2 * number, 2 * number + 1))
    free[:number, : number + 1] = by_value
    free[number:, number + 1 :] = np.diag(np.exp(x))
    return half_widths(slopes, free, residual, np.ones(len(residual)))
