"""Simulate the sensor under a load: wrench to pose to inductance.

    wrench --(mechanics)--> pose p +- e --(magnetics)--> L(p), R(p) --> signals

Models of several meshes are solved twice: on two rough ones, which show how exact the pose must be for the signals,
then as finely as that takes.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.omitted.mechanical import including
from sits_mech.chain.plans.aimed import Promise, aimed_mechanics
from sits_mech.chain.plans.goal import answer_error, goal_at, missed_by, rest_flags
from sits_mech.chain.propagation import poses_of, read_poses
from sits_mech.chain.rests import aimed_rest
from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.tracks import check_frequency
from sits_mech.mechanics.depth import TouchLoad, to_depth
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.notes import Omission
from sits_mech.quantities import Equilibrium, Impedance, MagneticModel, SolveFailed, Wrench
from sits_mech.readout.signals import Signals
from sits_mech.scene.sensor import Sensor
from sits_mech.status import OK


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
        Requested error of the signals, over the largest change that any of them shows from rest to the load.
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
    >>> result = sm.simulate(sensor, sm.Wrench(F_x=0.2), mechanics="linear", magnetics="planar", tolerance=0.1)
    >>> round(1e6 * result.equilibrium.pose.d_h)  # um
    241
    >>> round(result.signals.known["dL_x"], 2)  # % of L0
    1.45
    """
    check_frequency(sensor.coils, sensor.frequency)  # before the layer is solved
    began = time.process_time()
    wrench, depth = (wrench.wrench, wrench.depth) if isinstance(wrench, TouchLoad) else (wrench, None)
    loads = [*via, wrench]
    layer, choice = aimed_mechanics(sensor, mechanics, tolerance, loads, magnetics)
    own = (layer if depth is None else to_depth(layer, sensor, depth)), choice
    found = aimed_rest(sensor, loads, own, (magnetics, tolerance), symmetry_of(sensor), best=best)
    rest = including(sensor, found.rest, found.left_out)
    shown = simulation_at(sensor, found.field, rest)
    goal, left_out = found.goal or goal_at(sensor, found.field, [rest.pose]), shown.impedance.report.left_out
    error = answer_error(goal, rest, left_out)
    seconds = time.process_time() - began
    promise = None if found.planned is None else Promise(found.planned, seconds, found.reached, error)
    flags = rest_flags(sensor, rest, tolerance, error, left_out)
    if goal is not None and error > tolerance:
        report = missed_by(goal, rest, shown.impedance, sensor.coil_names)
        shown = replace(shown, impedance=replace(shown.impedance, report=report))
    return replace(shown, promise=promise, flags=flags, left_out=found.left_out)


def simulation_at(sensor: Sensor, field: MagneticModel, equilibrium: Equilibrium) -> Simulation:
    """Return the simulation of an equilibrium: impedance and signals at its pose."""
    check_clearance(sensor, equilibrium.pose)
    try:
        reading = read_poses(sensor, field, poses_of([equilibrium]), separate=False)
    except SolveFailed as error:  # the target rests, the coils are not solved
        raise SolveFailed(str(error), error.report, equilibrium, "magnetics") from error
    found = reading.impedance
    single = {name: getattr(found, name)[0] for name in ("L", "R", "error_L", "error_R")}
    signals = Signals(**{name: float(np.asarray(value)[0]) for name, value in reading.signals.known.items()})
    return Simulation(equilibrium, replace(found, **single), signals)
