"""Say what one more unit of a production is delivered with, and keep what is known of it for the next ones."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sits_mech.analysis.bench.load_plan import LoadPlan
from sits_mech.analysis.bench.unknowns import PriorParameter, parameter_unit
from sits_mech.analysis.built.prior import Prior, root_of
from sits_mech.analysis.built.production import Production
from sits_mech.memory import input_text
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError
from sits_mech.units import quantity, shown

_LOTS, _UNITS = 100, 40  # for a yield to one percent
_READ = {0: "tared", 1: "and 1 load"}
MOST = 0.9
"""Share of units, and of each one's loads, that an error covers."""


class Delivered(NamedTuple):
    """What one more unit is delivered with after some readings."""

    after: str  # what was read, in words
    error: Array  # of its range, within which `MOST` of a force's readings lie on `MOST` of the units (d,)
    good: float  # share of units all of whose forces are within a limit there, over all lots that may be
    lots: tuple[float, float]  # the same of single lots: `MOST` of them have more than the first, less than the second


def delivered(found: Production, plan: LoadPlan, limit: float) -> list[Delivered]:
    """Return what one more unit is delivered with: after no reading of its own, a tare, and the loads of a plan.

    Of a unit with theta = m + d, known to be N(0, C) with C = Cov m + W and read with the information I, is left open

        e = Sigma (I^(1/2) n - C^-1 (m + d)),    Sigma = (C^-1 + I)^-1,    n noise,

    where m is one of the lot, the same for all its units.
    """
    prior, read, random = found.next, plan.read, np.random.default_rng(0)
    answers, by = prior.force_slopes(prior.start, read)
    own, C, size = np.hypot(prior.noise, prior.model), prior.covariance, prior.deviations
    by, C = by * size, C / np.outer(size, size)
    between = found.between / size
    lots = root_of(C - np.diag(between**2))
    shape = (_LOTS, _UNITS, len(size))
    theta = random.standard_normal((_LOTS, 1, len(size))) @ lots.T + between * random.standard_normal(shape)
    noise, alone = random.standard_normal(shape), random.standard_normal((_LOTS, _UNITS, *by.shape[:2]))
    known = np.linalg.inv(C)
    steps = [("as computed", known)]
    steps += [(_READ.get(n, f"and {n} loads"), each * np.outer(size, size)) for n, each in enumerate(plan.known_after)]
    rows = []
    for words, information in steps:
        e = (noise @ root_of(information - known).T - theta @ known.T) @ np.linalg.inv(information)
        errors = np.einsum("mdn,mnp,ljp->ljmd", answers, by, e, optimize=True)
        errors += np.einsum("mdn,ljmn->ljmd", answers, own * alone, optimize=True)
        each = np.quantile(np.abs(errors) / np.ptp(read, axis=0), MOST, axis=2)
        good = np.mean(np.all(each <= limit, axis=-1), axis=1)
        ends = np.quantile(good, [1.0 - MOST, MOST]).tolist()
        rows.append(Delivered(words, np.quantile(each, MOST, axis=(0, 1)), float(good.mean()), (ends[0], ends[1])))
    return rows


def spread_of(prior: Prior, texts: Sequence[str]) -> dict[str, float]:
    """Read deviations between units: ``modulus=2 %``, ``gap=20 um``, ``target.width=1 %`` [SI, the modulus relative].

    Raises SceneError for anything else.
    """
    found = {}
    for text in texts:
        name, _, size = (part.strip() for part in text.partition("="))
        if name not in prior.setup.names or not size:
            raise SceneError(f"within: must be name=deviation of {', '.join(prior.setup.names)}; got {text}")
        share = size.endswith("%") and name != "modulus" and abs(float(prior.start[prior.setup.names.index(name)]))
        found[name] = quantity(size, "" if share else parameter_unit(name, size), f"within: {name}") * (share or 1.0)
        if not 0.0 <= found[name] < np.inf:
            raise SceneError(f"within: {name}: must be zero or more; got {size}")
    return found


def lot_record(prior: Prior) -> dict[str, Any]:
    """Return what is known of one more unit, SI, as `known_by` reads it."""
    size = prior.deviations
    return {
        "sensor": prior.sensor.name,
        "unknowns": {each.name: {"value": each.value, "deviation": each.deviation} for each in prior.known},
        "correlation": (prior.covariance / np.outer(size, size)).tolist(),
    }


def known_by(prior: Prior, path: Path) -> Prior:
    """Return a sensor of which a file of `lot_record` says what is known; SceneError where it is of others."""
    try:
        record = json.loads(input_text(path, "a readable lot.json"))
        names, alike = list(record["unknowns"]), np.array(record["correlation"], dtype=float)
        known = [
            PriorParameter(name, float(one["value"]), float(one["deviation"]))
            for name, one in record["unknowns"].items()
        ]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise SceneError(f"{path}: must be a lot.json of sits-mech lot; got: {error}") from None
    own = [each.name for each in prior.known]
    if names != own or alike.shape != (len(own), len(own)):
        raise SceneError(f"{path}: must be of the same unknowns, {', '.join(own)}; got {', '.join(names)}")
    if (name := record.get("sensor")) != prior.sensor.name:
        raise SceneError(f"{path}: must be of the sensor {prior.sensor.name}; got {shown(name)}")
    sizes = np.array([(each.value, each.deviation) for each in known])
    sound = np.isfinite(sizes).all() & np.all(sizes[:, 1] > 0.0) & np.allclose(alike, alike.T)
    if not sound or np.min(np.linalg.eigvalsh(alike)) < 1e-9:  # rounding
        raise SceneError(f"{path}: must hold deviations above zero, and correlations that can be; got others")
    return prior.known_together(known, alike)
