"""Bend a target at its load, as coils see it (bending.py): a step of Newton's method from the rest of a rigid one.

With q that rest, whose pad presses on the shapes by r,

    (K(q) + P) (dq, a) = (0, f_a - r),

of which a second step changes 0.2 % of stiff foils. What coils see of w, b_c, linear in q and a (`CoilView`), is that
of a rigid target moved by the (d_z, alpha, alpha_x) of least squares over the coils, which the pose takes, extrapolated
from the first two meshes. Error: what that adds (a third and a fourth show -0.9 to 0.9 of it, of nine pads); what
shapes of two degrees less change; what a plate of thickness h resists besides as it must stretch to bend, less than

    1/2 (range of w / h)^2,

0.47 where its rim is clamped (S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), section 100);
and what coils see differently. All loads share it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State
from sits_mech.mechanics.equilibrium.control import Control, Scales
from sits_mech.mechanics.equilibrium.linearisation import bending_equations
from sits_mech.mechanics.foil.bending import BondedPlate, CoilView
from sits_mech.mechanics.levels.answer import enlarged, relative, starts
from sits_mech.mechanics.levels.family import Levels, Line, extrapolated
from sits_mech.memory import latest
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Equilibrium, Mask, Pose, Wrench
from sits_mech.threads import one_thread

_SHAPES = 0.02  # of what coils see: so much ten degrees show of a point of `biorob2018-w22`, where four and six agree


@dataclass(frozen=True, eq=False)
class Bending:
    """What bends of a target at its load, as coils see it."""

    plate: BondedPlate
    stiffness: float  # of the target [N m]
    seen: Callable[[Pose, Mask], CoilView]  # how coils see it at a pose, of some of q and a

    @one_thread
    def bent(self, line: Line, control: Control, found: Equilibrium) -> Equilibrium:
        """Return an equilibrium with the pose of a rigid target that coils read alike; as it is with places given."""
        levels, scales = line[int(found.state[0])], line.scales
        added = None if control.held.any() else self.added(levels, scales, found.wrench, found.state.tobytes())
        if added is None:
            return found
        motion, off, deflection = added
        part = np.copysign(off, motion)  # meshes, shapes and stretching err alike under all loads
        bent = replace(found, pose=Pose.of(found.pose.components + motion), shared=np.vstack([found.shared, part]))
        moved = found.pose.components - scales.pose(np.zeros(6)).components
        more = relative(off, moved, levels.fine.reach(scales.thickness))
        note = Note.of(NoteKind.BENT, deflection=deflection, bare=self.plate.target.bare)
        return enlarged(bent, Pose.of(found.error.components + off), found.report.estimated_error + more, note)

    @latest(16, owned=True)  # finer meshes are compared at some of these loads after all
    def added(self, levels: Levels, scales: Scales, load: Wrench, state: bytes) -> tuple[Array, Array, float] | None:
        """Return what bending adds to a pose, the error of it [m, rad], and its size [m]; None if singular.

        Coils see it where the second level rests, whatever finer ones change of that.
        """
        here, steps = starts(levels, scales, load, np.frombuffer(state))[0], self.steps(levels, scales, load, state)
        if steps is None:
            return None
        w, free = self.plate.upwards @ steps[0], [k for k in (1, 2, 4) if k in np.flatnonzero(levels.fine.freed)]
        seen = self.seen(scales.pose(here.q), np.asarray(steps.any(axis=0)))
        (own, lower, before), unlike = self.plate.as_motion(steps, seen, free)
        limit = extrapolated([before, own], levels.terms[:2], pressed=levels.fine.pressed(here), early=1.0)
        stretched = min(1.0, (np.ptp(w) / self.plate.target.thickness) ** 2 / 2.0)
        shapes = np.maximum(np.abs(own - lower), _SHAPES * np.abs(own))
        off = limit.error + shapes + stretched * np.abs(limit.value)
        off[1] += unlike[0]
        return limit.value, off, float(np.abs(w).max())

    def steps(self, levels: Levels, scales: Scales, load: Wrench, state: bytes) -> Array | None:
        """Return q and a less those of the rigid target, (3, 6 + m) [m, rad], None if singular.

        On the second level, there by shapes of two degrees less, and on the first level.
        """
        pairs = zip((levels.fine, levels.coarse), starts(levels, scales, load, np.frombuffer(state)), strict=True)
        each = [self._step(body, here, scales, load) for body, here in pairs]
        good = [one for one in each if one is not None]
        return np.concatenate([good[0], good[1][:1]]) if len(good) == len(each) else None

    def _step(self, body: Bonded, here: State, scales: Scales, load: Wrench) -> Array | None:
        """Return q and a less those of the rigid target on a mesh, by all shapes and those of two degrees less."""
        body, (length, force) = body.near(here.u), (scales.lengths[1], scales.loads[1])
        shapes, some, degrees = self._on(body, scales.thickness)
        found = bending_equations(body, here, shapes)
        if found is None:
            return None
        (S, left), n = found, int(body.freed.sum())
        S[n:, n:] += some.T @ self.plate.plate @ some * (self.stiffness * length / force)
        left[n:] -= some.T @ self.plate.work(load)[6:] / force
        steps = np.zeros((2, 6 + len(some)))
        for step, most in zip(steps, (np.inf, degrees.max() - 2), strict=True):
            rows = np.append(np.arange(n), n + np.flatnonzero(degrees <= most))
            way = np.zeros(len(left))
            way[rows] = np.linalg.solve(S[np.ix_(rows, rows)], -left[rows])
            step[np.flatnonzero(body.freed)] = way[:n] * scales.lengths[np.flatnonzero(body.freed)]
            step[6:] = length * some @ way[n:]
        return steps

    def _on(self, body: Bonded, thickness: float) -> tuple[Array, Array, Array]:
        """Return shapes that a body's symmetry allows at its bonded nodes, (n, d, k), of which, (m, k), and degrees."""
        some, degrees = np.eye(len(self.plate.even)), self.plate.degrees.sum(axis=1)
        if body.mesh.hoop:
            r = np.hypot(*self.plate.places.T) / self.plate.target.extent[0]
            degrees = np.arange(2, int(degrees.max()) + 1, 2)
            even = r[:, None] ** degrees
            even -= self.plate.areas @ even / self.plate.areas.sum()
            some = np.linalg.lstsq(self.plate.upwards[:, 6:], even, rcond=None)[0]
        elif body.components < 6:
            some, degrees = some[:, self.plate.even], degrees[self.plate.even]
        return self.plate.bonded(body, thickness) @ some, some, degrees
