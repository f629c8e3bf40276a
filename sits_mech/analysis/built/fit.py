"""Fit parameters of a model to a measurement, with half-widths and correlations.

Least squares over all numbers measured, each output over its range, or over the noise of a reading where that is known:

    chi^2(p) = sum ((y(p) - y) / sigma)^2 + sum ((p_k - v_k) / s_k)^2,

the second sum, of squares of z_k, over parameters that are known to be v_k +- s_k beforehand; of a factor it is of its
logarithm. Of parameters that are known together it is |B z|^2, (B^T B)^-1 the correlations of z. With known noise and
parameters that are all known beforehand this is, but for a constant, -2 ln of the posterior density, whose covariance
where it is largest is that of Laplace's approximation,

    Sigma = (J^T J)^-1,    J the derivatives of all terms,    chi^2(p) of N numbers follows chi^2_N if all is as stated.

Half-widths at 95 % are those of Student's t with the residual's variance, or the model's own if that is more; with a
known noise the normal distribution's, wider by what chi^2 over its degrees of freedom exceeds one. Numbers only: the
model is any function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult, least_squares, lsq_linear
from scipy.stats import chi2, norm
from scipy.stats import t as student

from sits_mech.quantities import Array
from sits_mech.units import SceneError

Model = Callable[[Array], Array]
"""Parameters, many at a time, shape (k, p), to outputs, shape (k, m, n); NaN where there is none."""
Slopes = Callable[[Array], Array]
"""Parameters, shape (p,), to derivatives of the outputs by them, shape (m, n, p)."""
_STEP = 1e-3  # of a parameter's size: of the differences
_ENOUGH = 1e-3  # of chi^2: 0.03 deviations
_STEPS, _HALVINGS = 40, 5  # of Gauss and Newton: some ten are taken, whole ones, more along a bent valley
_END = 1e-6  # of the reach: this close to its end a value is held by it


class EndReached(SceneError):
    """A best value at an end of its reach: of which parameter, and the end."""

    def __init__(self, words: str, name: str, end: float) -> None:
        super().__init__(words)
        self.name, self.end = name, end


@dataclass(frozen=True)
class Free:
    """A parameter to fit."""

    name: str
    start: float  # known beforehand, and the first value, or the end next to it
    low: float
    high: float
    size: float  # typical change
    deviation: float = np.inf  # standard deviation known beforehand; inf if nothing is
    beyond: tuple[str, str] = ("", "")  # why it must not be less, nor more
    wall: bool = False  # whether its lower end is nature's, where it may stay
    ratio: bool = False  # whether ln of it is what is known, of a positive one; the deviation is then relative to start

    def known(self, value: Array) -> Array:
        """Return how far values are from what is known beforehand, in deviations."""
        off = self.start * np.log(np.maximum(value, 1e-300) / self.start) if self.ratio else value - self.start
        return off / self.deviation

    def value(self, z: float) -> float:
        """Return the value that is z deviations from what is known beforehand."""
        off = z * self.deviation
        return float(self.start * np.exp(off / self.start) if self.ratio else self.start + off)

    def known_slope(self, value: float) -> float:
        """Return the derivative of `known`."""
        return (self.start / value if self.ratio else 1.0) / self.deviation


@dataclass(frozen=True)
class Beforehand:
    """What is known of parameters beforehand, terms of chi^2."""

    free: tuple[Free, ...]
    root: Array | None = None  # B of the module docstring, (k, k), of the first k parameters; each alone without it

    @property
    def count(self) -> int:
        """How many terms there are."""
        return sum(np.isfinite(each.deviation) for each in self.free)

    def terms(self, P: Array) -> Array:
        """Return the terms for parameters (k, p), shape (k, known)."""
        each = [one.known(P[:, k]) for k, one in enumerate(self.free) if np.isfinite(one.deviation)]
        return self._together(np.reshape(each, (-1, len(P)))).T

    def slopes(self, p: Array) -> Array:
        """Return their derivatives by the parameters (p,), shape (known, p)."""
        rows = [np.isfinite(each.deviation) for each in self.free]
        each = np.diag([one.known_slope(x) for one, x in zip(self.free, p.tolist(), strict=True)])[rows]
        return self._together(each)

    def _together(self, each: Array) -> Array:
        """Return B z of columns z."""
        if self.root is None:
            return each
        first = len(self.root)
        return np.concatenate([self.root @ each[:first], each[first:]])


@dataclass(frozen=True)
class ParameterFit:
    """Parameters of a model fitted to a measurement."""

    names: tuple[str, ...]
    values: Array  # (p,)
    half_widths: Array  # 95 %, (p,); inf if not determined
    correlation: Array  # (p, p)
    covariance: Array  # (p, p), with the variance below; pseudo-inverse where something is not determined
    residual: Array  # measured less model, (m, n)
    rms: float  # of the residual, over each output's range
    rms_before: float  # the same at the first values
    chi_square: float  # in units of the noise, or of each range
    variance: float  # multiplies the parameters' covariance
    p_value: float  # probability of more than this chi^2; NaN where the noise is not known


def fit_parameters(
    model: Model, y: ArrayLike, free: Sequence[Free], *, noise: ArrayLike | None = None, own: float = 0.0,
    slopes: Slopes | None = None, root: Array | None = None,
) -> ParameterFit:
    """Fit the parameters of a model to measured outputs (m, n), NaN where none was measured.

    `noise`: standard deviation of the numbers of `y`, of one shape with them or alike for all; `own`: root mean square
    error of the model itself over each range, a floor of the scatter; `slopes` in place of differences; `root` as of
    `Beforehand`. Raise SceneError for no more numbers than parameters, prior knowledge without noise; EndReached for a
    best value at an end.
    """
    y, beforehand = np.asarray(y, dtype=float), Beforehand(tuple(free), root)
    known = beforehand.count
    numbers = int(np.isfinite(y).sum())
    if numbers + known <= len(free):
        raise SceneError(f"measurement: must hold more than {len(free) - known} numbers; got {numbers}")
    if known and noise is None:
        raise SceneError("noise: must be given where a parameter has a deviation: both are weighed; got none")
    ranges = np.maximum(np.nanmax(y, axis=0) - np.nanmin(y, axis=0), 1e-6 * np.nanmax(np.abs(y), axis=0))
    scale = np.broadcast_to(ranges if noise is None else np.asarray(noise, dtype=float), y.shape)
    sizes = np.array([each.size for each in free])
    start = np.array([np.clip(each.start, each.low, each.high) for each in free])
    found = _least(model, y, beforehand, scale, start, slopes)
    _check_ends(free, found.x)
    jacobian = found.jac * sizes
    flat = np.linalg.norm(jacobian, axis=0) < 1e-12
    spread = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    freedom, chi_square = numbers + known - len(free), float(np.sum(found.fun**2))
    least, within, p_value = own**2, student.ppf(0.975, freedom), np.nan
    if noise is not None:
        least, within, p_value = 1.0, norm.ppf(0.975), float(chi2.sf(chi_square, freedom))
    variance = max(chi_square / freedom, least)
    covariance = spread * variance * np.outer(sizes, sizes)
    widths = np.where(flat, np.inf, within * np.sqrt(np.diagonal(spread) * variance) * sizes)
    safe = np.sqrt(np.maximum(np.diagonal(spread), 1e-300))
    off = y - model(np.stack([found.x, start]))
    rms, before = (float(np.sqrt(np.nanmean((each / ranges) ** 2))) for each in off)
    return ParameterFit(
        tuple(each.name for each in free), found.x, widths, spread / np.outer(safe, safe), covariance, off[0],
        rms, before, chi_square, variance, p_value,
    )


def _least(
    model: Model, y: Array, beforehand: Beforehand, scale: Array, start: Array, slopes: Slopes | None = None
) -> OptimizeResult:
    """Return the parameters of least chi^2 near `start`; residuals of the data come first, then of prior knowledge."""
    free, there = beforehand.free, np.isfinite(y)
    low, high, sizes = (np.array([getattr(each, key) for each in free]) for key in ("low", "high", "size"))

    def off(P: Array) -> Array:
        """Return residuals for many parameters, shape (k, m n + known)."""
        return np.concatenate([((model(P) - y) / scale)[:, there], beforehand.terms(P)], axis=1)

    def by_slopes(p: Array) -> Array:
        """Return their derivatives by those of the model."""
        data = (slopes(p) / scale[..., None])[there] if slopes else np.zeros((0, len(p)))
        return np.concatenate([data, beforehand.slopes(p)])

    def differences(p: Array) -> Array:
        """Return their derivatives by differences, one-sided where the other side fails; evaluated at once."""
        up, down = np.minimum(p + _STEP * sizes, high), np.maximum(p - _STEP * sizes, low)
        places = [np.where(np.eye(len(p), dtype=bool), side, p) for side in (up, down)]
        each = off(np.concatenate([*places, p[None]]))
        (above, below), here = each[:-1].reshape(2, len(p), -1), each[-1]
        up = np.where(none := ~np.isfinite(above).all(axis=1), p, up)
        above[none] = here
        down = np.where(none := ~np.isfinite(below).all(axis=1), p, down)
        below[none] = here
        return ((above - below) / np.where(up > down, up - down, np.inf)[:, None]).T

    def one(p: Array) -> Array:
        """Return the residuals for one."""
        return np.asarray(off(p[None])[0])

    if slopes:
        return _gauss_newton(one, by_slopes, start, (low, high), sizes)
    return least_squares(
        one, start, jac=differences, bounds=(low, high), x_scale=sizes, xtol=1e-8, ftol=1e-9, gtol=1e-12
    )


def _gauss_newton(
    residuals: Callable[[Array], Array], slopes: Callable[[Array], Array], first: Array, ends: tuple[Array, Array],
    sizes: Array,
) -> OptimizeResult:
    """Return the parameters of least chi^2 in a box by Gauss and Newton, steps halved until it falls.

    Slopes are those of the first step, corrected by each step's own change (C. G. Broyden, Math. Comp. 19 (1965) 577),
    and new ones where these lead nowhere. A step is the least of the linear model in the box (P. B. Stark,
    R. L. Parker, Comput. Stat. 10 (1995) 129). It ends where a step of new slopes would gain less than `_ENOUGH`, of
    each term's share where the noise is not known.
    """
    (low, high), x, r = ends, first, residuals(first)
    J, fresh = slopes(x), True
    for _ in range(_STEPS):
        room = (low - x) / sizes, (high - x) / sizes
        step = sizes * lsq_linear(J * sizes, -r, bounds=room, method="bvls").x
        left = r + J @ step
        if not r @ r - left @ left > _ENOUGH * min(1.0, float(r @ r) / len(r)):
            if fresh:
                break
            J, fresh = slopes(x), True
            continue
        places = np.clip(x + np.outer(0.5 ** np.arange(_HALVINGS), step), low, high)
        tried = ((there, residuals(there)) for there in places)
        better = next(((there, new) for there, new in tried if new @ new < r @ r), None)
        if better is None and fresh:
            break
        if better is not None:
            way, change = (better[0] - x) / sizes, better[1] - r
            x, r = better
        fresh = better is None
        J = slopes(x) if fresh else J + np.outer(change - J @ (way * sizes), way / sizes) / (way @ way)
    found = OptimizeResult()
    found.update(x=x, fun=r, jac=J if fresh else slopes(x))
    return found


def _check_ends(free: Sequence[Free], values: Array) -> None:
    """Refuse best values at an end."""
    for each, value in zip(free, values.tolist(), strict=True):
        if min(value - each.low, each.high - value) < _END * (each.high - each.low):
            upper = each.high - value < value - each.low
            if each.wall and not upper:
                continue
            reason = each.beyond[int(upper)] or "what moved the readings is not fitted, or a unit is wrong"
            came = f"the fit goes on to its {'upper' if upper else 'lower'} end, {value:.4g}: {reason}"
            words = f"{each.name}: must fit the readings between {each.low:.4g} and {each.high:.4g}; {came}"
            raise EndReached(words, each.name, each.high if upper else each.low)
