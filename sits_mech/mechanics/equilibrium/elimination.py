"""Eliminate the cells at rims from Newton's method: bring them to rest by themselves after each of its steps.

At a rim, where a free face meets a bonded one, strains are singular, and Newton's method on the layer fails on a few
cells there, with the target's place long settled. With their displacements I (element/patch.py), O all others and the
target's motion q, the equations f = 0 of the layer are those of O and q alone,

    f_O(u_O, u_I(u_O, q), q) = 0,        where    f_I(u_O, u_I) = 0    gives u_I.

A step of Newton's method on the whole layer, as far as J stays positive outside of the patch, moves O and q; then I is
brought to rest again. The step is shortened where |f_O| does not fall: that problem's merit function, as the potential,
where K is much larger than mu, lets only steps of some sqrt(mu/K) down.

The patch follows its boundary B by parts of the way b that is left of it. A step is that of

    (K_II + d L_II) du_I = -f_I - (K + d L)_IB du_B,       du_B = b,   or 0 while f_I is not small,

as far as J stays positive. The damping d grows until no pivot is negative: cells at a rim fold in more than one way,
and a rest is looked for that is stable by itself.

Source: X.-C. Cai, D. Keyes, SIAM J. Sci. Comput. 24 (2002) 183; F.-N. Hwang, X.-C. Cai, Comput. Methods Appl. Mech.
Engng 196 (2007) 1603. Without contact.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.assembly import Factored
from sits_mech.mechanics.element.kernel import (
    deformed,
    element_forces,
    element_stiffness,
    gradients,
    kinematics,
    summed,
    volumes,
)
from sits_mech.mechanics.element.patch import Patch
from sits_mech.mechanics.element.target import moved
from sits_mech.mechanics.equilibrium.body import Bonded, State, deformed_state, smallest_volume
from sits_mech.mechanics.equilibrium.linearisation import (
    MIN_J_KEPT,
    Factor,
    NewtonStep,
    Residuals,
    increments,
    residuals_of,
    stepped,
)
from sits_mech.quantities import Array

_MOST = 60  # factorisations of a patch on its way: 10 pulls of `biorob2018` took 13 to 51
_DAMPED, _MORE, _TOO_STIFF = 0.1, 4.0, 100.0  # least damping [shear moduli], how it grows, and its end
_RISES, _FALLS = 1.5, 0.3  # of f_I in a step: damping grows beyond the one, and shrinks below the other
_LEAST_J, _LEAST = 0.5, 2.0**-8  # of J, what a step of a patch leaves, and of a step; by 0.2 of J it lost 7 of 11 pulls
_SMALL, _LEFT = 5e-3, 0.1  # of the load's size, f_I at which B moves on; of |f_O|, f_I at its end
_SHORTEN, _SHORTEST = 0.3, 0.05  # of a step, each time and at most: three tries
_FALL, _CALM = 0.1, 0.05  # of a step's part, by which |f_O| has to fall; of the load's size, |f_O| that may rise


class Relaxed(NamedTuple):
    """A patch that followed its boundary."""

    u: Array  # displacements of the layer, I at rest
    p: Array  # (e, m), the patch's pressures
    part: float  # of the boundary's way that was gone


def relaxed(body: Bonded, patch: Patch, start: tuple[Array, Array], end: Array, small: tuple[float, float]) -> Relaxed:
    """Move a patch's boundary from where it is to its end, and bring I to rest.

    `start`: displacements of the layer, and the patch's pressures; `end`: displacements; `small`: norms of f_I at which
    B moves on, and at which I is at rest.
    """
    (here, p), way, mesh, inner = start, end - start[0], patch.mesh, patch.inner
    way[inner] = 0.0
    left, damped, before, spent = 1.0 * bool(way.any()), 0.0, np.inf, 0
    laws = body.laws.part(patch.cells)
    while spent < _MOST:
        known = deformed(mesh, here)
        forces = element_forces(mesh, laws, here, known).forces
        size = float(np.linalg.norm(forces[inner]))
        if left == 0.0 and size <= small[1]:
            break
        moves = left > 0.0 and (size <= small[0] or not spent)
        factor, stiffness, damped, tries = _stable(body, patch, (here, p), _damping(damped, size, before))
        step, spent = left * way * moves, spent + tries
        if factor is None:
            break
        pushed = forces + summed(mesh.dofs, (stiffness @ step[mesh.dofs][..., None])[..., 0], len(step))
        step[inner] = factor.solve(-pushed[inner])
        volume = known.J - laws.swelling + (kinematics(known.F).H * gradients(mesh, step)).sum(axis=-1)
        part = _part(patch, here, step, _LEAST_J * min(float(known.J.min()), 1.0))
        here, p = here + part * step, p + part * (laws.K * volumes(mesh, volume) - p)
        left, before = left * (1.0 - part * moves), np.inf if moves * part else size
        damped = _stiffer(damped) if before == size and part < 1.0 else damped
    return Relaxed(here, p, 1.0 - left)


def _part(patch: Patch, here: Array, step: Array, least: float) -> float:
    """Return the part of a step, halved and halved again, up to which a patch keeps J > `least`; 0 if little."""
    part = 1.0
    while part > _LEAST and not deformed(patch.mesh, here + part * step).J.min() > least:
        part *= 0.5
    return part * (part > _LEAST)


def _damping(damped: float, size: float, before: float) -> float:
    """Return the damping after a step with |f_I| after and before it."""
    if size > _RISES * before:
        return _stiffer(damped)
    if size < _FALLS * before:
        return damped / _MORE if damped > _DAMPED / _MORE else 0.0
    return damped


def _stiffer(damped: float) -> float:
    """Return more damping, up to the largest one."""
    return min(max(_MORE * damped, _DAMPED), _TOO_STIFF)


def _stable(
    body: Bonded, patch: Patch, at: tuple[Array, Array], damped: float
) -> tuple[Factored | None, Array, float, int]:
    """Return the factored K_II + d L_II and K + d L, d as given or the least more without negative pivot; d; tries."""
    stiffness, tries = element_stiffness(patch.mesh, body.laws.part(patch.cells), *at), 0
    while damped <= _TOO_STIFF:
        each, tries = (stiffness + damped * patch.laplacian if damped else stiffness), tries + 1
        factor = patch.pattern.factored((each,))
        if factor is not None and not factor.negative:
            return factor, each, damped, tries
        damped = max(_MORE * damped, _DAMPED)
    return None, stiffness, damped, tries


def eliminated(
    body: Bonded, here: State, found: Residuals, factor: Factor, way: NewtonStep
) -> tuple[State, float, Residuals] | None:
    """Return the state after a part of Newton's step with the patch at rest, that part, and the gradient there.

    Without a patch the potential is descended.
    """
    if (patch := body.patch) is None:
        return stepped(body, here, found, factor, way, np.zeros(body.components, dtype=bool), falling=True)
    step, before, best = increments(body, here, factor, way), _outside(patch, found), None
    size, least, part = max(float(np.linalg.norm(here.load)), body.rounding), np.inf, 1.0
    while part > _SHORTEST:
        there = _gone(body, patch, here, (*step, way), part, (_SMALL * size, _LEFT * before))
        if there is not None:
            after = residuals_of(body, there)
            if (left := _outside(patch, after)) < least:
                best, least = (there, part, after), left
            if left <= max((1.0 - _FALL * part) * before, _CALM * size):
                break
        part *= _SHORTEN
    return best


def _gone(
    body: Bonded, patch: Patch, here: State, step: tuple[Array, Array, NewtonStep], part: float,
    small: tuple[float, float]
) -> State | None:
    """Return the state after a part of a step, None if that turns cells inside out or the patch cannot follow.

    A patch that the step would turn inside out follows its boundary from where it is.
    """
    (linear, p_full, way), cells = step, patch.cells
    u, q, p = here.u + part * linear, moved(here.q, part * way.q), here.p + part * (p_full - here.p)
    u[body.bonded] = body.with_target(q)
    before, J = deformed_state(body, here).J.min(axis=1), deformed(body.mesh, u).J.min(axis=1)
    good, outside = (J[own].min() > MIN_J_KEPT * min(float(before[own].min()), 1.0) for own in (cells, ~cells))
    if not outside:
        return None
    after = relaxed(body, patch, (u, p[cells]) if good else (here.u, here.p[cells]), u, small)
    u[patch.inner], p[cells] = after.u[patch.inner], after.p
    known = deformed(body.mesh, u)
    min_J = smallest_volume(body, u, everywhere=False, known=known)
    if after.part < 1.0 or not min_J > 0.0:
        return None
    return replace(here, u=u, q=q, p=p, min_J=min_J, load=here.load + part * way.forces, known=known)


def _outside(patch: Patch, found: Residuals) -> float:
    """Return |f_O|, the forces on q included."""
    return float(np.hypot(np.linalg.norm(found.free[~patch.own]), np.linalg.norm(found.target)))
