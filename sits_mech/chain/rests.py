"""Find the equilibrium under a load: solve an image of it, on meshes as fine as the signals need, and turn it back."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sits_mech.chain.models import Choice, loaded_model
from sits_mech.chain.omitted.mechanical import including, mechanical_omissions
from sits_mech.chain.plans.aimed import aim_at
from sits_mech.chain.plans.goal import Goal
from sits_mech.chain.plans.prices import MeshForecast
from sits_mech.chain.propagation import poses_of
from sits_mech.geometry.collision import check_clearance
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.levels.words import wrench_words
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.symmetry import Symmetry, image_of, image_of_rest, symmetrised, symmetry_of
from sits_mech.mechanics.touch import check_untouched
from sits_mech.notes import Omission
from sits_mech.quantities import (
    WRENCH,
    Array,
    Equilibrium,
    MagneticModel,
    MechanicalModel,
    PathModel,
    SolveFailed,
    Wrench,
)
from sits_mech.scene.sensor import SceneError, Sensor

_LOG = logging.getLogger(__name__)
_NO_PATH = "via: must be left out without elastomer.friction: the load path makes no difference"


class AimedRest(NamedTuple):
    """The equilibrium under a load, and under its solved image, and the magnetic model for its pose."""

    rest: Equilibrium  # without what the mechanics leave out
    image: Equilibrium  # under the load that was solved for it
    back: Array  # (6, 6), takes the image back to the load
    left_out: tuple[Omission, ...]  # by the mechanics
    field: MagneticModel  # as fine as the signals need
    asked: float  # tolerance of `field`
    planned: MeshForecast | None = None  # from the first meshes; None where nothing was planned
    reached: float = float("nan")  # error of the numerics over the signals' full scale
    goal: Goal | None = None


def aimed_rest(
    sensor: Sensor, loads: Sequence[Wrench], mechanics: tuple[MechanicalModel, Choice], magnetics: tuple[str, float],
    symmetry: Symmetry, *, best: bool = True,
) -> AimedRest:
    """Solve the equilibrium under a load to a tolerance of the signals, on meshes that its first two show to be needed.

    `loads` are those passed on the way, for a layer with friction, and the load; `mechanics` is the model with its
    choice (`aimed_mechanics`), `magnetics` the model's name as asked for and the tolerance; raises as `simulate`.
    """
    (*via, wrench), (layer, choice), (name, tolerance) = loads, mechanics, magnetics
    left_out = mechanical_omissions(sensor, choice.name, [wrench], bent=choice.bent)
    field, _ = loaded_model(sensor, name, tolerance, loads)
    if via:
        found = _along_path(sensor, layer, loads)
        return AimedRest(found, found, np.eye(len(WRENCH)), left_out, field, tolerance)
    aim = None
    if not depends_on_path(sensor):
        rough = layer.rough if isinstance(layer, RefinedModel) else layer
        first, start, back = _of_load(sensor, symmetry, rough, wrench)
        check_clearance(sensor, first.pose)
        aim = aim_at(sensor, name, tolerance, [wrench], [first.pose])
    if aim is None:
        return AimedRest(*_of_load(sensor, symmetry, layer, wrench), left_out, field, tolerance)
    aim = aim.sharing([first], [including(sensor, first, left_out)])
    if not isinstance(layer, RefinedModel):
        return AimedRest(first, start, back, left_out, aim.field, aim.asked, goal=aim.goal)
    planned = aim.promised(first, 1)
    if not best:
        aim.refuse_beyond(planned, wrench_words(vars(wrench)))
    finer = layer.towards(aim.goal.weights @ back, aim.left)
    rest, found, _ = _of_load(sensor, symmetry, finer, wrench, start)
    error = aim.goal.of(poses_of([rest]))
    return AimedRest(rest, found, back, left_out, aim.field, aim.asked, planned, error, aim.goal)


def at_rest(
    sensor: Sensor, layer: MechanicalModel, wrench: Wrench, left_out: tuple[Omission, ...], via: Sequence[Wrench] = (),
    *, known: Equilibrium | None = None,
) -> Equilibrium:
    """Return the equilibrium under a load; components of its pose that symmetry forbids are zero without error.

    A load is solved as one of its images, as for `calibrate`: by half the pad if that lies in the plane. The state of
    another image is not that of the load, and is left out. Its error holds `left_out`, what the layer leaves out of the
    load. `via` are loads passed on the way, for a layer with friction. Raises SceneError where the layer has no
    friction, SolveFailed without equilibrium. `known`: solved before.
    """
    if known is not None:
        found = symmetrised(known, symmetry_of(sensor), wrench)
    elif via:
        found = _along_path(sensor, layer, [*via, wrench])
    else:
        found = _of_load(sensor, symmetry_of(sensor), layer, wrench)[0]
    return including(sensor, found, left_out)


def _of_load(
    sensor: Sensor, symmetry: Symmetry, layer: MechanicalModel, wrench: Wrench, start: Equilibrium | None = None
) -> tuple[Equilibrium, Equilibrium, Array]:
    """Return the equilibrium under a load, that under its solved image, and the matrix back; as `image_at_rest`."""
    found, back = image_at_rest(symmetry, layer, wrench, start)
    image = symmetrised(found, symmetry_of(sensor), found.wrench)
    return (image if found.wrench == wrench else image_of_rest(image, back, wrench)), found, back


def image_at_rest(
    symmetry: Symmetry, layer: MechanicalModel, wrench: Wrench, start: Equilibrium | None = None
) -> tuple[Equilibrium, Array]:
    """Return the equilibrium under the solved image of a load, and the matrix that takes it back to the load.

    `start` is an equilibrium under that image. Raises SolveFailed, with the load and not its image, without one.
    """
    solved, back = symmetry.standard(wrench)
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
        last = error.last
        last = None if last is None else image_of_rest(last, back, Wrench(*(back @ last.wrench.components)))
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
    check_way(sensor, loads)
    if not isinstance(layer, PathModel):
        raise SceneError(_NO_PATH)
    return symmetrised(layer.along(loads), symmetry_of(sensor), *loads)
