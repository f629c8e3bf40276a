"""The command for the studio."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sits_mech.cli.options import Models, app, check_readable

_FIRST = "biorob2018-w15"


@app.command
def studio(
    scene: Annotated[
        str | None, Parameter(help=f"Name in the catalogue, scene file or folder of a design; {_FIRST} by default.")
    ] = None, *,
    required: Annotated[Path | None, Parameter(help="Requirement file, as of design: limits beside figures.")] = None,
    port: Annotated[int, Parameter(help="Port of this machine; 0: a free one.")] = 0,
    browser: Annotated[bool, Parameter(help="Whether the browser opens.")] = True, models: Models = Models(),
) -> int:
    """Change a sensor by hand and see what it shows: a page on this machine alone.

    Sliders answer at once, by what tables and their slopes tell (orange, with what is left open); the solve follows
    behind (green). Requirements stand as lines over the curves; "find" searches the sensor that holds them best.
    Nothing is written but what is downloaded. It needs sits-mech[studio], and ends with Ctrl-C.

    Example: sits-mech studio biorob2018-w15
    """
    from sits_mech.scene.files import read_table
    from sits_mech.scene.sensor import load_sensor
    from sits_mech.units import SceneError

    text = ""
    if required is not None:
        check_readable(required, "a readable requirement file")

        from sits_mech.synthesis.requirements import read_requirements

        read_requirements(required)
        text, named = required.read_text(encoding="utf-8"), str(read_table(required)["scene"])
        beside = required.parent / named
        scene = scene or (str(beside) if beside.is_file() else named)
    scene = scene or _FIRST
    design = Path(scene) / "recommended.toml"
    source = str(design) if design.is_file() else scene
    load_sensor(source)
    if not 0 <= port < 65536:
        raise SceneError(f"--port: must be from 0 to 65535; got {port}")
    try:
        from sits_mech.studio.page import serve
    except ModuleNotFoundError as error:
        raise SceneError(f"studio: must have {error.name}: pip install 'sits-mech[studio]'") from None
    serve(source, (models.mechanics, models.magnetics, models.tolerance), port, browser=browser, required=text)
    return 0
