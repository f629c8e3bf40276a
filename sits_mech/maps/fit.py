"""Which parameters of a model describe a measurement, how far are they known, and what do they share?

Least squares over all numbers measured, each output over its range, or over the noise of a reading where that is known:

    chi^2(p) = sum ((y(p) - y) / sigma)^2 + sum ((p_k - v_k) / s_k)^2,

the second sum over parameters that are known to be v_k +- s_k beforehand. Half-widths at 95 % are those of Student's t
with the residual's variance, or the model's own if that is more; with a known noise the normal distribution's, wider
by what chi^2 over its degrees of freedom exceeds one. The profile of a parameter is the least chi^2 for each of its
values, all others fitted; less its own term it is what the measurement says of it, flat where it says nothing.
Numbers only: the model is any function. Source of the profile: D. M. Bates, D. G. Watts, Nonlinear Regression
Analysis and Its Applications, Wiley 1988, ch. 6.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import norm
from scipy.stats import t as student

from sits_mech.quantities import Array
from sits_mech.units import SceneError

Model = Callable[[Array], Array]
"""Parameters, many at a time, shape (k, p), to outputs, shape (k, m, n); NaN where there is none."""
_STEP = 1e-3  # of a parameter's size: of the differences
_END = 1e-6  # of the reach: this close to its end a value is held by it


@dataclass(frozen=True)
class Free:
    """A parameter that is fitted.

    Attributes
    ----------
    name : str
    start, low, high : float
        First value, which is also the value known beforehand; least and greatest values.
    size : float
        How large a change of it is.
    deviation : float
        Standard deviation of what is known of it beforehand; infinite where that is nothing.
    beyond : tuple of str
        Why it must not be less, and not be more.
    """

    name: str
    start: float
    low: float
    high: float
    size: float
    deviation: float = np.inf
    beyond: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class ParameterFit:
    """Parameters of a model that describe a measurement.

    Attributes
    ----------
    names : tuple of str
    values, half_widths : ndarray, shape (p,)
        Best values and their 95 % half-widths; infinite where the data do not determine them.
    correlation : ndarray, shape (p, p)
    residual : ndarray, shape (m, n)
        Measured less model.
    rms, rms_before : float
        Of the residual with the best and with the first values, over each output's range.
    chi_square : float
        What is least, in units of the noise; over each range where no noise is known.
    variance : float
        By which the half-widths are those of more than the noise.
    """

    names: tuple[str, ...]
    values: Array
    half_widths: Array
    correlation: Array
    residual: Array
    rms: float
    rms_before: float
    chi_square: float
    variance: float


def fit_parameters(
    model: Model, y: ArrayLike, free: Sequence[Free], *, noise: float | None = None, own: float = 0.0
) -> ParameterFit:
    """Return the parameters of a model that describe a measurement best.

    Parameters
    ----------
    model : callable
    y : array_like, shape (m, n)
        Measured, n outputs.
    free : sequence of Free
        The parameters.
    noise : float, optional
        Standard deviation of a number of `y`.
    own : float
        Root mean square error of the model itself, over each range: half-widths are not of less scatter.

    Raises
    ------
    SceneError
        When there are no more numbers than parameters, something is known beforehand but the noise is not, or the best
        value lies at an end.
    """
    y = np.asarray(y, dtype=float)
    known = sum(np.isfinite(each.deviation) for each in free)
    if y.size + known <= len(free):
        raise SceneError(f"measurement: must hold more than {len(free) - known} numbers; got {y.size}")
    if known and noise is None:
        raise SceneError("noise: must be given where a parameter has a deviation: both are weighed; got none")
    ranges = np.maximum(np.ptp(y, axis=0), 1e-6 * np.abs(y).max(axis=0))
    scale = ranges if noise is None else np.full(y.shape[1], noise)
    found = _least(model, y, free, scale)
    _check_ends(free, found.x)
    sizes = np.array([each.size for each in free])
    jacobian = found.jac * sizes
    flat = np.linalg.norm(jacobian, axis=0) < 1e-12
    spread = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    freedom, chi_square = y.size + known - len(free), float(np.sum(found.fun**2))
    variance = max(chi_square / freedom, own**2) if noise is None else max(chi_square / freedom, 1.0)
    within = student.ppf(0.975, freedom) if noise is None else norm.ppf(0.975)
    widths = np.where(flat, np.inf, within * np.sqrt(np.diagonal(spread) * variance) * sizes)
    safe = np.sqrt(np.maximum(np.diagonal(spread), 1e-300))
    start = np.array([each.start for each in free])
    off = y - model(np.stack([found.x, start]))
    rms, before = (float(np.sqrt(np.mean((each / ranges) ** 2))) for each in off)
    return ParameterFit(
        tuple(each.name for each in free), found.x, widths, spread / np.outer(safe, safe), off[0], rms, before,
        chi_square, variance,
    )  # fmt: skip


def profile(
    model: Model, y: ArrayLike, free: Sequence[Free], found: ParameterFit, name: str, *, noise: float,
    values: ArrayLike,
) -> Array:  # fmt: skip
    """Return what the measurement says of a parameter: least chi^2 for each of its values, less its own term.

    Parameters
    ----------
    model, y, free, noise
        As for `fit_parameters`.
    found : ParameterFit
        Its result.
    name : str
        Of the parameter.
    values : array_like, shape (k,)
        Its values, in order.

    Returns
    -------
    ndarray, shape (k,)
        Above the least of them; infinite where the model has no outputs.
    """
    y, values = np.asarray(y, dtype=float), np.asarray(values, dtype=float)
    place = [each.name for each in free].index(name)
    others = [each for each in free if each.name != name]
    scale, best = np.full(y.shape[1], noise), np.full(len(values), np.inf)
    start = int(np.argmin(np.abs(values - found.values[place])))
    for way in (range(start, len(values)), range(start - 1, -1, -1)):
        here = np.delete(found.values, place)
        for k in way:

            def held(p: Array, value: float = float(values[k])) -> Array:
                """The model with this parameter held."""
                return model(np.insert(p, place, value, axis=-1))

            if not others:
                best[k] = float(np.sum(((held(np.zeros((1, 0))) - y) / scale) ** 2))
                continue
            if not np.all(np.isfinite(held(here[None]))):
                break
            rest = _least(held, y, others, scale, here)
            here, best[k] = rest.x, float(np.sum(rest.fun**2))
    return np.asarray(best - np.min(best))


def _least(
    model: Model, y: Array, free: Sequence[Free], scale: Array, start: Array | None = None
) -> OptimizeResult:
    """Return the parameters of the least chi^2; residuals of the data come first, then of what is known."""
    known = np.array([each.start for each in free])
    deviations = np.array([each.deviation for each in free])
    rows = np.isfinite(deviations)
    low, high, sizes = (np.array([getattr(each, key) for each in free]) for key in ("low", "high", "size"))

    def off(P: Array) -> Array:
        """Residuals for many parameters, shape (k, m n + known)."""
        data = ((model(P) - y) / scale).reshape(len(P), -1)
        return np.concatenate([data, ((P - known) / np.where(rows, deviations, 1.0))[:, rows]], axis=1)

    def slopes(p: Array) -> Array:
        """Their derivatives, by differences on both sides, or one where the other has no answer; asked for at once."""
        up, down = np.minimum(p + _STEP * sizes, high), np.maximum(p - _STEP * sizes, low)
        places = [np.where(np.eye(len(p), dtype=bool), side, p) for side in (up, down)]
        each = off(np.concatenate([*places, p[None]]))
        (above, below), here = each[:-1].reshape(2, len(p), -1), each[-1]
        up = np.where(none := ~np.isfinite(above).all(axis=1), p, up)
        above[none] = here
        down = np.where(none := ~np.isfinite(below).all(axis=1), p, down)
        below[none] = here
        return np.asarray(((above - below) / np.where(up > down, up - down, np.inf)[:, None]).T)

    def one(p: Array) -> Array:
        """Residuals for one."""
        return np.asarray(off(p[None])[0])

    first = known if start is None else np.clip(start, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
    return least_squares(
        one, first, jac=slopes, bounds=(low, high), x_scale=sizes, xtol=1e-8, ftol=1e-9,
        gtol=1e-12,
    )  # fmt: skip


def _check_ends(free: Sequence[Free], values: Array) -> None:
    """Refuse best values at an end."""
    for each, value in zip(free, values.tolist(), strict=True):
        if min(value - each.low, each.high - value) < _END * (each.high - each.low):
            upper = each.high - value < value - each.low
            reason = each.beyond[int(upper)] or "what moved the readings is not fitted, or a unit is wrong"
            came = f"the fit goes on to its {'upper' if upper else 'lower'} end, {value:.4g}: {reason}"
            raise SceneError(f"{each.name}: must fit the readings between {each.low:.4g} and {each.high:.4g}; {came}")
