"""Cut a sensor by a vertical plane: tracks, target and fixed plates as quadrilaterals along and up.

The plane has the direction (cos angle, sin angle) and the distance `offset` from the z axis, counted along (-sin angle,
cos angle): y = offset for the angle 0. Places in it are s along that direction and z. A ring of a coil is cut where

    s = s_0 +- sqrt(r^2 - d^2),    d = distance of the coil's axis from the plane,

not at all where r < |d|; a straight track where its ends lie on different sides, over its width along the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sits_mech.geometry.outline import fixed_loops, hull, target_outline
from sits_mech.geometry.tracks import coil_tracks
from sits_mech.geometry.windings import coil_sections
from sits_mech.quantities import Array, Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.parts.outlines import Loop, edges
from sits_mech.scene.sensor import Coil, Conductor, Sensor, Target


class Plane(NamedTuple):
    """A vertical plane: direction [rad] and distance from the z axis [m]."""

    angle: float = 0.0
    offset: float = 0.0

    @property
    def words(self) -> str:
        """Return its name: y = 0, or its direction."""
        if self.angle == 0.0:
            return f"y = {1e3 * self.offset:.4g}{' mm' if self.offset else ''}"
        return f"{np.degrees(self.angle):.3g}° from x"


FLAT = Plane()
"""The plane y = 0."""


def along_plane(places: Array, plane: Plane) -> tuple[Array, Array]:
    """Return s and distance from a plane of places (..., 2 or 3) [m]."""
    x, y = places[..., 0], places[..., 1]
    c, s = np.cos(plane.angle), np.sin(plane.angle)
    return np.asarray(c * x + s * y), np.asarray(c * y - s * x - plane.offset)


def coil_cut(coil: Coil, plane: Plane = FLAT, substrate_radius: float | None = None) -> tuple[Array, Array]:
    """Return corners (m, 4, 2) of the tracks that a plane cuts, as s and z [m], and the current's signs (m,).

    The sign is +1 where a positive current runs to the left of the plane's direction; the substrate is a cylinder along
    y.
    """
    if not coil.is_round:
        corners, sign = _straight_cut(coil, plane)
        return (corners if substrate_radius is None else _bent(corners, substrate_radius)), sign
    rings = coil_sections(coil)
    start, d = along_plane(np.array(coil.centre), plane)
    outer, inner = (np.sqrt(np.maximum((rings.radius + k * rings.width / 2) ** 2 - d**2, 0.0)) for k in (1, -1))
    cut = outer > 0.0
    low, high = (rings.z + k * rings.height / 2 for k in (-1, 1))
    sides = boxes(start + inner, start + outer, low, high), boxes(start - outer, start - inner, low, high)
    corners = np.concatenate([side[cut] for side in sides])
    if substrate_radius is not None:
        corners = _bent(corners, substrate_radius)
    sign = rings.signs[cut]
    return corners, np.concatenate([sign, -sign])


def _straight_cut(coil: Coil, plane: Plane) -> tuple[Array, Array]:
    """Return corners and signs of the straight tracks that a plane cuts."""
    tracks = coil_tracks(coil)
    (s_a, d_a), (s_b, d_b) = along_plane(tracks.start, plane), along_plane(tracks.end, plane)
    cut = (d_a > 0.0) != (d_b > 0.0)
    across = (d_b - d_a)[cut]
    middle = s_a[cut] - d_a[cut] * (s_b - s_a)[cut] / across
    half = tracks.width[cut] / 2 * tracks.length[cut] / np.abs(across)
    low, high = (tracks.start[cut, 2] + k * tracks.thickness[cut] / 2 for k in (-1, 1))
    return boxes(middle - half, middle + half, low, high), np.sign(across)


def boxes(left: Array, right: Array, low: Array | float, high: Array | float) -> Array:
    """Return the corners of boxes between ends along (m,) and up, shape (m, 4, 2)."""
    left, right, low, high = np.broadcast_arrays(left, right, low, high)
    return np.stack([left, low, right, low, right, high, left, high], axis=-1).reshape(-1, 4, 2)


def _bent(places: Array, radius: float) -> Array:
    """Return places (..., 2) of a flat section as they stand on a cylinder below."""
    angle, out = places[..., 0] / radius, radius + places[..., 1]
    return np.stack([out * np.sin(angle), out * np.cos(angle) - radius], axis=-1)


def names_cut(sensor: Sensor, plane: Plane = FLAT) -> tuple[list[str], list[str]]:
    """Return the names of the coils that a plane cuts, and of the others."""
    found: tuple[list[str], list[str]] = ([], [])
    for coil in sensor.coils:
        found[len(coil_cut(coil, plane)[0]) == 0].append(coil.name)
    return found


def target_cut(target: Target, pose: Pose, plane: Plane = FLAT) -> Array:
    """Return the target's pieces (k, 4, 2) along a plane that cut it before it moved [m], seen across the plane.

    Corners go counter-clockwise from the bottom left.
    """
    pieces = chords(target_outline(target).loops, plane)
    c, s = np.cos(plane.angle), np.sin(plane.angle)
    ends = pieces[:, [0, 1, 1, 0]]
    up = np.broadcast_to([0.0, 0.0, target.thickness, target.thickness], ends.shape)
    body = np.stack([c * ends - s * plane.offset, s * ends + c * plane.offset, up], axis=-1)
    moved = target_points(body.reshape(-1, 3), pose).reshape(*ends.shape, 3)
    return np.stack([along_plane(moved, plane)[0], moved[..., 2]], axis=-1)


def target_points(points: Array, pose: Pose) -> Array:
    """Return points of the target's own axes, from its bottom face's centre, in the scene; shape (n, 3) [m]."""
    return points @ rotation_matrix(pose.rotation).T + pose.centre


def conductor_cut(part: Conductor, plane: Plane) -> Array:
    """Return the pieces of a fixed plate that a plane cuts, (k, m, 2); of one that ends in it without holes [m]."""
    faces, rims = [_crossings(fixed_loops(part, up), plane) for up in (-1.0, 1.0)], [fixed_loops(part, -1.0)[0]]
    if len(faces[0]) == len(faces[1]) > 0:
        axis = int(np.argmax(np.ptp(np.vstack(faces), axis=0)))
        low, high = (face[np.argsort(face[:, axis])].reshape(-1, 2, 2) for face in faces)
        return np.concatenate([low, high[:, ::-1]], axis=1)
    rims.append(fixed_loops(part, 1.0)[0])  # one that stands along the plane, or ends in it
    upright = _crossings([np.array(pair) for pair in zip(*rims, strict=True)], plane, closed=False)
    corners = np.vstack([*faces, upright])
    return hull(corners)[None] if len(corners) > 2 else np.zeros((0, 4, 2))


def _crossings(lines: Sequence[Array], plane: Plane, closed: bool = True) -> Array:
    """Return where lines (m, 3), closed or not, cross a plane, along it and up, shape (k, 2) [m]."""
    a, b = edges(lines) if closed else (np.array([line[k] for line in lines]) for k in (0, 1))
    d_a, d_b = (along_plane(ends, plane)[1] for ends in (a, b))
    crossed = (d_a > 0.0) != (d_b > 0.0)
    share = (d_a[crossed] / (d_a - d_b)[crossed])[:, None]
    places = a[crossed] + share * (b - a)[crossed]
    return np.column_stack([along_plane(places, plane)[0], places[:, 2]])


def chords(loops: Sequence[Loop | Array], plane: Plane) -> Array:
    """Return from where to where a plane is within an outline with holes, shape (k, 2) [m]."""
    a, b = edges([np.array(loop) for loop in loops])
    (s_a, d_a), (s_b, d_b) = along_plane(a, plane), along_plane(b, plane)
    crossed = (d_a > 0.0) != (d_b > 0.0)
    share = d_a[crossed] / (d_a - d_b)[crossed]
    return np.sort(s_a[crossed] + share * (s_b - s_a)[crossed]).reshape(-1, 2)
