"""Preview the answer of a search that has only begun: what its predictions promise, and how far they were off so far.

The error of a figure is the largest of what is left open by the solved designs themselves, and of what each solved
design of the choice differs from its prediction by the others of it, where there are any.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.search import Branch, Search
from sits_mech.synthesis.solved.answered import Task, over


@dataclass(frozen=True)
class Preview:
    """Predicted design and figures."""

    values: dict[str, Any]  # by key of the scene, as written
    figures: dict[str, tuple[float, float]]  # value and error [SI]; the error nan where it is not known
    limits: Mapping[str, float]  # [SI]
    solved: int

    @property
    def exceeded(self) -> tuple[str, ...]:
        """The limits that the prediction exceeds."""
        return tuple(
            name for name, limit in self.limits.items()
            if name in self.figures and over(name, self.figures[name][0], limit) > 0.0
        )


def preview_of(asked: Requirements, search: Search) -> Preview:
    """Return the best prediction of a search that was stopped after a few designs."""
    branches = [each for each in search.branches if each.prediction.solved]
    points = {each.choice: search.propose(each) if search.count else None for each in branches}

    def merit(branch: Branch) -> float:
        """Return what the choice promises, or where nothing varies has."""
        point = points[branch.choice]
        return min(map(search.merit, branch.known)) if point is None else point.merit

    best = min(branches, key=merit)
    point = points[best.choice]
    x = best.prediction.solved[0].point if point is None else point.x
    figures = search.task.figures(best.prediction.at(x))
    error = errors(search.task, best.prediction)
    rows = {name: (value, error.get(name, np.nan)) for name, value in figures.items()}
    design = Design(best.choice, tuple(x.tolist()))
    return Preview(asked.space.values(design), rows, search.task.limits, search.solved)


def errors(task: Task, prediction: Prediction) -> dict[str, float]:
    """Return the error of each predicted figure."""
    found: dict[str, float] = {}
    for k, each in enumerate(prediction.solved):
        own = task.figures(each)
        others = [*prediction.solved[:k], *prediction.solved[k + 1 :]]
        there = task.figures(Prediction(others, ()).at(each.point)) if others else {}
        off = {name: abs(value - own[name]) for name, value in there.items()}
        for name in own:
            known = [size for size in (each.error.get(name), off.get(name), found.get(name)) if size is not None]
            if known:
                found[name] = max(known)
    return found
