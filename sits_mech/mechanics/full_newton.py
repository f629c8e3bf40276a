"""How does a whole pad come to rest under all six components of a load? Newton's method on displacements and turns.

The target is exactly rigid: a bonded point X of its lower face goes to ``c + R X``, c the centre's place, R a rotation.
Per unit of virtual work, with f the forces of the pad and of the contacts on the bonded nodes, x = R X, and f_c, m_c
what the contacts exert on the target itself (block_contact.py),

    forces     sum f + f_c = F,         moments     sum x x f + m_c = M + (R h) x F,         h = (0, 0, load height),

F a dead force, M a dead moment about the fixed axes. Newton's method turns R by ``exp([w])``, so that nothing is
singular at any rotation: with ``du = dc + w x x`` on the bonded nodes the tangent is that of the pad between those
fields, and what the turned arms add to the moments, in matrices of vector products: ``sum [f][x] - [F][R h]`` by w.
It is not symmetric, as a moment about fixed axes has no potential; a target at rest counts as stable where the
symmetric part of the stiffness that it feels is positive definite: no small push then does negative work.

Unknowns: nodal displacements and c in thicknesses, w in radians; scales of block_mesh.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from sits_mech.geometry.turns import cross_matrix, rotation_matrix
from sits_mech.mechanics.block_contact import SolidContact, softened
from sits_mech.mechanics.block_mesh import Solid
from sits_mech.mechanics.forms import Indices, Tangent, entries, summed
from sits_mech.mechanics.newton import solved
from sits_mech.quantities import Array

_SETTLED = 1e-9
_ITERATIONS = (14, 20)  # without contact and with it
_SOFTER = (100.0, 10.0, 1.0)  # times the length over which contact gives, on the way from rest without it
_EASY = 5  # iterations up to which the next increment grows
_NEAR = 1e-3  # residual from which one more step leaves the target's stiffness as it is


@dataclass(frozen=True)
class Place:
    """A pad's state: nodal displacements, pressures, the target's centre and rotation; whether it stands stable."""

    u: Array
    p: Array
    c: Array
    R: Array
    residual: float = np.inf
    iterations: int = 0
    min_J: float = 1.0
    stable: bool = True

    @property
    def settled(self) -> bool:
        """Whether it is at rest, and stays there."""
        return self.residual <= _SETTLED and self.stable


@dataclass(frozen=True)
class Way:
    """The last place at rest on the way to a load, how much of it that is, what ended it as of `path.Outcome`."""

    place: Place
    reached: float
    reason: str = ""


def followed(pad: Solid, load: Array, smallest: float) -> Way:
    """Return the way from rest to a load, shape (6,), in steps as small as they need be down to the smallest."""
    mesh = pad.body.mesh
    here = Place(np.zeros(mesh.nodes.size), np.zeros(mesh.chi.shape[:2]), np.zeros(3), np.eye(3))
    at, increment, spent, reason = 0.0, 1.0, 0, ""
    while at < 1.0 and increment >= smallest:
        part = min(1.0, at + increment)
        trial = _newton(pad, here, part * load)
        spent += trial.iterations
        if trial.settled:
            here, at = trial, part
            increment *= 2.0 if trial.iterations <= _EASY else 1.0
        else:
            reason = "buckled" if trial.residual <= _SETTLED else "lost"
            increment *= 0.5
    return Way(replace(here, iterations=spent), at, reason)


def eased(pad: Solid, start: Place, load: Array) -> Way:
    """Return the rest with contact from that without, let in softly: faces stand deep behind planes at first."""
    here, spent = start, start.iterations
    for factor in _SOFTER:
        soft = replace(pad, body=replace(pad.body, parts=softened(pad.body.parts, factor)))
        here = _newton(soft, here, load)
        spent += here.iterations
        if not here.settled:
            return Way(replace(start, iterations=spent), 0.0, "lost")
    return Way(replace(here, iterations=spent), 1.0)


def _newton(pad: Solid, start: Place, load: Array) -> Place:
    """Iterate to rest under one load; the result's residual says whether it settled."""
    body, here = pad.body, start
    top = body.bonded[:, 0] // 3
    X = body.mesh.nodes[top] * (1.0, 1.0, 0.0)
    size, stable, n = max(float(np.linalg.norm(load)), 1e-5 * body.K), start.stable, len(body.free)
    pushes, most = np.vstack([np.zeros((n, 6)), np.eye(6)]), _ITERATIONS[bool(body.parts)]
    for count in range(most + 1):
        found = body.element.tangent(body.mesh, body.law, body.K, here.u, here.p)
        forces, K = _with_contact(pad, here, found)
        x, f = X @ here.R.T, forces[:-6].reshape(-1, 3)[top]
        arm = body.height * here.R[:, 2]
        T = np.concatenate([np.broadcast_to(np.eye(3), (len(x), 3, 3)), -cross_matrix(x)], axis=2)
        P = _map(body.free, top, T, len(here.u))
        gradient = P.T @ forces
        gradient[-6:] -= np.concatenate([load[:3], load[3:] + np.cross(arm, load[:3])])
        left = float(np.linalg.norm(gradient)) / size
        left = left if left > _SETTLED or np.isfinite(found.energy) else np.inf  # beyond its law's locking stretch
        here = replace(here, residual=left, iterations=count, min_J=found.min_J)
        if here.residual <= _SETTLED or not np.isfinite(here.residual) or count == most:
            break
        turning = (cross_matrix(f) @ cross_matrix(x)).sum(axis=0) - cross_matrix(load[:3]) @ cross_matrix(arm)
        add = sparse.coo_matrix((turning.ravel(), tuple(n + 3 + np.indices((3, 3)).reshape(2, -1))), (n + 6, n + 6))
        ways = solved((P.T @ K @ P + add).tocsc(), np.column_stack([-gradient, pushes]))
        if ways is None:
            break
        stable = _stable(ways[-6:, 1:]) if here.residual <= _NEAR else stable
        moved = _moved(pad, here, ways[:, 0], (P, X, top))
        if moved is None:
            break
        here = moved
    return replace(here, stable=stable)


def _with_contact(pad: Solid, here: Place, found: Tangent) -> tuple[Array, sparse.csr_matrix]:
    """Forces and stiffness of pad and contacts on the displacements, the target's centre and its turning."""
    body, size = pad.body, len(here.u) + 6
    forces = np.concatenate([found.forces, np.zeros(6)])
    values, rows, columns = [found.stiffness.ravel()], [body.rows], [body.columns]
    for part in body.parts:
        if isinstance(part, SolidContact):
            push = part.push(here.u, here.c, here.R)
            numbers = part.surface.numbers[push.on]
            forces += summed(numbers, push.forces, size)
            values.append(push.stiffness.ravel())
            for known, more in zip((rows, columns), entries(numbers), strict=True):
                known.append(more)
    each = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return forces, sparse.csr_matrix(each, shape=(size, size))


def _stable(compliance: Array) -> bool:
    """Say whether a target with this compliance withstands every small push."""
    return bool(np.all(np.linalg.eigvalsh(0.5 * (compliance + compliance.T)) > 0.0))


def _moved(pad: Solid, here: Place, step: Array, maps: tuple[sparse.csr_matrix, Array, Indices]) -> Place | None:
    """State after the longest part of a step that keeps every quadrature point well above inversion."""
    body, (P, X, top) = pad.body, maps
    linear = (P @ step)[:-6]
    F, J = body.element.deformation(body.mesh, here.u)
    B, dofs = body.mesh.B, body.mesh.dofs
    dF = (B.reshape(len(J), -1, dofs.shape[1]) @ linear[dofs][:, :, None]).reshape(F.shape)
    volume = J - 1.0 + np.einsum("eqi,eqi->eq", body.element.cofactor(F), dF)
    p_full = body.K * np.einsum("emq,eq->em", body.mesh.chi, volume)
    part = 1.0
    while part > 1e-3:
        c, R = here.c + part * step[-6:-3], rotation_matrix(part * step[-3:]) @ here.R
        u = here.u + part * linear
        u.reshape(-1, 3)[top] = c + X @ (R - np.eye(3)).T
        least = float(body.element.deformation(body.mesh, u)[1].min())
        if least > 0.2 * min(here.min_J, 1.0):
            return Place(u, here.p + part * (p_full - here.p), c, R, min_J=least)
        part *= 0.5
    return None


def _map(free: Indices, top: Indices, T: Array, n: int) -> sparse.csr_matrix:
    """From the unknowns to the nodal displacements and the target's place."""
    count, own = len(free), np.arange(6)
    rows = 3 * top[:, None, None] + np.arange(3)[:, None] + np.zeros(6, dtype=int)
    columns = np.broadcast_to(count + own, rows.shape)
    values = np.concatenate([np.ones(count), T.ravel(), np.ones(6)])
    at = np.concatenate([free, rows.ravel(), n + own]), np.concatenate([np.arange(count), columns.ravel(), count + own])
    return sparse.csr_matrix((values, at), shape=(n + 6, count + 6))
