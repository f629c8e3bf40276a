"""Show a load history: rows with poses and signals, a record, CSV, curves over time."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from rich.table import Table

from sits_mech.notes import Omission
from sits_mech.quantities import POSE, WRENCH, report_of, shown_unit
from sits_mech.readout.loads import request_of
from sits_mech.readout.signals import changes, shown_signals
from sits_mech.report.left_out import entry
from sits_mech.report.notes import joined_words, kept_sentences, sentences
from sits_mech.report.pictures.style import new_figure, save_figures, strokes
from sits_mech.report.plots.curves import signal_label
from sits_mech.report.records import status_record
from sits_mech.report.tables.solves import column_table, shown_scale, sizes_of, with_error
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import Sensor, save_sensor
from sits_mech.status import joined
from sits_mech.store import save_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 40  # rows that are printed
_CODES = ("code", "code_time")


def moving(data: xr.Dataset) -> tuple[str, ...]:
    """Return the components of the wrench that are not zero all the time; F_z where all are."""
    return tuple(name for name in WRENCH if np.any(data[name].to_numpy() != 0.0)) or ("F_z",)


def history_table(data: xr.Dataset) -> Table:
    """Return load, pose and signals at the history's own times, with errors of what is not given."""
    rows = np.flatnonzero(data["given"].to_numpy())
    step = -(-len(rows) // _MOST)
    thinned = rows[::step]
    found, signals = [name for name in WRENCH if f"error_{name}" in data], shown_signals(data)
    loads = [name for name in moving(data) if name not in found]
    places = [name for name in POSE if name in POSE[:3] or np.any(data[name].to_numpy() != 0.0)]
    columns = [(name, 1.0, shown_unit(name)) for name in found] + [(name, *shown_scale(name)) for name in places]
    columns += [(name, 1.0, "%") for name in signals]
    units = {"t": "s"} | {name: shown_unit(name) for name in loads}
    units |= {name.removesuffix("_percent"): unit for name, _, unit in columns}
    headings = [f"{name} [{unit}]" for name, unit in units.items()]
    title = f"{data.attrs['name']}: estimated errors behind every number"
    table = column_table(title, headings, justify="right", no_wrap=True)
    table.add_column("status")
    sizes = sizes_of(data, [name for name, *_ in columns])
    for row in thinned:
        here = data.isel(time=row)
        each = ((k, name, f"error_{name}") for name, k, _ in columns)
        values = [with_error(*(k * float(part) for part in (here[a], here[b], sizes[a]))) for k, a, b in each]
        cells = (f"{float(here[name]):.4g}" for name in loads)
        table.add_row(f"{float(here['time']):.6g}", *cells, *values, here["flags"].item())
    left = "" if step < 2 else f"one row of {step}, {len(rows)} in all; "
    table.caption = f"{left}{joined_words(data.attrs['notes'])}" or None
    return table


def history_record(data: xr.Dataset, left_out: Sequence[Omission] = ()) -> dict[str, Any]:
    """Return a history for a program: lists over the history's own times, SI, with the request and the report."""
    own = data.isel(time=np.flatnonzero(data["given"].to_numpy()))
    kept = report_of(data.attrs["report"])
    report = kept.written | {"notes": sentences(kept.notes)}
    coils = np.diagonal(own["L"].transpose("time", "coil", "coil_2").to_numpy(), axis1=1, axis2=2)
    return status_record(joined(data["flags"].to_numpy())) | {
        "request": request_of(data),
        "error_of_full_scale": data.attrs["error"],
        "time": own["time"].to_numpy(),
        "wrench": {name: own[name].to_numpy() for name in WRENCH},
        "pose": {name: own[name].to_numpy() for name in POSE},
        **{name: own[name].to_numpy() for name in map("error_{}".format, WRENCH) if name in own},
        "error": {name: own[f"error_{name}"].to_numpy() for name in POSE},
        "signals": {item: own[item].to_numpy() for name in shown_signals(data) for item in (name, f"error_{name}")},
        "L": coils,
        "unit_L": data.attrs["unit_L"],
        **({name: data[name].to_numpy() for name in _CODES if name in data}),
        "notes": kept_sentences(data.attrs["notes"]),
        "report": report | {"left_out": [*map(entry, left_out)]},
    }


def history_csv(data: xr.Dataset) -> str:
    """Return all solved times as CSV, SI, every number to its last digit; L of each coil by its name."""
    flat = {name: data[name] for name in data.data_vars if data[name].dims == ("time",)}
    for coil in data["coil"].to_numpy():
        flat |= {f"{name}[{coil}]": data[name].sel(coil=coil, coil_2=coil, drop=True) for name in ("L", "error_L")}
    frame = xr.Dataset(flat).to_dataframe().reset_index()
    return str(frame.assign(given=frame["given"].astype(int)).to_csv(index=False))


def history_curves(data: xr.Dataset) -> Figure:
    """Plot loads, pose and signals that change over time, one below the other; bands are errors."""
    time, rest = data["time"].to_numpy(), float(data["d_v"][0])
    forces, places = moving(data), [name for name in ("d_v", "d_h", "d_y") if np.any(data[name] != 0.0)]
    every = shown_signals(data)
    names = [name for name in every if changes(data[name].to_numpy(), np.zeros(1))] or every[:1]
    rows = 2 + len(names) + ("code" in data)
    with new_figure(0.32 * rows, rows=rows) as (figure, axes):
        for name, stroke in zip(forces, strokes(len(forces)), strict=True):
            axes[0].plot(time, data[name], **(stroke | {"marker": ""}), label=f"${name}$ [{shown_unit(name)}]")
        axes[0].set_ylabel("load")
        axes[0].legend()
        for name, stroke in zip(places, strokes(len(places)), strict=True):
            start, label = (rest, f"${name} - {name}(0)$") if name == "d_v" else (0.0, f"${name}$")
            axes[1].plot(time, 1e6 * (data[name] - start), **(stroke | {"marker": ""}), label=label)
        axes[1].set_ylabel("pose [um]")
        axes[1].legend()
        for panel, name in zip(axes[2:], names, strict=False):
            value, error = data[name].to_numpy(), data[f"error_{name}"].to_numpy()
            panel.fill_between(time, value - error, value + error, color="0.8", linewidth=0.0)
            panel.plot(time, value, color="0.15")
            panel.set_ylabel(signal_label(name))
        if "code" in data:
            code, at = data["code"].to_numpy(), data["code_time"].to_numpy()
            coils = [str(name) for name in data["coil"].to_numpy()]
            for t, values, name, stroke in zip(at.T, (code - code[0]).T, coils, strokes(len(coils)), strict=True):
                axes[-1].plot(t, values, stroke["marker"], color=stroke["color"], ms=1.5, label=name)
            axes[-1].set_ylabel("change of code")
            axes[-1].legend()
        axes[-1].set_xlabel("time [s]")
        for panel in axes[:-1]:
            panel.tick_params(labelbottom=False)
        figure.suptitle(fill(data.attrs["name"], 54))
        figure.align_ylabels(axes)
    return figure


def write_history(sensor: Sensor, data: xr.Dataset, folder: Path) -> list[str]:
    """Write a history's table, scene and picture, each by an atomic rename; return what could not be drawn."""
    save_table(data, folder / "history.nc")
    write_text(folder / "history.csv", history_csv(data))
    if "code" in data:
        columns = {"time": "code_time", "ready": "code_ready", "code": "code", "L": "code_L"}
        codes = data[[*columns.values()]].to_dataframe(dim_order=["scan", "coil"]).reset_index()
        codes = codes.rename(columns={old: new for new, old in columns.items()})
        write_text(folder / "codes.csv", codes[["time", "ready", "coil", "code", "L"]].to_csv(index=False))
    save_sensor(sensor, folder / "scene.toml")
    return save_figures(folder, {"history": partial(history_curves, data)})
