"""Where a coil's current runs: its tracks as straight bars (planar), as concentric rings, and as spiral paths.

A coil has `layers` layers of `turns` turns. Turn i (0 is the innermost) has its centre line at

    r_i = inner_diameter / 2 + track_width / 2 + i (track_width + track_gap)

and layer k (0 is the uppermost, whose top face is z = 0) at

    z_k = -track_thickness / 2 - k layer_pitch.

All turns are in series. A positive current runs counter-clockwise seen from above, so that in the planar section
y = 0 it runs along +y (into the picture of x to the right, z up) on the coil's right side and along -y on its left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy.constants import c

from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil


@dataclass(frozen=True)
class Bars:
    """Tracks of one coil in the section y = 0, all of one size, in series.

    Attributes
    ----------
    x, z : ndarray, shape (n,)
        Centres [m].
    sign : ndarray, shape (n,)
        +1 where a positive coil current runs along +y, -1 where it returns.
    width, thickness : float
        Sizes along x and z [m].
    """

    x: Array
    z: Array
    sign: Array
    width: float
    thickness: float


@dataclass(frozen=True)
class Sections:
    """Coaxial rings of rectangular section.

    Attributes
    ----------
    radius, z : ndarray, shape (n,)
        Centres of the sections [m].
    width, height : ndarray, shape (n,)
        Sizes along r and z [m].
    """

    radius: Array
    z: Array
    width: Array
    height: Array

    def mirrored(self) -> Sections:
        """Return the image in the plane z = 0."""
        return Sections(self.radius, -self.z, self.width, self.height)


def kinds_of(coils: Sequence[Coil]) -> tuple[tuple[Coil, ...], tuple[int, ...]]:
    """Return the distinct windings among coils, about z and without a name, and which of them each coil has.

    In an order that does not depend on that of the coils.
    """
    return _kinds_of(tuple(coils))


@lru_cache(maxsize=32)
def _kinds_of(coils: tuple[Coil, ...]) -> tuple[tuple[Coil, ...], tuple[int, ...]]:
    windings = [coil.model_copy(update={"name": "", "centre": (0.0, 0.0)}) for coil in coils]
    kinds = sorted(set(windings), key=repr)
    return tuple(kinds), tuple(kinds.index(winding) for winding in windings)


def rounded(distance: float) -> float:
    """Return a distance to twelve digits: those that are equal as meant differ by rounding."""
    return float(f"{distance:.11e}")


def distinct_pairs(coils: Sequence[Coil]) -> tuple[Sequence[Coil], list[tuple[int, int, float]], NDArray[np.int64]]:
    """Return the distinct windings; the distinct pairs of them, with the distance of the axes; which one each two are.

    A coil makes a pair with itself, at distance zero. The last is of shape (n, n).
    """
    kinds, which = kinds_of(coils)
    found = dict[tuple[int, int, float], int]()
    index = np.zeros((len(coils), len(coils)), dtype=np.int64)
    for i, j in combinations_with_replacement(range(len(coils)), 2):
        apart = rounded(math.dist(coils[i].centre, coils[j].centre))
        pair = min(which[i], which[j]), max(which[i], which[j]), apart
        index[i, j] = index[j, i] = found.setdefault(pair, len(found))
    return kinds, list(found), index


def turn_radii(coil: Coil) -> Array:
    """Radii of the turns' centre lines, innermost first [m]; shape (turns,)."""
    pitch = coil.track_width + coil.track_gap
    return coil.inner_diameter / 2 + coil.track_width / 2 + pitch * np.arange(coil.turns, dtype=np.float64)


def layer_heights(coil: Coil) -> Array:
    """Heights z of the layers' mid-planes, uppermost first [m]; shape (layers,)."""
    return -coil.track_thickness / 2 - coil.layer_pitch * np.arange(coil.layers, dtype=np.float64)


def coil_sections(coil: Coil) -> Sections:
    """Return the coil as ``layers * turns`` concentric rings about its axis."""
    z, radius = (each.ravel() for each in np.meshgrid(layer_heights(coil), turn_radii(coil), indexing="ij"))
    return Sections(radius, z, np.full(z.size, coil.track_width), np.full(z.size, coil.track_thickness))


def coil_bars(coil: Coil) -> Bars:
    """Return the coil's section y = 0 as ``2 * layers * turns`` bars."""
    rings = coil_sections(coil)
    n = rings.radius.size
    x = coil.centre[0] + np.concatenate([rings.radius, -rings.radius])
    sign = np.concatenate([np.ones(n), -np.ones(n)])
    return Bars(x, np.tile(rings.z, 2), sign, coil.track_width, coil.track_thickness)


def spiral_path(coil: Coil, *, points_per_turn: int = 60) -> Array:
    """Return the coil's centre line as one polyline: every layer an Archimedean spiral, in series.

    Layers alternate inwards and outwards and are joined by straight vias; all turn counter-clockwise seen from above.

    Returns
    -------
    ndarray, shape (n, 3)
        Vertices x, y, z in the order of a positive current [m].
    """
    pitch = coil.track_width + coil.track_gap
    r = turn_radii(coil)
    theta = np.linspace(0.0, 2 * np.pi * coil.turns, points_per_turn * coil.turns + 1)
    outward = r[0] - pitch / 2 + pitch * theta / (2 * np.pi)
    pieces: list[Array] = []
    for k, z in enumerate(layer_heights(coil)):
        radius = outward[::-1] if k % 2 == 0 else outward
        xy = np.column_stack([radius * np.cos(theta), radius * np.sin(theta)])
        pieces.append(np.column_stack([xy + np.asarray(coil.centre), np.full(theta.size, z)]))
    return np.vstack(pieces)


def track_length(coil: Coil) -> float:
    """Length of the track, all turns and layers [m]."""
    return float(2 * np.pi * turn_radii(coil).sum() * coil.layers)


def check_frequency(coils: Sequence[Coil], frequency: float) -> None:
    """Refuse a frequency at which a track is as long as a wave in free space: its current is no longer one current.

    Raises
    ------
    ValueError
        Also if the frequency is not a positive number.
    """
    if not 0.0 < frequency < math.inf:
        raise ValueError(f"frequency: must be a positive number of hertz, got {frequency}")
    coil = max(coils, key=track_length)
    length = track_length(coil)
    if frequency * length > c:
        raise ValueError(
            f"frequency: must be below {c / length:.3g} Hz, where a wave is as long as the track of coil {coil.name} "
            f"({length:.3g} m), got {frequency:g} Hz; no model here holds waves: it takes a full-wave solver"
        )


def wave_notes(coils: Sequence[Coil], frequency: float) -> tuple[str, ...]:
    """Say where a track is longer than a tenth of a wave: near its self-resonance, which no model here holds."""
    coil = max(coils, key=track_length)
    share = frequency * track_length(coil) / c
    if share < 0.1:
        return ()
    return (
        f"displacement current: the track of {coil.name} is {share:.2g} waves long at {frequency:.3g} Hz; what its "
        "turns' own capacitance adds is not held",
    )
