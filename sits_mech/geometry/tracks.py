"""Describe coils whose current runs straight, polygons, free paths and true spirals, as bars between points.

The centre line of turn i (0 is the innermost) of a rectangle, polygon or D lies ``track_width / 2 + i (track_width +
track_gap)`` outwards of the inner edge (`scene.turns`). Rings are facets between points a little outside of them, as
arcs are: L of a ring is met to 1e-4 with 32 facets.

All lie in planes z = const; their sections are upright rectangles. The vias between them are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product

import numpy as np

from sits_mech.description import Refusal
from sits_mech.geometry.windings import Bars, Sections, coil_sections, spiral_path, turn_radii
from sits_mech.memory import beyond_memory
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Mask
from sits_mech.scene.parts.turns import outside, turn
from sits_mech.scene.sensor import Coil
from sits_mech.units import millimetres as mm

c = 299_792_458.0  # of light in free space [m/s], exactly
_STRAIGHT = 1e-6  # tangent of the angle that a track may cross the section at
_ARRAYS = 20  # of all pairs of bars, held at once
_ROUND = 64  # facets of a ring


@dataclass(frozen=True)
class TrackBars:
    """Straight bars in planes z = const, in series."""

    start: Array  # (n, 3) in the order of a positive current [m]
    end: Array  # (n, 3) [m]
    width: Array  # (n,) in the plane [m]
    thickness: Array  # (n,) upright [m]

    @property
    def length(self) -> Array:
        """Lengths, shape (n,) [m]."""
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))

    @property
    def way(self) -> Array:
        """Unit vectors along x and y, shape (n, 2)."""
        return (self.end - self.start)[:, :2] / self.length[:, None]

    def moved(self, x: float, y: float) -> TrackBars:
        """Return them shifted along x and y [m]."""
        return TrackBars(self.start + (x, y, 0.0), self.end + (x, y, 0.0), self.width, self.thickness)

    def strands(self, across: tuple[Array, Array], through: tuple[Array, Array]) -> list[tuple[TrackBars, float]]:
        """Return filaments across widths and through thicknesses, at places from -1 to 1, each with its share.

        Those of tracks that go on where others end meet in a mitre, of up to a third of a turn.
        """
        right = np.column_stack([self.way[:, 1], -self.way[:, 0]])
        places = np.round(np.vstack([self.start, self.end]), 12)
        first, last = np.split(np.unique(places, axis=0, return_inverse=True)[1].ravel(), 2)
        _, there, here = np.intersect1d(first, last, return_indices=True)
        cosine = np.einsum("nk,nk->n", right[here], right[there])[:, None]
        mitre, ends = (right[here] + right[there]) / np.maximum(1.0 + cosine, 0.5), (right.copy(), right.copy())
        ends[0][there], ends[1][here] = (np.where(cosine > -0.5, mitre, right[k]) for k in (there, here))
        found = []
        for (out, share), (up, part) in product(*(zip(*rule, strict=True) for rule in (across, through))):
            start, end = (
                place + 0.5 * np.column_stack([out * self.width[:, None] * aside, up * self.thickness])
                for place, aside in zip((self.start, self.end), ends, strict=True)
            )
            found.append((TrackBars(start, end, self.width, self.thickness), share * part))
        return found


def coil_lines(coil: Coil, windings: str = "rings") -> list[tuple[Array, float]]:
    """Return the centre lines of a coil's tracks, each with its width [m], in the order of a positive current.

    Polylines (m, 3) in the scene. Closed turns end where they begin. "spiral" is the true path of round coils; as
    "rings" their turns are polygons.
    """
    if coil.shape == "path":
        lines = list(map(np.array, coil.path))
    elif coil.is_round and windings == "spiral":
        lines = spiral_path(coil)
    elif coil.is_round:
        angle = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)
        rings = coil_sections(coil)
        out = rings.radius * outside(np.pi / _ROUND)
        turns = zip(out, rings.z, rings.signs, strict=True)
        lines = [
            np.column_stack([r * np.cos(angle), s * r * np.sin(angle), np.full(angle.size, z)]) for r, z, s in turns
        ]
    else:
        ways = coil.directions or (1,) * coil.layers
        lines = [
            np.column_stack([line[::way], np.full(len(line), z)])
            for z, way in zip(coil.heights, ways, strict=True)
            for line in _turns(coil)
        ]
    widths = coil.widths or (coil.track_width,) * len(lines)  # a path alone has widths of its own
    return [(line + (*coil.centre, 0.0), width) for line, width in zip(lines, widths, strict=True)]


@lru_cache(maxsize=256)
def coil_tracks(coil: Coil, windings: str = "rings") -> TrackBars:
    """Return the straight tracks of a coil in the scene, as `coil_lines`; kept for later."""
    lines = coil_lines(coil, windings)
    start, end = (np.vstack([line[some] for line, _ in lines]) for some in (slice(None, -1), slice(1, None)))
    width = np.concatenate([np.full(len(line) - 1, width) for line, width in lines])
    return TrackBars(start, end, width, np.full(len(start), coil.track_thickness))


def track_length(coil: Coil) -> float:
    """Return the length of a coil's track, all turns and layers [m]."""
    if coil.is_round:
        return float(2 * np.pi * turn_radii(coil).sum() * coil.layers)
    return float(coil_tracks(coil).length.sum())


def track_squares(coil: Coil) -> float:
    """Return the length of a coil's track over its width, summed along it; of rings as `ring_squares` [-]."""
    if coil.is_round:
        return float(coil.layers * ring_squares(turn_radii(coil), coil.track_width).sum())
    tracks = coil_tracks(coil)
    return float((tracks.length / tracks.width).sum())


def ring_squares(radius: Array, width: float | Array) -> Array:
    """Return ``2 pi / ln(b / a)`` of rings from a to b, whose steady current falls with the radius."""
    return np.pi / np.arctanh(width / (2 * radius))


def _turns(coil: Coil) -> list[Array]:
    """Return closed turns of one layer about the middle, counter-clockwise, innermost first; shape (m, 2) each."""
    pitch = coil.track_width + coil.track_gap
    each = (turn(coil, coil.track_width / 2 + k * pitch) for k in range(coil.turns))
    return [np.vstack([line, line[:1]]) for line in each]


def standing_rings(coil: Coil) -> Sections:
    """Return rings that stand for a coil far from it: of its turns, length, pitch and heights.

    Rings of a round coil are its own. Those of free tracks turn about the middle as often as the tracks of one height
    and way together, as far from it on the mean over the angle, and as far apart; where these turn by less than a half,
    one around all stands for the coil.
    """
    if coil.is_round:
        return coil_sections(coil)
    pitch, found = coil.track_width + coil.track_gap, []
    if coil.shape != "path":
        middle = track_length(coil) / coil.layers / (2 * np.pi * coil.turns)
        ways = coil.directions or (1,) * coil.layers
        found = [_rings(coil, (middle, coil.turns, pitch), z, way) for z, way in zip(coil.heights, ways, strict=True)]
    else:
        each = [(line[0][2], *_turning(np.array(line)[:, :2])) for line in coil.path]
        for z, way in dict.fromkeys((one[0], math.copysign(1.0, one[1])) for one in each):
            angle, first, second = np.sum([one[1:] for one in each if one[0] == z and one[1] * way >= 0.0], axis=0)
            if min(abs(angle), 2.0 * abs(first) / coil.track_width) >= np.pi:  # a line through the middle turns too
                count, middle = max(1, round(abs(angle) / (2 * np.pi))), first / angle
                pitch = math.sqrt(12.0 * max(second / angle - middle**2, 0.0) / max(count**2 - 1, 1))
                found.append(_rings(coil, (middle, count, pitch), z, way))
        found = found or [_rings(coil, ((coil.outer_diameter - coil.track_width) / 2, 1, 0.0), coil.heights[0], 1.0)]
    return Sections(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _rings(coil: Coil, turns: tuple[float, int, float], z: float, way: float) -> tuple[Array, ...]:
    """Return radii, heights, widths, thicknesses and directions of rings from their mean radius, number and pitch."""
    middle, count, pitch = turns
    middle = max(middle, 2 * coil.track_width / np.pi)  # of a square turn around a point
    pitch = min(pitch, 0.95 * (2 * middle - coil.track_width) / max(count - 1, 1))
    radius = middle + pitch * (np.arange(count) - (count - 1) / 2)
    return radius, *(np.full(count, value) for value in (z, coil.track_width, coil.track_thickness, way))


def _turning(places: Array) -> Array:
    """Return how far a polyline turns about the middle [rad], and that times its distance from there, and squared."""
    (x, y), (u, v) = places[:-1].T, places[1:].T
    angle, away = np.arctan2(x * v - y * u, x * u + y * v), np.hypot(x + u, y + v) / 2
    return np.array([angle.sum(), (away * angle).sum(), (away**2 * angle).sum()])


def path_notes(coils: Sequence[Coil]) -> tuple[Note, ...]:
    """Note how long what the free tracks of coils are without is: vias, and the way back between their ends."""
    found = []
    for coil in coils:
        if coil.shape == "path":
            ends = [(np.array(line[0]), np.array(line[-1])) for line in coil.path]
            vias = sum(float(np.linalg.norm(b[0] - a[1])) for a, b in pairwise(ends))
            back = float(np.linalg.norm(ends[0][0] - ends[-1][1]))
            found.append(Note.of(NoteKind.FREE_TRACKS, coil=coil.name, vias=vias, back=back))
    return tuple(found)


def section_refusal(coils: Sequence[Coil]) -> Refusal | None:
    """Return which coil has no section at y = 0 that stands for it, or one too large to hold; None if all have one."""
    for coil in coils:
        name, bars = f"coils.{coil.name}", 2 * coil.layers * coil.turns
        if beyond := beyond_memory(8.0 * _ARRAYS * bars**2):
            return Refusal(name, "have pairs of bars in the section y = 0 that memory holds", f"{bars} bars, {beyond}")
        if coil.shape != "path" and coil.centre[1] != 0.0:
            return Refusal(f"{name}.centre", "be on y = 0 for a section", f"y = {mm(coil.centre[1])}")
        if not coil.is_round and (refusal := _not_across(coil)):
            return refusal
    return None


def _not_across(coil: Coil) -> Refusal | None:
    """Return why tracks have no section at y = 0 that stands for them."""
    (tracks, cut, step, sign), name = crossing(coil), f"coils.{coil.name}"
    if not cut.any() or sign.sum() != 0.0:
        got = f"{int((sign > 0).sum())} and {int((sign < 0).sum())}"
        return Refusal(name, "have tracks that cross the section y = 0 as often there as back", got)
    if np.any(np.abs(step[:, 0]) > _STRAIGHT * np.abs(step[:, 1])) or np.ptp(tracks.width[cut]) > 0.0:
        return Refusal(name, "have tracks of one width that cross the section y = 0 at right angles", "others")
    return None


def crossing(coil: Coil) -> tuple[TrackBars, Mask, Array, Array]:
    """Return a coil's tracks, which of them cross y = 0, their steps [m], and along (1) or against y (-1)."""
    tracks = coil_tracks(coil)
    cut = (tracks.start[:, 1] < 0.0) != (tracks.end[:, 1] < 0.0)
    return tracks, cut, tracks.end[cut] - tracks.start[cut], np.sign(tracks.way[cut, 1])


def coil_bars(coil: Coil) -> Bars:
    """Return the bars that the section y = 0 cuts of a coil.

    ValueError where it does not cut tracks of one width at right angles, as many there as back.
    """
    if coil.is_round:
        rings = coil_sections(coil)
        x, signs = (np.concatenate([own, -own]) for own in (rings.radius, rings.signs))
        return Bars(coil.centre[0] + x, np.tile(rings.z, 2), signs, coil.track_width, coil.track_thickness)
    if refusal := _not_across(coil):
        raise ValueError(str(refusal))
    tracks, cut, step, sign = crossing(coil)
    x = tracks.start[cut, 0] - tracks.start[cut, 1] * step[:, 0] / step[:, 1]
    return Bars(x, tracks.start[cut, 2], sign, float(tracks.width[cut][0]), coil.track_thickness)


def check_frequency(coils: Sequence[Coil], frequency: float) -> None:
    """Refuse a frequency that is not positive or at which a track is as long as a wave in free space (ValueError)."""
    if not 0.0 < frequency < math.inf:
        raise ValueError(f"frequency: must be a positive number of hertz, got {frequency}")
    coil = max(coils, key=track_length)
    length = track_length(coil)
    if frequency * length > c:
        raise ValueError(
            f"frequency: must be below {c / length:.3g} Hz, where a wave is as long as the track of coil {coil.name} "
            f"({mm(length, 3)}), got {frequency:g} Hz; no model here holds waves: it takes a full-wave solver"
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
