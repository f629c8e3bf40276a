"""Place the plates around the coils; check before a solve that a pose leaves the target clear of all else.

A box |xi| <= a, |eta| <= b, 0 <= zeta <= t around the target, in its own frame, is turned by R about the centre of its
bottom face, which stands at height d_v; so its lowest corner is at

    d_v - a |R_zx| - b |R_zy| + min(t R_zz, 0),        of a disc of radius a    d_v - a |(R_zx, R_zy)| + min(t R_zz, 0).

The coil plane is z = 0. Two rectangular plates are apart exactly where a slab fits between them (`scene.parts`). If
none does and one is round or an outline, both are taken as convex bodies n_i . x <= c_i, a disc with 128 sides: the
largest ball inside both, by linear programming, has a radius below zero where they are apart. Notches and holes count
as metal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull

from sits_mech.description import Refusal
from sits_mech.geometry.outline import target_outline
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, Array, Integers, Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.apart import from_windings
from sits_mech.scene.parts.metal import BoxedPart, separation
from sits_mech.scene.sensor import Conductor, Sensor, Target
from sits_mech.units import millimetres as mm

_SIDES = 128  # of what stands for a disc
_SOFT = 0.1  # of the clearance: the rise of a side below which it counts in square
_TIMES = 8  # of Newton's method, from above: monotone, as the function is convex
_TOUCH = 1e-9  # of their size: parts closer than this touch, whatever rounding says
_NEAREST = 1e-5  # of the target's size: the smallest gap to the coils


class Collision(ValueError):
    """A pose in which the target touches or passes the coil plane or a fixed plate."""


def clearance(sensor: Sensor, pose: Pose) -> Array:
    """Return the height of the target's lowest point above the coil plane [m], in the shape of the pose."""
    if sensor.target is None:
        return np.full(pose.components.shape[:-1], np.inf)
    down = rotation_matrix(pose.rotation)[..., 2, :]
    half = np.array(sensor.target.extent) / 2.0
    sides = np.abs(down[..., :2]) * half
    side = np.hypot(*np.moveaxis(sides, -1, 0)) if sensor.target.is_round else sides.sum(axis=-1)
    return np.asarray(pose.centre[..., 2] - side + np.minimum(sensor.target.thickness * down[..., 2], 0.0))


def smooth_height(middle: Array, sides: Array) -> Array:
    """Return the height of a tilted plate's lowest point, or up to a quarter more, without a kink where it is level.

    ``g = z - sum over sides of (sqrt(s^2 + e^2) - e)``, e = `_SOFT` g, by Newton's method; `middle` (p,) z of the lower
    face's centre, less what the thickness takes of it, `sides` (p, k) s, how far half of each side falls, either sign
    [m].
    """
    gap, square = middle.copy(), sides**2
    for _ in range(_TIMES if square.any() else 0):
        soft = _SOFT * gap[:, None]
        side = np.sqrt(square + soft**2)
        miss = gap - middle + (side - soft).sum(axis=1)
        gap = gap - miss / (1.0 + _SOFT * (soft / side - 1.0).sum(axis=1))
    return gap


def room(sensor: Sensor, pose: Pose) -> Array:
    """Return how far the target is at least from the coil plane and the fixed plates [m], in the shape of the pose."""
    gap = clearance(sensor, pose)
    for k in range(len(sensor.conductors) if sensor.target is not None else 0):
        gap = np.minimum(gap, gap_to_plate(sensor, sensor.target, pose, k).reshape(gap.shape))  # type: ignore[arg-type]
    return gap


def check_clearance(sensor: Sensor, pose: Pose) -> None:
    """Raise Collision if any pose brings the target to the coil plane or a fixed plate, ValueError if it is no number.

    A gap of 1e-5 of the target's size counts as none: roughness is larger, and no division as fine.
    """
    gap = clearance(sensor, pose)
    least = 0.0 if sensor.target is None else _NEAREST * max(sensor.target.extent)
    finite = np.isfinite(pose.components).all(axis=-1).ravel()
    if not finite.all():
        raise ValueError(f"pose: must be finite numbers; got {_words(pose, int(np.argmin(finite)))}")
    if not np.all(gap > least):
        index = int(np.argmin(gap))
        raise Collision(
            f"pose: the target must stay {1e3 * least:.3g} mm above the coil plane z = 0, its lowest point is at "
            f"{gap.ravel()[index] * 1e3:.4g} mm for {_words(pose, index)}"
        )
    if sensor.target is None:
        return
    for k, part in enumerate(sensor.conductors):
        size, most = max(*part.extent, *sensor.target.extent), _reach(part) + _reach(sensor.target)
        if np.all(np.linalg.norm(pose.centre.reshape(-1, 3) - part.centre, axis=1) > most):
            continue
        gap = gap_to_plate(sensor, sensor.target, pose, k).ravel()
        if np.all(gap > _TOUCH * size):
            continue
        index = int(np.argmin(gap))
        how = f"overlaps it by {-gap[index] * 1e3:.3g} mm" if gap[index] < -_TOUCH * size else "touches it"
        bottom, top = (1e3 * z for z in part.span)
        raise Collision(
            f"pose: the target must stay clear of conductors.{part.name}, which reaches from z = {bottom:.4g} mm to "
            f"{top:.4g} mm; it {how} for {_words(pose, index)}"
        )


def _reach(plate: Target | Conductor) -> float:
    """Return how far a plate reaches from the middle of any of its faces at most [m]."""
    return math.hypot(*plate.extent, plate.thickness)


def ground_notes(sensor: Sensor, pose: Pose) -> tuple[Note, ...]:
    """Note that a pose has the target's rim below the ground that the layer stands on: a wide target, tilted."""
    if sensor.elastomer is None or sensor.target is None:
        return ()
    gap = float(clearance(sensor, pose)) - sensor.elastomer.standoff
    if gap > -_TOUCH * max(sensor.target.extent):
        return ()
    return (Note.of(NoteKind.BELOW_GROUND, depth=-gap),)


def _words(pose: Pose, index: int) -> str:
    """Say which of some poses, counted flat, it is: the plane's components and those beside it that are not zero."""
    values = pose.components.reshape(-1, len(POSE))[index]
    shown = [(name, float(value)) for k, (name, value) in enumerate(zip(POSE, values, strict=True)) if k < 3 or value]
    return ", ".join(
        f"{name} = {1e3 * value:.4g} mm" if name.startswith("d") else f"{name} = {np.degrees(value):.4g} deg"
        for name, value in shown
    )


def gap_to_plate(sensor: Sensor, target: Target, pose: Pose, number: int) -> Array:
    """Return the distance of the target from a fixed plate at least [m], one a pose; negative where they overlap."""
    turns, places = rotation_matrix(pose.rotation).reshape(-1, 3, 3), pose.centre.reshape(-1, 3)
    half = np.array([*target.extent, target.thickness]) / 2.0
    middle = places + turns[:, :, 2] * half[2]
    plate, part = fixed_solids(sensor)[1][number], sensor.conductors[number]
    gap = separation(BoxedPart("target", half, turns, middle), plate)
    if target.shape == part.shape == "rectangle":
        return gap
    for k in np.flatnonzero(gap <= _TOUCH * max(*part.extent, *target.extent)):
        gap[k] = -_depth(target, part, turns[k], middle[k])
    return gap


def _depth(target: Target, part: Conductor, turn: Array, middle: Array) -> float:
    """Return the radius of the largest ball inside both plates; below zero where they are apart [m]."""
    from scipy.optimize import linprog

    own, other = _half_spaces(target), _half_spaces(part)
    fixed, size = other[:, :3] @ part.turn.T, max(*part.extent, *target.extent)
    normals = np.vstack([own[:, :3] @ turn.T, fixed])
    offsets = np.concatenate([own[:, 3], other[:, 3] + fixed @ (part.centre - middle)]) / size
    rows = np.column_stack([normals, np.ones(len(normals))])
    found = linprog([0.0, 0.0, 0.0, -1.0], A_ub=rows, b_ub=offsets, bounds=[(None, None)] * 4)
    return size * float(np.asarray(found.x)[3])


def _half_spaces(plate: Target | Conductor) -> Array:
    """Return n and c of a plate about its middle, shape (m, 4)."""
    (a, b), points = np.array(plate.extent) / 2.0, getattr(plate, "points", None)
    if points is not None:
        sides = ConvexHull(np.array(points)).equations * (1.0, 1.0, -1.0)
    elif plate.diameter is not None:
        angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
        sides = np.column_stack([np.cos(angle), np.sin(angle), np.full(_SIDES, a)])
    else:
        sides = np.array([[1.0, 0.0, a], [-1.0, 0.0, a], [0.0, 1.0, b], [0.0, -1.0, b]])
    sides = np.column_stack([sides[:, :2], np.zeros(len(sides)), sides[:, 2]])
    faces = [[0.0, 0.0, side, plate.thickness / 2.0] for side in (1.0, -1.0)]
    return np.vstack([sides, faces])


def fixed_solids(sensor: Sensor) -> tuple[tuple[BoxedPart, ...], tuple[BoxedPart, ...]]:
    """Return the boxes around the coils, or their layers, and those around the fixed plates."""
    coils = tuple(
        BoxedPart.level(coil.name, (*coil.extent, high - low), (*coil.centre, (low + high) / 2))
        for coil in sensor.coils for low, high in coil.spans
    )
    return coils, tuple(part.box for part in sensor.conductors)


def smallest_gap(solid: BoxedPart, others: Sequence[BoxedPart]) -> float:
    """Return the smallest separation from other boxes over all poses [m]; infinite without others."""
    return min((float(separation(solid, other).min()) for other in others), default=np.inf)


CLEARANCE = 1.8e-3
"""A common clearance of targets over coils: that of the preparation which serves it is not the poses' [m]."""
_CLOSE = 0.06  # of its narrower side: detail that a fixed plate nearer than that brings it is left out
_EASY = 0.125  # of a fixed plate's narrower side: a distance that few polynomials carry


@dataclass(frozen=True)
class PlacedPlate:
    """A plate in its p places; p = 1 if it does not move.

    `gap` has no kinks where a plate is level: of the target from fixed plates and the coil plane, of a fixed plate from
    other plates, at most `anchor`. `anchor` does not depend on the pose: of a fixed plate the distance from the nearest
    other one, but what its polynomials carry easily; of the target `CLEARANCE`.
    """

    title: str  # the part of the scene that it is; empty for the target
    plate: Target
    turns: Array  # (p, 3, 3) rotations
    places: Array  # (p, 3) centre of the bottom face [m]
    gap: Array  # (p,) from what it sees through polynomials [m]
    anchor: float  # [m]
    middle: tuple[float, float, float]  # x, y, z; of the target at rest, seen from above [m]
    windings: float = 0.0  # distance of a fixed plate from the coils; 0 for the target [m]
    susceptibility: complex = 0.0  # [-]

    def among(self, some: Integers) -> PlacedPlate:
        """Return it in some of its places; itself, where it does not move."""
        if len(self.places) == 1 < len(self.gap) or len(some) == len(self.gap):
            return self
        return replace(self, turns=self.turns[some], places=self.places[some], gap=self.gap[some])


def placed_plates(sensor: Sensor, turns: Array, places: Array) -> list[PlacedPlate]:
    """Return the target, if any, at its poses and the fixed plates; Collision if it touches one or the coil plane."""
    coils, plates = fixed_solids(sensor)
    parts: list[PlacedPlate] = []
    moving: list[BoxedPart] = []
    if sensor.target is not None and places.size:
        t = sensor.target.thickness
        half = np.array([*np.abs(target_outline(sensor.target).rim).max(0), t / 2])
        _check_above(sensor.target, turns, places)
        moving = [BoxedPart("target", half, turns, places + turns[:, :, 2] * t / 2)]
        sides = turns[:, 2, :2] * half[:2]
        sides = np.hypot(*sides.T)[:, None] if sensor.target.is_round else sides
        gap = smooth_height(places[:, 2] + np.minimum(turns[:, 2, 2] * t, 0.0), sides)
        for plate in plates:
            apart = separation(moving[0], plate)
            if apart.min() <= 0.0:
                raise Collision(
                    f"pose: the boxes around the target and {plate.name} must be clear of each other for 'sheets', "
                    f"they overlap by {-apart.min() * 1e3:.3g} mm"
                )
            gap = np.minimum(gap, apart)
        found = "", sensor.target, turns, places, gap, CLEARANCE, (0.0, 0.0, 0.0)
        parts = [PlacedPlate(*found, susceptibility=sensor.target.metal.susceptibility)]
    for k, (part, solid) in enumerate(zip(sensor.conductors, plates, strict=True)):
        lying, axes = lying_plate(part)
        drawn = part.loops and not part.is_turned
        windings = from_windings(part, sensor.coils) if drawn else smallest_gap(solid, coils)
        spacing = max(smallest_gap(solid, (*plates[:k], *plates[k + 1 :])), _CLOSE * min(lying.extent))
        anchor = min(spacing, max(windings, _EASY * min(lying.extent)))
        gap = np.minimum(anchor, separation(moving[0], solid)) if moving else np.array([anchor])
        turn = solid.turns[:, :, axes]
        fixed = solid.name, lying, turn, solid.places - turn[:, :, 2] * lying.thickness / 2
        parts.append(PlacedPlate(*fixed, gap, anchor, part.centre, windings, part.metal.susceptibility))
    return parts


@lru_cache(maxsize=64)
def as_plate(part: Conductor) -> Target:
    """Return a fixed plate as a target of the same shape and metal."""
    return Target(
        conductivity=part.metal.conductivity, relative_permeability=part.metal.relative_permeability, shape=part.shape,
        width=part.width, length=part.length, diameter=part.diameter, inner_diameter=part.inner_diameter,
        points=part.points, holes=part.holes, thickness=part.thickness, load_height=0.0,
    )


def lying_plate(part: Conductor) -> tuple[Target, Integers]:
    """Return a fixed plate with the thinnest side of a block as its thickness, and which of its axes are then x, y, z.

    A wall that is written as a tall block would otherwise be divided into skin depths along it and in as many sheets.
    """
    plate, sizes = as_plate(part), np.array([*part.extent, part.thickness])
    if part.shape != "rectangle" or sizes[2] == sizes.min():
        return plate, np.arange(3)
    axes = np.roll(np.arange(3), 2 - int(np.argmin(sizes)))
    width, length, thickness = sizes[axes].tolist()
    return plate.model_copy(update={"width": width, "length": length, "thickness": thickness}), axes


def overlapping(sensor: Sensor) -> Refusal | None:
    """Return which fixed plate touches a coil or another plate; None if none does.

    A level ring or outline may lie around a coil, in its plane, but not around another plate.
    """
    coils, plates = fixed_solids(sensor)
    for k, plate in enumerate(plates):
        part = sensor.conductors[k]
        for other in (*(() if part.loops and not part.is_turned else coils), *plates[:k]):
            if separation(plate, other).min() <= 0.0:
                must = "have boxes, sides along the part's axes, that do not touch for sheets: move one"
                return Refusal(f"{plate.name}, {other.name}", must, "boxes that do")
    return None


def _check_above(target: Target, turns: Array, places: Array) -> None:
    """Raise Collision where the plate's lowest point is not above the coil plane."""
    rim = target_outline(target).rim
    low = places[:, 2] + (turns[:, 2, :2] @ rim.T).min(1) + np.minimum(turns[:, 2, 2] * target.thickness, 0.0)
    if not np.all(low > 0.0):
        worst = float(np.min(np.where(np.isnan(low), -np.inf, low)))
        raise Collision(f"pose: the target must stay above the coil plane z = 0, its lowest point is at {mm(worst)}")
