"""Which plates stand in the space around the coils, and how far is each from everything else?

Every part has a box around it, with sides along the part's own axes. The distance of two boxes is bounded from below by
the widest slab that fits between them; two boxes are apart exactly where there is one, across one of their axes or of
the products of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.collision import Collision
from sits_mech.geometry.outline import Outline, target_outline
from sits_mech.quantities import Array
from sits_mech.sensor import Conductor, Sensor, Target


@dataclass(frozen=True)
class Solid:
    """A box around a part, in one place or in many.

    Attributes
    ----------
    name : str
        As in the scene.
    half : ndarray, shape (3,)
        Half sizes [m].
    turns : ndarray, shape (p, 3, 3)
        Rotations; p = 1 if it does not move.
    places : ndarray, shape (p, 3)
        Of the middle [m].
    """

    name: str
    half: Array
    turns: Array
    places: Array


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
                raise Collision(f"pose: target, {name}: the boxes around them must not touch, got boxes that do")
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


def fixed_solids(sensor: Sensor) -> tuple[tuple[Solid, ...], tuple[Solid, ...]]:
    """Return the boxes around the coils, and those around the fixed plates."""
    coils = [
        (coil.name, (coil.outer_diameter, coil.outer_diameter, coil.height), (*coil.centre, -coil.height / 2))
        for coil in sensor.coils
    ]
    plates = [(f"conductors.{part.name}", (*part.extent, part.thickness), part.centre) for part in sensor.conductors]
    both = [
        tuple(Solid(name, np.array(size) / 2, np.eye(3)[None], np.array([place])) for name, size, place in parts)
        for parts in (coils, plates)
    ]
    return both[0], both[1]


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


def separation(first: Solid, second: Solid) -> Array:
    """Return the width of the widest slab between two boxes, negative where they overlap; one a pose [m].

    At most their distance, and positive exactly where there is one (separating axes: the boxes' and their products).
    """
    first_axes, second_axes = np.broadcast_arrays(np.swapaxes(first.turns, 1, 2), np.swapaxes(second.turns, 1, 2))
    products = np.cross(first_axes[:, :, None], second_axes[:, None]).reshape(-1, 9, 3)
    length = np.linalg.norm(products, axis=2, keepdims=True)
    products = np.where(length > 1e-9, products / np.maximum(length, 1e-9), first_axes[:, :1])
    axes = np.concatenate([first_axes, second_axes, products], axis=1)
    apart = np.abs(np.einsum("pai,pi->pa", axes, first.places - second.places))
    for solid, own in ((first, first_axes), (second, second_axes)):
        apart = apart - np.abs(np.einsum("pai,pji->paj", axes, own)) @ solid.half
    return np.asarray(apart.max(1))


def nearest(solid: Solid, others: Sequence[Solid]) -> float:
    """Return the smallest separation from other boxes over all poses [m]; infinite without others."""
    return min((float(separation(solid, other).min()) for other in others), default=np.inf)


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
