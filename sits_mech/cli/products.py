"""Commands that draw, import, design or hand on: view, import, design, studio; of a calibration export, report."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sits_mech.cli.console import answer, deliver, deliver_picture, print_written, progress_bar, warn
from sits_mech.cli.options import (
    Case,
    Folder,
    Json,
    Load,
    Models,
    Output,
    Overrides,
    Place,
    Quantity,
    Scene,
    app,
    check_readable,
    check_request,
    flag,
    output_of,
    pose_of,
    sensor_of,
)
from sits_mech.units import SceneError, quantity

_FIRST = "biorob2018-w15"  # that the studio opens


@app.command
def view(
    scene: Scene, *, load: Load = Load(), place: Place = Place(),
    kind: Literal["scene", "layer", "field", "spatial"] | None = None,
    driven: Annotated[str | None, Parameter(help="Coil that carries current; by default the last.")] = None,
    frequency: Annotated[Quantity | None, Parameter(help="By default the scene's.")] = None,
    show: Annotated[Literal["displacement", "stretch"] | None, Parameter(name="--show", help="Colours of a layer.")] =
    None, output: Output = None, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """Draw a scene with its sizes (--kind scene), its layer under a load, the field at a pose, or both in space.

    Example: sits-mech view biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 kHz" --kind field -o field.png
    """
    from sits_mech.report.folder import checked_picture
    from sits_mech.report.pictures.request import PictureSettings, check_options, draw, driven_coil, kind_of_picture

    sensor, pose = sensor_of(scene, overrides), pose_of(place, overrides) if place.given else None
    kind = kind_of_picture(kind, load.wrench(), pose)
    path, coil = checked_picture(output or Path(f"{Path(scene).stem}-{kind}.png")), driven_coil(sensor, driven)
    check_options(kind, show=show, frequency=frequency, driven=driven)
    hertz = sensor.frequency if frequency is None else quantity(frequency, "Hz", "--frequency")

    drawn = load.wrench() if kind == "scene" or pose is not None else load.solved(sensor, rough=True).wrench
    draw(kind, sensor, PictureSettings(drawn, pose, hertz, coil, show or "displacement"), path)
    print_written([path], as_json)
    return 0


@app.command(name="import")
def import_board(
    board: Annotated[Path, Parameter(help="A .kicad_pcb file of KiCad 5 or later.")], *,
    net: Annotated[tuple[str, ...], Parameter(negative="", help="Net whose tracks are a coil; once per coil.")] = (),
    footprint: Annotated[tuple[str, ...], Parameter(negative="", help="Reference of a footprint that is a coil.")] = (),
    at: Annotated[
        tuple[str, ...], Parameter(negative="", help="Place on a coil as KiCad shows it: X,Y or X,Y,LAYER, in mm.")
    ] = (),
    frequency: Annotated[Quantity, Parameter(help="Frequency of the scene.")] = "5 MHz",
    origin: Annotated[Literal["coil", "board"], Parameter(help="At the middle of the coils, or the board's.")] = "coil",
    chord_error: Annotated[Quantity, Parameter(help="Largest error of polylines for arcs.")] = "1 um",
    pours: Annotated[bool, Parameter(help="Take filled zones of other nets as conductors.")] = True,
    output: Output = None,
) -> int:
    """Read coils and copper pours of a KiCad board into a scene, on stdout without -o.

    Without --net, --footprint and --at it lists what looks like a coil, and how to take each; -o coils.png draws them.

    Example: sits-mech import probe.kicad_pcb --net L1 --frequency "2 MHz" -o probe.toml
    """
    from sits_mech.boards.scene import Selection, board_scene

    hertz, error = quantity(frequency, "Hz", "--frequency"), quantity(chord_error, "m", "--chord-error")
    if not (net or footprint or at):
        return _list_coils(board, output)
    text, notes = board_scene(board, Selection(net, footprint, at, hertz, origin, error, pours))
    warn(*notes)
    deliver(text, output)
    return 0


def _list_coils(path: Path, output: Path | None) -> int:
    """Print what looks like a coil on a board; draw it where a picture is asked for."""
    from sits_mech.boards.kicad import read_board
    from sits_mech.boards.windings import hint, windings
    from sits_mech.report.folder import checked_picture
    from sits_mech.report.plots.board import board_figure, listed, winding_table

    board = read_board(path)
    found = windings(board)
    if output is not None and output.suffix == ".toml" or not found:
        raise SceneError(f"--net, --footprint or --at: {board.name}: must name a coil; it is missing; {hint(board)}")
    output = output and checked_picture(output)
    coils = listed(board, found)
    answer({}, [winding_table(board, coils)], False)
    warn(*board.notes)
    deliver_picture(output, lambda: board_figure(board, coils))
    return 0


@app.command
def export(
    folder: Folder, *,
    to: Annotated[str, Parameter(help="csv, netcdf, xlsx, c, spice, kicad, vtu, twin, page, pdf, svg or a plug-in.")],
    output: Output = None, load: Load = Load(), as_json: Json = False,
) -> int:
    """Write a calibration for another program; the load chooses the state that --to spice shows.

    kicad writes a footprint in the format of KiCad 7, for that version or later; vtu writes a folder for ParaView,
    twin a folder for robots and firmware (numbers, an evaluator for numpy and one in C99, a pad for MuJoCo), page one
    HTML file in which forces are dragged and codes follow, pdf and svg a folder of the calibration's pictures.

    Example: sits-mech export calibration --to spice -o coils.cir --fz "2 N"
    """
    from sits_mech.export.formats import export_path, format_of
    from sits_mech.readout.loads import check_enough
    from sits_mech.report.folder import look_at, read_calibration

    sensor, forces = look_at(folder)
    form, path = format_of(to), export_path(sensor, to, output)
    if load != Load() and not form.at_load:
        raise SceneError(f"--to {to}: must have no load: it writes the whole table")
    if form.inverts:
        check_enough(sensor.coils, forces)
    sensor, data = read_calibration(folder)

    from sits_mech.export.source import Source

    print_written([path], as_json, form.write(Source(sensor, data, load.wrench(sensor)), path))
    return 0


@app.command
def design(
    requirements: Annotated[Path, Parameter(help="Requirement file: scene, loads, vary, require, tolerance, goal.")], *,
    output: Annotated[Path | None, output_of("Folder for the answer and solved designs; without --plan.")] = None,
    plan: Annotated[bool, flag("Tell designs to solve, seconds, and what is left out; solve none.")] = False,
    preview: Annotated[bool, flag("Answer by what three solved designs predict; they are kept.")] = False,
    most: Annotated[int, Parameter(help="Largest number of designs to solve.")] = 60,
    processes: Annotated[int, Parameter(name=["--processes", "-j"], help="Processes for the first designs.")] = 1,
    as_json: Json = False,
) -> int:
    """Find a sensor for requirements: which thickness, silicone, target, coils; a stopped run is resumed.

    Example: sits-mech design requirements.toml -o fingertip
    """
    check_readable(requirements, "a readable requirement file")

    from sits_mech.batch.executors import workers
    from sits_mech.report.design import write_design
    from sits_mech.report.folder import cases_folder, prepare_folder
    from sits_mech.report.tables.design import (
        design_plan_tables,
        design_record,
        design_tables,
        preview_record,
        preview_table,
    )
    from sits_mech.synthesis.bounds import plan_of
    from sits_mech.synthesis.required.requirements import read_requirements
    from sits_mech.synthesis.run import check_most, previewed
    from sits_mech.synthesis.run import design as designed

    asked = read_requirements(requirements)
    check_most(most)
    if plan:
        planned = plan_of(asked)
        answer(asdict(planned), design_plan_tables(planned), as_json)
        return 0
    if output is None:
        raise SceneError("--output: must be a folder for the answer and solved designs; it is missing")
    if preview:
        with progress_bar("designs") as progress:
            seen = previewed(asked, folder=cases_folder(prepare_folder(output)), report=_reporter(progress))
        answer(preview_record(seen), [preview_table(seen)], as_json)
        return 0
    with workers(processes) as executor, progress_bar("designs") as progress:
        cases = cases_folder(prepare_folder(output))
        found = designed(asked, folder=cases, most=most, report=_reporter(progress), executor=executor)
    missed = write_design(asked, found, output)
    answer(design_record(found), design_tables(asked, found), as_json)
    warn(*found.notes, *missed, f"written to {output}")
    return 0 if found.feasible else 3


def _reporter(progress: Callable[[int, int], None]) -> Callable[[int, int, str], None]:
    """Return what moves a bar on a terminal, and writes a line for each solved design elsewhere."""

    def report(done: int, all_: int, words: str) -> None:
        """Tell of a solved design."""
        progress(done, all_)
        if not sys.stderr.isatty():
            warn(f"{done} of about {all_}: {words}")

    return report


@app.command
def report(folder: Folder, *, case: Case = None, output: Output = None, as_json: Json = False) -> int:
    """Write a calibration, a sweep, or one case of a sweep of calibrations, as one HTML file; it needs no network.

    Of a sweep: parallel coordinates, slices over two keys, and failed cases with commands that repeat each alone.

    Example: sits-mech report calibration -o report.html
    """
    from sits_mech.report.folder import is_sweep, read_calibration
    from sits_mech.scene.files import is_open_end, write_text
    from sits_mech.scene.sensor import SceneError

    own = "report.html" if case is None else f"report-{case}.html"
    path = folder / own if output is None else output
    if path.suffix not in (".html", ".htm") and not is_open_end(path):
        raise SceneError(f"--output: must end in .html; got {path.name!r}")
    if case is None and is_sweep(folder):
        from sits_mech.report.page.sweep import write_sweep

        scenes = [f"scene of failed cases written to {scene}" for scene in write_sweep(folder, path)]
        print_written([path], as_json, scenes)
        return 0
    sensor, data = read_calibration(folder, case)

    from sits_mech.report.page.html import page

    write_text(path, page(sensor, data, folder))
    print_written([path], as_json)
    return 0


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
    from sits_mech.scene.files import read_toml
    from sits_mech.scene.sensor import load_sensor

    text = ""
    if required is not None:
        check_readable(required, "a readable requirement file")

        from sits_mech.synthesis.required.requirements import read_requirements

        read_requirements(required)
        text, named = required.read_text(encoding="utf-8"), str(read_toml(required)["scene"])
        neighbour = required.parent / named
        scene = scene or (str(neighbour) if neighbour.is_file() else named)
    scene = scene or _FIRST
    design = Path(scene) / "recommended.toml"
    source = str(design) if design.is_file() else scene
    check_request(load_sensor(source), {}, **asdict(models))
    if not 0 <= port < 65536:
        raise SceneError(f"--port: must be from 0 to 65535; got {port}")
    try:
        from sits_mech.studio.page import serve
    except ModuleNotFoundError as error:
        raise SceneError(f"studio: must have {error.name}: pip install '.[studio]' in a clone") from None
    serve(source, (models.mechanics, models.magnetics, models.tolerance), port, browser=browser, required=text)
    return 0
