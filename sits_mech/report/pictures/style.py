"""Hold the style of every picture, and write figures to files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.quantities import Array, SolveFailed
from sits_mech.scene.files import write_bytes
from sits_mech.scene.sensor import SceneError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

COLUMN = 88.0 / 25.4  # width of a paper's column [in]
STYLE = Path(__file__).with_name("paper.mplstyle")
"""The style file of every picture, for matplotlib's `style.use` as well."""
TRACKS = ("#d55e00", "#0072b2")
"""Colours of tracks whose positive current runs to the left of a section's direction, and of those that return it."""
MARKS = "os^Dv<>PX"
"""Of the curves of a family, in order."""
_LETTER = np.array([0.05, 0.08])  # of an axis, of a label's letter
_SIDES = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]])  # of a mark, where its label may stand, in order
_DASHES = ("-", "--", "-.", ":")
_DATES = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}  # left out of files
_MISSING = "need matplotlib: pip install '.[view]' in a clone"


def check_drawing() -> None:
    """Raise SceneError where matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        raise SceneError(f"pictures {_MISSING}")


@contextmanager
def paper_style() -> Iterator[None]:
    """Set matplotlib to the style file; raise SceneError when matplotlib is not installed."""
    check_drawing()
    from matplotlib import rc_context

    with rc_context(_parameters()):
        yield


@cache
def _parameters() -> Any:
    """Return the settings of the style file."""
    from matplotlib import rc_params_from_file

    return rc_params_from_file(STYLE, use_default_template=False)


@contextmanager
def new_figure(
    height: float = 0.75, columns: int = 1, rows: int = 1, *, width: float = COLUMN,
    shares: Sequence[float] | None = None,
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Yield a figure in the paper's style and its axes row by row; raise SceneError without matplotlib.

    `height` is relative to `width` [in]; `shares` are the rows' relative heights.
    """
    with paper_style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(width, width * height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure, list(figure.subplots(rows, columns, squeeze=False, height_ratios=shares).ravel())


def add_polygons(axes: Axes, corners: Array, **style: Any) -> PolyCollection:
    """Draw polygons of one number of corners, shape (m, k, 2), and return what was drawn."""
    from matplotlib.collections import PolyCollection

    found = PolyCollection(list(corners), **style)
    axes.add_collection(found)
    return found


def label_bar(bar: Any, text: str) -> None:
    """Label the scale of colours of a picture."""
    bar.set_label(text, fontsize=7)
    bar.ax.tick_params(labelsize=6)


def strokes(count: int) -> list[dict[str, Any]]:
    """Return colour, marker and dashes of each curve of an ordered family, apart in grey and to the colour-blind."""
    from matplotlib import colormaps

    shades = colormaps["viridis"](np.linspace(0.0, 0.9, count))
    return [
        {"color": shade, "marker": MARKS[k % len(MARKS)], "linestyle": _DASHES[k % len(_DASHES)]}
        for k, shade in enumerate(shades)
    ]


def numbered_labels(places: Array, marks: Array) -> list[tuple[list[int], Array]]:
    """Return the numbers, from 1, in each label of some marks, and its side (2,) of the first one's.

    `places` and `marks` (n, 2) are of those with numbers and of all, in shares of the axes. A label stands where it
    hides the fewest marks; those at one place share one, and so do those that have no room for their own.
    """
    found, taken = list[tuple[list[int], Array]](), list[Array]()
    for own in _at_one_place(places):
        near, far = 0.5 * _LETTER, _LETTER * (3 * len(own) - 1.5, 1.5)
        boxes = [np.sort(places[own[0]] + np.stack([near, far]) * side, axis=0) for side in _SIDES]
        free = [k for k, box in enumerate(boxes) if box.min() > 0.0 and box.max() < 1.0
                and not any(np.all((box[0] < other[1]) & (box[1] > other[0])) for other in taken)]
        if not free and found:
            next_to = min(found, key=lambda each: float(np.abs(places[each[0][0] - 1] - places[own[0]]).max()))
            next_to[0].extend(k + 1 for k in own)
            continue
        hidden = [int(np.all((marks > box[0]) & (marks < box[1]), axis=1).sum()) for box in boxes]
        best = min(free or [0], key=lambda k: hidden[k])
        found.append(([k + 1 for k in own], _SIDES[best]))
        taken.append(boxes[best])
    return found


def _at_one_place(places: Array) -> list[list[int]]:
    """Return the indices of marks (n, 2) that are nearer than a letter to the first of them, in its order."""
    groups = list[list[int]]()
    for k, place in enumerate(places):
        same = next((own for own in groups if np.all(np.abs(places[own[0]] - place) < _LETTER)), [])
        if not same:
            groups.append(same)
        same.append(k)
    return groups


def save_figures(folder: Path, pictures: Mapping[str, Callable[[], Figure]], form: str = "png") -> list[str]:
    """Draw pictures and write them to a folder by name; return one line for each that cannot be drawn.

    Without matplotlib there is one line in place of all.
    """
    if find_spec("matplotlib") is None:
        return [f"no pictures: they {_MISSING}"]
    missed = []
    for name, draw in pictures.items():
        try:
            save_figure(draw(), folder / f"{name}.{form}")
        except (SolveFailed, SceneError) as error:
            missed.append(f"no picture {name}.{form}: {error}")
    return missed


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure by an atomic rename, 300 dots per inch; raise SceneError when it cannot be written."""
    write_bytes(path, figure_bytes(figure, path.suffix[1:]))


def figure_bytes(figure: Figure, form: str) -> bytes:
    """Return a figure as a file of a format, png, pdf or svg, 300 dots per inch."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    stream = BytesIO()
    with paper_style():
        if form != "png":
            figure.savefig(stream, format=form, dpi=300, metadata=_DATES[form])
            return stream.getvalue()
        figure.set_dpi(300)
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(stream)  # `savefig` would draw twice
    return stream.getvalue()
