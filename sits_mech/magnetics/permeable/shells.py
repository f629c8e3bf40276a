"""A plate's closed surface in triangles: what a magnetic potential on it means outside, inside and in the plate's skin.

The coils' field in the plate is H_0 = -grad u_0, the whole one -grad u on the surface. With v any function there,

    <S u, v>: the flux of what a potential u drives outside, S_i that inside without the plate,
    b_v = int n.H_0 v,    u_0 = -S_i^-1 b,    (S + K) u = -(b - S u_0) = -g,

where <K u, v> is the flux that leaves the plate's surface inwards (`permeable`). What the coils c and d have of it is

    Delta L_cd = mu0 (u_0c . S u_0d - u_0c . b_d - g_c . (S + K)^-1 g_d),

symmetric, exactly 0 for K = S_i, and with errors of second order in the cells. u is linear on triangles, charges are
constant; with V and D of `triangles`, M_iv = int_i v, and W = curl u . V curl v,

    S = W + (M/2 - D)^T V^-1 (M/2 - D),    S_i = W + (M/2 + D)^T V^-1 (M/2 + D).

The plate's symmetries, mirrored in z too, split the problem into classes, u(g x) = chi(g) u(x).

Range: plates without holes, and rings that hardly conduct; no coil's current passes through them. Source: O. Steinbach,
Numerical Approximation Methods for Elliptic Boundary Value Problems (2008), ch. 6, the symmetric Steklov-Poincare
operator.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.constants import mu_0
from scipy.linalg import cho_factor, cho_solve

from sits_mech.geometry.sheet_plan import CellPlan, plan_seams, standing_nodes
from sits_mech.magnetics.permeable.triangles import triangle_potentials
from sits_mech.quantities import Array, Complex, Integers

_POINTS = np.array([-1.0, 1.0]) / np.sqrt(12.0) + 0.5  # of an edge, with equal weights


@dataclass(frozen=True, eq=False)
class HalfSurface:
    """The upper half of a plate's surface, or of the part of it that its symmetry repeats, about its middle plane."""

    plan: CellPlan
    nodes: Array  # (n, 3), the plan's first [m]
    triangles: Integers  # (t, 3) counter-clockwise from outside, those of the face first
    faces: int  # how many are of the face
    below: Integers  # (n,) the plan's node that each stands under
    middle: Any  # (n,) whether it is in the middle plane
    corner: tuple[Integers, Integers]  # edges between face and rim: their nodes (2, c), the triangles beside (2, c)

    @cached_property
    def images(self) -> Array:
        """Isometries (2 g, 3, 3) that take the part to the whole, those of the upper half first."""
        group = np.zeros((2, len(self.plan.group), 3, 3))
        group[..., :2, :2] = self.plan.group
        group[:, :, 2, 2] = np.array([[1.0], [-1.0]])
        return group.reshape(-1, 3, 3)

    @cached_property
    def edges(self) -> tuple[Integers, sp.csr_array]:
        """Edges (e, 2) and the matrix from the circulation along each to half the fluxes, by nodes: (n, e)."""
        ends = np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
        edges, which = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
        sign = np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0) / (3.0 * mu_0)
        rows, columns = np.repeat(self.triangles, 3, axis=0).ravel(), np.repeat(which.ravel(), 3)
        return edges, sp.csr_array((np.repeat(sign, 3), (rows, columns)), shape=(len(self.nodes), len(edges)))

    @cached_property
    def points(self) -> tuple[Array, Array]:
        """Points of the edges' images, (2 g, e, 2, 3), and how these run, (2 g, e, 3) [m]."""
        start, end = np.moveaxis(self.nodes[self.edges[0]], 1, 0)
        at = start[:, None] + (end - start)[:, None] * _POINTS[:, None]
        turned = np.swapaxes(self.images, 1, 2)
        return at @ turned[:, None], (end - start) @ turned

    def loads(self, A: Array) -> Array:
        """Return int n.H_0 v of nodes' images, (2 g, n, m), from A at `points`, (2 g, e, 2, 3, m) [V s / (A m)]."""
        along = np.einsum("gekm,gek->gem", A.mean(axis=2), self.points[1])
        along *= np.round(np.linalg.det(self.images))[:, None, None]
        flat = self.edges[1] @ np.swapaxes(along, 0, 1).reshape(along.shape[1], -1)
        return np.swapaxes(flat.reshape(-1, len(along), along.shape[2]), 0, 1)


@dataclass(frozen=True, eq=False)
class ShellClass:
    """A symmetry class: the operators on its free nodes; real if its character is."""

    free: Any  # (n, f) from free nodes to all, sparse
    character: Complex  # (2 g,)
    weight: float  # images, twice where the conjugate class goes with it
    mirror: int
    S: Complex
    inner: Complex  # S_i
    stiffness: tuple[Complex, ...]  # grad u . grad v over face and rim; d_s u d_s v, d_n u d_n v of corners
    inverse: Any  # S_i^-1 of what has no net flux
    net: Any  # (f,) int v, 0 in classes without net flux

    def projected(self, loads: Array) -> Complex:
        """Return a class's b, (f, m), from loads (2 g, n, m)."""
        chi = self.character.conj() if np.iscomplexobj(self.S) else self.character.real
        return np.asarray(self.free.conj().T @ np.tensordot(chi / chi.size, loads, axes=1))

    def response(self, K: Complex) -> Complex:
        """Return X of Delta L = b_c^* X b_d, by K of the class (f, f)."""
        outside = self.S @ self.inverse
        g = np.eye(len(self.S)) + outside
        inner = self.inverse + outside.conj().T @ self.inverse
        return np.asarray(mu_0 * self.weight * (inner - g.conj().T @ np.linalg.solve(self.S + K, g)))


def surface(plan: CellPlan, levels: Array) -> HalfSurface:
    """Return the surface over a plan, with the rim's nodes on `levels` from the middle plane up to the face [m]."""
    n, cells, half = len(plan.nodes), plan.cells, levels[-1]
    a, b = cells.ravel(), np.roll(cells, -1, axis=1).ravel()
    _, index, count = np.unique(np.minimum(a, b) * n + np.maximum(a, b), return_inverse=True, return_counts=True)
    outer = (a != b) & (plan.loop[a] >= 0) & (plan.loop[a] == plan.loop[b]) & (count[index] == 1)
    rim, ends = np.unique(np.stack([a[outer], b[outer]]), return_inverse=True)
    nodes, below, known = [np.column_stack([plan.nodes, np.full(n, half)])], [np.arange(n)], rim[ends.reshape(2, -1)]
    quads = cells[:, 2] != cells[:, 3]
    faces = np.vstack([cells[:, :3], cells[quads][:, [0, 2, 3]]])
    cell, side = np.divmod(np.flatnonzero(outer), 4)
    neighbour = np.where(quads[cell] & (side > 1), len(cells) + np.cumsum(quads)[cell] - 1, cell)
    corner = known, np.stack([neighbour, len(faces) + len(neighbour) + np.arange(len(neighbour))])
    triangles = [faces]
    for k, z in enumerate(levels[-2::-1]):
        under = n + k * rim.size + ends.reshape(2, -1)
        (A, B), (D, C) = known, under
        triangles += [np.column_stack([A, D, C]), np.column_stack([A, C, B])]
        nodes.append(np.column_stack([plan.nodes[rim], np.full(rim.size, z)]))
        below.append(rim)
        known = under
    at = np.vstack(nodes)
    return HalfSurface(plan, at, np.vstack(triangles), len(faces), np.concatenate(below), at[:, 2] == 0.0, corner)


def shell_classes(part: HalfSurface) -> list[ShellClass]:
    """Return the classes of a plate's surface; those without nodes are left out."""
    T, plan = part.nodes[part.triangles], part.plan
    t, n, images, count = len(T), len(part.nodes), part.images, len(plan.group)
    edge, twice = np.roll(T, -1, axis=1) - T, np.linalg.norm(np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0]), axis=1)
    rows, columns = np.repeat(np.arange(t), 3), part.triangles.ravel()
    spread = sp.csr_array((np.ones(3 * t), (np.arange(3 * t), columns)), shape=(3 * t, n))
    mass = sp.csr_array((np.repeat(twice / 6.0, 3), (rows, columns)), shape=(t, n))
    curls = np.roll(edge, -1, axis=1) / twice[:, None, None]
    C = [sp.csr_array((curls[..., k].ravel(), (rows, columns)), shape=(t, n)) for k in range(3)]
    turn = np.round(np.linalg.det(images)).astype(int)
    moved = np.stack([(T @ g.T)[:, ::sign] for g, sign in zip(images, turn.tolist(), strict=True)])
    V, D = (np.moveaxis(each.reshape(t, len(images), t, *each.shape[2:]), 1, 0)
            for each in triangle_potentials(T, moved.reshape(-1, 3, 3)))
    kernels = []
    for g, sign, charged, paired in zip(images, turn.tolist(), V, D, strict=True):
        W: Any = sum(sign * g[k, i] * (C[i].T @ (C[k].T @ charged).T).T for k, i in np.argwhere(g != 0.0).tolist())
        kernels.append((charged, (spread.T @ paired[..., ::sign].reshape(t, 3 * t).T).T, W))
    every = [np.stack(each) for each in zip(*kernels, strict=True)]
    stiff: list[Any] = [sum(c[some].T @ sp.diags_array(twice[some] / 2.0) @ c[some] for c in C)
             for some in (slice(0, part.faces), slice(part.faces, t))]
    stiff += _corners(part, C)
    seams, found = plan_seams(plan), []
    turns = np.round(np.linalg.det(plan.group))
    for character, weight in zip(plan.characters, plan.weights, strict=True):
        for mirror in (1, -1):
            stands, factor = standing_nodes(plan, seams, character * turns)
            free = _free(part, stands, factor, mirror)
            if free.shape[1]:
                chi = np.concatenate([character, mirror * character])
                found.append(_class(free, (chi, mirror, weight * 2 * count), every, mass, stiff))
    return found


def _corners(part: HalfSurface, curls: list[Any]) -> list[Any]:
    """Return int d_s u d_s v along the corners, and int d_n u d_n v across these on both sides."""
    (a, b), neighbour = part.corner
    way = part.nodes[b] - part.nodes[a]
    length, c = np.linalg.norm(way, axis=1), np.arange(len(a))
    ends = np.concatenate([1.0 / np.sqrt(length), -1.0 / np.sqrt(length)])
    along = sp.csr_array((ends, (np.r_[c, c], np.r_[b, a])), shape=(len(a), len(part.nodes)))
    across = [sum(sp.diags_array(s / np.sqrt(length)) @ C[own] for s, C in zip(way.T, curls, strict=True))
              for own in neighbour]
    return [along.T @ along, sum(each.T @ each for each in across)]


def _free(part: HalfSurface, stands: Integers, factor: Complex, mirror: int) -> Any:
    """Return the matrix from a class's free nodes to all, by its plan's nodes that stand for others."""
    n = len(part.nodes)
    key = part.nodes[:, 2] * 0.0 + np.unique(part.nodes[:, 2], return_inverse=True)[1] * len(stands)
    own, home = key + part.below, key + stands[part.below]
    order = np.argsort(own)
    place = order[np.searchsorted(own[order], home)]
    value = np.where(part.middle & (mirror < 0), 0.0, factor[part.below])
    keeps = (value != 0.0) & (place == np.arange(n))
    number, used = np.cumsum(keeps) - 1, np.flatnonzero(value != 0.0)
    value = value if np.iscomplex(value).any() else value.real
    return sp.csr_array((value[used], (used, number[place[used]])), shape=(n, int(keeps.sum())))


def _class(
    free: Any, kind: tuple[Complex, int, float], kernels: list[Array], mass: Any, stiff: list[Any]
) -> ShellClass:
    """Return a class from the kernels V, D, W to each image, its character, mirror and weight."""
    chi, mirror, weight = kind
    factors: Any = chi if np.iscomplex(chi).any() else chi.real
    back = free.conj().T
    V, D, W = (np.tensordot(factors, each, axes=1) for each in kernels)
    D, M, W = (free.T @ D.T).T, (mass @ free).toarray(), (free.T @ (back @ W).T).T
    factor = cho_factor((V + V.conj().T) / 2.0)
    S, inner = ((W + W.conj().T) / 2.0 + B.conj().T @ cho_solve(factor, B) for B in (M / 2.0 - D, M / 2.0 + D))
    S, inner = ((each + each.conj().T) / 2.0 for each in (S, inner))
    net: Any = M.sum(axis=0) * float(np.all(np.abs(chi - 1.0) < 1e-9))
    inverse: Any = np.linalg.inv(gauged(inner, net))
    every = tuple((back @ each @ free).toarray() for each in stiff)
    return ShellClass(free, chi, weight, mirror, S, inner, every, np.asarray(inverse + inverse.conj().T) / 2.0, net)


def gauged(matrix: Complex, net: Any) -> Complex:
    """Return a matrix that sees no constant, held against one by the net flux."""
    size = net @ net
    return matrix + np.outer(net, net) * (np.trace(matrix) / size / len(net)) if size > 0.0 else matrix
