"""The command for the studio."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from sits_mech.cli.options import Models, app


@app.command
def studio(
    scene: Annotated[str, Parameter(help="Name in the catalogue or scene file.")] = "biorob2018-w15", *,
    port: Annotated[int, Parameter(help="Port of this machine; 0: a free one.")] = 0,
    browser: Annotated[bool, Parameter(help="Whether the browser opens.")] = True, models: Models = Models(),
) -> int:
    """Change a sensor by hand and see what it shows: a page on this machine alone.

    Sliders answer at once, by what tables and their slopes tell (orange, with what is left open); the solve follows
    behind (green). Nothing is written but what is downloaded. It needs sits-mech[studio], and ends with Ctrl-C.

    Example: sits-mech studio biorob2018-w15
    """
    from sits_mech.scene.sensor import load_sensor
    from sits_mech.units import SceneError

    load_sensor(scene)
    if not 0 <= port < 65536:
        raise SceneError(f"--port: must be from 0 to 65535; got {port}")
    try:
        from sits_mech.studio.page import serve
    except ModuleNotFoundError as error:
        raise SceneError(f"studio: must have {error.name}: pip install 'sits-mech[studio]'") from None
    serve(scene, (models.mechanics, models.magnetics, models.tolerance), port, browser=browser)
    return 0
