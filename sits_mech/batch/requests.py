"""Answer one case of a scene: the requests that a study varies.

A case is a scene with changes and the arguments of a request; its answer is a row of named numbers. Cases that run in
one process share what they can: a scene's models are made once, and prepare their plates and factors once.
"""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BaseModel, create_model

from sits_mech.batch.tables import SWEPT, table_row
from sits_mech.chain.models import MAGNETICS, MECHANICS, Choice, choose_mechanics, magnetic_model, model_of
from sits_mech.chain.omitted.mechanical import mechanical_omissions, within_omissions
from sits_mech.chain.plans.goal import rest_flags
from sits_mech.chain.pressing import touch_load
from sits_mech.chain.rests import at_rest
from sits_mech.chain.simulate import simulate
from sits_mech.inputs import FORM, Reads, checked, choice, quantity_of, within
from sits_mech.mechanics.depth import TouchLoad
from sits_mech.notes import packed, packed_omissions
from sits_mech.quantities import (
    LOAD_ARGUMENTS,
    POSE,
    POSE_ARGUMENTS,
    UNITS,
    Equilibrium,
    Impedance,
    MechanicalModel,
    Pose,
    Wrench,
)
from sits_mech.scene.cells import cells_from
from sits_mech.scene.sensor import Sensor, changed, scene_table, sensor_from
from sits_mech.scene.thermal import at_temperature
from sits_mech.status import flags_of, marked
from sits_mech.store import Row
from sits_mech.units import SceneError, si_range

if TYPE_CHECKING:
    import xarray as xr

_LOAD = {argument: UNITS[name] for argument, name in LOAD_ARGUMENTS.items()}
_PITCH = {"pitch_x": "m", "pitch_y": "m"}
_PLACE = {argument: UNITS[name] for argument, name in POSE_ARGUMENTS.items()} | {"frequency": "Hz"}


@dataclass(frozen=True)
class Variant:
    """A scene with changes; hashable, so that what is made of it can be kept."""

    text: str  # of `scene_text`
    overrides: tuple[str, ...] = ()  # as on the command line

    @property
    def sensor(self) -> Sensor:
        """Return the changed scene; raise SceneError when it is impossible."""
        return _sensor(self)


@dataclass(frozen=True)
class Request:
    """A kind of request."""

    answer: Callable[[Variant, Row], Row]  # scene and arguments as written -> row
    units: Mapping[str, str]  # SI units of the arguments that are quantities
    models: Mapping[str, tuple[str, ...]]  # choices of the arguments that name a model; they come with a tolerance
    needed: tuple[str, ...] = ()  # arguments without default
    ranges: tuple[str, ...] = ()  # arguments like "-1 N:1 N:9", which a study cannot vary
    layer: bool = True  # whether the answer needs the elastomer; else it is left out of the scene
    chunk: int = 1  # cases with the same coils, or at the same rest, that go to a worker at once

    @property
    def arguments(self) -> tuple[str, ...]:
        """Return the names of all arguments."""
        return (*self.units, *self.models, "tolerance")

    @cached_property
    def table(self) -> type[BaseModel]:
        """A model of its arguments: as written, read in SI."""
        kinds = {name: (_range if name in self.ranges else quantity_of)(unit) for name, unit in self.units.items()}
        kinds |= {name: choice("auto", *known) for name, known in self.models.items()}
        kinds["tolerance"] = SHARE
        fields: Any = {name: (Annotated[Any, kind], None) for name, kind in kinds.items()}
        return create_model("arguments", __config__=FORM, **fields)

    def in_si(self, arguments: Row) -> Row:
        """Return arguments, quantities as SI numbers and ranges as lists; raise SceneError naming a bad one."""
        found = checked(self.table, arguments, "arguments")
        return {name: getattr(found, name) for name in arguments}


def _range(unit: str) -> Reads:
    """Return what reads a quantity, or a range of quantities such as "-1 N:1 N:9"."""

    def check(value: object) -> float | list[float]:
        found = si_range(str(value), unit)
        return found[0] if len(found) == 1 else found

    text = {"type": "string", "pattern": r"^[^:]+(:[^:]+:\s*[0-9]+)?$"}
    return Reads(check, {"anyOf": [{"type": "number"}, text], "x-unit": unit})


SHARE = within("", math.ulp(0.0), math.nextafter(1.0, 0.0), 'a share such as "1 %" between 0 and 1')
"""What reads a tolerance, as `checked_tolerance` does."""


@lru_cache(maxsize=64)
def _sensor(variant: Variant) -> Sensor:
    """Return a scene with its changes."""
    return changed(sensor_from(tomllib.loads(variant.text)), variant.overrides)


@lru_cache(maxsize=4)
def _mechanical(variant: Variant, choice: Choice) -> MechanicalModel:
    """Return the mechanical model of a scene."""
    return model_of(at_temperature(variant.sensor), choice, choice.tolerance)


def _pose(variant: Variant, asked: Row) -> Row:
    """Return the pose of the target at rest as a row."""
    sensor, model, tolerance = variant.sensor, asked.get("model", "auto"), asked.get("tolerance", 1e-2)
    given = _load(sensor, asked, model, tolerance)
    wrench = given.wrench
    chosen = choose_mechanics(sensor, model, [wrench], tolerance)
    numerics = tolerance if chosen.by_name else chosen.tolerance
    left_out = mechanical_omissions(sensor, chosen.name, [wrench], bent=chosen.bent)
    layer = _mechanical(variant, Choice(chosen.name, tolerance=numerics, bent=chosen.bent))
    layer = within_omissions(layer, chosen, tolerance, left_out)
    found = at_rest(sensor, layer, wrench, left_out, known=given.found)
    return _rest(found) | marked(rest_flags(sensor, found, tolerance))


def _inductance(variant: Variant, asked: Row) -> Row:
    """Return the inductances with the target at a pose as a row."""
    pose = Pose(**{name: asked.get(argument, 0.0) for argument, name in POSE_ARGUMENTS.items()})
    tolerance = asked.get("tolerance", 1e-3)
    field, _ = magnetic_model(variant.sensor, asked.get("model", "auto"), tolerance, [pose])
    found = field.impedance(pose, asked.get("frequency", variant.sensor.frequency))
    bounded = not any(item.unbounded for item in found.report.left_out)
    return _shown(found) | marked(flags_of(found.report.estimated_error, tolerance, bounded=bounded))


def _simulate(variant: Variant, asked: Row) -> Row:
    """Return pose and signals under a load as a row."""
    models = {name: item for name, item in asked.items() if name not in _LOAD}
    given = _load(variant.sensor, asked, models.get("mechanics", "auto"), 0.5 * models.get("tolerance", 1e-2))
    found = simulate(variant.sensor, given, **models)
    return _rest(found.equilibrium) | _shown(found.impedance) | found.signals.known | marked(found.flags)


def _cells(variant: Variant, asked: Row) -> Row:
    """Return what two cells, or four with `pitch_y` too, read of each other at most as a row."""
    from sits_mech.chain.cells.crosstalk import FORCES, cell_crosstalk

    x, y = asked["pitch_x"] / 2.0, asked.get("pitch_y", 0.0) / 2.0
    places = [(i * x, j * y) for j in ((-1, 1) if y else (0,)) for i in (-1, 1)]
    targets = [{"name": name, "centre": place} for name, place in zip("ABCD", places, strict=False)]
    given = cells_from(scene_table(variant.sensor) | {"targets": targets}, "cells")
    found = cell_crosstalk(given, asked.get("tolerance", 1e-2))
    row: Row = {"finite_strain": found.finite_strain}
    for before, sizes in zip(("", "error_"), found.largest, strict=True):
        each = zip(itertools.product(found.reads, FORCES), sizes.ravel(), strict=True)
        row |= {f"{before}{read}_by_{force}": size for (read, force), size in each}
    return row | marked(found.flags)


def _calibrated(variant: Variant, asked: Row) -> xr.Dataset:
    """Return a calibration over a grid of loads; a load that failed is NaN and says why."""
    from sits_mech.chain.calibrate import calibrate  # tables, here as below: to plan a study needs none

    given = {name: asked.pop(argument) for argument, name in LOAD_ARGUMENTS.items() if argument in asked}
    loads = {name: values for name, values in given.items() if values != 0.0}
    return calibrate(variant.sensor, **loads, **asked)


def _calibrate(variant: Variant, asked: Row) -> Row:
    """Return a calibration as a row."""
    return table_row(_calibrated(variant, asked))


def _quality(variant: Variant, asked: Row) -> Row:
    """Return a sensor's quality over a grid of loads as a row."""
    _check_converter(variant.sensor)
    return with_quality(variant.sensor, _calibrated(variant, asked))


def _check_converter(sensor: Sensor) -> None:
    """Refuse a sensor without a converter."""
    if sensor.readout.converter == "none":
        raise SceneError('readout.converter must be given for quality, by whose noise forces are resolved; got "none"')


def with_quality(sensor: Sensor, data: xr.Dataset) -> Row:
    """Return the row of a sensor's calibration with its figures of quality at the worst load of each force.

    Resolution by the converter's noise and model errors [N, N m]; shares of each force's full scale: nonlinearity of
    its own signal, crosstalk of linear sums of all coils and of the inverse.
    """
    from sits_mech.analysis.limits import limits_of
    from sits_mech.analysis.readings.bench import coil_table, sensor_calibration, sensor_front_end
    from sits_mech.readout.quality import quality

    _check_converter(sensor)
    noise = sensor_front_end(sensor, data)[0].noise
    found, force = quality(sensor_calibration(sensor, data), noise, table=coil_table(sensor, data)), ("force",)
    own, each = np.eye(len(found.forces), dtype=bool), (found.crosstalk, found.crosstalk_after)
    before, after = (np.abs(np.where(own, 0.0, shares)).max(axis=1) for shares in each)
    row = table_row(data) | {
        "forces": (force, np.array(found.forces, dtype=object)),
        "resolution": (force, found.resolution[:, 2]),
        "error_by_model": (force, found.by_model[:, 2]),
        "linearity": (force, found.linearity),
        "crosstalk": (force, before),
        "error_crosstalk": (force, found.crosstalk_error),
        "crosstalk_after": (force, after),
        "condition": found.condition[1],
        "valid_share": found.valid_share,
    }
    limits = limits_of(sensor, data)
    return row | {"largest_stretch": limits.stretch, "least_clearance": limits.clearance}


def _load(sensor: Sensor, asked: Row, mechanics: str, tolerance: float) -> TouchLoad:
    """Return the load that a case asks for; where it names none that of the scene's touch."""
    touch = None if _LOAD.keys() & asked.keys() else sensor.touch
    if touch is not None and not touch.force is touch.depth is None:
        return touch_load(sensor, tolerance=tolerance, mechanics=mechanics)
    return TouchLoad(Wrench(**{name: asked.get(argument, 0.0) for argument, name in LOAD_ARGUMENTS.items()}))


def _rest(found: Equilibrium) -> Row:
    """Return a target at rest as a row."""
    row = {name: getattr(found.pose, name) for name in POSE}
    row |= {f"error_{name}": getattr(found.error, name) for name in POSE}
    if found.error_F_z is not None:
        row |= {"F_z": found.wrench.F_z, "error_F_z": found.error_F_z}
    report = found.report
    row |= {"min_J": np.nan if report.min_J is None else report.min_J, "error_mechanics": report.estimated_error}
    words = {"notes_mechanics": packed(report.notes), "left_out_mechanics": packed_omissions(report.left_out)}
    return row | {"mechanics": report.model} | words


def _shown(found: Impedance) -> Row:
    """Return inductances and resistances as a row."""
    pair, one, report = ("coil", "coil_2"), ("coil",), found.report
    row: Row = {name: (pair, getattr(found, name)) for name in ("L", "R", "L0", "error_L", "error_R")}
    row |= {"relative": (one, np.diagonal(found.L) / np.diagonal(found.L0)), "R_dc": (one, found.R_dc)}
    row |= {"unit_L": found.unit_L, "error_magnetics": report.estimated_error}
    words = {"notes_magnetics": packed(report.notes), "left_out_magnetics": packed_omissions(report.left_out)}
    return row | {"magnetics": report.model} | words


_CHAIN = {"mechanics": tuple(MECHANICS), "magnetics": tuple(MAGNETICS)}
REQUESTS = {
    "pose": Request(_pose, _LOAD, {"model": _CHAIN["mechanics"]}),
    "inductance": Request(_inductance, _PLACE, {"model": _CHAIN["magnetics"]}, needed=("dv",), layer=False, chunk=25),
    "simulate": Request(_simulate, _LOAD, _CHAIN, chunk=4),
    "cells": Request(_cells, _PITCH, {}, needed=("pitch_x",)),
    **{
        name: Request(answer, _LOAD, _CHAIN, needed=("fx", "fz"), ranges=tuple(_LOAD))
        for name, answer in zip(SWEPT, (_calibrate, _quality), strict=True)
    },
}
"""What a study can ask, by the name of the command."""
