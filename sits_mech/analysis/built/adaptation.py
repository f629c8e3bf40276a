"""Adapt a calibration to one sensor by a few readings of it: the posterior of what is unknown, and what it explains.

Unknown are the numbers of the built sensor and of its bench (`unknowns`, `setup`), a factor for each part of the poses'
errors that the whole table shares, and what each load was misread by; all of them theta, known to be v +- s beforehand.
With readings y of noise sigma, to which the table's own errors are added,

    -2 ln p(theta | y) = chi^2(theta) = sum ((y(theta) - y)/sigma)^2 + sum ((theta - v)/s)^2 + const,

of the modulus ln theta; its least by Gauss and Newton with the chain's own derivatives, its width there by Laplace's
approximation (fit.py). What an estimated error counts as is in `prior`. Of N numbers read the least chi^2 follows
chi^2_N if the sensor is one of those described; p is the probability of more. The part of the residual that no unknown
can move,

    r_n = (1 - J J^+) r,    J by all unknowns but u, r over sigma,

is tested for itself, with u as a part of the noise. What forces that are read are off by is in `prior`.

Source: A. Gelman and others, Bayesian Data Analysis, 3rd ed. 2013, sections 4.1 and 6.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import chi2

from sits_mech.analysis.bench.force_maps import ForceMaps
from sits_mech.analysis.bench.loaded import LoadedBench
from sits_mech.analysis.built.fit import Beforehand, Free, ParameterFit, fit_parameters
from sits_mech.analysis.built.prior import HALF, Prior, check_deviation, inverted, load_noise_of
from sits_mech.analysis.readings.measured import Measured
from sits_mech.quantities import Array, Mask

_WIDEST = 100.0  # deviations: how far a factor or a misread load is followed; what is as far tells by its p-value
_DETERMINED = 0.7  # of its deviation beforehand: what is known better afterwards was read
_RANK = 1e-6  # of the largest singular value: a direction that an unknown moves


@dataclass(frozen=True)
class Adaptation:
    """What readings tell of a built sensor."""

    prior: Prior  # the calibrated sensor, and what was unknown
    measured: Measured
    names: tuple[str, ...]  # of the unknowns of sensor and bench, then of the factors of shared errors
    values: Array  # where the posterior is largest, (p,) [SI]
    covariance: Array  # (p, p)
    chi_square: float  # least of the module docstring
    numbers: int  # that were read
    residual: Array  # readings less what the adapted sensor shows, loads as read, (m, n) [H]
    structured: float  # of the same what no unknown can move, as a chi^2
    freedom: int  # degrees of freedom of that
    before: Array  # readings less what the calibration shows, (m, n) [H]
    known: Beforehand = field(repr=False)  # all unknowns, what loads were misread by as well
    fit: ParameterFit = field(repr=False)  # of all of them
    other_idle: str = ""  # what idle coils may be as well: the readings fit both ways

    @property
    def deviations(self) -> Array:
        """The standard deviations of the posterior."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def p_value(self) -> float:
        """The probability that such a sensor fits its readings worse."""
        return self.fit.p_value

    @property
    def p_structured(self) -> float:
        """The probability that noise leaves more which no unknown can move; 1 where nothing is left to tell."""
        return float(chi2.sf(self.structured, self.freedom)) if self.freedom else 1.0

    @property
    def identified(self) -> tuple[str, ...]:
        """The unknowns that the readings determine, beyond what was known."""
        before, parameters = self.prior.deviations, len(self.prior.setup.parameters)
        return tuple(np.array(self.names)[:parameters][(self.deviations < _DETERMINED * before)[:parameters]].tolist())

    @property
    def correlation(self) -> Array:
        """The correlations of the posterior, shape (p, p)."""
        return self.covariance / np.outer(self.deviations, self.deviations)

    def force_deviations(self, forces: ArrayLike) -> tuple[Array, Array]:
        """Return the deviations of forces that are read at loads (m, d), before and after, (m, d) each [N].

        Before: by the calibration as it is, tared at rest.
        """
        at = np.asarray(forces, dtype=float)
        each = ((self.prior.start, inverted(self.prior.tared)), (self.values, self.covariance))
        found = [np.sqrt(np.einsum("mdd->md", self.prior.force_covariance(*one, at))) for one in each]
        return found[0], found[1]


def adapt(
    prior: Prior, measured: Measured, *, load_noise: float | None = None, depth_noise: float = 1e-5
) -> Adaptation:
    """Return what readings tell of a built sensor.

    A load of `measured` that was not measured is NaN, and then found from the readings themselves; `load_noise` is the
    deviation of a force that is read [N], by default, as of moments, a thousandth of the table's largest; `depth_noise`
    that of the target's way down, where it was measured [m]. Raises SceneError for an inductance that is
    not above 0, when loads lie beyond the table for every modulus, or an unknown is at the end of its reach.
    """
    measured.check()
    check_deviation("load_noise", load_noise, "N")
    check_deviation("depth_noise", depth_noise, "m")
    table, n, m = prior.table, len(prior.noise), len(measured.L)
    size = load_noise_of(table, load_noise)
    blind = ~np.isfinite(measured.forces)
    forces = np.where(blind, 0.5 * (table.map.low + table.map.high), measured.forces)
    bench = prior.bench(forces, loose=True, depth=measured.depth is not None)
    y, scale = measured.L, np.tile(np.hypot(prior.noise, prior.model), (m, 1))
    if measured.depth is not None:
        y, scale = np.column_stack([y, measured.depth]), np.column_stack([scale, np.full(m, depth_noise)])
    misread, reach = _misread(table, forces, blind, size), _WIDEST * HALF
    factors = [Free(each.name, each.value or 0.0, -reach, reach, HALF, each.deviation) for each in prior.factors]
    lead = -prior.sensor.readout.lead_inductance  # no lead has less than none
    own = (replace(each, low=max(each.low, lead), wall=True) if each.name == "lead" else each for each in bench.free())
    known = Beforehand((*own, *factors, *misread), prior.root)
    fit = fit_parameters(bench.model, y, known.free, noise=scale, slopes=bench.slopes, root=known.root)
    p = len(prior.start)
    none, freedom = _structured(bench, fit, scale, misread)
    before = measured.L - bench.model(np.concatenate([prior.start, np.zeros(forces.size)])[None])[0][:, :n]
    return Adaptation(
        prior, replace(measured, forces=forces), fit.names[:p], fit.values[:p], fit.covariance[:p, :p],
        fit.chi_square, int(np.isfinite(y).sum()), fit.residual[:, :n], none, freedom, before,
        known, fit,
    )


def _misread(table: ForceMaps, forces: Array, blind: Mask, noises: Array) -> list[Free]:
    """Return what each load may be misread by, row by row; a load that is not known is one of the table's."""
    found = []
    for row, (loads, unseen) in enumerate(zip(forces.tolist(), blind.tolist(), strict=True), 1):
        for k, (name, load, alone, noise) in enumerate(zip(table.map.names, loads, unseen, noises, strict=True)):
            low, high = (float(end[k]) - load for end in (table.map.low, table.map.high))
            if not alone:
                low, high = -_WIDEST * noise, _WIDEST * noise
            size = float(0.5 * (high - low) if alone else noise)
            found.append(Free(f"{name} of row {row}", 0.0, low, high, size, size))
    return found


def _structured(bench: LoadedBench, fit: ParameterFit, scale: Array, misread: Sequence[Free]) -> tuple[float, int]:
    """Return chi^2 and degrees of freedom of the part of a residual that no unknown of sensor and bench can move.

    What loads were misread by is not one of them: it is part of the noise, with its deviations.
    """
    by, by_load = bench.derivatives(fit.values)
    m, n, d = by_load.shape
    by_reading = by_load @ bench.by_reading(fit.values)
    off = fit.values[-m * d :].reshape(m, d)
    sizes = np.array([each.size for each in misread]).reshape(m, d)
    r = fit.residual + np.einsum("mnd,md->mn", by_reading, off)
    whole = np.einsum("mnd,md,mod->mno", by_reading, sizes**2, by_reading) + scale[..., None] ** 2 * np.eye(n)
    root = np.linalg.cholesky(whole)
    r = np.linalg.solve(root, r[..., None]).ravel()
    J = np.linalg.solve(root, by).reshape(m * n, -1)
    lengths = np.linalg.norm(J, axis=0)
    U, s, _ = np.linalg.svd(J[:, lengths > 0.0] / lengths[lengths > 0.0], full_matrices=False)
    U = U[:, s > _RANK * s[0]]
    left = r - U @ (U.T @ r)
    return float(left @ left), int(len(r) - U.shape[1])
