"""Bend a target under its load: a thin plate that is bonded on its pad, to first order.

A target of bending stiffness D (`Target.bending_stiffness`) moves upwards at (x, y), from its middle, by

    w = d_z + alpha_x y - alpha x + sum_m a_m phi_m,

phi_m the polynomials of degree `DEGREE` and less that are orthogonal to 1, x and y over its outline. Its energy is that
of G. R. Kirchhoff, free edges coming of themselves,

    1/2 a^T P a,   P_mn = D int (phi_m,xx + phi_m,yy) (phi_n,xx + phi_n,yy)
                            - (1 - nu) (phi_m,xx phi_n,yy + phi_m,yy phi_n,xx - 2 phi_m,xy phi_n,xy) dA.

The pad resists q, the motion of a rigid target, and a by one matrix, K = (K_qq, K_qa; K_aq, K_aa): its tangent,
condensed on the bonded face (equilibrium/linearisation.py), on the first mesh and about the state without load. With
the work of the load on q, f_q, and on the shapes, f_a = -F_z mean of phi over what is pressed,

    rigid   K_qq q_0 = f_q,         bent   (K + P) (q, a) = (f_q, f_a).

A touch presses a point, a line or an area of the target's top; a wrench without touch is a pressure spread evenly over
it, its moments linearly, which does no work on phi. Shear bends by its lever alone.

What a target bends over how far it moves goes on under larger loads as about the state without: of a disc that presses
its pad by 2 and 9 % within 0.7 to 1.1 of what NGSolve has for a foil meshed in space at finite strain, of a limp one,
which bends by as much as it moves, up to 1.9 (tests/mechanics).

Where that is too much to be left out, the target bends at its load (`Bending`): from a rigid one's rest q, whose pad
presses on the shapes by r, a step of Newton's method, of which a second one changes 0.2 % of stiff foils,

    (K(q) + P) (dq, a) = (0, f_a - r).

What coils see of w, b_c = mean_c w, is that of a rigid target moved by the (d_z, alpha, alpha_x) of least squares over
the coils, which the pose takes. Error: of mean_c |w| a tenth, as foils meshed in space show on the second mesh, and
what a plate of thickness h resists besides as it must stretch to bend, which is less than

    1/2 (range of w / h)^2,

0.47 where its rim is clamped (section 100); and what coils see differently.

Range: small slopes, thickness small against width. Left out: transverse shear of the plate, an indenter that gives,
swelling.

Source: S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), sections 21, 25, 57 and 100.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legder, leggauss, legval

from sits_mech.mechanics.equilibrium.body import Bonded, rest
from sits_mech.mechanics.equilibrium.control import Scales
from sits_mech.mechanics.equilibrium.linearisation import bending_step, bonded_stiffness
from sits_mech.mechanics.levels.answer import enlarged, relative, starts
from sits_mech.mechanics.levels.family import Levels
from sits_mech.mechanics.linear import undeformed_pad
from sits_mech.mechanics.touch import touched_place
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Equilibrium, Mask, Pose, Wrench
from sits_mech.scene.outlines import inside_loops
from sits_mech.scene.sensor import Sensor, Target
from sits_mech.scene.touch import Touch
from sits_mech.threads import one_thread

DEGREE = 6
"""Of the shapes: 4 and 10 differ from it by 1 % of what coils see of a foil pressed at a point (test_bending.py)."""
_POINTS = 16  # of Gauss along each side of an outline: twice as many change what coils see of 22 mm by 1 %
_OFF = 0.1  # of what bends: foils meshed in space show as much (tests/mechanics/test_bending.py)
_STEPS = 64  # along each side of a drawn outline


class Derivatives(NamedTuple):
    """Shapes at points and their second derivatives, (p, m) each [1, 1/m^2]."""

    value: Array
    xx: Array
    yy: Array
    xy: Array


@dataclass(frozen=True)
class Bent:
    """How far loads move points of a target upwards: as a rigid one, and what it bends besides, (l, p) each [m]."""

    rigid: Array
    bend: Array


@dataclass(frozen=True, eq=False)
class BondedPlate:
    """A target on its pad; made by `bonded_plate`."""

    target: Target
    touch: Touch | None
    places: Array  # (p, 2), points of the target from its middle [m]
    areas: Array  # (p,), shares of its area [m^2]
    degrees: Array  # (m, 2), of the shapes along x and y
    even: Mask  # (m,), whether they are even in y
    plane: Array  # (3, m), what of 1, x/a and y/b they are freed of
    pad: Array  # (6 + m, 6 + m), K of the whole pad [N/m, N, N m]

    @cached_property
    def upwards(self) -> Array:
        """How q and a move its points upwards, shape (p, 6 + m)."""
        return self.heights(self.places)

    @cached_property
    def plate(self) -> Array:
        """P over D, shape (m, m) [1/m^2]."""
        at = _shapes(self.target, self.degrees, self.places)
        nu, xx, yy, xy = self.target.poisson, *((each * self.areas[:, None]).T for each in at[1:])
        both = (xx + yy) @ (at.xx + at.yy)
        return np.asarray(both - (1.0 - nu) * (xx @ at.yy + yy @ at.xx - 2.0 * xy @ at.xy))

    def heights(self, places: Array) -> Array:
        """Return how q and a move places (n, 2) upwards, shape (n, 6 + m)."""
        (x, y), none = places.T, np.zeros(len(places))
        motion = [none, none + 1.0, -x, none, y, none]
        return np.column_stack([*motion, _shapes(self.target, self.degrees, places).value - self._plane(places)])

    def _plane(self, places: Array) -> Array:
        """Return what shapes have in common with 1, x and y at places (n, 2), shape (n, m)."""
        return _linear(self.target, places) @ self.plane

    def bent(self, loads: Sequence[Wrench], stiffness: float, places: Array | None = None) -> Bent:
        """Return how loads about the middle of its top face move a target of bending stiffness D [N m].

        At places (n, 2) from its middle [m], by default its own points.
        """
        rows, up = np.flatnonzero(np.diag(self.pad) > 0.0), self.upwards if places is None else self.heights(places)
        motion = rows[rows < 6]
        f = np.array([self.work(load) for load in loads]).reshape(-1, len(self.pad)).T
        whole = self.pad.copy()
        whole[6:, 6:] += stiffness * self.plate
        rigid, free = np.zeros_like(f), np.zeros_like(f)
        rigid[motion] = np.linalg.solve(self.pad[np.ix_(motion, motion)], f[motion])
        free[rows] = np.linalg.solve(whole[np.ix_(rows, rows)], f[rows])
        return Bent((up @ rigid).T, (up @ (free - rigid)).T)

    def as_motion(self, b: Array, weights: Array) -> tuple[Array, Array]:
        """Return motions (l, 6) of a rigid target that move what coils see by b (l, n), and the most they are off by.

        `weights` (p, n) are what its points count for each coil; of motions that coils do not tell apart the least.
        """
        columns, lever = [1, 2, 4], 0.5 * max(self.target.extent)
        seen = (weights.T @ self.upwards[:, columns]) / (1.0, lever, lever)
        some = np.linalg.lstsq(seen, b.T, rcond=1e-6)[0]
        motion = np.zeros((len(b), 6))
        motion[:, columns] = some.T / (1.0, lever, lever)
        return motion, np.abs(seen @ some - b.T).max(axis=0)

    def work(self, load: Wrench) -> Array:
        """Return the work of a load on q and a, shape (6 + m,)."""
        h, own = self.target.load_height, load.components
        q = own * (1.0, -1.0, 1.0, 1.0, 1.0, 1.0) + (0.0, 0.0, h * load.F_x, 0.0, -h * load.F_y, 0.0)
        if self.touch is None or load.F_z == 0.0:
            return np.concatenate([q, np.zeros(len(self.even))])
        places, shares = pressed_places(self.touch)
        pressed = self.heights(places + touched_place(load))[:, 6:]
        return np.concatenate([q, -load.F_z * (shares @ pressed)])


@dataclass(frozen=True, eq=False)
class Bending:
    """What bends of a target at its load, as coils see it; called with an equilibrium of the rigid one."""

    plate: BondedPlate
    stiffness: float  # of the target [N m]
    seen: Callable[[Pose], Array]  # what the target's points count for each coil at a pose, (p, n)

    @one_thread
    def __call__(self, levels: Levels, scales: Scales, found: Equilibrium) -> Equilibrium:
        """Return the equilibrium with the pose of a rigid target that coils read alike."""
        step = self.step(levels, scales, found)
        if step is None:
            return found
        w, weights = self.plate.upwards @ step, self.seen(found.pose)
        (shift,), (unlike,) = self.plate.as_motion(w[None] @ weights, weights)
        share = _OFF + min(1.0, (np.ptp(w) / self.plate.target.thickness) ** 2 / 2.0)
        off = share * np.abs(shift)
        off[1] = share * np.max(np.abs(w) @ weights) + unlike
        bent = replace(found, pose=Pose.of(found.pose.components + shift))
        moved = found.pose.components - scales.pose(np.zeros(6)).components
        more = relative(off, moved, levels.fine.reach(scales.thickness))
        note = Note.of(NoteKind.BENT, deflection=float(np.abs(w).max()), bare=self.plate.target.bare)
        return enlarged(bent, Pose.of(found.error.components + off), found.report.estimated_error + more, note)

    def step(self, levels: Levels, scales: Scales, found: Equilibrium) -> Array | None:
        """Return q and a less those of the rigid target, (6 + m,) [m, rad], on the second level; None if singular."""
        body, here = levels.fine, starts(levels, scales, found)[0]
        body = body.near(here.u)
        shapes, some = self._on(body, scales.thickness)
        length, force = scales.lengths[1], scales.loads[1]
        plate = some.T @ self.plate.plate @ some * (self.stiffness * length / force)
        work = some.T @ self.plate.work(found.wrench)[6:] / force
        way = bending_step(body, here, shapes, plate, work)
        if way is None:
            return None
        q, a = way
        return np.concatenate([q * scales.lengths[: len(q)], np.zeros(6 - len(q)), length * some @ a])

    def _on(self, body: Bonded, thickness: float) -> tuple[Array, Array]:
        """Return shapes that a body's symmetry allows at its bonded nodes, (n, d, k), and what each is of, (m, k)."""
        some = np.eye(len(self.plate.even))
        if body.mesh.hoop:
            r = np.hypot(*self.plate.places.T) / self.plate.target.extent[0]
            even = np.column_stack([r**power for power in range(2, int(self.plate.degrees.max()) + 1, 2)])
            even -= self.plate.areas @ even / self.plate.areas.sum()
            some = np.linalg.lstsq(self.plate.upwards[:, 6:], even, rcond=None)[0]
        elif body.components < 6:
            some = some[:, self.plate.even]
        shapes = np.zeros((*body.bonded.shape, some.shape[1]))
        shapes[:, -1] = self.plate.heights(thickness * body.X[:, :2])[:, 6:] @ some
        return shapes, some

@lru_cache(maxsize=8)
@one_thread
def bonded_plate(sensor: Sensor, degree: int = DEGREE) -> BondedPlate:
    """Return a scene's target on its pad; raises ValueError for a scene without, or one whose pad has no mesh."""
    body, scales = undeformed_pad(sensor)
    target, t, flat = sensor.target, scales.thickness, len(body.mesh.axes) == 2
    if target is None:
        raise ValueError("target: must be given for a force to bend it; it is missing")
    each = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i) if i + j > 1 and not (flat and j)]
    degrees = np.array(each)
    places, areas = outline_points(target)
    even, flatly = degrees[:, 1] % 2 == 0, _linear(target, places)
    some = flatly[:, : 2 if flat else 3]
    plane = np.zeros((3, len(degrees)))
    weighed = some * areas[:, None]
    plane[: some.shape[1]] = np.linalg.solve(weighed.T @ some, weighed.T @ _shapes(target, degrees, places).value)
    made = BondedPlate(target, sensor.touch, places, areas, degrees, even, plane, np.zeros((0, 0)))
    shapes = np.zeros((*body.bonded.shape, len(degrees)))
    shapes[:, -1] = made.heights(t * body.X[:, :2])[:, 6:]
    loads, lengths = (np.append(each, np.full(len(degrees), each[1])) for each in (scales.loads, scales.lengths))
    pad = bonded_stiffness(body, rest(body), shapes, even) * np.outer(loads, 1.0 / lengths)
    return BondedPlate(target, sensor.touch, places, areas, degrees, even, plane, pad)


def outline_points(target: Target) -> tuple[Array, Array]:
    """Return points of a target from its middle, shape (p, 2) [m], and their shares of its area (p,) [m^2]."""
    a, b = (0.5 * size for size in target.extent)
    if target.loops:
        step = (np.arange(_STEPS) + 0.5) * (2.0 / _STEPS) - 1.0
        grid = np.stack(np.meshgrid(a * step, b * step, indexing="ij"), axis=-1).reshape(-1, 2)
        there = grid[inside_loops([np.asarray(loop) for loop in target.loops], grid)]
        return there, np.full(len(there), 4.0 * a * b / _STEPS**2)
    return _disc(a) if target.is_round else _box(a, b)


def _box(a: float, b: float) -> tuple[Array, Array]:
    """Return Gauss points of a rectangle with half sides a and b, and their areas: one across a side of no length."""
    s, w = leggauss(_POINTS)
    x, y = (half * s if half else np.zeros(1) for half in (a, b))
    u, v = (half * w if half else np.ones(1) for half in (a, b))
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(u, v).ravel()


def _disc(radius: float) -> tuple[Array, Array]:
    """Return points of a disc, of Gauss along the square of the radius, and their areas."""
    s, w = leggauss(_POINTS)
    r, turn = radius * np.sqrt(0.5 * (s + 1.0)), 2.0 * np.pi * (np.arange(2 * _POINTS) + 0.5) / (2 * _POINTS)
    places = np.stack([np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn))], axis=-1).reshape(-1, 2)
    return places, np.repeat(0.25 * np.pi * radius**2 * w / _POINTS, 2 * _POINTS)


def pressed_places(touch: Touch) -> tuple[Array, Array]:
    """Return what a touch presses, about its place, shape (n, 2) [m], and the shares of the force (n,)."""
    if touch.shape == "sphere":
        return np.zeros((1, 2)), np.ones(1)
    if touch.diameter is not None:
        places, shares = _disc(0.5 * touch.diameter)
    else:
        places, shares = _box(*(0.5 * np.ptp(touch.border, axis=0)))
    return places, shares / shares.sum()


def _linear(target: Target, places: Array) -> Array:
    """Return 1, x/a and y/b at places, shape (n, 3)."""
    return np.column_stack([np.ones(len(places)), places / (0.5 * np.array(target.extent))])


def _shapes(target: Target, degrees: Array, places: Array) -> Derivatives:
    """Return products of Legendre's polynomials in x/a and y/b at places (n, 2), and their second derivatives."""
    most, half = 1 + int(degrees.max()), 0.5 * np.array(target.extent)
    each = [legder(np.eye(most), k) for k in range(3)]
    x, y = (  # by derivative, shape (degree, n) each
        [legval(s, own) / size**k for k, own in enumerate(each)]
        for s, size in zip((places / half).T, half, strict=True)
    )
    i, j = degrees.T
    return Derivatives(*((x[k][i] * y[n][j]).T for k, n in ((0, 0), (2, 0), (0, 2), (1, 1))))
