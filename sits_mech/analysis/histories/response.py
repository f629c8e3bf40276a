"""Simulate the sensor under a history of loads: poses by the layer's memory, and the coils' answer.

    loads Q(t) --(layer with a memory: mechanics/histories.py)--> poses q(t) --(magnetics)--> L(t), signals

Where places are given in place of loads, models are chosen by loads that one compliance gives, and what the mechanics
leave out of a place is left out of the force, as large a share of it.

Few rows of a history are solved: corners of the load, and between them as many as it moves by parts of its range.
Cubics carry each quantity to the others, from corner to corner (`interpolant`). Where their error is above what solved
times leave of the tolerance more rows are solved, by its second order.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sits_mech.analysis.histories.interpolant import Interpolant
from sits_mech.cases import Progress, untold
from sits_mech.chain.aimed import aim_at
from sits_mech.chain.goal import Goal, farthest
from sits_mech.chain.interpolate import BETWEEN
from sits_mech.chain.models import Choice, loaded_model, mechanical_model
from sits_mech.chain.propagation import levers, read_poses, unloaded_pose
from sits_mech.chain.simulate import flags_over, mechanical_omissions, omitted_parts
from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.tracks import check_frequency
from sits_mech.labels import labelled
from sits_mech.mechanics.histories import LoadHistory, Motion, TimedModel, compliant_loads, motion_of, undeformed
from sits_mech.mechanics.linear import small_strain
from sits_mech.mechanics.pad.section import layer_parts
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
from sits_mech.units import millimetres as mm

PARTS = 8
"""Steps over the range of a load that lie between two solved times, at most."""
_BEND = 0.5  # over the square of a range's parts: error of interpolation where y goes with the square of the load
_LEAST = 0.1  # of the tolerance: what interpolation is given where solved times leave less
_COARSE, _ROUNDING = 0.1, 1e-9  # error of a compliance that models are chosen by; of the largest load


def in_time(
    sensor: Sensor, history: LoadHistory, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto",
    progress: Progress = untold, points: bool = False,
) -> xr.Dataset:
    """Return poses, inductances and signals under a history of loads, as a Dataset over time.

    ``given`` (whether the time is of the history, or solved between two of them), the wrench, pose, ``L`` (coil,
    coil_2) and the signals, each with ``error_`` but given forces; ``status`` and ``flags``; ``L0``. Attributes: scene,
    request (with ``held``, the components whose places are given), ``notes``, ``unit_L``. Before its first time there
    was no load; the error of a pose is over the largest displacement; `points` asks for a model with memory at every
    point of the layer. Raises SceneError when a model cannot hold the scene, Collision where the target touches the
    coil plane, SolveFailed without a rest or an answer of the coils.
    """
    check_frequency(sensor.coils, sensor.frequency)  # before the layer is solved
    loads = expected_loads(sensor, history)
    field, by_field = loaded_model(sensor, magnetics, tolerance, loads)
    layer, by_layer = taken_layer(sensor, mechanics, tolerance, loads, points=points)
    every_omission, names = mechanical_omissions(sensor, by_layer.name, loads), sensor.coil_names
    left_out = tuple(item for item in every_omission if item.weighs)
    asked = _Asked(sensor, loads, (layer, field), magnetics, tolerance, left_out)
    divided, own = foreseen(history, BETWEEN * tolerance)
    while (answer := asked.solved(divided, own, progress)).more.any():
        divided = replace(divided, solved=divided.solved | answer.more)
    rows, motion, found, goal, every, _ = answer
    held = history.held
    poses = _bounded(sensor, left_out, every.pop("pose"), every.pop("error_pose"), held)
    stretch, wrench, off = every.pop("stretch"), every.pop("wrench"), every.pop("error_wrench")
    off = off + np.abs(wrench) * _of_forces(sensor, left_out)
    columns: dict[str, Any] = {"given": ("time", rows.given)}
    columns |= {name: ("time", part) for name, part in zip(WRENCH, wrench.T, strict=True)}
    columns |= {f"error_{WRENCH[k]}": ("time", off[:, k]) for k in np.flatnonzero(held)}
    for kind, each in (("", poses.value), ("error_", poses.error)):
        columns |= {f"{kind}{name}": ("time", part) for name, part in zip(POSE, each.T, strict=True)}
    columns |= {name: (("time", "coil", "coil_2")[: np.ndim(value)], value) for name, value in every.items()}
    left_out = (*left_out, *found.report.left_out)
    marks = flags_over(sensor, goal, poses, stretch, tolerance, left_out, interpolated=rows.interpolated)
    columns |= {name: ("time", part) for name, part in marks.items()}
    data = xr.Dataset(columns, coords={"time": rows.time, "coil": names, "coil_2": names})
    request: dict[str, Any] = {"mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance}
    request |= {"held": np.array(POSE)[held].tolist()} if held.any() else {}
    notes = dict.fromkeys((*_unknown(sensor), *motion.report.notes, *found.report.notes))
    data = data.assign(L0=(("coil", "coil_2"), found.L0)).assign_attrs(
        **provenance(sensor), request=json.dumps(request), notes=packed(notes), frequency=sensor.frequency,
        **found.convention, left_out=packed_omissions(left_out),
        report=kept_report(motion.report),
    )
    return labelled(data)


class _Answer(NamedTuple):
    """Values of a history at all its times, by those that are solved, and what else is to be solved."""

    rows: _Rows
    motion: Motion
    found: Impedance
    goal: Goal | None
    every: dict[str, Array]
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
        motion = _with_symmetry(sensor, divided, motion_of(sensor, layer, divided, progress))
        check_clearance(sensor, motion.pose)
        aim = aim_at(sensor, self.magnetics, tolerance, self.loads, farthest(motion.pose))
        pose, error = motion.pose.components, motion.error.components
        reading = read_poses(sensor, field if aim is None else aim.field,
                             _bounded(sensor, self.left_out, pose, error, divided.held))
        rows = _Rows(divided, own, motion, undeformed(sensor))
        found, goal = reading.impedance, None if aim is None else aim.goal
        values = {name: getattr(found, name) for name in ("L", "R", "error_L", "error_R")}
        values |= {name: np.asarray(value) for name, value in reading.signals.known.items()}
        forces = {"wrench": motion.wrench, "error_wrench": motion.error_wrench}
        every, off = rows.carried(values | forces | {"pose": pose, "error_pose": error, "stretch": motion.stretch})
        near, spent = every["error_pose"][rows.interpolated] - off["pose"], 0.0
        if goal is not None:
            spent = goal.magnetics + np.max(near @ np.abs(goal.weights).T, axis=1)
        most = np.clip(tolerance - spent, _LEAST * tolerance, BETWEEN * tolerance)
        more = _more(divided, own, motion.time, _share(sensor, goal, pose, values | forces, off) / most)
        return _Answer(rows, motion, found, goal, every, more)


def _bounded(sensor: Sensor, left_out: Sequence[Omission], pose: Array, error: Array, held: Mask) -> Bounded:
    """Return poses (p, 6) with errors that hold what the mechanics leave out, of places that are not held."""
    parts = np.where(held, 0.0, omitted_parts(sensor, left_out, pose))
    return Bounded.of(pose, error + np.abs(parts).sum(axis=0), parts)


def _of_forces(sensor: Sensor, left_out: Sequence[Omission]) -> Array:
    """Return what the mechanics leave out of forces under which places are held, (6,): displacements 1 + s as large."""
    s = np.abs(omitted_parts(sensor, left_out, unloaded_pose(sensor).components + 1.0))
    return np.asarray((s / (1.0 + s)).sum(axis=0))


def _share(
    sensor: Sensor, goal: Goal | None, pose: Array, values: Mapping[str, Array], off: Mapping[str, Array]
) -> Array:
    """Return errors of interpolation over the signals' range, by poses or of the signals, the larger of both.

    Of poses over the largest displacement where no signal changes; of forces that are found over the largest.
    """
    lever, signals = levers(sensor), shown_signals(values)
    size = np.max(np.abs((pose - unloaded_pose(sensor).components) * lever), initial=1e-300)
    weights = np.diag(lever / size) if goal is None else np.abs(goal.weights)
    span, lever = max(*(float(np.ptp(values[name])) for name in signals), 1e-300), np.maximum(lever, 1e-300)
    forces = off["wrench"] / lever / np.max(np.abs(values["wrench"]) / lever, initial=1e-300)
    each = *(off["pose"] @ weights.T).T, *forces.T, *(off[name] / span for name in signals)
    return np.asarray(np.max(each, axis=0))


@dataclass(frozen=True)
class _Rows:
    """All times of an answer: those that are solved, and rows of the history between them."""

    history: LoadHistory
    own: Mask  # which of its times are rows
    motion: Motion
    rest: Array  # (6,), pose from which the history has its places

    @property
    def left(self) -> NDArray[np.int_]:
        """Numbers of the rows that are not solved."""
        return np.flatnonzero(self.own & ~self.history.solved)

    def _merged(self, solved: NDArray[Any], between: NDArray[Any]) -> NDArray[Any]:
        """Return what is of solved times and of rows between them, in the order of time."""
        order = np.argsort(np.concatenate([self.motion.time, self.history.time[self.left]]), kind="stable")
        return np.concatenate([solved, between])[order]

    @property
    def time(self) -> Array:
        """All times [s]."""
        return self._merged(self.motion.time, self.history.time[self.left])

    @property
    def interpolated(self) -> Mask:
        """Which times are not solved."""
        return self._merged(np.zeros(self.motion.time.size, dtype=bool), np.ones(self.left.size, dtype=bool))

    @property
    def given(self) -> Mask:
        """Which times are the history's."""
        own = self.motion.given & np.isin(self.motion.time, self.history.time[self.own])
        return self._merged(own, np.ones(self.left.size, dtype=bool))

    def carried(self, values: Mapping[str, Array]) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return values at all times, ``error_`` with the errors of interpolation; and these, at rows between.

        Loads and places that the history gives are its own.
        """
        history, left = self.history, self.left
        corners = np.isin(self.motion.time, history.time[history.corners])
        found = {n: Interpolant(self.motion.time, corners, part).at(history.time[left]) for n, part in values.items()}
        for name, held in (("pose", history.held), ("wrench", ~history.held)):
            given = history.course[left] + self.rest * (name == "pose")
            found[name] = np.where(held, given, found[name][0]), np.where(held, 0.0, found[name][1])
        off = {name: error for name, (_, error) in found.items()}
        return {
            name: self._merged(part, found[name][0] + off.get(name.removeprefix("error_"), 0.0) * ("error_" in name))
            for name, part in values.items()
        }, off


def foreseen(history: LoadHistory, most: float) -> tuple[LoadHistory, Mask]:
    """Divide a history for errors of interpolation; return also which times are its own.

    Half is for the load's own course in time, which is interpolated first, the other for what a response adds to it.
    """
    divided, own = history.divided(PARTS, max(PARTS, int(np.ceil(np.sqrt(_BEND / most)))))
    load, corners = divided.shares, divided.corners
    while True:
        known, left = divided.solved, own & ~divided.solved
        _, off = Interpolant(divided.time[known], corners[known], load[known]).at(divided.time[left])
        more = _more(divided, own, divided.time[known], np.max(off, axis=1) / (0.5 * most))
        if not more.any():
            return divided, own
        divided = replace(divided, solved=known | more)


def _more(history: LoadHistory, own: Mask, solved: Array, share: Array) -> Mask:
    """Return which times to solve besides, from solved ones and errors of interpolation over their limit, by row."""
    left, found = np.flatnonzero(own & ~history.solved), np.zeros(own.size, dtype=bool)
    inside = np.searchsorted(solved, history.time[left], side="right")
    for number in np.unique(inside[share > 1.0]):
        rows = left[inside == number]
        pieces = int(np.ceil(np.sqrt(share[inside == number].max())))
        found[rows[np.arange(1, pieces) * len(rows) // pieces]] = True
    return found


def expected_loads(sensor: Sensor, history: LoadHistory) -> list[Wrench]:
    """Return the loads of a history, those that hold places by one compliance, under slow load.

    Raises SceneError for places of a touched sensor, out of the plane, or a thickness and more from the undeformed pad.
    """
    course, held = history.course, history.held
    if held.any():
        check_untouched(sensor, "places over time")
        if beside := np.array(POSE)[3:][held[3:]].tolist():
            raise SceneError(f"history: places must be of {', '.join(POSE[:3])}; got {', '.join(beside)}")
        t, rest = layer_parts(sensor)[1].thickness, undeformed(sensor)[1]
        far = float(rest + course[np.argmax(np.abs(course[:, 1])), 1])
        if held[1] and abs(far - rest) >= t:
            must = f"within a thickness of rest, between {mm(rest - t)} and {mm(rest + t)}"
            raise SceneError(f"history: d_v must be {must}; got {mm(far)}")
        loads, _ = compliant_loads(sensor, small_strain(sensor, _COARSE), course, held)
        loads[np.abs(loads) <= _ROUNDING * np.max(np.abs(loads))] = 0.0
        course = np.where(held, loads, course)
    return [Wrench(*row) for row in course.tolist()]


def taken_layer(
    sensor: Sensor, mechanics: str, tolerance: float, loads: Sequence[Wrench], *, points: bool = False
) -> tuple[MechanicalModel, Choice]:
    """Return the mechanical model: small loads take a smaller one; softening takes one at finite strain.

    Raises SceneError for a named model without memory at every point, where `points` asks for it.
    """
    if points:
        check_untouched(sensor, "every point of the pad over time")
    found = mechanical_model(sensor, mechanics, tolerance, loads)
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
