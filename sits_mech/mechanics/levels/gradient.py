"""Differentiate the pose of a target at rest by its load and by parameters of its scene.

On one mesh the free displacements u and the target's motion q are at rest where the forces left on them vanish,

    R(u, q; s) = 0,      R = (R_u, R_q),

s a number of the scene: a constant of the law, a length, which moves the nodes of the same cells, or what the scaled
load is made of. With K = dR_u/du factored, the motion B = -K^-1 dR_u/dq that follows the target's, and the stiffness S
that the target has (equilibrium/linearisation.py),

    dq/ds = -S^-1 d/ds [ B^T R_u + R_q ],       u and q held,

the virtual work of three or six motions: one factor serves all parameters, and a parameter costs the forces on two
changed meshes. Their difference, B held, is the derivative to some 1e-7; bonded nodes are where the changed target has
them. By the load itself ``dq/df = S^-1 w``, w what its components work with; on the components that half a pad hides,
by the stiffness there. Increments of a rotation become those of its vector (rotations.py).

Poses are extrapolated from the levels of a family (family.py), linearly: so are their derivatives, from the same
levels, with an error from their own sequence, and what is beyond the meshes in the pose's error (creases, contact left
out) in proportion. States of finer levels are only nearly at rest: they go one step on, and B with them by the same
factor; a level that does not come to rest then is left out. At small strain R is linear in u and q.

Source: K. K. Choi, N. H. Kim, Structural Sensitivity Analysis and Optimization 1 (2005), chapter 6, direct and adjoint
derivatives of condensed equations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import NamedTuple

import numpy as np
from numpy.linalg import solve

from sits_mech.mechanics.element.kernel import element_forces, small_strain_forces
from sits_mech.mechanics.element.target import all_six, bonded_tangent, moved, work_of_load
from sits_mech.mechanics.equilibrium.body import Bonded, State, rest, smallest_volume, unpack_state
from sits_mech.mechanics.equilibrium.control import Scales
from sits_mech.mechanics.equilibrium.elimination import eliminated
from sits_mech.mechanics.equilibrium.linearisation import (
    Factor,
    Residuals,
    factored,
    hidden_stiffness,
    on_motions,
    residuals_of,
    way_of,
)
from sits_mech.mechanics.equilibrium.outcome import StepTarget
from sits_mech.mechanics.levels.answer import errors_of, relative
from sits_mech.mechanics.levels.family import Levels, Line
from sits_mech.quantities import Array, Equilibrium, SolveFailed
from sits_mech.rotations import vector_rates
from sits_mech.scene.parameters import Parameter, SceneStencil
from sits_mech.scene.sensor import SceneError, Sensor

_OWNS = 1.2  # times what levels say of derivatives: of tilt under a narrower disc 1.1 (test_axisymmetric)
_TURN = np.array([4, 2, 5])  # where the rotation vector stands among the components of a motion
_AT_REST = 1e-6  # of the target's way, a step that leaves a state as it is
_FALLS = 0.1  # of the forces left, what that step may leave
_WAY = 1e-5  # along the motions B, for differences [thicknesses]


@dataclass(frozen=True)
class Family:
    """What an equilibrium was solved on."""

    levels: Levels
    scales: Callable[[Sensor], Scales]
    sensor: Sensor
    states: Sequence[Array] = ()  # packed, of the levels extrapolated from, coarsest first; none at small strain
    small: int = 0  # levels with a compliance at small strain, else 0
    sideways: bool = False  # include F_y, M_x, M_z of half a pad: one more factor a level


@dataclass(frozen=True)
class PoseSlopes:
    """Derivatives of a pose by n parameters and by the wrench, with absolute errors."""

    names: tuple[str, ...]
    pose: Array  # (6, n) [m or rad per SI unit]
    error: Array  # (6, n)
    compliance: Array  # (6, 6) [m or rad per N or N m]; nan if not modelled
    error_compliance: Array  # (6, 6)


class _Level(NamedTuple):
    """A level at rest: motions B that follow the target's, stiffness S on them, and that hidden by symmetry."""

    body: Bonded
    state: State
    load: Array
    B: Array
    S: Array
    hidden: Array | None
    small: int

    @property
    def q(self) -> Array:
        """Motion of the target."""
        return self.state.q

    def work(self, body: Bonded, load: Array) -> Array:
        """Return the virtual work of residual forces in a body with the same cells, shape (k,)."""
        q, u = self.state.q, self.state.u.copy()
        if not self.small:
            u[body.bonded] = body.with_target(q)
            own = replace(body.near(u), shared=lambda: self.body.pattern)
            found = residuals_of(own, replace(self.state, u=u, load=load, known=None))
            return self.B.T @ found.free + found.target
        T = bonded_tangent(body.X, np.zeros(6))[:, list(body.mesh.axes), : len(q)]
        u[body.bonded] = T @ q
        forces = small_strain_forces(body.mesh, body.laws, u)
        on_target = np.tensordot(T, forces[body.bonded], axes=((0, 1), (0, 1)))
        on_target = on_target - work_of_load(load, body.height, np.zeros(6))[: len(q)]
        return self.B.T @ forces[body.free] + on_target


def solved_family(line: Line, found: Equilibrium, scales: Callable[[Sensor], Scales], sideways: bool = False) -> Family:
    """Return the family of a line that an equilibrium is on, with its states as far as known.

    Raise ValueError for an equilibrium without state (such as an image), SceneError for contact with friction.
    """
    if found.state.size < 2:
        raise ValueError("equilibrium: must be one of this model with its state, got one without")
    levels = line[int(found.state[0])]
    fine, coarse = np.split(found.state[1:], [levels.fine.size])
    if line.sensor.elastomer is not None and line.sensor.elastomer.friction > 0.0 and levels.fine.parts:
        raise SceneError("elastomer.friction: must be 0 for a gradient where faces touch: answers depend on their way")
    finer = takewhile(lambda state: state.size > 0, found.finer)
    return Family(levels, scales, line.sensor, (coarse, fine, *finer), sideways=sideways)


def equilibrium_slopes(family: Family, found: Equilibrium, parameters: Sequence[Parameter]) -> PoseSlopes:
    """Return the derivatives of a pose by its load and by parameters of its scene.

    Raise SceneError for a parameter that changes the cells or contact with friction, SolveFailed for a target without
    stiffness.
    """
    stencils = [each.stencil(lambda sensor: family.levels.changed(sensor, 0) is not None) for each in parameters]
    levels: list[_Level] = []
    by_load, by_each = [], []
    for number in range(family.small or len(family.states)):
        level = _linearised(family, number, found)
        if level is None:
            if number > 1:
                break
            raise SolveFailed("gradient: the target has no stiffness under this load", found.report, found)
        turns = np.eye(6)  # from increments (dc, dw) to those of the motion's components
        turns[np.ix_(_TURN, _TURN)] = vector_rates(all_six(level.q)[_TURN])
        by_load.append(turns @ _by_load(level))
        by_each.append(turns @ _by_each(family, number, found, level, stencils))
        levels.append(level._replace(B=level.B[:0]))
    family = replace(family, levels=family.levels.folding((levels[0].state, levels[1].state)))
    scales, beyond = family.scales(family.sensor), _beyond(family, found, levels)
    compliance = _limit(family, levels, by_load, scales.lengths[:, None] / scales.loads, beyond)
    pose, error = _limit(family, levels, by_each, scales.lengths[:, None], beyond)
    q = (found.pose.components - scales.pose(np.zeros(6)).components) / scales.lengths
    for column, stencil in enumerate(stencils):  # what the motion's units change
        moved = (weight * family.scales(sensor).pose(q).components for sensor, _, weight in stencil.places)
        pose[:, column] += stencil.own * scales.pose(q).components + sum(moved)
    unknown = _unknown(levels)
    for each in compliance:
        each[unknown] = each[:, unknown] = np.nan
    return PoseSlopes(tuple(each.name for each in parameters), pose, error, *compliance)


def _unknown(levels: Sequence[_Level]) -> list[int]:
    """Return the components that are not modelled: about an axis the turn about it, and in contact all but d_v."""
    known = all(level.hidden is not None for level in levels)
    if levels[0].body.mesh.hoop:
        return [5] if known else [0, 2, 3, 4, 5]
    return [3, 4, 5] if levels[0].body.components < 6 and not known else []


def _linearised(family: Family, number: int, found: Equilibrium) -> _Level | None:
    """Linearise one level at rest; None without stiffness."""
    body, k = family.levels.maker(number), family.levels.fine.components
    load = family.scales(family.sensor).load(found.wrench)[:k]
    if family.small:
        here = rest(body)
    else:
        here = unpack_state(body, family.states[number], load)
        body = body.near(here.u)
        least = smallest_volume(body, here.u, everywhere=True)
        here = replace(here, p=element_forces(body.mesh, body.laws, here.u).pressure, min_J=least)
    factor = factored(body, here, residuals_of(body, here))
    if factor is None:
        return None
    found_there = (here, factor.by_q, factor.stiffness) if family.small else _settled(body, here, factor)
    if found_there is None:
        return None
    here, B, S = found_there
    asked = not body.pressed(here) if body.mesh.hoop else family.sideways
    hidden = hidden_stiffness(body, factor.made) if asked else None
    if not np.all(np.isfinite(S)) or not np.linalg.cond(S) < 1.0 / np.finfo(float).eps:
        return None
    if family.small:
        given = work_of_load(load, body.height, np.zeros(6))[:k] - factor.side.T @ factor.step
        here = replace(here, q=np.asarray(solve(S, given - residuals_of(body, here).target), dtype=float))
        here.u[body.free] = B @ here.q + factor.step
    return _Level(body, here, load, B, S, hidden, family.small)


def _settled(body: Bonded, here: State, factor: Factor) -> tuple[State, Array, Array] | None:
    """Take one more step, with B there by the previous factor; None where it does not lead to rest.

    The change of forces along an older B, (r_u, r_q) = (K B + C, C^T B + D), corrects B by -K^-1 r_u; the stiffness is
    then r_q + B^T r_u.
    """
    held = np.zeros(body.components, dtype=bool)
    before, B = residuals_of(body, here), factor.by_q
    way = way_of(body, here, before, factor, StepTarget(held, np.zeros(body.components)))
    if way is None or body.length(way.q) <= _AT_REST * body.length(here.q):
        return here, B, factor.stiffness
    gone = eliminated(body, here, before, factor, way)
    if gone is None or gone[1] < 1.0 or not _left(gone[2]) < _FALLS * _left(before):
        return None
    on_free, on_target = _along_motions(body, gone[0], B)
    B = B - factor.of_free.solve(on_free)
    return gone[0], B, on_motions(body, on_target + B.T @ on_free)


def _left(found: Residuals) -> float:
    """Return the size of the residual forces."""
    return float(np.linalg.norm([*found.free, *found.target]))


def _along_motions(body: Bonded, here: State, B: Array) -> tuple[Array, Array]:
    """Return the change of forces on free displacements (m, k) and target (k, k) along the motions B."""
    columns = []
    for k, motion in enumerate(np.eye(body.components)):
        ends = []
        for way in (_WAY, -_WAY):
            u, q = here.u.copy(), moved(here.q, way * motion)
            u[body.free] += way * B[:, k]
            u[body.bonded] = body.with_target(q)
            found = residuals_of(body, replace(here, u=u, q=q, known=None))
            ends.append(np.concatenate([found.free, found.target]))
        columns.append((ends[0] - ends[1]) / (2.0 * _WAY))
    both = np.stack(columns, axis=1)
    return both[: len(body.free)], both[len(body.free) :]


def _by_load(level: _Level) -> Array:
    """Return motion increments by load components, shape (6, 6), scaled; zero where unknown."""
    k, found = len(level.S), np.zeros((6, 6))
    turned = np.zeros(6) if level.small else all_six(level.q)  # where the load works
    work = np.stack([work_of_load(unit, level.body.height, turned) for unit in np.eye(6)], axis=1)
    if level.body.mesh.hoop and level.hidden is not None:
        found[1, 1], other = work[1, 1] / level.S[1, 1], np.array([[1.0, -1.0], [-1.0, 1.0]])
        for own, S in (([3, 4], level.hidden), ([0, 2], other * level.hidden)):  # alpha_x against alpha
            found[np.ix_(own, own)] = solve(S, work[np.ix_(own, own)])
        return found
    found[:k, :k] = solve(level.S, work[:k, :k])
    if level.hidden is not None:
        found[k:, k:] = solve(level.hidden, work[k:, k:])
    return found


def _by_each(family: Family, number: int, found: Equilibrium, level: _Level, stencils: Sequence[SceneStencil]) -> Array:
    """Return motion increments by parameters, shape (6, n), scaled."""
    increments = np.zeros((6, len(stencils)))
    k = len(level.S)
    for column, stencil in enumerate(stencils):
        work = stencil.own * level.work(level.body, level.load) if stencil.own else np.zeros(k)
        for sensor, _, weight in stencil.places:
            body = family.levels.changed(sensor, number)
            if body is None:
                raise SceneError("gradient: a finer mesh has other cells beside this scene; change the sizes a little")
            work = work + weight * level.work(body, family.scales(sensor).load(found.wrench)[:k])
        increments[:k, column] = -solve(level.S, work)
    return increments


def _beyond(family: Family, found: Equilibrium, levels: Sequence[_Level]) -> float:
    """Return the part of the pose's error beyond that of the meshes, over the displacement."""
    lever, sunk = family.levels.fine.reach()[: len(levels[0].S)], family.levels.fine.sunk(levels[1].q)
    limit = family.levels.limit([level.q * lever for level in levels], sunk=sunk)
    return max(found.report.estimated_error - relative(limit.error, limit.value), 0.0)


def _limit(
    family: Family, levels: Sequence[_Level], values: Sequence[Array], unit: Array, beyond: float
) -> tuple[Array, Array]:
    """Extrapolate derivatives over the levels with errors, shape (6, n), in a unit.

    What edges that a press opens add goes with the square of the sink, which changes as well (family.py).
    """
    limit, lever, sunk = family.levels.limit, family.levels.fine.reach(), family.levels.fine.sunk(levels[1].q)
    poses = [all_six(level.q) * lever for level in levels]
    opened = 2.0 * (limit(poses, sunk=sunk).value - limit(poses).value) / (sunk[0] or 1.0)
    found = np.zeros((2, *values[0].shape))
    for column in range(values[0].shape[1]):
        value, off, _ = limit([each[:, column] * lever for each in values], sunk=sunk)
        error = errors_of(_OWNS * off + beyond * np.abs(value), family.levels.share)
        found[:, :, column] = np.stack([value - opened * values[1][1, column], error]) / lever
    return found[0] * unit, found[1] * unit
