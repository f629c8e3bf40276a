"""Reduce what a unit differs by from its calibration to a few constants of the firmware.

    x_i = c_i + o_i + g_i (c_i - b_i),    f = inverse(x),    F = q + Q f,

c the unit's codes, b those the header counts from (export/fixed_point.py), the inverse that of the calibrated sensor. A
factor s of the modulus alone is Q = s 1, a lead or a capacitance o and g; a gap, an offset or a tilt, which mostly
change each coil's curve as a line would, are shared out between all. The numbers are the least squares of F over the
forces of the table, each over its range, from Q = s 1 and each coil's own straight line;

    dF = Q A dx + dq + dQ f,    A = (W x_f)^+ W,    W = 1/noise.

What they leave is `left`: of 16 sensors with gap, offset and tilt by `unknowns.USUAL` 0.1 to 0.7 % of the range
on 90 % of loads (`biorob2018-w15`; one that is softer by 28 % and turned 1.1 %), where a tare leaves 7 to 42 %.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.analysis.readings.bench import code_calibration, loads_over
from sits_mech.analysis.readings.codes import unit_codes
from sits_mech.quantities import Array
from sits_mech.readout.calibration import Calibration

_ACROSS = {1: 9, 2: 5}  # loads along each force, of more forces 4
_SHARE = 0.85  # of the table's range, from no load on: what units are fitted over
_HELD = 10.0  # weight of forces beyond `BEYOND` over that of errors
BEYOND = 0.08
"""Of the table's range: how far forces f may lie beyond it, where the map can be followed (firmware's reach is 0.1)."""
_STEPS, _NEWTON = 30, 8  # of the numbers, and of each inverse
_SETTLED, _CHANGE = 1e-5, 0.1  # of the ranges: a change that ends an inverse; usual size of changes of the numbers


@dataclass(frozen=True)
class Constants:
    """Numbers of a unit, as of the module docstring."""

    base: Array  # b, (n,) [codes]
    offset: Array  # o, (n,) [codes]
    gain: Array  # g, (n,)
    rest: Array  # x without load, (n,) [codes]
    shift: Array  # q, (d,) [N, N m]
    factor: Array  # Q, (d, d) [SI]
    left: Array  # of 90 % of forces, over their ranges, (d,)

    def codes(self, own: Array) -> Array:
        """Return x of the unit's codes (..., n)."""
        return own + self.offset + self.gain * (own - self.base)

    def forces(self, f: Array) -> Array:
        """Return F of the calibrated sensor's forces (..., d) at x."""
        return self.shift + f @ self.factor.T


def as_computed(cal: Calibration) -> Constants:
    """Return the numbers of the sensor as it is calibrated."""
    rest, d = cal.map.at(cal.rest), len(cal.forces)
    none = np.zeros_like(rest)
    return Constants(np.rint(cal.map.coefficients[np.all(cal.map.powers == 0, axis=1)][0]), none, none, rest,
                     np.zeros(d), np.eye(d), np.zeros(d))


def constants_of(found: Adaptation, cal: Calibration | None = None) -> Constants:
    """Return the numbers of a unit; `cal` is the calibration in codes, where it is at hand.

    Raises SceneError without a converter, ValueError as `code_calibration`.
    """
    prior = found.prior
    cal = cal or code_calibration(prior.sensor, prior.data)
    s = float(found.values[found.names.index("modulus")]) if "modulus" in found.names else 1.0
    f = _grid(cal)
    own = unit_codes(prior.sensor, prior.data, prior.bench(s * f).model(prior.used(found.values)[None])[0])
    seen = np.all(np.isfinite(own), axis=1)
    f, own = f[seen], own[seen]
    first = as_computed(cal)
    offset, gain = _lines(cal, first.base, f, own)
    first = replace(first, offset=offset, gain=gain, factor=s * first.factor)
    return _fitted(cal, first, f, own, s)


def _grid(cal: Calibration) -> Array:
    """Return forces over the table, (m, d)."""
    count = _ACROSS.get(len(cal.forces), 4)
    edge = 0.5 * (1.0 - _SHARE) * (cal.high - cal.low)
    return loads_over(np.minimum(cal.low + edge, np.maximum(cal.low, 0.0)), cal.high - edge, count)


def _lines(cal: Calibration, base: Array, f: Array, own: Array) -> tuple[Array, Array]:
    """Return offset and gain of each coil that bring its codes nearest to the calibrated sensor's, (n,) each."""
    off, middle = cal.map.at(f) - own, own.mean(axis=0)
    gain = np.sum((own - middle) * off, axis=0) / np.maximum(np.sum((own - middle) ** 2, axis=0), 1e-300)
    return off.mean(axis=0) - gain * (middle - base), gain


def _fitted(cal: Calibration, first: Constants, f: Array, own: Array, s: float) -> Constants:
    """Return the least squares from first numbers, for codes (m, n) of forces s f (m, d)."""
    ranges, scale, place = cal.high - cal.low, cal.full_scale, f
    (m, d), n = f.shape, own.shape[1]
    ends = cal.low - BEYOND * ranges, cal.high + BEYOND * ranges

    def constants(x: Array) -> Constants:
        """Return the numbers for their changes, over ranges."""
        o, g, q, Q = np.split(x, np.cumsum([n, n, d]))
        factor = first.factor + ranges[:, None] * Q.reshape(d, d) / ranges
        return replace(first, offset=first.offset + scale * o, gain=first.gain + g, shift=ranges * q, factor=factor)

    def residual(x: Array) -> Array:
        """Return errors of forces over ranges, then how far f is beyond its ends, (2 m d,)."""
        nonlocal place
        here = constants(x)
        place = np.clip(inverse(cal, here.codes(own), place)[0], cal.low - ranges, cal.high + ranges)
        off, beyond = (here.forces(place) - s * f) / ranges, (place - np.clip(place, *ends)) / ranges
        return np.concatenate([off.ravel(), _HELD * beyond.ravel()])

    def slopes(x: Array) -> Array:
        """Return their derivatives, (2 m d, 2 n + d + d^2)."""
        here = constants(x)
        A = inverse(cal, here.codes(own), place)[1] * scale / ranges[:, None]  # of f over its range, (m, d, n)
        by = np.concatenate([A, A * ((own - here.base) / scale)[:, None, :]], axis=-1)
        turned, none = (here.factor / ranges[:, None] * ranges) @ by, np.zeros((m, d, d + d * d))
        factor = np.einsum("ij,mk->mijk", np.eye(d), place / ranges).reshape(m, d, d * d)
        off = np.concatenate([turned, np.tile(np.eye(d), (m, 1, 1)), factor], axis=-1)
        held = _HELD * ((place < ends[0]) | (place > ends[1]))[..., None] * np.concatenate([by, none], axis=-1)
        return np.concatenate([off, held]).reshape(2 * m * d, -1)

    best = least_squares(residual, np.zeros(2 * n + d + d * d), jac=slopes, x_scale=_CHANGE, ftol=1e-3, max_nfev=_STEPS)
    kept = constants(best.x)
    left = np.quantile(np.abs(best.fun[: m * d].reshape(m, d)), 0.9, axis=0) / s
    return replace(kept, rest=cal.map.at(np.linalg.solve(kept.factor, -kept.shift)), left=left)


def inverse(cal: Calibration, codes: Array, start: Array) -> tuple[Array, Array]:
    """Return the forces (m, d) of the calibrated sensor at codes (m, n), and A of the module docstring, (m, d, n)."""
    f = start
    for _ in range(_NEWTON):
        A = np.linalg.pinv(cal.weights[:, None] * cal.map.slopes(f)) * cal.weights
        step = np.einsum("mdn,mn->md", A, codes - cal.map.at(f))
        f = f + step
        if np.max(np.abs(step) / (cal.high - cal.low)) < _SETTLED:
            break
    return f, A
