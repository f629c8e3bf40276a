"""Scenes and poses that keep to one coil's axis, and the discs in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.description import Refusal
from sits_mech.magnetics.axis.lines import CoaxialDisc
from sits_mech.quantities import Array, Pose
from sits_mech.scene.sensor import Coil, Conductor, Sensor, Target, metal_parts
from sits_mech.units import millimetres as mm

_APART = 1e-9  # off the axis by less than this is coaxial [m]


def on_axis(coil: Coil, pose: Pose) -> bool:
    """Tell whether poses leave a disc on a coil's axis, turned about it at most."""
    tilted = np.any(pose.rotation[..., :2] != 0.0)
    return not tilted and bool(np.all(_off_axis(coil, pose) <= _APART))


def _off_axis(coil: Coil, pose: Pose) -> Array:
    """Return the distance of the disc's middle from the coil's axis [m]."""
    return np.asarray(np.linalg.norm(pose.centre[..., :2] - coil.centre, axis=-1))


def check_coaxial(sensor: Sensor, pose: Pose) -> None:
    """Refuse poses off the axis of the scene's one coil."""
    coil = sensor.coils[0]
    if sensor.target is None or on_axis(coil, pose):
        return
    off, tilt = float(_off_axis(coil, pose).max()), float(np.degrees(np.abs(pose.rotation[..., :2]).max()))
    if off > _APART:
        raise ValueError(f"pose: the disc must be on the axis of coil {coil.name}, it is {off * 1e3:.4g} mm off")
    raise ValueError(f"pose: alpha and alpha_x must be 0 on a coil's axis, got {tilt:.4g} deg")


def not_coaxial(sensor: Sensor, model: str, shapes: tuple[str, ...] = ("disc",)) -> Refusal | None:
    """Return why a `model` of one axis does not hold a scene; None where it does, or of round coils alone.

    `shapes` are those of plates that it holds.
    """
    coil, plates = sensor.coils[0], metal_parts(sensor)
    if sensor.substrate_radius is not None:
        return Refusal("substrate_radius", f"be left out for {model}, of flat coils", mm(sensor.substrate_radius))
    if plates and len(sensor.coils) != 1:
        return Refusal("coils", f"be one over coaxial discs for {model}", f"{len(sensor.coils)}")
    if bent := next((each for each in sensor.coils if not each.is_round), None):
        return Refusal(f"coils.{bent.name}.shape", f"be circle for {model}", bent.shape)
    if drawn := next(((name, part) for name, part in plates if part.shape not in shapes), None):
        return Refusal(f"{drawn[0]}.shape", f"be {' or '.join(shapes)} for {model}", drawn[1].shape)
    return _misplaced(sensor.conductors, coil, model)


def _misplaced(parts: Sequence[Conductor], coil: Coil, model: str) -> Refusal | None:
    """Return which fixed plate is tilted or off a coil's axis; None if none is."""
    for part in parts:
        if tilted := next((key for key in ("alpha", "alpha_x") if getattr(part, key)), None):
            got = f"{np.degrees(getattr(part, tilted)):.4g} deg"
            return Refusal(f"conductors.{part.name}.{tilted}", f"be 0 for {model}", got)
        off = float(np.hypot(part.centre[0] - coil.centre[0], part.centre[1] - coil.centre[1]))
        if off > _APART:
            must = f"be on the axis of coil {coil.name} for {model}"
            return Refusal(f"conductors.{part.name}.centre", must, f"{off * 1e3:.4g} mm off")
    return None


def coaxial_discs(sensor: Sensor, d_v: float) -> tuple[CoaxialDisc, ...]:
    """Return the discs and rings of a scene, the target first, its lower face at d_v [m]."""
    discs = [] if sensor.target is None else [_disc(sensor.target, d_v)]
    return (*discs, *(_disc(part, part.centre[2] - part.thickness / 2) for part in sensor.conductors))


def _disc(part: Target | Conductor, bottom: float) -> CoaxialDisc:
    """Return a plate as a disc or a ring, its lower face at a height [m]."""
    outer, inner, metal = (part.diameter or 0.0) / 2, part.hole / 2, part.metal
    return CoaxialDisc(outer, bottom, bottom + part.thickness, metal.conductivity, 1.0 + metal.susceptibility, inner)
