"""Predict designs that were not solved: kriging with slopes through the solved ones of the same choice.

A figure y of solved points x_i, with values y_i and slopes g_i where they are known, is taken as a linear function and
a Gaussian process over the unit box with the kernel

    k(x, x') = exp(-|x - x'|^2 / (2 l^2)),      <y(x), g_b(x')> = dk/dx'_b,      <g_a(x), g_b(x')> = d2k/dx_a dx'_b.

The best prediction is a sum of values and slopes with weights that depend on the points alone, so that one set of them
serves a whole table. It interpolates what is known; of one point it is the tangent, or without slopes the value.
Positive figures are predicted by their logarithm, but sizes, which are sums.

Source: A. I. J. Forrester, A. Sobester, A. J. Keane, Engineering Design via Surrogate Modelling (2008), chapter 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.required.kinds import kind_of
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.solved.answered import Answered
from sits_mech.synthesis.solved.figures import Table

_LENGTH = 1.0  # l, of the box
_JITTER = 1e-9  # of the kernel at no distance: rounding of what is nearly the same


@dataclass(frozen=True)
class Kriging:
    """Weights of known values at points (k, v) in a prediction."""

    points: Array
    slopes: bool  # whether slopes are known there, too

    def weights(self, x: Array) -> tuple[Array, Array]:
        """Return the weights of values (k,) and of slopes (k, v) in the prediction at a point (v,)."""
        key = x.tobytes()
        if key not in self._last:
            self._last.clear()
            self._last[key] = self._weights(x)
        return self._last[key]

    @cached_property
    def _last(self) -> dict[bytes, tuple[Array, Array]]:
        """The weights of the last point: figures are asked for one after the other."""
        return {}

    def _weights(self, x: Array) -> tuple[Array, Array]:
        """Return `weights`."""
        k, v = self.points.shape
        covariance = _covariance(self.points, x[None], self.slopes, False)[:, 0]
        side = np.concatenate([covariance, [1.0], x[: self._linear]])
        own = (self._inverse @ side)[: len(covariance)]
        return own[:k], own[k:].reshape(v, k).T if self.slopes else np.zeros((k, v))

    @cached_property
    def _linear(self) -> int:
        """The coordinates of the linear function: none where values alone do not determine its slopes."""
        k, v = self.points.shape
        known = self.slopes or np.linalg.matrix_rank(np.column_stack([np.ones(k), self.points])) > v
        return v if known else 0

    @cached_property
    def _inverse(self) -> Array:
        """The inverse of the equations of all weights and of the linear function's multipliers."""
        k, v = self.points.shape[0], self._linear
        C = _covariance(self.points, self.points, self.slopes, self.slopes)
        rows = np.zeros((len(C), 1 + v))
        rows[:k] = np.column_stack([np.ones(k), self.points[:, :v]])
        for axis in range(v if self.slopes else 0):
            rows[k * (1 + axis) : k * (2 + axis), 1 + axis] = 1.0
        whole = np.block([[C + _JITTER * np.eye(len(C)), rows], [rows.T, np.zeros((1 + v, 1 + v))]])
        return np.linalg.pinv(whole, rcond=1e-12, hermitian=True)


def _covariance(a: Array, b: Array, slopes_a: bool, slopes_b: bool) -> Array:
    """Return covariances of values at points a and b, their slopes after them axis by axis."""
    away = a[:, None] - b[None]
    K = np.exp(-(away**2).sum(axis=-1) / (2.0 * _LENGTH**2))
    by_b = [away[..., j] / _LENGTH**2 * K for j in range(a.shape[1])] if slopes_b else []
    rows = [np.hstack([K, *by_b])]
    for i in range(a.shape[1] if slopes_a else 0):
        own = [-away[..., i] / _LENGTH**2 * K]
        for j in range(a.shape[1] if slopes_b else 0):
            own.append(((i == j) - away[..., i] * away[..., j] / _LENGTH**2) / _LENGTH**2 * K)
        rows.append(np.hstack(own))
    return np.vstack(rows)


@dataclass(frozen=True)
class Prediction:
    """Predictions of one choice from its solved designs, and those that failed."""

    solved: Sequence[Answered]
    failed: Sequence[Answered]

    def distance(self, x: Array) -> float:
        """Return the distance of a point from the nearest one that is known, solved or failed."""
        every = [*self.solved, *self.failed]
        return min((float(np.max(np.abs(each.point - x), initial=0.0)) for each in every), default=np.inf)

    def at(self, x: Array) -> Answered:
        """Return the design at a point as it is predicted, without derivatives."""
        return Answered(Design((), tuple(x.tolist())), "", self.table(x), np.zeros(0), self.plain(x), {})

    def table(self, x: Array) -> Table | None:
        """Return the table at a point; None where none was solved."""
        tables = [each.table for each in self.solved if each.table is not None]
        if not tables:
            return None
        (values, slopes), (others, _) = (own.weights(x) for own in self._of_tables)
        by_x = np.array([each.by_x for each in self.solved])
        L = np.tensordot(values, np.array([each.L for each in tables]), 1) + np.tensordot(slopes, by_x, 2)
        by_tolerance, noise = (np.tensordot(others, np.array([each[k] for each in tables]), 1) for k in (1, 2))
        sizes = {
            name: (value, np.tensordot(others, np.array([each.sizes[name][1] for each in tables]), 1))
            for name, value in self.plain(x).items() if all(name in each.sizes for each in tables)
        }
        return Table(L, by_tolerance, np.abs(noise), sizes)

    @cached_property
    def _of_tables(self) -> tuple[Kriging, Kriging]:
        """Kriging with and without slopes."""
        points = np.array([each.point for each in self.solved])
        return Kriging(points, True), Kriging(points, False)

    def plain(self, x: Array) -> dict[str, float]:
        """Return the figures without a table at a point."""
        return {name: figure.at(x) for name, figure in self._figures.items()}

    @cached_property
    def _figures(self) -> dict[str, _Figure]:
        """Each figure without a table, with slopes where all designs have them."""
        every, shared = [*self.solved, *self.failed], dict[tuple[bytes, bool], Kriging]()
        names = (self.solved[0] if self.solved else self.failed[0]).plain
        return {name: _Figure.of(name, [each for each in every if name in each.plain], shared) for name in names}


@dataclass(frozen=True)
class _Figure:
    """A figure without a table at points: kriging, values or their logarithms, slopes likewise."""

    kriging: Kriging
    values: Array
    slopes: Array
    logs: bool

    @classmethod
    def of(
        cls, name: str, known: Sequence[Answered], shared: dict[tuple[bytes, bool], Kriging]
    ) -> _Figure:
        """Return a figure from the designs that have it; figures of the same designs share their weights."""
        values = np.array([each.plain[name] for each in known])
        logs = bool(np.all(values > 0.0)) and not kind_of(name).exact
        own = [each.plain_by_x.get(name) for each in known]
        points = np.array([each.point for each in known])
        slopes = np.array([np.zeros(points.shape[1]) if each is None else each for each in own])
        whole = all(each is not None for each in own)
        scale = values[:, None] if logs else 1.0
        kriging = shared.setdefault((points.tobytes(), whole), Kriging(points, whole))
        return cls(kriging, np.log(values) if logs else values, slopes / scale, logs)

    def at(self, x: Array) -> float:
        """Return the figure at a point."""
        values, slopes = self.kriging.weights(x)
        found = float(values @ self.values + np.sum(slopes * self.slopes))
        return float(np.exp(np.clip(found, -300.0, 300.0))) if self.logs else found
