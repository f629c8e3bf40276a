"""What the studio shows and hands out of a view: the explorer with what is required, what it took, files, pictures."""

from __future__ import annotations

import numpy as np
import xarray as xr

from sits_mech.report.page.html import page as report_page
from sits_mech.report.shown import Shown, calibration_page, merit
from sits_mech.report.tables.loads import csv_text
from sits_mech.scene.sensor import SceneError, scene_text
from sits_mech.studio.asked import lines, rows_html
from sits_mech.studio.session import View


def frame(view: View, data: xr.Dataset) -> str:
    """Return the page of a view's table, as the report's explorer shows it, with what is required.

    Figures of merit take three times as long as the rest, and wait for a solved one.
    """
    asked, below = None, ""
    if view.judged is not None:
        asked, below = lines(view.judged, view.sensor, data), f"<h2>Required</h2>{rows_html(view.judged)}"
    return calibration_page(view.sensor, data, "", asked, below + (merit(data) if view.kind == "solved" else ""))


def pictures(view: View) -> tuple[str, ...]:
    """Return the names of the pictures that a view has, as files: of a solved table its curves too."""
    names = Shown(view.sensor, view.data if view.kind == "solved" else None).pictures()
    return tuple(f"{name}.{format}" for name in names for format in ("svg", "png"))


def cost(data: xr.Dataset) -> str:
    """Return in words what a table took, beside what was planned; nothing where neither is known."""
    took, planned = float(np.nansum(data["seconds"])) if "seconds" in data else 0.0, data.attrs.get("planned")
    words = "" if planned is None else f", planned {float(planned[0]):.2g} s"
    return f"; took {took:.2g} s{words}" if took else ""


def file_of(view: View, name: str) -> bytes:
    """Return a file of what is shown, by its name; SceneError where a table must be solved for it."""
    if name == "scene.toml":
        return scene_text(view.sensor).encode()
    if name in pictures(view):
        stem, _, format = name.rpartition(".")
        return Shown(view.sensor, view.data if view.kind == "solved" else None).picture(stem, format)
    if view.data is None or view.kind != "solved":
        raise SceneError(f"{name}: must be of a solved table; this one is a {view.kind}")
    if name == "table.csv":
        return csv_text(view.data).encode()
    return report_page(view.sensor, view.data).encode()
