"""Eddy-current modes of a plate in three dimensions, seen through polynomial fields; one preparation, any pose.

Strong form in the plate: ``J = -j omega sigma (A_coils + A_J)``, div J = 0, no current through the surface, with
``A_J(r) = mu0 / (4 pi) int J(r') / |r - r'| dV'``. Weak form over the divergence-free currents w of `loops`:

    (1/sigma) <w, J> + j omega mu0 / (4 pi) << w, J / |r - r'| >> = -j omega <w, A_coils>,

that is ``(R + j omega L) i = -j omega g`` with R and L real, symmetric and independent of pose and frequency (complex
Hermitian in a disc's angular orders). A vertical loop's or sheet's moment in each cell meets the mean of 1/r between
cells (`prisms`). The plate's symmetries split the problem into classes, each with its own modes.

The coils' potential over the plate is a polynomial: the products of Chebyshev polynomials ``T_i T_j T_k`` on its
bounding box, for each component of A. Coefficients fall like ``rho^-(i+j+k)``; weighted by that, the few
combinations the plate can see are kept (`Sheeted.bases`), and a pose pays for these alone:

    Delta Z_cd = omega^2 sum_k a_ck a_dk / (1 + j omega tau_k),   a_c = coupling^T basis^T (coefficients).

A gradient drives no current; in cells with uniform current it drives one of the order of the cells' error, another on
each division. Combinations of fields are kept without their gradients, so that divisions are levels of one family.

Both skin regimes are one: sheets and cells are graded to faces and rim below the skin depth, and grow to the plate's
size away from them. Neglected: displacement current; cells carry uniform current (error of second order).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import cholesky, eigh, solve_triangular

from sits_mech.geometry.sheet_plan import Plan
from sits_mech.magnetics.modes import Modes, few_modes
from sits_mech.magnetics.space.classes import Problem, first_alike, kernel, mixed, problems, scaled, stacked
from sits_mech.magnetics.space.coupling import Sheeted
from sits_mech.magnetics.space.fields import Basis, Box, decay_scale, field_means, without_gradients
from sits_mech.quantities import Array, Complex, Integers

_KEEP = 1e-5  # weaker combinations of fields are left out: their energy, to the strongest, is the square
_SKETCH = 256  # random currents, doubled until they show weaker combinations
_ROUNDING = 1e-12  # a field whose means are smaller, to the largest, is of another symmetry than the class


def prepare_sheets(
    divisions: Sequence[tuple[Plan, Array]], conductivity: float, box: Box, *, highest: float, depth: float = 0.0
) -> tuple[Sheeted, ...]:
    """Find a plate's modes on several divisions, the finest first, whose combinations of fields serve for all.

    A division is the plan of the outline or of its fundamental part, and z (l + 1,) of the sheets' interfaces from the
    middle plane (0) up to the top face [m]. The modes answer up to the frequency `highest` [Hz]; within `depth` of the
    rim current may pass between sheets [m].
    """
    bases: dict[tuple[int, int], Basis] = {}
    found: list[tuple[dict[tuple[int, int], Modes], int, int]] = []
    metal = conductivity, 2 * np.pi * highest
    for (plan, levels), first in zip(divisions, first_alike(divisions), strict=True):
        once = found[first][:2] if first < len(found) else _modes(plan, levels, metal, (box, depth), bases)
        found.append((*once, 2 * (levels.size - 1)))
    if not bases:
        raise ValueError("outline: the division leaves the currents no freedom; the metal is too narrow")
    none = {key: Modes(np.zeros(0), np.zeros((basis.size, 0))) for key, basis in bases.items()}
    seen = tuple(bases.values())
    return tuple(
        Sheeted(box, seen, tuple(classes.get(key, none[key]) for key in bases), unknowns, sheets)
        for classes, unknowns, sheets in found
    )


def packed(plates: Sequence[Sheeted]) -> dict[str, Any]:
    """Return the divisions of a plate as arrays by name."""
    first = plates[0]
    found: dict[str, Any] = {"sizes": [[plate.unknowns, plate.sheets] for plate in plates]}
    for k, basis in enumerate(first.bases):
        found |= {f"rows_{k}": basis.rows, f"fields_{k}": basis.fields, f"widths_{k}": basis.widths}
    for d, plate in enumerate(plates):
        for k, part in enumerate(plate.classes):
            found |= {f"tau_{d}_{k}": part.tau, f"coupling_{d}_{k}": part.coupling, f"highest_{d}_{k}": part.highest}
    return found


def unpacked(box: Box, arrays: Mapping[str, Any]) -> tuple[Sheeted, ...]:
    """Return the divisions of a plate from their arrays."""
    sizes = arrays["sizes"].tolist()
    count = sum(f"rows_{k}" in arrays for k in range(len(arrays)))
    bases = tuple(Basis(*(arrays[f"{name}_{k}"] for name in ("rows", "fields", "widths"))) for k in range(count))
    return tuple(
        Sheeted(box, bases, tuple(
            Modes(arrays[f"tau_{d}_{k}"], arrays[f"coupling_{d}_{k}"], highest=float(arrays[f"highest_{d}_{k}"]))
            for k in range(count)
        ), *own)
        for d, own in enumerate(sizes)
    )


def _modes(
    plan: Plan, levels: Array, metal: tuple[float, float], reach: tuple[Box, float],
    bases: dict[tuple[int, int], Basis],
) -> tuple[dict[tuple[int, int], Modes], int]:
    """Return classes of one division by order and mirror, and unknowns; the first division fills `bases`.

    `metal` is its conductivity and the highest angular frequency.
    """
    box, depth = reach
    prisms = stacked(plan, levels)
    means = kernel(plan, levels, prisms)
    fields = field_means(plan, prisms, box)
    classes, unknowns, first = {}, 0, not bases
    for key, problem in problems(plan, levels, depth):
        if not (first or key in bases):
            continue
        L, R, unit = scaled(problem, means, metal[0])
        bases[key], B = combined(problem, box, fields, (R, unit), bases.get(key))
        classes[key] = few_modes(L, R, B, metal[1], weight=problem.weight)
        unknowns += problem.loops.unknowns * int(problem.weight)
    return classes, unknowns


def combined(
    problem: Problem, box: Box, fields: Array, units: tuple[Complex, Array], basis: Basis | None, keep: float = _KEEP
) -> tuple[Basis, Complex]:
    """Return a class's combinations of fields, and their fluxes (r, unknowns).

    `fields` are as of `field_means`, `units` R and the unit of each unknown, as of `scaled`; `basis` is another
    division's, or None: to be found. Combinations weaker than `keep`, to the strongest, are left out.
    """
    (R, unit), scale = units, decay_scale(box)
    rows, B = _fluxes(problem, fields, None if basis is None else basis.rows)
    B = B * unit * scale[rows, None]
    if basis is None:
        strong = without_gradients(box, rows, _resisted(R, B, problem.weight))
        basis = _by_level(box, rows, _strongest(strong, keep) / scale[rows, None])
    return basis, (basis.fields * scale[basis.rows, None]).T @ B[np.searchsorted(rows, basis.rows)]


def _resisted(R: Complex, B: Complex, weight: float) -> Array:
    """Return rows of B R^-1/2: what fields drive where nothing but resistance stops the currents."""
    seen = solve_triangular(cholesky(R, lower=True), B.conj().T, lower=True).conj().T
    if np.iscomplexobj(seen):
        seen = np.hstack([seen.real, seen.imag]) * np.sqrt(weight)
    return seen.real


def _strongest(seen: Array, keep: float) -> Array:
    """Return a few orthonormal combinations of fields in which currents see nearly all, from `seen` (fields, currents).

    Of many they are sought in what random currents show.
    """
    size = np.linalg.norm(seen, axis=1)
    rows = np.flatnonzero(size > keep * 1e-2 * size.max())
    coupled, span = seen[rows], np.eye(0)
    count, most = _SKETCH, min(coupled.shape) // 2
    while count < most:
        span = np.linalg.qr(coupled @ np.random.default_rng(2).normal(size=(coupled.shape[1], count)))[0]
        within = span.T @ coupled
        values, vectors = eigh(within @ within.T)
        if values[0] < keep**2 * values[-1]:
            break
        count *= 2
    else:
        few = coupled.shape[1] < coupled.shape[0]
        values, vectors = eigh(coupled.T @ coupled if few else coupled @ coupled.T)
        span = coupled if few else np.eye(len(rows))
    kept = values > keep**2 * values[-1]
    basis = np.zeros((seen.shape[0], int(kept.sum())))
    basis[rows] = span @ vectors[:, kept]
    return np.asarray(basis / np.linalg.norm(basis, axis=0))


def _by_level(box: Box, rows: Integers, fields: Array) -> Basis:
    """Turn combinations so that low levels drive the first ones alone, without rows of zeros."""
    kept = np.flatnonzero(fields.any(axis=1))
    level = box.levels()[rows[kept]]
    order = kept[np.argsort(level, kind="stable")]
    widths = np.searchsorted(np.sort(level), np.arange(max(map(len, box.sizes))), "right")
    turned = np.asarray(np.linalg.qr(fields[order].T, mode="r")).T
    return Basis(rows[order], turned, np.minimum(widths, fields.shape[1]))


def _fluxes(problem: Problem, fields: Array, rows: Integers | None) -> tuple[Integers, Complex]:
    """Return which of the three components' coefficients a class sees, and their fluxes B (rows, unknowns)."""
    pairs, weights, moments = problem.parts
    means = mixed(weights, fields)
    sees = np.zeros((3, fields.shape[-1]), dtype=bool)
    if rows is None:  # most are of another symmetry than the class
        least = _ROUNDING * max(np.abs(P).max() for P in means)
        for (a, _), P in zip(pairs, means, strict=True):
            sees[a] |= np.abs(P).max(axis=0) > least
    else:
        sees.flat[rows] = True
    B: Any = [np.zeros((np.count_nonzero(some), problem.loops.unknowns), dtype=weights.dtype) for some in sees]
    for (a, b), P in zip(pairs, means, strict=True):
        B[a] += (moments[b].T @ P[:, sees[a]]).T
    return np.flatnonzero(sees), np.vstack(B)
