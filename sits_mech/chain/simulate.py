"""Simulate the sensor under a load: wrench to pose to inductance.

    wrench --(mechanics)--> pose p +- e --(magnetics)--> L(p), R(p) --> signals

The models keep linear algebra to one thread (`threads`); nothing here is large enough to gain from a second.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.aimed import Promise, aim_at
from sits_mech.chain.bending import bending
from sits_mech.chain.goal import Goal, goal_at, tolerance_left
from sits_mech.chain.models import MECHANICS, Choice, loaded_model, mechanical_model
from sits_mech.chain.prices import Look
from sits_mech.chain.propagation import poses_of, read_poses, signals_at, unloaded_pose
from sits_mech.description import Question, added, by_component, sized
from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.tracks import check_frequency
from sits_mech.mechanics.depth import TouchLoad, to_depth
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.levels.words import wrench_words
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.symmetry import Symmetry, image_of, symmetrised, symmetry_of, turned
from sits_mech.mechanics.touch import check_untouched, on_target
from sits_mech.notes import NoteKind, Omission, OmissionKind
from sits_mech.quantities import (
    WRENCH,
    Array,
    Bounded,
    Equilibrium,
    Impedance,
    MagneticModel,
    Mask,
    MechanicalModel,
    PathModel,
    Pose,
    SolveFailed,
    Wrench,
)
from sits_mech.readout.signals import Signals
from sits_mech.scene.sensor import SceneError, Sensor, known_stretch
from sits_mech.status import OK, flags_of, marked

_LOG = logging.getLogger(__name__)
_NO_PATH = "via: must be left out without elastomer.friction: the load path makes no difference"


@dataclass(frozen=True)
class Simulation:
    """What the sensor shows under one load.

    Attributes
    ----------
    equilibrium : Equilibrium
        Where the target comes to rest.
    impedance : Impedance
        What the coils show; its errors include what the pose's error makes of them.
    signals : Signals
        Combined, with errors.
    promise : Promise or None
        What was planned and what was reached; None where nothing was planned.
    flags : tuple of str
        What holds of the answer, worst first, as of `status.flags_of`.
    left_out : tuple of Omission
        All that the mechanical model leaves out, what changes nothing as well.
    """

    equilibrium: Equilibrium
    impedance: Impedance
    signals: Signals
    promise: Promise | None = None
    flags: tuple[str, ...] = (OK,)
    left_out: tuple[Omission, ...] = ()

    @property
    def status(self) -> str:
        """The worst of the flags."""
        return self.flags[0]


@checked_arguments
def simulate(
    sensor: Sensor, wrench: Wrench | TouchLoad, *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto", via: Sequence[Wrench] = (), best: bool = True,
) -> Simulation:
    """Return what the sensor shows under a load.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    wrench : Wrench or TouchLoad
        The load [N, N m], or that of the scene's touch as `touch_load` finds it, whose error counts.
    tolerance : float
        Asked error of the signals, over the largest change that any of them shows from rest to the load.
    mechanics, magnetics : str
        Names of the models.
    via : sequence of Wrench
        Loads that are passed on the way from rest, for a layer with friction.
    best : bool
        Whether a tolerance that cannot be reached is answered as well as possible; without it models of several meshes
        refuse it.

    Returns
    -------
    Simulation
        Equilibrium, impedance and signals.

    Raises
    ------
    SceneError
        When a model cannot hold the scene, or without `best` a tolerance cannot be reached.
    Collision
        When the target comes to the coil plane.
    SolveFailed
        When the layer has no equilibrium that could be reached, or the coils cannot be solved at the pose.

    Examples
    --------
    >>> sensor = sm.load_sensor("biorob2018")
    >>> found = sm.simulate(sensor, sm.Wrench(F_x=0.2), mechanics="linear", magnetics="planar", tolerance=0.1)
    >>> round(1e6 * found.equilibrium.pose.d_h)  # um
    241
    >>> round(found.signals.known["dL_x"], 2)  # % of L0
    1.45
    """
    check_frequency(sensor.coils, sensor.frequency)  # before the layer is solved
    began = time.process_time()
    wrench, depth = (wrench.wrench, wrench.depth) if isinstance(wrench, TouchLoad) else (wrench, None)
    layer, choice = mechanical_model(sensor, mechanics, tolerance, [*via, wrench])
    layer = layer if depth is None else to_depth(layer, sensor, depth)
    if via:
        field, _ = loaded_model(sensor, magnetics, tolerance, [*via, wrench])
        left_out = mechanical_omissions(sensor, choice.name, [wrench], bent=choice.bent)
        shown = simulated(sensor, field, at_rest(sensor, layer, wrench, left_out, via))
        return _flagged(sensor, field, replace(shown, left_out=left_out), tolerance)
    found = aimed_rest(sensor, wrench, (layer, choice), (magnetics, tolerance), symmetry_of(sensor), best=best)
    rest = _with(sensor, _of_load(sensor, found.found, wrench, found.back), found.left_out)
    shown = replace(simulated(sensor, found.field, rest), left_out=found.left_out)
    if found.planned is not None:
        error = whole_error(found.goal, rest, shown.impedance.report.left_out)
        shown = replace(shown, promise=Promise(found.planned, time.process_time() - began, found.reached, error))
    return _flagged(sensor, found.field, shown, tolerance, found.goal)


def _flagged(
    sensor: Sensor, field: MagneticModel, shown: Simulation, tolerance: float, goal: Goal | None = None
) -> Simulation:
    """Flag an answer by the tolerance of its signals, with all that is left out, and by the silicone's data."""
    rest = shown.equilibrium
    goal = goal or goal_at(sensor, field, [rest.pose])
    left_out = shown.impedance.report.left_out
    error = whole_error(goal, rest, left_out)
    return replace(shown, flags=rest_flags(sensor, rest, tolerance, error, left_out))


def whole_error(goal: Goal | None, rest: Equilibrium, left_out: Sequence[Omission]) -> float:
    """Return the error of an answer over the signals' full scale, with all that is left out; 0 without a goal.

    `left_out` is what the magnetic model leaves out; the errors of the pose hold what the mechanics do.
    """
    return 0.0 if goal is None else goal.of(poses_of([rest])) + sized(left_out)


def flags_over(
    sensor: Sensor, goal: Goal | None, poses: Bounded, stretch: Array, tolerance: float,
    left_out: Sequence[Omission] = (), *, interpolated: Mask | bool = False,
) -> dict[str, list[str]]:
    """Return status and flags over time, as `marked`, from poses (p, 6), stretches (p,) and which are `interpolated`.

    `left_out` is what both halves leave out; errors of poses hold what the mechanics do.
    """
    known, count, bounded = known_stretch(sensor), len(stretch), not any(item.unbounded for item in left_out)
    more = sized(item for item in left_out if item.half == "magnetics")
    errors = [0.0 if goal is None else goal.of(poses[k]) + more for k in range(count)]
    each = [
        marked(flags_of(own, tolerance, most, known, interpolated=between, bounded=bounded))
        for own, most, between in zip(errors, stretch.tolist(), np.broadcast_to(interpolated, count), strict=True)
    ]
    return {name: [row[name] for row in each] for name in ("status", "flags")}


def rest_flags(
    sensor: Sensor, found: Equilibrium, tolerance: float, error: float | None = None,
    left_out: Sequence[Omission] = (),
) -> tuple[str, ...]:
    """Return the flags of an equilibrium by an error, by default that of its pose, and by the silicone's data.

    They are as of `flags_of`; `left_out` is what the magnetic model leaves out.
    """
    report = found.report
    error = report.estimated_error if error is None else error
    return flags_of(
        error, tolerance, report.stretch, known_stretch(sensor), changed=report.error_stretch,
        bounded=not any(item.unbounded for item in (*report.left_out, *left_out)),
    )


def with_omissions(sensor: Sensor, rests: Sequence[Equilibrium], name: str, *, held: bool = False) -> list[Equilibrium]:
    """Return equilibria whose errors hold what the mechanical model of a name leaves out, a part that all share."""
    bent = [any(note.kind is NoteKind.BENT for note in rest.report.notes) for rest in rests]
    left_out = mechanical_omissions(sensor, name, [rest.wrench for rest in rests], bent=all(bent)) if rests else ()
    left_out = tuple(replace(item, held=item.held or held) for item in left_out)  # by errors of an adapted table
    of_bent = tuple(item for item in left_out if item.kind is not OmissionKind.BENDING)
    return [_with(sensor, rest, of_bent if solved else left_out) for rest, solved in zip(rests, bent, strict=True)]


def mechanical_omissions(
    sensor: Sensor, name: str, loads: Sequence[Wrench], *, bent: bool = False
) -> tuple[Omission, ...]:
    """Return all that the mechanical model of a name leaves out of loads, with sizes that may take a solve.

    None of a model without a description; `bent` tells that it bends the target.
    """
    if name not in MECHANICS:
        return ()
    model, question = MECHANICS[name], Question(loads=on_target(sensor, loads), closely=True)
    return (*model.leaves_out(sensor, question), *(() if bent else bending(sensor, loads, model.least)))


def within_omissions(
    layer: MechanicalModel, choice: Choice, tolerance: float, left_out: Sequence[Omission]
) -> MechanicalModel:
    """Return the chosen mechanical model with numerics to what a tolerance leaves beside its omissions."""
    left = tolerance_left(sized(item for item in left_out if not item.held), tolerance)
    if left == tolerance or not isinstance(layer, RefinedModel):
        return layer
    return layer.towards(None, left if choice.by_name else min(left, choice.tolerance))


def omitted_parts(sensor: Sensor, left_out: Sequence[Omission], pose: Array) -> Array:
    """Return the signed changes of poses (..., 6) by omissions, shape (m, ..., 6) [m, rad]."""
    moved = pose - unloaded_pose(sensor).components
    sizes = [by_component(item, moved) for item in left_out if not item.held and not item.unbounded]
    return np.array(sizes).reshape(-1, *pose.shape)


def _with(sensor: Sensor, rest: Equilibrium, left_out: tuple[Omission, ...]) -> Equilibrium:
    """Return an equilibrium whose error holds the omissions that count."""
    left_out = tuple(item for item in left_out if item.weighs)
    if not left_out:
        return rest
    parts = omitted_parts(sensor, left_out, rest.pose.components)
    error = Pose.of(rest.error.components + np.abs(parts).sum(axis=0))
    shared = np.concatenate([rest.shared, parts])
    return replace(rest, error=error, shared=shared, report=added(rest.report, left_out))


class AimedRest(NamedTuple):
    """The equilibrium under the solved image of a load, and the magnetic model for its pose."""

    found: Equilibrium
    back: Array  # (6, 6), takes the image back to the load
    left_out: tuple[Omission, ...]  # by the mechanics
    field: MagneticModel  # as fine as the signals need
    asked: float  # tolerance of `field`
    planned: Look | None = None  # from the first meshes; None where nothing was planned
    reached: float = float("nan")  # error of the numerics over the signals' full scale
    goal: Goal | None = None


def aimed_rest(
    sensor: Sensor, wrench: Wrench, mechanics: tuple[MechanicalModel, Choice], magnetics: tuple[str, float],
    symmetry: Symmetry, *, best: bool = True,
) -> AimedRest:
    """Solve the equilibrium under a load to a tolerance of the signals, on meshes that its first two show to be needed.

    `magnetics` is the model's name as asked for and the tolerance; raises as `simulate`.
    """
    (layer, choice), (name, tolerance) = mechanics, magnetics
    left_out = mechanical_omissions(sensor, choice.name, [wrench], bent=choice.bent)
    field, _ = loaded_model(sensor, name, tolerance, [wrench])
    if not isinstance(layer, RefinedModel) or depends_on_path(sensor):
        return AimedRest(*image_at_rest(symmetry, layer, wrench), left_out, field, tolerance)
    start, back = image_at_rest(symmetry, layer.rough, wrench)
    first = _of_load(sensor, start, wrench, back)
    check_clearance(sensor, first.pose)
    aim = aim_at(sensor, name, tolerance, [wrench], [first.pose])
    if aim is None:
        return AimedRest(*image_at_rest(symmetry, layer, wrench), left_out, field, tolerance)
    aim = aim.sharing([first], [_with(sensor, first, left_out)])
    planned = aim.promised(first, 1)
    if not best:
        aim.refuse_beyond(planned, wrench_words(vars(wrench)))
    finer = layer.towards(aim.goal.weights @ back, aim.left)
    found, _ = image_at_rest(symmetry, finer, wrench, start)
    rest = _of_load(sensor, found, wrench, back)
    error = aim.goal.of(poses_of([rest]))
    return AimedRest(found, back, left_out, aim.field, aim.asked, planned, error, aim.goal)


def at_rest(
    sensor: Sensor, layer: MechanicalModel, wrench: Wrench, left_out: tuple[Omission, ...], via: Sequence[Wrench] = (),
    *, known: Equilibrium | None = None,
) -> Equilibrium:
    """Return the equilibrium under a load; components of its pose that symmetry forbids are zero without error.

    A load that leaves the plane is solved as one of its images, as for `calibrate`: by half the pad if that lies in the
    plane. The state of an image is not that of the load, and is left out. Its error holds `left_out`, what the layer
    leaves out of the load. `via` are loads passed on the way, for a layer with friction. Raises SceneError where the
    layer has no friction, SolveFailed without equilibrium. `known`: solved before.
    """
    if known is not None:
        found = symmetrised(known, symmetry_of(sensor), wrench)
    elif via:
        found = _along_path(sensor, layer, [*via, wrench])
    else:
        image, back = image_at_rest(symmetry_of(sensor), layer, wrench)
        found = _of_load(sensor, image, wrench, back)
    return _with(sensor, found, left_out)


def _of_load(sensor: Sensor, found: Equilibrium, wrench: Wrench, back: Array) -> Equilibrium:
    """Return the equilibrium under a load from that under its solved image."""
    image = symmetrised(found, symmetry_of(sensor), found.wrench)
    return image if found.wrench == wrench else turned(image, back, wrench)


def image_at_rest(
    symmetry: Symmetry, layer: MechanicalModel, wrench: Wrench, start: Equilibrium | None = None
) -> tuple[Equilibrium, Array]:
    """Return the equilibrium under the solved image of a load, and the matrix that takes it back to the load.

    `start` is an equilibrium under that image. Raises SolveFailed, with the load and not its image, without one.
    """
    solved, back = symmetry.standard(wrench) if wrench.out_of_plane else (wrench, np.eye(len(WRENCH)))
    try:
        found = layer.equilibrium(solved, start=start)
        if _LOG.isEnabledFor(logging.INFO):
            words, report = wrench_words(vars(solved)), found.report
            _LOG.info("%s: at rest under %s, %d unknowns, error %.2g", report.model, words, report.unknowns,
                      report.estimated_error)
        return found, back
    except SolveFailed as error:
        if solved == wrench:
            raise
        last = None if error.last is None else turned(error.last, back, Wrench(*(back @ error.last.wrench.components)))
        carried = None
        if error.carried is not None:
            load, off = (each.components for each in error.carried)
            carried = Wrench(*image_of(back, load).tolist()), Wrench(*image_of(np.abs(back), off).tolist())
        message = f"{error} (an image of the load was solved)"
        raise SolveFailed(message, error.report, last, error.half, carried) from error


def check_way(sensor: Sensor, loads: Sequence[Wrench]) -> None:
    """Refuse loads passed on the way to the last one where they make no difference."""
    if len(loads) > 1 and not depends_on_path(sensor):
        raise SceneError(_NO_PATH)


def _along_path(sensor: Sensor, layer: MechanicalModel, loads: Sequence[Wrench]) -> Equilibrium:
    """Return the equilibrium at the end of a load path, without what the symmetry of all its loads forbids."""
    check_untouched(sensor, "loads on the way (via)")
    if not (depends_on_path(sensor) and isinstance(layer, PathModel)):
        raise SceneError(_NO_PATH)
    return symmetrised(layer.along(loads), symmetry_of(sensor), *loads)


def simulated(sensor: Sensor, field: MagneticModel, equilibrium: Equilibrium) -> Simulation:
    """Return the simulation of an equilibrium: impedance and signals at its pose."""
    check_clearance(sensor, equilibrium.pose)
    try:
        reading = read_poses(sensor, field, poses_of([equilibrium]))
    except SolveFailed as error:  # the target rests, the coils are not solved
        raise SolveFailed(str(error), error.report, equilibrium, "magnetics") from error
    found = reading.impedance
    single = {name: getattr(found, name)[0] for name in ("L", "R", "error_L", "error_R")}
    return Simulation(equilibrium, replace(found, **single), signals_at(reading.signals, 0))
