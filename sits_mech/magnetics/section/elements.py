"""Complex vector potential of plates in the coils' known field: forms, open boundary, solution, flux linkage.

Strong form, per metre of depth, ``exp(+j omega t)``, A along y in the section x-z; A_c is the coils' potential in free
space (closed form, `source`), A_r = A - A_c the reaction of the plates:

    -div(nu grad A) + j omega sigma (A - e_k) = 0    in plate k,      nu = 1 / (mu_r mu0),
    -div(grad A_r) = 0                               in air,
    A and nu dA/dn continuous,                       A_r -> 0 far away.

e_k [V s/m] is the plate's common potential: it makes the net current of an isolated plate zero, and is 0 for a plate
whose current returns at a circle of radius R_b where A = 0 (A_c then carries the bars' images in that circle).

Unknowns u [V s/m]: A in the plates, A_r in the air, so that nothing cancels where the skin effect drives A to e_k, and
the coils need no mesh. With g = A_c at the plates' nodes, 0 elsewhere, an air element at a plate sees u - g; times mu0,

    a(u, v) = int_plates grad u . grad v / mu_r + int_air grad u . grad v
              + sum_k j omega mu0 sigma_k int_k (u - e_k) v + b(u, v),
    a(u, v) = int_all grad g . grad v    for all v,

since A_c is harmonic over the plates. Beyond the circle of radius R around the plates A_r is a series in r^-m (less its
image for a grounded circle), whose flux is known: with c_m(v) the integral of v cos(m theta) d theta over the circle,

    b(u, v) = sum_m (m / pi) c_m(u) c_m(v) (1 + q) / (1 - q) + the same with sine,    q = (R / R_b)^2m or 0,

and for m = 0 the factor 1 / (2 pi ln(R_b / R)), or any for isolated plates, where it only fixes the constant. The
circle is a polygon of the same mean ln r. What coil c links of the reaction to coil d is, by reciprocity, an integral
over the plates,

    Phi_cd = -(1/mu0) [int (1/mu_r - 1) grad g_c . grad u_d + sum_k j omega mu0 sigma_k int_k g_c (u_d - e_k)],

symmetric in c and d to rounding and, with its error quadratic in the error of u, twice as good as the field.
Delta L = Re Phi, R = -omega Im Phi.

Elements: Lagrange triangles of order 2 and 3 on one mesh; the difference of the two answers is the energy of the
difference of the fields, hence a sum over elements: error estimate and guide for refinement in one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0
from scipy.sparse import csc_matrix, csr_matrix, eye_array, hstack, vstack
from skfem import Basis, ElementTriP2, ElementTriP3, FacetBasis, LinearForm
from skfem.models.poisson import laplace, mass, unit_load

from sits_mech.geometry.plates import PlateSection
from sits_mech.magnetics.axis.elements import refined_solution
from sits_mech.magnetics.section.coils import CoilBars, coil_potentials
from sits_mech.magnetics.section.mesh import DividedPlane
from sits_mech.quantities import Array, Complex, Integers

_ELEMENTS = {2: ElementTriP2, 3: ElementTriP3}
_HARMONICS = 0.25  # of the circle's edges


@LinearForm
def _harmonic(v, w):  # type: ignore[no-untyped-def]
    x, z = w.x[0] - w.centre.real, w.x[1] - w.centre.imag
    angle = (x * w.n[0] + z * w.n[1]) / (x * x + z * z)  # d theta / d s
    return v * angle * np.cos(w.order * np.arctan2(z, x) - w.phase)


@dataclass(frozen=True)
class FieldSolution:
    """The field of every coil, one ampere each, at one order."""

    basis: Basis  # on the whole mesh
    u: Complex  # (dofs, n) A in the plates, A_r in the air [V s/m per A]
    g: Array  # (dofs, n) A_c at the plates' nodes, 0 elsewhere [V s/m per A]
    e: Complex  # (plates, n) common potential of each plate [V s/m per A]
    flux: Complex  # (n, n) Phi [H/m]
    residual: float  # of the linear system, relative to its right-hand side


def solve_field(
    division: DividedPlane, plates: tuple[PlateSection, ...], coils: tuple[CoilBars, ...], omega: float, order: int,
    ground: float | None = None,
) -> FieldSolution:
    """Solve for every coil, one ampere each, with elements of order 2 or 3; omega [rad/s], `ground` R_b [m]."""
    basis = Basis(division.mesh, _ELEMENTS[order](), intorder=2 * order)
    parts = [basis.with_elements(np.flatnonzero(division.part == k)) for k in range(len(plates) + 1)]
    stiffness = [laplace.assemble(part).tocsr() for part in parts]

    weights = [unit_load.assemble(part) for part in parts[1:]]
    k2 = np.array([1j * omega * mu_0 * plate.conductivity for plate in plates])
    D = csr_matrix(stiffness[0].shape, dtype=complex)
    for plate, part, K, s in zip(plates, parts[1:], stiffness[1:], k2, strict=True):
        D = D + (1.0 / plate.relative_permeability - 1.0) * K + s * mass.assemble(part).tocsr()
    K0 = sum(stiffness[1:], stiffness[0])
    g, dofs = np.zeros((basis.N, len(coils))), np.unique(np.concatenate([_dofs(part) for part in parts[1:]]))
    x, z = basis.doflocs[:, dofs]
    g[dofs] = coil_potentials(coils, x + 1j * z, ground)
    for plate, part, m in zip(plates, parts[1:], weights, strict=True):
        if plate.isolated:  # a constant in the plate changes e_k alone, and would cost digits
            g[_dofs(part)] -= m @ g / m.sum()
    open_boundary = _open_boundary(basis, division, ground)
    isolated = [plate.isolated for plate in plates]
    u, e, residual = _solve(K0 + D + open_boundary, K0 @ g, weights, k2, isolated)
    induced = D @ u - sum(np.outer(s * m, row) for s, m, row in zip(k2, weights, e, strict=True))
    flux: Complex = np.asarray(-(g.T @ induced) / mu_0)
    return FieldSolution(basis, u, g, e, flux, residual)


def _dofs(part: Basis) -> Integers:
    """Return unknowns of a part, its rim included."""
    return np.unique(part.element_dofs)


def _open_boundary(basis: Basis, division: DividedPlane, ground: float | None) -> csr_matrix:
    """Return b(u, v) as a matrix."""
    facets = FacetBasis(basis.mesh, basis.elem, facets=basis.mesh.boundary_facets(), intorder=2 * basis.elem.maxdeg + 2)
    rows, factors = [], []
    for m in range(int(_HARMONICS * len(facets.find)) + 1):
        q = 0.0 if ground is None else (division.radius / ground) ** (2 * m)
        alone = 1.0 if ground is None else 1.0 / (2 * np.pi * np.log(ground / division.radius))  # of m = 0
        factor = m / np.pi * (1 + q) / (1 - q) if m else alone
        for phase in (0.0, np.pi / 2) if m else (0.0,):
            rows.append(_harmonic.assemble(facets, order=float(m), phase=phase, centre=division.centre))
            factors.append(factor)
    C = csr_matrix(np.array(rows))
    return csr_matrix(C.T.multiply(np.array(factors)) @ C)


def _solve(
    S: csr_matrix, f: Array, weights: list[Array], k2: Complex, isolated: list[bool]
) -> tuple[Complex, Complex, float]:
    """Solve with the common potentials of isolated plates as further unknowns, each equation over its plate's area."""
    free = [k for k, alone in enumerate(isolated) if alone]
    e = np.zeros((len(isolated), f.shape[1]), dtype=complex)
    system, load = S, f.astype(complex)
    if free:
        m = np.column_stack([weights[k] for k in free])
        columns, rows = csr_matrix(-m * k2[free]), csr_matrix((-m / m.sum(axis=0)).T)
        system = csr_matrix(vstack([hstack([S, columns]), hstack([rows, eye_array(len(free))])]))
        load = np.vstack([load, np.zeros((len(free), f.shape[1]))])
    solution, residual = refined_solution(csc_matrix(system), load)
    e[free] = solution[S.shape[0] :]
    return solution[: S.shape[0]], e, residual


def element_errors(
    division: DividedPlane, plates: tuple[PlateSection, ...], omega: float, coarse: FieldSolution, fine: FieldSolution
) -> Array:
    """Return each element's share of the difference of two orders' flux linkages, shape (elements,) [H/m].

    The energy of the difference of the fields, all coils together.
    """
    share = np.zeros(division.part.size)
    for k in range(len(plates) + 1):
        elements = np.flatnonzero(division.part == k)
        values = [_field_on(solution, elements, fine.basis.quadrature, k) for solution in (coarse, fine)]
        energy = np.sum(np.abs(values[1][0] - values[0][0]) ** 2, axis=1)
        if k > 0:
            energy = energy / plates[k - 1].relative_permeability
            energy += omega * mu_0 * plates[k - 1].conductivity * np.abs(values[1][1] - values[0][1]) ** 2
        dx = Basis(division.mesh, fine.basis.elem, elements=elements, quadrature=fine.basis.quadrature).dx
        share[elements] = np.einsum("cep,ep->e", energy, dx) / mu_0
    return share


def _field_on(
    solution: FieldSolution, elements: Integers, quadrature: tuple[Array, Array], part: int
) -> tuple[Complex, Complex]:
    """Return gradient (coils, 2, elements, points) and value less e_k (coils, elements, points) in one part."""
    basis = Basis(solution.basis.mesh, solution.basis.elem, elements=elements, quadrature=quadrature)
    u = solution.u - solution.g if part == 0 else solution.u
    e = np.zeros(u.shape[1]) if part == 0 else solution.e[part - 1]
    fields = [basis.interpolate(column) for column in u.T]
    slopes = np.array([np.asarray(field.grad) for field in fields])
    return slopes, np.array([np.asarray(field) - c for field, c in zip(fields, e, strict=True)])
