"""Show a sensor or a calibration in a notebook, and write the same as a file: no server, nothing solved.

What is shown is a page of its own within a frame, so that its scripts run and its style stays its own.
"""

from __future__ import annotations

import html
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

import xarray as xr

from sits_mech.analysis.readings.bench import readings
from sits_mech.arguments import checked_arguments
from sits_mech.inputs import unknown
from sits_mech.readout.crosstalk import crosstalk
from sits_mech.readout.loads import several
from sits_mech.report.folder import check_table
from sits_mech.report.page.explorer import RequiredLines, explorer, page_file
from sits_mech.report.page.parts import figures_part, scene_part, subtitle
from sits_mech.report.pictures.drawing import scene_drawing
from sits_mech.report.pictures.style import figure_bytes
from sits_mech.report.plots.curves import calibration_pictures
from sits_mech.scene.files import write_text
from sits_mech.scene.parts.cover import Cover
from sits_mech.scene.parts.elastomer import Elastomer
from sits_mech.scene.plausible import slips
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor, sensor_from
from sits_mech.units import shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FORMATS = ("svg", "png")
_FRAME = '<iframe title="{title}" srcdoc="{page}" style="width:100%;height:640px;border:0"></iframe>'


@dataclass(frozen=True, eq=False, repr=False)
class Shown:
    """A sensor, or a calibration of it, as `show` returns it."""

    sensor: Sensor
    data: xr.Dataset | None = None

    def __repr__(self) -> str:
        """Return what it is, in a line."""
        kind = "sensor" if self.data is None else f"calibration of {self.data['status'].size} loads"
        return f"<{kind}: {self.sensor.name}>"

    def _repr_html_(self) -> str:
        """Return the page in a frame, for a notebook."""
        return _FRAME.format(title=html.escape(self.sensor.name), page=html.escape(self.page()))

    def page(self) -> str:
        """Return what is shown as one HTML text."""
        words = _main_numbers(self.sensor) if self.data is None else subtitle(self.data)
        head = f'<h2>{html.escape(self.sensor.name)}</h2><p class="hint">{words}</p>'
        if self.data is None:
            return _page(self.sensor.name, head + _scene(self.sensor))
        return calibration_page(self.sensor, self.data, head)

    def save(self, path: str | Path) -> None:
        """Write the page to a file; raise SceneError where that cannot be."""
        if Path(path).suffix != ".html":
            raise SceneError(f"path: must end in .html; got {shown(str(path))}")
        write_text(Path(path), self.page())

    def pictures(self) -> tuple[str, ...]:
        """Return the names of the pictures that it has."""
        return tuple(self._drawn())

    def picture(self, name: str, format: str = "svg") -> bytes:
        """Return a picture as a file of a format, svg or png; raise SceneError for another one, or no matplotlib."""
        for key, value, known in (("name", name, self.pictures()), ("format", format, _FORMATS)):
            if value not in known:
                raise SceneError(f"{key}: {unknown(value, known)}")
        return figure_bytes(self._drawn()[name](), format)

    def _drawn(self) -> dict[str, Callable[[], Figure]]:
        """Return what draws each picture: plan and section, curves and crosstalk as far as the table has loads."""
        found: dict[str, Callable[[], Figure]] = {"drawing": partial(scene_drawing, self.sensor)}
        if self.data is None or not several(self.data):
            return found
        found |= calibration_pictures(self.data)
        if len(several(self.data)) < 2 or not crosstalk(self.data):
            del found["crosstalk"]
        return found


@checked_arguments
def show(what: Sensor | xr.Dataset | str | Path, sensor: Sensor | None = None) -> Shown:
    """Show a sensor or a calibration in a notebook, without a server; nothing is solved.

    Parameters
    ----------
    what : Sensor, str, Path or Dataset
        A sensor, or a scene as of `load_sensor`: plan and section with sizes, all numbers, those that are probably
        slips. A table of `calibrate`: its section and plan under a load that sliders move, maps, curves, errors,
        figures of merit.
    sensor : Sensor, optional
        That of a table that does not name its scene.

    Returns
    -------
    Shown
        Jupyter and marimo show it where it ends a cell. ``save("sensor.html")`` writes the page, one file that needs no
        other. ``pictures()`` names its pictures, ``picture("drawing", "svg")`` is one as bytes of SVG or PNG.

    Raises
    ------
    SceneError
        For anything else: a scene that cannot be read, a table of another kind or version, without a load that
        converged, or that is not of `sensor`.

    Examples
    --------
    >>> models = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sm.load_sensor("biorob2018"), F_x=[-0.2, 0.2], F_z=[0.0, 1.0], **models)
    >>> sm.show(data).pictures()
    ('drawing', 'L_v', 'L_h', 'crosstalk')
    >>> sm.show("biorob2018").picture("drawing", "png")[1:4]
    b'PNG'
    """
    if isinstance(what, xr.Dataset):
        return Shown(_sensor_of(what, sensor), what)
    if sensor is not None:
        raise SceneError(f"sensor: must be left out where no table is shown; got {shown(sensor.name)}")
    if isinstance(what, str | Path):
        return Shown(load_sensor(what))
    if not isinstance(what, Sensor):
        kind = type(what).__name__
        raise SceneError(f"what: must be a sensor, a scene's name or path, or a table of calibrate; got {kind}")
    return Shown(what)


def _sensor_of(data: xr.Dataset, sensor: Sensor | None) -> Sensor:
    """Return the sensor of a table, its own or the one that is given; refuse a table that is no calibration of it."""
    check_table(data, "what", "request")
    own = sensor_from(tomllib.loads(data.attrs["scene"])) if "scene" in data.attrs else None
    found, coils = sensor or own, list(map(str, data["coil"].to_numpy()))
    if found is None:
        raise SceneError("sensor: must be given for a table without the attribute scene; it is missing")
    if found != (own or found) or found.coil_names != coils:
        raise SceneError(f"sensor: must be that of the table, with coils {', '.join(coils)}; got {shown(found.name)}")
    return found


def calibration_page(
    sensor: Sensor, data: xr.Dataset, head: str = "", asked: RequiredLines | None = None, below: str | None = None
) -> str:
    """Return a calibration as one HTML text for a frame: below `head` the report's explorer, then figures of merit.

    What is asked for stands as lines in the explorer; `below` it something else may stand.
    """
    body, script = explorer(sensor, data, readings(sensor, data), asked)
    return _page(sensor.name, f"{head}{body}{merit(data) if below is None else below}", script)


def merit(data: xr.Dataset) -> str:
    """Return the figures of merit of a calibration as HTML."""
    return f"<h2>Figures of merit</h2>{figures_part(data)}"


def drawing(sensor: Sensor) -> str:
    """Return plan and section of a sensor with its sizes, as SVG within HTML."""
    text = Shown(sensor).picture("drawing").decode()
    return text[text.index("<svg") :]


def _scene(sensor: Sensor) -> str:
    """Return what is implausible, drawing and numbers of a sensor as HTML."""
    try:
        picture = f'<figure class="drawing">{drawing(sensor)}</figure>'
    except SceneError as error:  # without matplotlib
        picture = f"<p>{html.escape(str(error))}</p>"
    notes = "".join(f"<li>{html.escape(slip)}</li>" for slip in slips(sensor))
    numbers = f"<details><summary>all numbers</summary>{scene_part(sensor)}</details>"
    return f'<ul class="words">{notes}</ul>{picture}{numbers}'


def _main_numbers(sensor: Sensor) -> str:
    """Return what a sensor is in one line."""
    count, converter = len(sensor.coils), sensor.readout.converter
    found = [f"{sensor.frequency / 1e6:.6g} MHz", f"{count} coil{'s' if count > 1 else ''}"]
    for name, part in (("target", sensor.target), ("pad", sensor.elastomer), ("cover", sensor.cover)):
        if part is not None:
            made = part.words if isinstance(part, Elastomer | Cover) else part.material
            material = f" of {made}" if made else ""
            found.append(f"{name}{material}, {1e3 * part.thickness:.4g} mm thick")
    return html.escape(" · ".join([*found, *([] if converter == "none" else [converter])]))


def _page(title: str, body: str, script: str = "") -> str:
    """Return a page for a frame."""
    parts = {"css": page_file("page.css"), "title": html.escape(title), "body": body, "script": script}
    return Template(page_file("frame.html")).substitute(parts)
