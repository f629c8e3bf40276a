"""Which stable constants leave the smallest residual? One least-squares solver for each kind of law.

    minimise over x   |w (P(x) - P_measured)|^2 / 2     under the stability conditions of fitting.py

    neo-hookean, mooney-rivlin, yeoh   linear:  P = A x, conditions C x >= 0 (a convex programme)
    ogden, gent                        bounded nonlinear least squares with the exact Jacobian, by trust region

Stresses are divided by the data's initial stiffness before solving, so that unknowns are of order one; Gent's law is
solved for ``q = 1/j_m``, which is zero where the data do not lock. Covariance of the free unknowns, J the weighted
Jacobian, s the residual's deviation, W the squared weights:

    (J^T J)^-1 (J^T W J) (J^T J)^-1 s^2 n / n_independent,    n_independent = 2 (runs of one sign of the residual) <= n
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import LinearConstraint, brentq, least_squares, minimize, nnls
from scipy.stats import t as student

from sits_mech.mechanics.homogeneous import PLANE, principal_stretches, state_stress, tangent
from sits_mech.quantities import Array
from sits_mech.silicone.laws import LAWS

_STIFFNESS_LEFT = 1e-3  # smallest stiffness kept in the fitted range, relative to the initial one
_EXPONENTS = (-16.0, -10.0, -6.5, -4.0, -2.5, 1.2, 1.8, 2.6, 4.0, 6.5, 10.0, 16.0)  # where the search for alpha starts
_REFINED = 6
_REACH = 30.0  # largest size of an exponent
_NO_TERM = 1e-7  # an Ogden term of this share of the stiffness is none
_ONE_TERM = 0.02  # two exponents closer than this are one
_FLAT = 1e-5  # a j_m above 1/_FLAT is no locking


@dataclass(frozen=True)
class Points:
    """What was measured: principal stretches (n, 3) [-], engineering stress (n,) [Pa], root of the weight (n,) [-]."""

    stretches: Array
    stress: Array
    weight: Array

    @property
    def scale(self) -> float:
        """The secant modulus at the largest stretch [Pa]."""
        last = int(np.argmax(self.stretches[:, 0]))
        return float(self.stress[last] / (self.stretches[last, 0] - 1.0))

    @property
    def excess(self) -> Array:
        """I1 - 3 of every point, shape (n,)."""
        found: Array = (self.stretches**2).sum(axis=1) - 3.0
        return found

    def ends(self) -> dict[str, tuple[float, float]]:
        """Return the uniaxial and planar stretches that have the largest I1 of the points."""
        most = float(self.excess.max())

        def beyond(stretch: float, mode: str) -> float:
            """Return how far a state's I1 is beyond the largest."""
            return float((principal_stretches(mode, np.array([stretch])) ** 2).sum()) - 3.0 - most

        reach = 2.0 + np.sqrt(most)
        return {
            mode: (brentq(beyond, 1e-3 / reach**2, 1.0, (mode,)), brentq(beyond, 1.0, reach, (mode,)))
            for mode in ("uniaxial", "planar")
        }


@dataclass(frozen=True)
class Answer:
    """Constants, their half-widths, what is left [Pa], and remarks."""

    constants: dict[str, float | tuple[float, ...]]
    confidence: dict[str, float | None | tuple[float | None, ...]]
    rms: float
    notes: tuple[str, ...] = ()


def fit_constants(law: str, points: Points, terms: int) -> Answer:
    """Return the stable constants of `law` that leave the smallest residual at `points`.

    Parameters
    ----------
    law : str
        A key of `sits_mech.materials.LAWS`.
    points : Points
        The data.
    terms : int
        Number of Ogden's terms.

    Returns
    -------
    Answer
        The constants, with their confidence.
    """
    if law == "ogden":
        return _fit_ogden(points, terms)
    return _fit_gent(points) if law == "gent" else _fit_linear(law, points)


def _fit_linear(law: str, points: Points) -> Answer:
    """Fit a law that is linear in its constants."""
    names, scale = tuple(LAWS[law].units), points.scale
    unit = [dict.fromkeys(names, 0.0) | {name: 1.0} for name in names]
    matrix = np.stack([state_stress(law, one, points.stretches) for one in unit], axis=1)
    conditions = _conditions(law, unit, points)
    answer = _least_squares(matrix * points.weight[:, None], points.stress * points.weight / scale, conditions) * scale
    size = 1.0 / np.linalg.norm(matrix * points.weight[:, None], axis=0)  # what each constant weighs in the stress
    answer = np.where(np.abs(answer / size) > 1e-9 * np.abs(answer / size).max(), answer, 0.0)
    limits = conditions * size / np.linalg.norm(conditions * size, axis=1)[:, None]
    held = limits[limits @ (answer / size) <= 1e-7 * np.linalg.norm(answer / size)]
    free = np.linalg.svd(held)[2][np.linalg.matrix_rank(held, 1e-3) :].T if len(held) else np.eye(len(names))
    free = size[:, None] * free
    residual = matrix @ answer - points.stress
    widths = _half_widths(matrix @ free, free, residual, points.weight)
    return Answer(
        constants=dict(zip(names, (float(value) for value in answer), strict=True)),
        confidence=dict(zip(names, widths, strict=True)),
        rms=_rms(residual, points),
        notes=("the constants are held by the stability conditions",) if len(held) else (),
    )


def _conditions(law: str, unit: list[dict[str, float]], points: Points) -> Array:
    """Return rows whose products with the constants must not be negative: stiffness less the share of it to be kept."""
    ends, step = points.ends(), 1e-6
    pull = np.geomspace(*ends["uniaxial"], 201)
    planar = principal_stretches("planar", np.geomspace(1.0, ends["planar"][1], 101))
    states, directions, columns = principal_stretches("uniaxial", pull), _directions(planar), []
    for one in unit:
        up, down = (
            state_stress(law, one, principal_stretches("uniaxial", pull * (1.0 + way * step))) for way in (1, -1)
        )
        along = np.einsum("naa->na", tangent(law, one, states))
        turned = np.einsum("nka,nab,nkb->nk", directions, tangent(law, one, planar), directions)
        at_rest = tangent(law, one, np.ones((1, 3)))[0, 0, 0]
        rows = np.concatenate([(up - down) / (2.0 * step * pull) * (2.0 / 3.0), along.ravel(), turned.ravel()])
        rest = at_rest - _STIFFNESS_LEFT * along[-1, 1]  # not zero either where the law stiffens
        columns.append(np.r_[rows - _STIFFNESS_LEFT * at_rest, rest] / 4.0)
    found = np.stack(columns, axis=1)
    return np.vstack([found, np.eye(3)[2:]]) if law == "yeoh" else found


def _directions(stretches: Array) -> Array:
    """Return unit increments to look along, shape (n, 3, 2): two fixed ones, and where a law of I1 gives way first."""
    along = stretches**2 @ PLANE
    first = np.linalg.solve(tangent("neo-hookean", {"shear_modulus": 1.0}, stretches), along[..., None])[..., 0]
    size = np.linalg.norm(first, axis=1, keepdims=True)
    first = np.where(size > 1e-9, first / np.maximum(size, 1e-9), [1.0, 0.0])  # at rest all directions are alike
    fixed = np.broadcast_to(np.eye(2), (len(stretches), 2, 2))
    found: Array = np.concatenate([fixed, first[:, None, :]], axis=1)
    return found


def _least_squares(matrix: Array, right: Array, conditions: Array) -> Array:
    """Return the least-squares answer under ``conditions @ answer >= 0`` (a small convex programme)."""
    free: Array = np.asarray(np.linalg.lstsq(matrix, right)[0], dtype=np.float64)
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


def _ogden_columns(stretches: Array, alpha: Array) -> tuple[Array, Array]:
    """Return the stress per unit of each mu, and its derivative in alpha, shape (n, terms)."""
    powers = stretches[:, [0, 2], None] ** alpha
    logs = powers * np.log(stretches[:, [0, 2], None])
    column = 2.0 / alpha * (powers[:, 0] - powers[:, 1]) / stretches[:, :1]
    return column, 2.0 / alpha * (logs[:, 0] - logs[:, 1]) / stretches[:, :1] - column / alpha


def _fit_ogden(points: Points, terms: int) -> Answer:
    """Fit Ogden's law: mu > 0, alpha at least 1 or at most -2."""
    right, root = points.stress * points.weight / points.scale, points.weight[:, None]
    best = min(
        (_refined_ogden(points, right, alpha) for alpha in _ogden_starts(points, right, terms)),
        key=lambda found: float(found[2]),
    )
    order = np.argsort(best[1])
    mu, alpha = best[0][order] * points.scale, best[1][order]
    if terms > 1 and ((mu <= _NO_TERM * mu.sum()).any() or (np.diff(alpha) < _ONE_TERM).any()):
        fewer = _fit_ogden(points, terms - 1)
        return replace(fewer, notes=(*fewer.notes, f"the data determine no {terms} terms"))
    column, slope = _ogden_columns(points.stretches, alpha)
    residual = column @ mu - points.stress
    held = np.isclose(np.abs(alpha), np.where(alpha > 0.0, 1.0, 2.0), rtol=1e-5) | (np.abs(alpha) > 0.9999 * _REACH)
    free = np.eye(2 * len(mu))[:, np.r_[np.ones(len(mu), dtype=bool), ~held]]
    widths = _half_widths(np.hstack([column, slope * mu]) @ free, free, residual, root[:, 0])
    return Answer(
        constants={"mu": tuple(mu.tolist()), "alpha": tuple(alpha.tolist())},
        confidence={"mu": tuple(widths[: len(mu)]), "alpha": tuple(widths[len(mu) :])},
        rms=_rms(residual, points),
        notes=("an exponent is held at the end of its range",) if held.any() else (),
    )


def _ogden_starts(points: Points, right: Array, terms: int) -> list[Array]:
    """Return the choices of exponents that leave least with the best mu >= 0."""
    column = _ogden_columns(points.stretches, np.array(_EXPONENTS))[0] * points.weight[:, None]
    small: Array = np.asarray(np.linalg.qr(np.column_stack([column, right]), mode="r"))
    ranked = sorted(
        (float(nnls(small[:, list(chosen)], small[:, -1])[1]), chosen)
        for chosen in itertools.combinations(range(len(_EXPONENTS)), terms)
    )
    return [np.array(_EXPONENTS)[list(chosen)] for _, chosen in ranked[:_REFINED]]


def _refined_ogden(points: Points, right: Array, alpha: Array) -> tuple[Array, Array, float]:
    """Return mu (scaled), alpha and the cost of the nearest minimum."""
    terms, root = len(alpha), points.weight[:, None]
    mu = np.maximum(nnls(_ogden_columns(points.stretches, alpha)[0] * root, right)[0], 1e-4)

    def residual(x: Array) -> Array:
        """Return what is left."""
        column, _ = _ogden_columns(points.stretches, x[terms:])
        left: Array = column * root @ x[:terms] - right
        return left

    def jacobian(x: Array) -> Array:
        """Return its derivative."""
        column, slope = _ogden_columns(points.stretches, x[terms:])
        return np.hstack([column, slope * x[:terms]]) * root

    low = np.r_[np.zeros(terms), np.where(alpha > 0.0, 1.0, -_REACH)]
    high = np.r_[np.full(terms, np.inf), np.where(alpha > 0.0, _REACH, -2.0)]
    found = least_squares(
        residual, np.r_[mu, alpha], jacobian, (low, high), ftol=1e-15, xtol=1e-15, gtol=1e-15, max_nfev=300
    )
    return found.x[:terms], found.x[terms:], float(found.cost)


def _fit_gent(points: Points) -> Answer:
    """Fit Gent's law: with ``q = 1/j_m`` given, mu follows; q is searched for."""
    right, excess = points.stress * points.weight / points.scale, points.excess
    plain = state_stress("neo-hookean", {"shear_modulus": 1.0}, points.stretches) * points.weight
    most = (1.0 - 1e-6) / float(excess.max())

    def residual(x: Array) -> Array:
        """Return what is left."""
        left: Array = x[0] * plain / (1.0 - x[1] * excess) - right
        return left

    def jacobian(x: Array) -> Array:
        """Return its derivative."""
        column = plain / (1.0 - x[1] * excess)
        return np.stack([column, x[0] * column * excess / (1.0 - x[1] * excess)], axis=1)

    bounds = ([0.0, _FLAT * most], [np.inf, most])
    found = least_squares(
        residual, [0.3, 0.3 * most], jacobian, bounds, x_scale=[1.0, most], ftol=1e-15, xtol=1e-15, gtol=1e-15
    )
    mu, j_m = points.scale * float(found.x[0]), 1.0 / float(found.x[1])
    flat = found.x[1] < 1e2 * _FLAT * most
    weighted = jacobian(found.x) * [1.0, -points.scale * float(found.x[1]) ** 2]
    free = np.eye(2)[:, : 1 if flat else 2]
    left = residual(found.x) * points.scale / points.weight
    widths = _half_widths(weighted / points.weight[:, None] @ free, free, left, points.weight)
    return Answer(
        constants={"shear_modulus": mu, "j_m": j_m},
        confidence={"shear_modulus": widths[0], "j_m": widths[1]},
        rms=_rms(left, points),
        notes=("the data show no locking: j_m is at the end of its range",) if flat else (),
    )


def _rms(residual: Array, points: Points) -> float:
    """Return the weighted root mean square of what is left."""
    return float(np.sqrt(np.average(residual**2, weights=points.weight**2)))


def _half_widths(slopes: Array, free: Array, residual: Array, weight: Array) -> list[float | None]:
    """Return 95 % half-widths of the constants, from the derivatives of the stress in their free combinations."""
    count, unknowns = slopes.shape
    runs = 1 + int(np.count_nonzero(np.diff(np.sign(residual))))
    independent = min(count, 2 * runs)
    if independent <= unknowns or unknowns == 0:
        return [None] * len(free)
    size = np.linalg.norm(slopes * weight[:, None], axis=0)
    weighted = slopes * weight[:, None] / size
    if np.linalg.cond(weighted) > 1e10:
        return [None] * len(free)
    inverse = np.linalg.pinv(weighted)
    spread = np.sum(residual**2 * weight**2) / np.sum(weight**2) * count / (independent - unknowns)
    change = free / size @ inverse * weight
    deviation = np.sqrt(spread * (change**2).sum(axis=1)) * student.ppf(0.975, independent - unknowns)
    return [float(value) if value > 0.0 else None for value in deviation]
