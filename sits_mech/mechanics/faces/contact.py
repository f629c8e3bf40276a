"""Keep the free faces of a layer off the ground and the target: a part of its energy.

A point at depth d behind a rigid surface is pressed back, per reference area, with

    p(d) = mu (d/h)**2/2    up to d = h,        mu (d/h - 1/2)    beyond,        p(d <= 0) = 0,

the derivative of an energy phi(d): forces, tangent, work and moments stay exact. True contact has no depth; the answer
is off by O(h), h the contact depth. The mesh of the error estimate takes twice of it, so that the estimate holds it.
With y = (a, e, b) the place in the target's frame, a and e along its bottom face from the centre and b above it,
lengths in thicknesses:

    ground      d = -z
    shape       d = depth below the surface of a rigid shape that moves up and down alone (rigid.py), on a cover's top
    plane       d = b, on faces under the target; the plane goes on beyond it
    wall        d = depth inside the target's outline, and phi(d) s(b), on faces beside the target: s rises smoothly
                from 0 at b = 0, the edge, to 1 a little above

The outline is a rectangle whose corners are rounded with a small radius r, or a disc, which is one with r its own; of a
section it has no ends along y:

    d = r - |max(w, 0)| - min(max(w_1, w_2), 0),        w = (|a| - half_x + r, |e| - half_y + r).

The target stands at c and is turned by R: y = R^T r, r = x - c. With g and H the slope and curvature of the energy in
y, and h = R g, a point x, the target's centre and its turning on by a small w (from the left) are pushed with

    A^T h,    A = (1, -1, [r]),        dy = R^T A (dx, dc, w),        [r] w = r x w,

and since dh = R H dy + w x h, the stiffness in (x, c, w) is

    A^T R H R^T A  -  A^T [h] e_w^T  +  e_w [h] (1, -1, 0),         e_w = (0, 0, 1)^T,

which is not symmetric in w alone, where w has three components: finite turns do not commute. In the plane it is.

Unknowns: nodal displacements and the target's motion; energies in shear modulus times thickness to the power of the
dimension. Source: P. Wriggers, Computational Contact Mechanics (2006), chapter 6. Friction is one more energy in y, of
one increment of a load path; without a coefficient there is none. Neglected: adhesion, the target's top face (its sides
go on upwards). Faces that touch each other: folds.py; those of half a pad that meet their own image meet in the plane
of symmetry, which is one more plane, d = level - y, "mirror", and has no friction.

Friction is Coulomb's on points of a free face along a rigid surface, in one increment of a path. With y the place of a
point in the surface's own frame (the ground's, or the target's), n the surface's normal and p the pressure there, a
traction tau along the surface, per reference area, holds the point back:

    |tau| <= f p,        slip only where |tau| = f p, and then along tau,        f the coefficient.

It depends on the way there. An increment goes from a state with places y_0 and tractions tau_0 to the next one. The
point hangs on an anchor by a short elastic slip s, up to s_0, and its energy per area is, x = |s|/s_0,

    D(y) = f p s_0 x**2/2    up to x = 1,        f p s_0 (x - 1/2)    beyond,
    s = (1 - n n^T)(y - y_0) + s_e,        tau = dD/dy = f p x s/|s|,    f p s/|s| beyond,

which has a symmetric tangent that is nowhere negative. The slip s_e at the beginning is that whose traction is tau_0,
cut to what the pressure allows,

    s_e = s_0 min(1, |tau_0|/(f p)) tau_0/|tau_0|,

so that a point that is pressed harder sticks where it is, and one that is let go of slips. What goes on to the next
increment is tau: beyond s_0 the anchor has been dragged along, and the work of that, f p (|s| - s_0), is lost. The
pressure stands still while the increment is solved, and is taken from its end, pass by pass
(equilibrium/increments.py).

A potential of each increment, rather than Coulomb's equations, keeps tangents symmetric, for passes over the pressure.
The bend of D at x = 1 stays: all points are stiff at the beginning of an increment, also those that slipped and turn
back. An elastic slip of one length, not one stiffness, makes points stick where they are hardly pressed. Tractions are
carried, not slips: pressing changes none. Neglected: what s_0 lets a point creep, O(s_0), like the depth of contact;
another coefficient at rest; friction of faces on each other.

Sources: the same, chapters 4 and 10; M. Li et al., ACM Trans. Graph. 39 (2020) 49, section 5, the potential with the
pressure of before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.mechanics.element.assembly import Term
from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.target import placed
from sits_mech.mechanics.faces.surface import Surface
from sits_mech.quantities import Array, Integers
from sits_mech.rotations import cross_matrix

Plane = Literal["ground", "plane", "wall", "mirror", "shape"]
Jet = tuple[Array, Array, Array]
"""A function at m points: value (m,), slope (m, k) and curvature (m, k, k) in k variables."""

_RISE = 0.02  # thicknesses above the target's edge over which its side wall sets in
_CORNER = 0.05  # thicknesses of radius at a rectangle's vertical corners
_TINY = 1e-300  # in place of a length or force of zero that is divided by
_SLIPS = 1.0 + 1e-9  # x of points that slip: those that slipped before begin an increment at 1


@dataclass(frozen=True)
class Contact:
    """Free faces before a rigid surface.

    `plane`: "ground", "plane" (the target's), "wall" (the target's sides), "mirror" (the plane of symmetry) or "shape",
    one that presses on a cover and has a height of its own (rigid.py).
    """

    surface: Surface
    plane: Plane
    depth: float  # over which the pressure builds up [thicknesses]
    plate: PlateOutline  # half sizes of the target [thicknesses]
    level: float = 0.0  # y of the plane of symmetry [thicknesses]
    friction: float = 0.0  # coefficient
    grip: Grip | None = None  # friction in one increment of a path; None: points slip freely
    shape: Callable[[Array], Jet] | None = None  # how deep points (m, 3) lie in a shape

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the contact at displacements `u` and the target's motion `q`."""
        faces, (on, energy, forces, stiffness) = self.surface, self._pushed(u, q)
        numbers = faces.numbers if self.shape is None else faces.numbers_of_shape
        whole = np.zeros((*numbers.shape, numbers.shape[1]))
        whole[on] = stiffness
        return Term(energy, summed(numbers[on], forces, len(u) + (6 if self.shape is None else 8)), numbers, whole)

    def _pushed(self, u: Array, q: Array) -> tuple[Integers, float, Array, Array]:
        """Return which faces are pushed; energy, forces (f, d k + 6), stiffnesses on displacements and q."""
        faces, held = self.surface, self.plane in ("ground", "mirror")
        r, R = self._frame(u, q)
        f, p, _ = faces.shape.shape
        y = (r @ R).reshape(-1, 3)
        jet = pressed(*self._depths(y))
        on = np.flatnonzero(jet[0].reshape(f, p).any(axis=1))
        if self.grip is not None:
            more = self.grip(y)
            jet = jet[0] + more[0], jet[1] + more[1], jet[2] + more[2]
            on = np.flatnonzero(jet[2].reshape(f, -1).any(axis=1))
        energy, g, H = (each.reshape(f, p, *each.shape[1:]) for each in jet)
        h, bent = g[on] @ R.T, R @ H[on] @ R.T
        A = np.zeros((len(on), p, 3, 9))
        A[..., :3] = np.eye(3)
        stiffness = np.zeros((len(on), p, 9, 9))
        if self.shape is not None:
            A[..., 2, 5] = -1.0  # it rises
        elif not held:
            A[..., 3:6], A[..., 6:] = -np.eye(3), cross_matrix(r[on])
            twist = cross_matrix(h)
            stiffness[..., 6:] -= A.swapaxes(-1, -2) @ twist
            stiffness[..., 6:, :3] += twist
            stiffness[..., 6:, 3:6] -= twist
        stiffness += A.swapaxes(-1, -2) @ bent @ A
        spread = faces.spread[on]
        weight, across = faces.weight[on], spread.reshape(len(on), 9 * p, spread.shape[-1])
        forces = (weight[..., None, None] * (h[..., None, :] @ A)).reshape(len(on), 1, 9 * p) @ across
        stiffness = ((weight[..., None, None] * stiffness) @ spread).reshape(across.shape)
        return on, float((weight * energy[on]).sum()), forces[:, 0], across.swapaxes(1, 2) @ stiffness

    def looked_at(self, u: Array, q: Array) -> tuple[Array, Array, Array]:
        """Return places of points in the surface's frame, pressures [shear moduli], normals into the surface."""
        r, R = self._frame(u, q)
        y = (r @ R).reshape(-1, 3)
        depth, reach, above = self._depths(y)
        share = 1.0 if above is None else _risen(above[0])[0]
        normal = depth[1] / np.maximum(np.linalg.norm(depth[1], axis=1), 1e-12)[:, None]
        return y, pressure(depth[0] / reach)[1] * share, normal

    def _frame(self, u: Array, q: Array) -> tuple[Array, Array]:
        """Return places of points from the surface's origin, shape (f, p, 3), and the rotation of its frame."""
        place = self.surface.places(u)
        if self.plane in ("ground", "mirror", "shape"):
            return place, np.eye(3)
        centre, turn = placed(q)
        return place - centre - (0.0, 0.0, 1.0), turn

    def _depths(self, y: Array) -> tuple[Jet, float, Jet | None]:
        """Return the arguments of `pressed` at points, (x, y, z) before the ground, (a, e, b) before the target."""
        if self.shape is not None:
            return self.shape(y), self.depth, None
        if self.plane == "ground":
            return _linear(-y[:, 2], (0.0, 0.0, -1.0)), self.depth, None
        if self.plane == "mirror":
            return _linear(self.level - y[:, 1], (0.0, -1.0, 0.0)), self.depth, None
        above = _linear(y[:, 2], (0.0, 0.0, 1.0))
        if self.plane == "plane":
            return above, self.depth, None
        return _depth_inside(self.plate, y), self.depth, above


def pressure(d: Array) -> tuple[Array, Array, Array]:
    """Return energy, pressure and its slope at depths in units of the contact depth."""
    d = np.maximum(d, 0.0)
    small = d < 1.0
    energy = np.where(small, d**3 / 6.0, 0.5 * d**2 - 0.5 * d + 1.0 / 6.0)
    return energy, np.where(small, 0.5 * d**2, d - 0.5), np.where(small, d, 1.0)


def pressed(depth: Jet, reach: float, above: Jet | None = None) -> Jet:
    """Return the energy per area at a depth jet [thicknesses], phi(d), or phi(d) s(b) above a wall's edge.

    `reach` is the contact depth [thicknesses]; `above` is b, in the same variables as `depth`.
    """
    phi, p, k = pressure(depth[0] / reach)
    phi, k = phi * reach, k / reach
    square = depth[1][:, :, None] * depth[1][:, None, :]
    if above is None:
        return phi, p[:, None] * depth[1], k[:, None, None] * square + p[:, None, None] * depth[2]
    s, s_b, s_bb = _risen(above[0])
    mixed = depth[1][:, :, None] * above[1][:, None, :]
    curvature = (k * s)[:, None, None] * square + (p * s)[:, None, None] * depth[2]
    curvature += (p * s_b)[:, None, None] * (mixed + mixed.transpose(0, 2, 1))
    curvature += (phi * s_bb)[:, None, None] * above[1][:, :, None] * above[1][:, None, :]
    curvature += (phi * s_b)[:, None, None] * above[2]
    return phi * s, (p * s)[:, None] * depth[1] + (phi * s_b)[:, None] * above[1], curvature


def _risen(above: Array) -> tuple[Array, Array, Array]:
    """Return the wall factor s at heights above its edge, with slope and curvature."""
    r = np.clip(above / _RISE, 0.0, 1.0)
    s = r**3 * (10.0 - 15.0 * r + 6.0 * r**2)
    return s, 30.0 * r**2 * (1.0 - r) ** 2 / _RISE, 60.0 * r * (1.0 - r) * (1.0 - 2.0 * r) / _RISE**2


def _linear(value: Array, slope: tuple[float, float, float]) -> Jet:
    """Return a jet of constant slope."""
    return value, np.tile(slope, (len(value), 1)), np.zeros((len(value), 3, 3))


def _depth_inside(plate: PlateOutline, y: Array) -> Jet:
    """Return the depth of places (a, e, b) inside the target's outline."""
    r = plate.half_x if plate.is_round else _CORNER
    w = np.abs(y[:, :2]) - (plate.half_x, plate.half_y) + r
    corner = np.all(w >= 0.0, axis=1)
    away = np.maximum(np.hypot(*w.T), 1e-12)
    flat = np.stack([w[:, 0] > w[:, 1], w[:, 0] <= w[:, 1]], axis=1)
    n = np.where(corner[:, None], w / away[:, None], flat) * np.sign(y[:, :2])
    slope, curvature = np.zeros_like(y), np.zeros((len(y), 3, 3))
    slope[:, :2] = -n
    along = np.stack([-n[:, 1], n[:, 0]], axis=1)  # the rounded corner
    curvature[:, :2, :2] = -np.where(corner, 1.0 / away, 0.0)[:, None, None] * along[:, :, None] * along[:, None, :]
    return r - np.where(corner, away, w.max(axis=1)), slope, curvature


@dataclass(frozen=True, eq=False)
class Grip:
    """Friction of m points in one increment."""

    largest: Array  # (m,), f p, the largest traction [shear moduli]
    anchor: Array  # (m, 3), y_0 - s_e [thicknesses]
    normal: Array  # (m, 3), unit n; nothing along it is held
    slip: float  # s_0 [thicknesses]

    def __call__(self, y: Array) -> tuple[Array, Array, Array]:
        """Return the energy per area at places y, its slope and its curvature, shapes (m,), (m, 3), (m, 3, 3)."""
        s, size = self._slipped(y)
        x = size / self.slip
        inside = np.minimum(x, 1.0)
        energy = self.largest * self.slip * inside * (x - 0.5 * inside)
        way = s / np.maximum(size, _TINY)[:, None]
        across = (self.largest / np.maximum(size, self.slip))[:, None, None]
        plane = np.eye(3) - self.normal[:, :, None] * self.normal[:, None, :]
        along = np.where(x > _SLIPS, 1.0, 0.0)[:, None, None] * way[:, :, None] * way[:, None, :]
        return energy, (self.largest * inside)[:, None] * way, across * (plane - along)

    def traction(self, y: Array) -> Array:
        """Return tau at places y, shape (m, 3) [shear moduli]."""
        return self(y)[1]

    def _slipped(self, y: Array) -> tuple[Array, Array]:
        """Return the slips s and their lengths."""
        away = y - self.anchor
        s = away - (away * self.normal).sum(axis=1)[:, None] * self.normal
        return s, np.linalg.norm(s, axis=1)


def gripped(largest: Array, start: tuple[Array, Array], normal: Array, slip: float) -> Grip:
    """Return the friction of an increment that starts at places and tractions y_0, tau_0, shape (m, 3)."""
    place, before = start
    before = before - (before * normal).sum(axis=1)[:, None] * normal
    size = np.linalg.norm(before, axis=1)
    share = np.minimum(size / np.maximum(largest, _TINY), 1.0)
    elastic = slip * share / np.maximum(size, _TINY)
    return Grip(largest, place - elastic[:, None] * before, normal, slip)
