"""What presses on the free face of a cover: a rigid shape, whose surface is one of contact.py, or a pressure.

A shape is a core, grown by a radius e on all sides, that goes on upwards without end: a point for a sphere, a line for
a cylinder, a rectangle or a disc for a flat punch whose edge is rounded by e. With y the place from the lowest point,
c the half sizes of the core, or its radius, and

    w = (|y_1| - c_1, |y_2| - c_2, e - y_3),    or    (|(y_1, y_2)| - c, e - y_3),

a point lies below the surface, along its normal, by

    d = e - |max(w, 0)|   outside of the core,      e - max_i w_i   in it.

A pressure is a dead load on an area A of the face at rest: each of its points keeps dF = F dA/A while the face moves.

The force of a shape is that on all points, F = sum d(energy)/du_z; it is guided, free of friction, above a place (x, y).
Lengths in thicknesses of the pad.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from sits_mech.mechanics.element.assembly import Term
from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.mechanics.faces.contact import Contact, Jet, pressure
from sits_mech.mechanics.faces.surface import Surface
from sits_mech.quantities import Array, Integers
from sits_mech.scene.touch import Touch

NOWHERE = PlateOutline(0.0, 0.0, False)
_FAR = 1e9  # thicknesses, half the length of a cylinder that goes on beyond the cover
_TRIED = (0.1, 0.3, 0.6, 0.9)  # of the room, where a shape is expected to press more
_TINY, _TOUCHING = 1e-12, 1e-12  # lengths that are divided by; a force by which a shape touches


@dataclass(frozen=True)
class Rigid:
    """A rigid shape at a place; called with points (m, 3), it says how deep they lie in it."""

    core: tuple[float, ...]  # half sizes along x and y, or one radius [thicknesses]
    radius: float  # e
    lowest: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __call__(self, places: Array) -> Jet:
        """Return d with slope and curvature."""
        y = places - self.lowest
        w, slope, curvature = self._beyond(y)
        out = np.maximum(w, 0.0)
        size = np.linalg.norm(out, axis=1)
        outside = size > 0.0
        n = np.where(outside[:, None], out / np.maximum(size, _TINY)[:, None], w == w.max(axis=1, keepdims=True))
        bent = (slope.swapaxes(1, 2) * (out > 0.0)[:, None]) @ slope / np.maximum(size, _TINY)[:, None, None]
        along = np.einsum("mi,mij->mj", n, slope)
        bent -= outside[:, None, None] * along[:, :, None] * along[:, None, :] / np.maximum(size, _TINY)[:, None, None]
        bent += np.einsum("mi,mijk->mjk", n, curvature)
        return self.radius - np.where(outside, size, w.max(axis=1)), -along, -bent

    def _beyond(self, y: Array) -> Jet:
        """Return w (m, i) with slope (m, i, 3) and curvature (m, i, 3, 3)."""
        m, k = len(y), len(self.core) + 1
        w, slope, curvature = np.zeros((m, k)), np.zeros((m, k, 3)), np.zeros((m, k, 3, 3))
        w[:, -1], slope[:, -1, 2] = self.radius - y[:, 2], -1.0
        if k == 3:
            w[:, :2] = np.abs(y[:, :2]) - self.core
            slope[:, [0, 1], [0, 1]] = np.sign(y[:, :2])
            return w, slope, curvature
        away = np.maximum(np.linalg.norm(y[:, :2], axis=1), _TINY)
        n = y[:, :2] / away[:, None]
        w[:, 0], slope[:, 0, :2] = away - self.core[0], n
        curvature[:, 0, :2, :2] = (np.eye(2) - n[:, :, None] * n[:, None, :]) / away[:, None, None]
        return w, slope, curvature


@dataclass(frozen=True, eq=False)
class DeadLoad:
    """Forces on nodes of a surface that stay as they are."""

    forces: Array  # (d n,)
    numbers: Integers  # of the surface, as those of a contact there

    def __call__(self, u: Array, q: Array) -> Term:
        """Return their energy and what they leave on the nodes; they have no stiffness."""
        none = np.zeros((*self.numbers.shape, self.numbers.shape[1]))
        return Term(-float(self.forces @ u), np.concatenate([-self.forces, np.zeros(6)]), self.numbers, none)


@dataclass(frozen=True, eq=False)
class Press:
    """What presses on the top of a cover, and the faces that it may meet."""

    touch: Touch  # at rest in the middle
    surface: Surface  # the cover's top
    points: Surface  # the same, closer points, of a pressure
    depth: float  # of contact [thicknesses]
    top: float  # height of that face [thicknesses]
    room: float  # how deep a shape may go: to the target, or as deep as it is round [thicknesses]
    thickness: float  # of the pad [m]

    @property
    def touches(self) -> bool:
        """Whether it is a shape, whose contact is solved, and not a pressure."""
        return self.touch.shape != "pressure"

    def contact(self, place: tuple[float, float], sunk: float) -> Contact:
        """Return the contact of a shape above a place whose lowest point is so far below the face at rest."""
        return Contact(self.surface, "shape", self.depth, NOWHERE, shape=self._shape((*place, self.top - sunk)))

    def force(self, contact: Contact, u: Array, q: Array) -> float:
        """Return the force of a shape in a state."""
        on_nodes = contact(u, q).forces[: u.size]
        return float(on_nodes.reshape(-1, len(self.surface.axes))[:, -1].sum())

    def load(self, place: tuple[float, float], force: Array) -> DeadLoad:
        """Return the forces (x, y, z) of a pressure on its area about a place."""
        points, half = self.points, np.abs(self.touch.border).max(axis=0) / self.thickness
        away = np.abs(points.rest[..., :2] - place)
        inside = np.hypot(*np.moveaxis(away, -1, 0)) <= half[0] if self.touch.diameter else np.all(away <= half, axis=-1)
        weight = points.weight * inside
        each = np.einsum("fp,fpk->fk", weight / max(float(weight.sum()), _TINY), points.shape)
        axes = list(points.axes)
        found = np.zeros((points.size, len(axes)))
        np.add.at(found, points.nodes, each[..., None] * force[axes])
        return DeadLoad(found.ravel(), self.surface.numbers)

    def sunk(self, place: tuple[float, float], u: Array, force: float) -> float:
        """Return how deep a shape stands that presses by a force on a face displaced by u, which stays."""
        points = self.surface.places(u).reshape(-1, 3)
        weight, shape = self.surface.weight.ravel(), self._shape((*place, self.top))

        def left(sunk: float) -> float:
            """Return what is left of the force at a depth."""
            d, slope, _ = replace(shape, lowest=(*place, self.top - sunk))(points)
            return float(weight @ (pressure(d / self.depth)[1] * slope[:, 2])) - max(force, _TOUCHING)

        above = next((part * self.room for part in _TRIED if left(part * self.room) > 0.0), None)
        return 0.0 if above is None else float(brentq(left, -self.room, above))

    def _shape(self, lowest: tuple[float, float, float]) -> Rigid:
        """Return the shape with its lowest point at a place."""
        touch, t = self.touch, self.thickness
        if touch.shape == "sphere":
            return Rigid((0.0,), (touch.radius or 0.0) / t, lowest)
        if touch.shape == "cylinder":
            return Rigid((_FAR, 0.0) if touch.axis == "x" else (0.0, _FAR), (touch.radius or 0.0) / t, lowest)
        e = (touch.edge_radius or 0.0) / t
        half = np.abs(touch.border).max(axis=0) / t - e
        return Rigid((float(half[0]),) if touch.diameter else (float(half[0]), float(half[1])), e, lowest)
