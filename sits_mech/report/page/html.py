"""What does one show colleagues? A calibration as one HTML file: explorer, figures, pictures, tables, warnings.

The file holds everything: style, script, pictures, the table. It needs no network and opens from a disk. Its layout and
the explorer's script stand beside this file; the text of each section is made in `parts`.
"""

from __future__ import annotations

import html
import json
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.codes import Readings, readings
from sits_mech.geometry.windings import coil_bars
from sits_mech.quantities import Array
from sits_mech.readout.loads import beyond_two, two_forces
from sits_mech.report.page.parts import (
    computed_part,
    figures_part,
    inverse_part,
    loads_part,
    pictures_part,
    readout_part,
    scene_part,
    subtitle,
    tiles,
    words_part,
)  # fmt: skip
from sits_mech.report.records import json_text
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import Sensor
from sits_mech.version import __version__

_MM = 1e3
_NAMES = {"inverse": "Forces back", "figures": "Figures", "how": "How computed"}  # shorter ones, to jump to


def write_html(sensor: Sensor, data: xr.Dataset, folder: Path, path: Path) -> None:
    """Write the report of a calibration.

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`.
    folder : Path
        Of the calibration, with its pictures.
    path : Path
        The HTML file.

    Raises
    ------
    SceneError
        When the file cannot be written.
    """
    write_text(path, page(sensor, data, folder))


def page(sensor: Sensor, data: xr.Dataset, folder: Path) -> str:
    """Return the report of a calibration as one HTML text; arguments as of `write_html`.

    What needs a table over F_x and F_z alone is left out where the loads have other components, and named.
    """
    data = data if beyond_two(data) else two_forces(data)
    read = None if beyond_two(data) else readings(sensor, data)
    sections, script = _sections(sensor, data, folder, read), ""
    if read is not None:
        items = readout_items(sensor, read)
        explorer = Template(_file("explorer.html")).substitute(readouts=_cards(items))
        sections = [("explorer", "Explorer", explorer), *sections]
        script = f'<script type="application/json" id="table">{_table(sensor, data, read, items)}</script>\n'
        script += f"<script>\n{_file('page.js')}\n</script>\n"
    nav = "".join(f'<a href="#{name}">{_NAMES.get(name, title)}</a>' for name, title, _ in sections)
    texts = (f'<section id="{name}"><h2>{title}</h2>{text}</section>' for name, title, text in sections)
    return Template(_file("page.html")).substitute(
        title=html.escape(sensor.name), subtitle=subtitle(data), tiles=tiles(data, read), nav=nav,
        sections="\n".join(texts), script=script, css=_file("page.css"),
        footer=f"Made by sits-mech {html.escape(__version__)}. SI units; x is shear, F_z presses down, alpha turns the "
        "right edge down.",
    )  # fmt: skip


def _file(name: str) -> str:
    """Return the text of a file of the page."""
    return (resources.files("sits_mech.report.page") / name).read_text(encoding="utf-8")


def _sections(sensor: Sensor, data: xr.Dataset, folder: Path, read: Readings | None) -> list[tuple[str, str, str]]:
    """Return name, title and HTML of each section below the explorer."""
    hint = '<p class="hint">Every computed load with its estimated errors.</p>'
    readout = [] if read is None else [
        ("readout", "Readout", readout_part(sensor, read)),
        ("inverse", "Forces back from inductances", inverse_part(sensor, data, read)),
    ]  # fmt: skip
    return [
        ("words", "In plain words", f'<ul class="words">{words_part(sensor, data, read)}</ul>'),
        ("figures", "Figures of merit", figures_part(data)),
        ("pictures", "Pictures", pictures_part(folder)),
        *readout,
        ("loads", "Loads", hint + loads_part(data)),
        ("scene", "Scene", scene_part(sensor)),
        ("how", "How it was computed", computed_part(data)),
    ]


def readout_items(sensor: Sensor, read: Readings) -> list[dict[str, Any]]:
    """Return what the explorer shows: label, variable, its error, scale, digits and unit of each."""
    found = []
    for i, coil in enumerate(sensor.coils):
        entry = {"label": f"L of {coil.name}", "name": f"L{i}", "error": f"error_L{i}", "scale": 1e6, "digits": 5}
        found.append(entry | {"unit": "µH"})
        if read.codes is not None:
            found.append({"label": f"code of {coil.name}", "name": f"code{i}", "scale": 1, "digits": 0, "unit": ""})
    several = len(sensor.coils) > 1
    signals = (("L_v", "sum signal L_v"), ("L_h", "difference L_h")) if several else (("L_v", "signal L_v"),)
    for name, label in signals:
        entry = {"label": label, "name": f"{name}_percent", "error": f"error_{name}_percent", "scale": 1, "digits": 3}
        found.append(entry | {"unit": "%"})
    poses = (("d_h", "shift d_h", 1e6, 1, "µm"), ("d_v", "height d_v", 1e6, 1, "µm"), ("alpha", "tilt", 1e3, 3, "mrad"))
    for name, label, scale, digits, unit in poses:
        entry = {"label": label, "name": name, "error": f"error_{name}", "scale": scale, "digits": digits, "unit": unit}
        found.append(entry)
    return found


def _cards(items: list[dict[str, Any]]) -> str:
    """Return one card for each item; the script fills in its numbers."""
    lines = []
    for item in items:
        name, label = item["name"], html.escape(item["label"])
        lines.append(f'<div><i>{label}</i><b id="v-{name}">–</b><em id="e-{name}"></em></div>')
    return "\n".join(lines)


def _table(sensor: Sensor, data: xr.Dataset, read: Readings, items: list[dict[str, Any]]) -> str:
    """Return the table that the explorer works on, as JSON that may stand within HTML."""
    names = [name for item in items for name in (item["name"], item.get("error")) if name]
    values: dict[str, Any] = {}
    for name in names:
        stem, number = name.rstrip("0123456789"), name[len(name.rstrip("0123456789")) :]
        if number:
            arrays = {"L": read.L, "error_L": read.error_L, "code": read.codes}
            values[name] = np.asarray(arrays[stem])[:, :, int(number)]
        else:
            values[name] = data[name].transpose("F_x", "F_z").to_numpy()
    reasons = data["reason"].transpose("F_x", "F_z").to_numpy().tolist()
    forces = {name: data[name].to_numpy() for name in ("F_x", "F_z")}
    record = {
        **forces, "values": values, "reasons": reasons, "items": items, "scene": _drawing(sensor, data),
        "start": {name: _between(force) for name, force in forces.items()},
        "rest": {name: float(force[np.argmin(np.abs(force))]) for name, force in forces.items()},
    }  # fmt: skip
    return json.dumps(json.loads(json_text(record)), separators=(",", ":")).replace("</", "<\\/")


def _between(forces: Array) -> float:
    """Return the load that the explorer opens at: one of the table's, about three quarters up its range."""
    return float(forces[(3 * (len(forces) - 1)) // 4])


def _drawing(sensor: Sensor, data: xr.Dataset) -> dict[str, Any]:
    """Return the section y = 0 in millimetres, as rectangles: x, -z of the upper edge, width, height."""
    bars = []
    for coil in sensor.coils:
        found = coil_bars(coil)
        corner = _MM * np.column_stack([found.x - found.width / 2, -found.z - found.thickness / 2])
        size = np.tile([_MM * found.width, _MM * found.thickness], (len(corner), 1))
        bars += np.column_stack([corner, size, found.sign]).round(4).tolist()
    fixed = []
    for part in sensor.conductors:
        width, (x, _, z), thick = part.extent[0], part.centre, part.thickness
        fixed.append([_MM * (x - width / 2), -_MM * (z + thick / 2), _MM * width, _MM * thick])
    layer, target = sensor.elastomer, sensor.target
    width = _MM * (layer.extent[0] if layer else 0.0)
    bottom = _MM * (layer.standoff if layer else 0.0)
    rest = bottom + _MM * (layer.thickness if layer else 0.0)
    plate = {"width": _MM * target.extent[0], "thickness": _MM * target.thickness} if target else {}
    reach = max([0.56 * width, *(abs(bar[0]) + bar[2] for bar in bars)])
    deep = max(_MM * coil.height for coil in sensor.coils) + 0.5
    top = rest + plate.get("thickness", 0.0) + 2.4
    force = {name[-1]: float(np.abs(data[name]).max()) or 1.0 for name in ("F_x", "F_z")}
    view = {"x": -reach - 0.3, "y": -top, "width": 2 * reach + 0.6, "height": top + deep}
    box = {"width": width, "bottom": bottom}
    return {"bars": bars, "fixed": fixed, "layer": box, "target": plate, "rest": rest, "view": view, "force": force}
