"""Bend a target under its load: a thin plate that is bonded on its pad, to first order.

A target of bending stiffness D (`Target.bending_stiffness`) moves upwards at (x, y), from its middle, by

    w = d_z + alpha_x y - alpha x + sum_m a_m phi_m,

phi_m the polynomials of degree `DEGREE` and less that are orthogonal to 1, x and y over its outline. Its energy is that
of G. R. Kirchhoff, free edges coming of themselves,

    1/2 a^T P a,   P_mn = D int (phi_m,xx + phi_m,yy) (phi_n,xx + phi_n,yy)
                            - (1 - nu) (phi_m,xx phi_n,yy + phi_m,yy phi_n,xx - 2 phi_m,xy phi_n,xy) dA.

The pad resists q, the motion of a rigid target, and a by one matrix, K = (K_qq, K_qa; K_aq, K_aa): its tangent,
condensed on the bonded face (equilibrium/linearisation.py), on the first mesh and about the state without load.
A slope moves points of that face along, by their depth below the neutral plane: what the pad drags there bends a foil
of 0.2 mm 5 % less. With the work of the load on q, f_q, and on the shapes, f_a = -F_z mean of phi over what is pressed,

    rigid   K_qq q_0 = f_q,         bent   (K + P) (q, a) = (f_q, f_a).

A touch presses a point, a line or an area of the target's top; a wrench without touch is a pressure spread evenly over
it, its moments linearly, which does no work on phi. Shear bends by its lever alone.

What a target bends over how far it moves goes on under larger loads as about the state without: of a disc that presses
its pad by 2 and 9 % within 0.7 to 1.1 of what NGSolve has for a foil meshed in space at finite strain, of a limp one,
which bends by as much as it moves, up to 1.9 (tests/mechanics).

Where that is too much to be left out, the target bends at its load (bent.py).

Range: small slopes, thickness small against width. Left out: transverse shear of the plate, an indenter that gives,
swelling.

Source: S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), sections 21, 25, 57 and 100.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legder, leggauss, legval

from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.equilibrium.newton import bonded_stiffness
from sits_mech.mechanics.linear import undeformed_pad
from sits_mech.mechanics.touch import touched_place
from sits_mech.quantities import Array, Mask, Wrench
from sits_mech.scene.parts.outlines import inside_loops
from sits_mech.scene.parts.touch import Touch
from sits_mech.scene.sensor import Sensor, Target
from sits_mech.threads import one_thread

DEGREE = 6
"""Of the shapes: 4 and 10 differ from it by 1 % of what coils see of a foil pressed at a point (test_bending.py)."""
_POINTS = 16  # of Gauss along each side of an outline: twice as many change what coils see of 22 mm by 1 %
_STEPS = 64  # along each side of a drawn outline


class Derivatives(NamedTuple):
    """Shapes at points and their derivatives, (p, m) each [1, 1/m, 1/m^2]."""

    value: Array
    x: Array
    y: Array
    xx: Array
    yy: Array
    xy: Array


class CoilView(NamedTuple):
    """How n coils see q and a as they see the target move upwards: (6 + m, n), and what is missed of the mean |w|."""

    parts: Array
    off: float


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
        nu, xx, yy, xy = self.target.poisson, *((each * self.areas[:, None]).T for each in at[3:])
        both = (xx + yy) @ (at.xx + at.yy)
        return both - (1.0 - nu) * (xx @ at.yy + yy @ at.xx - 2.0 * xy @ at.xy)

    def heights(self, places: Array) -> Array:
        """Return how q and a move places (n, 2) upwards, shape (n, 6 + m)."""
        return np.asarray(self.lifts(places)[0])

    def lifts(self, places: Array) -> Array:
        """Return how q and a move places (n, 2) upwards, with derivatives x, y, xx, xy, yy, shape (6, n, 6 + m)."""
        at, a = _shapes(self.target, self.degrees, places), 0.5 * np.array(self.target.extent)
        found = np.zeros((6, len(places), 6 + len(self.degrees)))
        found[0, :, 1], found[0, :, 2], found[0, :, 4] = 1.0, -places[:, 0], places[:, 1]
        found[1, :, 2], found[2, :, 4] = -1.0, 1.0
        found[0, :, 6:] = at.value - _linear(self.target, places) @ self.plane
        found[1:3, :, 6:] = at.x - self.plane[1] / a[0], at.y - self.plane[2] / a[1]
        found[3:, :, 6:] = at.xx, at.xy, at.yy
        return found

    def bonded(self, body: Bonded, thickness: float) -> Array:
        """Return how shapes move the bonded nodes of a body, (n, d, m): upwards, and along by its slope."""
        w, w_x, w_y = self.lifts(thickness * body.X[:, :2])[:3, :, 6:]
        along = self.target.neutral_plane * np.stack([w_x, w_y])[: len(body.mesh.axes) - 1]
        return np.stack([*along, w], axis=1)

    def answers(self, loads: Sequence[Wrench], stiffness: float) -> tuple[Array, Array]:
        """Return q and a of a rigid target under loads about the middle of its top face, and what bending adds.

        Of bending stiffness D [N m]; shape (6 + m, l) each.
        """
        rows = np.flatnonzero(np.diag(self.pad) > 0.0)
        motion = rows[rows < 6]
        f = np.array([self.work(load) for load in loads]).reshape(-1, len(self.pad)).T
        whole = self.pad.copy()
        whole[6:, 6:] += stiffness * self.plate
        rigid, free = np.zeros_like(f), np.zeros_like(f)
        rigid[motion] = np.linalg.solve(self.pad[np.ix_(motion, motion)], f[motion])
        free[rows] = np.linalg.solve(whole[np.ix_(rows, rows)], f[rows])
        return rigid, free - rigid

    def as_motion(self, moved: Array, seen: CoilView, free: Sequence[int] = (1, 2, 4)) -> tuple[Array, Array]:
        """Return motions (l, 6) of a rigid target that coils see as q and a, (l, 6 + m), and what they are off by (l,).

        Of those of the components that are `free`; of motions that coils do not tell apart the least.
        """
        columns, b = list(free), moved @ seen.parts
        levers = np.where(np.array(columns) > 1, 0.5 * max(self.target.extent), 1.0)
        rows = seen.parts[columns].T / levers
        some = np.linalg.lstsq(rows, b.T, rcond=1e-6)[0]
        motion = np.zeros((len(b), 6))
        motion[:, columns] = some.T / levers
        varied = self.areas @ np.abs(moved[:, 6:] @ self.upwards[:, 6:].T).T / self.areas.sum()
        return motion, np.abs(rows @ some - b.T).max(axis=0) + seen.off * varied

    def work(self, load: Wrench) -> Array:
        """Return the work of a load on q and a, shape (6 + m,)."""
        h, own = self.target.load_height, load.components
        q = own * (1.0, -1.0, 1.0, 1.0, 1.0, 1.0) + (0.0, 0.0, h * load.F_x, 0.0, -h * load.F_y, 0.0)
        if self.touch is None or load.F_z == 0.0:
            return np.concatenate([q, np.zeros(len(self.even))])
        places, shares = pressed_places(self.touch)
        pressed = self.heights(places + touched_place(load))[:, 6:]
        return np.concatenate([q, -load.F_z * (shares @ pressed)])


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
    shapes = made.bonded(body, t)
    loads, lengths = (np.append(each, np.full(len(degrees), each[1])) for each in (scales.loads, scales.lengths))
    pad = bonded_stiffness(body, shapes, even) * np.outer(loads, 1.0 / lengths)
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
    """Return products of Legendre's polynomials in x/a and y/b at places (n, 2), and their derivatives."""
    most, half = 1 + int(degrees.max()), 0.5 * np.array(target.extent)
    each = [legder(np.eye(most), k) for k in range(3)]
    x, y = (  # by derivative, shape (degree, n) each
        [legval(s, own) / size**k for k, own in enumerate(each)]
        for s, size in zip((places / half).T, half, strict=True)
    )
    i, j = degrees.T
    return Derivatives(*((x[k][i] * y[n][j]).T for k, n in ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))))
