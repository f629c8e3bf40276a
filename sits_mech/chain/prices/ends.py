"""What is it worth that a section stands for coils, plates and pads that have ends along y? A coarse answer in space.

Coils, plates. A section's L [H/m] says something of a sensor relative to its inductances without target alone. With
s_cd = sqrt(L0_cc L0_dd) of each model,

    e_L,cd = |(L_cd/s_cd)_space - (L_cd/s_cd)_section| s_cd,section,    e_R of R/s alike,

at the same pose and frequency, is what the section leaves out of each entry: the ends of tracks and plates, the
roundness of coils and targets, the pitch of spirals. The space's comes of `sheets` on its coarsest rung, within a few
percent of the change in some tenths of a second; its own error is added. Of a target longer or
wider than the coils see, as much counts as lies under them and a coil's diameter and two gaps beyond. Of many poses
some are asked, and the others have the share of the next one.

Pads. Plane strain makes a pad too stiff by the factors of `mechanics.finite_length` in shear, compression and tilt: it
leaves (factor - 1) times a displacement out.

Range: no size is known where `sheets` does not hold the scene (permeable targets, curved substrates) or takes long
(among other metal), or no factor is (pillars, outlines, meshes of the user's). Neglected: finite strain in the factors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.cases import DONE, Row
from sits_mech.geometry.collision import clearance
from sits_mech.magnetics.answer import largest
from sits_mech.magnetics.sheets import not_representable, sheets
from sits_mech.mechanics.closed_form import finite_strain_model
from sits_mech.mechanics.finite_length import FiniteLength, finite_length_factor
from sits_mech.mechanics.loads import ERRORS, shared_of, with_shared
from sits_mech.quantities import (
    POSE,
    Array,
    Equilibrium,
    Impedance,
    Integers,
    MagneticModel,
    Pose,
    SolveFailed,
    Wrench,
)
from sits_mech.scene.sensor import Sensor, Target

ROUGH = 0.1  # tolerance of the answers in space
_MISSED = 0.02  # of space's change, what its coarsest rung was seen to miss beyond its own estimate
_POSES = 32  # that are asked of a batch
_BEYOND = 1.0, 2.0  # coil diameters, gaps


@dataclass(frozen=True)
class Ends:
    """What a section leaves out of inductances and resistances.

    Attributes
    ----------
    L, R : ndarray, shape (..., n, n)
        What space has more than the section, with its sign [unit_L of the section and its resistance].
    error_L, error_R : ndarray
        How far that may be off.
    size : float
        The largest of coils' own L, its error included, over the section's largest change of inductance at the pose.
    """

    L: Array
    R: Array
    error_L: Array
    error_R: Array
    size: float


def ends_of_plates(sensor: Sensor, found: Impedance, pose: Pose) -> Ends | None:
    """Return what the answer of a section leaves out; None where space has no model of the scene, or a slow one.

    Parameters
    ----------
    sensor : Sensor
        With a target.
    found : Impedance
        Per metre of depth, at one pose or many.
    pose : Pose
        Those of `found`.
    """
    if found.unit_L != "H/m" or sensor.target is None or sensor.conductors or not_representable(sensor) is not None:
        return None
    rows, n = Pose.of(pose.components.reshape(-1, len(POSE))), len(sensor.coils)
    L, R = (values.reshape(-1, n, n) for values in (found.L, found.R))
    chosen = _chosen(rows.components)
    some = Pose.of(rows.components[chosen])
    twin = _under_coils(sensor, some)
    try:
        space = sheets(twin, ROUGH).impedance(some, found.frequency)
    except (SolveFailed, ValueError):
        return None
    scale, other = (np.sqrt(np.outer(np.diag(L0), np.diag(L0))) for L0 in (found.L0, space.L0))
    change = np.abs(L - found.L0).max(axis=(1, 2))
    share = np.where(change > 0.0, change, 1.0)[chosen, None, None]
    more = [
        (space.L / other * scale - L[chosen]) / share, (space.R / other * scale - R[chosen]) / share,
        (space.error_L + _MISSED * largest(space.L - space.L0)) / other * scale / share,
        (space.error_R + _MISSED * largest(space.R)) / other * scale / share,
    ]  # fmt: skip
    next_one = _next(rows.components, chosen)
    each = [(values[next_one] * change[:, None, None]).reshape(found.L.shape) for values in more]
    size = float(np.diagonal(np.abs(more[0]) + more[2], axis1=1, axis2=2).max(initial=0.0))
    return Ends(each[0], each[1], each[2], each[3], size)


def _chosen(poses: Array) -> Integers:
    """Return which of many poses are asked: all of a few; else the outermost ones and some at equal steps."""
    if len(poses) <= _POSES:
        return np.arange(len(poses))
    outer = [*poses.argmin(axis=0), *poses.argmax(axis=0)]
    return np.unique([*outer, *np.linspace(0, len(poses) - 1, _POSES - 2 * len(POSE)).astype(int)])


def _next(poses: Array, chosen: Integers) -> Integers:
    """Return for every pose which of the chosen ones is next to it, over the range of each component."""
    span = np.ptp(poses, axis=0)
    places = poses / np.where(span > 0.0, span, 1.0)
    return np.array([int(np.argmin(((places[chosen] - place) ** 2).sum(axis=1))) for place in places], dtype=np.int64)


def _under_coils(sensor: Sensor, pose: Pose) -> Sensor:
    """Return a scene whose rectangular target ends where the coils no longer see it."""
    target = sensor.target
    if target is None or target.shape != "rectangle":
        return sensor
    beyond = _BEYOND[0] * max(coil.outer_diameter for coil in sensor.coils)
    beyond += _BEYOND[1] * float(np.max(np.maximum(clearance(sensor, pose), pose.d_v)))
    sides = []
    for axis, side in enumerate(target.extent):
        away = [abs(coil.centre[axis] - place) for coil in sensor.coils for place in pose.centre[:, axis]]
        half = max(away) + 0.5 * max(coil.outer_diameter for coil in sensor.coils) + beyond
        sides.append(min(side, 2.0 * half))
    if tuple(sides) == target.extent:
        return sensor
    cut = Target.model_validate(target.model_dump() | {"width": sides[0], "length": sides[1]})
    return sensor.model_copy(update={"target": cut})


@dataclass(frozen=True)
class InSection:
    """A model in section whose errors hold what it leaves out of a scene with ends.

    Attributes
    ----------
    model : MagneticModel
        Per metre of depth.
    sensor : Sensor
    """

    model: MagneticModel
    sensor: Sensor

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return what the model does; where the size is not known, the report says so."""
        found = self.model.impedance(pose, frequency)
        if found.unit_L != "H/m":
            return found
        ends = ends_of_plates(self.sensor, found, pose)
        if ends is None:
            note = "ends along y: in no error, not estimated for this scene"
            return replace(found, report=replace(found.report, notes=(*found.report.notes, note)))
        note = f"a section stands for coils and plates with ends: {ends.size:.2g} of the change, in the error; ask for"
        report = replace(
            found.report, estimated_error=found.report.estimated_error + ends.size,
            notes=(*found.report.notes, f"{note} sheets"),
        )  # fmt: skip
        known = np.zeros((0, *found.L.shape)) if found.shared_L is None else found.shared_L
        return replace(
            found, error_L=found.error_L + np.abs(ends.L) + ends.error_L, report=report,
            error_R=found.error_R + np.abs(ends.R) + ends.error_R, shared_L=np.concatenate([known, ends.L[None]]),
        )  # fmt: skip


def ends_of_pad(sensor: Sensor) -> FiniteLength | None:
    """Return by how much plane strain is too stiff for a pad; None where no planar layer stands for it at all."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None or target.shape == "outline":
        return None
    if elastomer.mesh is not None or elastomer.kind == "pillars":
        return None
    return finite_length_factor(sensor)


def in_plane_strain(sensor: Sensor, model: str) -> bool:
    """Say whether a mechanical model, by its name, takes a pad in plane strain."""
    target, elastomer = sensor.target, sensor.elastomer
    flat = elastomer is not None and elastomer.mesh is None and finite_strain_model(sensor) == "planar"
    flat |= target is not None and target.shape == "outline"
    return model in ("planar", "closed-form") or (model == "linear" and flat)


def whole_factors(factor: FiniteLength) -> Array:
    """Return how much farther a pad moves its target than plane strain says: d_h, d_v and alpha, shape (3,) [-]."""
    more = np.array([max(factor.shear, factor.tilt), factor.compression, factor.tilt]) - 1.0
    return np.asarray(np.maximum(more, 0.0) + factor.error)


def softer(sensor: Sensor, poses: Array) -> Array:
    """Return by how much a pad moves its target farther than plane strain says, with the sign.

    Parameters
    ----------
    sensor : Sensor
    poses : ndarray, shape (..., 6)
        In plane strain, in the order of `POSE` [m, rad].
    """
    factor, elastomer = ends_of_pad(sensor), sensor.elastomer
    if factor is None or elastomer is None:
        return np.zeros_like(poses)
    moved = poses - np.array([0.0, elastomer.standoff + elastomer.thickness, 0.0, 0.0, 0.0, 0.0])
    return np.asarray(moved * np.pad(whole_factors(factor), (0, len(POSE) - 3)))


def held(sensor: Sensor, model: str, found: Equilibrium, *, by_name: bool) -> Equilibrium:
    """Return an equilibrium whose error holds what plane strain leaves out, where no user asked for that by name.

    It is shared by all loads.

    Parameters
    ----------
    sensor : Sensor
    model : str
        Of the mechanics.
    found : Equilibrium
        By it.
    by_name : bool
        Whether it was asked for.
    """
    if by_name or not in_plane_strain(sensor, model):
        return found
    more = softer(sensor, found.pose.components)
    size = float(np.max(whole_factors(factor))) if (factor := ends_of_pad(sensor)) is not None else 0.0
    note = f"plane strain stands for a pad with ends: {size:.2g} of the displacement, in the error; ask for block"
    report = replace(
        found.report, estimated_error=found.report.estimated_error + size, notes=(*found.report.notes, note)
    )
    error, shared = found.error.components + np.abs(more), np.vstack([found.shared, more])
    return replace(found, error=Pose.of(error), report=report, shared=shared)


def rows_held(sensor: Sensor, model: str, rows: Mapping[Wrench, Row], *, by_name: bool) -> dict[Wrench, Row]:
    """Return rows of a grid of loads as `held` returns equilibria."""
    if by_name or not in_plane_strain(sensor, model):
        return dict(rows)
    found = {}
    for load, row in rows.items():
        found[load] = row
        if row["status"] == DONE:
            more = softer(sensor, np.array([row[name] for name in POSE]))
            errors = np.array([row[name] for name in ERRORS]) + np.abs(more)
            found[load] = with_shared(row, np.vstack([shared_of(row), more]))
            found[load] |= dict(zip(ERRORS, errors.tolist(), strict=True))
    return found


def pitch_of_spirals(sensor: Sensor, found: Impedance, pose: Pose) -> float:
    """Return what rings leave out of spirals, over the largest change of inductance at the same pose [-].

    From the difference of both in space at the coarsest rung, whose errors they share; NaN where space has no model.

    Parameters
    ----------
    sensor, found, pose
        As for `ends_of_plates`, in henry.
    """
    if not_representable(sensor) is not None or sensor.target is None:
        return float("nan")
    rows = pose.components.reshape(-1, len(POSE))
    some = Pose.of(rows[_chosen(rows)])
    try:
        each = [sheets(sensor, ROUGH, windings=kind).impedance(some, found.frequency) for kind in ("rings", "spiral")]
    except (SolveFailed, ValueError):
        return float("nan")
    rings, spirals = (np.diagonal(one.L, axis1=1, axis2=2) / np.diag(one.L0) - 1.0 for one in each)
    return float((np.abs(spirals - rings).max(axis=1) / np.abs(rings).max(axis=1)).max())
