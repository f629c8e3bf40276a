"""Stiffness of a body about an axis, deformed along it, against small shear and tilt: the first harmonic.

A small displacement of the deformed body in the plane y = 0 is, with m, n and c functions of r and z,

    u_r = (m + n) cos(theta),      u_theta = (n - m) sin(theta),      u_z = c cos(theta),

so that ``u_x = m + n cos(2 theta)``: m is a shift, and n = c = 0 on the axis. Its gradients on (r, theta, z) are

    (m + n),r     -2 n/r        (m + n),z                cos    sin    cos
    (n - m),r      2 n/r        (n - m),z      times     sin    cos    sin
    c,r           -c/r          c,z                      cos    sin    cos

and as A couples none of the cosines with the sines, half the weights of full turns are left of the integrals:

    E_2 = 1/2 int pi r [ dF : (A + p L) : dF + K pi(H : dF)^2 ] dr dz.

The target moves its nodes, at r and Z above its lower face, by m = d_h + alpha Z, c = -alpha r (n = 0). What half a pad
solves is this, exactly, for a change from rest under F_z. Along y it is the same with d_y, and alpha_x = -alpha.

Unknowns: m, n, c at the nodes, in thicknesses; pressures as in kernel.py, eliminated. Left out: contact, which adds to
the stiffness. Source: E. L. Wilson, AIAA Journal 3 (1965) 2269, harmonics of axisymmetric bodies.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sits_mech.mechanics.element.assembly import Pattern, pattern
from sits_mech.mechanics.element.kernel import Laws, deformation, kinematics
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.quantities import Array, Integers


def harmonic_stiffness(mesh: MixedMesh, laws: Laws, u: Array, pressure: Array) -> Array:
    """Return element stiffnesses (e, 3 k, 3 k) on m, n, c at nodal displacements (2 n,) with pressures (e, m)."""
    (e, q, *_), (along, hoop, up) = mesh.inside.slope.shape, np.moveaxis(mesh.inside.slope, 2, 0)
    state = kinematics(deformation(mesh, u)[0])
    A = laws.tangent(state)
    A *= mesh.inside.weights[..., None, None]
    state.add_L(A, (pressure[:, None] @ mesh.chi)[:, 0])
    zero = np.zeros_like(hoop)
    by_m = np.stack([along, zero, up, -along, zero, -up, zero, zero, zero], axis=2)
    by_n = np.stack([along, -2.0 * hoop, up, along, 2.0 * hoop, up, zero, zero, zero], axis=2)
    by_c = np.stack([zero, zero, zero, zero, zero, zero, along, -hoop, up], axis=2)
    B = np.concatenate([by_m, by_n, by_c], axis=3)  # dF by the unknowns, (e, q, 9, 3 k)
    volume = mesh.chi @ (state.H[..., None, :] @ B)[:, :, 0]
    found = B.reshape(e, q * 9, -1).swapaxes(1, 2) @ (A @ B).reshape(e, q * 9, -1)
    return np.asarray(0.5 * (found + laws.K[..., None] * volume.swapaxes(1, 2) @ volume))


@lru_cache(maxsize=16)
def harmonic_pattern(mesh: MixedMesh, bonded: bytes) -> Pattern:
    """Return the assembly pattern of m, n, c; `bonded`: numbers of the target's nodes (b,)."""
    top = np.frombuffer(bonded, dtype=np.int64)
    fixed = np.zeros((len(mesh.nodes), 3), dtype=bool)
    fixed[mesh.nodes[:, 1] < 1e-9] = fixed[top] = True
    fixed[mesh.nodes[:, 0] < 1e-9, 1:] = True
    numbers = (3 * mesh.cells[:, None, :] + np.arange(3)[:, None]).reshape(len(mesh.cells), -1)
    border = (3 * top[:, None] + np.arange(3)).ravel()
    return pattern(mesh, (numbers,), np.flatnonzero(~fixed.ravel()), border)


def off_axis_stiffness(
    mesh: MixedMesh, laws: Laws, state: tuple[Array, Array], bonded: tuple[Integers, Array], turning: float
) -> Array:
    """Return the stiffness (2, 2) of a target on d_y and alpha_x, nan if singular, at displacements and pressures.

    `bonded`: its nodes, and their places from its centre, (b, 3); `turning`: what its load and its nodes' forces do as
    it turns.
    """
    nodes, X = bonded
    own, stiffness = harmonic_pattern(mesh, nodes.tobytes()), harmonic_stiffness(mesh, laws, *state)
    T = np.zeros((len(X), 3, 2))
    T[:, 0, 0], T[:, 0, 1], T[:, 2, 1] = 1.0, -X[:, 2], X[:, 0]
    factor = own.factored((stiffness,))
    if factor is None:
        return np.full((2, 2), np.nan)
    C, D = own.sides((stiffness,), T.reshape(-1, 2))
    return D + np.diag([0.0, turning]) - C.T @ factor.solve(C)
