"""Read requirement files: loads that a sensor meets, what may vary, what it must hold, what is best.

Their keys stand in `written.py`; each figure's meaning in `solved/figures.py`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.inputs import checked, unknown
from sits_mech.quantities import WRENCH
from sits_mech.readout.converter import conversion_time, converter
from sits_mech.scene.files import read_as
from sits_mech.scene.parameters import parameter, value_of
from sits_mech.scene.sensor import SceneError, Sensor, changed, load_from, scene_text, silicones_of
from sits_mech.scene.thermal import unknown_coefficients
from sits_mech.synthesis.required.kinds import KINDS, figure_names, figure_words, kind_of
from sits_mech.synthesis.required.space import Space, space_of
from sits_mech.synthesis.required.written import LEAST_ERROR, LEAST_YIELD, SPECIAL, Written
from sits_mech.units import millimetres as mm
from sits_mech.units import shown

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
    minimised: dict[str, float]  # weights of figures over limits, or sizes; empty: the first design within limits
    least_yield: float  # share of the sensors made that must hold every limit

    @property
    def identity(self) -> str:
        """The requirements as JSON, for comparison."""
        asked = [self.limits, self.tolerance, self.minimised, self.least_yield]
        return json.dumps([self.scene, self.loads, self.overload, self.space.record, *asked], indent=1)


def read_requirements(path: Path) -> Requirements:
    """Read a requirement file in TOML.

    Raises SceneError in one line: the file, the key, what it must be, what came.
    """
    return read_as(path, requirements_of)


def requirements_of(table: Mapping[str, Any], folder: Path = Path(), sensor: Sensor | None = None) -> Requirements:
    """Return the requirements of tables, as of a file in a folder, of its scene or of `sensor` instead.

    Errors as `read_requirements`.
    """
    given = checked(Written, table if sensor is None else {"scene": "", **table}, "requirements")
    parts = given.model_dump(exclude_unset=True)
    sensor = load_from(folder, parts["scene"]) if sensor is None else sensor
    if sensor.target is None or sensor.elastomer is None:
        raise SceneError("scene: must have a target and an elastomer")
    loads, goal = parts["loads"], parts.get("goal", {})
    overload = loads.pop("overload", 1.0)
    if not loads:
        raise SceneError(f"loads: must name at least one of {', '.join(WRENCH)}; got none")
    loads = {name: loads[name] for name in WRENCH if name in loads}
    space = space_of(sensor, parts["vary"])
    limits = _limits(parts.get("require", {}), tuple(loads))
    tolerance = parts.get("tolerance", {})
    for key, size in tolerance.items():
        _check_scatter(sensor, space, key, size, shown(table["tolerance"][key]))
    for name in (weights := goal.get("minimise", {})):
        if name not in (known := figure_names(tuple(loads))):
            raise SceneError(f"goal.minimise: {unknown(name, (*known, 'feasible'))}")
    if not weights and not limits:
        raise SceneError("goal: must name a figure to minimise where nothing is required")
    share = goal.get("least_yield", LEAST_YIELD)
    found = Requirements(scene_text(sensor), loads, overload, space, limits, tolerance, weights, share)
    _check_together(found, sensor)
    return found


def _limits(given: Mapping[str, Any], forces: tuple[str, ...]) -> dict[str, float]:
    """Return the limits of the figures by name."""
    found: dict[str, float] = {}
    for key, item in given.items():
        if KINDS[key].of == "load" and (not item or not set(item) <= set(forces)):
            raise SceneError(f"require.{key}: must be a table of some of {', '.join(forces)}; got {shown(item)}")
        found |= {f"{key}.{name}": part for name, part in item.items()} if isinstance(item, dict) else {key: item}
    return found


def _check_scatter(sensor: Sensor, space: Space, key: str, deviation: float, words: str) -> None:
    """Refuse a deviation of what is no length or number of the scene, or at twice which no sensor is possible."""
    if key in space.lists:
        raise SceneError(f"tolerance.{key}: must be of a length or a number; a list varies it")
    if key not in SPECIAL and value_of(sensor, key) is None:
        known = (*SPECIAL, "a dotted key of a length or number of the scene")
        raise SceneError(f"tolerance: {key} must be one of {', '.join(known)}")
    small = f"tolerance.{key}: must leave a sensor that is off by twice of it; got {words}"
    if key == "modulus" and not _TWICE * deviation < 1.0:
        raise SceneError(small)
    if key not in SPECIAL:
        try:
            parameter(sensor, key).changed(-_TWICE * deviation)
        except SceneError as error:
            raise SceneError(f"{small}: {error}") from None


def _check_together(found: Requirements, sensor: Sensor) -> None:
    """Refuse requirements that contradict each other."""
    n, asked = len(sensor.coils), (*found.limits, *found.minimised)
    by_force = [name for name in asked if kind_of(name).of == "load"]
    if n < len(found.loads) and by_force:
        raise SceneError(f"loads: must be at most {n} components for as many coils; got {', '.join(found.loads)}")
    for name, least in found.space.least_sizes().items():
        limit = found.limits.get(name, np.inf)
        if limit < least * (1.0 - 1e-9):
            most = f"at least {mm(least)}, which the parts have within the bounds"
            raise SceneError(f"require.{name}: must be {most}; got {mm(limit)}")
    _check_readings(found, sensor)
    if any(name.startswith("drift.") for name in asked):
        _check_temperature(found.space, sensor)
    if "hysteresis" in asked:
        _check_history(found.space, sensor, "require" if "hysteresis" in found.limits else "goal")


def _check_readings(found: Requirements, sensor: Sensor) -> None:
    """Refuse a rate, or a resolution, that no sensor of the scene's coils and converter has, or an unknowable error.

    The shortest conversion of n coils one after the other is the fastest. With inductances known to the share r of
    themselves, each of which turns at most once along a component's range F, their way is at most 2 L, and at the worst
    load that component is known to r F/(2 n) at best.
    """
    n, name, asked = len(sensor.coils), sensor.readout.converter, found.limits.get("rate", 0.0)
    if name != "none":
        part = converter(name)
        clock = part.internal[2] if part.internal else part.clock[1]
        fastest = 1.0 / (n * conversion_time(part.rcount[0], part, clock))
        if asked > fastest:
            raise SceneError(f"require.rate: must be at most {fastest:.4g} Hz, which {name} has; got {asked:g} Hz")
    for force, (low, high) in found.loads.items():
        best = found.tolerance.get("repeatability", 0.0) * (high - low) / (2.0 * n)
        bounds = {
            f"resolution.{force}": (best, "which repeatability leaves"),
            f"error.{force}": (LEAST_ERROR, "a hundredth of the tolerance that designs are solved to"),
        }
        for key, (least, why) in bounds.items():
            if (limit := found.limits.get(key, np.inf)) < least:
                own = figure_words(key, limit)
                raise SceneError(f"require.{key}: must be at least {figure_words(key, least)}, {why}; got {own}")


def _check_history(space: Space, sensor: Sensor, place: str) -> None:
    """Refuse a hysteresis of silicones whose rate and softening are not known."""
    for other in _of_each(space, sensor, "elastomer.material"):
        for silicone in silicones_of(other):
            if not silicone.has_history:
                name = silicone.name or "the scene's silicone"
                what = "needs prony or mullins of every silicone"
                raise SceneError(f"{place}: hysteresis {what}; of {name} both are unknown")


def _check_temperature(space: Space, sensor: Sensor) -> None:
    """Refuse a drift of parts whose coefficients are not known."""
    for key in ("elastomer.material", "target.material"):
        for other in _of_each(space, sensor, key):
            if words := unknown_coefficients(other):
                raise SceneError(f"drift: {words}")


def _of_each(space: Space, sensor: Sensor, key: str) -> list[Sensor]:
    """Return the scene with each value of a list; unchanged where there is no list."""
    values = space.lists.get(key, ())
    return [changed(sensor, space.overrides({key: value})) for value in values] or [sensor]
