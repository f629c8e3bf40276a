"""What does it look like? view."""

from __future__ import annotations

from typing import Annotated, Literal

from cyclopts import Parameter

from sits_mech.commands.options import Load, Output, Overrides, Place, Quantity, Scene, app, sensor_of
from sits_mech.console import not_converged, warn


@app.command
def view(
    scene: Scene, *, load: Load = Load(), place: Place = Place(),
    kind: Literal["field", "layer", "spatial"] | None = None,
    driven: Annotated[str | None, Parameter(help="Name of the coil that carries current; the last one.")] = None,
    frequency: Quantity | None = None, output: Output = None,
    overrides: Overrides = (),
) -> int:  # fmt: skip
    """Draw the deformed layer, the field around a pose, or coils, target and eddy currents in space.

    Example: sits-mech view biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 kHz" --kind field -o field.png
    """
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.pictures import Request, draw, kind_of_picture, picture_path
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
