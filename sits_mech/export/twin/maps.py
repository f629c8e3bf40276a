"""Fit the polynomials of a twin: its calibration's own, readings over poses, and where its inverse starts.

    y_c = b_c + sum_k a_kc prod_i T_{k_i}(x_i)        inductances [H] of all coils, then codes; x from -1 to 1

Over wrenches the terms are those of the calibration's maps, of inductances and of codes together, so that the twin
gives their digits. Over poses the magnetics is solved anew: at points that lie in the box of the table's poses as
Chebyshev's nodes do (x_i = cos pi u_i, u by Sobol, and the box's corners), with the terms of a total degree, by least
squares. Of the degrees with few enough terms the least is taken that predicts other points of the box to 1e-6 of the
range, or about as well as any; its largest miss there is the error. Components of the pose that the table does not move
have no map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from sits_mech.analysis.readings.bench import absolute, codes_of, table_poses
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.chain.models import loaded_model
from sits_mech.export.source import Source
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.maps.chebyshev import design_matrix
from sits_mech.maps.surrogate import SmoothMap
from sits_mech.quantities import POSE, WRENCH, Array, Pose, SolveFailed
from sits_mech.readout.calibration import Calibration
from sits_mech.readout.converter import FrontEnd
from sits_mech.readout.loads import fixed, varied, wrench_of
from sits_mech.readout.loads import points as rows_of

Powers = NDArray[np.int_]
_MOVES = 1e-12  # m or rad: what moves less is at rest
_TERMS = {1: 12, 2: 66, 3: 165, 4: 210, 5: 252, 6: 210}  # at most, by the number of components that move
_POINTS, _OTHERS = 2.5, 128  # points a term; those that tell the error
_AS_GOOD, _ENOUGH = 1.2, 1e-6  # of the least error, or of the range: within it the fewest terms win
_GUESS = {1: 8, 2: 7, 3: 5, 4: 3}  # total degree of what starts the inverse; 2 for more


@dataclass(frozen=True)
class TwinMap:
    """A polynomial map in the form of the twin; arrays as of `sensor.npz`."""

    powers: Powers  # (k, d) degrees of each term, the first of all zeros
    coefficients: Array  # (outputs, k), the first column zero: it is the base
    base: Array  # (outputs,)
    low: Array  # (d,) the box, in SI
    high: Array  # (d,)
    columns: Powers  # (d,) which of the six components vary
    fixed: Array  # (6,) what the others are
    error: Array  # (outputs,) largest error of predicting what is left out

    def arrays(self, name: str) -> dict[str, Array | Powers]:
        """Return the fields as arrays named `name`_field, the coefficients in both precisions."""
        found = {f"{name}_{key}": value for key, value in vars(self).items()}
        return found | {f"{name}_coefficients_float32": self.coefficients.astype(np.float32)}


def over_wrenches(source: Source, cal: Calibration, codes: Calibration | None) -> TwinMap:
    """Return the map of a calibration over wrenches: the terms of its inductances and codes together."""
    maps = [cal.map] if codes is None else [cal.map, codes.map]
    powers = np.unique(np.concatenate([each.powers for each in maps]), axis=0)
    coefficients = np.concatenate([_among(each, powers) for each in maps])
    held = np.array([fixed(source.data).get(name, 0.0) for name in WRENCH])
    columns = np.array([WRENCH.index(name) for name in cal.forces])
    for name in varied(source.data):  # one value alone
        if name not in cal.forces:
            held[WRENCH.index(name)] = float(source.data[name][0])
    error = np.concatenate([each.error for each in maps])
    return _based(powers, coefficients, (cal.low, cal.high), columns, held, error, len(cal.coils))


def over_poses(source: Source, codes: FrontEnd | None) -> tuple[TwinMap | None, str]:
    """Return the map of readings over the box of the table's poses, and a line about it; None where there is none."""
    poses = table_poses(source.data)
    poses = poses[np.isfinite(poses).all(axis=1)]
    low, high = poses.min(axis=0), poses.max(axis=0)
    moves = high - low > _MOVES
    columns = np.flatnonzero(moves)
    if not columns.size:
        return None, "no map of poses: the target does not move"
    held, d = 0.5 * (low + high), len(columns)
    held[~moves & (np.abs(held) < _MOVES)] = 0.0
    degrees = [each for each in range(1, 13) if len(total_degree(d, each)) <= _TERMS[d]]
    x, others = _nodes(d, int(_POINTS * len(total_degree(d, degrees[-1]))))
    at = np.tile(held, (len(x) + len(others), 1))
    at[:, columns] = 0.5 * (np.concatenate([x, others]) * (high - low)[columns] + (high + low)[columns])
    try:
        y = readings_at(source, Pose.of(at), codes)
    except (Collision, SolveFailed) as reason:
        return None, f"no map of poses: the box of the table's poses holds one that cannot be ({reason})"
    known, asked, scale = y[: len(x)], y[len(x) :], np.ptp(y, axis=0)
    fits = {degree: _fitted(x, known, total_degree(d, degree)) for degree in degrees}
    off = {degree: np.abs(design_matrix(others, total_degree(d, degree)) @ fit - asked) for degree, fit in fits.items()}
    worst = {degree: float((miss / scale).max()) for degree, miss in off.items()}
    most = max(_AS_GOOD * min(worst.values()), _ENOUGH)
    best = next(degree for degree in degrees if worst[degree] <= most)
    powers, error = total_degree(d, best), off[best].max(axis=0)
    moved, count = ", ".join(POSE[k] for k in columns), len(others)
    found = _based(powers, fits[best].T, (low[columns], high[columns]), columns, held, error, len(source.sensor.coils))
    return found, f"poses: {len(powers)} terms over {moved}, within {worst[best]:.1e} of the range at {count} others"


def readings_at(source: Source, pose: Pose, front: FrontEnd | None) -> Array:
    """Return L [H] and, with a converter, codes at poses, shape (m, n) or (m, 2 n); raise Collision, SolveFailed."""
    sensor, request = source.sensor, source.request
    check_clearance(sensor, pose)
    loads = [wrench_of(row) for row in rows_of(source.data)]
    model, _ = loaded_model(sensor, request["magnetics"], request["tolerance"], loads)
    found, _ = absolute(sensor, model.impedance(pose, sensor.frequency))
    own = np.diagonal(found.L, axis1=-2, axis2=-1)
    seen = at_terminals(sensor, found)[0] if front is not None else None
    return own if front is None or seen is None else np.hstack([own, codes_of(sensor, front, seen.L, seen.R)])


def guess_of(cal: Calibration, base: Array, scale: Array) -> tuple[TwinMap, Array]:
    """Return a map from readings to scaled forces that starts Newton's method, and its directions (d, n + 1).

    Its x are the directions' sums of readings less the base over `scale`, and their last number.
    """
    seeds = cal.seeds[0]
    off = (cal.map.value_and_slopes(seeds)[0] - base) / scale
    towards = cal.domain.whitening[1] * scale[:, None]
    y = off @ towards
    low, high = y.min(axis=0), y.max(axis=0)
    directions = np.column_stack([(2.0 / (high - low))[:, None] * towards.T, -(high + low) / (high - low)])
    powers = total_degree(len(low), _GUESS.get(len(low), 2))
    fit = _fitted((2.0 * y - high - low) / (high - low), seeds, powers)
    d = len(low)
    found = _based(powers, fit.T, (-np.ones(d), np.ones(d)), np.arange(d), np.zeros(6), np.zeros(d), d)
    return found, directions


def total_degree(d: int, degree: int) -> Powers:
    """Return the degrees of all products of d variables up to a total degree, shape (k, d), in lexical order."""
    return np.array([powers for powers in product(range(degree + 1), repeat=d) if sum(powers) <= degree])


def _fitted(x: Array, y: Array, powers: Powers) -> Array:
    """Return coefficients (k, outputs) by least squares, each output of its own size."""
    scale = np.maximum(np.abs(y).max(axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(design_matrix(x, powers), y / scale, rcond=None)[0] * scale)


def _nodes(d: int, count: int) -> tuple[Array, Array]:
    """Return points for a fit, as Chebyshev's nodes and the corners, and evenly spread others."""
    u = qmc.Sobol(2 * d, scramble=False).random_base2(int(np.ceil(np.log2(max(count, _OTHERS) + 1))))
    corners = np.array(list(product((-1.0, 1.0), repeat=d)))
    near = np.cos(np.pi * u[1 : count + 1, :d])
    return np.vstack([corners, near]), 2.0 * u[1 : _OTHERS + 1, d:] - 1.0


def _among(found: SmoothMap, powers: Powers) -> Array:
    """Return the coefficients of a map (n, k) among terms that hold all of its own."""
    place = {tuple(row): k for k, row in enumerate(powers.tolist())}
    wide = np.zeros((found.coefficients.shape[1], len(powers)))
    wide[:, [place[tuple(row)] for row in found.powers.tolist()]] = found.coefficients.T
    return wide


def _based(
    powers: Powers, coefficients: Array, box: Sequence[Array], columns: Powers, held: Array, error: Array, coils: int
) -> TwinMap:
    """Return a map whose constant is its base, in codes (of outputs beyond the coils) a whole number."""
    a, base = coefficients.copy(), coefficients[:, 0].copy()
    base[coils:] = np.rint(base[coils:])
    a[:, 0] -= base
    return TwinMap(powers, a, base, box[0], box[1], columns, held, error)
