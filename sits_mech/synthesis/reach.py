"""Tell from a few solved designs which resolution no other one can reach, whatever its silicone.

A softer silicone shows a load more, and is strained as much more: by linear theory resolution times strain stays, so
that it is the resolution r at the end of the data, of all designs that differ by their silicones alone. It goes with
powers of the sizes, so that tangents of its logarithm at a solved point x of the unit box tell the least of the box,

    ln r >= ln r(x) + sum_k min over 0 <= y_k <= 1 of (y_k - x_k) d ln r/dx_k + ln `_AT_LEAST`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.answered import Task
from sits_mech.synthesis.kinds import STRAIN, figure_words
from sits_mech.synthesis.prediction import Prediction

_AT_LEAST = 0.59  # of r by such tangents, what came: the least of 78 pairs of designs of four requirement files


def out_of_reach(task: Task, known: Sequence[Prediction], count: int) -> str:
    """Return in words which resolution no design brings within its limit, of `count` variables, or ""."""
    limited = [name for name in task.limits if name.startswith("resolution.")]
    each = [_least(task, own, one.point, limited) for own in known for one in own.solved if limited]
    for name in limited if each else ():
        value = min(found.get(name, np.inf) for found in each) * (_AT_LEAST if count else 1.0)
        if task.limits[name] < value < np.inf:
            least, limit = figure_words(name, value), figure_words(name, task.limits[name])
            return f"{name} some {least} at the end of a silicone's data, against {limit}"
    return ""


def _least(task: Task, prediction: Prediction, x: Array, names: Sequence[str]) -> dict[str, float]:
    """Return the least resolutions at the end of the data by tangents at a point."""

    def at_end(x: Array) -> dict[str, float]:
        """Return resolutions, times the strain within the data."""
        own = task.figures(prediction.table(x), prediction.plain(x))
        strain = min(max(own.get(STRAIN, 1.0), 0.0), 1.0)
        return {name: max(own[name] * strain, 1e-300) for name in names if name in own}

    step = float(np.cbrt(np.finfo(float).eps))
    here, beside = at_end(x), [at_end(x + row) for row in step * np.eye(len(x))]
    slopes = {name: np.array([np.log(there[name] / here[name]) / step for there in beside]) for name in here}
    most = {name: np.minimum(-slope * x, slope * (1.0 - x)).sum() for name, slope in slopes.items()}
    return {name: here[name] * float(np.exp(fall)) for name, fall in most.items()}
