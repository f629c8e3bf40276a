"""Put what a mechanical model leaves out of poses into their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sits_mech.chain.models import MECHANICS, Choice
from sits_mech.chain.omitted.bending import bending
from sits_mech.chain.plans.goal import tolerance_left
from sits_mech.chain.propagation import levers, unloaded_pose
from sits_mech.description import Question, added, by_component, sized
from sits_mech.mechanics.levels.answer import relative
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.touch import on_target
from sits_mech.notes import NoteKind, Omission, OmissionKind
from sits_mech.quantities import Array, Equilibrium, MechanicalModel, Pose, Wrench
from sits_mech.scene.sensor import Sensor


def with_omissions(sensor: Sensor, rests: Sequence[Equilibrium], name: str, adapted: bool = False) -> list[Equilibrium]:
    """Return equilibria whose errors hold what the mechanical model of a name leaves out, a part that all share."""
    bent = [any(note.kind is NoteKind.BENT for note in rest.report.notes) for rest in rests]
    left_out = mechanical_omissions(sensor, name, [rest.wrench for rest in rests], bent=all(bent)) if rests else ()
    left_out = tuple(replace(item, included=item.included or adapted) for item in left_out)  # by errors of the table
    of_bent = tuple(item for item in left_out if item.kind is not OmissionKind.BENDING)
    return [including(sensor, rest, of_bent if solved else left_out) for rest, solved in zip(rests, bent, strict=True)]


def mechanical_omissions(
    sensor: Sensor, name: str, loads: Sequence[Wrench], *, bent: bool = False
) -> tuple[Omission, ...]:
    """Return all that the mechanical model of a name leaves out of loads, with sizes that may take a solve.

    None of a model without a description; `bent` tells that it bends the target.
    """
    if name not in MECHANICS:
        return ()
    model, question = MECHANICS[name], Question(loads=on_target(sensor, loads), closely=True)
    return (*model.omissions(sensor, question), *(() if bent else bending(sensor, loads, model.least)))


def within_omissions(
    layer: MechanicalModel, choice: Choice, tolerance: float, left_out: Sequence[Omission]
) -> MechanicalModel:
    """Return the chosen mechanical model with numerics to what a tolerance leaves beside its omissions."""
    left = tolerance_left(sized(item for item in left_out if not item.included), tolerance)
    if left == tolerance or not isinstance(layer, RefinedModel):
        return layer
    return layer.towards(None, min(left, choice.asked(left)))


def omitted_parts(sensor: Sensor, left_out: Sequence[Omission], pose: Array) -> Array:
    """Return the signed changes of poses (..., 6) by omissions, shape (m, ..., 6) [m, rad]."""
    moved = pose - unloaded_pose(sensor).components
    sizes = [by_component(item, moved) for item in left_out if not item.included and not item.unbounded]
    return np.array(sizes).reshape(-1, *pose.shape)


def including(sensor: Sensor, rest: Equilibrium, left_out: tuple[Omission, ...]) -> Equilibrium:
    """Return an equilibrium whose error holds the omissions that count."""
    left_out = tuple(item for item in left_out if item.weighs)
    if not left_out:
        return rest
    parts, lever = omitted_parts(sensor, left_out, rest.pose.components), levers(sensor)
    error = Pose.of(rest.error.components + np.abs(parts).sum(axis=0))
    moved = rest.pose.components - unloaded_pose(sensor).components
    size = sum(relative(np.abs(part), moved, lever) for part in parts)
    shared = np.concatenate([rest.shared, parts])
    return replace(rest, error=error, shared=shared, report=added(rest.report, left_out, size))
