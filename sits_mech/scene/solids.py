"""Boxes around parts in their places, and whether a slab fits between two of them.

Two boxes are apart exactly where a slab fits between them, across one of their axes or of the products of these.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array


@dataclass(frozen=True)
class BoxedPart:
    """A box around a part in its p places; p = 1 if it does not move."""

    name: str  # as in the scene
    half: Array  # (3,) half sizes [m]
    turns: Array  # (p, 3, 3) rotations
    places: Array  # (p, 3) of the middle [m]

    @classmethod
    def level(cls, name: str, size: tuple[float, ...], place: tuple[float, ...]) -> BoxedPart:
        """Return a box along x, y and z that does not move, by its sizes and its middle [m]."""
        return cls(name, np.array(size) / 2, np.eye(3)[None], np.array([place]))


def separation(first: BoxedPart, second: BoxedPart) -> Array:
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
