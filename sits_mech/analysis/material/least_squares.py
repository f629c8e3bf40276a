"""Fit the stable constants of least residual: one least-squares solver for each kind of law.

    minimise over x   |w (P(x) - P_measured)|^2 / 2     under the stability conditions of fitted.py

    linear in its constants (LinearFit)   P = A x, conditions C x >= 0 (a convex programme)
    a sum of terms (TermFit)              P = sum_p m_p a(x_p): bounded nonlinear least squares by trust region; of
                                          several starts for the shapes x, each with the best m >= 0, the best few

Stresses are divided by the data's initial stiffness before solving, so that moduli are of order one. Derivatives by
shapes and constants are central differences of the law's own stress. Covariance of the free unknowns, J the weighted
Jacobian, s the residual's deviation, W the squared weights:

    (J^T J)^-1 (J^T W J) (J^T J)^-1 s^2 n / n_independent,    n_independent = 2 (runs of one sign of the residual) <= n

and where there are several specimens k, r_k their residuals, s that of each with constants of its own beside

    n/(n - 1) sum_k d_k d_k^T,    d_k = (J^T J)^-1 J_k^T r_k,    k = 1..n (of the same strains: their mean's variance)

Source: C. L. Lawson, R. J. Hanson, Solving Least Squares Problems (1974); G. H. Golub, V. Pereyra, SIAM J. Numer. Anal.
10 (1973) 413, for unknowns of which some are linear; H. White, Econometrica 48 (1980) 817, for the covariance.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from scipy.optimize import LinearConstraint, least_squares, minimize, nnls
from scipy.stats import t as student

from sits_mech.analysis.material.points import MeasuredPoints
from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import PLANE, principal_stretches, state_stress, tangent
from sits_mech.silicone.laws import Constants, Law
from sits_mech.silicone.laws.law import LinearFit, TermFit

_STIFFNESS_LEFT = 1e-3  # smallest stiffness kept in the fitted range, relative to the initial one
_REFINED = 6  # starts that are looked into
_NO_TERM = 1e-7  # a term of this share of the stiffness is none
_ONE_TERM = 0.02  # two shapes closer than this are one
_T = TypeVar("_T")
_STEP = 1e-6  # of differences, relative to a range or a value


@dataclass(frozen=True)
class Answer:
    """Fitted constants with half-widths, residual and notes."""

    constants: dict[str, float | tuple[float, ...]]
    confidence: dict[str, float | None | tuple[float | None, ...]]
    rms: float  # [Pa]
    notes: tuple[str, ...] = ()


def fit_constants(law: Law, points: MeasuredPoints, terms: int) -> Answer:
    """Fit the stable constants of least residual at the points; `terms` for a law that may have several."""
    if isinstance(law.fit, LinearFit):
        return _fit_linear(law, law.fit, points)
    return _fit_terms(law, law.fit, points, terms if law.fit.several else 1)


def _fit_linear(law: Law, fit: LinearFit, points: MeasuredPoints) -> Answer:
    """Fit a law that is linear in its constants."""
    names, scale = tuple(law.units), points.scale
    unit = [dict.fromkeys(names, 0.0) | {name: 1.0} for name in names]
    matrix = np.stack([state_stress(law.name, one, points.stretches) for one in unit], axis=1)
    signs = np.eye(len(names))[[names.index(name) for name in fit.not_negative]]
    other = np.reshape(fit.tension_alone if points.tension_alone else (), (-1, len(names)))
    conditions = np.vstack([_conditions(law, unit, points), signs, other])
    answer = _least_squares(matrix * points.weight[:, None], points.stress * points.weight / scale, conditions) * scale
    size = 1.0 / np.linalg.norm(matrix * points.weight[:, None], axis=0)  # what each constant weighs in the stress
    answer = np.where(np.abs(answer / size) > 1e-9 * np.abs(answer / size).max(), answer, 0.0)
    limits = conditions * size / np.linalg.norm(conditions * size, axis=1)[:, None]
    holds = limits @ (answer / size) <= 1e-7 * np.linalg.norm(answer / size)
    held, by = limits[holds], ("the stability conditions", "what other modes than tension allow")
    free = np.linalg.svd(held)[2][np.linalg.matrix_rank(held, 1e-3) :].T if len(held) else np.eye(len(names))
    free = size[:, None] * free
    residual = matrix @ answer - points.stress
    widths = half_widths(matrix @ free, free, residual, points.weight, points.specimen)
    return Answer(
        constants=dict(zip(names, (float(value) for value in answer), strict=True)),
        confidence=dict(zip(names, widths, strict=True)),
        rms=_rms(residual, points),
        notes=tuple(
            f"the constants are held by {what}"
            for what, some in zip(by, np.split(holds, [len(holds) - len(other)]), strict=True) if some.any()
        ),
    )


def _conditions(law: Law, unit: list[dict[str, float]], points: MeasuredPoints) -> Array:
    """Return the rows C of C x >= 0: stiffness less the share of it to be kept."""
    ends, step = points.ends(), 1e-6
    pull = np.geomspace(*ends["uniaxial"], 201)
    planar = principal_stretches("planar", np.geomspace(1.0, ends["planar"][1], 101))
    states, directions, columns = principal_stretches("uniaxial", pull), _directions(planar), []
    for one in unit:
        up, down = (
            state_stress(law.name, one, principal_stretches("uniaxial", pull * (1.0 + way * step))) for way in (1, -1)
        )
        along = np.einsum("naa->na", tangent(law.name, one, states))
        turned = np.einsum("nka,nab,nkb->nk", directions, tangent(law.name, one, planar), directions)
        at_rest = tangent(law.name, one, np.ones((1, 3)))[0, 0, 0]
        rows = np.concatenate([(up - down) / (2.0 * step * pull) * (2.0 / 3.0), along.ravel(), turned.ravel()])
        rest = at_rest - _STIFFNESS_LEFT * along[-1, 1]  # not zero either where the law stiffens
        columns.append(np.r_[rows - _STIFFNESS_LEFT * at_rest, rest] / 4.0)
    return np.stack(columns, axis=1)


def _directions(stretches: Array) -> Array:
    """Return unit increments to test, (n, 3, 2): two fixed ones, and where a law of I1 fails first."""
    along = stretches**2 @ PLANE
    first = np.linalg.solve(tangent("neo-hookean", {"shear_modulus": 1.0}, stretches), along[..., None])[..., 0]
    size = np.linalg.norm(first, axis=1, keepdims=True)
    first = np.where(size > 1e-9, first / np.maximum(size, 1e-9), [1.0, 0.0])  # at rest all directions are alike
    fixed = np.broadcast_to(np.eye(2), (len(stretches), 2, 2))
    return np.concatenate([fixed, first[:, None, :]], axis=1)


def _least_squares(matrix: Array, right: Array, conditions: Array) -> Array:
    """Solve least squares under ``conditions @ answer >= 0``, a small convex programme."""
    free = np.asarray(np.linalg.lstsq(matrix, right)[0], dtype=np.float64)
    if (conditions @ free >= 0.0).all():
        return free
    size = np.linalg.norm(matrix, axis=0)  # columns of one size: c30 multiplies far larger numbers than c10
    scaled, limits = matrix / size, conditions / size
    limits = limits / np.linalg.norm(limits, axis=1)[:, None]

    def left(x: Array) -> tuple[float, Array]:
        """Return half the squared residual, and its gradient."""
        residual = scaled @ x - right
        return 0.5 * float(residual @ residual), scaled.T @ residual

    start = np.zeros(matrix.shape[1])
    start[0] = float(scaled[:, 0] @ right)
    inside = LinearConstraint(limits, 0.0, np.inf)
    answer = minimize(left, start, jac=True, method="SLSQP", constraints=inside, options={"ftol": 1e-15})
    constants: Array = answer.x / size
    return constants


def _columns(law: Law, fit: TermFit, stretches: Array, shapes: Array) -> Array:
    """Return the stress of a term of unit modulus at each shape, shape (n, shapes)."""
    each = [fit.constants(np.ones(1), shapes[k : k + 1]) for k in range(len(shapes))]
    return np.stack([state_stress(law.name, constants, stretches) for constants in each], axis=1)


def _fit_terms(law: Law, fit: TermFit, points: MeasuredPoints, terms: int) -> Answer:
    """Fit a law of one or several terms; fewer where the data do not determine more."""
    reach = float(points.excess.max())
    shapes = fit.starts(reach)
    shapes = shapes[shapes >= fit.tension_alone] if points.tension_alone else shapes
    starts = _starts(_columns(law, fit, points.stretches, shapes), points, terms)
    found = [_refined(law, fit, points, shapes[chosen]) for chosen in starts]
    m, x, _ = min(found, key=lambda answer: answer[2])
    order = np.argsort(x)
    m, x = m[order] * points.scale, x[order]
    if terms > 1 and ((m <= _NO_TERM * m.sum()).any() or (np.diff(x) < _ONE_TERM).any()):
        fewer = _fit_terms(law, fit, points, terms - 1)
        return replace(fewer, notes=(*fewer.notes, f"the data determine no {terms} terms"))
    constants, held = fit.constants(m, x), fit.held(x, reach)
    residual = state_stress(law.name, constants, points.stretches) - points.stress
    free = np.eye(2 * terms)[:, np.r_[np.ones(terms, dtype=bool), ~held]]
    slopes = _slopes(law, constants, points.stretches) @ free
    widths = half_widths(slopes, free, residual, points.weight, points.specimen)
    return Answer(
        constants=constants,
        confidence=_like(constants, widths),
        rms=_rms(residual, points),
        notes=(fit.note,) if held.any() else (),
    )


def _starts(columns: Array, points: MeasuredPoints, terms: int) -> list[list[int]]:
    """Return the choices of shapes, by index, of least residual with non-negative moduli."""
    small = np.asarray(
        np.linalg.qr(np.column_stack([columns, points.stress / points.scale]) * points.weight[:, None], mode="r")
    )
    choices = [list(chosen) for chosen in itertools.combinations(range(columns.shape[1]), terms)]
    return sorted(choices, key=lambda chosen: float(nnls(small[:, chosen], small[:, -1])[1]))[:_REFINED]


def _refined(law: Law, fit: TermFit, points: MeasuredPoints, start: Array) -> tuple[Array, Array, float]:
    """Return scaled moduli, shapes and cost of the nearest minimum."""
    terms, root, right = len(start), points.weight[:, None], points.stress * points.weight / points.scale
    low, high = fit.limits(start, float(points.excess.max()))

    def columns(x: Array) -> Array:
        """Return the weighted stress of each term at unit modulus."""
        return _columns(law, fit, points.stretches, x) * root

    def residual(unknowns: Array) -> Array:
        """Return the weighted residual."""
        return columns(unknowns[terms:]) @ unknowns[:terms] - right

    def jacobian(unknowns: Array) -> Array:
        """Return the derivative of the residual."""
        x, step = unknowns[terms:], _STEP * (high - low)
        below, above = np.maximum(x - step, low), np.minimum(x + step, high)
        slope = (columns(above) - columns(below)) / (above - below)
        return np.hstack([columns(x), slope * unknowns[:terms]])

    m = np.maximum(nnls(columns(start), right)[0], 1e-4)
    limits = np.r_[np.zeros(terms), low], np.r_[np.full(terms, np.inf), high]
    size = np.r_[np.ones(terms), np.abs(start)]
    found = least_squares(
        residual, np.r_[m, start], jacobian, limits, x_scale=size, ftol=1e-15, xtol=1e-15, gtol=1e-15, max_nfev=300
    )
    return found.x[:terms], found.x[terms:], float(found.cost)


def _slopes(law: Law, constants: Constants, stretches: Array) -> Array:
    """Return the derivatives of the stress by each constant, in order, shape (n, numbers)."""
    numbers = np.concatenate([np.atleast_1d(value) for value in constants.values()])
    found = []
    for step in np.diag(_STEP * np.where(numbers == 0.0, 1.0, np.abs(numbers))):
        ways = numbers + step, numbers - step
        up, down = (state_stress(law.name, _like(constants, way.tolist()), stretches) for way in ways)
        found.append((up - down) / (2.0 * step.sum()))
    return np.stack(found, axis=1)


def _rms(residual: Array, points: MeasuredPoints) -> float:
    """Return the weighted root mean square of the residual."""
    return float(np.sqrt(np.average(residual**2, weights=points.weight**2)))


def half_widths(
    slopes: Array, free: Array, residual: Array, weight: Array, specimen: Array | int = 0
) -> list[float | None]:
    """Return 95 % half-widths of constants, None for one the data do not determine.

    `slopes` (n, k): derivatives of the stress by k unknowns; `free` (constants, k): of the constants by these; residual
    and root weight (n,), specimen of each point (n,).
    """
    count, unknowns = slopes.shape
    specimen, together, residual = np.broadcast_to(specimen, count), residual, residual.copy()
    several = int(specimen.max())
    for k in range(several and several + 1):
        one = specimen == k
        residual[one] -= slopes[one] @ np.linalg.lstsq(slopes[one] * weight[one, None], (residual * weight)[one])[0]
    runs = 1 + int(np.count_nonzero(np.diff(np.sign(residual))))
    independent = min(count, 2 * runs)
    size = np.linalg.norm(slopes * weight[:, None], axis=0)
    if independent <= unknowns or unknowns == 0 or not size.all():
        return [None] * len(free)
    weighted = slopes * weight[:, None] / size
    if np.linalg.cond(weighted) > 1e10:
        return [None] * len(free)
    inverse = np.linalg.pinv(weighted)
    spread = np.sum(residual**2 * weight**2) / np.sum(weight**2) * count / (independent - unknowns)
    change = free / size @ inverse * weight
    deviation = np.sqrt(spread * (change**2).sum(axis=1)) * student.ppf(0.975, independent - unknowns)
    if several:
        apart = np.linalg.norm((change * together) @ np.eye(several + 1)[specimen], axis=1)
        deviation = np.hypot(deviation, student.ppf(0.975, several) * np.sqrt(1.0 + 1.0 / several) * apart)
    return [float(value) if value > 0.0 else None for value in deviation]


def _like(constants: Constants, numbers: Sequence[_T]) -> dict[str, _T | tuple[_T, ...]]:
    """Distribute numbers over the names of constants, as many as each has."""
    rest = iter(numbers)
    return {
        name: tuple(next(rest) for _ in value) if isinstance(value, tuple) else next(rest)
        for name, value in constants.items()
    }
