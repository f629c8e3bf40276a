"""Choose places along a coil's tracks at which the field of metal nearby is taken.

A station is a direction from the coil's middle: there, the field across the tracks at some nodes is interpolated to all
turns, of which the rings of `tracks.standing_rings` are the sections. Metal a gap away answers smoothly over that gap,
and with it goes how many stations and nodes there are: of round coils Gauss points over the winding's radius and
height, of others the tracks' own places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss

from sits_mech.geometry.tracks import coil_tracks, standing_rings
from sits_mech.geometry.windings import Sections
from sits_mech.quantities import Array, Complex, Integers
from sits_mech.scene.sensor import Coil

_APART = 1.2  # of nodes and stations, over the gap: 0.2 % of R where a rim lies over the winding
_STATIONS, _ACROSS = (16, 32), (4, 12)  # at least and at most
_THROUGH, _FLAT = 3, 0.05  # nodes over the height; one where that is no more of the radius


@dataclass(frozen=True, eq=False)
class Stations:
    """Places about a coil's middle, s stations of m nodes each."""

    points: Array  # (s, m, 3) [m]
    outward: Array  # (s, m, 2) across the track, in the plane
    share: Array  # (s,) of the tracks' length
    turns: Array  # (t, m) from nodes to rings

    def across(self, B: Complex) -> Complex:
        """Return the parts up and outwards of B (p, s m, 3, n) at the points, (p, s, m, 2, n)."""
        B = B.reshape(len(B), *self.points.shape, -1)
        return np.stack([B[..., 2, :], np.einsum("psmin,smi->psmn", B[..., :2, :], self.outward)], axis=3)

    def by_turns(self, field: Complex) -> Complex:
        """Return a field of nodes (p, s, m, 2, n) at all turns, (p, n, s, 2 t), that up before that outwards."""
        found = np.moveaxis(field, 4, 1).swapaxes(3, 4) @ self.turns.T
        return found.reshape(*found.shape[:3], -1)


@lru_cache(maxsize=256)
def stations(coil: Coil, gap: float) -> Stations:
    """Return the stations of a coil about z (`windings.unnamed`) for metal from a gap on [m]."""
    rings = standing_rings(coil)
    if not coil.is_round:
        return _straight(coil, rings)
    count = _between(2.0 * np.pi * rings.radius.mean() / (_APART * gap), _STATIONS)
    radii = _nodes(rings.radius, _between(np.ptp(rings.radius) / (_APART * gap), _ACROSS))
    heights = _nodes(rings.z, 1 if np.ptp(rings.z) < _FLAT * rings.radius.max() else _THROUGH)
    turns = np.einsum("tm,tk->tmk", _lagrange(radii, rings.radius), _lagrange(heights, rings.z))
    radius, z = (each.ravel() for each in np.meshgrid(radii, heights, indexing="ij"))
    angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    outward = np.broadcast_to(way[:, None], (count, z.size, 2))
    points = np.concatenate([outward * radius[:, None], np.broadcast_to(z[:, None], (count, z.size, 1))], axis=2)
    return Stations(points, outward, np.full(count, 1.0 / count), turns.reshape(rings.radius.size, -1))


def _between(count: float, ends: tuple[int, int]) -> int:
    """Return a whole number from one end to another."""
    return min(max(math.ceil(count), ends[0]), ends[1])


def _straight(coil: Coil, rings: Sections) -> Stations:
    """Return stations of straight tracks: in some directions, of each ring a place along a track, by their rank."""
    tracks = coil_tracks(coil)
    count = np.maximum(np.ceil(tracks.length / (np.pi * rings.radius.max() / _STATIONS[0])).astype(int), 1)
    which = np.repeat(np.arange(count.size), count)
    share = (np.arange(which.size) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[which]
    places = tracks.start[which] + share[:, None] * (tracks.end - tracks.start)[which]
    right = np.column_stack([tracks.way[which, 1], -tracks.way[which, 0]])
    away = np.hypot(*places[:, :2].T)
    right *= np.where(np.einsum("ij,ij->i", right, places[:, :2]) < 0.0, -1.0, 1.0)[:, None]
    sector = np.floor(np.arctan2(places[:, 1], places[:, 0]) / (2.0 * np.pi) * _STATIONS[0]).astype(int) % _STATIONS[0]
    length = np.bincount(sector, (tracks.length / count)[which], _STATIONS[0])
    used = np.flatnonzero(length)
    chosen = np.array([_by_rank(places, away, np.flatnonzero(sector == each), rings) for each in used])
    return Stations(places[chosen], right[chosen], length[used] / length.sum(), np.eye(rings.radius.size))


def _by_rank(places: Array, away: Array, some: Integers, rings: Sections) -> Integers:
    """Return which of some places stands for each ring: from the middle out, on the nearest height."""
    chosen = np.empty(rings.radius.size, dtype=np.int64)
    for z in np.unique(rings.z):
        own = np.flatnonzero(rings.z == z)
        apart = np.abs(places[some, 2] - z)
        level = some[apart <= apart.min() + 1e-9]
        ordered = level[np.argsort(away[level], kind="stable")]
        rank = (np.argsort(np.argsort(rings.radius[own])) + 0.5) / own.size
        chosen[own] = ordered[(rank * ordered.size).astype(int)]
    return chosen


def _nodes(values: Array, most: int) -> Array:
    """Return Gauss points between the extremes of values, or the different values where these are no more."""
    each = np.unique(values)
    if each.size <= most:
        return each
    return np.asarray((each[0] + each[-1]) / 2 + (each[-1] - each[0]) / 2 * leggauss(most)[0])


def _lagrange(nodes: Array, at: Array) -> Array:
    """Return Lagrange's polynomials of nodes at places, shape (places, nodes)."""
    found = np.ones((at.size, nodes.size))
    for k, node in enumerate(nodes):
        for other in np.delete(nodes, k):
            found[:, k] *= (at - other) / (node - other)
    return found
