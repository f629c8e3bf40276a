"""Tell from a few solved designs which resolution no other one can reach, whatever its silicone.

A softer silicone shows a load more, and is strained as much more: by linear theory resolution times strain stays, so
that it is the resolution r at the end of the data, of all designs that differ by their silicones alone. It is a sum of
products of powers of the sizes, whose logarithm is convex over the logarithms z of the sizes, so that its tangent at a
solved design is below it everywhere,

    ln r >= ln r(z) + sum_k min over the bounds (z'_k - z_k) d ln r/dz_k + ln `_AT_LEAST`;

of a number that may be zero z is the number itself; of several solved designs the highest bound counts. `_AT_LEAST` is
for finite strains. Where a force is hardly read, r has a pole and is no such sum: designs that do not read all loads
evenly tell nothing. 85 pairs of designs of five files came to 0.706 of the tangent at least (a square coil; 0.715 of
the four others); three from a design with an inverse of 0.6, its target over both coils, to 1e-5. Errors have no such
bound: to 0.08 of skins' tangents.

Source: S. Boyd, S.-J. Kim, L. Vandenberghe, A. Hassibi, Optim. Eng. 8 (2007) 67, convexity of posynomials.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.required.kinds import INVERSE, STRAIN, figure_words
from sits_mech.synthesis.solved.answered import Answered, Task

_AT_LEAST = 0.68  # of r by such tangents, what came: studies/benchmarks/design.py, `above_tangents`
_EVENLY = 0.7  # of the figure `INVERSE`


def out_of_reach(task: Task, known: Sequence[Prediction], growth: Array) -> str:
    """Return in words which resolution no design brings within its limit, or "".

    `growth` is by how much each number grows between its bounds, over the lower one (v,); 0 where that is not positive.
    """
    limited = [name for name in task.limits if name.startswith("resolution.")]
    ends = np.array([np.zeros(len(growth)), np.ones(len(growth))])
    even = [(own, one.point) for own in known for one in own.solved if limited and reads_evenly(task, one)]
    each = [tangents(task, own, x, limited, ends, growth) for own, x in even]
    for name in limited:
        own = [found[name] for found in each if name in found]
        value = max((r * float(np.exp(falls.min(axis=0).sum())) for r, falls in own), default=0.0)
        value *= _AT_LEAST if len(growth) else 1.0
        if task.limits[name] < value < np.inf:
            words, limit = figure_words(name, value), figure_words(name, task.limits[name])
            return f"{name} some {words} at the end of a silicone's data, against {limit}"
    return ""


def reads_evenly(task: Task, found: Answered) -> bool:
    """Return whether a solved design reads all loads so evenly that its tangents tell of others."""
    return task.figures(found).get(INVERSE, 1.0) >= _EVENLY


def tangents(
    task: Task, prediction: Prediction, x: Array, names: Sequence[str], ends: Array, growth: Array
) -> dict[str, tuple[float, Array]]:
    """Return each r at a point x, and the changes of its logarithm along its tangents to `ends`, shape (m, v) both."""

    def at_end(x: Array) -> dict[str, float]:
        """Return resolutions, times the strain within the data."""
        own = task.figures(prediction.at(x))
        strain = min(max(own.get(STRAIN, 1.0), 0.0), 1.0)
        return {name: max(own[name] * strain, 1e-300) for name in names if name in own}

    step = float(np.cbrt(np.finfo(float).eps))
    here, moved = at_end(x), [at_end(x + row) for row in step * np.eye(len(x))]
    q = np.where(growth > 0.0, growth, 1.0)
    ways = np.log((1.0 + q * ends) / (1.0 + q * x)) * (1.0 / q + x)  # (z' - z) dx/dz of z = ln(1 + q x)
    ways = np.where(growth > 0.0, ways, ends - x)
    slopes = {name: np.array([np.log(there[name] / r) / step for there in moved]) for name, r in here.items()}
    return {name: (r, ways * slopes[name]) for name, r in here.items()}
