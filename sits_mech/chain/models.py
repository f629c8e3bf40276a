"""Which models are there, by name? The two halves of the chain, and the plan of a request."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from sits_mech.chain.plan import Choice, Plan, choose_magnetics, choose_mechanics, leaving, magnetic_tolerance
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.layer import linear_layer, planar_layer
from sits_mech.mechanics.strip import strip_layer
from sits_mech.quantities import MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.sensor import Sensor
from sits_mech.units import checked_tolerance

MECHANICS: Mapping[str, Callable[[Sensor, float], MechanicalModel]] = {
    "planar": planar_layer,
    "linear": linear_layer,
    "block": block_pad,
    "closed-form": strip_layer,
}
"""The mechanical models by name; each factory takes a sensor and a tolerance."""
MAGNETICS: Mapping[str, Callable[[Sensor, float], MagneticModel]] = {
    "planar": planar_bars,
    "planar-fem": planar_fem,
    "axisymmetric": axisymmetric,
    "sheets": sheets,
}
"""The magnetic models by name; each factory takes a sensor and a tolerance."""


def plan(
    sensor: Sensor, loads: Sequence[Wrench] = (), *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto",
) -> Plan:  # fmt: skip
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
    """
    by_layer = choose_mechanics(sensor, mechanics, tuple(MECHANICS), loads, tolerance) if loads else None
    by_field = choose_magnetics(sensor, magnetics, tuple(MAGNETICS), bool(loads), leaving(loads))
    return Plan.of(sensor, loads, checked_tolerance(tolerance), by_layer, by_field)


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
    """
    choice = choose_mechanics(sensor, name, tuple(MECHANICS), loads, tolerance)
    return MECHANICS[choice.name](sensor, checked_tolerance(tolerance)), choice


def magnetic_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-3, poses: Sequence[Pose] = ()
) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model of a name of `MAGNETICS` or "auto" with the reason; as `mechanical_model`."""
    choice = choose_magnetics(sensor, name, tuple(MAGNETICS), beside=leaving(poses))
    return MAGNETICS[choice.name](sensor, checked_tolerance(tolerance)), choice


def loaded_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-2, loads: Sequence[Wrench] = ()
) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model for poses that loads give to a tolerance, with the reason; as `mechanical_model`."""
    choice = choose_magnetics(sensor, name, tuple(MAGNETICS), True, leaving(loads))
    return MAGNETICS[choice.name](sensor, magnetic_tolerance(choice.name, checked_tolerance(tolerance))), choice
