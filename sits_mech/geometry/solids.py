"""Place the plates in the space around the coils and find how far each is from all else, by boxes around them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from sits_mech.geometry.collision import Collision, Solid, fixed_solids, nearest, separation, smooth_height
from sits_mech.geometry.outline import Outline, target_outline
from sits_mech.quantities import Array, Integers
from sits_mech.scene.apart import from_windings
from sits_mech.scene.sensor import Conductor, Sensor, Target

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

    title: str  # what to put before a note on it; empty for the target
    plate: Target
    outline: Outline | None  # instead of the scene's
    turns: Array  # (p, 3, 3) rotations
    places: Array  # (p, 3) centre of the bottom face [m]
    gap: Array  # (p,) from what it sees through polynomials [m]
    anchor: float  # [m]
    middle: tuple[float, float, float]  # x, y, z; of the target at rest, seen from above [m]
    windings: float = 0.0  # distance of a fixed plate from the coils; 0 for the target [m]
    susceptibility: complex = 0.0  # of a fixed plate [-]

    def among(self, some: Integers) -> PlacedPlate:
        """Return it in some of its places; itself, where it does not move."""
        if len(self.places) == 1 < len(self.gap) or len(some) == len(self.gap):
            return self
        return replace(self, turns=self.turns[some], places=self.places[some], gap=self.gap[some])


def placed_plates(sensor: Sensor, outline: Outline | None, turns: Array, places: Array) -> list[PlacedPlate]:
    """Return the target, if any, at its poses and the fixed plates; Collision if it touches one or the coil plane."""
    coils, plates = fixed_solids(sensor)
    parts: list[PlacedPlate] = []
    moving: list[Solid] = []
    if sensor.target is not None and places.size:
        t = sensor.target.thickness
        half = np.array([*np.abs(target_outline(sensor.target, outline).rim).max(0), t / 2])
        _check_above(sensor.target, outline, turns, places)
        moving = [Solid("target", half, turns, places + turns[:, :, 2] * t / 2)]
        sides = turns[:, 2, :2] * half[:2]
        sides = np.hypot(*sides.T)[:, None] if sensor.target.shape == "disc" else sides
        gap = smooth_height(places[:, 2] + np.minimum(turns[:, 2, 2] * t, 0.0), sides)
        for plate in plates:
            apart = separation(moving[0], plate)
            if apart.min() <= 0.0:
                raise Collision(
                    f"pose: the boxes around the target and {plate.name} must be clear of each other for 'sheets', "
                    f"they overlap by {-apart.min() * 1e3:.3g} mm"
                )
            gap = np.minimum(gap, apart)
        parts = [PlacedPlate("", sensor.target, outline, turns, places, gap, CLEARANCE, (0.0, 0.0, 0.0))]
    for k, (part, solid) in enumerate(zip(sensor.conductors, plates, strict=True)):
        windings = nearest(solid, coils) if part.shape != "outline" else from_windings(part, sensor.coils)
        beside = max(nearest(solid, (*plates[:k], *plates[k + 1 :])), _CLOSE * min(part.extent))
        anchor = min(beside, max(windings, _EASY * min(part.extent)))
        gap = np.minimum(anchor, separation(moving[0], solid)) if moving else np.array([anchor])
        place = solid.places - (0.0, 0.0, part.thickness / 2)
        found = f"{solid.name}: ", as_plate(part), None, solid.turns, place
        parts.append(PlacedPlate(*found, gap, anchor, part.centre, windings, part.metal.susceptibility))
    return parts


@lru_cache(maxsize=64)
def as_plate(part: Conductor) -> Target:
    """Return a fixed plate as a target of the same shape and metal."""
    return Target(
        conductivity=part.metal.conductivity, relative_permeability=part.metal.relative_permeability, shape=part.shape,
        width=part.width, length=part.length, diameter=part.diameter, points=part.points, holes=part.holes,
        thickness=part.thickness, load_height=0.0,
    )


def overlapping(sensor: Sensor) -> str | None:
    """Say in one line which fixed plate touches a coil or another plate; None if none does.

    An outline may lie around a coil, in its plane, but not around another plate.
    """
    coils, plates = fixed_solids(sensor)
    for k, plate in enumerate(plates):
        for other in (*(() if sensor.conductors[k].shape == "outline" else coils), *plates[:k]):
            if separation(plate, other).min() <= 0.0:
                return (
                    f"{plate.name}, {other.name}: model 'sheets' needs parts whose boxes (sides along the part's "
                    "axes) do not touch, got boxes that do; move one, or 'planar-fem' if the sections are apart"
                )
    return None


def _check_above(target: Target, outline: Outline | None, turns: Array, places: Array) -> None:
    """Raise Collision where the plate's lowest point is not above the coil plane."""
    rim = target_outline(target, outline).rim
    low = places[:, 2] + (turns[:, 2, :2] @ rim.T).min(1) + np.minimum(turns[:, 2, 2] * target.thickness, 0.0)
    if not np.all(low > 0.0):
        worst = float(np.min(np.where(np.isnan(low), -np.inf, low)))
        raise Collision(f"pose: the target must stay above the coil plane z = 0, its lowest point is at {worst:.4g} m")
