"""Make the sections of the HTML report: text and tables of a calibration, every number with its error."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from pydantic import BaseModel
from rich.table import Table

from sits_mech.analysis.limits import limits_of
from sits_mech.analysis.readings.bench import Readings, coil_table, sensor_calibration
from sits_mech.geometry.windings import kinds_of
from sits_mech.quantities import shown_unit
from sits_mech.readout.crosstalk import crosstalk
from sits_mech.readout.loads import answered, at_middle, each_of, fixed, load_words, request_of, varied
from sits_mech.readout.quality import quality
from sits_mech.readout.signals import shown_signals
from sits_mech.report.tables.loads import KINDS, failures, load_table, remarks, summary_table
from sits_mech.report.tables.quality import limits_record, limits_table, quality_record, quality_tables
from sits_mech.report.tables.readings import front_end_table
from sits_mech.scene.sensor import Coil, Sensor, scene_text, silicones_of
from sits_mech.status import INTERPOLATED, OK, counted, exit_code

PICTURES = {
    "L_v": "Sum of the inductances against the normal force.",
    "L_h": "Difference of the inductances against shear.",
    "dL_v": "Change of the mean inductance against the normal force.",
    "dL_x": "First moment of the inductances along x against the shear force along x.",
    "dL_y": "First moment of the inductances along y against the shear force along y.",
    "crosstalk": "What each force does to the signals of the others, relative to their own full scale.",
    "layer": "The deformed layer under the largest load, in a section along it.",
}
"""Captions of a calibration's pictures."""
_MOST = 1000  # loads in the page's table
_LINES = 8  # of a cell in one column
_NOTABLE = 10.0  # crosstalk worth a sentence [% of full scale]


def subtitle(data: xr.Dataset) -> str:
    """Return one line under the title."""
    request = request_of(data)
    models = f"{request['mechanics']} mechanics, {request['magnetics']} magnetics"
    frequency = f"{float(data.attrs['frequency']) / 1e6:.4g} MHz"
    held = load_words(fixed(data))
    loads = f"{data['status'].size} loads{' under ' if held else ''}{held}"
    return html.escape(f"Calibration over {loads} at {frequency} · {models}")


def tiles(data: xr.Dataset, read: Readings) -> str:
    """Return the headline numbers."""
    found = [(_span(data, name), f"{KINDS[name]} [{shown_unit(name)}]") for name in varied(data)]
    found.append((f"{1e6 * float(np.mean(read.L0)):.4g} µH", "free-space inductance of a coil"))
    stray = crosstalk(data).attrs
    for name, size in stray.items():
        if str(name).startswith("full_scale_") and size > 0.0:
            signal = str(name).removeprefix("full_scale_")
            found.append((f"{size:.3g} % of L0", f"full scale of {signal}: its range over the loads"))
    mixed = sorted(_mixed(stray), reverse=True)[:2]
    found += [(f"{share:.3g} %", f"crosstalk of {force} into {signal}") for share, force, signal in mixed]
    done = f"{int(answered(data).sum())} of {data['status'].size} loads answered"
    found.append((f"{float(data['seconds'].sum()):.3g} s", f"processor time of the poses; {done}"))
    return tiles_of([each for each in found if not each[0].startswith("nan")])


def tiles_of(found: Sequence[tuple[str, str]]) -> str:
    """Return values and what they are as tiles."""
    texts = (tuple(map(html.escape, each)) for each in found)
    return "\n".join("<div class=\"tile\"><b>{}</b><span>{}</span></div>".format(*each) for each in texts)


def _mixed(stray: Mapping[Hashable, Any]) -> list[tuple[float, str, str]]:
    """Return share [% of full scale], force and signal of each crosstalk that is larger than its error."""
    found = []
    for name, share in stray.items():
        signal, _, force = str(name).removeprefix("largest_").partition("_from_")
        if str(name).startswith("largest_") and share > stray[f"error_{name}"]:
            found.append((float(share), force, signal))
    return found


def _span(data: xr.Dataset, force: str) -> str:
    """Return a force's range."""
    low, high = (f"{float(data[force][end]):.4g}".replace("-", "−") for end in (0, -1))
    return low if low == high else f"{low} … {high}"


def words_part(sensor: Sensor, data: xr.Dataset, read: Readings) -> str:
    """Return warnings and what else a reader should know, in sentences."""
    lines = [f"No result under {line}" for line in failures(data)]
    lines += [_sentence(line) for line in remarks(data)]
    lines += [] if read.front is None else [_sentence(line) for line in read.front.warnings]
    lines += _mixing(data) + _models(sensor, data)
    statuses = each_of(data)
    good = [f'<li class="good">Status: {counted(statuses)}.</li>'] if exit_code(statuses) == 0 else []
    lines += [] if good else [f"Status: {counted(statuses)}."]
    return "\n".join(good + [f"<li>{html.escape(line)}</li>" for line in lines])


def _sentence(line: str) -> str:
    """Return a line that begins and ends as a sentence does."""
    return line[:1].upper() + line[1:] + ("" if line.endswith(".") else ".")


def _mixing(data: xr.Dataset) -> list[str]:
    """Return what crosstalk means for the user, where there is much of it."""
    much = [item for item in sorted(_mixed(crosstalk(data).attrs), reverse=True) if item[0] > _NOTABLE]
    if not much:
        return []
    shares = [f"{signal} by up to {share:.2g} % of its full scale by {force}" for share, force, signal in much]
    return [f"Signals are moved by other forces than their own, {'; '.join(shares)}: read all forces from all signals "
            "together, not each from its own."]


def _models(sensor: Sensor, data: xr.Dataset) -> list[str]:
    """Return the limitations of the models that were used."""
    lines, mechanics = [], request_of(data)["mechanics"]
    if data.attrs["unit_L"] != "H":
        lines.append(
            "The magnetic model is per metre of depth. Microhenries and codes are its relative changes times the "
            "coils' inductance in free space; effects of the target's ends in y are not in them. Of a short target the "
            "shear signal can be several times smaller in space: calibrate with --magnetics sheets where it matters."
        )
    layer, target = sensor.elastomer, sensor.target
    if any(each.has_history for each in silicones_of(sensor)):
        lines.append(
            "The silicone relaxes or softens, the table is its first elastic answer: quality --period says "
            "what a load that comes and goes makes of the forces."
        )
    if mechanics not in ("block", "axisymmetric") and layer and target and target.extent[1] < 0.95 * layer.extent[1]:
        lines.append(
            f"The layer is solved as if the target were as long as the layer ({_mm(layer.extent[1])}); it is "
            f"{_mm(target.extent[1])} long. The real pad is softer: take --mechanics block where newtons matter."
        )
    lines.append("Estimated errors are of the numerics. The constants of a silicone are uncertain by more.")
    return lines


def _mm(metres: float) -> str:
    """Return a length for a reader."""
    return f"{1e3 * metres:.4g} mm"


def figures_part(data: xr.Dataset) -> str:
    """Return the figures of merit."""
    return html_table(summary_table(data))


def pictures_part(folder: Path, captions: Mapping[str, str]) -> str:
    """Return the pictures of a folder, within the page; a line where there are none."""
    found = []
    for name, caption in captions.items():
        file = folder / f"{name}.png"
        if file.is_file():
            text = base64.b64encode(file.read_bytes()).decode("ascii")
            image = f'<img alt="{html.escape(caption)}" src="data:image/png;base64,{text}">'
            found.append(f"<figure>{image}<figcaption>{html.escape(caption)}</figcaption></figure>")
    if not found:
        return "<p>The folder has no pictures: they need matplotlib when the calibration is made.</p>"
    return f'<div class="pictures">{"".join(found)}</div>'


def readout_part(sensor: Sensor, read: Readings) -> str:
    """Return the converter's settings and the codes of the coils."""
    if read.front is None:
        return f"<p>{html.escape(_sentence('; '.join(read.left_out)))}</p>"
    return html_table(front_end_table(read.front, sensor.coil_names, read.left_out))


def inverse_part(sensor: Sensor, data: xr.Dataset, read: Readings) -> str:
    """Return the quality of the inverse: its error, where it has no answer, noise in newtons."""
    try:
        cal = sensor_calibration(sensor, data)
    except ValueError as error:
        return f"<p>{html.escape(_sentence(str(error)))}</p>"
    few = len(cal.coils) < len(cal.forces)
    fit = ("interpolation error", f"{cal.error:.1e} of a coil's full scale, by leaving out loads")
    rows = [("no inverse", f"{len(cal.coils)} coils cannot resolve {', '.join(cal.forces)}"), fit] if few else [
        ("forces resolved", ", ".join(name for name in cal.forces if name not in cal.unresolved) or "none"),
        fit,
        ("loads with one answer", f"{100.0 * cal.share:.4g} % of the calibrated range"),
        *(("no answer", region) for region in cal.no_inverse),
    ]
    if read.front is None:
        return _pairs(rows)
    found = quality(cal, read.front.noise, table=coil_table(sensor, data))
    tables = quality_tables(quality_record(found, data))
    hint = '<p class="hint after">Noise is that of the converter at its longest conversion.</p>'
    return _pairs(rows) + hint + "".join(_titled(table) for table in tables)


def limits_part(sensor: Sensor, data: xr.Dataset) -> str:
    """Return the limits of the pad, and the uncertainty of its modulus by the sources."""
    return html_table(limits_table(limits_record(limits_of(sensor, data))))


def _titled(table: Table) -> str:
    """Return a table with its title and what it says below."""
    below = f'<p class="hint after">{html.escape(str(table.caption))}</p>' if table.caption else ""
    return f"<h3>{html.escape(str(table.title).capitalize())}</h3>{html_table(table)}{below}"


def loads_part(data: xr.Dataset) -> str:
    """Return every load with pose, signals, errors and time; of a large table those at the middle of what runs last."""
    held, count = "", data["status"].size
    names = list(varied(data))
    while data["status"].size > _MOST and len(names) > 1:
        names.pop()
        data, held = at_middle(data, names)
    words = f"Loads with {held} of {count}; result.csv has all." if held else "Every computed load."
    hint = f'<p class="hint">{html.escape(words)} Estimated errors stand behind the numbers.</p>'
    box = '<div class="scroll" role="region" aria-label="Loads" tabindex="0">'
    return f"{hint}{box}{html_table(load_table(data), numbers=True)}</div>"


def scene_part(sensor: Sensor) -> str:
    """Return the scene as tables, and as the file that makes it."""
    blocks = [("sensor", [("name", sensor.name), ("frequency", f"{sensor.frequency / 1e6:.6g} MHz")])]
    kinds, numbers = kinds_of(sensor.coils)
    for k in range(len(kinds)):
        blocks.append(_coils([coil for coil, number in zip(sensor.coils, numbers, strict=True) if number == k]))
    plates = {"target": sensor.target, "elastomer": sensor.elastomer, "cover": sensor.cover}
    parts: list[tuple[str, BaseModel]] = [(name, part) for name, part in plates.items() if part is not None]
    parts += [(f"conductor {part.name}", part) for part in sensor.conductors]
    blocks += [(title, _rows(part)) for title, part in [*parts, ("readout", sensor.readout)]]
    tables = "".join(f"<div><h3>{html.escape(title)}</h3>{_pairs(rows)}</div>" for title, rows in blocks)
    source = f"<details><summary>scene file</summary><pre>{html.escape(scene_text(sensor))}</pre></details>"
    return f'<div class="two">{tables}</div>{source}'


def _coils(coils: Sequence[Coil]) -> tuple[str, list[tuple[str, str]]]:
    """Return title and rows of coils that are equal but for their places."""
    if len(coils) == 1:
        return f"coil {coils[0].name}", _rows(coils[0])
    places = "; ".join(f"{coil.name} {', '.join(map(_mm, coil.centre))}" for coil in coils)
    rows = [("centres", places), *(row for row in _rows(coils[0]) if row[0] != "centre")]
    return f"{len(coils)} equal coils", rows


def _rows(part: BaseModel) -> list[tuple[str, str]]:
    """Return the keys and values of a part, of long outlines the number of their corners."""
    table = part.model_dump(exclude_none=True)
    for key, loops in (("points", [table.get("points", ())]), ("holes", table.get("holes", ()))):
        if (corners := sum(map(len, loops))) > _CORNERS:
            table[key] = f"{corners} corners"
        elif key in table and corners == 0:
            del table[key]
    return [(key, _shown(key, value)) for key, value in table.items() if key != "name"]


_LENGTHS = (
    "diameter", "width", "gap", "thickness", "pitch", "length", "height", "centre", "standoff", "points", "radius",
    "layer_z", "path_widths", "holes",
)
_CORNERS = 8  # of an outline that are written
_UNITS = {"capacitance": "F", "inductance": "H", "resistance": "ohm", "modulus": "Pa", "conductivity": "S/m"}


def _shown(key: str, value: Any) -> str:
    """Return a scene's value for a reader, lengths in millimetres."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {_shown(name, item)}" for name, item in value.items())
    if key == "path":
        return f"{len(value)} polylines of {sum(map(len, value))} points"
    if isinstance(value, list | tuple):
        return "; ".join(_shown(key, item) for item in value)
    if isinstance(value, float) and key.endswith(_LENGTHS):
        return _mm(value)
    unit = next((f" {unit}" for word, unit in _UNITS.items() if key.endswith(word)), "")
    return f"{value:.6g}{unit}" if isinstance(value, float) else str(value)


def computed_part(data: xr.Dataset) -> str:
    """Return models, tolerance, errors and times."""
    request = request_of(data)
    done = data.where(answered(data))
    seconds, least = data["seconds"], float(done["min_J"].min()) if "min_J" in done else math.nan
    rows = [
        ("mechanics", f"{request['mechanics']}: relative error of a pose up to {_most(done, 'error_mechanics')}"),
        ("magnetics", f"{request['magnetics']}: relative error of a change up to {_most(done, 'error_magnetics')}"),
        ("asked tolerance", f"{request['tolerance']:g}"),
        ("time", f"{float(seconds.sum()):.3g} s for all loads, at most {float(seconds.max()):.2g} s for one"),
        ("smallest volume ratio", f"{least:.4f}" if math.isfinite(least) else "not known"),
        *((f"largest error of {name.removesuffix('_percent')}", f"{_most(done, f'error_{name}')} % of L0")
          for name in shown_signals(data)),
        ("version", f"sits-mech {data.attrs['version']}, scene {data.attrs['scene_hash']}"),
    ]
    return _pairs(rows)


def _most(data: xr.Dataset, name: str) -> str:
    """Return the largest value of a variable."""
    value = float(data[name].max()) if name in data else math.nan
    return f"{value:.2g}" if math.isfinite(value) else "unknown"


def html_table(table: Table, *, numbers: bool = False) -> str:
    """Return a table as HTML, a name once for all its rows; with `numbers` all cells are aligned to the right."""
    kind, open_box, close_box = (' class="n"', "", "") if numbers else ("", '<div class="wide">', "</div>")
    head = "".join(f"<th{kind}>{html.escape(str(column.header))}</th>" for column in table.columns)
    lines = [f"<table><thead><tr>{head}</tr></thead><tbody>" if table.show_header else "<table><tbody>"]
    rows = [list(map(str, cells)) for cells in zip(*(column.cells for column in table.columns), strict=True)]
    for texts in rows if table.show_header else _joined(rows):
        texts = list(map(_cell, texts))
        bad = ' class="bad"' if numbers and texts[-1].partition(";")[0] not in (OK, INTERPOLATED) else ""
        lines.append(f"<tr{bad}><td{kind}>" + f"</td><td{kind}>".join(texts) + "</td></tr>")
    return "".join([open_box, *lines, "</tbody></table>", close_box])


def _cell(text: str) -> str:
    """Return the text of a cell as HTML, many lines in columns."""
    found = html.escape(text).replace("+-", "±").replace("\n", "<br>")
    return f'<div class="columns">{found}</div>' if text.count("\n") > _LINES else found


def _joined(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return rows of names and texts, those without a name joined to the one before."""
    found: list[list[str]] = []
    for name, text in rows:
        if name or not found:
            found.append([name, text])
        else:
            found[-1][1] += f"\n{text}"
    return found


def _pairs(rows: Sequence[tuple[str, str]]) -> str:
    """Return a table of names and values."""
    cells = (f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>" for name, value in rows)
    return f'<div class="wide"><table><tbody>{"".join(cells)}</tbody></table></div>'
