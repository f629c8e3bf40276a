"""What do the calibration curves look like? The signals against the forces, and the crosstalk over the load range.

Sizes are those of one column of a two-column paper (88 mm). matplotlib is imported here alone, and drawn off screen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from sits_mech.quantities import Array, shown_unit
from sits_mech.readout.crosstalk import crosstalk
from sits_mech.readout.loads import at_middle, varied
from sits_mech.readout.signals import told
from sits_mech.scene.files import replaced
from sits_mech.scene.sensor import SceneError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

_KINDS = {"F_x": "shear force", "F_y": "shear force", "F_z": "normal force"}
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


def normal_curves(data: xr.Dataset) -> Figure:
    """Return L_v, or dL_v, against F_z, one curve per F_x; bars are estimated errors.

    Where the table does not vary one of them, another component of the load stands for it; those that are left are at
    the middle of their range, as the title says.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.

    Raises
    ------
    SceneError
        When the table varies no component of the load, or matplotlib is missing.
    """
    return _family(data, told(data)[0], "F_z", "F_x")


def shear_curves(data: xr.Dataset) -> Figure:
    """Return L_h, or dL_x, against F_x, one curve per F_z; as `normal_curves`."""
    return _family(data, told(data)[1], "F_x", "F_z")


def _family(data: xr.Dataset, signal: str, first: str, second: str) -> Figure:
    """Return one signal against a component of the load, a curve for each value of another one."""
    names = varied(data)
    along = next((name for name in (first, *names) if name in names and (name != second or names == (second,))), None)
    family = next((name for name in (second, *names) if name in names and name != along), None)
    if along is None:
        raise SceneError("curves: need a table over at least one component of the load; this one holds a single load")
    data, held = at_middle(data, [along, *([] if family is None else [family])])
    with new_figure() as (figure, (axes,)):
        curves = _curves(data, signal, along, family)
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


def _curves(data: xr.Dataset, signal: str, along: str, family: str | None) -> list[tuple[str, Array, Array]]:
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
    text = pair.get(signal, signal.removesuffix("_percent").replace("dL", r"\Delta L"))
    return rf"${text}\,/\,L_0$ [%]"


def _shades(count: int) -> Any:
    """Return one colour for each curve of a family."""
    from matplotlib import colormaps

    return colormaps["viridis"](np.linspace(0.0, 0.9, count))


def crosstalk_map(data: xr.Dataset) -> Figure:
    """Return the crosstalk both ways over F_x and F_z [% of the signal's own full scale].

    Parameters
    ----------
    data : Dataset
        As from `calibrate`; other components are at the middle of their range, as the title says.

    Raises
    ------
    SceneError
        When the table does not vary both forces, or matplotlib is missing.
    """
    if not {"F_x", "F_z"} <= set(varied(data)) or "L_h_percent" not in data:
        raise SceneError("crosstalk: needs a table over F_x and F_z, of two coils")
    data, held = at_middle(data, ["F_x", "F_z"])
    stray = crosstalk(data)
    maps = (("L_h_from_F_z", "$F_z$ into $L_h$"), ("L_v_from_F_x", "$F_x$ into $L_v$"))
    with new_figure(height=0.7, columns=2) as (figure, both):
        for axes, (name, title) in zip(both, maps, strict=True):
            values = stray[name].transpose("F_z", "F_x")
            reach = float(np.max(np.nan_to_num(np.abs(values)))) or 1.0
            picture = axes.pcolormesh(data["F_x"], data["F_z"], values, cmap="RdBu_r", vmin=-reach, vmax=reach)
            axes.grid(False)
            axes.set_title(title, fontsize=8)
            axes.set_xlabel("$F_x$ [N]")
            bar = figure.colorbar(picture, ax=axes, location="bottom", shrink=0.95)
            bar.set_label("% of full scale", fontsize=7)
            bar.ax.tick_params(labelsize=6)
        both[0].set_ylabel("$F_z$ [N]")
        if held:
            figure.suptitle(held, fontsize=8)
    return figure


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
