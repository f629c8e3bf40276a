"""Differentiate what the sensor shows by its sizes, its silicone and its load, through the whole chain.

By a number s of the scene, with the pose p(s) of the target under a load held and the inductance L(p, s),

    dL/ds = sum_k dL/dp_k dp_k/ds + dL/ds at the fixed pose,

the pose's half by the factor that the layer at rest has (mechanics/levels/gradient.py), the other by the magnetic
model's own slopes (magnetics/slopes.py), R alike. A signal is a function of L, of L0 and of where the coils are, and
depends on all three. Errors: those of the pose's derivatives times the slopes, those of differences by lengths, and of
all of it the relative error of L, or R.

A number that the layer does not have costs the mechanics nothing, nor one that no coil and no plate has the magnetics;
a length of a plate takes new eddy-current modes. Images of a load are those of the symmetry that all numbers keep: a
scene whose width grows is no longer a square, one whose thickness grows is. Where target and pad end flush both widths
have two derivatives: given is that of a target that grows over its pad, and of a pad that shrinks under its target.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.derivatives.fixed_pose import AtFixedPose, at_fixed_poses, place_of
from sits_mech.chain.models import Choice, loaded_model
from sits_mech.chain.omitted.conductors import is_coaxial
from sits_mech.chain.plans.aimed import aimed_mechanics
from sits_mech.chain.propagation import signal_weights
from sits_mech.chain.rests import aimed_rest
from sits_mech.chain.simulate import Simulation, simulation_at
from sits_mech.magnetics.pose_slopes import KnownImpedance, pose_slopes
from sits_mech.mechanics.levels.gradient import PoseSlopes
from sits_mech.mechanics.symmetry import Symmetry, image_of_rest, symmetry_of
from sits_mech.mechanics.touch import check_untouched
from sits_mech.quantities import (
    POSE,
    WRENCH,
    Array,
    Equilibrium,
    Impedance,
    MagneticModel,
    MechanicalModel,
    Pose,
    Wrench,
)
from sits_mech.readout.signals import rows_of, signal_changes, signals
from sits_mech.scene.parameters import TEMPERATURE, Parameter, parameter
from sits_mech.scene.sensor import SceneError, Sensor

_NO_LENGTHS = ("conductivity", "relative_permeability", "loss_tangent", "friction")


@runtime_checkable
class SlopedModel(MechanicalModel, Protocol):
    """A mechanical model with derivatives of its poses."""

    def slopes(self, found: Equilibrium, parameters: Sequence[Parameter], *, sideways: bool = False) -> PoseSlopes:
        """Return the derivatives of a pose by its load and by numbers of the scene."""
        ...


@dataclass(frozen=True)
class ByNumbers:
    """Derivatives of what c coils show at p poses: impedances, shape (p, c, c, n); signals by name, (p, n)."""

    L: Array
    error_L: Array
    R: Array
    error_R: Array
    signals: dict[str, Array]
    errors: dict[str, Array]

    def first(self) -> dict[str, Any]:
        """Return what is known at the first pose, by the names of the attributes."""
        return {
            name: {key: each[0] for key, each in found.items()} if isinstance(found, dict) else found[0]
            for name, found in vars(self).items()
        }


@dataclass(frozen=True, kw_only=True)
class Gradient(ByNumbers):
    """Derivatives of what a sensor shows under one load, and estimated absolute errors.

    Attributes
    ----------
    names : tuple of str
        n numbers of the scene.
    simulation : Simulation
        What it shows.
    pose, error_pose : ndarray, shape (6, n)
        By each number [m or rad per its SI unit].
    compliance, error_compliance : ndarray, shape (6, 6)
        Pose by each component of the load [m or rad per N or N m]; NaN of what the mechanical model does not hold.
    L, error_L, R, error_R : ndarray, shape (c, c, n)
        Impedance of the coils [its unit per SI unit].
    signals, errors : dict of str to ndarray, shape (n,)
        Signals of the sensor by their names, and their errors.
    """

    names: tuple[str, ...]
    simulation: Simulation
    pose: Array
    error_pose: Array
    compliance: Array
    error_compliance: Array


class Moved(NamedTuple):
    """Derivatives of p poses by n numbers, and errors, shape (p, 6, n) each [m or rad per SI unit]."""

    pose: Array
    error: Array


def sloped_model(
    sensor: Sensor, mechanics: str, tolerance: float, loads: Sequence[Wrench], magnetics: str = "auto"
) -> tuple[SlopedModel, Choice]:
    """Return the mechanical model for some loads and its choice; raise SceneError for one without derivatives."""
    check_untouched(sensor, "derivatives")
    layer, choice = aimed_mechanics(sensor, mechanics, tolerance, loads, magnetics)
    if not isinstance(layer, SlopedModel):
        raise SceneError(f"mechanics: must be block, planar, axisymmetric or linear for a gradient; got {choice.name}")
    return layer, choice


@checked_arguments
def gradient(
    sensor: Sensor, wrench: Wrench, names: Sequence[str], *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto", sideways: bool = False,
) -> Gradient:
    """Return how what a sensor shows under a load changes with numbers of its scene and with the load.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    wrench : Wrench
    names : sequence of str
        Dotted keys such as "elastomer.thickness", "coils.*.track_width", "elastomer.material.c10", or "modulus".
    tolerance, mechanics, magnetics : as for `simulate`
    sideways : bool
        Whether the compliance by F_y, M_x and M_z is asked for where half a pad is solved.

    Raises
    ------
    SceneError
        When a name is no number of the scene that a derivative is known by, or a model cannot hold the scene.
    Collision, SolveFailed
        As `simulate`.

    Examples
    --------
    >>> sensor, load = sm.load_sensor("biorob2018"), sm.Wrench(F_z=0.5)
    >>> by = sm.gradient(sensor, load, ["modulus"], mechanics="linear", magnetics="planar", tolerance=0.1)
    >>> round(float(by.signals["dL_v"][0]), 3)  # % of L0 for a modulus twice as large, to first order
    0.165
    """
    numbers, moving = scene_numbers(sensor, names)
    _, by_field = loaded_model(sensor, magnetics, tolerance, [wrench])
    symmetry = symmetry_kept(sensor, moving)
    own = sloped_model(sensor, mechanics, tolerance, [wrench], magnetics)
    rest = aimed_rest(sensor, [wrench], own, (magnetics, tolerance), symmetry)
    found, back, field = rest.image, rest.back, rest.field
    by_pose = own[0].slopes(found, moving, sideways=sideways or wrench.out_of_plane != ())
    kept = symmetry.projection(wrench) @ back
    simulation = simulation_at(sensor, field, image_of_rest(found, kept, wrench))
    moved = moved_derivatives(numbers, moving, Moved((kept @ by_pose.pose)[None], (np.abs(kept) @ by_pose.error)[None]))
    one = Pose.of(simulation.equilibrium.pose.components[None])
    direct = at_fixed_poses(sensor, (field, by_field.name, rest.asked), one, numbers)
    shown = simulation.impedance
    single = {name: getattr(shown, name)[None] for name in ("L", "R", "error_L", "error_R")}
    change = shown_change(sensor, field, replace(shown, **single), one, numbers, moved, direct)
    compliance, error = by_pose.compliance, by_pose.error_compliance
    if not np.array_equal(back, np.eye(len(WRENCH))):  # the solved image is another load
        compliance, error = back @ compliance @ back.T, np.abs(back) @ error @ np.abs(back).T
    return Gradient(
        **change.first(), names=tuple(names), simulation=simulation, pose=moved.pose[0], error_pose=moved.error[0],
        compliance=compliance, error_compliance=error,
    )


def scene_numbers(sensor: Sensor, names: Sequence[str]) -> tuple[list[Parameter], list[Parameter]]:
    """Return numbers of a scene by name, and those that move the target; errors as `gradient`."""
    numbers = [_checked(sensor, name) for name in names]
    scenes = [(place_of(number), number.scene) for number in numbers]
    parts = [[(scene.elastomer, scene.target, scene.cover) for scene in pair] for pair in scenes]
    return numbers, [number for number, (other, own) in zip(numbers, parts, strict=True) if other != own]


def symmetry_kept(sensor: Sensor, numbers: Sequence[Parameter]) -> Symmetry:
    """Return the symmetry that a scene keeps when some numbers change: a square whose width grows has two mirrors."""
    changed = (place.sensor for number in numbers for place in number.stencil().places)
    return min(map(symmetry_of, (sensor, *changed)), key=lambda each: len(each.images) + (each.kind == "disc"))


def moved_derivatives(numbers: Sequence[Parameter], moving: Sequence[Parameter], found: Moved) -> Moved:
    """Return derivatives of p poses by n numbers from those that move them, shape (p, 6, m); the others are zero."""
    every = np.zeros((2, *found.pose.shape[:2], len(numbers)))
    every[..., [number in moving for number in numbers]] = np.stack(found)
    return Moved(*every)


def _checked(sensor: Sensor, name: str) -> Parameter:
    """Return a number of a scene; raise SceneError for one without derivatives."""
    if name.startswith(TEMPERATURE):
        return parameter(sensor, name)
    if name.rpartition(".")[2] in _NO_LENGTHS or name.startswith("readout."):
        raise SceneError(f"gradient: {name} has no derivative here; lengths, constants of the silicone, frequency have")
    return parameter(sensor, name)


def shown_change(
    sensor: Sensor, field: MagneticModel, shown: Impedance, pose: Pose, numbers: Sequence[Parameter],
    moved: Moved, direct: AtFixedPose, *, known: KnownImpedance | None = None,
) -> ByNumbers:
    """Join both halves: return derivatives of what the coils show at p poses by n numbers.

    The errors of `shown`, shape (p, c, c), include the poses' errors; slopes that are `known` are quick ones.
    """
    components: Sequence[str] = POSE if pose.out_of_plane or np.any(moved.pose[:, 3:]) else POSE[:3]
    components = ("d_v",) if is_coaxial(field) else components
    quick, known = known is not None, known or KnownImpedance(shown, {})
    _, *each = pose_slopes(sensor, field, pose, sensor.frequency, components, quick=quick, known=known)
    ways = Moved(*(part[:, [POSE.index(name) for name in components]] for part in moved))
    sizes = (shown.L - shown.L0, shown.R)
    share_L, share_R = (_share(*both) for both in zip((shown.error_L, shown.error_R), sizes, strict=True))
    L, error_L = _chained(each[0], ways, direct.L, direct.error_L, share_L)
    R, error_R = _chained(each[1], ways, direct.R, direct.error_R, share_R)
    rows = rows_of(signal_weights(sensor))
    own = [np.einsum("piik->pik", part) for part in (each[0], direct.L, direct.error_L)]
    _, wrong = _chained(rows @ own[0], ways, rows @ own[1], np.abs(rows) @ own[2], share_L)
    there = np.einsum("pii->pi", shown.L), np.diagonal(shown.L0)
    values, errors = _signal_slopes(sensor, there, (np.einsum("piin->pin", L), direct.L0), numbers, wrong)
    return ByNumbers(L, error_L, R, error_R, values, errors)


def _share(error: Array, size: Array) -> Array:
    """Return the relative error of L or R at p poses over the largest change of a coil's own, shape (p,)."""
    own, largest = (np.einsum("pii->pi", np.abs(part)).max(axis=1) for part in (error, size))
    return np.asarray(own / np.maximum(largest, 1e-300))


def _chained(by_pose: Array, moved: Moved, direct: Array, error: Array, share: Array) -> tuple[Array, Array]:
    """Return derivatives by n numbers, and errors, from slopes by k components of p poses, shape (p, ..., k)."""
    terms = [np.einsum("p...k,pkn->p...n", *pair) for pair in (
        (by_pose, moved.pose), (np.abs(by_pose), moved.error), (np.abs(by_pose), np.abs(moved.pose))
    )]
    share = share.reshape(-1, *[1] * (direct.ndim - 1))
    return terms[0] + direct, terms[1] + error + share * (terms[2] + np.abs(direct))


def _signal_slopes(
    sensor: Sensor, there: tuple[Array, Array], change: tuple[Array, Array], numbers: Sequence[Parameter], wrong: Array
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return derivatives of the signals and their errors from those of L, (p, c, n), and L0, (c, n)."""
    (L, L0), (by_L, by_L0), weights = there, change, signal_weights(sensor)
    values, errors = dict[str, list[Array]](), dict[str, list[Array]]()
    for k, number in enumerate(numbers):
        unit = max(float(np.max(np.abs(by_L[..., k]))), 1e-300) / float(np.max(L0))  # signals are linear in L
        total = {name: unit * value for name, value in signal_changes(by_L[..., k] / unit, L0, weights).items()}
        offset, stencil = signals(L, L0, weights, wrong[..., k]).known, number.stencil()
        if any(place.sensor.coils != sensor.coils for place in stencil.places):
            for place in stencil.places:
                shifted = signals(L, L0 + place.amount * by_L0[:, k], signal_weights(place.sensor)).known
                total = {name: value + place.weight * np.asarray(shifted[name]) for name, value in total.items()}
            total = {name: value + stencil.own * np.asarray(offset[name]) for name, value in total.items()}
        for name, value in total.items():
            values.setdefault(name, []).append(value)
            errors.setdefault(name, []).append(np.asarray(offset[f"error_{name}"]))
    stacked = [{name: np.stack(each, axis=-1) for name, each in part.items()} for part in (values, errors)]
    return stacked[0], stacked[1]
