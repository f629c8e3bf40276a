"""Learn what the units of a production share from readings of some, for the next ones: fewer loads a unit, its yield.

Of each unknown, in deviations z from what is known beforehand (analysis/built/fit.py), a unit j has

    z_j = m + d_j,    m ~ N(0, A) of the production,    d_j ~ N(0, W) of each unit,    A + W = 1,  W diagonal:

the silicone of one mix, the load cell of one bench and the errors of one model are shared, glue and tilt hardly. A
unit's readings tell I_j (z - z_j)^2, b_j = I_j z_j, by Laplace's approximation; without its own d_j, of m

    K_j = (1 + I_j W)^-1 I_j,    g_j = (1 + I_j W)^-1 b_j,    Cov m = (A^-1 + sum K_j)^-1,    m = Cov m sum g_j,

and the next unit is known to be m, with Cov m + W. Each unit is then adapted anew with what the others tell. W is the
most likely one of the readings, w_k^2 known as by `_AS_MANY` units (expectation and maximisation of the scaled inverse
chi^2; A. Gelman and others, Bayesian Data Analysis, 3rd ed. 2013, sections 5.4 and 13.4):

    w_k^2 <- (n w_0k^2 + sum_j E d_jk^2)/(n + J),    d_j by b_j - I_j m with D_j = (1 + W I_j)^-1 W.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sits_mech.analysis.bench.unknowns import CELL, PriorParameter
from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.fit import Free
from sits_mech.analysis.built.mistakes import STRANGE
from sits_mech.analysis.built.prior import Prior, inverted, root_of
from sits_mech.analysis.readings.measured import Measured
from sits_mech.cases import Progress, no_progress
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError

_MIX = {"modulus": 0.03, "stiffening": 0.01}  # deviations between units of one mix, chosen
_HALF = 0.5  # of the variance of others that is each unit's, chosen; units themselves tell
_AS_MANY = 4.0  # units that these count as
_ROUNDS, _SETTLED = 500, 1e-3  # of expectation and maximisation, and the change that ends them


class Evidence(NamedTuple):
    """What a unit's readings tell: I and b of the module docstring."""

    information: Array  # (p, p)
    vector: Array  # (p,)


@dataclass(frozen=True)
class Population:
    """What is known of m, and what units scatter by, in deviations beforehand."""

    mean: Array  # (p,)
    covariance: Array  # (p, p)
    within: Array  # w, (p,)


@dataclass(frozen=True)
class Production:
    """What readings of some units tell of all."""

    start: Prior  # what was known before any
    next: Prior  # what is known of one more unit
    within: Array  # deviations between units, of parameters and factors, (p,) [SI; of the modulus relative]
    units: dict[str, Adaptation]  # each by its own readings and those of the others
    refused: dict[str, str]  # whose readings tell nothing, and why

    @classmethod
    def alone(cls, prior: Prior) -> Production:
        """Return the production whose units share nothing of what is unknown."""
        return cls(prior, prior, prior.deviations / _over(prior), {}, {})

    @property
    def between(self) -> Array:
        """Standard deviations between the next units, (p,) [SI]."""
        return self.within * _over(self.next)


def _over(prior: Prior) -> Array:
    """Return what deviations between units are relative to, the modulus alone to its own, (p,)."""
    return np.array([(each.value or 1.0) if each.name == "modulus" else 1.0 for each in prior.known])


def produced(
    prior: Prior, units: Mapping[str, Measured], within: Mapping[str, float], *, progress: Progress = no_progress,
    **noises: Any,
) -> Production:
    """Return what readings of units tell of their production, and each unit with the help of the others.

    `prior` is of a unit before any is read; `units` are the readings of each, of which those that are hardly of such a
    sensor do not count for the others; `within` are deviations between units by name of the unknown [SI, of the modulus
    relative], others by half of the variance; `progress` gets the number of fits done and of all; `noises` as of
    `adapt`. Raises SceneError for a name that is not unknown, or when no unit is such a sensor.
    """
    count = 0

    def fits_from(priors: Mapping[str, Prior]) -> tuple[dict[str, Adaptation], dict[str, str]]:
        """Return each unit adapted, and why some are not."""
        nonlocal count
        found, refused = {}, {}
        for name, measured in units.items():
            try:
                found[name] = adapt(priors[name], measured, **noises)
            except SceneError as error:
                refused[name] = str(error)
            count += 1
            progress(count, 2 * len(units))
        return found, refused

    first, refused = fits_from(dict.fromkeys(units, prior))
    good = [name for name, found in first.items() if found.p_value >= STRANGE]
    if not good:
        why = next(iter(refused.values()), f"p-values below {STRANGE}")
        raise SceneError(f"units: must have one or more that are such sensors; got none: {why}")
    evidence, (mean, scatter) = {name: evidence_of(first[name]) for name in good}, _scatter(prior, within)
    shared = shared_by(list(evidence.values()), mean, scatter)
    priors = {}
    for name in units:
        others = [each for other, each in evidence.items() if other != name]
        priors[name] = _next(prior, shared_by(others, mean, shared.within, settled=True))
    found, refused = fits_from(priors)
    return Production(prior, _next(prior, shared), shared.within * prior.deviations / _over(prior), found, refused)


def evidence_of(found: Adaptation) -> Evidence:
    """Return what the readings of a unit tell, without what was known before."""
    count, fit = len(found.values), found.fit
    pairs = list(zip(found.known.free[:count], found.values.tolist(), strict=True))
    slopes = np.array([each.known_slope(value) for each, value in pairs])
    z = np.array([float(each.known(np.array(value))) for each, value in pairs])
    whole = inverted(found.covariance / fit.variance * np.outer(slopes, slopes))
    before = np.eye(count) if found.prior.root is None else found.prior.root.T @ found.prior.root
    root = root_of(whole - before)
    return Evidence(root @ root.T / fit.variance, whole @ z / fit.variance)


def _scatter(prior: Prior, stated: Mapping[str, float]) -> tuple[Array, Array]:
    """Return A and the square roots of W of the module docstring to begin with, diagonals (p,)."""
    names = [each.name for each in prior.known]
    unknown = [name for name in stated if name not in prior.setup.names]
    if unknown:
        raise SceneError(f"within: must be of {', '.join(prior.setup.names)}; got {', '.join(unknown)}")
    one = np.full(len(names), np.sqrt(_HALF))
    for k, each in enumerate(prior.known):
        if each.name in CELL or each in prior.factors:
            one[k] = 0.0
        size = stated.get(each.name, _MIX.get(each.name))
        if size is not None:
            one[k] = size * ((each.value or 1.0) if each.name == "modulus" else 1.0) / each.deviation
    return np.maximum(1.0 - one**2, 0.0), one


def shared_by(units: list[Evidence], mean: Array, within: Array, *, settled: bool = False) -> Population:
    """Return what units tell of m and W; `mean`, A, and `within`, the root of W, to begin with, or `settled`."""
    p, first = len(within), within**2
    W, one = first.copy(), np.eye(p)
    for _ in range(_ROUNDS):
        own = [np.linalg.solve(one + each * W, np.column_stack([each, b])) for each, b in units]
        total = np.sum(own, axis=0) if own else np.zeros((p, p + 1))
        covariance = np.linalg.solve(one + mean[:, None] * total[:, :p], np.diag(mean))
        m = covariance @ total[:, p]
        if settled or not units:
            break
        squares = np.zeros(p)
        for each, b in units:
            D = np.linalg.solve(one + W[:, None] * each, np.diag(W))
            squares += (D @ (b - each @ m)) ** 2 + np.diagonal(D + D @ each @ covariance @ each @ D)
        new = np.where(first > 0.0, (_AS_MANY * first + squares) / (_AS_MANY + len(units)), 0.0)
        done = np.max(np.abs(new - W) / np.maximum(W, 1e-300)) < _SETTLED
        W = new
        if done:
            break
    return Population(m, 0.5 * (covariance + covariance.T), np.sqrt(W))


def _next(prior: Prior, shared: Population) -> Prior:
    """Return what is known of one more unit."""
    whole = shared.covariance + np.diag(shared.within**2)
    size = np.sqrt(np.diagonal(whole))
    known = []
    for each, z, width in zip(prior.known, shared.mean.tolist(), size.tolist(), strict=True):
        value = each.value or 0.0
        free = Free(each.name, value, -np.inf, np.inf, 1.0, each.deviation, ratio=each.name == "modulus")
        there = free.value(z)
        known.append(PriorParameter(each.name, there, width * each.deviation * (there / value if free.ratio else 1.0)))
    return prior.known_together(known, whole / np.outer(size, size))
