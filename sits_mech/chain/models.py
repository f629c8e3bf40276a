"""Make the models of both halves of the chain by name, and the plan of a request."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from sits_mech.chain.conductors import AmongFar, negligible, without_far
from sits_mech.chain.ends import ROUGH, InSection
from sits_mech.chain.goal import HALF, Goal, goal_of
from sits_mech.chain.omissions import Answered, Omission, strain_bound
from sits_mech.chain.plan import Choice, choose_magnetics, choose_mechanics
from sits_mech.chain.prices import Look, look, magnetic_tolerance
from sits_mech.chain.propagation import poses_of, unloaded
from sits_mech.chain.request import Plan
from sits_mech.quantities import POSE, WRENCH, Equilibrium, MagneticModel, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.scene.plausible import check_loads
from sits_mech.scene.sensor import Sensor
from sits_mech.scene.thermal import at_temperature
from sits_mech.units import checked_tolerance


def _made(factory: str, sensor: Sensor, tolerance: float) -> Any:
    """Return the model from a factory below `sits_mech`, imported when first asked for."""
    room, _, name = factory.rpartition(".")
    return getattr(import_module(f"sits_mech.{room}"), name)(sensor, tolerance)


MECHANICS: Mapping[str, Callable[[Sensor, float], MechanicalModel]] = {
    "planar": partial(_made, "mechanics.layer.planar_layer"),
    "linear": partial(_made, "mechanics.linear.small_strain"),
    "block": partial(_made, "mechanics.block.block_pad"),
    "closed-form": partial(_made, "mechanics.closed_form.strip_layer"),
}
"""The mechanical models by name; each factory takes a sensor and a tolerance."""
MAGNETICS: Mapping[str, Callable[[Sensor, float], MagneticModel]] = {
    "planar": partial(_made, "magnetics.bars.planar_bars"),
    "planar-fem": partial(_made, "magnetics.field.planar_fem"),
    "axisymmetric": partial(_made, "magnetics.rings.axisymmetric"),
    "sheets": partial(_made, "magnetics.sheets.sheets"),
}
"""The magnetic models by name; each factory takes a sensor and a tolerance."""
_KINDS = {"planar": "section", "planar-fem": "section", "axisymmetric": "space", "sheets": "space"}
_COARSE = 1e-2  # relative error of the change that conductors are compared with


def plan(
    sensor: Sensor, loads: Sequence[Wrench] = (), *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto",
) -> Plan:
    """Return what a request takes, what it leaves out, and what to expect of it.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    loads : sequence of Wrench
        Those asked for; none where poses are given.
    tolerance, mechanics, magnetics
        As for `simulate`.

    Raises
    ------
    SceneError
        When a model is unknown or cannot hold the scene.

    Examples
    --------
    >>> found = sm.plan(sm.load_sensor("biorob2018"), [sm.Wrench(F_z=1.0)])
    >>> found.mechanics.name, found.magnetics.name
    ('block', 'sheets')
    """
    sensor, asked = at_temperature(sensor), checked_tolerance(tolerance)
    check_loads(sensor, {part: [getattr(load, part) for load in loads] for part in WRENCH})
    by_layer = choose_mechanics(sensor, mechanics, tuple(MECHANICS), loads, tolerance) if loads else None
    solved, by_field = _chosen(sensor, magnetics, tolerance, loads, bool(loads))
    seen = _seen(sensor, by_layer, (solved, by_field.name), loads, asked)
    return Plan.of(sensor, loads, asked, by_layer, by_field, _rest(solved, by_field.name), seen)


def _seen(
    sensor: Sensor, choice: Choice | None, coils: tuple[Sensor, str], loads: Sequence[Wrench], tolerance: float
) -> Look | None:
    """Return what the first meshes show of one load at finite strain, for the signals of a coarse model."""
    if choice is None or len(loads) != 1 or strain_bound(sensor, loads) == np.inf:
        return None

    goals = list[Goal]()

    def measure(found: Equilibrium) -> float:
        """Return the error over the signals' full scale; of the pose, where no coil can be solved."""
        solved, name = coils
        try:
            goal = goal_of(solved, MAGNETICS[name](solved, ROUGH), [found.pose])
        except (SolveFailed, ValueError):
            goal = None
        if goal is None:
            return found.report.estimated_error
        goals.append(goal)
        return goal.mechanics(poses_of([found]))

    seen = look(MECHANICS[choice.name](sensor, tolerance), loads[0], tolerance, measure)
    if seen is None or not goals:
        return seen
    finer = magnetic_tolerance(coils[1], tolerance) / ROUGH
    return seen._replace(magnetics=min(goals[0].magnetics * min(finer, 1.0), HALF * tolerance))


def _rest(sensor: Sensor, name: str) -> Answered | None:
    """Return a coarse answer of the coils with the target at rest, for sizes that need it; None if there is none."""
    pose, shorted = _shown_at(sensor, ()), len(sensor.coils) > 1 and sensor.readout.idle_coil == "shorted"
    needed = shorted or sensor.target is not None and (_KINDS[name] == "section" or sensor.coils[0].winding == "spiral")
    if pose is None or not needed or (name == "sheets" and sensor.conductors):  # seconds among other metal
        return None
    try:
        return Answered(pose, MAGNETICS[name](sensor, ROUGH).impedance(pose, sensor.frequency), answered=False)
    except (SolveFailed, ValueError):
        return None


def mechanical_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-2, loads: Sequence[Wrench] = ()
) -> tuple[MechanicalModel, Choice]:
    """Return the mechanical model of a name with the reason for it.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    name : str
        "auto" or a key of `MECHANICS`.
    tolerance : float
        Asked relative error of the pose.
    loads : sequence of Wrench
        All it will be asked for, where that is known: small ones need less.

    Raises
    ------
    SceneError
        When the model is unknown or cannot hold the scene.

    Examples
    --------
    >>> model, choice = sm.mechanical_model(sm.load_sensor("biorob2018"), "linear")
    >>> found = model.equilibrium(sm.Wrench(F_z=0.1))
    >>> choice.name, round(1e6 * found.pose.d_v)  # um
    ('linear', 1988)
    """
    sensor = at_temperature(sensor)
    check_loads(sensor, {part: [getattr(load, part) for load in loads] for part in WRENCH})
    choice = choose_mechanics(sensor, name, tuple(MECHANICS), loads, tolerance)
    return MECHANICS[choice.name](sensor, checked_tolerance(tolerance)), choice


def magnetic_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-3, poses: Sequence[Pose] = ()
) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model of a name of `MAGNETICS` or "auto" with the reason; as `mechanical_model`.

    Known `poses` tell whether they leave the plane or an axis, and which conductors are too far to matter there;
    otherwise that is asked of the target at rest. The errors of a section that was not asked for by name hold its ends.

    Examples
    --------
    >>> model, choice = sm.magnetic_model(sm.load_sensor("biorob2018"), "planar")
    >>> found = model.impedance(sm.Pose(d_h=1e-3, d_v=2e-3), 5e6)
    >>> choice.name, (found.L / found.L0).diagonal().round(2).tolist()
    ('planar', [0.99, 0.93])
    """
    sensor = at_temperature(sensor)
    return _built(sensor, _chosen(sensor, name, checked_tolerance(tolerance), poses, False), tolerance, ends=True)


def loaded_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-2, loads: Sequence[Wrench] = ()
) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model for poses under loads, with the reason; as `mechanical_model`.

    What a section leaves out is told beside the errors of loads, once for all of them: it would cost more than they do.
    """
    sensor = at_temperature(sensor)
    solved, choice = _chosen(sensor, name, checked_tolerance(tolerance), loads, True)
    return _built(sensor, (solved, choice), magnetic_tolerance(choice.name, tolerance))


def _built(
    sensor: Sensor, settled: tuple[Sensor, Choice], tolerance: float, *, ends: bool = False
) -> tuple[MagneticModel, Choice]:
    """Return the model of a choice for the solved part of a scene, with the choice; its errors may hold the ends."""
    solved, choice = settled
    model = MAGNETICS[choice.name](solved, tolerance)
    if ends and _KINDS[choice.name] == "section" and not choice.by_name and sensor.target is not None:
        model = InSection(model, solved)
    if choice.left_out or choice.notes:
        left_out = tuple(item.text for item in choice.left_out)
        model = AmongFar(model, sensor, solved, left_out, choice.notes, negligible(tolerance))
    return model, choice


def _chosen(
    sensor: Sensor, name: str, tolerance: float, given: Sequence[Wrench] | Sequence[Pose], loaded: bool
) -> tuple[Sensor, Choice]:
    """Return what is solved of a scene, and by which model; without a name, far conductors are left out."""
    known = tuple(MAGNETICS)
    if name != "auto" or not sensor.conductors:
        return sensor, choose_magnetics(sensor, name, known, given, loaded)
    plain = choose_magnetics(sensor.model_copy(update={"conductors": ()}), name, known, given, loaded)
    solved, left_out, counted = sensor, tuple[Omission, ...](), ""
    pose = _shown_at(sensor, given)
    if pose is not None and sensor.target is not None and sensor.substrate_radius is None:
        asked = magnetic_tolerance(plain.name, tolerance) if loaded else tolerance
        flat, made = _KINDS[plain.name] == "section", MAGNETICS[plain.name]
        solved, left_out, counted = without_far(sensor, lambda bare: made(bare, _COARSE), pose, asked, section=flat)
    choice = choose_magnetics(solved, name, known, given, loaded)
    choice = replace(choice, reason=f"{choice.reason} ({counted})") if counted else choice
    notes = () if choice.name == plain.name else (_changed(plain, choice),)
    return solved, replace(choice, notes=notes, left_out=left_out)


def _shown_at(sensor: Sensor, given: Sequence[Wrench] | Sequence[Pose]) -> Pose | None:
    """Return where the change of inductance is asked for: known poses, or the target at rest; None if neither is."""
    poses = [pose.components.reshape(-1, len(POSE)) for pose in given if isinstance(pose, Pose)]
    if poses:
        return Pose.of(np.concatenate(poses))
    return None if sensor.elastomer is None else unloaded(sensor)


def _changed(plain: Choice, choice: Choice) -> str:
    """Say that conductors change the model from the one the bare sensor takes."""
    kinds = [_KINDS[each.name] for each in (choice, plain)]
    kind = f"{kinds[0]} instead of {kinds[1]}: " if kinds[0] != kinds[1] else ""
    return f"{kind}{choice.name} instead of {plain.name}, which the sensor takes without conductors; {choice.reason}"
