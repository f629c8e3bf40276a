"""Bring some cells of a layer to rest by themselves, while their boundary moves: the cells at a bonded rim.

At a rim, where a free face meets a bonded one, strains are singular, and Newton's method on the layer fails there
first, on a few cells, with the target's place long settled. Those cells are a patch: with their inner displacements I,
which no other cell touches, and the boundary B, its outer and bonded nodes, it rests where

    f_I(u_I, u_B) = 0.

B goes from a state at rest to where it is to be, by ``(1 - s) b`` of a way b that is left. A step is that of

    (K_II + d L_II) du_I = -f_I - (K + d L)_IB du_B,       du_B = b,   or 0 while f_I is not small,

as far as J stays positive, with K of the mixed element (linearisation.py) and L of ``int grad v : grad u``, mu = 1. The
damping d grows until K_II + d L_II has no negative pivot: cells fold in more than one way, and a rest that is stable by
itself is looked for. The potential is no measure there: with K/mu of 1000 it lets only tiny steps down.

Source: X.-C. Cai, D. Keyes, SIAM J. Sci. Comput. 24 (2002) 183; F.-N. Hwang, X.-C. Cai, Comput. Methods Appl. Mech.
Engng 196 (2007) 1603, nonlinear elimination; studies of the numbers below: tests/mechanics/equilibrium/test_patch.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.mechanics.element.assembly import Factored, Pattern, pattern
from sits_mech.mechanics.element.kernel import (
    deformed,
    element_forces,
    element_stiffness,
    gradients,
    kinematics,
    summed,
    volumes,
)
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.quantities import Array, Integers, Mask

_MOST = 60  # factorisations
_SMALL, _AT_END = 0.05, 0.01  # of the size of the load: f_I at which B moves on, and at which it has come to its end
_BETWEEN = 8  # steps after which B moves on anyway
_KEPT = 0.2  # of the smallest J, at least, after a step
_LEAST = 0.02  # of the way that is left: less is not gone, there is more damping instead
_DAMPED, _MORE = 0.1, 4.0  # first damping [shear moduli], and how it grows
_TOO_STIFF = 100.0  # damping, beyond which there is none


@dataclass(frozen=True, eq=False)
class Patch:
    """Some cells of a layer's mesh, with displacements of their own."""

    cells: Integers  # (e,), numbers in the layer
    mesh: MixedMesh  # the cells alone, on all nodes of the layer
    inner: Integers  # (m,), numbers of the displacements I
    pattern: Pattern
    laplacian: Array  # (e, d k, d k), L


def rim(body: Bonded) -> Mask:
    """Whether a cell touches a rim, an edge or corner that a free face shares with ground or target, (e,)."""
    skin, d = body.faces.skin, len(body.mesh.axes)
    if skin is None:
        return np.zeros(len(body.mesh.cells), dtype=bool)
    nodes = np.unique(skin.surface.nodes)
    held = nodes[~np.isin(d * nodes, body.free)]
    return np.asarray(np.isin(body.mesh.cells, held).any(axis=1))


def patch_of(body: Bonded, cells: Mask) -> Patch:
    """Return the patch of some of a layer's cells, (e,)."""
    mesh, d = body.mesh.part(cells), len(body.mesh.axes)
    own = np.zeros(body.mesh.nodes.size, dtype=bool)
    own[mesh.dofs] = True
    own[body.mesh.dofs[~cells]] = False
    inner = body.free[own[body.free]]
    slope, weights = mesh.inside
    e, _, _, k = slope.shape
    each = np.einsum("eq,eqda,eqdb->eab", weights, slope, slope, optimize=True)
    laplacian = np.zeros((e, d, k, d, k))
    for i in range(d):
        laplacian[:, i, :, i] = each
    made = pattern(mesh, (mesh.dofs,), inner, np.zeros(0, dtype=np.int64))
    return Patch(np.flatnonzero(cells), mesh, inner, made, laplacian.reshape(e, d * k, d * k))


def carried(body: Bonded, patch: Patch, rest: Array, u: Array, size: float) -> tuple[Array, Array] | None:
    """Return the displacements with I at rest, and the patch's pressures (e, m); None where it cannot follow.

    `rest`: displacements of the layer at rest, from which the boundary goes to that of `u`; `size` of its load.
    """
    mesh, inner = patch.mesh, patch.inner
    way, here = u - rest, rest.copy()
    way[inner] = 0.0
    p = body.K * volumes(mesh, deformed(mesh, here).J - body.swelling)
    left, damped, before, waited = 1.0, 0.0, np.inf, 0
    for count in range(_MOST):
        known = deformed(mesh, here)
        found = element_forces(mesh, body.law, body.K, here, known, body.swelling)
        forces = float(np.linalg.norm(found.forces[inner]))
        if left == 0.0 and forces <= _AT_END * size:
            out = u.copy()
            out[inner] = here[inner]
            return out, p
        moves = left > 0.0 and (forces <= _SMALL * size or waited >= _BETWEEN)
        if waited >= 2:
            damped = max(_MORE * damped, _DAMPED) if forces > 1.5 * before else damped
        if forces < 0.3 * before:
            damped = damped / _MORE if damped > 0.02 else 0.0
        stiffness = element_stiffness(mesh, body.law, body.K, here, p, known)
        factor, damped, stiffness = _stable(patch, stiffness, damped)
        if factor is None:
            return None
        step = left * way if moves else np.zeros_like(way)
        pushed = summed(mesh.dofs, (stiffness @ step[mesh.dofs][..., None])[..., 0], len(step)) if moves else 0.0
        step[inner] = factor.solve(-(found.forces + pushed)[inner])
        volume = known.J - body.swelling + (kinematics(known.F).H * gradients(mesh, step)).sum(axis=-1)
        part = 1.0
        while part > _LEAST and deformed(mesh, here + part * step).J.min() <= _KEPT * min(found.min_J, 1.0):
            part *= 0.5
        if part <= _LEAST:
            if damped > _TOO_STIFF:
                return None
            damped, waited = max(_MORE * damped, _DAMPED), waited + 1
            continue
        here, p = here + part * step, p + part * (body.K * volumes(mesh, volume) - p)
        if moves:
            left = 0.0 if part == 1.0 else left * (1.0 - part)
            before, waited = np.inf, 0
        else:
            before, waited = forces, waited + 1
            damped = max(_MORE * damped, _DAMPED) if part < 1.0 else damped
    return None


def _stable(patch: Patch, stiffness: Array, damped: float) -> tuple[Factored | None, float, Array]:
    """Factor K_II + d L_II with the least damping that leaves no negative pivot; None where there is none."""
    while damped <= _TOO_STIFF:
        each = stiffness + damped * patch.laplacian if damped else stiffness
        factor = patch.pattern.factored((each,))
        if factor is not None and not factor.negative:
            return factor, damped, each
        damped = max(_MORE * damped, _DAMPED)
    return None, damped, stiffness
