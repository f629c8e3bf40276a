"""What do the free faces of a layer do: do they lie on the ground, rise at the target, touch themselves?

Read off the deformed nodes and the contacts' energy. Where contact is solved, a face lies on its plane within the
length over which the contact gives; where it is not, it may have gone through. Self-contact and the target's top face
are solved nowhere: they are found here and named.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.mechanics.body import Bonded, State
from sits_mech.mechanics.contact import Contact
from sits_mech.mechanics.pad import side_faces, top_faces
from sits_mech.quantities import Array

_SEEN = 1e-6  # thicknesses behind a plane that count
_PRESSED = 1e-14  # energy of a contact that counts [shear modulus times thickness squared]


@dataclass(frozen=True)
class Folds:
    """Where the free faces are.

    Attributes
    ----------
    ground, target, walls : bool
        Whether a face is on or behind the ground, the bottom face of a target flush with the layer, the sides of a
        narrower one.
    rise : float
        How far a face that is at the target's sides stands above the target's bottom face [thicknesses].
    itself : bool
        Whether a face crosses itself or another one.
    """

    ground: bool
    target: bool
    walls: bool
    rise: float
    itself: bool

    @property
    def touch(self) -> bool:
        """Whether a plane is touched at all."""
        return self.ground or self.target or self.walls


def folds(body: Bonded, state: State) -> Folds:
    """Return where the free faces of a deformed layer are."""
    half = float(body.X.max())
    place = body.mesh.nodes + state.u[: body.mesh.nodes.size].reshape(-1, 2)
    sides, top = side_faces(body.mesh), top_faces(body.mesh, half)
    cos, sin = np.cos(state.q[2]), np.sin(state.q[2])
    x, z = (place - [state.q[0], 1.0 + state.q[1]]).T
    along, above = x * cos - z * sin, x * sin + z * cos
    inner = np.concatenate([face[1:-1] for face in sides])
    pressed = {
        part.plane for part in body.parts if isinstance(part, Contact) and part(state.u, state.q).energy > _PRESSED
    }
    ground = "ground" in pressed or bool(np.any(place[inner, 1] < -_SEEN))
    if not top:
        target = "plane" in pressed or bool(np.any(above[inner] > _SEEN))
        return Folds(ground, target, False, 0.0, _crossing([place[face] for face in sides]))
    beside = np.concatenate([face[1:] for face in top])
    inside = (np.abs(along[beside]) < half - _SEEN) & (above[beside] > _SEEN)
    rise = float(above[beside][inside].max()) if inside.any() else 0.0
    whole = [np.concatenate([place[side], place[face[::-1]][1:]]) for side, face in zip(sides, top, strict=True)]
    return Folds(ground, False, "wall" in pressed or bool(inside.any()), rise, _crossing(whole))


def fold_notes(body: Bonded, state: State, plate: float) -> tuple[str, ...]:
    """Return sentences about the free faces.

    Parameters
    ----------
    body : Bonded
    state : State
    plate : float
        Thickness of the target [thicknesses].
    """
    return fold_words(folds(body, state), plate, any(isinstance(part, Contact) for part in body.parts))


def fold_words(found: Folds, plate: float, solved: bool) -> tuple[str, ...]:
    """Return sentences about what free faces do under a target of thickness `plate`, their contact `solved` or not."""
    names = {
        "the ground": found.ground,
        "the target's plane, taken to go on beyond it": found.target,
        "the target's sides": found.walls,
    }
    begin, end = ("folds onto", "its contact is not in this answer, the true layer is stiffer")
    if solved:
        begin, end = "lies on", "frictionless contact"
    notes = [f"a free face {begin} {name}: {end}" for name, own in names.items() if own]
    if found.walls and found.rise > plate:
        notes.append("silicone rises above the target's top face: its sides are taken to go on upwards")
    if found.itself:
        notes.append("a free face touches itself: that contact is not solved, the true layer is stiffer")
    return tuple(notes)


def _crossing(lines: list[Array]) -> bool:
    """Whether any two segments of some open lines cross, neighbours apart."""
    start = np.concatenate([line[:-1] for line in lines])
    way = np.concatenate([np.diff(line, axis=0) for line in lines])
    number = np.concatenate([np.arange(len(line) - 1) + 10 * k * len(line) for k, line in enumerate(lines)])
    between = start[None, :, :] - start[:, None, :]

    def cross(a: Array, b: Array) -> Array:
        return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])

    det = cross(way[:, None, :], way[None, :, :])
    det = np.where(np.abs(det) > 1e-14, det, np.inf)
    s, t = cross(between, way[None, :, :]) / det, cross(between, way[:, None, :]) / det
    apart = np.abs(number[:, None] - number[None, :]) > 1
    return bool(np.any((s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0) & apart))
