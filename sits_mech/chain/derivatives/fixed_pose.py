"""Differentiate L and R by numbers of the scene while the target stays in place: the direct half of a derivative.

Lengths of coils and plates by the magnetic model's own slopes (magnetics/slopes.py), the frequency likewise. What all
metal conducts needs nothing more where there is but one plate: its currents depend on the product of frequency and
conductivity alone, so that, with R the resistance that the plate brings,

    sigma dL/dsigma = f dL/df,    sigma dR/dsigma = f dR/df - R.

and the tracks' with them, whose copper's coefficient is taken as the plate's, and L0 alike. Several plates of different
metal are differenced. What nothing magnetic has costs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.chain.models import MAGNETICS
from sits_mech.chain.omitted.conductors import is_coaxial
from sits_mech.magnetics.pose_slopes import STEP, KnownImpedance
from sits_mech.magnetics.slopes import by_frequency, by_lengths
from sits_mech.maps.differences import CENTRAL
from sits_mech.quantities import POSE, Array, MagneticModel, Pose
from sits_mech.scene.parameters import TEMPERATURE, Parameter
from sits_mech.scene.sensor import Sensor

_ELECTRIC = ("target", "coils", "conductors", "substrate_radius")
_FREE = 1e3  # times the step of a number, over which inductances in free space are differenced
_CONDUCTIVITY = TEMPERATURE + "conductivity"


class AtFixedPose(NamedTuple):
    """Derivatives of L and R at p fixed poses, with errors, shape (p, c, c, n), and of L0, shape (c, n)."""

    L: Array
    R: Array
    error_L: Array
    error_R: Array
    L0: Array


def at_fixed_poses(
    sensor: Sensor, model: tuple[MagneticModel, str, float], pose: Pose, numbers: Sequence[Parameter],
    known: KnownImpedance | None = None,
) -> AtFixedPose:
    """Return the derivatives of the coils' impedance by n numbers at p fixed poses.

    `model` is the magnetic model with its name and tolerance; `known` as for `by_lengths`.
    """
    (field, name, tolerance), count = model, len(sensor.coils)
    shape = len(pose.components), count, count, len(numbers)
    L, R, error_L, error_R = np.zeros((4, *shape))
    found = AtFixedPose(L, R, error_L, error_R, np.zeros((count, len(numbers))))
    causes = [_cause(number, field) for number in numbers]
    if not any(causes):
        return found
    lengths = {k: numbers[k].name for k, cause in enumerate(causes) if cause == "length"}
    f, rows = sensor.frequency, pose.components
    each = by_lengths(sensor, field, rows, f, tuple(lengths.values()), known)
    for whole, part in zip(found[:4], each, strict=True):
        whole[..., list(lengths)] = part
    for own in lengths:
        if place_of(numbers[own]).coils != numbers[own].scene.coils:
            found.L0[:, own] = _free(numbers[own], name, tolerance)
    own_f = by_frequency(field, rows, f) if {"frequency", "metal"} & {*causes} else []
    for own, cause in enumerate(causes):
        if cause == "frequency":
            found.L[..., own], found.R[..., own] = own_f
            found.L0[:, own] = free_by_frequency(field, f)
        elif cause == "metal":
            grown, R = _growth(numbers[own]), field.impedance(pose, f).R
            found.L[..., own], found.R[..., own] = grown * f * own_f[0], grown * (f * own_f[1] - R)
            found.L0[:, own] = grown * f * free_by_frequency(field, f)
    return found


def _cause(number: Parameter, field: MagneticModel) -> str:
    """Return by what a number changes the impedance at fixed poses: "frequency", "metal", "length", or nothing."""
    if number.name == "frequency":
        return "frequency"
    target = number.scene.target
    alone = not number.scene.conductors and (target is None or target.metal.relative_permeability == 1.0)
    if number.name == _CONDUCTIVITY and alone:
        return "metal"
    off_axis = is_coaxial(field) and ".centre." in number.name
    if off_axis or number.name == "target.load_height":
        return ""
    other = place_of(number)
    return "length" * any(getattr(other, part) != getattr(number.scene, part) for part in _ELECTRIC)


def _free(number: Parameter, name: str, tolerance: float) -> Array:
    """Return the derivative of the coils' inductances in free space, shape (c,)."""
    total, none = np.zeros(len(number.scene.coils)), Pose.of(np.zeros((0, len(POSE))))
    for place in replace(number, step=_FREE * number.step).stencil().places:
        alone = MAGNETICS[name](place.sensor, tolerance).impedance(none, place.sensor.frequency)
        total = total + place.weight * np.diagonal(alone.L0)
    return total


def free_by_frequency(field: MagneticModel, frequency: float) -> Array:
    """Return the derivative of the coils' inductances in free space by the frequency, shape (c,) [H/Hz]."""
    none, ways = Pose.of(np.zeros((0, len(POSE)))), [place for place in CENTRAL.places if place]
    found = {place: np.diagonal(field.impedance(none, frequency * np.exp(STEP * place)).L0) for place in ways}
    return CENTRAL.slope(found | {0: 0.0 * found[1]}, STEP * frequency)


def place_of(number: Parameter) -> Sensor:
    """Return a scene in which a number is slightly different."""
    return number.stencil().places[0].sensor


def _growth(number: Parameter) -> float:
    """Return the relative growth of the target's conductivity with a number; zero without target."""
    target, stencil = number.scene.target, number.stencil()
    if target is None:
        return 0.0
    ends = [place.weight * place.sensor.target.metal.conductivity for place in stencil.places if place.sensor.target]
    return sum(ends, stencil.own * target.metal.conductivity) / target.metal.conductivity
