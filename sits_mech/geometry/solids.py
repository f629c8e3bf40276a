"""Which plates stand in the space around the coils, and how far is each from everything else, as `boxes` go?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.boxes import Solid, fixed_solids, nearest, separation
from sits_mech.geometry.collision import Collision
from sits_mech.geometry.outline import Outline, target_outline
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Conductor, Sensor, Target


@dataclass(frozen=True)
class PlacedPlate:
    """A plate in its places.

    Attributes
    ----------
    title : str
        What to put before a note on it; nothing for the target.
    plate : Target
        Its shape and metal.
    outline : Outline or None
        Instead of the scene's.
    turns, places : ndarray, shapes (p, 3, 3), (p, 3)
        Rotations, and places of the bottom face's centre [m]; p = 1 if it does not move.
    gap : float
        From all else, the smallest over all poses; for the target from the coil plane, not from the coils [m].
    middle : tuple of float
        Seen from above; of the target, where it is at rest [m].
    """

    title: str
    plate: Target
    outline: Outline | None
    turns: Array
    places: Array
    gap: float
    middle: tuple[float, float]


def placed_plates(sensor: Sensor, outline: Outline | None, turns: Array, places: Array) -> list[PlacedPlate]:
    """Return the target, if there is one, and the fixed plates.

    Parameters
    ----------
    sensor : Sensor
    outline : Outline or None
        The target's, instead of the scene's.
    turns, places : ndarray, shapes (p, 3, 3), (p, 3)
        The target's poses [m].

    Raises
    ------
    Collision
        If the target touches a fixed plate's box or the coil plane in any pose.
    """
    coils, plates = fixed_solids(sensor)
    parts: list[PlacedPlate] = []
    moving: list[Solid] = []
    if sensor.target is not None and places.size:
        t = sensor.target.thickness
        half = np.array([*np.abs(target_outline(sensor.target, outline).rim).max(0), t / 2])
        moving = [Solid("target", half, turns, places + turns[:, :, 2] * t / 2)]
        apart = {plate.name: nearest(moving[0], (plate,)) for plate in plates}
        for name, gap in apart.items():
            if gap <= 0.0:
                raise Collision(
                    f"pose: the boxes around the target and {name} must be clear of each other for 'sheets', they "
                    f"overlap by {-gap * 1e3:.3g} mm"
                )
        gap = min(float(lowest_points(sensor.target, outline, turns, places).min()), *apart.values(), np.inf)
        parts = [PlacedPlate("", sensor.target, outline, turns, places, gap, (0.0, 0.0))]
    for k, (part, solid) in enumerate(zip(sensor.conductors, plates, strict=True)):
        gap = nearest(solid, (*coils, *moving, *plates[:k], *plates[k + 1 :]))
        place = solid.places - (0.0, 0.0, part.thickness / 2)
        parts.append(PlacedPlate(f"{solid.name}: ", as_plate(part), None, solid.turns, place, gap, part.centre[:2]))
    return parts


def as_plate(part: Conductor) -> Target:
    """Return a fixed plate as a target of the same shape and metal."""
    return Target(
        conductivity=part.metal.conductivity, relative_permeability=part.metal.relative_permeability, shape=part.shape,
        width=part.width, length=part.length, diameter=part.diameter, thickness=part.thickness, load_height=0.0,
    )  # fmt: skip


def overlapping(sensor: Sensor) -> str | None:
    """Say in one line which fixed plate touches a coil or another plate; None if none does."""
    coils, plates = fixed_solids(sensor)
    for k, plate in enumerate(plates):
        for other in (*coils, *plates[:k]):
            if separation(plate, other).min() <= 0.0:
                return (
                    f"{plate.name}, {other.name}: model 'sheets' needs parts whose boxes (sides along the part's "
                    "axes) do not touch, got boxes that do; move one, or 'planar-fem' if the sections are apart"
                )
    return None


def lowest_points(target: Target, outline: Outline | None, turns: Array, places: Array) -> Array:
    """Return the height of the plate's lowest point over the coil plane, one a pose [m].

    Parameters
    ----------
    target : Target
    outline : Outline or None
        Instead of the scene's.
    turns, places : ndarray, shapes (p, 3, 3), (p, 3)
        Poses [m].

    Raises
    ------
    Collision
        Where it is not above.
    """
    rim = target_outline(target, outline).rim
    low = places[:, 2] + (turns[:, 2, :2] @ rim.T).min(1) + np.minimum(turns[:, 2, 2] * target.thickness, 0.0)
    if not np.all(low > 0.0):
        worst = float(np.min(np.where(np.isnan(low), -np.inf, low)))
        raise Collision(f"pose: the target must stay above the coil plane z = 0, its lowest point is at {worst:.4g} m")
    return np.asarray(low)
