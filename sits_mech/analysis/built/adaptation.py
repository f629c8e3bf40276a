"""Adapt a calibration to one sensor by a few readings of it: the posterior of what is unknown, and what it explains.

Unknown are the numbers of the built sensor and of its bench (`setup`, `priors`), a factor for each part of the poses'
errors that the whole table shares, and what each load was misread by; all of them theta, known to be v +- s beforehand.
With readings y of noise sigma, to which the table's own errors are added,

    -2 ln p(theta | y) = chi^2(theta) = sum ((y(theta) - y)/sigma)^2 + sum ((theta - v)/s)^2 + const,

its least by Gauss and Newton with the chain's own derivatives, its width there by Laplace's approximation
(maps/fit.py). An estimated error counts as two deviations. Of N numbers read the least chi^2 follows chi^2_N if the
sensor is one of those described; p is the probability of more. The part of the residual that no unknown can move,

    r_n = (1 - J J^+) r,    J by all unknowns but u, r over sigma,

is tested for itself, with u as a part of the noise. A force that is read is off by

    dF = A dL,    A = (W L_F)^+ W,    W = 1/noise,    cov F = A (L_theta Sigma L_theta^T + sigma^2) A^T.

Source: A. Gelman and others, Bayesian Data Analysis, 3rd ed. 2013, sections 4.1 and 6.3.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.stats import chi2

from sits_mech.analysis.bench import own_inductances, sensor_front_end
from sits_mech.analysis.built.loaded import LoadedBench, Table, layer_slopes, moduli, table_of
from sits_mech.analysis.built.priors import priors, usual_unknowns
from sits_mech.analysis.built.setup import CELL, LAYER, Setup
from sits_mech.chain.models import loaded_model
from sits_mech.maps.fit import Free, ParameterFit, fit_parameters
from sits_mech.maps.surrogate import SmoothMap
from sits_mech.quantities import POSE, Array, MagneticModel
from sits_mech.readout.loads import points, several, wrench_of
from sits_mech.readout.measured import Measured
from sits_mech.scene.sensor import SceneError, Sensor

HALF = 0.5
"""Deviation of a pose over its estimated error; studies/adapted_twins.py: 0.72, 0.23, 0.05 of d_h, d_v and alpha."""
_MAGNETIC = 0.1  # the same of an inductance; measured there: 0.08 of biorob2018-w15 from 1e-2 to 1e-3
_COARSER = 10.0  # times the table's tolerance: of the model that reads what the set-up changes, three times as fast
_COARSEST = 0.1
_SOME = 16  # loads by which its roughness is measured
_LOAD = 1e-3  # of the largest force of the table: noise of a load, unless it is said
_WIDEST = 100.0  # deviations: how far a factor or a misread load is followed; what is as far tells by its p-value
_DETERMINED = 0.7  # of its deviation beforehand: what is known better afterwards was read
_RANK = 1e-6  # of the largest singular value: a direction that an unknown moves


@dataclass(frozen=True)
class Prior:
    """A calibrated sensor with what is unknown of it, before anything is read."""

    sensor: Sensor
    data: xr.Dataset
    setup: Setup
    table: Table
    slopes: SmoothMap | None  # of `layer_slopes`
    noise: Array  # of a reading of each coil, converter or bench alone (n,) [H]
    model: Array  # deviation of the table's own errors (n,) [H]
    _slopes: dict[bytes, tuple[Array, Array]] = field(default_factory=dict, repr=False)  # those asked for before

    @property
    def forces(self) -> tuple[str, ...]:
        """The forces of the table."""
        return self.table.map.names

    def bench(self, forces: Array, *, loose: bool = False, depth: bool = False) -> LoadedBench:
        """Return the model of what rows of loads show."""
        return LoadedBench(self.setup, self.table, forces, self.slopes, True, loose, depth)

    @cached_property
    def start(self) -> Array:
        """What is known beforehand of parameters and factors, shape (p,)."""
        count = self.bench(np.zeros((1, len(self.forces)))).count
        return np.array([each.value or 0.0 for each in self.setup.parameters] + [0.0] * count[1])

    @cached_property
    def covariance(self) -> Array:
        """Its covariance, shape (p, p)."""
        own = [each.deviation for each in self.setup.parameters]
        return np.diag(np.array(own + [HALF] * (len(self.start) - len(own))) ** 2)

    def told(self, loads: Array, load_noise: float | None = None, depth_noise: float | None = None) -> Array:
        """Return what a reading under each of m loads tells of the unknowns, M of `load_plan`, shape (m, p, p).

        Noises as of `adapt`; without `depth_noise` the way down is not measured.
        """
        size = load_noise_of(self.table, load_noise)
        by, by_load = self.bench(loads, depth=depth_noise is not None).derivatives(self.start)
        own = self.noise**2 + self.model**2
        own = own if depth_noise is None else np.append(own, depth_noise**2)
        unsure = np.diag(own) + size**2 * by_load @ by_load.swapaxes(1, 2)
        return np.asarray(by.swapaxes(1, 2) @ np.linalg.solve(unsure, by))

    @cached_property
    def tared(self) -> Array:
        """What is known, as a matrix of information, after one reading of the load nearest to none, shape (p, p)."""
        rest = np.clip(np.zeros(len(self.forces)), self.table.map.low, self.table.map.high)
        return np.asarray(np.linalg.inv(self.covariance) + self.told(rest[None])[0])

    @property
    def in_use(self) -> Array:
        """Which unknowns stay where the sensor is used, away from the bench, shape (p,)."""
        names = [each.name for each in self.setup.parameters]
        return np.array([name not in CELL for name in names] + [True] * (len(self.start) - len(names)))

    def force_covariance(self, p: Array, covariance: Array, forces: Array) -> Array:
        """Return the covariance of forces that are read, shape (m, d, d) [N^2], at loads (m, d).

        `p` and `covariance` are of parameters and factors.
        """
        answers, by = self.force_slopes(p, forces)
        own = np.diag(self.noise**2 + self.model**2)
        spread = np.einsum("mnp,pq,moq->mno", by, covariance, by) + own
        return np.asarray(answers @ spread @ answers.swapaxes(1, 2))

    def force_slopes(self, p: Array, forces: Array) -> tuple[Array, Array]:
        """Return derivatives of forces by inductances, A of the module docstring, (m, d, n), and of these, (m, n, p).

        By unknowns that stay away from the bench; zero by others.
        """
        used, kept = self.in_use, self._slopes
        at = np.where(used, p, self.start)
        key = at.tobytes() + forces.tobytes()
        if key not in kept:
            kept[key] = self.bench(forces).derivatives(at)
        by, by_load = kept[key]
        answers = np.linalg.pinv(by_load / self.noise[:, None]) / self.noise
        return np.asarray(answers), np.where(used, by, 0.0)


@dataclass(frozen=True)
class Adaptation:
    """What readings tell of a built sensor.

    Attributes
    ----------
    prior : Prior
        The calibrated sensor, and what was unknown.
    measured : Measured
        The readings.
    names : tuple of str
        Of the unknowns of sensor and bench, then of the factors of shared errors.
    values, deviations : ndarray, shape (p,)
        Where the posterior is largest, and its standard deviations [SI].
    covariance : ndarray, shape (p, p)
    chi_square : float
        Least of the module docstring; `numbers` the numbers read.
    residual : ndarray, shape (m, n)
        Readings less what the adapted sensor shows, loads as read [H].
    structured : float, freedom : int
        Of the same what no unknown can move, as a chi^2, and its degrees of freedom.
    before : ndarray, shape (m, n)
        Readings less what the calibration shows [H].
    """

    prior: Prior
    measured: Measured
    names: tuple[str, ...]
    values: Array
    covariance: Array
    chi_square: float
    numbers: int
    residual: Array
    structured: float
    freedom: int
    before: Array

    @property
    def deviations(self) -> Array:
        """The standard deviations of the posterior."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance)))

    @property
    def p_value(self) -> float:
        """The probability that such a sensor fits its readings worse."""
        return float(chi2.sf(self.chi_square, self.numbers))

    @property
    def p_structured(self) -> float:
        """The probability that noise leaves more which no unknown can move; 1 where nothing is left to tell."""
        return float(chi2.sf(self.structured, self.freedom)) if self.freedom else 1.0

    @property
    def identified(self) -> tuple[str, ...]:
        """The unknowns that the readings determine, beyond what was known."""
        before = np.sqrt(np.diagonal(self.prior.covariance))
        parameters = len(self.prior.setup.parameters)
        return tuple(np.array(self.names)[:parameters][(self.deviations < _DETERMINED * before)[:parameters]].tolist())

    @property
    def correlation(self) -> Array:
        """The correlations of the posterior, shape (p, p)."""
        return np.asarray(self.covariance / np.outer(self.deviations, self.deviations))

    def force_deviations(self, forces: ArrayLike) -> tuple[Array, Array]:
        """Return the deviations of forces that are read at loads (m, d), before and after, (m, d) each [N].

        Before: by the calibration as it is, tared at rest.
        """
        at = np.asarray(forces, dtype=float)
        each = ((self.prior.start, inverted(self.prior.tared)), (self.values, self.covariance))
        found = [np.sqrt(np.einsum("mdd->md", self.prior.force_covariance(*one, at))) for one in each]
        return found[0], found[1]


def inverted(information: Array) -> Array:
    """Return the covariance of a matrix of information, of unknowns in metres, farads, ..."""
    size = np.sqrt(np.diagonal(information))
    return np.asarray(np.linalg.inv(information / np.outer(size, size)) / np.outer(size, size))


def prior_of(
    sensor: Sensor, data: xr.Dataset, unknown: Sequence[str] = (), *, noise: float | None = None
) -> Prior:
    """Return a calibrated sensor with what is unknown of it.

    Parameters
    ----------
    sensor, data
        As from `calibrate`.
    unknown : sequence of str
        Names or texts as of `setup.known`; by default all that a sensor and its bench have (`priors`).
    noise : float, optional
        Of an inductance that is read [H]; by default the converter's.
    """
    request, names = json.loads(data.attrs["request"]), several(data)
    known = priors(sensor, unknown or usual_unknowns(sensor, request["magnetics"], names))
    loads = [wrench_of(row) for row in points(data)]
    asked = float(data.attrs["magnetics_tolerance"])
    tolerance = max(asked, min(_COARSER * asked, _COARSEST))

    def coarser(scene: Sensor) -> MagneticModel:
        """Return the magnetic model by which the set-up's changes are read."""
        return loaded_model(scene, request["magnetics"], tolerance, loads)[0]

    setup, table = Setup(sensor, known, coarser), table_of(sensor, data, names)
    needs = {each.name for each in known} & {*LAYER}
    slopes = layer_slopes(sensor, data, names, request["mechanics"], request["tolerance"]) if needs else None
    model = np.hypot(_own_errors(sensor, data, table), _roughness(setup, table))
    return Prior(sensor, data, setup, table, slopes, _noise(sensor, data, noise), model)


def _roughness(setup: Setup, table: Table) -> Array:
    """Return by how much the model of the set-up's changes scatters about the table, over some loads, (n,) [H]."""
    some = np.linspace(0, len(table.poses) - 1, min(_SOME, len(table.poses))).astype(int)
    known = np.array([[each.value or 0.0 for each in setup.parameters]])
    off = setup.readings(table.poses[None, some], known)[0] - table.L[some]
    return np.asarray(np.std(off, axis=0))


def _noise(sensor: Sensor, data: xr.Dataset, noise: float | None) -> Array:
    """Return the noise of a reading of each coil [H]."""
    if noise is not None:
        return np.full(len(sensor.coils), noise)
    try:
        return np.asarray(sensor_front_end(sensor, data)[0].noise)
    except ValueError as error:
        raise SceneError(f"noise: must be given, the scene's converter has none; {error}") from None


def _own_errors(sensor: Sensor, data: xr.Dataset, table: Table) -> Array:
    """Return deviations of each coil's inductance by errors that are of each load alone, and the map's, (n,) [H]."""
    own = own_inductances(sensor, data)
    error = own["error_L"]
    if table.parts is not None:
        error = error - abs(own["shared_L"].isel(part=np.flatnonzero(_of_poses(data)))).sum("part")
    each = error.transpose(..., "coil").to_numpy().reshape(-1, error.sizes["coil"])
    alone = np.sqrt(np.nanmean(np.maximum(each, 0.0) ** 2, axis=0))
    between = np.where(np.isfinite(table.map.rms), table.map.rms, table.map.error)
    return np.asarray(np.hypot(_MAGNETIC * alone, between))


def _of_poses(data: xr.Dataset) -> NDArray[np.bool_]:
    """Return which shared parts of errors are of poses, shape (part,)."""
    parts = np.stack([data[f"shared_{name}"].transpose(..., "part").fillna(0.0).to_numpy() for name in POSE])
    return np.asarray(np.any(parts, axis=tuple(range(parts.ndim - 1))), dtype=np.bool_)


def adapt(
    prior: Prior, measured: Measured, *, load_noise: float | None = None, depth_noise: float = 1e-5
) -> Adaptation:
    """Return what readings tell of a built sensor.

    Parameters
    ----------
    prior : Prior
        From `prior_of`.
    measured : Measured
        Readings under loads; a load that was not measured is NaN, and then found from the readings themselves.
    load_noise : float, optional
        Deviation of a load that is read [N]; by default a thousandth of the largest of the table.
    depth_noise : float
        The same of the target's way down, where it was measured [m].

    Raises
    ------
    SceneError
        When loads lie beyond the table for every modulus, or an unknown is at the end of its reach.
    """
    table, n, m = prior.table, len(prior.noise), len(measured.L)
    size = load_noise_of(table, load_noise)
    blind = ~np.isfinite(measured.forces)
    forces = np.where(blind, 0.5 * (table.map.low + table.map.high), measured.forces)
    bench = prior.bench(forces, loose=True, depth=measured.depth is not None)
    y, scale = measured.L, np.tile(np.hypot(prior.noise, prior.model), (m, 1))
    if measured.depth is not None:
        y, scale = np.column_stack([y, measured.depth]), np.column_stack([scale, np.full(m, depth_noise)])
    misread = _misread(table, forces, blind, size)
    free = [*_free(prior, forces), *_factors(bench.count[1]), *misread]
    fit = fit_parameters(bench.model, y, free, noise=scale, slopes=bench.slopes)
    p = len(prior.start)
    none, freedom = _structured(bench, fit, scale, misread)
    before = measured.L - bench.model(np.concatenate([prior.start, np.zeros(forces.size)])[None])[0][:, :n]
    return Adaptation(
        prior, replace(measured, forces=forces), fit.names[:p], fit.values[:p], fit.covariance[:p, :p],
        fit.chi_square, int(np.isfinite(y).sum()), fit.residual[:, :n], none, freedom, before,
    )


def load_noise_of(table: Table, asked: float | None) -> float:
    """Return the deviation of a load that is read [N], as asked for or the usual one."""
    return float(_LOAD * np.max(np.abs([table.map.low, table.map.high]))) if asked is None else asked


def _free(prior: Prior, forces: Array) -> list[Free]:
    """Return the parameters of sensor and bench to be fitted."""
    (softest, stiffest), why = moduli(forces, prior.table, prior.forces)
    room = 1e-3 * (stiffest - softest)
    modulus = Free("modulus", 1.0, softest + room, stiffest - room, 1.0, beyond=why)
    parameters = prior.setup.parameters
    if not softest <= 1.0 <= stiffest and all(each.name != "modulus" for each in parameters):
        raise SceneError(f"table: must reach beyond the measured forces; {why[int(softest <= 1.0)]}")
    found = prior.setup.free(prior.table.poses, {"modulus": modulus})
    if any(not each.low < each.high for each in found if each.name == "modulus"):
        raise SceneError(f"table: must reach beyond the measured forces; {why[0] or why[1]}")
    least = -prior.sensor.readout.lead_inductance  # no lead has less than none
    found = tuple(replace(each, low=max(each.low, least), wall=True) if each.name == "lead" else each for each in found)
    return [replace(each, start=float(np.clip(each.start, each.low, each.high))) for each in found]


def _factors(count: int) -> list[Free]:
    """Return the factors of shared errors."""
    return [Free(f"error {k + 1}", 0.0, -_WIDEST * HALF, _WIDEST * HALF, HALF, HALF) for k in range(count)]


def _misread(table: Table, forces: Array, blind: NDArray[np.bool_], noise: float) -> list[Free]:
    """Return what each load may be misread by, row by row; a load that is not known is one of the table's."""
    found = []
    for row, (loads, unseen) in enumerate(zip(forces.tolist(), blind.tolist(), strict=True), 1):
        for k, (name, load, alone) in enumerate(zip(table.map.names, loads, unseen, strict=True)):
            low, high = (float(end[k]) - load for end in (table.map.low, table.map.high))
            if not alone:
                low, high = -_WIDEST * noise, _WIDEST * noise
            size = 0.5 * (high - low) if alone else noise
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
