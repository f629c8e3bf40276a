"""Calculate the errors of forces by tolerances of the sensor: thickness, modulus, gap and coil offset.

A sensor that is a little off shows L' where the calibrated one shows L; read by the calibration, and tared at rest,

    error of the forces = A (dL(F) - dL(0)),    dL = L' - L,    A the slopes of the calibration's own inverse.

Only the layer's thickness and modulus need it solved anew, and the modulus only at F / s (see `comparison`); a gap
lifts every pose, an offset of the coils along x shifts it. Neglected: tilt of the target as made, and its size.

`spread` is numbers only. Independent normal deviations x_i of size s_i; a costly function y(x) is asked at a few points
of a Sobol sequence within three s_i, a polynomial (`surrogate`) goes through them, and of the polynomial, at 2^12 of a
sequence,

    mean, standard deviation, 2.5 % and 97.5 % quantiles of y;
    Sobol's shares: first-order V(E(y | x_i)) / V(y), total 1 - V(E(y | all but x_i)) / V(y)      (Saltelli 2010)

Shares add up to one where the deviations act apart; total over first-order says how much they act together. What the
polynomial misses stands beside them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.stats import norm, qmc, sobol_indices

from sits_mech.analysis.readings.bench import sensor_calibration
from sits_mech.cases import Progress, no_progress
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.geometry.collision import Collision
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import POSE, Array, Pose, SolveFailed, Wrench
from sits_mech.readout.calibration import Calibration
from sits_mech.readout.loads import fixed, request_of, varied
from sits_mech.scene.sensor import SceneError, Sensor

_WIDTH = 3.0  # standard deviations that the design covers
_STILL = 1e-9  # of an answer: what scatters less may be rounding


@dataclass(frozen=True)
class Spread:
    """Scatter of q answers under p tolerances."""

    names: tuple[str, ...]  # of the tolerances
    mean: Array  # (q,)
    deviation: Array  # standard, (q,)
    interval: Array  # (q, 2), 2.5 % and 97.5 % quantiles
    first: Array  # (q, p), shares of the variance; nan if it is zero
    total: Array  # (q, p)
    map_error: Array  # (q,), root mean square at points left out
    failed: int  # points without answers, whose part of the box is that of the nearest ones


def evaluation_points(deviations: ArrayLike, count: int) -> Array:
    """Return the deviations at which to evaluate, (count, p), the first zero; a power of two fills the box evenly."""
    s, power = np.asarray(deviations, dtype=float), int(np.ceil(np.log2(count)))
    unit = qmc.Sobol(len(s), rng=np.random.default_rng(0)).random_base2(power)[: count - 1]
    return np.vstack([np.zeros((1, len(s))), _WIDTH * s * (2.0 * unit - 1.0)])


def spread(names: Sequence[str], deviations: ArrayLike, points: ArrayLike, values: ArrayLike) -> Spread:
    """Return mean, scatter and shares of answers (m, q), where finite, at `evaluation_points` (m, p); or ValueError."""
    s, x, y = (np.asarray(item, dtype=float) for item in (deviations, points, values))
    good = np.isfinite(y).all(axis=1)
    found = fit_map(names, x[good], y[good], simplex=len(s) > 2)
    unit = qmc.Sobol(len(s), rng=np.random.default_rng(0)).random_base2(12)  # of the module docstring
    drawn = found.at(_within(found, norm.ppf(np.clip(unit, 1e-9, 1.0 - 1e-9)) * s))
    first, total = _shares(found, s, len(unit))
    return Spread(
        tuple(names), drawn.mean(axis=0), drawn.std(axis=0), np.quantile(drawn, [0.025, 0.975], axis=0).T, first, total,
        found.rms, int(np.sum(~good)),
    )


def _within(found: SmoothMap, points: Array) -> Array:
    """Clip points (m, p) to the box of the map: 0.3 % of a normal deviation lie beyond it."""
    return np.clip(points, found.low, found.high)


def _shares(found: SmoothMap, s: Array, samples: int) -> tuple[Array, Array]:
    """Return first-order and total shares, shape (q, p) each."""
    q = found.coefficients.shape[1]
    first, total = np.full((2, q, len(s)), np.nan)
    scale = np.ptp(found.at(_within(found, evaluation_points(s, 64))), axis=0)
    moves = np.flatnonzero(scale > _STILL * np.maximum(np.abs(found.at(np.zeros(len(s)))), 1e-300))
    if moves.size == 0:
        return first, total

    def answers(x: Array) -> Array:
        """Return answers (q, m) at deviations (p, m)."""
        return np.asarray((found.at(_within(found, x.T))[:, moves] / scale[moves]).T)

    dists = [norm(scale=size) for size in s]
    indices = sobol_indices(func=answers, n=samples, dists=dists, rng=np.random.default_rng(0))
    first[moves] = np.asarray(indices.first_order).reshape(len(moves), -1)
    total[moves] = np.asarray(indices.total_order).reshape(len(moves), -1)
    return first, total


TOLERANCES = ("thickness", "modulus", "gap", "offset")
"""Standard deviations: of the layer [m], of the modulus over its own [-], of the gap [m], of the coils along x [m]."""


@dataclass(frozen=True)
class ForceSpread:
    """Errors of the forces by tolerances."""

    loads: Array  # (k, d) [N]
    forces: tuple[str, ...]
    spread: Spread  # of the errors [N], in the order loads times forces, without sensors that failed

    def table(self) -> xr.Dataset:
        """Return deviation, interval and shares over (load, force), the shares also over the cause."""
        shape = (len(self.loads), len(self.forces))
        found, dims = self.spread, ("load", "force")
        return xr.Dataset(
            {
                "deviation": (dims, found.deviation.reshape(shape)),
                "low": (dims, found.interval[:, 0].reshape(shape)),
                "high": (dims, found.interval[:, 1].reshape(shape)),
                "first": ((*dims, "cause"), found.first.reshape(*shape, -1)),
                "total": ((*dims, "cause"), found.total.reshape(*shape, -1)),
                **{name: ("load", self.loads[:, k]) for k, name in enumerate(self.forces)},
            },
            coords={"force": list(self.forces), "cause": list(found.names)},
        )


def force_spread(
    sensor: Sensor, data: xr.Dataset, deviations: Mapping[str, float], loads: Sequence[Sequence[float]], *,
    samples: int = 64, progress: Progress = no_progress,
) -> ForceSpread:
    """Return the errors of forces by tolerances at some loads.

    `deviations` are standard deviations of `TOLERANCES`; `loads` hold all components that the table varies, in its
    order [N, N m]; `samples`, the sensors to solve, is a power of two. Raises SceneError for an unknown tolerance, a
    deviation that is not positive or of which three leave no sensor, too few samples, or where no load has readings of
    its own.
    """
    wrong = [name for name in deviations if name not in TOLERANCES]
    if wrong or not deviations:
        raise SceneError(f"tolerance: must be some of {', '.join(TOLERANCES)}; got {', '.join(wrong) or 'none'}")
    _check_deviations(sensor, deviations, samples)
    cal = sensor_calibration(sensor, data)
    if cal.share == 0.0:
        every = ", ".join(cal.forces)
        raise SceneError(f"tolerance: needs a table with an inverse; the coils do not resolve all of {every}")
    asked = np.vstack([np.zeros((1, len(cal.forces))), np.asarray(loads, dtype=float)])  # the first one is tared
    held = fixed(data.isel({name: 0 for name in varied(data) if name not in cal.forces}))
    wrenches = [Wrench(**held | dict(zip(cal.forces, load, strict=True))) for load in asked.tolist()]
    points = evaluation_points(list(deviations.values()), samples)
    request = request_of(data)
    layer = cache(partial(_settled, sensor, wrenches, (request["mechanics"], request["tolerance"])))
    poses = []
    for number, point in enumerate(points):
        at = dict.fromkeys(TOLERANCES, 0.0) | dict(zip(deviations, point.tolist(), strict=True))
        poses.append(layer(at["thickness"], at["modulus"]) + Pose(-at["offset"], at["gap"]).components)
        progress(number + 1, len(points))
    L = _relative(sensor, np.array(poses), (request["magnetics"], request["tolerance"])) * cal.L0
    off = L - L[:1]
    errors = np.einsum("kdn,mkn->mkd", cal.answers(asked[1:]), off[:, 1:] - off[:, :1])
    found = spread(tuple(deviations), list(deviations.values()), points, errors.reshape(len(points), -1))
    return ForceSpread(asked[1:], cal.forces, found)


def _check_deviations(sensor: Sensor, deviations: Mapping[str, float], samples: int) -> None:
    """Refuse deviations of which three leave no layer, or hardly any modulus, and too few samples for them."""
    thickness = 0.0 if sensor.elastomer is None else sensor.elastomer.thickness
    most = {"thickness": thickness / _WIDTH, "modulus": 0.9 / _WIDTH}  # a tenth of it is left
    for name, size in deviations.items():
        if not 0.0 < size < most.get(name, np.inf):
            below = f" below {most[name]:.3g}" if name in most else ""
            raise SceneError(f"{name}: must be a positive deviation{below}; got {size:g}")
    if samples < 2 * len(deviations) + 2:
        raise SceneError(
            f"samples: must be at least {2 * len(deviations) + 2} for {len(deviations)} tolerances; got {samples}"
        )


def loads_inside(cal: Calibration) -> Array:
    """Return loads (k, d) inside a table: its middle, all but F_z nearer to their ends, and F_z at its end besides."""
    normal = np.array([name == "F_z" for name in cal.forces])
    shares = np.unique([np.where(normal, down, side) for side, down in ((0.5, 0.5), (0.75, 0.5), (0.75, 1.0))], axis=0)
    return np.asarray(cal.low + (cal.high - cal.low) * shares)


def _settled(
    sensor: Sensor, loads: Sequence[Wrench], model: tuple[str, float], thicker: float, stiffer: float
) -> Array:
    """Return the poses (k, 6) of a layer of another thickness and modulus; NaN where a load fails."""
    if sensor.elastomer is None:
        raise SceneError(f"{sensor.name}: elastomer: must be given; it is missing")
    layer = sensor.elastomer.of_thickness(sensor.elastomer.thickness + thicker)
    solver, _ = mechanical_model(sensor.model_copy(update={"elastomer": layer}), *model)
    found, start = np.full((len(loads), len(POSE)), np.nan), None
    for k, load in enumerate(loads):
        try:
            start = solver.equilibrium(Wrench(*(load.components / (1.0 + stiffer)).tolist()), start=start)
        except SolveFailed:
            continue
        found[k] = start.pose.components
    return found


def _relative(sensor: Sensor, poses: Array, model: tuple[str, float]) -> Array:
    """Return L over L0 at poses (m, k, 6), shape (m, k, n)."""
    flat = poses.reshape(-1, len(POSE))
    good = np.isfinite(flat).all(axis=1)
    try:
        shown = loaded_model(sensor, model[0], model[1])[0].impedance(Pose.of(flat[good]), sensor.frequency)
    except Collision as reason:
        raise SceneError(f"gap, thickness: three deviations must leave the target clear; {reason}") from None
    L = np.full((len(flat), len(sensor.coils)), np.nan)
    L[good] = np.diagonal(shown.L, axis1=-2, axis2=-1) / np.diagonal(shown.L0)
    return L.reshape(*poses.shape[:-1], -1)
