"""Force in, inductance out: the one place where both physics meet.

    wrench --(mechanics)--> pose p +- e --(magnetics)--> L(p), R(p) --> signals

The models keep linear algebra to one thread (`threads`); nothing here is large enough to gain from a second.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.omissions import keeps_axis, mirrored
from sits_mech.chain.pose_errors import read_poses, signals_at, stacked
from sits_mech.geometry.collision import check_clearance
from sits_mech.quantities import (
    Equilibrium,
    Impedance,
    MagneticModel,
    MechanicalModel,
    Pose,
    SolveFailed,
    Wrench,
)  # fmt: skip
from sits_mech.readout.signals import Signals
from sits_mech.scene.sensor import Sensor


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
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto"
) -> Simulation:
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
    """
    field, _ = loaded_model(sensor, magnetics, tolerance, [wrench])
    layer, _ = mechanical_model(sensor, mechanics, tolerance, [wrench])
    return _simulated(sensor, layer, field, wrench)


def at_rest(sensor: Sensor, layer: MechanicalModel, wrench: Wrench) -> Equilibrium:
    """Return where a target rests; shift and tilt that symmetry forbids are zero without error.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    layer : MechanicalModel
        Of the sensor.
    wrench : Wrench
        The load [N, N m].

    Raises
    ------
    SolveFailed
        When the layer has no equilibrium that could be reached.
    """
    return with_symmetry(sensor, layer.equilibrium(wrench))


def with_symmetry(sensor: Sensor, found: Equilibrium) -> Equilibrium:
    """Return an equilibrium without shift and tilt, and errors of them, where scene and load are symmetric."""
    if not mirrored(sensor) or not keeps_axis(found.wrench):
        return found
    turns = found.wrench.M_z != 0.0
    pose, error = (Pose(0.0, part.d_v, alpha_z=turns * part.alpha_z) for part in (found.pose, found.error))
    return replace(found, pose=pose, error=error)


def _simulated(sensor: Sensor, layer: MechanicalModel, field: MagneticModel, wrench: Wrench) -> Simulation:
    """Return what the sensor shows under a load by given models."""
    equilibrium = at_rest(sensor, layer, wrench)
    check_clearance(sensor, equilibrium.pose)
    try:
        reading = read_poses(sensor, field, stacked([equilibrium.pose]), stacked([equilibrium.error]))
    except SolveFailed as error:  # the target rests, the coils are not solved
        raise SolveFailed(str(error), error.report, equilibrium, "magnetics") from error
    found = reading.impedance
    single = {name: getattr(found, name)[0] for name in ("L", "R", "error_L", "error_R")}
    return Simulation(equilibrium, replace(found, **single), signals_at(reading.signals, 0))
