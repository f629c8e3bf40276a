"""Write a sweep as one HTML file: parallel coordinates and a slice for any two keys, failed cases with their commands.

Numbers go into the page case by case, keys with fifteen digits and results with six; of more than `_MOST` numbers
evenly chosen cases. The script stands beside this file, in sweep.js, on the axes and shades of the other reports.
"""

from __future__ import annotations

import html
import json
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.batch.requests import REQUESTS
from sits_mech.batch.run import TABLE
from sits_mech.batch.studies.written import SCENE
from sits_mech.batch.tables import SWEPT
from sits_mech.labels import unit_of
from sits_mech.quantities import Array
from sits_mech.readout.loads import each_of, point
from sits_mech.report.page.explorer import page_file, script_of
from sits_mech.report.page.html import page_of
from sits_mech.report.page.parts import html_table, tiles_of
from sits_mech.report.tables.cases import case_remarks, case_table
from sits_mech.report.tables.solves import point_name
from sits_mech.scene.files import write_text
from sits_mech.status import ANSWERED, UNFINISHED, counted
from sits_mech.store import read_table

_MOST = 300_000  # numbers in a page
_FAILED = 200  # failed cases that are listed
_MARKUP = """<p class="hint">Each line is a case. Drag along an axis to keep a part, click it to keep all.$hint</p>
<div class="small"><label>colour <select id="of"></select></label><span id="state" role="status"></span></div>
<div class="stage"><svg id="parallel" role="img" aria-label="Parallel coordinates of the cases"></svg></div>
<h3>Slice</h3>
<div class="small"><label>across <select id="x"></select></label><label>up <select id="y"></select></label>
<span id="held"></span></div>
<div class="stage"><svg id="slice" role="img" aria-label="Cases over two keys"></svg></div>"""

Record = dict[str, Any]


def write_sweep(folder: Path, path: Path) -> list[Path]:
    """Write the report of a sweep's folder; return the scenes of failed cases, which are written to the folder."""
    data = read_table(folder / TABLE)
    failed = [k for k, word in enumerate(data["status"].to_numpy().ravel()) if word not in (*ANSWERED, UNFINISHED)]
    text = str(data.attrs["scene"])
    scenes = (json.loads(text) if SCENE in data.coords else {"": text}) if failed else {}
    files = {name: folder / ("scene.toml" if len(scenes) == 1 else f"scene-{k}.toml") for k, name in enumerate(scenes)}
    for name, file in files.items():
        write_text(file, scenes[name])
    write_text(path, sweep_page(data, failed, files))
    return list(files.values())


def sweep_page(data: xr.Dataset, failed: Sequence[int], files: dict[str, Path]) -> str:
    """Return the report of a sweep's table; `failed` are numbers of cases, `files` their scenes by names."""
    states = each_of(data)
    record = columns_of(data)
    shown = len(record["cases"])
    hint = f" {shown} of {len(states)} cases are here; result.nc has all." if shown < len(states) else ""
    box = '<div class="scroll" role="region" aria-label="Cases" tabindex="0">'
    sections = [("cases", "Cases", f"{box}{html_table(case_table(data), numbers=True)}</div>")]
    if remarks := case_remarks(data):
        lines = "".join(f"<li>{html.escape(line)}</li>" for line in remarks)
        sections.append(("left-out", "Left out", f"<ul>{lines}</ul>"))
    if failed:
        sections.insert(0, ("failed", "Failed cases", _failed_part(data, failed, files)))
    sections.insert(0, ("explorer", "Explorer", _MARKUP.replace("$hint", hint)))
    asked = ", ".join(f"{name} = {item}" for name, item in json.loads(data.attrs["fixed"]).items()) or "nothing fixed"
    seconds = float(np.nansum(data["seconds"])) if "seconds" in data else 0.0
    tiles = [(str(len(states)), "cases"), (str(len(failed)), "failed"), (f"{seconds:.3g} s", "for all cases")]
    return page_of(
        f"Sweep of {data.attrs['request']}", sections, " SI units.",
        subtitle=html.escape(f"{data.attrs['combine']} · {asked} · {counted(states)}"),
        tiles=tiles_of(tiles),
        script=script_of(record, [page_file(f"{name}.js") for name in ("table", "charts", "sweep")]),
    )


def columns_of(data: xr.Dataset) -> Record:
    """Return keys and results of the cases for the script."""
    states, dims = data["status"].to_numpy().ravel(), data["status"].dims
    found = [_column(data, str(name), data[name].broadcast_like(data["status"]).transpose(*dims).to_numpy().ravel())
             for name in data["status"].coords]
    keys = len(found)
    for name, item in data.data_vars.items():
        if item.dtype.kind == "f" and not str(name).startswith("error_"):
            found += [_column(data, label, values) for label, values in _parts(item, str(name), dims)
                      if np.isfinite(values).any()]
    found.append(_column(data, "status", states))
    step = max(1, -(-states.size * len(found) // _MOST))
    cases = np.flatnonzero(states != UNFINISHED)[::step].tolist()
    for column in found:
        column["values"] = [column["values"][case] for case in cases]
    numbers = {"keys": keys, "cases": [case + 1 for case in cases], "grid": dims != ("case",) and step == 1}
    return {"forces": [], "items": [], "columns": found} | numbers


def _parts(item: xr.DataArray, name: str, dims: tuple[Any, ...]) -> Iterator[tuple[str, Array]]:
    """Yield name and values of a variable's columns: of coils and forces one for each, of matrices the diagonal."""
    inner = tuple(dim for dim in item.dims if dim not in dims)
    values = item.transpose(*dims, *inner).to_numpy()
    if inner == ("coil", "coil_2"):
        values, inner = np.diagonal(values, axis1=-2, axis2=-1), ("coil",)
    if not inner:
        yield name, values.ravel()
    elif inner in (("coil",), ("force",)):
        for k, label in enumerate(item[inner[0]].to_numpy()):
            yield f"{name}[{label}]", values[..., k].ravel()


def _column(data: xr.Dataset, name: str, values: Array) -> Record:
    """Return a column: numbers, or places in a list of words."""
    stem = name.partition("[")[0]
    unit = str(data[stem].attrs.get("units", "") or unit_of(stem, "")).removeprefix("1").strip()
    label = f"{name} [{unit}]" if unit else name
    if values.dtype.kind not in "fiu":
        words, places = np.unique(values.astype(str), return_inverse=True)
        return {"name": name, "label": label, "values": places.ravel().tolist(), "words": words.tolist()}
    digits = 15 if name in data.coords else 6
    return {"name": name, "label": label, "values": [float(f"{value:.{digits}g}") for value in values.tolist()]}


def _failed_part(data: xr.Dataset, failed: Sequence[int], files: dict[str, Path]) -> str:
    """Return a table of failed cases, with the command that repeats each alone."""
    lines = []
    for number in failed[:_FAILED]:
        row = point(data, number)
        words = (point_name(row), f"{row['status'].item()}: {row['reason'].item()}", command(row, files))
        where, why, again = map(html.escape, words)
        lines.append(f"<tr><td>{number + 1}</td><td>{where}<br>{why}<br><code>{again}</code></td></tr>")
    more = f'<p class="hint after">and {len(failed) - _FAILED} more</p>' if len(failed) > _FAILED else ""
    head = "<thead><tr><th>case</th><th>where, why, and how to repeat it alone</th></tr></thead>"
    return f'<div class="wide"><table>{head}<tbody>{"".join(lines)}</tbody></table></div>{more}'


def command(row: xr.Dataset, files: dict[str, Path]) -> str:
    """Return the command line that repeats a case of a sweep alone."""
    asked, point = row.attrs["request"], {str(name): row[name].item() for name in row["status"].coords}
    words = ["sits-mech", "calibrate" if asked in SWEPT else asked, str(files[point.pop(SCENE, "")])]
    for name, item in (json.loads(row.attrs["fixed"]) | point).items():
        value = f"{item:.15g}" if isinstance(item, float) else str(item)
        own = name in REQUESTS[asked].arguments
        words += [f"--{name}={value}"] if own else ["--set", f"{name}={value}"]
    return shlex.join([*words, "--si"])
