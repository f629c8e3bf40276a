"""What do the calibration curves look like? The signals against the forces, and the crosstalk over the load range.

Sizes are those of one column of a two-column paper (88 mm). matplotlib is imported here alone, and drawn off screen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from sits_mech.quantities import Array, shown_unit
from sits_mech.readout.crosstalk import components_of, crosstalk, short_name, signals_of
from sits_mech.readout.loads import at_middle, several
from sits_mech.scene.files import replaced
from sits_mech.scene.sensor import SceneError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

_KINDS = {"F_x": "shear force", "F_y": "shear force", "F_z": "normal force"}
_FORMATS = (".png", ".pdf", ".svg")
COLUMN = 88.0 / 25.4  # width of a paper's column [in]
_STYLE: Any = {
    "font.size": 8, "axes.labelsize": 8, "legend.fontsize": 6.5, "legend.title_fontsize": 6.5, "axes.linewidth": 0.6,
    "lines.linewidth": 1.0, "lines.markersize": 2.5, "xtick.labelsize": 7, "ytick.labelsize": 7, "axes.grid": True,
    "grid.linewidth": 0.3, "grid.alpha": 0.5,
}  # fmt: skip


@contextmanager
def new_figure(
    height: float = 0.75,
    columns: int = 1,
    rows: int = 1,
    *,
    width: float = COLUMN,
    shares: Sequence[float] | None = None,
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Give an empty figure and its axes row by row; what is drawn inside has the paper's style.

    Parameters
    ----------
    height : float
        Of the figure, over its width.
    columns, rows : int
        Number of axes across and down.
    width : float
        Of the figure [in]; one paper column by default.
    shares : sequence of float, optional
        Heights of the rows to one another; equal by default.

    Raises
    ------
    SceneError
        When matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise SceneError("pictures need matplotlib: pip install 'sits-mech[view]'") from None
    with rc_context(_STYLE):
        figure = Figure(figsize=(width, width * height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure, list(figure.subplots(rows, columns, squeeze=False, height_ratios=shares).ravel())


def add_polygons(axes: Axes, corners: Array, **style: Any) -> PolyCollection:
    """Draw polygons of one number of corners, shape (m, k, 2), and return what was drawn."""
    from matplotlib.collections import PolyCollection

    found = PolyCollection(list(corners), **style)
    axes.add_collection(found)
    return found


def calibration_pictures(data: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Return what draws each picture of a table, by name: curves of each signal whose force it varies, crosstalk."""
    own = signals_of(data)
    forces = [force for force in own if data.sizes.get(force, 1) > 1] or list(own)[:1]
    found: dict[str, Callable[[], Figure]] = {
        short_name(own[force]): partial(signal_curves, data, force) for force in forces
    }
    return found | {"crosstalk": partial(crosstalk_map, data)}


def signal_curves(data: xr.Dataset, force: str) -> Figure:
    """Return the signal that answers a force against it, a curve for each value of another one; bars are errors.

    Where the table does not vary the force, another component of the load stands for it; those that are left are at
    the middle of their range, as the title says.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.
    force : str
        One with a signal of its own: F_z, F_x or F_y.

    Raises
    ------
    SceneError
        When the table varies no component of the load, or matplotlib is missing.
    """
    signal, second = signals_of(data)[force], "F_x" if force == "F_z" else "F_z"
    names = several(data)
    along = next((name for name in (force, *names) if name in names and (name != second or names == (second,))), None)
    family = next((name for name in (second, *names) if name in names and name != along), None)
    if along is None:
        raise SceneError("curves: need a table over at least one component of the load; this one holds a single load")
    data, held = at_middle(data, [along, *([] if family is None else [family])])
    with new_figure() as (figure, (axes,)):
        curves = _curves(data, signal, family)
        for (name, values, errors), shade in zip(curves, _shades(len(curves)), strict=True):
            axes.errorbar(
                data[along], values, errors, color=shade, marker="o", markersize=2.2, linewidth=0.9, elinewidth=0.6,
                capsize=1.2, label=name,
            )  # fmt: skip
        axes.set_xlabel(f"{_KINDS.get(along, 'moment')} ${along}$ [{shown_unit(along)}]")
        axes.set_ylabel(_label(signal, data.sizes["coil"]))
        axes.set_title(held, fontsize=8)
        if family is not None:
            title = f"${family}$ [{shown_unit(family)}]"
            axes.legend(title=title, ncols=1 + (len(curves) > 5), handlelength=1.2, columnspacing=0.8)
    return figure


def _curves(data: xr.Dataset, signal: str, family: str | None) -> list[tuple[str, Array, Array]]:
    """Return label, values and errors of each curve; two that are one by mirror symmetry go as one, with both signs."""
    if family is None:
        values, errors = (data[f"{kind}{signal}"].to_numpy() for kind in ("", "error_"))
        return [("", values, errors)]
    found: list[tuple[str, Array, Array]] = []
    others = data[family].to_numpy()
    table = {other: data.sel({family: other}) for other in others}
    for other in others:
        values, errors = (table[other][f"{kind}{signal}"].to_numpy() for kind in ("", "error_"))
        twin = table[-other][signal].to_numpy() if other != 0.0 and -other in table else None
        same = twin is not None and np.allclose(values, twin, rtol=1e-9, atol=0.0, equal_nan=True)
        if not (same and other < 0.0):
            found.append((f"\u00b1{other:.3g}" if same else f"{other:.3g}", values, errors))
    return found


def _label(signal: str, coils: int) -> str:
    """Return what a signal is, as an axis label."""
    pair = {"L_v_percent": "(L_1 + L_2)", "L_h_percent": "(L_1 - L_2)"} if coils == 2 else {}
    return rf"${pair.get(signal, _symbol(short_name(signal)))}\,/\,L_0$ [%]"


def _symbol(signal: str) -> str:
    """Return a signal's name as mathematics."""
    return signal.replace("dL", r"\Delta L")


def _shades(count: int) -> Any:
    """Return one colour for each curve of a family."""
    from matplotlib import colormaps

    return colormaps["viridis"](np.linspace(0.0, 0.9, count))


def crosstalk_map(data: xr.Dataset) -> Figure:
    """Return the crosstalk of each component into the signals of the others [% of the signal's own full scale].

    Of two components maps over both, of more a matrix of the largest shares with their errors.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.

    Raises
    ------
    SceneError
        When the table does not vary two components, or none that has a signal of its own, or matplotlib is missing.
    """
    data, held = at_middle(data, several(data))
    components, stray = components_of(data), crosstalk(data)
    if len(components) < 2 or not stray:
        raise SceneError("crosstalk: needs a table over two components of the load, one of them with a signal")
    return _crosstalk_maps(data, stray, held) if len(components) == 2 else _crosstalk_matrix(data, stray)


def _crosstalk_maps(data: xr.Dataset, stray: xr.Dataset, held: str) -> Figure:
    """Return the crosstalk over the two components of a table, F_x across where it is one."""
    across, up = sorted(components_of(data), key=lambda name: name != "F_x")
    names = sorted(map(str, stray))
    with new_figure(height=0.7, columns=len(names)) as (figure, every):
        for axes, name in zip(every, names, strict=True):
            values, (signal, _, force) = stray[name].transpose(up, across), name.partition("_from_")
            reach = float(np.max(np.nan_to_num(np.abs(values)))) or 1.0
            picture = axes.pcolormesh(data[across], data[up], values, cmap="RdBu_r", vmin=-reach, vmax=reach)
            axes.grid(False)
            axes.set_title(f"${force}$ into ${_symbol(signal)}$", fontsize=8)
            axes.set_xlabel(f"${across}$ [{shown_unit(across)}]")
            bar = figure.colorbar(picture, ax=axes, location="bottom", shrink=0.95)
            bar.set_label("% of full scale", fontsize=7)
            bar.ax.tick_params(labelsize=6)
        every[0].set_ylabel(f"${up}$ [{shown_unit(up)}]")
        if held:
            figure.suptitle(held, fontsize=8)
    return figure


def _crosstalk_matrix(data: xr.Dataset, stray: xr.Dataset) -> Figure:
    """Return the largest crosstalk of each component into each signal, and the signals' full scales."""
    own = {force: short_name(name) for force, name in signals_of(data).items() if force in data.dims}
    forces = list(components_of(data))
    shares, texts = np.full((len(own), len(forces)), np.nan), {}
    for i, (force, signal) in enumerate(own.items()):
        for j, other in enumerate(forces):
            if other == force:
                texts[i, j] = f"full scale\n{stray.attrs[f'full_scale_{signal}']:.3g} % of $L_0$"
                continue
            share, error = (stray.attrs[f"{kind}largest_{signal}_from_{other}"] for kind in ("", "error_"))
            if share > error:
                shares[i, j], texts[i, j] = share, f"{share:.2g} %\n$\\pm$ {error:.2g} %"
            else:
                texts[i, j] = "below\nits error" if np.isinf(error) else f"below its\nerror, {error:.2g} %"
    with new_figure(height=0.2 + 0.22 * len(own)) as (figure, (axes,)):
        axes.imshow(shares, cmap="OrRd", vmin=0.0, vmax=60.0, aspect="auto")
        for (i, j), text in texts.items():
            axes.annotate(text, (j, i), ha="center", va="center", fontsize=6)
        axes.set_xticks(range(len(forces)), [f"${name}$" for name in forces])
        axes.set_yticks(range(len(own)), [f"${_symbol(name)}$" for name in own.values()])
        axes.set_xlabel("applied up to its full scale")
        axes.set_title("crosstalk, of the full scale of a signal", fontsize=8)
        axes.grid(False)
    return figure


def checked_picture(path: Path) -> Path:
    """Return where a picture goes; raise SceneError where its format cannot be drawn or its folder is not there."""
    if path.suffix not in _FORMATS:
        raise SceneError(f"--output: must end in {', '.join(_FORMATS)}; got {path.name!r}")
    if not path.parent.is_dir():
        raise SceneError(f"--output: must be in a folder that exists; got {path}")
    return path


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure by an atomic rename, 300 dots per inch; raise SceneError when it cannot be written."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with replaced(path) as other:
        if path.suffix != ".png":
            figure.savefig(other, format=path.suffix[1:], dpi=300)
            return
        figure.set_dpi(300)
        canvas: Any = FigureCanvasAgg(figure)
        with other.open("wb") as stream:
            canvas.print_png(stream)  # `savefig` would draw twice
