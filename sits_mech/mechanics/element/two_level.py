"""How is a mesh solved that is too large to be factored? By conjugate gradients, with the mesh that it was made from.

``K x = b`` for the free displacements of a mesh whose cells, the children, come from dividing each cell of a coarser
mesh, its parent, once. What lies inside a parent is eliminated in it; on what is left, the parents' faces, the
preconditioner adds up

    M^-1 = sum_v R_v^T (R_v S R_v^T)^-1 R_v  +  P K_c^-1 P^T,

small problems about every corner v of a child, with the nodes on the faces and edges that meet in it, and the coarse
mesh, by its own factor or its own preconditioner. Both are there for the nearly incompressible: the patches hold the
motions that keep volumes, and eliminating inside the parents bends what the coarse mesh gives so that each child keeps
its volume. S is the sum of the parents' matrices and is never assembled.

Source: J. Schoeberl, Numer. Math. 84 (1999) 97; P. E. Farrell, L. R. Mitchell, F. Wechsung, SIAM J. Sci. Comput. 41
(2019) A3073. For symmetric positive definite K: a state near its limit load breaks off, which is told. Measured on a
pad of 20 x 20 x 2 mm, K/mu = 1000, to 1e-4 of the residual: 52 steps on 23,000 unknowns in bricks; on tetrahedra
65, on 45,000 as on 153,000 unknowns. From K/mu = 1000 to 100,000 the steps grow by a fifth.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skfem.element import Element

from sits_mech.mechanics.element.mesh import Indices, MixedMesh
from sits_mech.mechanics.element.prolongation import Prolongation
from sits_mech.meshing.refinement import Refinement
from sits_mech.quantities import Array

_INSIDE = 1e-9  # from a parent's faces, in its reference cell
_MOST = 300  # steps


Mask = NDArray[np.bool_]
_Patch = tuple[Indices, NDArray[np.float32]]


class Iterated(NamedTuple):
    """Displacements (d n, r), steps taken, and what is left of the right-hand sides, the worst; inf if broken off."""

    x: Array
    steps: int
    left: float


class _Parents(NamedTuple):
    """Parents without what lies inside: numbers of displacements on their faces (e, o) and inside (e, i), S (e, o, o).

    Last the inverse of the inside (e, i, i), and that times its coupling to the faces (e, i, o).
    """

    outer: Indices
    inner: Indices
    S: Array
    inverse: Array
    coupling: Array


@dataclass(frozen=True, eq=False)
class TwoLevel:
    """Equations on a refined mesh, made by `two_level`, solved by `solve`."""

    _parents: _Parents
    _free: Mask
    _patches: list[_Patch]
    _onto: Prolongation
    _coarse: Callable[[Array], Array]

    def solve(self, b: Array, until: float) -> Iterated:
        """Return the solution on the free displacements, zero on others.

        Parameters
        ----------
        b : ndarray, shape (d n, r)
            Right-hand sides; what they hold on displacements that are not free does not count.
        until : float
            Norm of the residual over that of the right-hand side at which to stop.
        """
        own, x, r = self._parents, np.zeros_like(b), self._on_faces(b)
        size = np.maximum(np.linalg.norm(r, axis=0), 1e-300)
        z = self.preconditioned(r)
        p, rz, left, steps = z, (r * z).sum(axis=0), float(np.max(np.linalg.norm(r, axis=0) / size)), 0
        while left > until and steps < _MOST:
            Ap = np.where(self._free[:, None], _summed(own.outer, own.S @ p[own.outer], len(b)), 0.0)
            work = (p * Ap).sum(axis=0)
            if not np.all((work > 0.0) | (rz == 0.0)):
                return Iterated(x, steps, np.inf)
            part = np.divide(rz, work, out=np.zeros_like(rz), where=work > 0.0)
            x, r, steps = x + part * p, r - part * Ap, steps + 1
            z, before = self.preconditioned(r), rz
            rz = (r * z).sum(axis=0)
            p = z + np.divide(rz, before, out=np.zeros_like(rz), where=before > 0.0) * p
            left = float(np.max(np.linalg.norm(r, axis=0) / size))
        return Iterated(self._filled(x, b), steps, left)

    def approximated(self, b: Array) -> Array:
        """Return the preconditioner's answer, shape (d n, r); for meshes refined from this one to take as coarse."""
        return self._filled(self.preconditioned(self._on_faces(b)), b)

    def _on_faces(self, b: Array) -> Array:
        """What right-hand sides leave on the parents' faces when all inside is eliminated."""
        own = self._parents
        left = b - _summed(own.outer, own.coupling.swapaxes(1, 2) @ b[own.inner], len(b))
        left[own.inner.ravel()] = 0.0
        left[~self._free] = 0.0
        return left

    def _filled(self, x: Array, b: Array) -> Array:
        """Displacements on the parents' faces, and those inside that follow."""
        own, filled = self._parents, x.copy()
        filled[own.inner] = own.inverse @ b[own.inner] - own.coupling @ x[own.outer]
        return filled

    def preconditioned(self, r: Array) -> Array:
        """Return the preconditioner times residuals on the parents' faces, shape (d n, r)."""
        z, single = np.zeros_like(r), r.astype(np.float32)
        for numbers, inverse in self._patches:
            z[numbers] += inverse @ single[numbers]
        z += self._onto.displacements(self._coarse(self._onto.gathered(r)))
        z[self._parents.inner.ravel()] = 0.0
        z[~self._free] = 0.0
        return z


def two_level(
    mesh: MixedMesh, refinement: Refinement, element: Element, stiffness: Array, free: Indices,
    coarse: tuple[Prolongation, Callable[[Array], Array]],
) -> TwoLevel:  # fmt: skip
    """Return the equations of a refined mesh, ready to be solved.

    Parameters
    ----------
    mesh : MixedMesh
        Made of `refinement.mesh`.
    refinement : Refinement
        Of the coarse mesh, divided once.
    element : skfem.Element
        Of the displacements.
    stiffness : ndarray, shape (f, d k, d k)
        Of the elements, symmetric.
    free : ndarray
        Numbers of the free displacements.
    coarse : tuple
        From the coarse mesh to this one; and the coarse mesh's own solution, or a preconditioner, for right-hand sides
        of shape (d n_coarse, r), zero where displacements are not free.
    """
    parents = _condensed(mesh, refinement, element, stiffness)
    mask = np.zeros(mesh.nodes.size, dtype=bool)
    mask[free] = True
    mask[parents.inner.ravel()] = True
    return TwoLevel(parents, mask, _patches(mesh, element, parents, mask), *coarse)


def _condensed(mesh: MixedMesh, refinement: Refinement, element: Element, stiffness: Array) -> _Parents:
    """Eliminate what lies inside the parents."""
    d, k = mesh.nodes.shape[1], mesh.cells.shape[1]
    kinds, cells = refinement.kinds.reshape(-1, 2**d), mesh.cells.reshape(-1, 2**d * k)
    at = refinement.within(element.doflocs)
    far = at.sum(axis=-1) if _is_simplex(element) else at.max(axis=-1)
    inside = np.asarray((at.min(axis=-1) > _INSIDE) & (far < 1.0 - _INSIDE))
    parts = []
    patterns, which = np.unique(kinds, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        own = np.flatnonzero(which.ravel() == number)
        _, first, local = np.unique(cells[own[0]], return_index=True, return_inverse=True)
        within = inside[pattern].ravel()[first]
        split = np.argsort(~within, kind="stable")
        place = np.argsort(split)[local.ravel()].reshape(2**d, k)
        for some in np.array_split(own, max(1, len(own) // 100)):
            nodes = cells[np.ix_(some, first[split])]
            parts.append((some, _eliminated(nodes, place, int(within.sum()), stiffness, (some, d))))
    order = np.argsort(np.concatenate([some for some, _ in parts]))
    return _Parents(*(np.concatenate([part[i] for _, part in parts])[order] for i in range(5)))


def _eliminated(
    nodes: Indices, place: Indices, inside: int, stiffness: Array, which: tuple[Indices, int]
) -> _Parents:
    """Parents of one pattern: nodes (e, n), those inside first, and where in them those of each child stand."""
    (some, d), n = which, nodes.shape[1]
    A = np.zeros((len(nodes), d * n, d * n))
    children = stiffness.reshape(-1, len(place), *stiffness.shape[1:])
    for child, own in enumerate(place):
        to = (d * own + np.arange(d)[:, None]).ravel()
        A[:, to[:, None], to] += children[some, child]
    i = d * inside
    numbers = (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), -1)
    inverse = np.linalg.inv(A[:, :i, :i])
    coupling = inverse @ A[:, :i, i:]
    S = A[:, i:, i:] - A[:, :i, i:].swapaxes(1, 2) @ coupling
    return _Parents(numbers[:, i:], numbers[:, :i], S, inverse, coupling)


def _patches(mesh: MixedMesh, element: Element, parents: _Parents, free: Mask) -> list[_Patch]:
    """Free displacements of the faces and edges that meet in each corner of a child, and the inverse of S there."""
    d, size = mesh.nodes.shape[1], mesh.nodes.size
    kept = free.copy()
    kept[parents.inner.ravel()] = False
    pairs = [mesh.cells[:, [corner, node]] for node, corner in zip(*np.nonzero(_hats(element) > _INSIDE), strict=True)]
    about = np.unique(np.concatenate(pairs), axis=0)
    about = about[np.any(kept.reshape(-1, d)[about[:, 1]], axis=1)]
    corners, start = np.unique(about[:, 0], return_index=True)
    held = parents.outer[:, ::d] // d
    order = np.argsort(held, axis=None, kind="stable")
    begin = np.searchsorted(held.ravel()[order], np.arange(size // d + 1))
    owner, place, found = order // held.shape[1], np.full(size, -1), []
    for corner, nodes in zip(corners, np.split(about[:, 1], start[1:]), strict=True):
        numbers = (d * nodes[:, None] + np.arange(d)).ravel()
        numbers = numbers[kept[numbers]]
        place[numbers] = np.arange(len(numbers))
        matrix = np.zeros((len(numbers), len(numbers)))
        for parent in owner[begin[corner] : begin[corner + 1]]:
            to = place[parents.outer[parent]]
            own = np.flatnonzero(to >= 0)
            matrix[np.ix_(to[own], to[own])] += parents.S[parent][np.ix_(own, own)]
        place[numbers] = -1
        found.append((numbers, np.linalg.inv(matrix).astype(np.float32)))
    return found


def _hats(element: Element) -> Array:
    """The linear functions of an element's corners at its nodes, shape (k, c)."""
    at, count = element.doflocs, element.refdom.nnodes
    if _is_simplex(element):
        return np.column_stack([1.0 - at.sum(axis=1), at])
    return np.asarray(np.prod(1.0 - np.abs(at[:, None] - at[:count]), axis=-1))


def _is_simplex(element: Element) -> bool:
    """Whether the reference cell is a triangle or tetrahedron."""
    return bool(element.refdom.nnodes == element.doflocs.shape[1] + 1)


def _summed(numbers: Indices, values: Array, size: int) -> Array:
    """Sums, shape (size, r), of values (e, o, r) that go to each number (e, o)."""
    return np.stack([np.bincount(numbers.ravel(), own.ravel(), size) for own in np.moveaxis(values, -1, 0)], axis=1)
