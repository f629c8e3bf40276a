"""Move the nodes bonded to the rigid target, and apply dead loads to it.

The target is exactly rigid: its motion q has the components of a pose, ``(d_h, d_z, alpha, d_y, alpha_x, alpha_z)``, or
the first three of them in the plane y = 0; `d_z` is minus the sink. They are the displacement c = (d_h, d_y, d_z) of
the centre of its bottom face and the rotation vector w = (alpha_x, alpha, alpha_z) of its rotation R, of any size. A
bonded point X, from that centre, moves by

    u = c + (R - 1) X,        du = dc + dw x (R X),

dw the turn on from there, by the right hand: increments of q are (dc, dw), and R goes on to exp([dw]) R, so that
nothing is singular at any rotation. A force F keeps its direction and acts at the material point h = (0, 0, height)
above the centre, a moment M has fixed axes; against ``dc`` and ``dw`` they work with

    F    and    M + (R h) x F,        F = (F_x, F_y, -F_z),   M = (M_x, M, M_z),

and the second changes with dw by ``-[F][R h] dw``, as forces f on the bonded nodes, at x = R X, turn their moment by
``sum [f][x] dw``. Neither is symmetric: a moment about fixed axes has no potential, in the plane alone.

Unknowns eliminated this way need no penalty and no multiplier. Scaled: lengths by the thickness of the layer, forces by
shear modulus times thickness squared (per depth: times thickness), moments by that times the thickness. Source: J. C.
Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Engng 58 (1986) 79, for increments of finite rotations.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array
from sits_mech.rotations import cross_matrix, rotation_matrix, rotation_vector

ORDER = np.array([0, 2, 4, 1, 3, 5])
"""Places of the components of q among those of (c, w) along x, y, z."""
_CENTRE, _TURN = [0, 3, 1], [4, 2, 5]  # where those of c and of w stand in q


def placed(q: Array) -> tuple[Array, Array]:
    """Return displacement (3,) [thicknesses] and rotation (3, 3) of the target's centre."""
    whole = all_six(q)
    return whole[_CENTRE], rotation_matrix(whole[_TURN])


def all_six(q: Array) -> Array:
    """Return a motion, a step or a load with all its components, those out of the plane zero where it has three."""
    whole = np.zeros(6)
    whole[: len(q)] = q
    return whole


def moved(q: Array, step: Array) -> Array:
    """Return q after a step (dc, dw) in the order of q, both of shape (3,) or (6,)."""
    found = q + step
    if len(q) == 6:
        found[_TURN] = rotation_vector(rotation_matrix(step[_TURN]) @ rotation_matrix(q[_TURN]))
    return found


def between(q: Array, end: Array) -> Array:
    """Return the step from one motion to another: the inverse of `moved`."""
    step = end - q
    if len(q) == 6:
        step[_TURN] = rotation_vector(rotation_matrix(end[_TURN]) @ rotation_matrix(q[_TURN]).T)
    return step


def bonded_displacement(X: Array, q: Array) -> Array:
    """Return the displacements (n, 3) of bonded nodes at X (n, 3) from the centre."""
    c, R = placed(q)
    return c + X @ (R - np.eye(3)).T


def bonded_tangent(X: Array, q: Array) -> Array:
    """Return the derivative of `bonded_displacement` by all six components of (dc, dw), shape (n, 3, 6)."""
    _, R = placed(q)
    each = np.concatenate([np.broadcast_to(np.eye(3), (len(X), 3, 3)), -cross_matrix(X @ R.T)], axis=2)
    return each[:, :, ORDER]


def work_of_load(load: Array, height: float, q: Array) -> Array:
    """Return the work of a dead load per (dc, dw), shape (6,), in the order of q.

    Load F_x, F_z, M, F_y, M_x, M_z and q: (3,) or (6,), scaled; the force acts at `height` above the bonded face.
    """
    F, M = _forces(load)
    return np.asarray(np.concatenate([F, M + cross_matrix(height * placed(q)[1][:, 2]) @ F])[ORDER])


def work_between(load: Array, height: float, ends: tuple[Array, Array], step: Array) -> float:
    """Return the work of a dead load between two motions a `step` (dc, dw) apart.

    Exact for forces; for a moment about fixed axes, which has no potential, the work along the step's rotation.
    """
    F, M = _forces(load)
    (c, R), (C, Q) = (placed(q) for q in ends)
    return float(F @ (C - c + height * (Q - R)[:, 2]) + M @ all_six(step)[_TURN])


def turning(forces: Array, X: Array, load: Array, height: float, q: Array) -> Array:
    """Return the stiffness on (dc, dw), (6, 6), of bonded nodes' forces (n, 3) and a load as the target turns."""
    _, R = placed(q)
    F, _ = _forces(load)
    found = np.zeros((6, 6))
    own = (cross_matrix(forces) @ cross_matrix(X @ R.T)).sum(axis=0)
    found[3:, 3:] = own - cross_matrix(F) @ cross_matrix(height * R[:, 2])
    return np.asarray(found[np.ix_(ORDER, ORDER)])


def _forces(load: Array) -> tuple[Array, Array]:
    """Return force and moment along x, y, z."""
    whole = all_six(load)
    return whole[_CENTRE] * (1.0, 1.0, -1.0), whole[_TURN]
