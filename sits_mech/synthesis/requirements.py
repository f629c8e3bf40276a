"""Read requirement files: loads that a sensor meets, what may vary, what it must hold, what is best.

    scene = "biorob2018-w15"             # a scene file beside this one, or a name of the catalogue
    [loads]                              # ranges of components of the load, as of `Wrench`
    F_x = ["-1 N", "1 N"]
    F_z = ["0 N", "4 N"]
    overload = 1.5                       # times the loads, carried without harm; 1 by default
    [vary]                               # keys of the scene in quotes: bounds, or a list
    "elastomer.thickness" = { from = "1 mm", to = "6 mm" }
    "elastomer.material" = ["ecoflex-00-30", "dragon-skin-10"]
    "coils.*.turns" = [8, 10, 12]        # a star stands for every coil
    [require]                            # limits of figures, all optional
    resolution = { F_x = "10 mN", F_z = "20 mN" }
    error = { F_z = "5 %" }
    drift = { F_z = "20 mN/K" }          # of zero, with temperature
    crosstalk_before_inverse = "60 %"
    hysteresis = "5 %"
    rate = "100 Hz"
    footprint = ["25 mm", "25 mm"]
    height = "8 mm"
    [tolerance]                          # one standard deviation of what is made, independent and normal
    "elastomer.thickness" = "0.05 mm"
    modulus = "10 %"                     # all stiffnesses of the silicone together
    coil_offset = "0.1 mm"               # of the coils beside the pad, along x and along y
    repeatability = "0.01 %"             # of one reading of an inductance, beside the converter's noise
    [goal]
    minimise = "error.F_z"               # a figure, {figure = weight, ...}, or "feasible"
    yield = "95 %"                       # share of the sensors made that must hold every limit

Each figure's meaning stands in `figures.py`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.quantities import UNITS, WRENCH
from sits_mech.scene.files import check_keys, read_as
from sits_mech.scene.materials import unknown
from sits_mech.scene.parameters import parameter, value_of
from sits_mech.scene.sensor import SceneError, Sensor, changed, load_beside, scene_text, silicone_of
from sits_mech.scene.thermal import unknown_coefficients
from sits_mech.synthesis.kinds import ASKED, KINDS, figure_names, kind_of, unit_of
from sits_mech.synthesis.space import Space, space_of
from sits_mech.units import quantity, shown

KEYS = ("scene", "loads", "vary", "require", "tolerance", "goal")
SPECIAL = {"modulus": "", "coil_offset": "m", "repeatability": ""}
"""Tolerances that are no key of the scene."""
_YIELD = 0.95  # of the sensors made, by default
_TWICE = 2.0  # standard deviations of a tolerance, that leave a sensor


@dataclass(frozen=True)
class Requirements:
    """Requirements of a sensor; made by `read_requirements` or `requirements_of`."""

    scene: str  # start of every design, as of `scene_text`
    loads: dict[str, tuple[float, float]]  # least and greatest of each component that varies [N, N m]
    overload: float  # times the loads, that the pad carries
    space: Space
    limits: dict[str, float]  # by figure, such as "resolution.F_x", "footprint.x", "height" [SI]
    tolerance: dict[str, float]  # deviation by key [SI], "modulus" [-], "coil_offset" [m], "repeatability" [-]
    goal: dict[str, float]  # weights of minimised figures over limits, or sizes; empty: the first design within limits
    least_yield: float  # share of the sensors made that must hold every limit

    @property
    def identity(self) -> str:
        """The requirements as JSON, for comparison."""
        rest = [self.loads, self.overload, self.space.record, self.limits, self.tolerance, self.goal, self.least_yield]
        return json.dumps([self.scene, *rest], indent=1)


def read_requirements(path: Path) -> Requirements:
    """Read a requirement file in TOML.

    Raises SceneError in one line: the file, the key, what it must be, what came.
    """
    return read_as(path, requirements_of)


def requirements_of(table: Mapping[str, Any], folder: Path = Path(), sensor: Sensor | None = None) -> Requirements:
    """Return the requirements of tables, as of a file in a folder, of its scene or of `sensor` instead.

    Errors as `read_requirements`.
    """
    check_keys(table, KEYS, ("loads", "vary") if sensor is not None else ("scene", "loads", "vary"))
    sensor = load_beside(folder, str(table["scene"])) if sensor is None else sensor
    if sensor.target is None or sensor.elastomer is None:
        raise SceneError("scene: must have a target and an elastomer")
    loads, overload = _loads(_part(table, "loads"))
    space = space_of(sensor, _part(table, "vary"))
    limits = _limits(_part(table, "require"), tuple(loads))
    tolerance = _tolerance(_part(table, "tolerance"), sensor, space)
    goal, least_yield = _goal(_part(table, "goal"), limits, tuple(loads))
    found = Requirements(scene_text(sensor), loads, overload, space, limits, tolerance, goal, least_yield)
    _check_together(found, sensor)
    return found


def _part(table: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table of the file, empty where it is missing."""
    part = table.get(name, {})
    if not isinstance(part, dict):
        raise SceneError(f"{name}: must be a table; got {shown(part)}")
    return part


def _loads(table: Mapping[str, Any]) -> tuple[dict[str, tuple[float, float]], float]:
    """Return the ranges of the loads, in the order of `WRENCH`, and the overload."""
    for key in table:
        if key not in (*WRENCH, "overload"):
            raise SceneError(f"loads: {unknown(key, (*WRENCH, 'overload'))}")
    found = {name: _ends(name, table[name]) for name in WRENCH if name in table}
    if not found:
        raise SceneError(f"loads: must name at least one of {', '.join(WRENCH)}; got none")
    overload = quantity(table.get("overload", 1.0), "", "loads.overload")
    if not overload >= 1.0:
        raise SceneError(f"loads.overload: must be 1 or more; got {overload:g}")
    return found, overload


def _ends(name: str, ends: Any) -> tuple[float, float]:
    """Return least and greatest of a component of the load."""
    if not isinstance(ends, list) or len(ends) != 2:
        raise SceneError(f'loads.{name}: must be least and greatest, such as ["0 N", "4 N"]; got {shown(ends)}')
    low, high = (quantity(end, UNITS[name], f"loads.{name}") for end in ends)
    if not low < high or low > 0.0 or high < 0.0:
        raise SceneError(f"loads.{name}: must rise, with no load between its ends; got {shown(ends)}")
    return low, high


def _limits(table: Mapping[str, Any], forces: tuple[str, ...]) -> dict[str, float]:
    """Return the limits of the figures by name."""
    found: dict[str, float] = {}
    for key, item in table.items():
        if key not in ASKED:
            raise SceneError(f"require: {unknown(key, ASKED)}")
        parts = _parts(key, item, forces)
        found |= {name: quantity(part, unit_of(name), f"require.{name}") for name, part in parts.items()}
    for name, value in found.items():
        if not value > 0.0:
            raise SceneError(f"require.{name}: must be positive; got {value:g}")
    return found


def _parts(key: str, item: Any, forces: tuple[str, ...]) -> dict[str, Any]:
    """Return what a limit by components of the load, or of the footprint by axes, asks of each."""
    if not KINDS[key].of:
        return {key: item}
    if KINDS[key].of == "axes":
        if not isinstance(item, list) or len(item) != 2:
            form = 'two lengths, such as ["25 mm", "25 mm"]'
            raise SceneError(f"require.{key}: must be {form}; got {shown(item)}")
        return dict(zip(figure_names(forces, (key,)), item, strict=True))
    if not isinstance(item, dict) or not set(item) <= set(forces) or not item:
        raise SceneError(f"require.{key}: must be a table of some of {', '.join(forces)}; got {shown(item)}")
    return {f"{key}.{name}": part for name, part in item.items()}


def _tolerance(table: Mapping[str, Any], sensor: Sensor, space: Space) -> dict[str, float]:
    """Return the standard deviations; keys of the scene must be of a number or a length."""
    found = {}
    for key, item in table.items():
        if key in SPECIAL:
            found[key] = quantity(item, SPECIAL[key], f"tolerance.{key}")
        elif key in space.lists:
            raise SceneError(f"tolerance.{key}: must be of a length or a number; a list varies it")
        else:
            if value_of(sensor, key) is None:
                known = (*SPECIAL, "a dotted key of a length or number of the scene")
                raise SceneError(f"tolerance: {key} must be one of {', '.join(known)}")
            found[key] = quantity(item, "m" if isinstance(item, str) else "", f"tolerance.{key}")
        if not 0.0 < found[key] < np.inf:
            raise SceneError(f"tolerance.{key}: must be a positive standard deviation; got {shown(item)}")
        _check_scatter(sensor, key, found[key], shown(item))
    return found


def _check_scatter(sensor: Sensor, key: str, deviation: float, said: str) -> None:
    """Refuse a deviation at twice which no sensor is possible."""
    small = f"tolerance.{key}: must leave a sensor that is off by twice of it; got {said}"
    if key == "modulus" and not _TWICE * deviation < 1.0:
        raise SceneError(small)
    if key not in SPECIAL:
        try:
            parameter(sensor, key).changed(-_TWICE * deviation)
        except SceneError as error:
            raise SceneError(f"{small}: {error}") from None


def _goal(
    table: Mapping[str, Any], limits: Mapping[str, float], forces: tuple[str, ...]
) -> tuple[dict[str, float], float]:
    """Return the weights of what is minimised, and the yield."""
    for key in table:
        if key not in ("minimise", "yield"):
            raise SceneError(f"goal: {unknown(key, ('minimise', 'yield'))}")
    asked = table.get("minimise", "feasible")
    weights = {asked: 1.0} if isinstance(asked, str) else asked
    if not isinstance(weights, dict) or not weights:
        raise SceneError(f'goal.minimise: must be a figure, {{figure = weight}} or "feasible"; got {shown(asked)}')
    found = {} if [*weights] == ["feasible"] else _weights(weights, figure_names(forces))
    if not found and not limits:
        raise SceneError("goal: must name a figure to minimise where nothing is required")
    share = quantity(table.get("yield", _YIELD), "", "goal.yield")
    if not 0.5 <= share < 1.0:
        raise SceneError(f"goal.yield: must be a share from 50 % to below 100 %; got {share:g}")
    return found, share


def _weights(given: Mapping[str, Any], known: tuple[str, ...]) -> dict[str, float]:
    """Return the weights of figures, that of the footprint for both its sides."""
    found = {}
    for name, weight in given.items():
        for each in figure_names((), (name,)) if name == "footprint" else (name,):
            if each not in known:
                raise SceneError(f"goal.minimise: {unknown(each, (*known, 'feasible'))}")
            found[each] = quantity(weight, "", f"goal.minimise.{name}")
            if not found[each] > 0.0:
                raise SceneError(f"goal.minimise.{name}: must be a positive weight; got {shown(weight)}")
    return found


def _check_together(found: Requirements, sensor: Sensor) -> None:
    """Refuse requirements that contradict each other."""
    n, asked = len(sensor.coils), (*found.limits, *found.goal)
    by_force = [name for name in asked if kind_of(name).of == "load"]
    if n < len(found.loads) and by_force:
        raise SceneError(f"loads: must be at most {n} components for as many coils; got {', '.join(found.loads)}")
    for name, least in found.space.least_sizes().items():
        limit = found.limits.get(name, np.inf)
        if limit < least * (1.0 - 1e-9):
            most = f"at least {least:g} m, which the parts have within the bounds"
            raise SceneError(f"require.{name}: must be {most}; got {limit:g} m")
    if any(name.startswith("drift.") for name in asked):
        _check_temperature(found.space, sensor)
    if "hysteresis" in asked:
        _check_history(found.space, sensor, "require" if "hysteresis" in found.limits else "goal")


def _check_history(space: Space, sensor: Sensor, place: str) -> None:
    """Refuse a hysteresis of silicones whose rate and softening are not known."""
    for other in _of_each(space, sensor, "elastomer.material"):
        silicone = silicone_of(other)
        if silicone is not None and not silicone.has_history:
            name = silicone.name or "the scene's silicone"
            what = "needs prony or mullins of every silicone"
            raise SceneError(f"{place}: hysteresis {what}; of {name} both are unknown")


def _check_temperature(space: Space, sensor: Sensor) -> None:
    """Refuse a drift of parts whose coefficients are not known."""
    for key in ("elastomer.material", "target.material"):
        for other in _of_each(space, sensor, key):
            said = unknown_coefficients(other)
            if said:
                raise SceneError(f"drift: {said}")


def _of_each(space: Space, sensor: Sensor, key: str) -> list[Sensor]:
    """Return the scene with each value of a list; unchanged where there is no list."""
    values = space.lists.get(key, ())
    return [changed(sensor, space.overrides({key: value})) for value in values] or [sensor]
