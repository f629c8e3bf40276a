"""Press on the surface of a pad with rigid targets: what that does to the targets, at small strain and beyond.

With u = U q + K_ff^-1 f the displacements by the motions q of all targets and nodal forces f on the pad, the targets
held, U their fields (equilibrium/linearisation.py), S the targets' stiffness and P the work of loads on them,

    S q = P + U^T f,

reciprocity: what a touch does to the targets is its work on the fields of their motions, so that the mesh is fine at
the targets alone, wherever it presses. Forces f_p at points x_p of the surface, as spread.py has them, are nodal ones,
f = N(x_p)^T f_p.

Finite strain: Newton's second step, from u with its pressures by the tangent there, moves the targets on by dq. Forces
without friction follow the face there, f_x = -f_z w_x with w the height of the face above that at rest, and a guided
shape stays above its place while the face moves aside below it.

Lengths in thicknesses of the pad, forces in mu t^2. Left out: friction, and what presses beside the upper face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sits_mech.mechanics.cells.spread import Spread
from sits_mech.mechanics.element.kernel import gradients, volumes
from sits_mech.mechanics.equilibrium.body import Bonded, rest, smallest_volume
from sits_mech.mechanics.equilibrium.linearisation import Factor, bending_equations, factored_shapes
from sits_mech.quantities import Array, Integers, Mask
from sits_mech.scene.parts.touch import Touch


@dataclass(frozen=True, eq=False)
class Level:
    """A pad on one mesh, solved for `shapes` (b, 3, m) of its bonded nodes: the motions of its targets."""

    body: Bonded  # without components
    shapes: Array
    top: float  # height of the surface

    @cached_property
    def factor(self) -> Factor:
        """The pad at rest, factored."""
        own = range(6, 6 + self.shapes.shape[-1])
        return factored_shapes(self.body, rest(self.body), self.shapes, [(self.body.pattern, own)])[0]

    @cached_property
    def flexibility(self) -> Array:
        """S^-1, (m, m)."""
        return np.asarray(np.linalg.inv(self.factor.stiffness))

    @cached_property
    def surface(self) -> tuple[Array, Array, Integers]:
        """Lines through nodes of the upper face along x and y, and the numbers of their displacements, (x, y, 3).

        Zeros over slots, where no touch is.
        """
        nodes = np.round(self.body.mesh.nodes, 9)
        on, cells = np.flatnonzero(np.abs(nodes[:, 2] - self.top) < 1e-9), nodes[self.body.mesh.cells]
        sides = np.concatenate([cells.min(axis=1), cells.max(axis=1)])
        x, y = (_with_middles(np.unique(nodes[on, k]), sides[:, k]) for k in (0, 1))
        numbers = np.zeros((len(x), len(y), 3), dtype=int)
        numbers[np.searchsorted(x, nodes[on, 0]), np.searchsorted(y, nodes[on, 1])] = 3 * on[:, None] + np.arange(3)
        return x, y, numbers

    def at(self, points: Array) -> Array:
        """Return N of the surface, (p, x, y), at points (p, 2)."""
        x, y = (_quadratics(own, points[:, k]) for k, own in enumerate(self.surface[:2]))
        return x[:, :, None] * y[:, None]

    def work(self, f: Array) -> Array:
        """Return U^T f, (m, ...), of nodal forces (d n, ...)."""
        on_bonded = np.tensordot(self.shapes, f[self.body.bonded], axes=((0, 1), (0, 1)))
        return on_bonded + self.factor.by_q.T @ f[self.body.pattern.free]

    def displaced(self, q: Array, f: Array) -> Array:
        """Return u of the module docstring, (d n,)."""
        u, free = np.zeros_like(f), self.body.pattern.free
        u[free] = self.factor.by_q @ q + self.factor.of_free.solve(f[free])
        u[self.body.bonded] = self.shapes @ q
        return u

    def second(self, u: Array, P: Array, f: Array) -> Array:
        """Return dq of the module docstring, (m,), from u (d n,) under loads P and nodal forces f; inf if inverted."""
        mesh = self.body.mesh
        p = self.body.laws.K * volumes(mesh, gradients(mesh, u)[..., ::4].sum(axis=-1))
        found = None
        if smallest_volume(self.body, u, everywhere=False) > 0.0:
            found = bending_equations(self.body, replace(rest(self.body), u=u, p=p), self.shapes, f)
        if found is None:
            return np.full_like(P, np.inf)
        (S, left), n = found, len(P)
        left[-n:] -= P
        return np.asarray(np.linalg.solve(S, -left)[-n:])


def _with_middles(lines: Array, sides: Array) -> Array:
    """Return lines with those in the middle of slots, which have no nodes, between sides of cells beside them."""
    is_side = np.isin(lines, sides)
    slots = np.flatnonzero(is_side[1:] & is_side[:-1])
    return np.insert(lines, slots + 1, (lines[slots] + lines[slots + 1]) / 2.0)


def _quadratics(nodes: Array, places: Array) -> Array:
    """Return the quadratic shape functions of an axis's nodes, every other one within a cell, at places, (p, n)."""
    cell = 2 * np.clip(np.searchsorted(nodes[::2], places) - 1, 0, len(nodes) // 2 - 1)
    s, found = (places - nodes[cell + 1]) / (nodes[cell + 2] - nodes[cell + 1]), np.zeros((len(places), len(nodes)))
    for k, value in enumerate((0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0))):
        found[np.arange(len(places)), cell + k] = value
    return found


def touch_forces(level: Level, spread: Spread, thickness: float, F: float) -> Array:
    """Return the nodal forces (d n,) by which F [mu t^2] lies at points (p, 2) [m] with shares (p,)."""
    found, (points, share) = np.zeros(level.body.mesh.nodes.size), spread
    found[level.surface[2][..., 2]] = -F * np.tensordot(share, level.at(points / thickness), axes=1)
    return found


def followed(level: Level, u: Array, touch: Touch, spread: Spread, scale: tuple[float, float]) -> Array:
    """Return the nodal forces of a touch where it has moved the face by u; `scale` as of `touch_forces`."""
    *axes, numbers = level.surface
    there, (points, share) = u[numbers], spread
    if touch.friction == "none" and touch.shape != "pressure":
        aside = np.tensordot(level.at(np.array([touch.place]) / scale[0]), there[..., :2], axes=2)
        points = points - scale[0] * aside
    f = touch_forces(level, (points, share), *scale)
    if touch.friction == "none":
        for k, lines in enumerate(axes):
            f[numbers[..., k]] = -f[numbers[..., 2]] * _slopes(there[..., 2], lines, k, numbers[..., 2] == 0)
    return f


def _slopes(w: Array, lines: Array, axis: int, missing: Mask) -> Array:
    """Return dw/dx along an axis at nodes of the face, one-sided at slots and zero within, where w is `missing`."""
    w = np.where(missing, np.nan, w)
    found, each = np.gradient(w, lines, axis=axis), np.diff(w, axis=axis) / np.expand_dims(np.diff(lines), 1 - axis)
    before, after = ((each.take([0], axis), each), (each, each.take([-1], axis)))
    for own in (np.concatenate(before, axis), np.concatenate(after, axis), np.zeros_like(w)):
        found = np.where(np.isnan(found), own, found)
    return found
