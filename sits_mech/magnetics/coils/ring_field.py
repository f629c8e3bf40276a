"""Field of a coil: its vector potential at points in space, of rings or of straight tracks, and its wave numbers.

Ring of radius a at height z_k, 1 A, at distance rho from its axis, with M of coaxial loops (`loops`; nothing cancels on
the axis):

    A = (-y, x, 0) P,   P = M(a, rho, z - z_k) / (2 pi rho^2).

P of all the coil's rings together is smooth over the distance from them: for many points it is tabulated once and
interpolated (cubic splines in ln z and, with its mirror image, in s; in steps h of both less than 2e-6 (h/0.04)^4
off; a table's heights z are filled octave by octave, in steps of c = z / 2 or more). From a clearance c on, of windings
from b to B,

    s = f(rho) - f(0),   f(rho) = i / c + asinh(3 t + 9/2 t^3) / 3,   t = (rho - i) / c,   i = rho clipped to [b, B],

which is linear above the windings, logarithmic far from them, and smooth to the fourth derivative between.

Above rings below z = 0, with the section means ``S(k) = sum <a J1(k a) exp(k z)>`` [m],

    A_phi = (mu0/2) int_0^inf S(k) J1(k r) exp(-k z) dk    [V s/m per A].

Rectangles, free tracks and true spirals are summed track by track (`straight`). For a track stand filaments at Gauss
points of its width and its thickness, as many as its distance asks (`gauss_count`). Units: V s / (A m). The return lead
is left out.

Source: Dodd and Deeds, J. Appl. Phys. 39 (1968) 2829.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates, spline_filter
from scipy.special import j1

from sits_mech.geometry.tracks import coil_tracks
from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import reduced_mutual
from sits_mech.magnetics.coils.straight import Potential, track_potential
from sits_mech.magnetics.section.kernels import gauss_count, gauss_rule
from sits_mech.memory import beyond_memory, check_seconds, latest
from sits_mech.quantities import Array, Integers
from sits_mech.scene.sensor import Coil

STEP = 0.04
"""Of tables, in distances to the windings."""
_RIGHT = 5e-5  # error of a track's field by filaments, of its size; by 3e-4 all cells have L and R 1.6e-4 off
_STEPLESS = 1e-5  # the same where fewer filaments will do: no step shows in what is interpolated
_POINT = 9e-8  # s of processor time that a filament of a ring takes at a point
_NODES, _FEW = 64, 16  # of a profile, or a multiple: one serves many places; points of a height, with fewer none
_POSES = 30  # whose points of a plate a table may outnumber: as many cost the same without one
_TRACK = 5e-8  # s that a straight filament does, or a wave across a ring
_BEND = math.sqrt(8.0 / 9.0)  # by which the cubic is solved: t = _BEND sinh(asinh(sinh(3 s) / _BEND) / 3)
_PAD = 12  # cells of a table beyond the region: its end moves a spline 0.27 times as much a cell, 1e-7 there
_PANEL = 16  # Gauss points of a panel
_WAVES = 0.375  # Gauss points across a ring, over its width times the largest wave number: 1.5 times the fewest
_ARRAYS = 4  # of a number for each ring and wave number, beside those at the Gauss points


def filament_counts(coil: Coil, clearance: float, error: float = _RIGHT) -> tuple[int, int]:
    """Return how many filaments across a track and through it are right from a clearance on [m], and in its moment."""
    away = min(clearance, coil.outer_diameter / 4)
    return gauss_count(coil.track_width, away, error), gauss_count(coil.track_thickness, clearance, error)


def _farther(
    coil: Coil, away: Array, clearance: float, error: float = _RIGHT
) -> list[tuple[tuple[int, int], Any]]:
    """Return how many filaments points take, and which: fewer octave by octave of `away`, so far that no step shows.

    `away` is how far they are from a track, `clearance` the least such distance [m].
    """
    most, kinds = filament_counts(coil, clearance, error), defaultdict[tuple[int, int], list[float]](list)
    if most == (1, 1):
        return [(most, ...)]
    octave = np.floor(np.log2(np.maximum(away / clearance, 1.0)))
    for k in np.unique(octave).tolist():
        few = filament_counts(coil, clearance * 2.0**k, min(error, _STEPLESS))
        kinds[min(most[0], few[0]), min(most[1], few[1])].append(k)
    return [(counts, np.isin(octave, each)) for counts, each in kinds.items()]


def ring_profile(coil: Coil, rho: Array, z: Array, clearance: float, error: float = _RIGHT) -> Array:
    """Return P of the module docstring, all rings in series, where points are at least a clearance off [m].

    `error` is that of a track's field by filaments, of its size.
    """
    rings = coil_sections(coil)
    rho, z = np.broadcast_arrays(rho, z)
    total = np.zeros(rho.shape)
    columns = zip(rings.radius, rings.z, rings.width, rings.height, rings.signs, strict=True)
    for radius, middle, width, height, way in columns:
        radial, above = np.abs(rho - radius) - width / 2, np.abs(z - middle) - height / 2
        parts = _farther(coil, np.hypot(np.maximum(radial, 0.0), np.maximum(above, 0.0)), clearance, error)
        seconds = _POINT * rings.radius.size * sum(math.prod(counts) * rho[some].size for counts, some in parts)
        where = f"at {rho.size} points from {1e3 * clearance:.2g} mm on"
        check_seconds(seconds, f"coils: the field of {rings.radius.size} turns {where}")
        for counts, some in parts:
            for (out, share), (up, part) in product(*(zip(*gauss_rule(count), strict=True) for count in counts)):
                a, away = radius + width / 2 * out, z[some] - middle - height / 2 * up
                total[some] += way * share * part * a * a / math.tau * reduced_mutual(a, rho[some], away)
    return total


def coil_potential(coil: Coil, points: Array, clearance: float, windings: str = "rings") -> Array:
    """Return A of a coil at points (n, 3) [m], at least a clearance off, shape (n, 3) [V s / (A m)]."""
    if windings == "rings" and coil.is_round:
        x, y = points.T[:2] - np.reshape(coil.centre, (2, 1))
        profile = ring_profile(coil, np.hypot(x, y), points[:, 2], clearance)
        A = np.stack([-y * profile, x * profile])
    else:
        A = _straight(coil, windings, clearance)(points.T[None])[0]
    return np.column_stack([*A, np.zeros(len(points))])


def _straight(coil: Coil, windings: str, clearance: float) -> Potential:
    """Return a function that gives A of a coil's straight tracks, (p, 3, q) to (p, 2, q)."""
    def potential(points: Array) -> Array:
        """Return A at points [m]."""
        flat = np.swapaxes(points, 0, 1).reshape(3, -1)
        found = np.empty((2, flat.shape[1]))
        for counts, some in _farther(coil, np.maximum(flat[2], -coil.height - flat[2]), clearance):
            found[:, some] = _tracks(coil, windings, counts)(flat[:, some][None])[0]
        return np.swapaxes(found.reshape(2, len(points), -1), 0, 1)

    return potential


@lru_cache(maxsize=32)
def _tracks(coil: Coil, windings: str, counts: tuple[int, int]) -> Potential:
    """Return A of a coil's straight tracks by so many filaments across and through each."""
    return track_potential(coil_tracks(coil, windings), *map(gauss_rule, counts))


def winding_potential(
    winding: Coil, windings: str, region: tuple[float, float, float], points: int, step: float = STEP
) -> Potential:
    """Return a function that gives A of a coil about z anywhere in a region, (p, 3, q) to (p, c, q); c = 2 without A_z.

    `region`: distance from which on it is right, and height on which rings are tabulated; greatest height and distance
    from the axis [m], which what is found at a point does not depend on. `windings` are "rings" or "spiral"; `points`
    are those of a pose, by which a table in some steps [distance to the windings] pays or not.
    """
    if not winding.is_round or windings == "spiral":
        return _straight(winding, windings, region[0])
    lowest, axis = region[0], Radial(winding, region[0], step)
    least = 2 * _PAD * (_PAD + axis.steps(winding.outer_diameter / 2))  # nodes of a table, whatever the poses
    if least > _POSES * points:
        return lambda at: np.swapaxes(
            coil_potential(winding, np.swapaxes(at, 1, 2).reshape(-1, 3), lowest).reshape(len(at), -1, 3), 1, 2
        )[:, :2]
    highest, farthest = (2.0 ** math.ceil(math.log2(size)) for size in region[1:])  # few tables serve all poses
    columns = _PAD + math.ceil(axis.steps(farthest))
    rows = 2 * _PAD + math.ceil(math.log(highest / lowest) / step)
    return _table(axis, columns, rows).potential


def check_straight(coils: Sequence[Coil], windings: str, lowest: float, points: int) -> None:
    """Refuse the potential of coils of straight tracks, at points from a height on, where it takes too long."""
    straight = [coil for coil in coils if not coil.is_round or windings == "spiral"]
    tracks = sum(len(coil_tracks(coil, windings).start) * math.prod(filament_counts(coil, lowest)) for coil in straight)
    check_seconds(_TRACK * tracks * points, f"coils: the field of {tracks} straight filaments at {points} points")


@dataclass(frozen=True)
class Radial:
    """Distances from a round coil's axis in steps over which its field is smooth, from a clearance on [m]."""

    coil: Coil
    clearance: float
    step: float = STEP  # in the clearance

    def steps(self, rho: Array | float) -> Any:
        """Return s of the module docstring [`step`]."""
        return (self._from_windings(rho) - self._from_windings(0.0)) / self.step

    def at(self, steps: Integers) -> Any:
        """Return the distance from the axis after so many steps [m]."""
        s, c = self.step * steps + self._from_windings(0.0), self.clearance
        i = self._wound(c * s)
        return i + c * _BEND * np.sinh(np.arcsinh(np.sinh(3.0 * (s - i / c)) / _BEND) / 3.0)

    def _from_windings(self, rho: Array | float) -> Any:
        """Return f of the module docstring."""
        i, c = self._wound(rho), self.clearance
        t = (rho - i) / c
        return i / c + np.arcsinh(t * (3.0 + 4.5 * t * t)) / 3.0

    def _wound(self, rho: Array | float) -> Any:
        """Return the nearest distance from the axis that is wound."""
        return np.clip(rho, self.coil.inner_diameter / 2, self.coil.outer_diameter / 2)


@dataclass(frozen=True, eq=False)
class _Table:
    """Spline coefficients of P in steps of a coil's distances from the axis, and of ln z from `start` on; P below."""

    axis: Radial
    values: Array
    start: float

    def potential(self, points: Array) -> Array:
        """Return A_x and A_y at points (p, 3, q), shape (p, 2, q)."""
        x, y, z = points[:, 0], points[:, 1], points[:, 2]
        rho, below = np.hypot(x, y), z < math.exp(self.start + 0.5 * _PAD * self.axis.step)
        height = np.log(np.where(below, 1.0, z))
        place = np.stack([self.axis.steps(rho), (height - self.start) / self.axis.step])
        P = map_coordinates(self.values, place, order=3, mode="mirror", prefilter=False)
        if below.any():
            P[below] = ring_profile(self.axis.coil, rho[below], z[below], self.axis.clearance)
        return np.stack([-y * P, x * P], axis=1)


@lru_cache(maxsize=16)
def _table(axis: Radial, columns: int, rows: int) -> _Table:
    """Return P of a coil's rings at so many distances from the axis, and heights about its clearance and above."""
    from scipy.interpolate import CubicSpline

    start = math.log(axis.clearance) - _PAD * axis.step
    rho, z = axis.at(np.arange(columns)), np.exp(start + axis.step * np.arange(rows))
    octave, P = np.floor(np.log2(np.maximum(z / axis.clearance, 1.0))), np.empty((columns, rows))
    for k in np.unique(octave).tolist():
        own, some = replace(axis, clearance=axis.clearance * 2.0**k), octave == k
        steps = own.steps(rho)
        nodes = np.arange(math.ceil(steps[-1]) + _PAD)
        values = ring_profile(axis.coil, own.at(nodes)[:, None], z[some], axis.clearance)
        P[:, some] = CubicSpline(nodes, values, bc_type="clamped")(steps)
    return _Table(axis, spline_filter(P, order=3, mode="mirror"), start)


def level_potential(coil: Coil, windings: str, points: Array, distance: float) -> Array:
    """Return `coil_potential` about z; of rings at many points of few heights by splines of one profile."""
    from scipy.interpolate import CubicSpline

    if windings != "rings" or not coil.is_round:
        return coil_potential(coil, points, distance, windings)
    heights, level = np.unique(points[:, 2], return_inverse=True)
    if _FEW * heights.size > len(points):
        return coil_potential(coil, points, distance)
    axis, P = Radial(coil, distance), np.empty(len(points))
    steps = axis.steps(np.hypot(points[:, 0], points[:, 1]))
    rim, last = int(axis.steps(coil.outer_diameter / 2)), _NODES * math.ceil(steps.max() / _NODES + 0.1)
    nodes, values = _profiles(axis, tuple(heights.tolist()), rim if steps.min() > rim else 0, last)
    for k, row in enumerate(values):
        P[level == k] = CubicSpline(nodes, row)(steps[level == k])
    return np.column_stack([-points[:, 1] * P, points[:, 0] * P, np.zeros(len(points))])


@latest(16)
def _profiles(axis: Radial, heights: tuple[float, ...], first: int, last: int) -> tuple[Integers, Array]:
    """Return steps from a coil's axis, and P of its rings there on some heights [m], (heights, steps)."""
    nodes = np.arange(first, last)
    return nodes, ring_profile(axis.coil, axis.at(nodes), np.array(heights)[:, None], axis.clearance)


def source_spectrum(rings: Sections, k: Array) -> Array:
    """Return S(k), shape (n,) [m]: section means of ``a J1(k a) exp(k z)``, summed over rings of 1 A below z = 0.

    Gauss points across a ring are as many as its waves ask. ValueError where it would take more memory than the process
    may, SceneError where it would take longer than a step may.
    """
    points, n = 4 + int(_WAVES * k.max(initial=0.0) * rings.width.max(initial=0.0)), rings.radius.size
    if beyond := beyond_memory(8.0 * (2 * points + _ARRAYS) * n * k.size):
        raise ValueError(f"coils: {n} turns of a coil, times {k.size} wave numbers, take {beyond}")
    check_seconds(_TRACK * points * n * k.size, f"coils: {k.size} wave numbers of {n} turns")
    nodes, weights = np.polynomial.legendre.leggauss(points)
    a = rings.radius[:, None] + rings.width[:, None] / 2 * nodes
    mean = np.einsum("rg,rgk,g->rk", a, j1(a[:, :, None] * k), weights) / 2
    thick = np.maximum(k * rings.height[:, None], 1e-12)
    top = (rings.z + rings.height / 2)[:, None]
    return np.asarray(rings.signs @ (mean * -np.expm1(-thick) / thick * np.exp(k * top)))


def wave_numbers(largest: float, length: float) -> tuple[Array, Array]:
    """Return Gauss points and weights on [0, largest] for what turns like ``exp(j k length)``, finer towards 0."""
    panels = 16 + int(largest * length / _PANEL)
    edges = largest * np.linspace(0.0, 1.0, panels + 1) ** 1.5
    nodes, weights = np.polynomial.legendre.leggauss(_PANEL)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1.0 + nodes)).ravel(), (half * weights).ravel()
