"""Plot calibration curves: the signals against the forces, and the crosstalk over the load range.

Sizes, colours and fonts are those of paper.mplstyle: one column of a two-column paper (88 mm). Curves of a family
differ in colour, marker and dashes, so that a grey print tells them apart. matplotlib is drawn off screen.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sits_mech.quantities import TOUCH, Array, shown_unit
from sits_mech.readout.crosstalk import components_of, crosstalk, short_name, signals_of
from sits_mech.readout.loads import at_middle, request_of, several
from sits_mech.report.pictures.style import label_bar, new_figure, strokes
from sits_mech.report.tables.loads import KINDS
from sits_mech.scene.sensor import SceneError
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SEEN = 0.03  # of a picture's height: a shorter half of a bar hides behind its mark


def calibration_pictures(data: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Return what draws each picture of a table, by name: curves of each signal whose force it varies, crosstalk."""
    own = signals_of(data)
    forces = [force for force in own if data.sizes.get(force, 1) > 1] or list(own)[:1]
    found: dict[str, Callable[[], Figure]] = {
        short_name(own[force]): partial(signal_curves, data, force) for force in forces
    }
    return found | {"crosstalk": partial(crosstalk_map, data)}


def signal_curves(data: xr.Dataset, force: str) -> Figure:
    """Plot a force's signal (F_z, F_x or F_y) against it, a curve per value of another component.

    The title says the largest error; errors are bars where these can be seen.

    Another component replaces a force that the table does not vary; the remaining ones are at the middle of their
    range, as the title says. Raise SceneError where the table varies no component, or without matplotlib.
    """
    signal, second = signals_of(data)[force], "F_x" if force == "F_z" else "F_z"
    names = several(data)
    along = next((name for name in (force, *names) if name in names and (name != second or names == (second,))), None)
    family = next((name for name in (second, *names) if name in names and name != along), None)
    if along is None:
        raise SceneError("curves: need a table over at least one component of the load; this one holds a single load")
    data, held = at_middle(data, list(filter(None, (along, family))))
    data = _in_mm(data)
    with new_figure(0.8) as (figure, (axes,)):
        curves = _curves(data, signal, family)
        error, height = np.nanmax([each[2] for each in curves]), np.ptp([each[1] for each in curves])
        seen = not error < _SEEN * height
        for (name, values, errors), stroke in zip(curves, strokes(len(curves)), strict=True):
            axes.errorbar(data[along], values, errors if seen else None, **stroke, elinewidth=0.6, label=name)
            if seen:  # bars as a line that is not drawn: the legend keeps clear of lines alone
                ends = np.stack([values - errors, values + errors, np.full_like(values, np.nan)], axis=-1)
                axes.plot(np.repeat(data[along], 3), ends.ravel(), linestyle="none", marker="")
        axes.set_xlabel(load_label(along))
        pair = "$L_v = L_1 + L_2$" if signal == "L_v_percent" else "$L_h = L_1 - L_2$"
        axes.set_ylabel(signal_label(signal).replace(pair[:4] + "$", pair))
        kind = {"v": "normal signal", "y": "shear signal along y"}.get(short_name(signal)[-1], "shear signal")
        words = "; ".join(filter(None, (kind + by_models(data), _mathematics(held))))
        off = f"{'bars: ' * seen}errors up to {error:.2g} % of $L_0$"
        figure.suptitle(f"{fill(data.attrs.get('name', ''), 54)}\n{words}\n{off}".strip())
        if family is not None:
            axes.legend(title=_short_label(family), ncols=1 + (len(curves) > 5))
    return figure


def by_models(data: xr.Dataset) -> str:
    """Return by which models a table was solved, in words; "" where it does not say."""
    asked = request_of(data) if "request" in data.attrs else {}
    return " (models: {mechanics}, {magnetics})".format(**asked) if "mechanics" in asked else ""


def _mathematics(words: str) -> str:
    """Return words in which each component of a load is a symbol."""
    return re.sub(r"\b([FM](_[xyz])?) =", r"$\1$ =", words)


def _curves(data: xr.Dataset, signal: str, family: str | None) -> list[tuple[str, Array, Array]]:
    """Return label, values and errors of each curve; two that are one by mirror symmetry go as one, with both signs."""
    if family is None:
        return [("", data[signal].to_numpy(), data[f"error_{signal}"].to_numpy())]
    found: list[tuple[str, Array, Array]] = []
    others = data[family].to_numpy()
    table = {other: data.sel({family: other}) for other in others}
    for other in others:
        values, errors = table[other][signal].to_numpy(), table[other][f"error_{signal}"].to_numpy()
        twin = table[-other][signal].to_numpy() if other != 0.0 and -other in table else None
        same = twin is not None and np.allclose(values, twin, rtol=1e-9, atol=0.0, equal_nan=True)
        if not (same and other < 0.0):
            found.append((f"\u00b1{other:.3g}" if same else f"{other:.3g}", values, errors))
    return found


def load_label(name: str) -> str:
    """Return what a component of a load is, as an axis label."""
    return f"{KINDS[name].partition(' a')[0]} {_short_label(name)}"


def _short_label(name: str) -> str:
    """Return symbol and unit of a component, of a touch's place in mm."""
    return f"{_short_symbol(name)} [{'mm' if name in TOUCH else shown_unit(name)}]"


def _short_symbol(name: str) -> str:
    """Return a component of a load, or a coordinate of a touch's place, as mathematics."""
    return f"${name[-1] if name in TOUCH else name}$"


def _in_mm(data: xr.Dataset) -> xr.Dataset:
    """Return a table over places of a touch in mm."""
    return data.assign_coords({name: MM * data[name] for name in TOUCH if name in data.dims})


def signal_label(signal: str) -> str:
    """Return what a signal is, as an axis label."""
    return rf"${_symbol(short_name(signal))}$ [% of $L_0$]"


def _symbol(signal: str) -> str:
    """Return a signal's name as mathematics."""
    return signal.replace("dL", r"\Delta L")


def crosstalk_map(data: xr.Dataset) -> Figure:
    """Plot the crosstalk of each component into the others' signals [% of the signal's own full scale].

    Two components give maps over both, more a matrix of the largest shares with errors. Raise SceneError where the
    table varies fewer, or none with a signal of its own, or without matplotlib.
    """
    data, held = at_middle(data, several(data))
    data = _in_mm(data)
    components, stray = components_of(data), crosstalk(data)
    if len(components) < 2 or not stray:
        raise SceneError("crosstalk: needs a table over two components of the load, one of them with a signal")
    return _crosstalk_maps(data, stray, held) if len(components) == 2 else _crosstalk_matrix(data, stray)


def _crosstalk_maps(data: xr.Dataset, stray: xr.Dataset, held: str) -> Figure:
    """Return the crosstalk over the two components of a table, F_x across where it is one."""
    from matplotlib.patheffects import withStroke

    across, up = sorted(components_of(data), key=lambda name: name != "F_x")
    names = sorted(map(str, stray))
    with new_figure(height=0.7, columns=len(names)) as (figure, every):
        for axes, name in zip(every, names, strict=True):
            values, (signal, _, force) = stray[name].transpose(up, across), name.partition("_from_")
            reach = float(np.max(np.nan_to_num(np.abs(values)))) or 1.0
            places = data[across].to_numpy(), data[up].to_numpy()
            picture = axes.pcolormesh(*places, values, cmap="RdBu_r", vmin=-reach, vmax=reach, rasterized=True)
            lines = axes.contour(*places, values, _round_levels(values.to_numpy()), colors="0.25", linewidths=0.5)
            for label in axes.clabel(lines, fontsize=5, fmt=lambda level: f"{level:g}".replace("-", "\u2212")):
                label.set_rotation(0.0)  # a 6 on its head reads 9, and a minus along a line is lost
                label.set_path_effects([withStroke(linewidth=1.2, foreground="white")])
            axes.grid(False)
            axes.set_title(f"{_short_symbol(force)} into ${_symbol(signal)}$")
            axes.set_xlabel(_short_label(across))
            bar = figure.colorbar(picture, ax=axes, location="bottom", shrink=0.95)
            label_bar(bar, rf"of ${_symbol(signal)}$'s full scale [%]")
        every[0].set_ylabel(_short_label(up))
        words = filter(None, (f"crosstalk{by_models(data)}", _mathematics(held)))
        figure.suptitle(fill(f"{', '.join(words)}; lines: equal values", 58))
    return figure


def _round_levels(values: Array) -> Array:
    """Return a few round values within some."""
    from matplotlib.ticker import MaxNLocator

    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    levels = np.asarray(MaxNLocator(3).tick_values(low, high))
    return levels[(levels > low) & (levels < high) & (abs(levels) > 1e-6 * (high - low))]


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
            name = f"largest_{signal}_from_{other}"
            share, error = stray.attrs[name], stray.attrs[f"error_{name}"]
            if share > error:
                shares[i, j], texts[i, j] = share, f"{share:.2g} %\n$\\pm$ {error:.2g} %"
            else:
                texts[i, j] = "below\nits error" if np.isinf(error) else f"below its\nerror of {error:.2g} %"
    with new_figure(height=0.2 + 0.22 * len(own)) as (figure, (axes,)):
        axes.imshow(shares, cmap="Greys", vmin=0.0, vmax=100.0, aspect="auto")
        for (i, j), text in texts.items():
            axes.annotate(text, (j, i), ha="center", va="center", fontsize=6)
        axes.set_xticks(range(len(forces)), [_short_symbol(name) for name in forces])
        axes.set_yticks(range(len(own)), [f"${_symbol(name)}$" for name in own.values()])
        axes.set_xlabel("applied over its whole range")
        axes.set_ylabel("signal")
        axes.set_title(f"largest crosstalk{by_models(data)},\nin percent of the signal's full scale")
        axes.grid(False)
    return figure
