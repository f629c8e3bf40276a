"""Simulate the sensor under a history of loads: poses by the layer's memory, and the coils' answer.

    loads Q(t) --(layer with a memory: mechanics/histories.py)--> poses q(t) --(magnetics)--> L(t), signals

The loads of a file are divided where they move by more than a share of their range, so that what lies between two
solved times is smooth; between them monotone cubics carry each inductance from corner to corner of the load.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from sits_mech.cases import Progress, untold
from sits_mech.chain.aimed import aim_at
from sits_mech.chain.goal import farthest
from sits_mech.chain.models import Choice, loaded_model, mechanical_model
from sits_mech.chain.propagation import read_poses
from sits_mech.chain.simulate import counted_omissions, flags_over, omitted_parts
from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.tracks import check_frequency
from sits_mech.labels import labelled
from sits_mech.mechanics.histories import LoadHistory, Motion, TimedModel, motion_of
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.notes import Note, NoteKind, packed, packed_omissions
from sits_mech.quantities import POSE, WRENCH, Array, Bounded, MechanicalModel, Pose, Wrench, kept_report
from sits_mech.scene.sensor import SceneError, Sensor, provenance, silicones_of

PARTS = 8
"""Steps over the range of a load that lie between two solved times, at most."""
_CORNER = 0.5  # of a load's rate: a jump by more is a corner


def in_time(
    sensor: Sensor, history: LoadHistory, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto",
    progress: Progress = untold, points: bool = False,
) -> xr.Dataset:
    """Return poses, inductances and signals under a history of loads, as a Dataset over time.

    ``given`` (whether the time is of the history, or solved between two of them), the wrench, pose, ``L`` (coil,
    coil_2) and the signals, each with ``error_``; ``status`` and ``flags``; ``L0``. Attributes: scene, request,
    ``notes``, ``unit_L``. Before its first time there was no load; the error of a pose is over the largest
    displacement; `points` asks for a model with memory at every point of the layer. Raises SceneError when a model
    cannot hold the scene, Collision where the target touches the coil plane, SolveFailed without a rest or an answer of
    the coils.
    """
    check_frequency(sensor.coils, sensor.frequency)  # before the layer is solved
    field, by_field = loaded_model(sensor, magnetics, tolerance, history.loads)
    layer, by_layer = taken_layer(sensor, mechanics, tolerance, history, points=points)
    divided, own = history.divided(PARTS)
    motion = _with_symmetry(sensor, motion_of(sensor, layer, divided, progress))
    check_clearance(sensor, motion.pose)
    aim = aim_at(sensor, magnetics, tolerance, history.loads, farthest(motion.pose))
    left_out = counted_omissions(sensor, by_layer.name, history.loads)
    parts = omitted_parts(sensor, left_out, motion.pose.components)
    motion = replace(motion, error=Pose.of(motion.error.components + np.abs(parts).sum(axis=0)))
    poses = Bounded.of(motion.pose.components, motion.error.components, parts)
    reading = read_poses(sensor, field if aim is None else aim.field, poses)
    columns: dict[str, Any] = {"given": ("time", motion.given & np.isin(motion.time, divided.time[own]))}
    columns |= {name: ("time", part) for name, part in zip(WRENCH, motion.wrench.T, strict=True)}
    for kind, pose in (("", motion.pose), ("error_", motion.error)):
        columns |= {f"{kind}{name}": ("time", part) for name, part in zip(POSE, pose.components.T, strict=True)}
    found = reading.impedance
    columns |= {name: (("time", "coil", "coil_2"), getattr(found, name)) for name in ("L", "R", "error_L", "error_R")}
    columns |= {name: ("time", np.asarray(value)) for name, value in reading.signals.known.items()}
    left_out = (*left_out, *found.report.left_out)
    marks = flags_over(sensor, None if aim is None else aim.goal, poses, motion.stretch, tolerance, left_out)
    columns |= {name: ("time", part) for name, part in marks.items()}
    names = sensor.coil_names
    data = xr.Dataset(columns, coords={"time": motion.time, "coil": names, "coil_2": names})
    request = {"mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance}
    notes = dict.fromkeys((*_unknown(sensor), *motion.report.notes, *found.report.notes))
    data = data.assign(L0=(("coil", "coil_2"), found.L0)).assign_attrs(
        **provenance(sensor), request=json.dumps(request), notes=packed(notes), frequency=sensor.frequency,
        **found.convention, left_out=packed_omissions(left_out),
        report=kept_report(motion.report),
    )
    return labelled(data)


def taken_layer(
    sensor: Sensor, mechanics: str, tolerance: float, history: LoadHistory, *, points: bool = False
) -> tuple[MechanicalModel, Choice]:
    """Return the mechanical model: small loads take a smaller one; softening takes one at finite strain.

    Raises SceneError for a named model without memory at every point, where `points` asks for it.
    """
    found = mechanical_model(sensor, mechanics, tolerance, history.loads)
    softens = any(each.mullins is not None for each in silicones_of(sensor))
    if isinstance(found[0], TimedModel) or not (points or softens):
        return found
    if mechanics == "auto":
        return mechanical_model(sensor, "block", tolerance, history.loads)
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


def _with_symmetry(sensor: Sensor, motion: Motion) -> Motion:
    """Return a motion without the components of pose and error that the symmetry of scene and loads forbids."""
    loads = [Wrench(*row) for row in motion.wrench.tolist()]
    kept = symmetry_of(sensor).projection(*loads)
    pose, error = motion.pose.components @ kept.T, motion.error.components @ np.abs(kept).T
    return replace(motion, pose=Pose.of(pose), error=Pose.of(error))


def between(time: Array, load: Array, values: Array) -> Callable[[Array], Array]:
    """Return an interpolation from values (m, ...) at rising times (m,), ends held, to all times.

    Monotone cubics from corner to corner of the load (m, 6): where its rate jumps, the response has a kink.
    """
    rate = np.diff(load, axis=0) / np.diff(time)[:, None]
    size, jump = np.linalg.norm(rate, axis=1), np.linalg.norm(np.diff(rate, axis=0), axis=1)
    corners = 1 + np.flatnonzero(jump > _CORNER * np.maximum(size[1:], size[:-1]))
    ends = np.array([0, *corners.tolist(), len(time) - 1])
    legs = [PchipInterpolator(time[a : b + 1], values[a : b + 1], axis=0) for a, b in pairwise(ends)]

    def at(times: Array) -> Array:
        """Return values at other times."""
        held = np.clip(times, time[0], time[-1])
        leg = np.clip(np.searchsorted(time[ends], held, side="right") - 1, 0, len(legs) - 1)
        found = np.empty((*held.shape, *values.shape[1:]))
        for number in np.unique(leg):
            found[leg == number] = legs[number](held[leg == number])
        return found

    return at
