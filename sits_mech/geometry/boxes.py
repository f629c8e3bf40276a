"""Bound the distance of parts from below by the boxes around them, in one place or in many.

Every part has a box around it, with sides along the part's own axes. The distance of two boxes is bounded from below by
the widest slab that fits between them; two boxes are apart exactly where there is one, across one of their axes or of
the products of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array
from sits_mech.scene.sensor import Sensor


@dataclass(frozen=True)
class Solid:
    """A box around a part in its p places; p = 1 if it does not move."""

    name: str  # as in the scene
    half: Array  # (3,) half sizes [m]
    turns: Array  # (p, 3, 3) rotations
    places: Array  # (p, 3) of the middle [m]


def fixed_solids(sensor: Sensor) -> tuple[tuple[Solid, ...], tuple[Solid, ...]]:
    """Return the boxes around the coils, or their layers, and those around the fixed plates."""
    coils = [
        (coil.name, (*coil.extent, high - low), (*coil.centre, (low + high) / 2))
        for coil in sensor.coils for low, high in coil.spans
    ]
    plates = [(f"conductors.{part.name}", (*part.extent, part.thickness), part.centre) for part in sensor.conductors]
    both = [
        tuple(Solid(name, np.array(size) / 2, np.eye(3)[None], np.array([place])) for name, size, place in parts)
        for parts in (coils, plates)
    ]
    return both[0], both[1]


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
