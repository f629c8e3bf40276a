"""Complex vector potential of coaxial discs in one coil's known field: forms, far boundary, solution, flux linkage.

Strong form, ``exp(+j omega t)``, A = A_phi(r, z), nothing depends on the angle; A_c is the coil's potential in free
space (closed form, `coils.ring_field`), A_r = A - A_c the reaction of the discs; curl A = (-dA/dz, (1/r) d(r A)/dr):

    curl(nu curl A) + j omega sigma A = 0    in disc k,      nu = 1 / (mu_r (1 - j tan delta) mu0),
    curl curl A_r = 0                        in air,
    A and nu n x curl A continuous,          A = 0 on the axis,          A_r -> 0 far away.

No net current is prescribed: what flows around the axis closes on itself.

Unknowns u [V s/m per A]: A in the discs, A_r in the air, as in `section.elements` and for the same reasons. With g =
A_c at the discs' nodes, 0 elsewhere, an air element at a disc sees u - g; times mu0, with the forms

    c(u, v) = int [du/dz dv/dz + (u' + u/r) (v' + v/r)] r dr dz,    m(u, v) = int u v r dr dz,

    c_discs(u / mu, v) + c_air(u, v) + sum_k j omega mu0 sigma_k m_k(u, v) + b(u, v) = c_all(g, v)    for all v.

Far boundary: a cylinder (where: `axis.lines`), on it the Robin condition that a dipole in its middle
meets, ``A_r = p r / s^3`` at a distance s,

    b(u, v) = int [3 (r n_r + z n_z) / s^2 - 2 n_r / r] u v r dl.

What the coil links of the reaction is, by reciprocity, an integral over the discs,

    Phi = -(2 pi / mu0) sum_k [(1/mu_k - 1) c_k(g, u) + j omega mu0 sigma_k m_k(g, u)],

with an error quadratic in the field's. Delta L = Re Phi, R = -omega Im Phi.

Elements: the grid is a product of lines across r and z, and so are the elements, Lagrange's of any order at
Gauss-Lobatto points. Every form is a sum of Kronecker products of forms in r and in z alone, each over the lines that
bound one disc: exact, and assembled in no time. u / r is a polynomial in the first cell, since u is 0 on the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import Legendre
from scipy.constants import mu_0
from scipy.sparse import csc_matrix, csr_matrix, diags_array, kron
from scipy.sparse.linalg import splu

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.axis.lines import CoaxialDisc, Lines
from sits_mech.magnetics.coils.ring_field import ring_profile
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Coil

_DIGITS = 1e-10  # a part of the flux below this share of the whole is not asked to be accurate
_SOURCE = 1e-7  # error of a track's field by filaments; of Delta L it leaves 1e-8 where 1e-5 leave 6e-7
_SAME = 1e-12  # of the far boundary: a rim's node, whatever rounding says
_Forms = tuple[csr_matrix, csr_matrix]  # stiffness and mass of one variable over some cells, on all its nodes
_BEYOND = 3  # Gauss points more than the order: of u / r in the second cell, 1e-9


@dataclass(frozen=True)
class AxisField:
    """The field of one ampere in the coil, at one order."""

    r: Array  # (n,) nodes across, the axis among them [m]
    z: Array  # (m,) nodes along [m]
    u: Complex  # (n, m) A in the discs, A_r in the air [V s/m per A]
    g: Array  # (n, m) A_c at the discs' nodes, 0 elsewhere [V s/m per A]
    flux: complex  # Phi [H]
    residual: float  # of the linear system, relative to its right-hand side

    order: int  # of the elements

    @property
    def unknowns(self) -> int:
        """The size of the linear system."""
        return int(self.u.size - self.z.size)

    def reaction(self, r: Array, z: Array) -> Complex:
        """Return B of the discs' reaction at points in air off the axis, up and outwards, shape (k, 2) [T/A]."""
        (across, by_r), (along, by_z) = (
            _shapes(nodes[:: self.order], at, self.order) for nodes, at in ((self.r, r), (self.z, z))
        )
        A, A_r, A_z = (
            np.einsum("kn,nm,km->k", one, self.u, other)
            for one, other in ((across, along), (by_r, along), (across, by_z))
        )
        return np.stack([A_r + A / r, -A_z], axis=-1)


def solve_axis(lines: Lines, discs: Sequence[CoaxialDisc], coil: Coil, omega: float, order: int) -> AxisField:
    """Solve for one ampere in the coil, whose axis is r = 0, with elements of an order; omega [rad/s]."""
    r, z = (_nodes(edges, order) for edges in (lines.r, lines.z))
    stiffness, mass = _product(_forms(lines.r, order, radial=True), _forms(lines.z, order))
    D = 0j * mass
    for disc in discs:
        across = _forms(lines.r, order, (disc.inner, disc.radius), radial=True)
        own, mass = _product(across, _forms(lines.z, order, (disc.bottom, disc.top)))
        D = D + (1.0 / disc.permeability - 1.0) * own + 1j * omega * mu_0 * disc.conductivity * mass
    g = _source(r, z, discs, coil)
    inner = np.arange(z.size, g.size)  # not on the axis
    S = csc_matrix((stiffness + D + _far_boundary(lines, r, z, order))[inner][:, inner])
    load = (stiffness @ g.ravel())[inner]
    solution, residual = refined_solution(S, load.astype(complex))
    u = np.zeros(g.size, dtype=complex)
    u[inner] = solution
    flux = complex(-2 * np.pi / mu_0 * np.dot(g.ravel(), D @ u))
    return AxisField(r, z, u.reshape(g.shape), g, flux, residual, order)


def refined_solution(S: csc_matrix, load: Complex) -> tuple[Complex, float]:
    """Return the solution of a nearly symmetric system, refined once, and its relative residual."""
    factor = splu(S, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True})
    solution = factor.solve(load)
    solution += factor.solve(load - S @ solution)
    left = np.linalg.norm(load - S @ solution)
    return solution, float(left / max(np.linalg.norm(load), np.finfo(float).tiny))


def flux_errors(flux: Any, difference: Any, least: float = 0.0) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return errors of the real and the imaginary part of a flux, by what another order changes, and these relative.

    Each is no less than the relative size in the whole, as one may cancel. Relative errors are over the parts, of which
    some digits of the whole count at least, of the real one a share of it, `least`.
    """
    whole, tiny = np.abs(flux).max(), np.finfo(float).tiny
    changed, parts = np.abs(difference).max() / max(whole, tiny), list[tuple[float, float]]()
    for off, part, share in ((difference.real, flux.real, least), (difference.imag, flux.imag, 0.0)):
        largest = np.abs(part).max()
        error = max(np.abs(off).max(), changed * largest)
        parts.append((float(error), float(error / max(largest, max(share, _DIGITS) * whole, tiny))))
    return (parts[0][0], parts[1][0]), (parts[0][1], parts[1][1])


@lru_cache(maxsize=16)
def _rule(order: int) -> tuple[Array, Array, Array, Array]:
    """Return nodes on [-1, 1], and of the Gauss points there weights, shapes (points, nodes) and slopes."""
    nodes = np.concatenate([[-1.0], np.sort(Legendre.basis(order).deriv().roots().real), [1.0]])
    points, weights = np.polynomial.legendre.leggauss(order + _BEYOND)
    return nodes, weights, *_on_cell(nodes, points)


def _on_cell(nodes: Array, at: Array) -> tuple[Array, Array]:
    """Return the values and the slopes of nodes' shapes at points of [-1, 1], (points, nodes) each."""
    order, legvander = nodes.size - 1, np.polynomial.legendre.legvander
    inverse = np.linalg.inv(legvander(nodes, order))
    slopes = np.stack([Legendre.basis(k).deriv()(at) for k in range(order + 1)], axis=1)
    return legvander(at, order) @ inverse, slopes @ inverse


def _shapes(edges: Array, at: Array, order: int) -> tuple[Array, Array]:
    """Return the values and the slopes of all nodes' shapes at places, (places, nodes) each."""
    cell = np.clip(np.searchsorted(edges, at) - 1, 0, edges.size - 2)
    h = np.diff(edges)[cell]
    found = np.zeros((2, at.size, order * (edges.size - 1) + 1))
    own = np.arange(at.size)[:, None], order * cell[:, None] + np.arange(order + 1)
    found[0][own], slopes = _on_cell(_rule(order)[0], 2.0 * (at - edges[cell]) / h - 1.0)
    found[1][own] = slopes * (2.0 / h)[:, None]
    return found[0], found[1]


def _nodes(edges: Array, order: int) -> Array:
    """Return the nodes of all cells, ascending."""
    inner = edges[:-1, None] + np.diff(edges)[:, None] * (_rule(order)[0][:-1] + 1.0) / 2
    return np.append(inner.ravel(), edges[-1])


def _points(edges: Array, order: int) -> Array:
    """Return the Gauss points of all cells, shape (cells, points)."""
    points = np.polynomial.legendre.leggauss(order + _BEYOND)[0]
    return edges[:-1, None] + np.diff(edges)[:, None] * (points + 1.0) / 2


def _forms(edges: Array, order: int, span: tuple[float, float] | None = None, *, radial: bool = False) -> _Forms:
    """Return stiffness and mass over the cells within a span; across r with the weight r, and u' + u/r for u'."""
    _, weights, shapes, slopes = _rule(order)
    h = np.diff(edges)[:, None]
    w = weights * h / 2
    if span is not None:
        middle = (edges[1:] + edges[:-1]) / 2
        w = w * ((middle > span[0]) & (middle < span[1]))[:, None]
    u, du = np.broadcast_to(shapes, (h.size, *shapes.shape)), slopes * (2.0 / h)[:, :, None]
    if radial:
        r = _points(edges, order)
        w, du = w * r, du + u / r[:, :, None]
    return _assembled(w, du, order), _assembled(w, u, order)


def _assembled(weights: Array, shapes: Array, order: int) -> csr_matrix:
    """Return the sum over cells and points of weights (c, g) by products of shapes (c, g, nodes)."""
    local = np.einsum("cg,cgi,cgj->cij", weights, shapes, shapes)
    dofs = order * np.arange(len(local))[:, None] + np.arange(order + 1)
    i, j = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    size = order * len(local) + 1
    return csr_matrix((local.ravel(), (i.ravel(), j.ravel())), shape=(size, size))


def _product(across: _Forms, along: _Forms) -> _Forms:
    """Return the forms c and m of the module docstring."""
    (k, m), (own, mass) = across, along
    return csr_matrix(kron(m, own) + kron(k, mass)), csr_matrix(kron(m, mass))


def _source(r: Array, z: Array, discs: Sequence[CoaxialDisc], coil: Coil) -> Array:
    """Return g: the coil's potential at the discs' nodes."""
    g, tracks = np.zeros((r.size, z.size)), coil_sections(coil)
    for disc in discs:
        i = np.flatnonzero(np.abs(2 * r - disc.radius - disc.inner) < disc.radius - disc.inner + _SAME * r[-1])
        j = np.flatnonzero((z >= disc.bottom) & (z <= disc.top))
        rho, height = r[i][:, None], z[j][None, :]
        g[np.ix_(i, j)] = rho * ring_profile(coil, rho, height, disc.away(tracks), _SOURCE)
    return g


def _far_boundary(lines: Lines, r: Array, z: Array, order: int) -> csr_matrix:
    """Return b(u, v) as a matrix: of the side, and of both ends."""
    far, middle = lines.r[-1], (lines.z[0] + lines.z[-1]) / 2
    height, radius, end = _points(lines.z, order) - middle, _points(lines.r, order), lines.z[-1] - middle
    side = _side(lines.z, 3 * far**2 / (far**2 + height**2) - 2.0, order)
    ends = _side(lines.r, 3 * end * radius / (radius**2 + end**2), order)
    last, both = np.zeros(r.size), np.zeros(z.size)
    last[-1] = both[0] = both[-1] = 1.0
    return csr_matrix(kron(diags_array(last), side) + kron(ends, diags_array(both)))


def _side(edges: Array, factor: Array, order: int) -> csr_matrix:
    """Return the mass along a side with a factor at its points (cells, points)."""
    _, weights, shapes, _ = _rule(order)
    weights = weights * np.diff(edges)[:, None] / 2 * factor
    return _assembled(weights, np.broadcast_to(shapes, (len(weights), *shapes.shape)), order)
