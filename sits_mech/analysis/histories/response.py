"""Simulate the sensor under a history of loads: poses by the layer's memory, and the coils' answer.

    loads Q(t) --(layer with a memory: mechanics/histories.py)--> poses q(t) --(magnetics)--> L(t), signals

Where places are given in place of loads, models are chosen by the loads of closed forms, and what the mechanics leave
out of a displacement is left out of the force.

Where nothing remembers, neither a silicone nor friction, loads are solved as those of a table are, from the rests of
their neighbours, with what finer meshes change from a few (chain/interpolate.py).

Few rows of a history are solved: corners of the load, and between them as many as it moves by parts of its range.
Cubics carry each quantity to the others, from corner to corner (`interpolant`). Where their error is above what solved
times leave of the tolerance more rows are solved, by its second order.
"""

from __future__ import annotations

import json
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sits_mech.analysis.histories.interpolant import Interpolant, foreseen, more_times
from sits_mech.cases import Progress, no_progress
from sits_mech.chain.interpolate import BETWEEN, LayerGrid
from sits_mech.chain.models import Choice, loaded_model, mechanical_model
from sits_mech.chain.omitted.mechanical import mechanical_omissions, omitted_parts
from sits_mech.chain.plans.aimed import aim_at, aimed_loads, aimed_mechanics
from sits_mech.chain.plans.goal import Goal, farthest, flags_over
from sits_mech.chain.propagation import levers, read_poses, unloaded_pose
from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.tracks import check_frequency
from sits_mech.labels import labelled
from sits_mech.mechanics.histories import LoadHistory, Motion, TimedModel, expected_loads, motion_of, through_rests
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.loads import RefinedModel, settle
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.mechanics.touch import check_untouched
from sits_mech.notes import Note, NoteKind, Omission, packed, packed_omissions
from sits_mech.quantities import (
    POSE,
    WRENCH,
    Array,
    Bounded,
    Impedance,
    MagneticModel,
    Mask,
    MechanicalModel,
    Pose,
    Wrench,
    kept_report,
)
from sits_mech.readout.signals import shown_signals
from sits_mech.scene.sensor import SceneError, Sensor, provenance, silicones_of

_LEAST = 0.1  # of the tolerance: what interpolation is given where solved times leave less


def in_time(
    sensor: Sensor, history: LoadHistory, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto",
    progress: Progress = no_progress, points: bool = False,
) -> xr.Dataset:
    """Return poses, inductances and signals under a history of loads, as a Dataset over time.

    ``given`` (whether the time is of the history, or solved between two of them), the wrench, pose, ``L`` (coil,
    coil_2) and the signals, each with ``error_`` but given forces; ``status`` and ``flags``; ``L0``. Attributes: scene,
    request, ``notes``, ``unit_L``, ``error`` (the largest one over the signals' full scale). Before its first time
    there was no load; the error of a pose is over the largest displacement; `points` asks for a model with memory at
    every point of the layer. Raises SceneError when a model cannot hold the scene, Collision where the target touches
    the coil plane, SolveFailed without a rest or an answer of the coils.
    """
    check_frequency(sensor.coils, sensor.frequency)  # before the layer is solved
    loads = expected_loads(sensor, history)
    field, by_field = loaded_model(sensor, magnetics, tolerance, loads)
    points = points or bool(history.held.any())
    layer, by_layer = taken_layer(sensor, (mechanics, magnetics), tolerance, loads, points=points)
    every_omission, names = mechanical_omissions(sensor, by_layer.name, loads), sensor.coil_names
    left_out = tuple(item for item in every_omission if item.weighs)
    asked = _Asked(sensor, loads, (layer, field), magnetics, tolerance, left_out)
    divided, own = foreseen(history, BETWEEN * tolerance)
    while (answer := asked.solved(divided, own, progress)).more.any():
        divided = replace(divided, solved=divided.solved | answer.more)
    motion, found, goal, every, _ = answer
    time, interpolated, stretch, wrench = map(every.pop, ("time", "interpolated", "stretch", "wrench"))
    poses = _bounded(sensor, left_out, every.pop("pose"), every.pop("error_pose"), history.held)
    s = np.abs(omitted_parts(sensor, left_out, unloaded_pose(sensor).components + 1.0))  # they are 1 + s as large
    off = every.pop("error_wrench") + np.abs(wrench) * (s / (1.0 + s)).sum(axis=0)
    columns: dict[str, Any] = {"given": ("time", every.pop("given"))}
    columns |= {name: ("time", part) for name, part in zip(WRENCH, wrench.T, strict=True)}
    columns |= {f"error_{WRENCH[k]}": ("time", off[:, k]) for k in np.flatnonzero(history.held)}
    for kind, each in (("", poses.value), ("error_", poses.error)):
        columns |= {f"{kind}{name}": ("time", part) for name, part in zip(POSE, each.T, strict=True)}
    columns |= {name: (("time", "coil", "coil_2")[: np.ndim(value)], value) for name, value in every.items()}
    left_out = (*left_out, *found.report.left_out)
    marks, worst = flags_over(sensor, goal, poses, stretch, tolerance, left_out, interpolated=interpolated)
    columns |= {name: ("time", part) for name, part in marks.items()}
    data = xr.Dataset(columns, coords={"time": time, "coil": names, "coil_2": names})
    request = {"mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance}
    notes = dict.fromkeys((*_unknown(sensor), *motion.report.notes, *found.report.notes))
    data = data.assign(L0=(("coil", "coil_2"), found.L0)).assign_attrs(
        **provenance(sensor), request=json.dumps(request), notes=packed(notes), frequency=sensor.frequency,
        **found.convention, left_out=packed_omissions(left_out), report=kept_report(motion.report),
        error=worst,
    )
    return labelled(data)


class _Answer(NamedTuple):
    """Values of a history at all its times, by those that are solved, and what else is to be solved."""

    motion: Motion
    found: Impedance
    goal: Goal | None
    every: dict[str, Any]
    more: Mask


@dataclass(frozen=True)
class _Asked:
    """What a history is asked of."""

    sensor: Sensor
    loads: Sequence[Wrench]
    models: tuple[MechanicalModel, MagneticModel]
    magnetics: str
    tolerance: float
    left_out: Sequence[Omission]

    def solved(self, divided: LoadHistory, own: Mask, progress: Progress) -> _Answer:
        """Return the answer by the times of a history that are to be solved; `own` are those that are its rows."""
        sensor, tolerance, (layer, field) = self.sensor, self.tolerance, self.models
        resting = None if divided.held.any() or _remembers(sensor) else self._resting(divided, progress)
        motion = resting or _with_symmetry(sensor, divided, motion_of(sensor, layer, divided, progress))
        check_clearance(sensor, motion.pose)
        aim = aim_at(sensor, self.magnetics, tolerance, self.loads, farthest(motion.pose))
        pose, error = motion.pose.components, motion.error.components
        bounded = _bounded(sensor, self.left_out, pose, error, divided.held)
        reading = read_poses(sensor, field if aim is None else aim.field, bounded)
        found, goal = reading.impedance, None if aim is None else aim.goal
        values = {name: getattr(found, name) for name in ("L", "R", "error_L", "error_R")}
        values |= {name: np.asarray(value) for name, value in reading.signals.known.items()}
        values |= {"wrench": motion.wrench, "error_wrench": motion.error_wrench}
        values |= {"pose": pose, "error_pose": error, "stretch": motion.stretch}
        every, off = _at_all_times(divided, own, motion, values)
        near, spent = every["error_pose"][every["interpolated"]] - off["pose"], 0.0
        if goal is not None:
            spent = goal.magnetics + np.max(near @ np.abs(goal.weights).T, axis=1)
        most = np.clip(tolerance - spent, _LEAST * tolerance, BETWEEN * tolerance)
        more = more_times(divided, own, motion.time, _share(sensor, goal, values, off) / most)
        return _Answer(motion, found, goal, every, more)

    def _resting(self, divided: LoadHistory, progress: Progress) -> Motion | None:
        """Return a target's motion from rest to rest; None where a load has none, or the model has one mesh."""
        sensor, layer, mirrors = self.sensor, self.models[0], symmetry_of(self.sensor)
        began, time, course = clock.process_time(), divided.time[divided.solved], divided.course[divided.solved]
        loads = tuple(Wrench(*row) for row in course.tolist())
        if not isinstance(layer, RefinedModel):
            return None
        last = loads[int(np.argmax(np.linalg.norm(divided.shares[divided.solved], axis=1)))]
        if any(one.rest is None for one in settle(layer.rough, [last], symmetry=mirrors).values()):
            return None
        grid = LayerGrid(sensor, layer, {}, mirrors, self.tolerance, progress=progress, listed=loads)
        found = aimed_loads(grid, self.magnetics).settled
        rests = [rest for load in loads if (rest := found[load].rest) is not None]
        if len(rests) < len(loads):
            return None
        given = np.ones(time.size, dtype=bool)
        return through_rests(LoadHistory(time, course), given, rests, clock.process_time() - began)


def _remembers(sensor: Sensor) -> bool:
    """Whether where the target rests depends on more than the load: on a silicone's history, or on friction."""
    return depends_on_path(sensor) or any(each.has_history for each in silicones_of(sensor))


def _bounded(sensor: Sensor, left_out: Sequence[Omission], pose: Array, error: Array, held: Mask) -> Bounded:
    """Return poses (p, 6) with errors that hold what the mechanics leave out, of places that are not held."""
    parts = np.where(held, 0.0, omitted_parts(sensor, left_out, pose))
    return Bounded.of(pose, error + np.abs(parts).sum(axis=0), parts)


def _share(sensor: Sensor, goal: Goal | None, values: Mapping[str, Array], off: Mapping[str, Array]) -> Array:
    """Return errors of interpolation over the signals' range, by poses or of the signals, the larger of both.

    Of poses over the largest displacement where no signal changes; of forces that are found over the largest.
    """
    lever, signals = levers(sensor), shown_signals(values)
    size = np.max(np.abs((values["pose"] - unloaded_pose(sensor).components) * lever), initial=1e-300)
    weights = np.diag(lever / size) if goal is None else np.abs(goal.weights)
    span, lever = max(*(float(np.ptp(values[name])) for name in signals), 1e-300), np.maximum(lever, 1e-300)
    forces = off["wrench"] / lever / np.max(np.abs(values["wrench"]) / lever, initial=1e-300)
    each = *(off["pose"] @ weights.T).T, *forces.T, *(off[name] / span for name in signals)
    return np.asarray(np.max(each, axis=0))


def _at_all_times(
    history: LoadHistory, own: Mask, motion: Motion, values: Mapping[str, Array]
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return values at solved times and rows between them; and errors of interpolation (also in ``error_``) of these.

    Besides ``time``, whether it is of the history (``given``), and not solved (``interpolated``). Given loads are kept.
    """
    left, corners = np.flatnonzero(own & ~history.solved), np.isin(motion.time, history.time[history.corners])
    times, yes = history.time[left], np.ones(left.size, dtype=bool)
    order = np.argsort(np.concatenate([motion.time, times]), kind="stable")

    def merged(solved: NDArray[Any], between: NDArray[Any]) -> NDArray[Any]:
        """Return what is of solved times and of rows between them, in the order of time."""
        return np.concatenate([solved, between])[order]

    found = {name: Interpolant(motion.time, corners, part).at(times) for name, part in values.items()}
    load, error = found["wrench"]
    found["wrench"] = np.where(history.held, load, history.course[left]), error * history.held
    off = {name: error for name, (_, error) in found.items()}
    every = {
        name: merged(part, found[name][0] + off.get(name.removeprefix("error_"), 0.0) * ("error_" in name))
        for name, part in values.items()
    }
    given, no = motion.given & np.isin(motion.time, history.time[own]), np.zeros(motion.time.size, dtype=bool)
    marks = {"given": merged(given, yes), "interpolated": merged(no, yes)}
    return every | marks | {"time": merged(motion.time, times)}, off


def taken_layer(
    sensor: Sensor, models: tuple[str, str], tolerance: float, loads: Sequence[Wrench], *, points: bool = False
) -> tuple[MechanicalModel, Choice]:
    """Return the mechanical model: small loads take a smaller one; softening takes one at finite strain.

    Raises SceneError for a named model without memory at every point, where `points` asks for it.
    """
    if points:
        check_untouched(sensor, "every point of the pad over time")
    mechanics, magnetics = models
    found = aimed_mechanics(sensor, mechanics, tolerance, loads, magnetics)
    softens = any(each.mullins is not None for each in silicones_of(sensor))
    if isinstance(found[0], TimedModel) or not (points or softens):
        return found
    if mechanics == "auto":
        return mechanical_model(sensor, "block", tolerance, loads)
    if points:
        known = "auto, block, planar or axisymmetric"
        raise SceneError(f"mechanics: must be {known} to follow every point; got {mechanics}")
    return found


def _unknown(sensor: Sensor) -> tuple[Note, ...]:
    """Note that a silicone without data over time is taken as under slow load."""
    made = silicones_of(sensor)
    if not made or any(each.has_history for each in made):
        return ()
    return (Note(NoteKind.NO_HISTORY),)


def _with_symmetry(sensor: Sensor, history: LoadHistory, motion: Motion) -> Motion:
    """Return a motion without the components of loads and poses that the symmetry of scene and history forbids."""
    kept = symmetry_of(sensor).projection(*(Wrench(*row) for row in history.course.tolist()))
    pose, wrench = (part @ kept.T for part in (motion.pose.components, motion.wrench))
    error, off = (part @ np.abs(kept).T for part in (motion.error.components, motion.error_wrench))
    return replace(motion, pose=Pose.of(pose), error=Pose.of(error), wrench=wrench, error_wrench=off)
