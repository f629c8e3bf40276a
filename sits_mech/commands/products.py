"""What is made of a finished calibration? export, report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sits_mech.commands.options import Load, Output, app
from sits_mech.console import not_converged, warn

Folder = Annotated[Path, Parameter(help="Of a calibration: what was given to sits-mech calibrate -o.")]


@app.command
def export(
    folder: Folder, *, to: Annotated[str, Parameter(help="csv, netcdf, xlsx, c, spice, kicad or vtu.")],
    output: Output = None, load: Load = Load(),
) -> int:  # fmt: skip
    """Write a calibration for another program; --fx and --fz choose the state that --to spice shows.

    Example: sits-mech export calibration --to spice -o coils.cir --fz "2 N"
    """
    from sits_mech.export.formats import export as written
    from sits_mech.export.source import Source
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.folder import read_calibration

    sensor, data = read_calibration(folder)
    wrench = load.wrench()
    try:
        path, notes = written(Source(sensor, data, wrench.F_x, wrench.F_z), to, output)
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
    from sits_mech.report.html import write_html
    from sits_mech.sensor import SceneError

    path = folder / "report.html" if output is None else output
    if path.suffix not in (".html", ".htm"):
        raise SceneError(f"--output: must end in .html; got {path.name!r}")
    sensor, data = read_calibration(folder)
    write_html(sensor, data, folder, path)
    warn(f"written to {path}")
    return 0
