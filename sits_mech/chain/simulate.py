"""Force in, inductance out: the one place where both physics meet.

    wrench --(mechanics)--> pose p +- e --(magnetics)--> L(p), R(p) --> signals

The models keep linear algebra to one thread (`threads`); nothing here is large enough to gain from a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.pose_errors import read_poses, signals_at, stacked
from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.waves import check_frequency
from sits_mech.mechanics.symmetry import Symmetry, image_of, symmetry_of
from sits_mech.quantities import (
    WRENCH,
    Array,
    Equilibrium,
    Impedance,
    MagneticModel,
    MechanicalModel,
    PathModel,
    Pose,
    SolveFailed,
    Wrench,
)  # fmt: skip
from sits_mech.readout.signals import Signals
from sits_mech.scene.sensor import SceneError, Sensor


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
    """

    equilibrium: Equilibrium
    impedance: Impedance
    signals: Signals


def simulate(
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto",
    via: Sequence[Wrench] = (),
) -> Simulation:  # fmt: skip
    """Return what the sensor shows under a load.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    wrench : Wrench
        The load [N, N m].
    tolerance : float
        Asked relative error of the pose; of the change of inductance a tenth of it, by sheets as much.
    mechanics, magnetics : str
        Names of the models.
    via : sequence of Wrench
        Loads that are passed on the way from rest, for a layer with friction.

    Returns
    -------
    Simulation
        Equilibrium, impedance and signals.

    Raises
    ------
    SceneError
        When a model cannot hold the scene.
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
    field, _ = loaded_model(sensor, magnetics, tolerance, [*via, wrench])
    layer, _ = mechanical_model(sensor, mechanics, tolerance, [*via, wrench])
    return simulated(sensor, field, at_rest(sensor, layer, wrench, via))


def at_rest(sensor: Sensor, layer: MechanicalModel, wrench: Wrench, via: Sequence[Wrench] = ()) -> Equilibrium:
    """Return where a target rests; what symmetry forbids of its pose is zero without error.

    Of the images of a load that leaves the plane one is solved, as for `calibrate`: half the pad where it is in the
    plane. The state of such a one is not the load's own, and is left out.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    layer : MechanicalModel
        Of the sensor.
    wrench : Wrench
        The load [N, N m].
    via : sequence of Wrench
        Loads that are passed on the way from rest, for a layer with friction.

    Raises
    ------
    SceneError
        When loads are passed that make no difference to the layer.
    SolveFailed
        When the layer has no equilibrium that could be reached.
    """
    if via:
        return _passed(sensor, layer, [*via, wrench])
    found, back = image_at_rest(symmetry_of(sensor), layer, wrench)
    image = with_symmetry(sensor, found)
    return image if found.wrench == wrench else turned(image, wrench, back)


def image_at_rest(symmetry: Symmetry, layer: MechanicalModel, wrench: Wrench) -> tuple[Equilibrium, Array]:
    """Return where a target rests under the image of a load that is solved for it, and the matrix that takes it back.

    Raises
    ------
    SolveFailed
        When the layer has no equilibrium that could be reached; of the load, not of its image.
    """
    solved, back = symmetry.standard(wrench) if wrench.beside else (wrench, np.eye(len(WRENCH)))
    try:
        return layer.equilibrium(solved), back
    except SolveFailed as error:
        if solved == wrench:
            raise
        last = None if error.last is None else turned(error.last, Wrench(*(back @ error.last.wrench.components)), back)
        carried = None
        if error.carried is not None:
            load, off = (each.components for each in error.carried)
            carried = Wrench(*image_of(back, load).tolist()), Wrench(*image_of(np.abs(back), off).tolist())
        message = f"{error} (an image of the load was solved)"
        raise SolveFailed(message, error.report, last, error.half, carried) from error


def _passed(sensor: Sensor, layer: MechanicalModel, loads: Sequence[Wrench]) -> Equilibrium:
    """Return where a target rests at the end of a path of loads, without what the symmetry of all of them forbids."""
    if sensor.elastomer is None or sensor.elastomer.friction == 0.0 or not isinstance(layer, PathModel):
        raise SceneError("via: must be left out without elastomer.friction: the way of the load makes no difference")
    kept = symmetry_of(sensor).projection(*loads)
    found = layer.along(loads)
    return replace(turned(found, found.wrench, kept), state=found.state)


def with_symmetry(sensor: Sensor, found: Equilibrium) -> Equilibrium:
    """Return an equilibrium without what the symmetry of scene and load forbids of its pose, and errors of that."""
    kept = symmetry_of(sensor).projection(found.wrench)
    if np.array_equal(kept, np.eye(len(kept))):
        return found
    return replace(turned(found, found.wrench, kept), state=found.state)


def turned(found: Equilibrium, wrench: Wrench, matrix: Array) -> Equilibrium:
    """Return the image of an equilibrium, without state; errors have no sign."""
    pose, error = image_of(matrix, found.pose.components), image_of(np.abs(matrix), found.error.components)
    shared = found.shared @ matrix.T
    return replace(found, wrench=wrench, pose=Pose.of(pose), error=Pose.of(error), state=np.zeros(0), shared=shared)


def simulated(sensor: Sensor, field: MagneticModel, equilibrium: Equilibrium) -> Simulation:
    """Return what the sensor shows of a target at rest."""
    check_clearance(sensor, equilibrium.pose)
    try:
        shared = equilibrium.shared[:, None]
        reading = read_poses(sensor, field, stacked([equilibrium.pose]), stacked([equilibrium.error]), shared)
    except SolveFailed as error:  # the target rests, the coils are not solved
        raise SolveFailed(str(error), error.report, equilibrium, "magnetics") from error
    found = reading.impedance
    single = {name: getattr(found, name)[0] for name in ("L", "R", "error_L", "error_R")}
    return Simulation(equilibrium, replace(found, **single), signals_at(reading.signals, 0))
