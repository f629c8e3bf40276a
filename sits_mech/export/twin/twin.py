"""Read out a calibrated sensor and estimate what pressed on it: one file, numpy alone, batches of sensors at once.

    twin = Twin.load("sensor.npz")
    reading = twin.read(wrench)                      (n, 6) -> L (n, coils) [H], codes (n, coils), flags (n,)
    reading = twin.read_pose(pose)                   the same of the target's poses (n, 6) [m, rad]
    estimate = twin.estimate(reading.L)              wrench (n, 6) [N, N m], flags (n,); by codes: estimate_codes
    state = twin.start(n); state, reading = twin.step(state, wrench, dt)             the pad creeps
    state, estimate = twin.recover(state, L, dt)                                     and what creeps is undone

A wrench is F_x, F_z, M, F_y, M_x, M_z, F_z > 0 pressing down; a pose d_h, d_v, alpha, d_y, alpha_x, alpha_z. Maps are
sums of products of Chebyshev's polynomials,

    y_c = b_c + sum_k a_kc prod_i T_{k_i}(x_i),    x_i = (2 p_i - high_i - low_i)/(high_i - low_i) held within -1 and 1

and the inverse is Newton's method (least squares of more coils than forces) from a map of its own. In time the pad is
quasi-linear: it shows what the elastic pad shows under Q_e, and a wrench that is linear within each step gives exactly

    Q_e(t) = int C(t - s) dQ(s),    C(t) = 1 - sum_j c_j exp(-t/lambda_j);    Q(t) = int G(t - s) dQ_e(s) back.

Arrays stay what they are: the functions are those of the input's own namespace (`__array_namespace__`, or the module of
torch), in its precision. Nothing is kept between calls but what `step` returns; a NaN stays in it.

Neglected: softening after the largest load, rate of the converter, noise (`numbers` holds its size), temperature.
Made by sits-mech; BSD-3-Clause.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

WRENCH = ("F_x", "F_z", "M", "F_y", "M_x", "M_z")
POSE = ("d_h", "d_v", "alpha", "d_y", "alpha_x", "alpha_z")
OUTSIDE, IGNORED, UNSOLVED = 1, 2, 4
"""Flags, which add up: held at the domain's edge, NaN at its middle; a component that the map does not know is
not what it was in the calibration, and is ignored; no single wrench shows the reading, the estimate is NaN."""
FAULT_FLAGS, FAULT_FULL, FAULT_ZERO = 8, 16, 32
"""Besides `UNSOLVED`, of a coil that was not read: the part's error flags stand above a code; it is full scale (open,
or out of range); it is zero (shorted, or it does not swing)."""
_STEPS, _LONGEST, _REACH = 8, 0.3, 1.2  # of Newton's method, scaled: how many, how long, how far out
_SETTLED, _EDGE, _SAME = 1e-3, 1e-5, 1e-9  # the last step; beyond the domain; of a component that is ignored


class Reading(NamedTuple):
    """Inductances (n, coils) [H], codes (n, coils) as integers (none without converter), flags (n,)."""

    L: Any
    codes: Any
    flags: Any


class Estimate(NamedTuple):
    """Wrench (n, 6) [N, N m], NaN where there is none; flags (n,)."""

    wrench: Any
    flags: Any


@dataclass(frozen=True)
class Twin:
    """A calibrated sensor: `numbers` are all arrays that ``sensor.npz`` holds; ``about`` says what each is."""

    numbers: Mapping[str, Any]

    @classmethod
    def load(cls, path: str | Path) -> Twin:
        """Return the twin of a ``sensor.npz``; raise ValueError where the file is none."""
        try:
            with np.load(path, allow_pickle=False) as file:
                numbers = {name: file[name] for name in file.files}
        except (OSError, ValueError) as error:
            raise ValueError(f"{path}: must be the sensor.npz of a twin; got: {error}") from None
        if "wrench_coefficients" not in numbers:
            raise ValueError(f"{path}: must be the sensor.npz of a twin; it holds no wrench_coefficients")
        return cls(numbers)

    @cached_property
    def forces(self) -> tuple[str, ...]:
        """The components of the wrench that move the readings."""
        return tuple(WRENCH[k] for k in self.numbers["wrench_columns"])

    @cached_property
    def coils(self) -> tuple[str, ...]:
        """Names, in the order of the readings and of the converter's channels."""
        return tuple(str(name) for name in self.numbers["coils"])

    def read(self, wrench: Any) -> Reading:
        """Return what slow wrenches show, shape (n, 6) [N, N m]."""
        return self._read("wrench", _columns("wrench", wrench))

    def read_pose(self, pose: Any) -> Reading:
        """Return what poses of the target show, shape (n, 6) [m, rad]; raise ValueError where there is no such map."""
        if "pose_coefficients" not in self.numbers:
            raise ValueError("pose: must be of a twin with a map of poses; this one has none")
        return self._read("pose", _columns("pose", pose))

    def estimate(self, L: Any) -> Estimate:
        """Return the slow wrenches that show inductances, shape (n, coils) [H]."""
        _columns("L", L, len(self.coils))
        return self._estimated(0, L - _like(self._map("wrench").base[: len(self.coils)], L))

    def estimate_codes(self, codes: Any) -> Estimate:
        """Return the slow wrenches that show codes of the converter, integers of shape (n, coils).

        In the library's own precision: double in numpy, single in torch and jax unless they are set otherwise.
        """
        if not self.numbers["codes"]:
            raise ValueError("codes: must be of a twin with a converter; this one has none")
        xp, count = _namespace(codes), len(self.coils)
        _columns("codes", codes, count)
        flags = _faults(xp, codes, 2 ** int(self.numbers["bits"]) - 1)
        codes = xp.where((flags == 0)[:, None], codes, xp.zeros_like(codes))  # with flags they leave 32 bits
        whole = xp.asarray(codes, dtype=xp.int32) - _like(self._map("wrench").base[count:], codes, xp.int32)
        given = xp.asarray(whole, dtype=xp.asarray(1.0).dtype)
        found = self._estimated(count, xp.where((flags == 0)[:, None], given, given + float("nan")))
        return Estimate(found.wrench, found.flags + flags)

    def start(self, n: int, like: Any = None) -> Any:
        """Return the state of n pads that have rested without load; an array of the kind `like`.

        Of shape (branches + 1, d, n): the d `forces` of the last load, then what each branch still lacks of its share.
        """
        rest = np.zeros((len(self.numbers["creep_times"]) + 1, len(self.forces), n))
        return rest if like is None else _like(rest, like)

    def step(self, state: Any, wrench: Any, dt: Any) -> tuple[Any, Reading]:
        """Return state and readings after dt [s], () or (n,), in which the load went evenly to `wrench` (n, 6)."""
        rows = _columns("wrench", wrench)
        state, elastic = self._passed(state, rows, dt, -self.numbers["creep_weights"], self.numbers["creep_times"])
        return state, self._read("wrench", elastic)

    def recover(self, state: Any, L: Any, dt: Any) -> tuple[Any, Estimate]:
        """Return state and wrenches, now, of inductances (n, coils) [H] a time dt [s] after the last ones.

        The state is one of `start` that belongs to the readings; where a reading has no wrench it becomes NaN.
        """
        found = self.estimate(L)
        weights, times = self.numbers["relaxation_weights"], self.numbers["relaxation_times"]
        state, rows = self._passed(state, _columns("wrench", found.wrench), dt, weights, times)
        return state, Estimate(_namespace(L).stack(rows).T, found.flags)

    def _passed(self, state: Any, rows: list[Any], dt: Any, weights: Any, times: Any) -> tuple[Any, list[Any]]:
        """Return the state after a step, and the rows, the forces convolved with 1 + sum_j w_j exp(-t/t_j)."""
        xp, columns = _namespace(state), self.numbers["wrench_columns"].tolist()
        share = _durations(dt, state) / _like(times, state)[:, None]
        kept, mean = xp.exp(-share), _like(weights, state)[:, None] * (-xp.expm1(-share) / share)
        load = xp.stack([rows[k] for k in columns])
        rise = load - state[0, :, :]
        parts, passed = [load], load
        for j in range(len(times)):  # a branch at a time stays in the processor's cache
            parts.append(state[j + 1, :, :] * kept[j, :] + rise * mean[j, :])
            passed = passed + parts[-1]
        moved = dict(zip(columns, _rows(passed), strict=True))
        return xp.stack(parts), [moved.get(k, row) for k, row in enumerate(rows)]

    def _read(self, name: str, rows: list[Any]) -> Reading:
        """Return the outputs of a map at the rows of wrenches or poses."""
        xp, map_, count = _namespace(rows[0]), self._map(name), len(self.coils)
        x, flags = map_.scaled(rows)
        change = map_.at(x)[0]
        L = (change[:count, :] + _like(map_.base[:count], change)[:, None]).T
        whole = _like(map_.base[count:], change, xp.int32)
        return Reading(L, whole + xp.asarray(xp.round(change[count:, :].T), dtype=xp.int32), flags)

    def _estimated(self, first: int, given: Any) -> Estimate:
        """Return the wrenches of readings (n, coils) less the base, of the outputs from `first` on."""
        xp, map_, count, kind = _namespace(given), self._map("wrench"), len(self.coils), "codes" if first else "L"
        guess, scale = self._map(f"guess_{kind}"), _like(self.numbers[f"scale_{kind}"], given)[:, None]
        off, rows = given.T / scale, slice(first, first + count)
        towards = _like(self.numbers[f"directions_{kind}"], given)
        y = xp.clip(towards[:, :-1] @ off + towards[:, -1:], -1.0, 1.0)
        x = guess.at(_rows(y))[0] + _like(guess.base, given)[:, None]
        for _ in range(_STEPS):
            value, *slopes = (part[rows, :] / scale for part in map_.at(_rows(x), slopes=True))
            move = xp.stack(_least_squares(xp, slopes, off - value))
            step = xp.clip(move, -_LONGEST, _LONGEST)
            x = xp.clip(x + step, -_REACH, _REACH)
        left = xp.abs(off - map_.at(_rows(x))[0][rows, :] / scale)
        good = (_most(xp, _rows(move)) < _SETTLED) & (_most(xp, _rows(left)) < float(self.numbers["residual"]))
        good = good & self._valid(xp, xp.where(good, x, xp.zeros_like(x)))
        edge = 1.0 + float(self.numbers["margin"])
        flags = _flag(xp, _most(xp, _rows(x)) > edge, OUTSIDE) + _flag(xp, good, -UNSOLVED) + UNSOLVED
        columns = dict(zip(map_.columns, map_.unscaled(xp.clip(x, -edge, edge)), strict=True))
        fixed, zero = _like(map_.fixed, given), 0.0 * x[0, :]
        none = xp.where(good, zero, zero + float("nan"))
        return Estimate(xp.stack([columns.get(k, fixed[k]) + none for k in range(6)]).T, flags)

    def _valid(self, xp: Any, x: Any) -> Any:
        """Tell which scaled wrenches (d, n) lie where no other one shows the same."""
        valid, top = self.numbers["valid"], np.array(self.numbers["valid"].shape) - 1
        if valid.all():
            return x[0, :] == x[0, :]
        place = xp.asarray(0.0 * x[0, :], dtype=xp.int32)
        for row, last in zip(_rows(x), top.tolist(), strict=True):
            near = xp.round(xp.clip(0.5 * (row + 1.0) * last, 0.0, float(last)))
            place = place * (last + 1) + xp.asarray(near, dtype=xp.int32)
        return _like(valid.ravel(), x, xp.int32)[place] == 1

    def _map(self, name: str) -> _Map:
        """Return one of the maps."""
        if name not in self._maps:
            raise ValueError(f"{name.partition('_')[0]}: {self.numbers['no_inverse']}")
        return self._maps[name]

    @cached_property
    def _maps(self) -> dict[str, _Map]:
        """All maps by name."""
        names = [name.removesuffix("_coefficients") for name in self.numbers if name.endswith("_coefficients")]
        fields = ("coefficients", "coefficients_float32", "powers", "base", "low", "high", "columns", "fixed")
        return {name: _Map(*(self.numbers[f"{name}_{field}"] for field in fields)) for name in names}


@dataclass(frozen=True)
class _Map:
    """Outputs over a box: coefficients (outputs, terms), degrees (terms, d), the components that vary."""

    coefficients: Any
    coefficients_float32: Any
    powers: Any
    base: Any
    low: Any
    high: Any
    columns: Any
    fixed: Any

    def scaled(self, given: list[Any]) -> tuple[list[Any], Any]:
        """Return the rows of x, held at the box, NaN at its middle, and flags, of six rows of wrenches or poses."""
        xp, box = _namespace(given[0]), zip(self.columns.tolist(), self.low.tolist(), self.high.tolist(), strict=True)
        rows = [(given[k] - 0.5 * (high + low)) * (2.0 / (high - low)) for k, low, high in box]
        flags = _flag(xp, ~(_most(xp, rows) <= 1.0 + _EDGE), OUTSIDE)
        other = [given[k] - float(self.fixed[k]) for k in range(6) if k not in self.columns]
        if other:
            flags = flags + _flag(xp, ~(_most(xp, other) <= _SAME + _EDGE * float(np.abs(self.fixed).max())), IGNORED)
        return [xp.clip(xp.where(row == row, row, xp.zeros_like(row)), -1.0, 1.0) for row in rows], flags

    def unscaled(self, x: Any) -> list[Any]:
        """Return rows of x in the components' units."""
        rows = zip(_rows(x), self.low.tolist(), self.high.tolist(), strict=True)
        return [0.5 * (row * (high - low) + (high + low)) for row, low, high in rows]

    def at(self, x: list[Any], slopes: bool = False) -> list[Any]:
        """Return the outputs less their base (outputs, n) at rows of x, and if asked the derivatives by each row."""
        tables = [_chebyshev(row, int(most), slopes) for row, most in zip(x, self.powers.max(axis=0), strict=True)]
        last = [_namespace(x[0]).stack(rows) for rows in tables[-1] if rows]
        return self._sum(self._nested, tables[:-1], last)

    def _sum(self, node: Any, tables: list[Any], last: list[Any]) -> list[Any]:
        """Return the sum below a node of the nested sums, and its derivatives by this and later variables."""
        if not tables:
            leaf = _like(node[str(last[0].dtype).endswith("float32")], last[0])
            return [leaf @ rows[: leaf.shape[1], :] for rows in last]
        (values, rates), found = tables[0], list[Any]()
        for k, below in node:
            parts = self._sum(below, tables[1:], last)
            added = [part if k == 0 else values[k] * part for part in parts]
            if rates:
                added = [added[0], rates[k] * parts[0], *added[1:]]
            found = [a + b for a, b in zip(found, added, strict=True)] if found else added
        return found

    @cached_property
    def _nested(self) -> Any:
        """The coefficients by the degrees of each variable in turn, at last both precisions over the last one's."""
        return _nest(self.powers, (self.coefficients, self.coefficients_float32))


def _nest(powers: Any, coefficients: tuple[Any, ...]) -> Any:
    """Return what `_Map._nested` is, of some terms."""
    if powers.shape[1] == 1:
        dense = [np.zeros((len(each), int(powers.max()) + 1), dtype=each.dtype) for each in coefficients]
        for full, each in zip(dense, coefficients, strict=True):
            full[:, powers[:, 0]] = each
        return dense
    groups = [(k, powers[:, 0] == k) for k in np.unique(powers[:, 0]).tolist()]
    return [(k, _nest(powers[group, 1:], tuple(each[:, group] for each in coefficients))) for k, group in groups]


def _chebyshev(x: Any, degree: int, slopes: bool) -> tuple[list[Any], list[Any]]:
    """Return T_0 to T_degree at x and, if asked, their derivatives."""
    values, rates = [1.0 + 0.0 * x, x], [0.0 * x, 1.0 + 0.0 * x]
    for k in range(2, degree + 1):
        values.append(2.0 * x * values[k - 1] - values[k - 2])
        if slopes:
            rates.append(2.0 * values[k - 1] + 2.0 * x * rates[k - 1] - rates[k - 2])
    return values[: degree + 1], rates[: degree + 1] if slopes else []


def _least_squares(xp: Any, slopes: list[Any], off: Any) -> list[Any]:
    """Return the rows s with sum_i slopes_i s_i nearest to `off` (outputs, n), by Q R of the slopes."""
    Q, R, d = list(slopes), {}, len(slopes)
    for i in range(d):
        R[i, i] = xp.sqrt(xp.sum(Q[i] ** 2, axis=0))
        Q[i] = Q[i] / R[i, i]
        for j in range(i + 1, d):
            R[i, j] = xp.sum(Q[i] * Q[j], axis=0)
            Q[j] = Q[j] - R[i, j] * Q[i]
    found = [xp.sum(column * off, axis=0) for column in Q]
    for i in reversed(range(d)):
        for j in range(i + 1, d):
            found[i] = found[i] - R[i, j] * found[j]
        found[i] = found[i] / R[i, i]
    return found


def _faults(xp: Any, codes: Any, full: int) -> Any:
    """Return flags of what is wrong with the first of the codes (n, coils) that is of no coil, (n,); 0 without."""
    found = 0 * xp.asarray(codes[:, 0] == 0, dtype=xp.int32)
    for code in reversed([codes[:, k] for k in range(codes.shape[1])]):
        kinds = (code == 0, FAULT_ZERO), (code == full, FAULT_FULL), ((code > full) | (code < 0), FAULT_FLAGS)
        for wrong, flag in kinds:
            found = xp.where(wrong, xp.zeros_like(found) + flag, found)
    return found


def _flag(xp: Any, where: Any, value: int) -> Any:
    """Return a flag where something holds, else 0."""
    return xp.asarray(where, dtype=xp.int32) * value


def _most(xp: Any, rows: Any) -> Any:
    """Return the largest absolute value over rows."""
    return reduce(xp.maximum, [xp.abs(row) for row in rows])


def _columns(name: str, given: Any, count: int = 6) -> list[Any]:
    """Return the columns of wrenches or poses (n, 6), or of readings."""
    if given.ndim != 2 or given.shape[1] != count:
        raise ValueError(f"{name}: must be of shape (n, {count}); got {tuple(given.shape)}")
    return [given[:, k] for k in range(count)]


def _durations(dt: Any, state: Any) -> Any:
    """Return dt, shape () or (n,), as an array of the state's kind; refuse what is not positive."""
    given, n = dt if hasattr(dt, "shape") else np.asarray(dt), state.shape[2]
    if tuple(given.shape) not in ((), (n,)):
        raise ValueError(f"dt: must be one time or one for each of {n} sensors [s]; got shape {tuple(given.shape)}")
    xp = _namespace(given)
    positive = xp.all(given > 0)
    with suppress(TypeError, RuntimeError):  # of a traced value nothing is known yet
        if not positive:
            raise ValueError(f"dt: must be positive [s]; got {float(xp.min(given))}")
    return given if getattr(given, "requires_grad", False) else _like(given, state)  # torch would cut its graph


def _rows(array: Any) -> list[Any]:
    """Return the rows of an array."""
    return [array[k, :] for k in range(array.shape[0])]


def _namespace(array: Any) -> Any:
    """Return the functions of an array: its own namespace, or the module that it is of."""
    own = getattr(array, "__array_namespace__", None)
    return own() if own is not None else sys.modules[type(array).__module__.partition(".")[0]]


def _like(values: Any, array: Any, dtype: Any = None) -> Any:
    """Return numbers as an array of the kind, precision and place of another one."""
    xp = _namespace(array)
    place = {"device": array.device} if xp.__name__ == "torch" else {}
    return xp.asarray(values, dtype=array.dtype if dtype is None else dtype, **place)
