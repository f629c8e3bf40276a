"""Eliminate the cells at rims from Newton's method: bring them to rest by themselves after each of its steps.

At a rim, where a free face meets a bonded one, strains are singular, and Newton's method on the layer fails on a few
cells there, with the target's place long settled. With their displacements I (element/patch.py), O all others and the
target's motion q, the equations f = 0 of the layer are those of O and q alone,

    f_O(u_O, u_I(u_O, q), q) = 0,        where    f_I(u_O, u_I, q) = 0    gives u_I.

A step of Newton's method on the whole layer, as far as J stays positive outside of the patch, moves O and q; then I is
brought to rest again. The step is shortened where |f_O| does not fall: it is that problem's merit function, as the
potential, with K/mu of 1000, lets only tiny steps down.

The patch follows its boundary, B, by parts of the way b that is left of it. A step is that of

    (K_II + d L_II) du_I = -f_I - (K + d L)_IB du_B,       du_B = b,   or 0 while f_I is not small,

as far as J stays positive. The damping d grows until no pivot is negative: cells at a rim fold in more than one way,
and a rest is looked for that is stable by itself.

Source: X.-C. Cai, D. Keyes, SIAM J. Sci. Comput. 24 (2002) 183; F.-N. Hwang, X.-C. Cai, Comput. Methods Appl. Mech.
Engng 196 (2007) 1603.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.assembly import Factored, Stiffness
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
from sits_mech.mechanics.equilibrium.body import ROUNDING, Bonded, State, deformed_state, smallest_volume
from sits_mech.mechanics.equilibrium.linearisation import MIN_J_KEPT, Factor, Gradient, Step, gradient, increments
from sits_mech.quantities import Array, Integers

_MOST = 40  # factorisations of a patch on its way
_BETWEEN = 8  # steps after which B moves on anyway
_LEAST = 0.02  # of what is left of the way: less is not gone at once, there is more damping instead
_DAMPED, _MORE, _TOO_STIFF = 0.1, 4.0, 100.0  # least damping [shear moduli], how it grows, and its end
_RISES, _FALLS = 1.5, 0.3  # of f_I: damping grows beyond the one, and is let go below the other
_SMALL, _LEFT = 5e-3, 0.1  # of the load's size, f_I at which B moves on; of |f_O|, f_I at the end
_SHORTEN, _SHORTEST, _TRIES = 0.3, 0.05, 3  # of a step: each time, at most; how often where |f_O| does not fall
_FALL, _AT_REST = 0.1, 1e-10  # of a step's part, by which |f_O| has to fall; of the load's size, f_I at rest
_CALM = 0.05  # |f_O|, over the load's size, below which a step may raise it


class Followed(NamedTuple):
    """A patch that followed its boundary."""

    u: Array  # displacements of the layer, I at rest
    p: Array  # (e, m), the patch's pressures
    part: float  # of the boundary's way that was gone


def followed(
    body: Bonded, patch: Patch, start: tuple[Array, Array], end: tuple[Array, Array], small: tuple[float, float]
) -> Followed:
    """Move a patch's boundary from where it is to its end, and bring I to rest.

    `start`: displacements of the layer, and the patch's pressures; `end`: displacements, and q; `small`: norms of f_I
    at which B moves on, and at which I is at rest.
    """
    (here, p), (way, q), inner, law = start, end, patch.inner, body.law.part(patch.cells)
    way = way - here
    way[inner] = 0.0
    left, damped, before, since, count = 1.0 * bool(way.any()), 0.0, np.inf, 0, 0
    while count < _MOST:
        known = deformed(patch.mesh, here)
        found = element_forces(patch.mesh, law, body.K, here, known, body.swelling)
        terms = [term for part in body.parts if len((term := part(here, q)).numbers)]
        forces = found.forces + sum((term.forces[: len(here)] for term in terms), np.zeros(len(here)))
        size = float(np.linalg.norm(forces[inner]))
        if left == 0.0 and size <= small[1]:
            break
        if since > 1 and size > _RISES * before:
            damped = max(_MORE * damped, _DAMPED)
        elif size < _FALLS * before:
            damped = damped / _MORE if damped > _DAMPED / _MORE else 0.0
        stiffness = element_stiffness(patch.mesh, law, body.K, here, p, known)
        numbers, own = (patch.mesh.dofs, *(each.numbers for each in terms)), [each.stiffness for each in terms]
        factor, values, damped, tries = _stable(patch, numbers, (stiffness, *own), damped)
        count += tries
        if factor is None:
            break
        moves = left > 0.0 and (size <= small[0] or since >= _BETWEEN or count == tries)
        step = left * way if moves else np.zeros_like(way)
        step[inner] = factor.solve(-(forces + (_product(numbers, values, step) if moves else 0.0))[inner])
        volume = known.J - body.swelling + (kinematics(known.F).H * gradients(patch.mesh, step)).sum(axis=-1)
        part, least = 1.0, MIN_J_KEPT * min(found.min_J, 1.0)
        while part > _LEAST and not deformed(patch.mesh, here + part * step).J.min() > least:
            part *= 0.5
        if part <= _LEAST:
            if damped >= _TOO_STIFF:
                break
            damped, since = max(_MORE * damped, _DAMPED), since + 1
            continue
        here, p = here + part * step, p + part * (body.K * volumes(patch.mesh, volume) - p)
        if moves:
            left, before, since = left * (1.0 - part), np.inf, 0
        else:
            before, since = size, since + 1
            damped = max(_MORE * damped, _DAMPED) if part < 1.0 else damped
    return Followed(here, p, 1.0 - left)


def _stable(
    patch: Patch, numbers: tuple[Integers, ...], values: Stiffness, damped: float
) -> tuple[Factored | None, Stiffness, float, int]:
    """Factor K_II + d L_II, d as given or the least more that leaves no negative pivot; return d and the tries."""
    tries, own = 0, patch.pattern.following(numbers)
    while damped <= _TOO_STIFF:
        each = (values[0] + damped * patch.laplacian if damped else values[0], *values[1:])
        factor, tries = own.factored(each), tries + 1
        if factor is not None and not factor.negative:
            return factor, each, damped, tries
        damped = max(_MORE * damped, _DAMPED)
    return None, values, damped, tries


def _product(numbers: tuple[Integers, ...], values: Stiffness, step: Array) -> Array:
    """Return the stiffnesses times displacements (n,), those of q held."""
    n = len(step)
    full, found = np.concatenate([step, np.zeros(6)]), np.zeros(n + 6)
    for own, each in zip(numbers, values, strict=True):
        found += summed(own, (each @ full[own][..., None])[..., 0], n + 6)
    return found[:n]


def eliminated(
    body: Bonded, patch: Patch, here: State, found: Gradient, factor: Factor, way: Step
) -> tuple[State, float, Gradient] | None:
    """Return the state after a part of Newton's step with the patch at rest, that part, and the gradient there."""
    step, before = increments(body, here, factor, way), _outside(patch, found)
    size, least = max(float(np.linalg.norm(here.load)), ROUNDING * body.K), np.inf
    best: tuple[State, float, Gradient] | None = None
    part, tries = 1.0, 0
    while part > _SHORTEST and tries < _TRIES:
        there = _gone(body, patch, here, (*step, way), part, (_SMALL * size, max(_LEFT * before, _AT_REST * size)))
        if isinstance(there, float):
            part *= there
            continue
        after, tries = gradient(body, there), tries + 1
        left = _outside(patch, after)
        if best is None or left < least:
            best, least = (there, part, after), left
        if left <= max((1.0 - _FALL * part) * before, _CALM * size):
            break
        part *= _SHORTEN
    return best


def _gone(
    body: Bonded, patch: Patch, here: State, step: tuple[Array, Array, Step], part: float, small: tuple[float, float]
) -> State | float:
    """Return the state after a part of a step, or by how much it is to be shortened.

    A patch that the step would turn inside out follows its boundary from where it is.
    """
    (linear, p_full, way), cells = step, patch.cells
    u, q, p = here.u + part * linear, moved(here.q, part * way.q), here.p + part * (p_full - here.p)
    u[body.bonded] = body.with_target(q)
    before, J = deformed_state(body, here).J.min(axis=1), deformed(body.mesh, u).J.min(axis=1)
    held = [bool(J[own].min() > MIN_J_KEPT * min(float(before[own].min()), 1.0)) for own in (cells, ~cells)]
    if not held[1]:
        return 0.5
    start = (u, p[cells]) if held[0] else (here.u, here.p[cells])
    after = followed(body, patch, start, (u, q), small)
    if after.part < 1.0:
        return max(after.part, _SHORTEN)
    u[patch.inner], p[cells] = after.u[patch.inner], after.p
    known = deformed(body.mesh, u)
    min_J = smallest_volume(body, u, everywhere=False, known=known)
    if not min_J > 0.0:
        return _SHORTEN
    return replace(here, u=u, q=q, p=p, min_J=min_J, load=here.load + part * way.forces, known=known)


def _outside(patch: Patch, found: Gradient) -> float:
    """Return |f_O|, the forces on q included."""
    return float(np.hypot(np.linalg.norm(found.free[~patch.own]), np.linalg.norm(found.target)))
