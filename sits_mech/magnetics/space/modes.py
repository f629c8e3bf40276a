"""Eddy currents of a plate in three dimensions, seen through polynomial fields; one preparation, any pose.

Strong form in the plate: ``J = -j omega sigma (A_coils + A_J)``, div J = 0, no current through the surface, with
``A_J(r) = mu0 / (4 pi) int J(r') / |r - r'| dV'``. Weak form over the divergence-free currents w of `loops`:

    (1/sigma) <w, J> + j omega mu0 / (4 pi) << w, J / |r - r'| >> = -j omega <w, A_coils>,

that is ``(R + j omega L) i = -j omega g`` with R and L real, symmetric and independent of pose and frequency (complex
Hermitian in a disc's angular orders). A vertical loop's or sheet's moment in each cell meets the mean of 1/r between
cells (`prisms`). The plate's symmetries split the problem into classes, each reduced once for all frequencies
(`magnetics.modes`), which costs as much as one of them alone.

The coils' potential over the plate is a polynomial: the products of Chebyshev polynomials ``T_i T_j T_k`` on its
bounding box, for each component of A. Coefficients fall like ``rho^-(i+j+k)``; weighted by that, the few
combinations the plate can see are kept (`Sheeted.bases`), and a pose pays for these alone:

    Delta Z_cd = a_c^T Y a_d,    Y = omega^2 B (R + j omega L)^-1 B^T,    a_c = basis^T (coefficients).

A gradient drives no current. In cells of uniform current it drives a little, of the order of their error and different
on each division, so that gradients are removed from the combinations of fields.

Both skin regimes are one: sheets and cells are graded to faces and rim below the skin depth, and grow to the plate's
size away from them. Neglected: displacement current; cells carry uniform current (error of second order).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import cholesky, eigh, solve_triangular

from sits_mech.geometry.sheet_plan import CellPlan
from sits_mech.magnetics.modes import Reduced, reduced
from sits_mech.magnetics.space.classes import (
    Problem,
    driven,
    first_alike,
    kernel,
    mixed,
    problems,
    scaled,
    stacked,
)
from sits_mech.magnetics.space.coupling import Sheeted
from sits_mech.magnetics.space.fields import Basis, Box, Parity, decay_scale, field_means, without_gradients
from sits_mech.magnetics.space.sources import Sources
from sits_mech.quantities import Array, Complex, Integers

_KEEP = 1e-5  # weaker combinations of fields are left out: their energy, to the strongest, is the square
_WEAK = 4e-6  # the same, to the strongest of all classes of a round plate: L is as by 1e-7 to 1e-6 of its change
_SKETCH = 256  # random currents, doubled until they show weaker combinations
_ROUNDING = 1e-12  # a field whose means are smaller, to the largest, is of another symmetry than the class
_sizes = partial(np.linalg.norm, axis=0)  # strengths of combinations (rows, r)
_Key = tuple[int, int]  # of a class, by order and mirror
_ARRAYS = "diagonal", "off_diagonal", "coupling"  # of a class


def prepare_sheets(
    divisions: Sequence[tuple[CellPlan, Array]], conductivity: float, box: Box, highest: float = math.inf,
    depth: float = 0.0,
) -> tuple[Sheeted, ...]:
    """Prepare a plate on several divisions, the finest first, whose combinations of fields serve for all.

    A division is the plan of the outline or of its fundamental part, and z (l + 1,) of the sheets' interfaces from the
    middle plane (0) up to the top face [m]. Cells resolve the skin depth up to the angular frequency `highest` [rad/s];
    within `depth` of the rim current may pass between sheets [m].
    """
    bases, known = shared_bases(divisions, (conductivity, depth), box)
    found: list[tuple[dict[_Key, Reduced], int, int]] = []
    for division, first in zip(divisions, first_alike(divisions), strict=True):
        if first < len(found):
            once = found[first][:2]
        else:
            unknowns, classes = 0, dict[_Key, Reduced]()
            own = known.pop(id(division[0]), problems(*division, depth))
            for key, one, (L, R, _), B in matrices_of(division, own, conductivity, (box, None), bases):
                if key in bases:
                    classes[key] = reduced(L, R, B, weight=one.weight, highest=highest)
                    unknowns += one.loops.unknowns * int(one.weight)
            once = classes, unknowns
        found.append((*once, 2 * (division[1].size - 1)))
    check_free(bases)
    still = np.eye(1)
    none = {key: reduced(still, still, np.zeros((basis.size, 1)), highest=highest) for key, basis in bases.items()}
    seen = tuple(bases.values())
    return tuple(
        Sheeted(box, seen, tuple(classes.get(key, none[key]) for key in bases), unknowns, sheets)
        for classes, unknowns, sheets in found
    )


def check_free(found: Mapping[_Key, object]) -> None:
    """Refuse a division without classes of currents."""
    if not found:
        raise ValueError("outline: the division leaves the currents no freedom; the metal is too narrow")


def division_arrays(plates: Sequence[Sheeted]) -> dict[str, Any]:
    """Return the divisions of a plate as arrays by name."""
    found: dict[str, Any] = {"sizes": [[plate.unknowns, plate.sheets] for plate in plates]}
    for k, basis in enumerate(plates[0].bases):
        found |= {f"rows_{k}": basis.rows, f"fields_{k}": basis.fields}
    for d, plate in enumerate(plates):
        for k, part in enumerate(plate.classes):
            found |= {f"{name}_{d}_{k}": value for name, value in vars(part).items() if isinstance(value, np.ndarray)}
    return found


def division_from_arrays(box: Box, highest: float, arrays: Mapping[str, Any]) -> tuple[Sheeted, ...]:
    """Return the divisions of a plate from their arrays; the rest as of `prepare_sheets`."""
    count = sum(f"rows_{k}" in arrays for k in range(len(arrays)))
    bases = tuple(Basis(arrays[f"rows_{k}"], arrays[f"fields_{k}"]) for k in range(count))

    def part(*place: int) -> Reduced:
        """Return a class of a division."""
        own = {name: arrays["_".join(map(str, (name, *place)))] for name in _ARRAYS}
        return Reduced(**own, highest=highest)

    each = enumerate(arrays["sizes"].tolist())
    return tuple(Sheeted(box, bases, tuple(part(d, k) for k in range(count)), *own) for d, own in each)


def shared_bases(
    divisions: Sequence[tuple[CellPlan, Array]], metal: tuple[float, float], box: Box
) -> tuple[dict[_Key, Basis], dict[int, list[tuple[_Key, Problem]]]]:
    """Return combinations of fields (`combined`) that any of a round plate's levels along it sees, and their classes.

    Of other plates there are none; classes are those of the first division of a plan, by its identity.
    A class has few cells across a sector, in whose means other divisions' are not; and fields of orders that the
    sectors of one do not tell from lower ones. By the first division's alone, discs beside their coils were 3e-3 off.
    Classes add to one Delta Z: what is weak is so to the strongest combination of them all, `_WEAK`.
    """
    if not np.iscomplex(divisions[0][0].characters).any():
        return {}, {}
    scale, plans = decay_scale(box), {id(plan): (plan, levels) for plan, levels in divisions[::-1]}
    seeing: dict[_Key, list[tuple[Problem, list[Parity]]]] = {}
    known = {plan: list(problems(*division, metal[1])) for plan, division in plans.items()}
    for plan, division in plans.items():
        fields = field_means(division[0], stacked(*division), box)
        for key, problem in known[plan]:
            seeing.setdefault(key, []).append((problem, fields))
    strong: dict[_Key, tuple[Integers, Array]] = {}
    for key, each in seeing.items():
        seen, sees = [], np.zeros(scale.size, dtype=bool)
        for problem, fields in each:
            rows, B = _fluxes(problem, _mixed_means(problem, fields))
            R = problem.losses.toarray() / metal[0]
            part = _resisted(R, B * scale[rows, None], problem.weight)
            seen.append(np.zeros((scale.size, part.shape[1])))
            seen[-1][rows], sees[rows] = part, True
        rows = np.flatnonzero(sees)
        strong[key] = rows, _strongest(without_gradients(box, rows, np.hstack(seen)[rows]), _WEAK)
    most = max(_sizes(found).max() for _, found in strong.values())
    return {
        key: _basis(rows, found[:, _sizes(found) >= min(_WEAK * most, _sizes(found).max())], scale)
        for key, (rows, found) in strong.items()
    }, known


def matrices_of(
    division: tuple[CellPlan, Array], classes: Iterable[tuple[_Key, Problem]], conductivity: float,
    seen: tuple[Box | None, Sources | None], bases: dict[_Key, Basis], keep: float = _KEEP,
) -> Iterator[tuple[_Key, Problem, tuple[Complex, Complex, Array], Complex]]:
    """Yield the classes of a division: order and mirror, problem, L and R and units (`scaled`), fluxes (r, unknowns).

    Fluxes are of what is `seen`: combinations of fields on a box, of which the first division fills `bases`, and then
    coils at rest; `classes` as of `problems`.
    """
    (box, sources), prisms, first = seen, stacked(*division), not bases
    means = kernel(*division, prisms)
    fields = [] if box is None else field_means(division[0], prisms, box)
    driving = None if sources is None else sources.means(division[0], prisms)
    for key, problem in classes:
        L, R, unit = scaled(problem, means, conductivity)
        B: Any = np.zeros((0, len(unit)))
        if box is not None and (first or key in bases):
            bases[key], B = combined(problem, box, fields, (R, unit), bases.get(key), keep)
        if driving is not None:
            B = np.vstack([B, driven(problem, driving) * unit])
        yield key, problem, (L, R, unit), B


def combined(
    problem: Problem, box: Box, fields: Sequence[Parity], units: tuple[Complex, Array], basis: Basis | None,
    keep: float = _KEEP,
) -> tuple[Basis, Complex]:
    """Return a class's combinations of fields, and their fluxes (r, unknowns).

    `fields` are as of `field_means`, `units` R and the unit of each unknown, as of `scaled`; `basis` is another
    division's, or None: to be found. Combinations weaker than `keep`, to the strongest, are left out.
    """
    (R, unit), scale = units, decay_scale(box)
    means = _mixed_means(problem, fields)
    if basis is None:
        rows, B = _fluxes(problem, means)
        strong = without_gradients(box, rows, _resisted(R, B * unit * scale[rows, None], problem.weight))
        basis = _basis(rows, _strongest(strong, keep), scale)
    shapes = np.zeros((scale.size, basis.size))
    shapes[basis.rows] = basis.fields * scale[basis.rows, None] ** 2
    found: Any = sum(problem.transposed[b] @ (P @ shapes[rows]) for rows, b, P in means)
    return basis, found.T * unit


def _basis(rows: Integers, strong: Array, scale: Array) -> Basis:
    """Return combinations from those of coefficients over their sizes, of any strength."""
    some = strong.any(axis=1)
    return Basis(rows[some], strong[some] / _sizes(strong) / scale[rows[some], None])


def _resisted(R: Complex, B: Complex, weight: float) -> Array:
    """Return rows of B R^-1/2: what fields drive where nothing but resistance stops the currents."""
    seen = solve_triangular(cholesky(R, lower=True), B.conj().T, lower=True).conj().T
    if np.iscomplexobj(seen):
        seen = np.hstack([seen.real, seen.imag]) * np.sqrt(weight)
    return seen.real


def _strongest(seen: Array, keep: float) -> Array:
    """Return few orthogonal combinations of fields, of their strength, that hold nearly all of what is `seen`.

    `seen` are (fields, currents). Where there are many, they are found from random currents.
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
    return np.asarray(basis * (np.sqrt(values[kept]) / _sizes(basis)))


def _mixed_means(problem: Problem, fields: Sequence[Parity]) -> list[tuple[Integers, int, Complex]]:
    """Return what a class sees: coefficients of a component, the moments that meet it, sums of means over images.

    Of a class of order m all with i + j of another parity than m, and half along z, cancel: a quarter is summed.
    """
    pairs, weights, _ = problem.parts
    found, size = [], sum(part.columns.size for part in fields)
    for part in fields:
        folded = weights @ part.signs
        some = np.flatnonzero(np.abs(folded).max(axis=1) > _ROUNDING * len(part.signs))
        for k, P in zip(some.tolist(), mixed(folded[some], part.means), strict=True):
            found.append((pairs[k][0] * size + part.columns, pairs[k][1], P))
    return found


def _fluxes(problem: Problem, means: list[tuple[Integers, int, Complex]]) -> tuple[Integers, Complex]:
    """Return which of the three components' coefficients a class sees, and their fluxes B (rows, unknowns)."""
    largest = [np.abs(P).max(axis=0) for *_, P in means]
    least = _ROUNDING * max(each.max() for each in largest)
    rows = np.unique(np.concatenate([own[each > least] for (own, *_), each in zip(means, largest, strict=True)]))
    B = np.zeros((rows.size, problem.loops.unknowns), dtype=problem.parts[1].dtype)
    for own, b, P in means:
        seen = np.isin(own, rows)
        B[np.searchsorted(rows, own[seen])] += (problem.transposed[b] @ P[:, seen]).T
    return rows, B
