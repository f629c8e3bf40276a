"""Hold a calibration in integers: its map, domain and starting points in fixed point.

    code_c(x) = base_c + 2^-f sum_k a_kc prod_i T_{k_i}(x_i),    a whole numbers of 32 bits, x of b fractional bits

b and f are the most for which no sum, no product and no recurrence of the header (``firmware.h.in``) leaves 62 bits for
any forces within the reach of the inverse (`readout.inversion`). Everything else is that inverse's own, rounded:
directions and span of the readings, half-spaces around the loads, nodes with an answer. It starts from every node of a
fine grid; the header from a few of them, with steps that are halved until they lead nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array, Integers
from sits_mech.readout.calibration import Calibration
from sits_mech.readout.inversion import EXACT, INCONSISTENT, REACH
from sits_mech.scene.sensor import SceneError

FACET_BITS, WEIGHT_BITS, SLOPE_BITS, IMAGE_BITS, SEED_STEPS = 28, 20, 20, 12, 64  # after the point; of a cell
_MOST = 62  # bits of a number of the header
_BITS, _FRACTION = 28, 24  # the most of forces and of codes, of which a part of 12 bits changes by few
_SETTLED = 4  # change of codes by the last step, in the last bits, or twice what rounding is worth
_STRIDE = {1: 8, 2: 8, 3: 5}  # of the fine grid, for starting points
_FEW = 16  # starting points of a part that no strided node lies in


@dataclass(frozen=True)
class FixedPoint:
    """A calibration in codes as integers."""

    cal: Calibration  # its "inductances" are codes
    bits: int  # fractional bits of forces from -1 to 1
    fraction: int  # fractional bits of codes
    base: Integers  # (n,) code that each coil's polynomials count from
    power: Integers  # (k, d) degrees of each term, in lexical order
    ends: Integers  # (k,) how many of the nested sums end with the term
    coefficient: Integers  # (k, n) [2^-fraction codes]
    weight: Integers  # (n,) of each coil in the least squares
    tolerance: Integers  # (n,) residual of an answer [2^-fraction codes]
    far: Integers  # (n,) farthest code from the base [2^-fraction codes]
    direction: Integers  # (d, n) leading directions of the readings
    span: Integers  # (d, 3) middle, least and greatest along them
    down: Integers  # (d,) bits down to those of `image`
    seed: Integers  # (s, d) starting points
    image: Integers  # (s, d) where they lie along the directions
    first: Integers  # (parts + 1,) the first of each part of the domain
    facet: Integers  # (f, d + 1) half-spaces around the loads
    nodes: Integers  # (d,) a grid
    valid: Integers  # (bytes,) bits of its nodes that have an answer
    settled: int  # change of codes by the last step [2^-fraction codes]
    merit: int  # bits that the weighted residual loses before it is squared
    error: float  # of the integers against the map, at most [codes]


def fixed_point(cal: Calibration) -> FixedPoint:
    """Return a calibration in codes as integers; raise SceneError when codes change by more than those hold."""
    order = np.lexsort(cal.map.powers.T[::-1])
    power, above = cal.map.powers[order], cal.map.coefficients[order].copy()
    base = np.rint(above[0])
    above[0] -= base
    bits, fraction, most = _precision(power, above)
    one = 2.0**fraction
    coefficient = _whole(above * one)
    weight = np.maximum(np.rint(cal.weights / cal.weights.max() * 2**WEIGHT_BITS), 1).astype(np.int64)
    far = np.ceil((most + INCONSISTENT * cal.full_scale) * one).astype(np.int64)
    length = np.log2(float(np.max((far + most * one) * weight)))
    tolerance = (INCONSISTENT if len(base) > power.shape[1] else EXACT) * cal.full_scale
    direction, span, down = _directions(cal, base)
    seed, image, first = _starts(cal)
    flat = (cal.domain.labels == 1).ravel()
    lost = np.abs(above - coefficient / one).sum(axis=0) + 2.0**-bits * (power**2).sum(axis=1) @ np.abs(above)
    error = float(lost.max())  # [codes] of rounded coefficients, and of polynomials by rounded recurrences
    return FixedPoint(
        cal, bits, fraction, base.astype(np.int64), power, _ends(power), coefficient, weight,
        _whole(tolerance * one), far, direction, span, down, seed, image, first,
        _whole(np.unique(cal.domain.hull, axis=0) * 2**FACET_BITS),
        np.ones_like(power[0]) if flat.all() else np.array(cal.domain.labels.shape),
        np.array([1]) if flat.all() else np.packbits(flat, bitorder="little").astype(np.int64),
        max(_SETTLED, int(2.0 * error * one)),
        max(1, int(np.ceil(length - 0.5 * (_MOST - np.log2(len(base)))))), error,
    )


def _precision(power: Integers, above: Array) -> tuple[int, int, Array]:
    """Return the fractional bits of forces and codes, and how far each code gets from its base within the reach."""
    degree = int(power.max())
    k, angle = np.arange(degree + 1), np.arccosh(REACH)
    values, slopes = np.cosh(k * angle), k * np.sinh(k * angle) / np.sinh(angle)
    value, slope = (_MOST - np.log2(2.0 * REACH * each[max(degree - 1, 0)] + 1.0) for each in (values, slopes))
    bits = min(_BITS, int(value / 2), int(slope - SLOPE_BITS))  # of products in the recurrences
    most = np.abs(above).T @ np.prod(values[power], axis=1)
    sums = [most.max()]
    for i in range(power.shape[1]):
        others = np.prod(np.delete(values[power], i, axis=1), axis=1)
        sums.append((np.abs(above).T @ (slopes[power[:, i]] * others)).max())
    fraction = min(int(_MOST - 1 - bits - np.log2(max(sums))), int(30 - np.log2(np.abs(above).max())), _FRACTION)
    if fraction < 0:
        raise SceneError(f"--to c: must have codes that change by less than 2^30; got {np.abs(above).max():.3g}")
    return bits, fraction, np.asarray(most)


def _ends(power: Integers) -> Integers:
    """Return how many nested sums end with each term: those whose earlier degrees are others in the next."""
    count = power.shape[1]
    same = np.cumprod(power[1:] == power[:-1], axis=1).sum(axis=1)
    return np.append(count - 1 - same, count)


def _directions(cal: Calibration, base: Array) -> tuple[Integers, Integers, Integers]:
    """Return the leading directions of the readings, their middle and span, and the bits down to an image's."""
    middle, directions = cal.domain.whitening
    spare = int(np.ceil(np.log2(len(base))))
    bits = (_MOST - 32 - spare - np.ceil(np.log2(np.abs(directions).max(axis=0)))).astype(np.int64)
    scale = 2.0**bits
    span = np.vstack([(middle - base) @ directions, cal.domain.span]) * scale
    return _whole((directions * scale).T), _whole(span.T), bits - IMAGE_BITS


def _starts(cal: Calibration) -> tuple[Integers, Integers, Integers]:
    """Return starting points of every part of the domain, their images, and the first of each part."""
    top = np.array(cal.domain.labels.shape) - 1
    stride = _STRIDE.get(len(top), 4)
    found = []
    for part in cal.seeds:
        nodes = np.rint(0.5 * (part + 1.0) * top)
        kept = part[np.all(nodes % stride == 0, axis=1)]
        found.append(kept if len(kept) >= min(_FEW, len(part)) else part[:: -(-len(part) // _FEW)])
    seed = np.rint(np.concatenate(found) * SEED_STEPS)
    places = cal.domain.whitened(cal.map.value_and_slopes(seed / SEED_STEPS)[0]) * 2**IMAGE_BITS
    return seed.astype(np.int64), _whole(np.clip(places, -32767, 32767)), np.cumsum([0, *map(len, found)])


def _whole(values: Array) -> Integers:
    """Return numbers rounded."""
    return np.rint(values).astype(np.int64)
