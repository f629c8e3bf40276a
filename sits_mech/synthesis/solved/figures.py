"""Calculate figures of a sensor from its inductances at a few loads: resolution, error, crosstalk, drift.

Loads lie on a grid of Chebyshev's points of each range; a polynomial through them gives inductances L(F) and slopes
J = dL/dF everywhere in the box, linear in the table. With W the inverse of each coil's noise and
``A = (J^T W^2 J)^-1 J^T W^2`` what reads forces,

    resolution.F    sqrt (J^T W^2 J)^-1_kk at the worst load: one standard deviation [N, N m]
    error.F         |e_k| at the worst load over the range of F_k, that the share `yield` of the sensors made stays
                    below. A sensor that is off by dL(F) is tared at rest, and its reading of each component scaled at
                    one known load F_k* alone, its largest, the others none:
                        e' = A (dL(F) - dL(0)),      e_k(F) = e'_k(F) - F_k/F_k* e'_k(F_k*)
                    and one reading's noise is no part of it
    crosstalk_before_inverse
                    largest share of a component's range that another one feigns at its own in the best linear readout,
                    as in `readout.quality`
    drift.F         |A s|_k at no load, s the slope of the inductances that are read by temperature: by how much zero of
                    each component goes with it, not tared [N/K, N m/K]
    inverse         least det (A_mid J(F)): one in the middle, not positive where two loads show the same

Of a table whose errors feign a share eps_k of the range of F_k in such a readout, e'_k is known to eps_k max_j |e'_j|,
all over their ranges, and so is error.F_k: what an error changes alike at all loads is scaled away once more.

dL = sum_p delta_p dL/dp over tolerances p, normal and independent, to first order. Samples of them are the same for
every design. The share of the samples whose figures hold all limits is the yield; of figures that no tolerance moves,
the figure itself decides. Numbers only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import norm, qmc

from sits_mech.quantities import Array
from sits_mech.readout.quality import SEEN
from sits_mech.synthesis.required.kinds import INVERSE
from sits_mech.synthesis.solved.loads import Operator

_FEW, _MANY = 512, 4096  # samples of a search and of an answer: 128 gave an error 4 % too small
_FAR = 2.0  # deviations of a tolerance, of sensors that tell which loads are the worst: 95 % stay within
_ROUNDING = 1e-12  # of a range per kelvin: drift that symmetry forbids


class Table(NamedTuple):
    """Inductances (g, n) at the loads of a grid [H], their derivatives by tolerances (p, g, n), noise (n,) [H]."""

    L: Array
    by_tolerance: Array
    noise: Array
    sizes: Mapping[str, tuple[float, Array]] = MappingProxyType({})


@dataclass(frozen=True)
class Judge:
    """Figures of tables on one grid."""

    operator: Operator
    deviations: Array  # (p,), of the tolerances that tables have derivatives by
    limits: Mapping[str, float]  # of figures, as of `Requirements`
    share: float  # of the sensors made
    drawn: Array | None = None  # (s, p), deviations of a few sensors; normal ones by default

    @cached_property
    def few(self) -> Array:
        """The deviations of a few sensors, shape (s, p), the same for every search."""
        return self.samples(_FEW) if self.drawn is None else self.drawn

    def samples(self, count: int) -> Array:
        """Return deviations of the tolerances, shape (count, p)."""
        if not len(self.deviations):
            return np.zeros((1, 0))
        unit = qmc.Sobol(len(self.deviations), rng=np.random.default_rng(0)).random_base2(int(np.log2(count)))
        return norm.ppf(np.clip(unit, 1e-6, 1.0 - 1e-6)) * self.deviations

    def figures(self, table: Table) -> dict[str, float]:
        """Return resolution, error, crosstalk_before_inverse and inverse."""
        names, span = self.operator.loads.names, self.operator.loads.span
        slopes = self._slopes(table.L)
        resolution = np.sqrt(_variances(slopes, table.noise)).max(axis=0)
        found = dict(zip((f"resolution.{name}" for name in names), resolution.tolist(), strict=True))
        error = np.zeros(len(span))
        if len(self.deviations):
            error = np.quantile(self._worst_errors(table, self.few) / span, self.share, axis=0)
        found |= dict(zip((f"error.{name}" for name in names), error.tolist(), strict=True))
        reader = _readers(slopes[len(slopes) // 2], table.noise)
        found[INVERSE] = float(np.min(np.linalg.det(reader @ slopes)))
        if len(names) > 1:
            found["crosstalk_before_inverse"] = self._crosstalk(table.L)
        return found

    def drift(self, table: Table, slopes: Array) -> dict[str, float]:
        """Return the drift of zero of each component, by slopes of read inductances at the grid's loads, (g, n)."""
        values, derivatives = (part[..., :1, :] for part in self.operator.at_known)
        reader = _readers(np.moveaxis(derivatives @ table.L, 0, 2), table.noise)[0]
        found = np.abs(reader @ (values @ slopes)[0])
        found = np.where(found > _ROUNDING * self.operator.loads.span, found, 0.0)
        return {f"drift.{name}": size for name, size in zip(self.operator.loads.names, found.tolist(), strict=True)}

    def excess(self, table: Table, count: int = _FEW) -> Array:
        """Return the largest excess of each of many sensors over its limit, relative, shape (s,)."""
        each = self.excesses(table, count)
        none = np.full(len(self.few) if count == _FEW else count if len(self.deviations) else 1, -1.0)
        return np.asarray(np.max([none, *each.values()], axis=0))

    def excesses(self, table: Table, count: int = _FEW) -> dict[str, Array]:
        """Return the excess of each of many sensors over each limit of a scattering figure, relative, shape (s,)."""
        samples = self.few if count == _FEW else self.samples(count)
        names, span = self.operator.loads.names, self.operator.loads.span
        found: dict[str, Array] = {}
        for kind, of in (("error", self._worst_errors), ("resolution", self._resolutions)):
            limits = [self.limits.get(f"{kind}.{name}") for name in names]
            if any(limit is not None for limit in limits):
                values = of(table, samples) / (span if kind == "error" else 1.0)
                pairs = zip(names, limits, values.T, strict=True)
                found |= {f"{kind}.{name}": own / limit - 1.0 for name, limit, own in pairs if limit is not None}
        for name, (value, by) in table.sizes.items():
            if name in self.limits:
                found[name] = (value + samples @ by) / self.limits[name] - 1.0
        return found

    def resolution_parts(self, table: Table, converter: Array) -> dict[str, tuple[float, float]]:
        """Return each resolution's parts at its worst load by the converter's noise (n,) and by the rest [N, N m]."""
        slopes = self._slopes(table.L)
        reader, rest = _readers(slopes, table.noise), np.sqrt(np.maximum(table.noise**2 - converter**2, 0.0))
        found = {}
        for k, name in enumerate(self.operator.loads.names):
            worst = reader[int(np.argmax(_variances(slopes, table.noise)[:, k])), k]
            found[f"resolution.{name}"] = float(np.linalg.norm(worst * converter)), float(np.linalg.norm(worst * rest))
        return found

    def _slopes(self, L: Array) -> Array:
        """Return dL/dF at the points, shape (m, n, d)."""
        return np.moveaxis(self.operator.at_points[1] @ L, 0, 2)

    def _resolutions(self, table: Table, samples: Array) -> Array:
        """Return standard deviations at the worst load of each sensor, shape (s, d).

        Of a few sensors at the loads that are worst for the design or for one that is off by one tolerance alone.
        """
        own = self._slopes(table.L)
        parts = np.array([self._slopes(each) for each in table.by_tolerance]).reshape(-1, *own.shape)
        if len(samples) <= _FEW:
            off = _FAR * self.deviations[:, None, None, None] * parts
            each = np.concatenate([own[None], own + off, own - off])
            worst = np.unique(_variances(each, table.noise).argmax(axis=1))
            own, parts = own[worst], parts[:, worst]
        found = np.empty((len(samples), own.shape[2]))
        for k in range(0, len(samples), _FEW):
            some = own + np.tensordot(samples[k : k + _FEW], parts, 1) if len(parts) else own[None]
            found[k : k + _FEW] = np.sqrt(_variances(some, table.noise)).max(axis=1)
        return found

    def _worst_errors(self, table: Table, samples: Array) -> Array:
        """Return the largest misreading over the loads by each sensor that is off, shape (s, d) [N, N m]."""
        if not len(table.by_tolerance):
            return np.zeros((len(samples), len(self.operator.loads.names)))
        last = self._last
        if last[0] is table.L and last[1] is table.by_tolerance and last[2] is samples:
            return np.asarray(last[3])
        wrong = self._wrong(table, self.operator.points, self.operator.at_points)
        found = np.empty((len(samples), wrong.shape[2]))
        for k in range(0, len(samples), _FEW):
            off = np.tensordot(samples[k : k + _FEW], wrong, 1)
            found[k : k + _FEW] = np.abs(off.transpose(0, 2, 1), order="C").max(axis=2)  # loads last: ten times as fast
        last[:] = table.L, table.by_tolerance, samples, found
        return found

    @cached_property
    def _last(self) -> list[Any]:
        """The last table and samples with their errors: figures and limits ask for the same."""
        return [None] * 4

    def over_loads(self, table: Table, points: Array) -> tuple[Array, Array]:
        """Return resolution and error of each component at loads (m, d), shape (m, d) each [N, N m].

        The error is what the asked share of the sensors made stays below at that load.
        """
        at = self.operator.values(points), self.operator.derivatives(points)
        resolution = np.sqrt(_variances(np.moveaxis(at[1] @ table.L, 0, 2), table.noise))
        if not len(table.by_tolerance):
            return resolution, np.zeros(points.shape)
        off = np.abs(np.tensordot(self.few, self._wrong(table, points, at), 1))
        return resolution, np.quantile(off, self.share, axis=0)

    def tared_errors(self, table: Table) -> Array:
        """Return what the share `yield` of sensors that are tared, not scaled, misreads at most over ranges, (d,)."""
        span = self.operator.loads.span
        if not len(table.by_tolerance):
            return np.zeros(len(span))
        off = np.abs(np.tensordot(self.few, self._tared(table, self.operator.at_points), 1)).max(axis=1)
        return np.asarray(np.quantile(off / span, self.share, axis=0))

    def _wrong(self, table: Table, points: Array, at: tuple[Array, Array]) -> Array:
        """Return misreadings at loads (m, d) by each tolerance, tared and scaled, shape (p, m, d)."""
        values, slopes = self.operator.at_known
        known = self._tared(table, (values[1:], slopes[:, 1:]))
        gain = np.einsum("pkk->pk", known) / np.diag(self.operator.known[1:])
        return np.asarray(self._tared(table, at) - gain[:, None] * points)

    def _tared(self, table: Table, at: tuple[Array, Array]) -> Array:
        """Return misreadings at loads by each tolerance, tared, shape (p, m, d); values and slopes of them by `at`."""
        off = at[0] @ table.by_tolerance - (self.operator.at_known[0][:1] @ table.by_tolerance)
        readers = _readers(np.moveaxis(at[1] @ table.L, 0, 2), table.noise)
        return np.asarray(np.einsum("mdn,pmn->pmd", readers, off))

    def _crosstalk(self, L: Array) -> float:
        """Return the largest share of a range that another component feigns in the best linear readout."""
        points, span = self.operator.points, self.operator.loads.span
        here = self.operator.at_points[0] @ L
        scale = np.maximum(np.ptp(here, axis=0), 1e-300)
        design = np.hstack([(here - here.mean(axis=0)) / scale, np.ones((len(here), 1))])
        found = np.linalg.lstsq(design, points, rcond=SEEN)[0]
        wrong = (design @ found - points).reshape(*(len(axis) for axis in self.operator.fine), -1)
        axes = range(wrong.ndim - 1)
        nearest = [int(np.argmin(np.abs(axis))) for axis in self.operator.fine]
        each = [np.abs(wrong - np.take(wrong, [nearest[k]], axis=k)).max(axis=tuple(axes)) / span for k in axes]
        return float(max(each[j][k] for j in axes for k in axes if j != k))


def _variances(slopes: Array, noise: Array) -> Array:
    """Return variances of the forces by slopes (..., n, d) and noise (n,), shape (..., d)."""
    seen = slopes / noise[:, None]
    square = np.swapaxes(seen, -1, -2) @ seen
    try:
        inverse = np.linalg.inv(square)
    except np.linalg.LinAlgError:
        inverse = np.linalg.pinv(square)
    return np.abs(np.diagonal(inverse, axis1=-2, axis2=-1))


def _readers(slopes: Array, noise: Array) -> Array:
    """Return matrices from inductances to forces, shape (..., d, n)."""
    return np.linalg.pinv(slopes / noise[:, None]) / noise
