"""Describe round coils as concentric rings and as spirals, and tell which coils are equal; for others see `tracks`.

A round coil has `layers` layers of `turns` turns. Turn i (0 is the innermost) has its centre line at

    r_i = inner_diameter / 2 + track_width / 2 + i (track_width + track_gap)

and layer k (0 is the uppermost, whose top face is z = 0) at

    z_k = -track_thickness / 2 - k layer_pitch,    or the scene's own layer_z.

All turns are in series. A positive current runs counter-clockwise seen from above where `directions` does not say
otherwise, so that in the planar section y = 0 it runs along +y (into the picture of x to the right, z up) on the coil's
right side and along -y on its left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from sits_mech.quantities import Array, Integers
from sits_mech.scene.sensor import Coil

Pair = tuple[int, int, tuple[float, float]]


@dataclass(frozen=True)
class Bars:
    """Tracks of one coil in the section y = 0, all of one size, in series."""

    x: Array  # (n,) centres [m]
    z: Array  # (n,)
    sign: Array  # (n,) +1 where a positive coil current runs along +y, -1 where it returns
    width: float  # along x [m]
    thickness: float  # along z [m]


@dataclass(frozen=True)
class Sections:
    """Coaxial rings of rectangular section."""

    radius: Array  # (n,) centres of the sections [m]
    z: Array  # (n,)
    width: Array  # (n,) along r [m]
    height: Array  # (n,) along z [m]
    sign: Array | float = 1.0  # +1 where a positive coil current runs counter-clockwise from above, else -1

    @property
    def signs(self) -> Array:
        """The sign of each ring, shape (n,)."""
        return np.broadcast_to(self.sign, self.radius.shape)

    def some(self, index: Any) -> Sections:
        """Return some of the rings, without their signs."""
        return Sections(self.radius[index], self.z[index], self.width[index], self.height[index])

    def mirrored(self) -> Sections:
        """Return the image in the plane z = 0."""
        return Sections(self.radius, -self.z, self.width, self.height, self.sign)


def kinds_of(coils: Sequence[Coil]) -> tuple[tuple[Coil, ...], tuple[int, ...]]:
    """Return the distinct windings, about z and unnamed, and which each coil has; their order is not the coils'."""
    return _kinds_of(tuple(coils))


@lru_cache(maxsize=32)
def _kinds_of(coils: tuple[Coil, ...]) -> tuple[tuple[Coil, ...], tuple[int, ...]]:
    windings = unnamed(coils)
    several = set(windings)
    kinds = sorted(several, key=repr) if len(several) > 1 else list(several)
    return tuple(kinds), tuple(kinds.index(winding) for winding in windings)


def unnamed(coils: Sequence[Coil]) -> list[Coil]:
    """Return the windings of coils about z, without their names: equal coils are equal."""
    return [coil.model_copy(update={"name": "", "centre": (0.0, 0.0)}) for coil in coils]


def rounded(distance: float) -> float:
    """Return a distance to twelve digits: those that are equal as meant differ by rounding."""
    return float(f"{distance:.11e}")


def placed_pairs(coils: Sequence[Coil], turned: Sequence[bool]) -> tuple[list[Pair], Integers]:
    """Return the distinct pairs of windings, the second axis as seen from the first, and the pair of each two (n, n).

    A coil makes a pair with itself, at distance zero. `turned`: whether each winding (`kinds_of`) is the same however
    it is turned; of two such ones only the distance counts.
    """
    _, which = kinds_of(coils)
    found = dict[Pair, int]()
    index = np.zeros((len(coils), len(coils)), dtype=np.int64)
    for i, j in combinations_with_replacement(range(len(coils)), 2):
        (one, at), (other, there) = sorted((which[k], coils[k].centre) for k in (i, j))
        apart = rounded(there[0] - at[0]), rounded(there[1] - at[1])
        if turned[one] and turned[other]:
            apart = rounded(math.dist(coils[i].centre, coils[j].centre)), 0.0
        index[i, j] = index[j, i] = found.setdefault((one, other, apart), len(found))
    return list(found), index


def turn_radii(coil: Coil) -> Array:
    """Return the radii of a round coil's turns, innermost first, shape (turns,) [m]; ValueError for other shapes."""
    if not coil.is_round:
        raise ValueError(f"coils.{coil.name}: must be round for this; got shape {coil.shape!r}")
    pitch = coil.track_width + coil.track_gap
    return coil.inner_diameter / 2 + coil.track_width / 2 + pitch * np.arange(coil.turns, dtype=np.float64)


def coil_sections(coil: Coil) -> Sections:
    """Return a round coil as ``layers * turns`` concentric rings about its axis; ValueError for other shapes."""
    z, radius = (each.ravel() for each in np.meshgrid(coil.heights, turn_radii(coil), indexing="ij"))
    sign = np.repeat(np.array(coil.directions, dtype=float), coil.turns) if coil.directions else 1.0
    return Sections(radius, z, np.full(z.size, coil.track_width), np.full(z.size, coil.track_thickness), sign)


def spiral_path(coil: Coil, *, points_per_turn: int = 60) -> list[Array]:
    """Return a round coil's centre line about z, an Archimedean spiral (n, 3) a layer, along a positive current [m].

    Layers alternate inwards and outwards and are joined by straight vias, which are no part of it.
    """
    pitch = coil.track_width + coil.track_gap
    r = turn_radii(coil)
    theta = np.linspace(0.0, 2 * np.pi * coil.turns, points_per_turn * coil.turns + 1)
    outward = r[0] - pitch / 2 + pitch * theta / (2 * np.pi)
    pieces: list[Array] = []
    for k, (z, way) in enumerate(zip(coil.heights, coil.directions or (1,) * coil.layers, strict=True)):
        radius = outward[::-1] if k % 2 == 0 else outward
        xy = np.column_stack([radius * np.cos(theta), way * radius * np.sin(theta)])
        pieces.append(np.column_stack([xy, np.full(theta.size, z)]))
    return pieces
