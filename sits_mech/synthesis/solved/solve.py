"""Solve one design: sizes first, then the overload, then the loads that the sensor meets; no more than asked.

The overload's corners are solved as `overload.py` has it. A design that does not carry one, whose target comes to the
coils, or that is no scene at all, is rejected with its reason and solved no further. Of the others a table of
inductances over the loads is made, with its derivatives and its errors (chain/derivatives/gradient_grid.py); figures
that need none of that ask for none. Errors of the figures are those of `readout.quality`, that of the strain is what
the last refinement of the mesh changed.

    height, footprint   of the box around coils, fixed parts, layer and target at rest
    strain              (largest stretch - 1) under the overload over that of the data behind the silicone's constants
    rate                readings of all coils a second, by the longest conversion that is fast enough
    hysteresis          widest difference of loading and unloading at one load, over the peak, of a pad that comes and
                        goes in a second and answers like a spring with the silicone's viscosity and softening
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.limits import corners
from sits_mech.analysis.readings.bench import coil_table, sensor_calibration, sensor_front_end, table_inductances
from sits_mech.chain.derivatives.gradient_grid import gradient_on_grid
from sits_mech.chain.derivatives.temperature import CHAINED, read_slopes
from sits_mech.chain.models import choose_mechanics
from sits_mech.quantities import Array, SolveFailed
from sits_mech.readout.loads import answered
from sits_mech.readout.quality import quality
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import SceneError, Sensor, silicones_of
from sits_mech.silicone.history import loop_width
from sits_mech.status import NOT_CARRIED, OK
from sits_mech.store import case_path, finish, read_case
from sits_mech.synthesis.required.kinds import INVERSE, STRAIN
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.space import Design, size_of
from sits_mech.synthesis.solved.answered import LEAST_INVERSE, Answered, Task
from sits_mech.synthesis.solved.figures import Judge, Table
from sits_mech.synthesis.solved.loads import FEW, Loads, Operator, loads_between
from sits_mech.synthesis.solved.overload import Overload, linear_strain, overload_of, strain_at_end
from sits_mech.version import __version__

COARSE, FINE = 5e-2, 1e-2
"""Tolerances of the chain: of a search, of the recommended design."""
_SLOPE = 1e-4  # of the unit box: differences of sizes and of linear theory by the variables
_PART = 0.1  # of a deviation: the same by the tolerances
_OFFSETS = ("coils.*.centre.0", "coils.*.centre.1")
_OF_TABLE = ("resolution", "error", "drift", "crosstalk_before_inverse", "rate")
_SLOWEST = 0xFFFF  # count of a conversion


@dataclass(frozen=True)
class Solver:
    """Solver of designs to a tolerance of the chain."""

    requirements: Requirements
    tolerance: float
    folder: Path | None = None  # where answers are kept, and looked for first

    @cached_property
    def operator(self) -> Operator:
        """The interpolation of tables between their loads, the same for every tolerance."""
        return Operator(loads_between(self.requirements.loads))

    @cached_property
    def solved(self) -> Loads:
        """The loads that are solved for a table: those that it has, or in a search fewer."""
        return loads_between(self.requirements.loads, FEW) if self.tolerance >= COARSE else self.operator.loads

    @cached_property
    def scattering(self) -> dict[str, float]:
        """Return the deviations of tolerances that change a table; the coils' offset along each axis of the loads."""
        still = ("repeatability", "coil_offset")
        found = {name: size for name, size in self.requirements.tolerance.items() if name not in still}
        if "coil_offset" in self.requirements.tolerance:
            ways = _OFFSETS if any(name in self.requirements.loads for name in ("F_y", "M_x")) else _OFFSETS[:1]
            found |= dict.fromkeys(ways, self.requirements.tolerance["coil_offset"])
        return found

    @cached_property
    def task(self) -> Task:
        """Return limits and minimised figures for an answer."""
        asked = self.requirements
        limits = asked.limits | {STRAIN: 1.0}
        if self.needs_table:
            limits |= {INVERSE: LEAST_INVERSE}
        judge = Judge(
            self.operator, np.array(list(self.scattering.values())), asked.limits | {STRAIN: 1.0}, asked.least_yield
        )
        return Task(judge, limits, asked.minimised, tolerance=self.tolerance)

    @property
    def needs_table(self) -> bool:
        """Whether any figure that is asked for needs inductances."""
        asked = {*self.requirements.limits, *self.requirements.minimised}
        return any(name.partition(".")[0] in _OF_TABLE for name in asked)

    @property
    def _by_temperature(self) -> tuple[str, ...]:
        """Return the parameters of temperature, where any figure that is asked for needs them."""
        asked = {*self.requirements.limits, *self.requirements.minimised}
        return CHAINED if any(name.startswith("drift.") for name in asked) else ()

    def __call__(self, design: Design) -> Answered:
        """Solve a design, or read it where it is kept."""
        key = f"{__version__} {self.tolerance} {self.requirements.identity}"
        path = case_path(self.folder, key, {"choice": list(design.choice), "x": list(design.x)})
        kept = read_case(path)
        if kept is None:
            kept = finish(path, _packed(self.answered(design)))
        return _unpacked(design, kept)

    def answered(self, design: Design) -> Answered:
        """Solve a design."""
        began, v = time.process_time(), len(design.x)
        try:
            sensor = self.requirements.space.sensor(design)
        except SceneError as error:
            return Answered(design, f"impossible: {error}", None, np.zeros((v, 0, 0)), {}, {})
        plain, slopes = self._sizes(design, sensor)
        worst = overload_of(sensor, self._overloads, self.tolerance, finely=self.tolerance < COARSE)
        plain[STRAIN] = worst.strain
        known = {} if np.isnan(worst.error) else {STRAIN: worst.error}
        found = Answered(design, worst.reason, None, np.zeros((v, 0, 0)), plain, slopes, known)
        by_x = self._strain_slopes(design, sensor, worst)
        if by_x is not None:
            slopes[STRAIN] = by_x
        if not worst.reason and self.needs_table:
            try:
                found = self._with_table(found, sensor, self._by_tolerance(sensor, worst))
            except (SolveFailed, ValueError) as refusal:
                found = replace(found, reason=str(refusal))
        return replace(found, seconds=time.process_time() - began)

    def _sizes(self, design: Design, sensor: Sensor) -> tuple[dict[str, float], dict[str, Array]]:
        """Return sizes and hysteresis of a design, and their derivatives by the variables."""
        plain = size_of(sensor)
        moved = [self.requirements.space.sensor(each) for each, _ in _one_step_off(design)]
        ways = [way for _, way in _one_step_off(design)]
        slopes = {name: np.zeros(len(design.x)) for name in plain}
        for k, (there, way) in enumerate(zip(moved, ways, strict=True)):
            for name, size in size_of(there).items():
                slopes[name][k] = (size - plain[name]) / way
        if "hysteresis" in {*self.requirements.limits, *self.requirements.minimised} and sensor.elastomer is not None:
            plain["hysteresis"] = max(map(loop_width, silicones_of(sensor)))
        return plain, slopes

    @property
    def _overloads(self) -> dict[str, tuple[float, float]]:
        """Return the ranges of the loads that the pad carries."""
        asked = self.requirements
        return {name: (asked.overload * low, asked.overload * high) for name, (low, high) in asked.loads.items()}

    def expected(self, sensor: Sensor) -> tuple[float, float]:
        """Return the largest strain under the overload by linear theory, over what is known of the silicone.

        With it the one from which on the silicone is surely beyond its data under that load.
        """
        each = {load: linear_strain(sensor, load) for load in corners(sensor, self._overloads)}
        worst = max(each, key=lambda load: np.nan_to_num(each[load]))
        return each[worst], strain_at_end(sensor, worst)

    def scattered(self, sensor: Sensor) -> Iterator[Sensor]:
        """Yield sensors that are one deviation of each tolerance away, but of their coils' places."""
        for name, deviation in self.scattering.items():
            if name not in _OFFSETS:
                with suppress(SceneError):
                    yield parameter(sensor, name).changed(deviation)

    def _strain_slopes(self, design: Design, sensor: Sensor, worst: Overload) -> Array | None:
        """Return derivatives of the strain by the variables: of its own size as linear theory has them."""
        here = linear_strain(sensor, worst.load)
        there = [linear_strain(self.requirements.space.sensor(each), worst.load) for each, _ in _one_step_off(design)]
        ways = np.array([way for _, way in _one_step_off(design)])
        found = (np.array(there) / here - 1.0) / ways * worst.strain
        return found if np.isfinite(found).all() else None

    def _by_tolerance(self, sensor: Sensor, worst: Overload) -> dict[str, Array]:
        """Return derivatives of sizes and strain by the tolerances, shape (p,)."""
        plain, here = size_of(sensor), linear_strain(sensor, worst.load)
        found = {name: np.zeros(len(self.scattering)) for name in (*plain, STRAIN)}
        for k, (name, deviation) in enumerate(self.scattering.items()):
            if name in _OFFSETS:
                continue
            for step in (_PART * deviation, -_PART * deviation):
                with suppress(SceneError):
                    there = parameter(sensor, name).changed(step)
                    for key, size in size_of(there).items():
                        found[key][k] = (size - plain[key]) / step
                    found[STRAIN][k] = worst.strain * (linear_strain(there, worst.load) / here - 1.0) / step
                    break
        return {name: own for name, own in found.items() if np.isfinite(own).all() and own.any()}

    def _with_table(self, found: Answered, sensor: Sensor, scattered: Mapping[str, Array]) -> Answered:
        """Return a design that carries the overload with its table over the loads."""
        space, loads = self.requirements.space, self.solved
        between = Operator(loads).values(self.operator.loads.points)  # from the solved loads to those of the table
        axes = {name: axis.tolist() for name, axis in zip(loads.names, loads.axes, strict=True)}
        names = (*space.names, *self.scattering, *self._by_temperature)
        mechanics = self._mechanics(found.design.choice, sensor)
        data = gradient_on_grid(
            sensor, tuple(dict.fromkeys(names)), axes, tolerance=self.tolerance, mechanics=mechanics
        )
        if not bool(answered(data).all()):
            return replace(found, reason=next(str(each) for each in data["reason"].to_numpy().ravel() if each))
        own = table_inductances(sensor, data)
        L = between @ own["L"].transpose(*loads.names, "coil").to_numpy().reshape(-1, len(sensor.coils))
        each = _slopes_of(sensor, data, own["L0"].to_numpy(), between)
        width = [space.width(variable, sensor) for variable in space.variables]
        own_noise, repeated, rate = self.converter(sensor, data)
        noise = np.hypot(own_noise, repeated)
        sizes = {name: (found.plain[name], by) for name, by in scattered.items()}
        table = Table(L, np.array([each[name] for name in self.scattering]).reshape(-1, *L.shape), noise, sizes)
        more = {"rate": rate}
        if self._by_temperature:
            by_cause = np.array([each[name] for name in self._by_temperature])
            more |= self.task.judge.drift(table, read_slopes(sensor, L, by_cause))
        by_x = np.array([each[name] * size for name, size in zip(space.names, width, strict=True)])
        return replace(
            found, table=table, by_x=by_x.reshape(-1, *L.shape), plain=found.plain | more, converter=own_noise,
            error=found.error | figure_errors(sensor, data, self.task.judge, table),
        )

    def _mechanics(self, choice: tuple[int, ...], sensor: Sensor) -> str:
        """Name the model of a design's table: of finite strain where any corner of its choice needs it.

        So no two designs that are compared differ by their models.
        """
        space, ranges = self.requirements.space, self.requirements.loads
        names = set()
        for ends in product((0.0, 1.0), repeat=len(space.variables)):
            with suppress(SceneError):
                corner = space.sensor(Design(choice, ends))
                names.add(choose_mechanics(corner, "auto", corners(corner, ranges), self.tolerance).name)
        return "auto" if names <= {"linear"} else choose_mechanics(sensor).name

    def converter(self, sensor: Sensor, data: xr.Dataset) -> tuple[Array, Array, float]:
        """Return each inductance's noise by the converter and by repeatability [H], and readings a second.

        By the longest conversion that is fast enough.
        """
        asked, count = self.requirements.limits.get("rate"), _SLOWEST
        front, _ = sensor_front_end(sensor, data)
        n = len(sensor.coils)
        if asked is not None and front.rate < asked:
            too_long = 1.0 / front.rate - 1.0 / asked
            count = int(np.clip(_SLOWEST - too_long / n * front.reference / 16.0, *front.part.rcount))
            front, _ = sensor_front_end(sensor, data, rcount=count)
        most = np.nanmax(table_inductances(sensor, data)["L"].to_numpy().reshape(-1, n), axis=0)
        own = self.requirements.tolerance.get("repeatability", 0.0) * most
        return np.asarray(front.noise), np.asarray(own), float(front.rate)


def _one_step_off(design: Design) -> list[tuple[Design, float]]:
    """Return the designs a little beside one along each variable, and how far."""
    ways = [-_SLOPE if x > 0.5 else _SLOPE for x in design.x]
    return [(design.moved(k, way), way) for k, way in enumerate(ways)]


def figure_errors(sensor: Sensor, data: xr.Dataset, judge: Judge, table: Table) -> dict[str, float]:
    """Return errors of a table's figures from those of its loads; empty where these are too few for a calibration."""
    try:
        cal = sensor_calibration(sensor, data)
    except ValueError:
        return {}
    found, tared = quality(cal, table.noise, table=coil_table(sensor, data)), judge.tared_errors(table)
    off = found.error_sensitivity / np.abs(found.sensitivity).max(axis=0)
    errors = {}
    for k, name in enumerate(cal.forces):
        errors[f"resolution.{name}"] = float(np.max(off[:, k]) * found.resolution[k, 2])
        errors[f"error.{name}"] = float(found.crosstalk_error[k] * tared.max())
    return errors | {"crosstalk_before_inverse": float(np.max(found.crosstalk_error))}


def _slopes_of(sensor: Sensor, data: xr.Dataset, L0: Array, between: Array) -> dict[str, Array]:
    """Return derivatives of each coil's inductance by each parameter, shape (g, n) [H]; `between` from solved loads."""
    n = len(sensor.coils)
    scale = L0 / np.diagonal(data["L0"].to_numpy()) if data.attrs["unit_L"] != "H" else np.ones(n)
    own = np.diagonal(data["by_L"].transpose(..., "parameter", "coil", "coil_2").to_numpy(), axis1=-2, axis2=-1)
    values = own.reshape(-1, data.sizes["parameter"], n) * scale
    return {str(name): between @ values[:, k] for k, name in enumerate(data["parameter"].to_numpy())}


def _packed(found: Answered) -> dict[str, Any]:
    """Return an answer as a row."""
    row = {"status": OK if found.carried else NOT_CARRIED, "lasting": True, "reason": found.reason}
    row |= {"plain": found.plain, "plain_by_x": {name: own.tolist() for name, own in found.plain_by_x.items()}}
    row |= {"error": found.error, "seconds": found.seconds, "by_x": found.by_x.tolist()}
    if found.table is not None:
        row["table"] = [each.tolist() for each in found.table[:3]]
        row["converter"] = found.converter.tolist()
        row["sizes"] = {name: [value, by.tolist()] for name, (value, by) in found.table.sizes.items()}
    return row


def _unpacked(design: Design, row: Mapping[str, Any]) -> Answered:
    """Return the answer of a row."""
    sizes = {name: (value, np.array(by, dtype=float)) for name, (value, by) in row.get("sizes", {}).items()}
    parts = [np.array(each, dtype=float) for each in row.get("table", ())]
    table = Table(parts[0], parts[1], parts[2], sizes) if parts else None
    if table is not None and not table.by_tolerance.size:
        table = table._replace(by_tolerance=np.zeros((0, *table.L.shape)))
    shape = (len(design.x), *table.L.shape) if table is not None else (len(design.x), 0, 0)
    by_x = np.array(row["by_x"], dtype=float).reshape(shape)
    slopes = {name: np.array(own, dtype=float) for name, own in row["plain_by_x"].items()}
    converter = np.array(row.get("converter", ()), dtype=float)
    return Answered(design, row["reason"], table, by_x, row["plain"], slopes, row["error"], row["seconds"], converter)
