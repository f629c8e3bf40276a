"""Predict what a changed scene shows before it is solved, from tables that were, over one grid of loads.

A coil's own inductance is L = L_0 + f, L_0 in free space. With x_k = ln(p_k/p_0k) of each number p_k that was changed,

    f(p) = f(p_0) exp(sum_k h_k(x_k)),    other numbers y(p) = y(p_0) + sum_k g_k(x_k),

h_k and g_k the polynomials in Newton's form through the tables that differ from the first one in p_k alone, and through
their slopes by p_k where these are known. What that leaves open is guessed: of each polynomial its first missing term,

    |c| prod_i |x - x_i| / l,    c its last divided difference, l the change of ln p that doubles a curve's last term,

of two numbers the terms of both: of what hangs on one combination of them (what the pad stands out beside the target),
whose own terms of order n are a and b, (a^(1/n) + b^(1/n))^n - a - b. Neglected: contact that sets in between.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.chain.propagation import signal_weights
from sits_mech.quantities import POSE, Array
from sits_mech.readout.loads import varied
from sits_mech.readout.signals import rows_of, shown_signals, signals
from sits_mech.scene.parameters import numbers_of
from sits_mech.scene.sensor import Sensor

_DOUBLES = 0.15  # l: a tenth of the target's width misses 0.56 of its change (0.19), 15 % of the thickness 0.1 (1.6)
_LEAST = 1e-3  # of f: where a coil hardly sees the target, its logarithm tells nothing
_COILS = ("coil", "coil_2")


@dataclass(frozen=True)
class SolvedScene:
    """A scene with its table, and derivatives by some of its numbers where they are known: see `gradient_on_grid`."""

    sensor: Sensor
    data: xr.Dataset
    slopes: xr.Dataset | None = None

    @cached_property
    def numbers(self) -> dict[str, Any]:
        """What the scene gives, by dotted key."""
        return numbers_of(self.sensor)

    @cached_property
    def shown(self) -> tuple[Array, Array]:
        """Each coil's f of the module docstring, (loads, n), and other numbers: pose, R, L, (loads, 6 + 2 n n)."""
        L, R = (self.flat(self.data[name]) for name in ("L", "R"))
        pose = [self.flat(self.data[name]) for name in self.pose]
        f = np.einsum("lii->li", L) - np.diagonal(self.data["L0"].to_numpy())
        return f, np.column_stack([*pose, R.reshape(len(f), -1), L.reshape(len(f), -1)])

    def changes(self, key: str) -> tuple[Array, Array] | None:
        """Return the derivatives of `shown` by ln of a number; None where they are not known."""
        if self.slopes is None or key not in self.slopes["parameter"]:
            return None
        by, value = self.slopes.sel(parameter=key), self.numbers[key]
        L, R = (value * self.flat(by[f"by_{name}"]) for name in ("L", "R"))
        pose = value * self.flat(by["by_pose"])[:, [POSE.index(name) for name in self.pose]]
        return np.einsum("lii->li", L), np.column_stack([pose, R.reshape(len(R), -1), L.reshape(len(L), -1)])

    @property
    def pose(self) -> list[str]:
        """The components of the pose that the table has."""
        return [name for name in POSE if name in self.data]

    def flat(self, part: xr.DataArray) -> Array:
        """Return values with all loads in one axis, the first."""
        loads = varied(self.data)
        rest = [str(dim) for dim in part.dims if dim not in loads]
        values = part.transpose(*loads, *sorted(rest)).to_numpy()
        return values.reshape(-1, *values.shape[len(loads) :])


def preview(base: SolvedScene, others: Sequence[SolvedScene], sensor: Sensor) -> xr.Dataset | None:
    """Return the table of a changed scene as it is expected, errors with what is guessed; None where nothing tells.

    `others` are tables over the loads of `base`.
    """
    now = numbers_of(sensor)
    changed = _differ(base.numbers, now)
    if changed is None:
        return None
    f, rest = base.shown
    factors, added, orders = [], [], []
    left_f, left = np.zeros(f.shape), np.zeros(rest.shape)
    for key in changed:
        nodes = [each for each in others if _differ(base.numbers, each.numbers) == [key]]
        slopes, x = base.changes(key), float(np.log(now[key] / base.numbers[key]))
        if not nodes and slopes is None:
            return None
        at = [float(np.log(each.numbers[key] / base.numbers[key])) for each in nodes]
        logs = [np.log(np.maximum(each.shown[0] / f, _LEAST)) for each in nodes]
        moved = [each.shown[1] - rest for each in nodes]
        h, terms_h = _newton(x, at, logs, None if slopes is None else slopes[0] / f)
        g, terms_g = _newton(x, at, moved, None if slopes is None else slopes[1])
        factors.append(h)
        added.append(g)
        orders.append((terms_h, terms_g))
        left_f += terms_h[-1] * np.abs(f)
        left += terms_g[-1]
    for one, other in combinations(orders, 2):
        left_f += _of_both(one[0], other[0]) * np.abs(f)
        left += _of_both(one[1], other[1])
    more = f * np.expm1(sum(factors, np.zeros(f.shape)))
    return _table(base, sensor, (f + more, left_f), (sum(added, rest), left))


def _differ(first: Mapping[str, Any], other: Mapping[str, Any]) -> list[str] | None:
    """Return the keys of positive numbers by which scenes differ; None where they differ by more."""
    if first.keys() != other.keys():
        return None
    keys = [key for key in first if first[key] != other[key]]
    numbers = all(isinstance(each[key], float) and each[key] > 0.0 for key in keys for each in (first, other))
    return keys if numbers else None


def _newton(x: float, at: Sequence[float], changes: Sequence[Array], slope: Array | None) -> tuple[Array, list[Array]]:
    """Return a change at x by changes at places and the slope at zero, and its terms by order, the open one last."""
    order = sorted(range(len(at)), key=lambda k: -abs(at[k] - x))
    places = [0.0] * (1 if slope is None else 2) + [at[k] for k in order]
    zero = np.zeros_like(slope if slope is not None else changes[0])
    rows = [zero] * (1 if slope is None else 2) + [changes[k] for k in order]
    c = [rows[0]]
    for level in range(1, len(places)):
        rows = [
            slope if slope is not None and places[k + level] == places[k] == 0.0
            else (rows[k + 1] - rows[k]) / (places[k + level] - places[k])
            for k in range(len(rows) - 1)
        ]
        c.append(rows[0])
    powers = [c[-1]]  # of x, by Horner's rule
    for place, term in zip(places[-2::-1], c[-2::-1], strict=True):
        powers = [low - place * high for low, high in zip([zero, *powers], [*powers, zero], strict=True)]
        powers[0] = powers[0] + term
    left = np.abs(c[-1] * np.prod([x - place for place in places])) / _DOUBLES
    found = sum((own * x**n for n, own in enumerate(powers)), zero)
    return found, [np.abs(own * x**n) for n, own in enumerate(powers)] + [left]


def _of_both(one: Sequence[Array], other: Sequence[Array]) -> Array:
    """Return the terms of two numbers together by those of each, from the second order on."""
    found = np.zeros_like(one[0])
    for n, (a, b) in enumerate(zip(one[2:], other[2:], strict=False), 2):
        found = found + (a ** (1.0 / n) + b ** (1.0 / n)) ** n - a - b
    return found


def _table(base: SolvedScene, sensor: Sensor, own: tuple[Array, Array], rest: tuple[Array, Array]) -> xr.Dataset:
    """Return the first table with other numbers, as of `SolvedScene.shown`, each with what is left open of it."""
    loads, found = varied(base.data), {}
    shape, L0 = tuple(base.data.sizes[name] for name in loads), np.diagonal(base.data["L0"].to_numpy())
    n, count = len(L0), len(base.pose)

    def put(name: str, values: Array, dims: tuple[str, ...] = ()) -> None:
        """Hold a variable over all loads."""
        found[name] = ((*loads, *dims), values.reshape(*shape, *values.shape[1:]))

    for k, name in enumerate(base.pose):
        put(name, rest[0][:, k])
        put(f"error_{name}", base.flat(base.data[f"error_{name}"]) + rest[1][:, k])
    for name, first in (("R", count), ("L", count + n * n)):
        values, left = (part[:, first : first + n * n].reshape(-1, n, n) for part in rest)
        if name == "L":
            values[:, range(n), range(n)], left[:, range(n), range(n)] = L0 + own[0], own[1]
        put(name, values, _COILS)
        put(f"error_{name}", base.flat(base.data[f"error_{name}"]) + left, _COILS)
    weights = signal_weights(sensor)
    for name, shown in signals(L0 + own[0], L0, weights, own[1] @ np.abs(rows_of(weights)).T).known.items():
        put(name, base.flat(base.data[name]) + shown if name.startswith("error_") else np.asarray(shown))
    return base.data.assign(found)


def open_share(data: xr.Dataset) -> float:
    """Return the largest error of a signal of a table, over the range of all."""
    names = [name for name in shown_signals(data) if name in data]
    ranges = max(float(np.nanmax(data[name]) - np.nanmin(data[name])) for name in names)
    return max(float(np.nanmax(data[f"error_{name}"])) for name in names) / ranges
