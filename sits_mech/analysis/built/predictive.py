"""Foresee what a sensor may show under loads before its readings are fitted, and how likely readings are beforehand.

Of a modulus s, ln s = ln v + z sd/v, a sensor shows under a load F what the table's shows under f = F v/s; by what else
is unknown, theta, and what the load is misread by, u, this changes linearly,

    y = L(f) + J(f) theta + L_f(f) u/s + e,    y - L(f) ~ N(0, C_s),
    C_s = J Sigma_s J^T + L_f U L_f^T / s^2 + sigma^2 + b^2 diag(J Sigma_s J^T),

Sigma_s the covariance of theta where s is known to half the step between its nodes, J and L_f quadratics through
derivatives at three values of each force. b stands for what is not linear. A load beyond the table is followed along
L_f at its end, uncertain by all of what that adds. Readings have the density and the probability

    rho = sum_s exp(-d_s^2/2) |C_s|^(-1/2),    d_s^2 = (y - L)^T C_s^-1 (y - L) + z^2,
    p = max_s P(chi^2_(N+1) > d_s^2).

If they are as they should be, a slip that would have made them so has a density B times theirs with a probability of
less than 1/B (Markov). One number may lie in L +- (q^2 - z^2)^(1/2) C_s^(1/2) for some s. Neglected: that leads are not
below none.

Source: A. Gelman and others, Bayesian Data Analysis, 3rd ed. 2013, sections 6.3 and 7.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import logsumexp
from scipy.stats import chi2

from sits_mech.analysis.bench.force_maps import ForceMaps, mapped
from sits_mech.analysis.built.prior import Prior, load_noise_of
from sits_mech.analysis.readings.bench import loads_over
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import Array

_BENDS = 0.02
"""b: with it d^2 of 40 units of biorob2018-w15 drawn as known, of 10 numbers each, is 26 at most, 4 in the median; 943
without."""
_LINEAR = ("lead", "capacitance")  # by which readings change in proportion
_NODES, _MOST = 33, 4.0  # moduli, and to how many deviations: where a fit's ends are (`setup`)
_ROWS = 40  # that are looked at together, of more ones in even steps


class Likeliest(NamedTuple):
    """How likely readings are beforehand, and where the likeliest modulus expects each."""

    p: float
    evidence: float  # ln of the density of all readings, but for a constant
    off: Array  # (m, n) of the module docstring's y - L by what numbers before it show, in its deviations
    mean: Array  # (m, n) expected of each by what numbers before it show [H]
    deviation: Array  # (m, n) [H]


@dataclass(frozen=True)
class Predictive:
    """What a sensor may show, as known beforehand."""

    prior: Prior
    load_noise: ArrayLike | None = None

    @cached_property
    def _maps(self) -> tuple[SmoothMap, tuple[int, int, int]]:
        """The map from forces to what is shown besides the table's and its derivatives, and the sizes n, p, d."""
        prior, table = self.prior, self.prior.table
        loads = loads_over(self._modulus[0] * table.map.low, self._modulus[0] * table.map.high, 3)
        by, by_load = prior.slopes_at(prior.start, loads)
        more = prior.bench(loads).model(prior.start[None])[0] - table.map.at(loads / self._modulus[0])
        whole = np.concatenate([part.reshape(len(loads), -1) for part in (more, by, by_load)], axis=1)
        return fit_map(prior.forces, loads, whole), (more.shape[1], by.shape[2], by_load.shape[2])

    @property
    def _modulus(self) -> tuple[float, float, int | None]:
        """Value and deviation of the modulus beforehand, and its place among the unknowns."""
        names = self.prior.setup.names
        if "modulus" not in names:
            return 1.0, 0.0, None
        place = names.index("modulus")
        return float(self.prior.start[place]), float(self.prior.deviations[place]), place

    def nodes(self) -> Array:
        """Return the deviations z of the moduli that are looked at, shape (k,)."""
        return np.linspace(-_MOST, _MOST, _NODES) if self._modulus[2] is not None else np.zeros(1)

    @cached_property
    def _spread(self) -> Array:
        """The covariance of the unknowns where the modulus is one of the nodes, (p, p)."""
        deviation = self._modulus[1]
        half = _MOST / (_NODES - 1) * deviation  # of a step between nodes
        return self.prior.covariance + (half**2 - deviation**2) * np.outer(self._along, self._along)

    @property
    def _along(self) -> Array:
        """How far the unknowns are expected to move with the modulus, over its own way, (p,); zero if it is known."""
        _, deviation, place = self._modulus
        return 0.0 * self.prior.start if place is None else self.prior.covariance[:, place] / deviation**2

    def expected(self, forces: Array, z: float, table: ForceMaps | None = None) -> tuple[Array, Array, Array]:
        """Return L of the module docstring (m, n) [H], J (m, n, p), and what each has for itself (m, n, n) [H^2].

        At loads (m, d), of a modulus z deviations off; by another `table` of the same loads.
        """
        prior, (value, deviation, place), table = self.prior, self._modulus, table or self.prior.table
        softer = float(np.exp(z * deviation / value))
        f = forces / softer
        inside = np.clip(f, value * table.map.low, value * table.map.high)
        (maps, (n, p, d)), m = self._maps, len(forces)
        more, by, by_load = np.split(mapped(maps, inside), [n, n * (1 + p)], axis=-1)
        by, by_load = by.reshape(m, n, p), by_load.reshape(m, n, d)
        beyond = np.einsum("mnd,md->mn", by_load, f - inside)
        L = table.map.at(inside / value) + more + beyond
        size = load_noise_of(prior.table, self.load_noise) / softer
        own = (by_load * size**2) @ by_load.swapaxes(1, 2)
        bent = np.array([each.name not in _LINEAR for each in prior.known])
        bends = np.einsum("mnp,pq,mnq->mn", by[..., bent], self._spread[np.ix_(bent, bent)], by[..., bent])
        alone = prior.noise**2 + prior.model**2 + _BENDS**2 * bends + beyond**2
        L = L + by @ np.where(np.arange(p) == place, 0.0, self._along * deviation * z)
        return L, by, own + alone[..., None] * np.eye(n)

    def likeliest(self, forces: Array, y: Array, table: ForceMaps | None = None) -> Likeliest:
        """Return how likely readings (m, n) [H] under loads (m, d) are, of some `_ROWS` of them in even steps."""
        step = row_step(len(y))
        each = [self._at(forces[::step], y[::step], z, table) for z in self.nodes().tolist()]
        evidence = float(logsumexp([one.evidence for one in each]))
        return max(each, key=lambda one: one.p)._replace(evidence=evidence)

    def _at(self, forces: Array, y: Array, z: float, table: ForceMaps | None) -> Likeliest:
        """Return the same of a modulus."""
        L, by, own = self.expected(forces, z, table)
        (m, n), J = y.shape, by.reshape(y.size, -1)
        C = J @ self._spread @ J.T
        rows = C.reshape(m, n, m, n)
        rows[np.arange(m), :, np.arange(m)] += own
        root = np.linalg.cholesky(C)
        w = np.linalg.solve(root, (y - L).ravel())
        deviation = np.diagonal(root).reshape(m, n)
        off = w.reshape(m, n)
        d2 = float(w @ w + z * z)
        evidence = -0.5 * d2 - float(np.log(deviation).sum())
        return Likeliest(float(chi2.sf(d2, y.size + 1)), evidence, off, y - off * deviation, deviation)

    def ends(self, forces: Array, most: float) -> tuple[Array, Array]:
        """Return between what each coil's inductance may be, (m, n) each [H], within `most` deviations q."""
        low, high = np.full((2, len(forces), len(self.prior.noise)), np.nan)
        for z in self.nodes()[np.abs(self.nodes()) < most].tolist():
            L, by, own = self.expected(forces, z)
            size = np.sqrt(np.einsum("mnp,pq,mnq->mn", by, self._spread, by) + np.einsum("mnn->mn", own))
            half = np.sqrt(most**2 - z**2) * size
            low, high = np.fmin(low, L - half), np.fmax(high, L + half)
        return low, high


def row_step(count: int) -> int:
    """Return the step between the rows, of so many, that are looked at together."""
    return -(-count // _ROWS)
