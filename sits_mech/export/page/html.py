"""Write a calibrated sensor as one HTML file to play with: dragged forces, codes, and the forces back from them.

The file holds everything and needs no network: the twin's arrays of wrenches and readings with its evaluator in
JavaScript (``twin.js``, which does what ``twin/twin.py`` does), the table's poses and the drawings of the report's
explorer. Its own layout and script stand beside this file. The response is the slow one; noise is the converter's.
"""

from __future__ import annotations

import html
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from sits_mech.analysis.readings.bench import readings
from sits_mech.export.source import Source
from sits_mech.export.twin.arrays import readout_arrays
from sits_mech.quantities import POSE, WRENCH
from sits_mech.report.page.explorer import cards, items_of, page_file, script_of, sliders, table
from sits_mech.report.page.html import page_of
from sits_mech.report.page.parts import subtitle
from sits_mech.scene.files import write_text

_CHART = '<figure><svg id="curve{}" role="img" aria-label="Inductance of {} over the force moved last"></svg></figure>'

def write_page(source: Source, path: Path) -> tuple[str, ...]:
    """Write a sensor's page; return one line for each thing to know.

    Raise SceneError where `path` cannot be written, the table's outermost loads failed, or it has one load.
    """
    notes = list[str]()
    numbers, _ = readout_arrays(source, "page", notes)
    write_text(path, sensor_page(source, numbers, notes))
    return tuple(notes)


def sensor_page(source: Source, numbers: dict[str, Any], notes: list[str]) -> str:
    """Return the page of a sensor, of the arrays of its readout and what is to be known of them."""
    sensor, data = source.sensor, source.data
    read = readings(sensor, data)
    items = items_of(sensor, data, read)
    coils = [item for item in items if item["name"].rstrip("0123456789") in ("L", "code")]
    poses = [item for item in items if item["name"] in POSE]
    record = table(sensor, data, read, poses, small=False)
    kept = {name: np.asarray(value).tolist() for name, value in numbers.items() if not name.endswith("_float32")}
    markup = Template(page_file("page.html", "export.page")).substitute(
        sliders=sliders(data), cards="\n".join((cards(coils), _back(numbers), cards(poses))),
        charts="\n".join(_CHART.format(k, html.escape(name)) for k, name in enumerate(kept["coils"])),
        shown="Codes" if kept["codes"] else "Inductances", about=html.escape(source.about),
        notes="".join(f"<li>{html.escape(note)}</li>" for note in notes),
    )
    evaluator = page_file("twin.js", "export.twin")
    code = [page_file("table.js"), page_file("scene.js"), evaluator, page_file("page.js", "export.page")]
    return page_of(
        sensor.name, [("sensor", "Press and shear", markup)], " SI units; F_z presses down.",
        page_file("page.css", "export.page"), subtitle=subtitle(data), tiles="",
        script=script_of(record | {"twin": kept}, code),
    )


def _back(numbers: dict[str, Any]) -> str:
    """Return a card for each force that is read back; the script fills in the numbers."""
    seen = "codes" if numbers["codes"] else "inductances"
    card = '<div class="back"><i>{0} from the {1}</i><b id="b-{0}">–</b><em id="off-{0}"></em></div>'
    names = () if str(numbers["no_inverse"]) else (WRENCH[k] for k in numbers["wrench_columns"])
    return "\n".join(card.format(name, seen) for name in names)
