"""Combine what varies to the cases of a study: samples of ranges, derived keys, conditions.

Samples are points of the unit cube, a coordinate for each key: Sobol' points scrambled by the seed, of which the first
N are the same for any larger N; a Latin hypercube, which is another for each N; or Saltelli's design for indices of
sensitivity: N rows each of A and B (Sobol' points of twice the dimension), then of A with a column of B, for each key.
A. Saltelli et al., Computer Physics Communications 181 (2010) 259.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeGuard

import numpy as np
from scipy.stats import qmc

from sits_mech.batch.studies.expressions import Expression
from sits_mech.quantities import Array
from sits_mech.units import SceneError, shown, si_label, split_quantity

SAMPLED = ("sobol", "latin", "saltelli")
"""Ways to combine ranges to samples."""
MOST = 1_000_000  # cases of a study
_FORM = 'a list of different values, or a range { from = "1 mm", to = "5 mm" } with different ends in one unit'


def cube(combine: str, count: int, seed: int, keys: int) -> Array:
    """Return the points of the unit cube for so many samples, shape (cases, keys)."""
    if combine == "latin":
        return qmc.LatinHypercube(keys, rng=seed).random(count)
    wide = keys * (1 + (combine == "saltelli"))
    found = qmc.Sobol(wide, rng=seed).random_base2(math.ceil(math.log2(count)))[:count]
    if combine == "sobol":
        return found
    a, b = found[:, :keys], found[:, keys:]
    return np.concatenate([a, b, *(np.where(np.arange(keys) == key, b, a) for key in range(keys))])


def sampled(varied: Mapping[str, Any], points: Array) -> dict[str, list[Any]]:
    """Return the values of each key at points of the unit cube: within a range, or evenly of a list."""
    return {name: _along(name, item, points[:, k]) for k, (name, item) in enumerate(varied.items())}


def checked_count(combine: str, count: object, seed: object, keys: int) -> tuple[int, int]:
    """Return number and seed of samples; raise SceneError for what can be none."""
    if not is_whole(count, 1, MOST):
        raise SceneError(f"samples: must be given, a whole number from 1 to {MOST}, for {combine}; got {shown(count)}")
    if combine == "saltelli" and (count < 2 or count & (count - 1)):
        raise SceneError(f"samples: must be a power of two for saltelli; got {count}")
    whole = count * (keys + 2 if combine == "saltelli" else 1)
    if whole > MOST:
        raise SceneError(f"samples: must give at most {MOST} cases; got {whole}")
    if not is_whole(seed, 0):
        raise SceneError(f"seed: must be a whole number, zero or more; got {shown(seed)}")
    return count, seed


def is_whole(value: object, least: int, most: float = math.inf) -> TypeGuard[int]:
    """Tell whether a value is a whole number between two others."""
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def ends(name: str, item: Mapping[str, Any]) -> tuple[float, float, str] | None:
    """Return the ends of a range and their unit; None where they are the same or have two units."""
    (first, unit), (last, other) = (split_quantity(item[end], f"{name}.{end}") for end in ("from", "to"))
    return (first, last, unit) if unit == other and first != last else None


def written(numbers: Array, unit: str) -> list[Any]:
    """Return numbers of fifteen digits as a study file has them, with their unit."""
    rounded = [float(f"{number:.15g}") for number in numbers]
    return [f"{number!r} {unit}" for number in rounded] if unit else rounded


def _along(name: str, item: Any, shares: Array) -> list[Any]:
    """Return the values of a range, or of a list, at shares of it from 0 to 1."""
    if isinstance(item, list):
        return [item[int(share * len(item))] for share in shares]
    span = ends(name, item) if isinstance(item, dict) and set(item) == {"from", "to"} else None
    if span is None:
        raise SceneError(f"{name}: must be {_FORM}; got {shown(item)}")
    first, last, unit = span
    return written(first + (last - first) * shares, unit)


def derived(
    points: Sequence[dict[str, Any]], derive: Mapping[str, Expression], where: Sequence[Expression],
    known: Callable[[Mapping[str, Any]], Mapping[str, Any]],
) -> list[dict[str, Any]]:
    """Return points with their derived keys, without those that break a condition.

    `known` gives all that texts may name at a point but what the point has itself, in SI.
    """
    found = []
    for point in points:
        values, more = {**known(point), **{name: si_label(item) for name, item in point.items()}}, {}
        for name, text in derive.items():
            value = text(values)
            values[name] = more[name] = float(f"{value:.15g}") if isinstance(value, float) else value
        if all([text(values) for text in where]):
            found.append(point | more)
    if not found:
        raise SceneError(f"where: must leave a case at least; all {len(points)} break a condition")
    return found
