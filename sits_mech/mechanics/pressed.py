"""Press on the surface of a pad with rigid targets, at small strain: what that does to the targets.

With u = U q + K_ff^-1 f the displacements by the motions q of all targets and nodal forces f on the pad, the targets
held, U their fields (equilibrium/linearisation.py), S the targets' stiffness and P the work of loads on them,

    S q = P + U^T f,

reciprocity: what a touch does to the targets is its work on the fields of their motions, so that the mesh is fine at
the targets alone, wherever it presses. Forces f_p at points x_p of the surface are nodal ones, f = N(x_p)^T f_p; a
uniform pressure is equal forces at points evenly on its area, other touches as spread.py spreads them.

Finite strain: Newton's second step, from u with its pressures by the tangent there, moves the targets on by dq. Forces
without friction follow the face there, f_x = -f_z w_x with w the height of the face above that at rest, and a guided
shape stays above its place while the face moves aside below it.

Lengths in thicknesses of the pad, forces in mu t^2. Left out: friction, and what presses beside the upper face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sits_mech.mechanics.element.kernel import gradients, volumes
from sits_mech.mechanics.equilibrium.body import Bonded, rest, smallest_volume
from sits_mech.mechanics.equilibrium.linearisation import Factor, factored_shapes
from sits_mech.mechanics.spread import Spread
from sits_mech.quantities import Array
from sits_mech.scene.touch import Touch


@dataclass(frozen=True, eq=False)
class Level:
    """A pad on one mesh, solved for `shapes` (b, 3, m) of its bonded nodes: the motions of its targets."""

    body: Bonded
    shapes: Array
    top: float  # height of the surface

    @cached_property
    def factor(self) -> Factor:
        """The pad at rest, factored."""
        return factored_shapes(self.body, rest(self.body), self.shapes)[0]

    @cached_property
    def flexibility(self) -> Array:
        """S^-1, (m, m)."""
        return np.linalg.inv(self.factor.stiffness)

    def work(self, f: Array) -> Array:
        """Return U^T f, (m, ...), of nodal forces (d n, ...)."""
        on_bonded = np.tensordot(self.shapes, f[self.body.bonded], axes=((0, 1), (0, 1)))
        return np.asarray(on_bonded + self.factor.by_q.T @ f[self.body.pattern.free])

    def fields(self, q: Array) -> Array:
        """Return U q, (d n, ...), of motions (m, ...)."""
        u = np.zeros((self.body.mesh.nodes.size, *q.shape[1:]))
        u[self.body.pattern.free] = self.factor.by_q @ q
        u[self.body.bonded] = np.tensordot(self.shapes, q, axes=1)
        return u

    def held(self, f: Array) -> Array:
        """Return K_ff^-1 f, (d n, ...)."""
        u, free = np.zeros_like(f), self.body.pattern.free
        u[free] = self.factor.of_free.solve(f[free])
        return u

    def second(self, u: Array, P: Array | float, f: Array) -> Array:
        """Return dq of the module docstring, (m,), from u (d n,) under loads P and nodal forces f; inf if inverted."""
        mesh, laws = self.body.mesh, self.body.laws
        volume = np.trace(gradients(mesh, u).reshape(*mesh.inside.weights.shape, 3, 3), axis1=-2, axis2=-1)
        there = replace(rest(self.body), u=u, p=laws.K * volumes(mesh, volume))
        if not smallest_volume(self.body, u, everywhere=False) > 0.0:
            return np.full(self.shapes.shape[-1], np.inf)
        found, left = factored_shapes(self.body, there, self.shapes, f)
        return np.asarray(np.linalg.solve(found.stiffness, P - left))


@dataclass(frozen=True, eq=False)
class _Surface:
    """The nodes of a pad's upper face, a tensor grid with those in the middles of its cells."""

    x: Array
    y: Array
    upward: Array  # (x, y), numbers of displacements along z

    def at(self, points: Array) -> Array:
        """Return which combination of nodal values a point's is, (p, x, y)."""
        return np.asarray(_along(self.x, points[:, 0])[:, :, None] * _along(self.y, points[:, 1])[:, None])


def _surface(level: Level) -> _Surface:
    """Return the surface of a pad."""
    nodes = level.body.mesh.nodes
    on = np.flatnonzero(np.abs(nodes[:, 2] - level.top) < 1e-9)
    x, y = (np.unique(np.round(nodes[on, k], 9)) for k in (0, 1))
    upward = np.full((len(x), len(y)), -1)
    upward[tuple(np.abs(axis - nodes[on, k, None]).argmin(axis=1) for k, axis in ((0, x), (1, y)))] = 3 * on + 2
    return _Surface(x, y, upward)


def _along(nodes: Array, places: Array) -> Array:
    """Return the quadratic shape functions of an axis's nodes at places, (p, n)."""
    lines = nodes[::2]
    cell = np.clip(np.searchsorted(lines, places) - 1, 0, len(lines) - 2)
    s = 2.0 * (places - lines[cell]) / np.diff(lines)[cell] - 1.0
    found = np.zeros((len(places), len(nodes)))
    for k, value in enumerate((0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0))):
        found[np.arange(len(places)), 2 * cell + k] = value
    return found


def touch_forces(level: Level, spread: Spread, thickness: float, F: float) -> Array:
    """Return the nodal forces (d n,) by which F [mu t^2] lies at points (p, 2) [m] with shares (p,)."""
    surface, found, (places, share) = _surface(level), np.zeros(level.body.mesh.nodes.size), spread
    found[surface.upward.ravel()] = -F * (share @ surface.at(places / thickness).reshape(len(share), -1))
    return found


def followed(level: Level, u: Array, touch: Touch, spread: Spread, scale: tuple[float, float]) -> Array:
    """Return the nodal forces of a touch where it has moved the face by u; `scale` as of `touch_forces`."""
    surface, (points, share) = _surface(level), spread
    there = u[surface.upward[..., None] + np.array([-2, -1, 0])]
    if touch.friction == "none" and touch.shape != "pressure":
        place = np.array(touch.place)[None] / scale[0]
        points = points - scale[0] * np.einsum("pxy,xyk->pk", surface.at(place), there[..., :2])
    f = touch_forces(level, (points, share), *scale)
    if touch.friction == "none":
        for k, axis in enumerate((surface.x, surface.y)):
            f[surface.upward - 2 + k] = -f[surface.upward] * np.gradient(there[..., 2], axis, axis=k)
    return f
