"""Write the result of a design search to a folder: scenes of the recommended design and the front, table, page."""

from __future__ import annotations

import html
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.labels import labelled
from sits_mech.quantities import Wrench
from sits_mech.report.page.html import page_of
from sits_mech.report.page.parts import html_table, pictures_part
from sits_mech.report.pictures.section import load_view
from sits_mech.report.pictures.style import save_figures
from sits_mech.report.plots.design import choice_words, design_pictures
from sits_mech.report.records import json_text
from sits_mech.report.tables.design import asked_table, design_record, design_tables
from sits_mech.report.tables.solves import key_table
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import Sensor, save_sensor, scene_text
from sits_mech.store import save_table
from sits_mech.synthesis.answer import DesignAnswer
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.solved.answered import Answered
from sits_mech.version import __version__

_CAPTIONS = {
    "front": "Every design that was solved; filled marks hold all limits, dashed lines are limits; numbers are of the "
    "front's scenes in the folder front/; bars are estimated errors.",
    "landscape": "What is minimised around the recommended design, the star, by predictions through the solved "
    "designs, the dots; shaded where every limit holds; nothing is shown far from what was solved.",
    "limits": "Each figure over its limit, with its estimated error; share of the sensors made that hold each limit.",
    "worst_load": "The recommended layer under its largest load, in a section along it.",
}
_MEANINGS = {
    "resolution": "one standard deviation of a reading, at the load where it is largest.",
    "error": "largest misreading over the loads, of the range, that the asked share of the sensors made stays below, "
    "after each is tared and reads one known load of each component.",
    "drift": "of zero of a reading with the temperature of all parts, where it is not tared.",
    "crosstalk before the inverse": "what another component feigns at most in the best linear readout, of the range.",
    "strain": "largest stretch of the silicone less one, under the overload, of that in the data behind its constants.",
    "one load for each reading": "1 where the coils tell the loads as evenly everywhere as in the middle, not above 0 "
    "where two loads show the same.",
    "yield": "share of the sensors made, scattering by the tolerances, that hold every limit.",
    "within its error": "the figure is nearer to its limit than it is known: whether the limit holds is open.",
}
"""What a reader must know of the figures."""


def write_design(asked: Requirements, found: DesignAnswer, folder: Path) -> list[str]:
    """Write a search's result to an existing folder; return what could not be written; raise SceneError."""
    sensor = named_sensor(asked, found.best, "recommended")
    save_sensor(sensor, folder / "recommended.toml")
    (folder / "front").mkdir(exist_ok=True)
    for number, each in enumerate(found.front, 1):
        save_sensor(named_sensor(asked, each, f"front {number}"), folder / "front" / f"{number:02d}.toml")
    data = design_table(asked, found)
    save_table(data, folder / "designs.nc")
    data.to_dataframe().to_csv(folder / "designs.csv", index=False)
    write_text(folder / "answer.json", json_text(design_record(found)))
    pictures = design_pictures(asked, found) | {"worst_load": partial(load_view, sensor, worst_load(asked))}
    missed = save_figures(folder, pictures)
    write_text(folder / "report.html", design_page(asked, found, sensor, folder))
    return missed


def named_sensor(asked: Requirements, found: Answered, words: str) -> Sensor:
    """Return the sensor of a design under a name that says what it is."""
    sensor = asked.space.sensor(found.design)
    return sensor.model_copy(update={"name": f"{sensor.name}, {words}: {asked.space.words(found.design)}"})


def worst_load(asked: Requirements) -> Wrench:
    """Return the corner of the loads, in the plane, that is the largest."""
    plane = {name: pair for name, pair in asked.loads.items() if name in ("F_x", "F_z", "M")} or {"F_z": (0.0, 0.0)}
    corners = [dict(zip(plane, each, strict=True)) for each in product(*plane.values())]
    return Wrench(**max(corners, key=lambda load: sum(abs(value) for value in load.values())))


def design_table(asked: Requirements, found: DesignAnswer) -> xr.Dataset:
    """Return all solved designs: their values, figures in SI with errors, and the reasons of missing figures."""
    rows = [found.best, *found.known]
    figures = [found.task.figures(each) if each.carried else each.plain for each in rows]
    columns: dict[str, Any] = {}
    for key in asked.space.values(found.best.design):
        columns[key] = [str(asked.space.values(each.design)[key]) for each in rows]
    for name in dict.fromkeys(name for own in figures for name in own):
        columns[name] = [own.get(name, np.nan) for own in figures]
        columns[f"error_{name}"] = [each.error.get(name, np.nan) for each in rows]
    columns["reason"] = [each.reason for each in rows]
    columns["choice"] = [choice_words(asked, each.design.choice) for each in rows]
    columns["seconds"] = [each.seconds for each in rows]
    attributes = {"scene": asked.scene, "requirements": asked.identity, "version": __version__}
    return labelled(xr.Dataset({name: ("design", values) for name, values in columns.items()}, attrs=attributes))


def design_page(asked: Requirements, found: DesignAnswer, sensor: Sensor, folder: Path) -> str:
    """Return the answer as one HTML text, its pictures inside."""
    asked_for = html_table(asked_table(asked))
    meanings = html_table(key_table("what the figures mean", list(_MEANINGS.items())))
    sections = [
        ("answer", "Recommended" if found.feasible else "Nearest design", _tables(asked, found)),
        ("pictures", "Pictures", pictures_part(folder, _CAPTIONS)),
        ("asked", "Asked", f"{asked_for}<h3>what the figures mean</h3>{meanings}"),
        ("scene", "Scene", f"<pre>{html.escape(scene_text(sensor))}</pre>"),
    ]
    subtitle = html.escape(f"{found.solves} designs solved; {found.verdict}")
    return page_of(sensor.name, sections, subtitle=subtitle, tiles="", script="")


def _tables(asked: Requirements, found: DesignAnswer) -> str:
    """Return the tables and notes of a result."""
    every = design_tables(asked, found)
    tables = "\n".join(f"<h3>{html.escape(str(each.title))}</h3>{html_table(each)}" for each in every)
    notes = "".join(f"<li>{html.escape(line)}</li>" for line in found.notes)
    return f"{tables}<ul class='words'>{notes}</ul>"
