"""Pictures of built sensors: yields and limits are read without a number over a line."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from sits_mech.report.plots.built import production_figure


def test_yields_stand_below_the_curves(collisions: Callable[[Figure], list[str]]) -> None:
    """Errors that cross the limit: no text within the axes, each yield under its own step, the limit named."""
    names = [SimpleNamespace(name=name) for name in ("modulus", "gap")]
    start = SimpleNamespace(
        setup=SimpleNamespace(parameters=names), known=names, start=np.zeros(2), deviations=np.ones(2)
    )
    found: Any = SimpleNamespace(
        start=start, next=SimpleNamespace(start=np.array([0.3, -0.2]), deviations=np.array([0.1, 0.5])),
        units={"A1": SimpleNamespace(values=np.array([0.2, 0.1]))},
    )
    rows = [
        {"after": after, "yield": share, "force_error": {"F_x": error, "F_z": 0.8 * error}}
        for after, share, error in (("as computed", 0.0, 3.0), ("tared", 0.2, 0.1), ("and 1 load", 0.99, 0.025))
    ]
    figure = production_figure(found, {"delivered": rows, "limit": 0.03})
    errors = figure.axes[1]
    assert collisions(figure) == [] and not errors.texts
    assert [tick.get_text() for tick in errors.get_xticklabels()] == [
        "as computed\nyield 0 %", "tared\nyield 20 %", "and 1 load\nyield 99 %",
    ]
    assert [text.get_text() for text in errors.get_legend().get_texts()] == ["F_x", "F_z", "limit"]
