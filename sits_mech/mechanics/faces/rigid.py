"""What presses on the free face of a cover: a rigid shape, whose surface is one of contact.py, or a pressure.

A shape is a core, grown by a radius e on all sides, that goes on upwards without end: a point for a sphere, a line for
a cylinder, a rectangle or a disc for a flat punch whose edge is rounded by e. With y the place from the lowest point,
c the half sizes of the core, or its radius, and

    w = (|y_1| - c_1, |y_2| - c_2, e - y_3),    or    (|(y_1, y_2)| - c, e - y_3),

a point lies below the surface, along its normal, by

    d = e - |max(w, 0)|   outside of the core,      e - max_i w_i   in it.

A pressure is a dead load on an area A of the face at rest: each of its points keeps dF = F dA/A while the face moves.
Its edge crosses faces of the mesh, which close points resolve.

A shape is guided, free of friction, above a place (x, y), under a force F; its height s, of the lowest point above the
face at rest, is one more unknown, with one more equation

    d(energy)/ds + F = 0.

Lengths in thicknesses of the pad, forces in shear moduli times their square.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.mechanics.element.assembly import Term
from sits_mech.mechanics.element.target import all_six
from sits_mech.mechanics.faces.contact import Contact, Jet, pressure
from sits_mech.mechanics.faces.surface import Surface
from sits_mech.quantities import Array
from sits_mech.scene.parts.touch import Touch
from sits_mech.units import SLACK

_NOWHERE = PlateOutline(0.0, 0.0, False)
_TRIED = (0.1, 0.3, 0.6, 0.9)  # of the room: depths that are tried until the shape presses harder than the load
_SOFT, _STEP = 0.01, 10.0  # first contact depth, over the room; each over the next


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
        n = np.where(outside[:, None], out / np.maximum(size, SLACK)[:, None], w == w.max(axis=1, keepdims=True))
        bent = (slope.swapaxes(1, 2) * (out > 0.0)[:, None]) @ slope / np.maximum(size, SLACK)[:, None, None]
        along = np.einsum("mi,mij->mj", n, slope)
        bent -= outside[:, None, None] * along[:, :, None] * along[:, None, :] / np.maximum(size, SLACK)[:, None, None]
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
        away = np.maximum(np.linalg.norm(y[:, :2], axis=1), SLACK)
        n = y[:, :2] / away[:, None]
        w[:, 0], slope[:, 0, :2] = away - self.core[0], n
        curvature[:, 0, :2, :2] = (np.eye(2) - n[:, :, None] * n[:, None, :]) / away[:, None, None]
        return w, slope, curvature


@dataclass(frozen=True, eq=False)
class Press:
    """What presses on the top of a cover, and the faces that it may meet.

    Loads are those on a target about the middle of its top face: a force F_z with moments that say where it presses,
    ``x = M/F_z, y = -M_x/F_z``.
    """

    touch: Touch  # at rest in the middle
    surface: Surface  # the cover's top
    points: Surface  # the same face with more points, for a pressure
    depth: float  # of contact [thicknesses]
    top: float  # height of that face [thicknesses]
    room: float  # how deep a shape may go: to the target, or as deep as it is round [thicknesses]
    thickness: float  # of the pad [m]

    @property
    def depths(self) -> tuple[float, ...]:
        """Depths of contact on the way to its own, by which a shape is let in."""
        found = [_SOFT * self.room]
        while found[-1] > 2.0 * _STEP * self.depth:
            found.append(found[-1] / _STEP)
        return (*found, self.depth)

    def meets(self, load: Array) -> bool:
        """Whether a shape presses by a load: its height is unknown."""
        return self.touch.shape != "pressure" and bool(load[1] > 0.0)

    def __call__(self, u: Array, load: Array, height: float) -> Term:
        """Return the energy of contact less the load's work, with the forces on displacements, q and the height."""
        if not self.meets(load):
            return self._pressure(u, load)
        place, numbers = self._place(load), len(u) + 6
        found = Contact(self.surface, "shape", self.depth, _NOWHERE, shape=self._shape(place, height))(u, np.zeros(6))
        found.forces[numbers] += load[1]
        return found._replace(energy=found.energy + float(load[1]) * height)

    def height(self, u: Array, load: Array) -> float:
        """Return the height at which the shape carries a load on a face held at u; nan without a shape."""
        if not self.meets(load):
            return math.nan
        from scipy.optimize import brentq

        points, weight = self.surface.places(u).reshape(-1, 3), self.surface.weight.ravel()

        def left(height: float) -> float:
            """Return what is left of the force at a height."""
            d, slope, _ = self._shape(self._place(load), height)(points)
            return float(weight @ (pressure(d / self.depth)[1] * slope[:, 2])) - float(load[1])

        below = next((-part * self.room for part in _TRIED if left(-part * self.room) > 0.0), None)
        return math.nan if below is None else float(brentq(left, below, self.room))

    def _pressure(self, u: Array, load: Array) -> Term:
        """Return the term of a pressure, which has no stiffness."""
        (F_x, F_z, _, F_y, _, _), points = all_six(load), self.points
        half = np.maximum(np.abs(self.touch.border).max(axis=0) / self.thickness, SLACK)
        away = np.abs(points.rest[..., :2] - (self._place(load) if F_z else 0.0))
        across = np.hypot(*np.moveaxis(away, -1, 0)) / half[0] if self.touch.diameter else (away / half).max(axis=-1)
        inside = across <= 1.0
        weight = points.weight * inside
        share = np.einsum("fp,fpk->fk", weight / max(float(weight.sum()), SLACK), points.shape)
        on_nodes = np.zeros((points.size, len(points.axes)))
        np.add.at(on_nodes, points.nodes, share[..., None] * np.array([F_x, F_y, -F_z])[list(points.axes)])
        numbers = self.surface.numbers_of_shape
        forces = np.concatenate([-on_nodes.ravel(), np.zeros(8)])
        return Term(float(forces[: len(u)] @ u), forces, numbers, np.zeros((*numbers.shape, numbers.shape[1])))

    def _place(self, load: Array) -> tuple[float, float]:
        """Return where a load presses."""
        whole = all_six(load)
        return float(whole[2] / whole[1]), float(-whole[4] / whole[1])

    def _shape(self, place: tuple[float, float], height: float) -> Rigid:
        """Return the shape above a place."""
        touch, t, lowest = self.touch, self.thickness, (*place, self.top + height)
        if touch.shape == "sphere":
            return Rigid((0.0,), (touch.radius or 0.0) / t, lowest)
        if touch.shape == "cylinder":
            return Rigid((math.inf, 0.0) if touch.axis == "x" else (0.0, math.inf), (touch.radius or 0.0) / t, lowest)
        e = (touch.edge_radius or 0.0) / t
        half = np.abs(touch.border).max(axis=0) / t - e
        return Rigid((float(half[0]),) if touch.diameter else (float(half[0]), float(half[1])), e, lowest)
