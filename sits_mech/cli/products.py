"""What can be looked at, or handed on? view, and of a finished calibration export and report."""

from __future__ import annotations

from typing import Annotated, Literal

from cyclopts import Parameter

from sits_mech.cli.console import not_converged, warn
from sits_mech.cli.options import Folder, Load, Output, Overrides, Place, Quantity, Scene, app, sensor_of


@app.command
def view(
    scene: Scene, *, load: Load = Load(), place: Place = Place(),
    kind: Literal["scene", "layer", "field", "spatial"] | None = None,
    driven: Annotated[str | None, Parameter(help="Name of the coil that carries current; the last one.")] = None,
    frequency: Quantity | None = None, output: Output = None,
    overrides: Overrides = Overrides(),
) -> int:  # fmt: skip
    """Draw a scene with its sizes (--kind scene), its layer under a load, the field at a pose, or both in space.

    Example: sits-mech view biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 kHz" --kind field -o field.png
    """
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.pictures.request import Request, draw, kind_of_picture, picture_path
    from sits_mech.units import quantity

    sensor, pose = sensor_of(scene, overrides), place.pose() if place.given else None
    kind = kind_of_picture(kind, load.wrench(), pose)
    path = picture_path(output, scene, kind)
    hertz = sensor.frequency if frequency is None else quantity(frequency, "Hz", "--frequency")
    try:
        draw(kind, sensor, Request(load.wrench(), pose, hertz, driven), path)
    except SolveFailed as error:
        return not_converged(error, False)
    warn(f"written to {path}")
    return 0


@app.command
def export(
    folder: Folder, *, to: Annotated[str, Parameter(help="csv, netcdf, xlsx, c, spice, kicad or vtu.")],
    output: Output = None, load: Load = Load(),
) -> int:  # fmt: skip
    """Write a calibration for another program; the load chooses the state that --to spice shows.

    kicad writes a footprint in the format of KiCad 7, for that version or later; vtu writes a folder for ParaView.

    Example: sits-mech export calibration --to spice -o coils.cir --fz "2 N"
    """
    from sits_mech.export.formats import export as written
    from sits_mech.export.source import Source
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.folder import read_calibration

    sensor, data = read_calibration(folder)
    try:
        path, notes = written(Source(sensor, data, load.wrench()), to, output)
    except SolveFailed as error:
        return not_converged(error, False)
    for line in [*notes, f"written to {path}"]:
        warn(line)
    return 0


@app.command
def report(folder: Folder, *, output: Output = None) -> int:
    """Write a calibration as one HTML file with an explorer; it needs no network.

    Example: sits-mech report calibration -o report.html
    """
    from sits_mech.report.folder import read_calibration
    from sits_mech.report.page.html import write_html
    from sits_mech.scene.sensor import SceneError

    path = folder / "report.html" if output is None else output
    if path.suffix not in (".html", ".htm"):
        raise SceneError(f"--output: must end in .html; got {path.name!r}")
    sensor, data = read_calibration(folder)
    write_html(sensor, data, folder, path)
    warn(f"written to {path}")
    return 0
