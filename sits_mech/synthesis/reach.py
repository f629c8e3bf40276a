"""Tell from solved designs which limits no other design can hold, whatever its silicone.

By linear theory a silicone G times as stiff shows a load G times less and is strained G times less, so that of all
designs that differ by their silicones alone

    resolution times strain stays: it is the resolution r at the end of the data,
    an error over the range, of first or second order in the load, is r = min(1, G_solved/G) times the solved one's.

Both are sums of products of powers of the sizes. The logarithm of such a sum is convex over the logarithms z of the
sizes, so that its tangent at a solved design is below it everywhere,

    ln r >= ln r(z) + sum_k min over the bounds (z'_k - z_k) d ln r/dz_k + ln `_AT_LEAST`;

of a number whose bounds are not both positive, z is the number itself. What finite strains change is in `_AT_LEAST`.

Source: S. Boyd, S.-J. Kim, L. Vandenberghe, A. Hassibi, Optim. Eng. 8 (2007) 67, convexity of posynomials.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.quantities import Array
from sits_mech.synthesis.answered import Task
from sits_mech.synthesis.kinds import STRAIN, figure_words
from sits_mech.synthesis.prediction import Prediction

_AT_LEAST = {"resolution": 0.59, "error": 0.2}
_WORDS = {"resolution": " at the end of a silicone's data", "error": ""}


def out_of_reach(task: Task, known: Sequence[tuple[Prediction, float]], growth: Array) -> str:
    """Return in words which limit no design of a choice can hold, or "".

    `known` are predictions of choices that differ by their silicones alone, with the stiffness of each over that of the
    choice; `growth` is what each number grows by from its lower bound to its upper one, over the lower one (v,).
    """
    limited = [name for name in task.limits if name.partition(".")[0] in _AT_LEAST]
    rows = [least_at(task, own, one.point, limited, growth, G) for own, G in known for one in own.solved if limited]
    for name in limited if rows else ():
        kind = name.partition(".")[0]
        value = min(found.get(name, np.inf) for found in rows) * (_AT_LEAST[kind] if len(growth) else 1.0)
        if task.limits[name] < value < np.inf:
            least, limit = figure_words(name, value), figure_words(name, task.limits[name])
            return f"{name} some {least} at least{_WORDS[kind]}, against {limit}"
    return ""


def least_at(
    task: Task, prediction: Prediction, x: Array, names: Sequence[str], growth: Array, G: float = 1.0,
    ends: Array | None = None,
) -> dict[str, float]:
    """Return the least of each r by tangents at a point x, between its bounds or at one of `ends` (m, v)."""

    def figures(x: Array) -> dict[str, float]:
        """Return resolutions times the strain within the data, and errors."""
        own = task.figures(prediction.table(x), prediction.plain(x))
        strain = min(max(own.get(STRAIN, 1.0), 0.0), 1.0)
        share = {name: min(G, 1.0) if name.startswith("error") else strain for name in names if name in own}
        return {name: max(own[name] * share[name], 1e-300) for name in share}

    step = float(np.cbrt(np.finfo(float).eps))
    here, beside = figures(x), [figures(x + row) for row in step * np.eye(len(x))]
    ways = _ways(np.array([np.zeros(len(x)), np.ones(len(x))]) if ends is None else ends, x, growth)
    found = {}
    for name, value in here.items():
        slopes = np.array([np.log(there[name] / value) / step for there in beside])
        falls = slopes * ways
        found[name] = value * float(np.exp(falls.min(axis=0).sum() if ends is None else falls.sum(axis=1).min()))
    return found


def _ways(ends: Array, x: Array, growth: Array) -> Array:
    """Return (z' - z)/(dz/dx) from a point of the unit box to others, shape (m, v); z = ln(1 + growth x)."""
    safe = np.where(growth > 0.0, growth, 1.0)
    ways = np.log((1.0 + safe * ends) / (1.0 + safe * x)) * (1.0 / safe + x)
    return np.where(growth > 0.0, ways, ends - x)
