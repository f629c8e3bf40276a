"""Make the page's explorer: the table's numbers and labels, the scene's parts, the controls.

The table goes into the page as JSON, flat, the last component of the load running fastest: values with eleven digits,
errors with three. A table of more than `_MOST` numbers leaves the errors out, keeps six digits (of codes all), and says
so.
"""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from string import Template
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.readings.bench import Readings
from sits_mech.geometry.outline import from_above, pad_outlines, target_outline
from sits_mech.geometry.tracks import coil_lines
from sits_mech.geometry.windings import turn_radii
from sits_mech.quantities import POSE, UNITS, shown_unit
from sits_mech.readout.crosstalk import signals_of
from sits_mech.readout.loads import fixed, several, varied
from sits_mech.readout.signals import shown_signals
from sits_mech.report.records import json_text
from sits_mech.report.tables.loads import KINDS
from sits_mech.report.tables.solves import shown_scale
from sits_mech.scene.sensor import Coil, Conductor, Sensor
from sits_mech.units import MM

_MOST = 300_000  # numbers in a page
_DIGITS = {True: 11, False: 6}
_FEW = 6  # coils that are shown before signals and pose
_STILL = 1e-9  # a component of the pose below it is none [m, rad]
_UNSHOWN = ("values", "along", "limit")  # of what is required
_POSE = {
    "d_h": "shift d_h", "d_y": "shift d_y", "d_v": "height d_v", "alpha_x": "tilt alpha_x", "alpha": "tilt alpha",
    "alpha_z": "turn alpha_z",
}
_SIGNAL = {
    "L_v_percent": "sum signal L_v", "L_h_percent": "difference L_h", "dL_v": "dL_v, mean change from no target",
    "dL_x": "first moment dL_x", "dL_y": "first moment dL_y",
}

_MARKUP = """<p class="hint">Move the load: what the coils show, and where the target goes.$hint</p>
<div class="explorer">
<div>
<div class="stage"><svg id="stage" role="img" aria-label="Upright section of coils, layer and target"></svg></div>
<div class="controls">$sliders</div>
<div class="small">
<label>motion drawn <select id="grow"><option value="1">to scale</option><option value="3" selected>&times; 3</option>
<option value="10">&times; 10</option><option value="30">&times; 30</option></select></label>
<label id="cut-box">section <select id="cut"><option value="load">along the shear</option>
<option value="y">y = 0</option><option value="x">x = 0</option></select></label>
<button id="snap" type="button">nearest load</button><button id="rest" type="button">no load</button>
</div>
<div class="views">
<figure class="stage"><svg id="plan" role="img" aria-label="Coils and target seen from above under the load"></svg>
<figcaption>From above: line of the section, shear force; the dot is where the target dips.</figcaption></figure>
<figure class="stage" id="map-box"><div class="small"><label>map of <select id="map-item"></select></label>
<label>over <select id="map-x"></select></label><label>and <select id="map-y"></select></label></div>
<svg id="map" role="img" aria-label="Map over two components of the load"></svg>
<figcaption>Small dots are loads of the table; a click chooses a load.</figcaption></figure>
</div>
</div>
<div class="read">$cards<div id="state" role="status"></div></div>
</div>
<div class="charts">$figures</div>"""

Record = dict[str, Any]


@dataclass(frozen=True)
class RequiredLines:
    """What is required, as lines over the explorer, and what it is required of."""

    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # of components of the load [N, N m]
    height: float | None = None  # of the highest place that is allowed, from the coils' top [m]
    items: Sequence[Record] = ()  # as of `items_of`, with values (*loads) and a limit, each along a component


def explorer(sensor: Sensor, data: xr.Dataset, read: Readings, asked: RequiredLines | None = None) -> tuple[str, str]:
    """Return the explorer's section and script; the table must vary at least one component of the load."""
    asked = asked or RequiredLines()
    items = items_of(sensor, data, read)
    items += [{key: item for key, item in each.items() if key not in _UNSHOWN} for each in asked.items]
    data = data.assign({each["name"]: (varied(data), each["values"]) for each in asked.items})
    curves = charts(data, items, asked)
    small = sum(1 + ("error" in item) for item in items) * data["status"].size <= _MOST
    hint = "" if small else " This table is large: it stands here with six digits and without errors."
    markup = Template(_MARKUP).substitute(
        sliders=sliders(data), cards=cards(items), figures=empty_charts(curves), hint=hint
    )
    record = table(sensor, data, read, items, small=small) | {"charts": curves, "asked": dict(asked.ranges)}
    record["most_high"] = None if asked.height is None else MM * asked.height
    return markup, script_of(record, [page_file(f"{name}.js") for name in ("table", "scene", "charts", "page")])


def script_of(record: Record, code: Sequence[str]) -> str:
    """Return a page's numbers as JSON, and the texts of its code in a scope of their own."""
    # neither "</script" nor "<!--<script" of a name is HTML's
    text = json_text(record, indent=None, separators=(",", ":")).replace("<", "\\u003c")
    script = f'<script type="application/json" id="table">{text}</script>\n'
    whole = "\n".join(code)
    return f'{script}<script>\n(function () {{\n"use strict";\n{whole}\n}})();\n</script>\n'


def page_file(name: str, room: str = "report.page") -> str:
    """Return the text of a file of the page, or of another room."""
    return (resources.files(f"sits_mech.{room}") / name).read_text(encoding="utf-8")


def items_of(sensor: Sensor, data: xr.Dataset, read: Readings) -> list[Record]:
    """Return label, variable, its error, scale, digits and unit of each item; many coils come last."""
    coils, found = [], []
    for i, coil in enumerate(sensor.coils):
        entry = {"label": f"L of {coil.name}", "name": f"L{i}", "error": f"error_L{i}", "scale": 1e6, "digits": 5}
        coils.append(entry | {"unit": "µH"})
        if read.codes is not None:
            coils.append({"label": f"code of {coil.name}", "name": f"code{i}", "scale": 1, "digits": 0, "unit": ""})
    for name in dict.fromkeys((*shown_signals(data), *signals_of(data).values())):
        entry = {"label": _SIGNAL[name], "name": name, "error": f"error_{name}", "scale": 1, "digits": 3, "unit": "%"}
        found.append(entry)
    for name, label in _POSE.items():
        if name in POSE[:3] or (name in data and float(np.nan_to_num(np.abs(data[name].to_numpy())).max()) > _STILL):
            scale, unit = shown_scale(name)
            entry = {"label": label, "name": name, "error": f"error_{name}", "scale": scale}
            found.append(entry | {"digits": 1 if unit == "um" else 3, "unit": unit.replace("u", "µ")})
    return coils + found if len(sensor.coils) <= _FEW else found + coils


def cards(items: list[Record]) -> str:
    """Return a card for each item, a coil's code in that of its inductance; the script fills in the numbers."""
    lines, codes = [], {item["name"]: item for item in items if item["name"].startswith("code")}
    for item in items:
        name, label = item["name"], html.escape(item["label"])
        if name in codes:
            continue
        code = f"code{name[1:]}"
        extra = f'<small>code <span id="v-{code}">–</span></small>' if name[0] == "L" and code in codes else ""
        lines.append(f'<div><i>{label}</i><b id="v-{name}">–</b><em id="e-{name}"></em>{extra}</div>')
    return "\n".join(lines)


def sliders(data: xr.Dataset) -> str:
    """Return a slider with its label and its number for each component that the table varies."""
    lines = []
    for name in varied(data):
        letter, _, rest = name.partition("_")
        label = f"{letter}{f'<sub>{rest}</sub>' if rest else ''} {KINDS[name].replace(' force', '')}"
        lines.append(
            f'<label for="s-{name}">{label}</label><input type="range" id="s-{name}">'
            f'<output id="o-{name}" for="s-{name}"></output>'
        )
    return "\n".join(lines)


def charts(data: xr.Dataset, items: list[Record], asked: RequiredLines) -> list[Record]:
    """Return the curves that are drawn: each signal against the force that it answers, at several values of another."""
    varies, limits = several(data), {each["name"]: each for each in asked.items}
    own, found = {signal: force for force, signal in signals_of(data).items()}, []
    own |= {name: each["along"] for name, each in limits.items()}
    for item in items:
        along, name = own.get(item["name"]), item["name"]
        if along in varies:
            family = next((name for name in ("F_z", "F_x", *varies) if name in varies and name != along), None)
            words = (item["label"], item["unit"]) if name in limits else (name.removesuffix("_percent"), "% of L0")
            curve = {"name": name, "label": item["label"], "along": along, "family": family}
            limit = {"limit": limits[name]["limit"]} if name in limits else {}
            found.append(curve | {"axis": "{} [{}]".format(*words)} | limit)
    return found


def empty_charts(curves: list[Record]) -> str:
    """Return an empty chart with its words for each of `charts`."""
    lines = []
    for k, curve in enumerate(curves):
        words = f"{html.escape(curve['label'])} against {curve['along']}; green at the present load"
        words += f", grey at the table's {curve['family']}" if curve["family"] else ""
        svg = f'<svg id="chart{k}" role="img" aria-label="{words}"></svg>'
        lines.append(f"<figure>{svg}<figcaption>{words}.</figcaption></figure>")
    return "\n".join(lines)


def table(sensor: Sensor, data: xr.Dataset, read: Readings, items: list[Record], *, small: bool) -> Record:
    """Return the table that the explorer works on; errors only of a small one."""
    order, arrays = varied(data), {"L": read.L, "error_L": read.error_L, "code": read.codes}
    values = {}
    for name in (name for item in items for name in (item["name"], item.get("error")) if name):
        stem, number = name.rstrip("0123456789"), name[len(name.rstrip("0123456789")) :]
        each = np.asarray(arrays[stem])[..., int(number)] if number else data[name].transpose(*order).to_numpy()
        is_error = name.startswith("error_")
        if small or not is_error:
            digits = 3 if is_error else _DIGITS[small or stem == "code"]
            numbers = each.ravel().tolist()
            values[name] = [float(f"{value:.{digits}g}") if math.isfinite(value) else math.nan for value in numbers]
    forces = []
    for name in order:
        nodes, scale = data[name].to_numpy().tolist(), 1.0 if UNITS[name] == "N" else 1e3
        unit = f"{'' if scale == 1.0 else 'm'}{shown_unit(name)}"
        places = {"start": nodes[int(0.75 * (len(nodes) - 1) + 0.5)], "rest": min(nodes, key=abs)}
        forces.append({"name": name, "unit": unit, "scale": scale, "nodes": nodes} | places)
    reasons = data["reason"].transpose(*order).to_numpy().ravel()
    return {
        "forces": forces, "held": fixed(data), "values": values, "items": items, "scene": parts_of(sensor),
        "reasons": {str(k): str(text) for k, text in enumerate(reasons) if text},
    }


def parts_of(sensor: Sensor) -> Record:
    """Return coils, pad, target, cover and fixed plates in millimetres: outlines from above, heights."""
    coils = [_coil(coil) for coil in sensor.coils]
    layer, target = sensor.elastomer, sensor.target
    rest = 0.0 if layer is None else MM * (layer.standoff + layer.thickness)
    pad = plate = None
    if layer is not None:
        rims = [(MM * own.rim).round(6).tolist() for own in pad_outlines(layer, target)]
        pad = {"loops": rims, "bottom": MM * layer.standoff}
    if target is not None:
        loops = [(MM * np.array(loop)).round(6).tolist() for loop in target_outline(target).loops]
        plate = {"loops": loops, "thickness": MM * target.thickness}
    radius = None if sensor.substrate_radius is None else MM * sensor.substrate_radius
    return {
        "coils": coils, "pad": pad, "target": plate, "cover": _cover(sensor), "rest": rest, "substrate": radius,
        "fixed": [_fixed(part) for part in sensor.conductors],
    }


def _cover(sensor: Sensor) -> Record | None:
    """Return a cover, from above and over the target."""
    cover, layer, target = sensor.cover, sensor.elastomer, sensor.target
    if cover is None or layer is None or target is None:
        return None
    return {"loops": [(MM * np.array(cover.rim(target, layer))).round(6).tolist()], "thickness": MM * cover.thickness}


def _coil(coil: Coil) -> Record:
    """Return a coil: radii of its turns, or its tracks as polylines."""
    round_ = coil.is_round
    radii = (MM * turn_radii(coil)).round(6).tolist() if round_ else []
    lines = [] if round_ else [(MM * line).round(6).tolist() for line, _ in coil_lines(coil)]
    return {
        "name": coil.name, "centre": [MM * place for place in coil.centre], "width": MM * coil.track_width,
        "radii": radii, "lines": lines, "reach": MM * coil.outer_diameter / 2,
        "thickness": MM * coil.track_thickness, "heights": [round(MM * z, 6) for z in coil.heights],
    }


def _fixed(part: Conductor) -> Record:
    """Return a fixed plate."""
    loops, (low, high) = [(MM * rim).round(6).tolist() for rim in from_above(part)], part.span
    return {"name": part.name, "loops": loops, "low": MM * low, "high": MM * high}
