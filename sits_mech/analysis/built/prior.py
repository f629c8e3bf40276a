"""State what is known of a sensor before it is read, and what a reading would tell: a calibration with its unknowns.

Unknown are the numbers of the built sensor and of its bench (`unknowns`, `setup`), and a factor for each part of the
errors that the whole table shares. A reading under a load F, itself misread by u, tells of them (`load_plan`)

    M(F) = L_theta^T (sigma^2 + L_F U L_F^T)^-1 L_theta,     U = cov u,

and a force that is read is off by

    dF = A dL,    A = (W L_F)^+ W,    W = 1/noise,    cov F = A (L_theta Sigma L_theta^T + sigma^2) A^T.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from numbers import Real

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from sits_mech.analysis.bench.force_maps import ForceMaps, force_maps_of, layer_slopes
from sits_mech.analysis.bench.loaded import LoadedBench
from sits_mech.analysis.bench.setup import Setup
from sits_mech.analysis.bench.unknowns import CELL, LAYER, PriorParameter, priors, usual_unknowns
from sits_mech.analysis.readings.bench import sensor_front_end, table_inductances, with_idle
from sits_mech.chain.models import loaded_model
from sits_mech.maps.surrogate import SmoothMap
from sits_mech.quantities import UNITS, Array, MagneticModel
from sits_mech.readout.loads import points, request_of, several, varied, wrench_of
from sits_mech.readout.table_errors import error_parts
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.units import shown

HALF = 0.5
"""Deviation of a pose over its estimated error; d_h, d_v, alpha by benchmarks/adapted_twins.py: 0.76, 0.23, 0.06 of
biorob2018-w15, 0.24, 0.46, 0.11 of triaxial-4."""
OWN = 0.2
"""Of what loads do not share of a pose's errors: what one factor for all of them leaves, two deviations. Of alpha of
biorob2018-w15 at F_x 0.25 N, tolerance 0.03, the true errors beside 0.003 are 0.44 +- 0.10 of it."""
_LOAD = 1e-3  # of the largest force of the table, each: noise of a load, unless it is given


@dataclass(frozen=True)
class Prior:
    """A calibrated sensor with what is unknown of it, before anything is read."""

    sensor: Sensor
    data: xr.Dataset
    setup: Setup
    table: ForceMaps
    slopes: SmoothMap | None  # of `layer_slopes`
    noise: Array  # of a reading of each coil, converter or bench alone (n,) [H]
    model: Array  # deviation of the table's own errors (n,) [H]
    factors: tuple[PriorParameter, ...]  # of the parts of the errors that the table shares
    root: Array | None = None  # B of fit.py of parameters and factors, (p, p), where they are known together
    _slopes: dict[bytes, tuple[Array, Array]] = field(default_factory=dict, repr=False)  # those asked for before

    @property
    def forces(self) -> tuple[str, ...]:
        """The forces of the table."""
        return self.table.map.names

    def bench(self, forces: Array, *, loose: bool = False, depth: bool = False) -> LoadedBench:
        """Return the model of what rows of loads show."""
        return LoadedBench(self.setup, self.table, forces, self.slopes, True, loose, depth)

    def read_by(self, idle: str | None = None, *, tank: bool | None = None) -> Prior:
        """Return the sensor as another bench reads it: what its idle coils are, and whether a `tank` tells inductances.

        Either as before by None.
        """
        sensor = with_idle(self.sensor, idle)
        setup = replace(self.setup, sensor=sensor, tank=self.setup.tank if tank is None else tank)
        if setup == self.setup:
            return self
        return replace(
            self, sensor=sensor, setup=setup, table=force_maps_of(sensor, self.data, self.forces), _slopes={}
        )

    @property
    def known(self) -> tuple[PriorParameter, ...]:
        """What is known of parameters and factors, each alone."""
        return (*self.setup.parameters, *self.factors)

    @cached_property
    def start(self) -> Array:
        """What is known beforehand of parameters and factors, shape (p,)."""
        return np.array([each.value or 0.0 for each in self.known])

    @cached_property
    def deviations(self) -> Array:
        """Their standard deviations, shape (p,)."""
        return np.array([each.deviation for each in self.known])

    @cached_property
    def covariance(self) -> Array:
        """Their covariance, shape (p, p)."""
        alike = np.eye(len(self.start)) if self.root is None else np.linalg.inv(self.root.T @ self.root)
        return alike * np.outer(self.deviations, self.deviations)

    def fisher(self, loads: Array, load_noise: ArrayLike | None = None, depth_noise: ArrayLike | None = None) -> Array:
        """Return what a reading under each of m loads tells of the unknowns, M of `load_plan`, shape (m, p, p).

        Noises as of `adapt`, of all loads or of each, (m, d) and (m,); without `depth_noise` the way down is not
        measured.
        """
        size = np.broadcast_to(load_noise_of(self.table, load_noise), loads.shape)
        by, by_load = self.bench(loads, depth=depth_noise is not None).derivatives(self.start)
        own = np.tile(self.noise**2 + self.model**2, (len(loads), 1))
        if depth_noise is not None:
            own = np.column_stack([own, np.broadcast_to(np.square(depth_noise), len(loads))])
        unsure = own[..., None] * np.eye(own.shape[1]) + by_load * size[:, None] ** 2 @ by_load.swapaxes(1, 2)
        return by.swapaxes(1, 2) @ np.linalg.solve(unsure, by)

    @cached_property
    def tared(self) -> Array:
        """What is known, as a matrix of information, after one reading of the load nearest to none, shape (p, p)."""
        rest = np.clip(np.zeros(len(self.forces)), self.table.map.low, self.table.map.high)
        return np.asarray(inverted(self.covariance) + self.fisher(rest[None])[0])

    @property
    def in_use(self) -> Array:
        """Which unknowns stay where the sensor is used, away from the bench, shape (p,)."""
        return np.array([each.name not in CELL for each in self.known])

    def used(self, P: Array) -> Array:
        """Return unknowns (..., p) as they are where the sensor is used: of no load cell, whatever is known of one."""
        return np.where(self.in_use, P, [float(each.name == "cell") for each in self.known])

    def known_together(self, known: Sequence[PriorParameter], correlation: Array) -> Prior:
        """Return the sensor with something else known of its unknowns: each alone, and their correlation (p, p)."""
        count = len(self.setup.parameters)
        setup = replace(self.setup, parameters=tuple(known[:count]))
        root = np.linalg.inv(np.linalg.cholesky(correlation))
        return replace(self, setup=setup, factors=tuple(known[count:]), root=root, _slopes={})

    def force_covariance(self, p: Array, covariance: Array, forces: Array) -> Array:
        """Return the covariance of forces that are read, shape (m, d, d) [N^2], at loads (m, d).

        `p` and `covariance` are of parameters and factors.
        """
        answers, by = self.force_slopes(p, forces)
        spread = np.einsum("mnp,pq,moq->mno", by, covariance, by) + np.diag(self.noise**2 + self.model**2)
        return np.asarray(answers @ spread @ answers.swapaxes(1, 2))

    def slopes_at(self, p: Array, forces: Array) -> tuple[Array, Array]:
        """Return derivatives of inductances at loads (m, d) by unknowns, (m, n, p), and by loads, (m, n, d); kept."""
        key, kept = p.tobytes() + forces.tobytes(), self._slopes
        if key not in kept:
            kept[key] = self.bench(forces).derivatives(p)
        return kept[key]

    def force_slopes(self, p: Array, forces: Array) -> tuple[Array, Array]:
        """Return derivatives of forces by inductances, A of the module docstring, (m, d, n), and of these, (m, n, p).

        By unknowns that stay away from the bench; zero by others.
        """
        by, by_load = self.slopes_at(self.used(p), forces)
        answers = np.linalg.pinv(by_load / self.noise[:, None]) / self.noise
        return np.asarray(answers), np.where(self.in_use, by, 0.0)


def inverted(information: Array) -> Array:
    """Return the covariance of a matrix of information, of unknowns in metres, farads, ..., or the other way round."""
    size = np.sqrt(np.diagonal(information))
    return np.asarray(np.linalg.inv(information / np.outer(size, size)) / np.outer(size, size))


def root_of(matrix: Array) -> Array:
    """Return B of a symmetric matrix B B^T without negative parts."""
    size, turn = np.linalg.eigh(matrix)
    return np.asarray(turn * np.sqrt(np.maximum(size, 0.0)))


def prior_of(sensor: Sensor, data: xr.Dataset, unknown: Sequence[str] = (), *, noise: float | None = None) -> Prior:
    """Return a calibrated sensor with what is unknown of it.

    `unknown` are names or texts as of `unknowns.known`, by default all that a sensor and its bench have; `noise` is of
    an inductance that is read [H], by default the converter's.
    """
    request, names = request_of(data), several(data)
    known = priors(sensor, unknown or usual_unknowns(sensor, (request["mechanics"], request["magnetics"]), names))
    loads = [wrench_of(row) for row in points(data)]
    asked = float(data.attrs["magnetics_tolerance"])

    def model(scene: Sensor) -> MagneticModel:
        """Return the table's magnetic model, of a changed scene."""
        return loaded_model(scene, request["magnetics"], asked, loads)[0]

    setup, table = Setup(sensor, known, model), force_maps_of(sensor, data, names)
    needs = {each.name for each in known} & {*LAYER}
    slopes = layer_slopes(sensor, data, names, request["mechanics"], request["tolerance"]) if needs else None
    factors = tuple(PriorParameter(f"error {k + 1}", 0.0, HALF) for k in range(table.shared))
    own = _own_errors(sensor, data, table)
    return Prior(sensor, data, setup, table, slopes, _noise(sensor, data, noise), own, factors)


def _noise(sensor: Sensor, data: xr.Dataset, noise: float | None) -> Array:
    """Return the noise of a reading of each coil [H]."""
    check_deviation("noise", noise, "H")
    if noise is not None:
        return np.full(len(sensor.coils), noise)
    try:
        return sensor_front_end(sensor, data)[0].noise
    except ValueError as error:
        raise SceneError(f"noise: must be given, the scene's converter has none; {error}") from None


def _own_errors(sensor: Sensor, data: xr.Dataset, table: ForceMaps) -> Array:
    """Return deviations of each coil's inductance by errors that are of each load alone, and the map's, (n,) [H]."""
    _, alone, rest = error_parts(table_inductances(sensor, data), varied(data))
    each = HALF * (rest + OWN * np.abs(alone).sum(axis=0))
    root = np.sqrt(np.nanmean(each.reshape(-1, each.shape[-1]) ** 2, axis=0))
    between = np.where(np.isfinite(table.map.rms), table.map.rms, table.map.error)
    return np.hypot(root, between)


def check_deviation(name: str, value: float | None, unit: str) -> None:
    """Refuse a deviation that is no number above 0."""
    if value is not None and not (isinstance(value, Real) and 0.0 < value < np.inf):
        raise SceneError(f"{name}: must be a number above 0 [{unit}]; got {shown(value)}")


def load_noise_of(table: ForceMaps, asked: ArrayLike | None) -> Array:
    """Return deviations of loads that are read, (d,) or of each (m, d) [N, N m]: of forces as asked for, or usual."""
    usual = _LOAD * np.maximum(np.abs(table.map.low), np.abs(table.map.high))
    of_force = np.array([UNITS[name] == "N" for name in table.map.names])
    return usual if asked is None else np.where(of_force, asked, usual)
