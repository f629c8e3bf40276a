"""Write a calibration as one HTML file: explorer, figures, pictures, tables, warnings.

The file holds everything: style, script, pictures, the table. It needs no network and opens from a disk. Its layout
stands beside this file; the text of each section is made in `parts`, the explorer in `explorer`.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from string import Template

import xarray as xr

from sits_mech.analysis.readings.bench import Readings, readings
from sits_mech.readout.loads import varied
from sits_mech.report.page.explorer import explorer, page_file
from sits_mech.report.page.parts import (
    PICTURES,
    computed_part,
    figures_part,
    inverse_part,
    limits_part,
    loads_part,
    pictures_part,
    readout_part,
    scene_part,
    subtitle,
    tiles,
    words_part,
)
from sits_mech.scene.sensor import Sensor
from sits_mech.version import __version__

_NAMES = {"inverse": "Forces back", "figures": "Figures", "limits": "Limits", "how": "How computed"}  # to jump to


def page(sensor: Sensor, data: xr.Dataset, folder: Path | None = None) -> str:
    """Return the report of a calibration as one HTML text, without a folder without pictures."""
    read = readings(sensor, data)
    sections, script = _sections(sensor, data, folder, read), ""
    if varied(data):
        markup, script = explorer(sensor, data, read)
        sections = [("explorer", "Explorer", markup), *sections]
    units = " SI units; x and y are shear, F_z presses down, alpha turns the right edge down."
    return page_of(sensor.name, sections, units, subtitle=subtitle(data), tiles=tiles(data, read), script=script)


def page_of(
    title: str, sections: Sequence[tuple[str, str, str]], footer: str = "", style: str = "", **parts: str
) -> str:
    """Return a page of sections, each with its name, title and HTML; `parts` are the others of page.html.

    `style` follows the style of all pages; a single section has no link.
    """
    links = (f'<a href="#{name}">{_NAMES.get(name, heading)}</a>' for name, heading, _ in sections)
    nav = "".join(links) if len(sections) > 1 else ""
    texts = (f'<section id="{name}"><h2>{heading}</h2>{text}</section>' for name, heading, text in sections)
    return Template(page_file("page.html")).substitute(
        title=html.escape(title), nav=nav, sections="\n".join(texts), css=page_file("page.css") + style,
        footer=f"Made by sits-mech {html.escape(__version__)}.{footer}", **parts,
    )


def _sections(sensor: Sensor, data: xr.Dataset, folder: Path | None, read: Readings) -> list[tuple[str, str, str]]:
    """Return name, title and HTML of each section below the explorer."""
    return [
        ("words", "In plain words", f'<ul class="words">{words_part(sensor, data, read)}</ul>'),
        ("figures", "Figures of merit", figures_part(data)),
        *([] if folder is None else [("pictures", "Pictures", pictures_part(folder, PICTURES))]),
        ("readout", "Readout", readout_part(sensor, read)),
        ("inverse", "Forces back from inductances", inverse_part(sensor, data, read)),
        ("limits", "Limits of the pad", limits_part(sensor, data)),
        ("loads", "Loads", loads_part(data)),
        ("scene", "Scene", scene_part(sensor)),
        ("how", "How it was computed", computed_part(data)),
    ]
