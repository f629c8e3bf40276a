"""Say what one more unit of a production is delivered with, and keep what is known of it for the next ones."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.analysis.built.load_plan import LoadPlan
from sits_mech.analysis.built.prior import Prior, inverted
from sits_mech.analysis.built.unknowns import PARAMETERS, Known
from sits_mech.memory import input_text
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError
from sits_mech.units import quantity

_SAMPLES = 4000  # of units, for a yield to one percent
MOST = 0.9
"""Share of units, and of each one's loads, that an error is said of."""


def delivered(prior: Prior, plan: LoadPlan, limit: float, *, seed: int = 0) -> list[tuple[str, Array, float]]:
    """Return what one more unit is delivered with: after no reading of its own, a tare, and the loads of a plan.

    Each time, in words what was read; within what of its range 90 % of a force's readings lie on 90 % of units, (d,);
    and the share of units all of whose forces are within `limit` there.
    """
    read, ranges, random = plan.read, np.ptp(plan.read, axis=0), np.random.default_rng(seed)
    answers, by = prior.force_slopes(prior.start, read)
    own = np.hypot(prior.noise, prior.model)
    steps = [("as computed", inverted(prior.covariance)), ("tared", plan.told[0])]
    steps += [(f"and {n} load{'s' if n > 1 else ''}", each) for n, each in enumerate(plan.told[1:], 1)]
    off, alone = random.standard_normal((_SAMPLES, len(prior.start))), random.standard_normal((_SAMPLES, *by.shape[:2]))
    found = []
    for words, information in steps:
        size = np.sqrt(np.diagonal(inverted(information)))
        root = np.linalg.cholesky(inverted(information) / np.outer(size, size)) * size[:, None]
        errors = np.einsum("mdn,mnp,pq,kq->kmd", answers, by, root, off, optimize=True)
        errors += np.einsum("mdn,kmn->kmd", answers, own * alone)
        each = np.quantile(np.abs(errors) / ranges, 0.9, axis=1)
        found.append((words, np.quantile(each, 0.9, axis=0), float(np.mean(np.all(each <= limit, axis=1)))))
    return found


def spread_of(prior: Prior, texts: Sequence[str]) -> dict[str, float]:
    """Read deviations between units: ``modulus=2 %``, ``gap=20 um`` [SI, of the modulus relative].

    Raises SceneError for anything else.
    """
    found = {}
    for text in texts:
        name, _, size = (part.strip() for part in text.partition("="))
        if name not in prior.setup.names or not size:
            raise SceneError(f"within: must be name=deviation of {', '.join(prior.setup.names)}; got {text}")
        found[name] = quantity(size, PARAMETERS.get(name, ""), f"within: {name}")
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
        known = [Known(name, float(one["value"]), float(one["deviation"])) for name, one in record["unknowns"].items()]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise SceneError(f"{path}: must be a lot.json of sits-mech lot; got: {error}") from None
    own = [each.name for each in prior.known]
    if names != own or alike.shape != (len(own), len(own)):
        raise SceneError(f"{path}: must be of the same unknowns, {', '.join(own)}; got {', '.join(names)}")
    return prior.known_together(known, alike)
