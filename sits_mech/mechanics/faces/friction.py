"""Coulomb friction on points of a free face along a rigid surface, in one increment of a path.

With y the place of a point in the surface's own frame (the ground's, or the target's), n the surface's normal and p the
pressure there, a traction tau along the surface, per reference area, holds the point back:

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
pressure stands still while the increment is solved, and is taken from its end, pass by pass (rest/increments.py).

The choice. A potential of each increment, rather than the equations of Coulomb's law themselves, keeps tangents
symmetric and the line of solvers as it is; the price are passes over the pressure. The bend of D at x = 1 is left as it
is: all points are stiff at the beginning of an increment, also those that slipped before and turn back now, which a
smooth D would not hold. An elastic slip of one length, rather than of one stiffness, makes points stick where they are
hardly pressed as well. Tractions are carried, and not slips: pressing then changes no traction. Neglected: what s_0
lets a point creep, O(s_0), like the depth of contact; another coefficient at rest than in motion; friction of faces on
each other.

Unknowns: none of its own. Units as in contact.py. Source: P. Wriggers, Computational Contact Mechanics (2006), chapters
4 and 10; M. Li et al., ACM Trans. Graph. 39 (2020) 49, section 5, the potential with the pressure of before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array

_TINY = 1e-300
_SLIPS = 1.0 + 1e-9  # x of points that slip: those that slipped before begin an increment at 1


@dataclass(frozen=True, eq=False)
class Grip:
    """Friction of m points in one increment."""

    limit: Array  # (m,), f p, the largest traction [shear moduli]
    anchor: Array  # (m, 3), y_0 - s_e [thicknesses]
    normal: Array  # (m, 3), unit n; nothing along it is held
    slip: float  # s_0 [thicknesses]

    def __call__(self, y: Array) -> tuple[Array, Array, Array]:
        """Return the energy per area at places y, its slope and its curvature, shapes (m,), (m, 3), (m, 3, 3)."""
        s, size = self._slipped(y)
        x = size / self.slip
        inside = np.minimum(x, 1.0)
        energy = self.limit * self.slip * inside * (x - 0.5 * inside)
        way = s / np.maximum(size, _TINY)[:, None]
        across = (self.limit / np.maximum(size, self.slip))[:, None, None]
        plane = np.eye(3) - self.normal[:, :, None] * self.normal[:, None, :]
        along = np.where(x > _SLIPS, 1.0, 0.0)[:, None, None] * way[:, :, None] * way[:, None, :]
        return energy, (self.limit * inside)[:, None] * way, across * (plane - along)

    def traction(self, y: Array) -> Array:
        """Return tau at places y, shape (m, 3) [shear moduli]."""
        return self(y)[1]

    def lost(self, y: Array) -> Array:
        """Return the work per area lost to slip in an increment to places y, shape (m,)."""
        return self.limit * np.maximum(self._slipped(y)[1] - self.slip, 0.0)

    def _slipped(self, y: Array) -> tuple[Array, Array]:
        """Return the slips s and their lengths."""
        away = y - self.anchor
        s = away - (away * self.normal).sum(axis=1)[:, None] * self.normal
        return s, np.linalg.norm(s, axis=1)


def gripped(limit: Array, start: tuple[Array, Array], normal: Array, slip: float) -> Grip:
    """Return the friction of an increment that starts at places and tractions y_0, tau_0, shape (m, 3)."""
    place, before = start
    before = before - (before * normal).sum(axis=1)[:, None] * normal
    size = np.linalg.norm(before, axis=1)
    share = np.minimum(size / np.maximum(limit, _TINY), 1.0)
    elastic = slip * share / np.maximum(size, _TINY)
    return Grip(limit, place - elastic[:, None] * before, normal, slip)
