"""Commands that solve one sensor: pose, inductance, simulate, envelope; cells of several targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from sits_mech.cli.console import (
    announcing,
    answer,
    deliver,
    deliver_picture,
    exit_code_of,
    kept_promise,
    solving,
    warn,
)
from sits_mech.cli.options import (
    Accept,
    Best,
    Frequency,
    Json,
    Load,
    Magnetics,
    Mechanics,
    Models,
    Output,
    Overrides,
    Picture,
    Place,
    Quantity,
    Ratio,
    Scene,
    Tolerance,
    Warmth,
    Warmths,
    Way,
    app,
    check_request,
    pose_of,
    sensor_of,
    sensors_of,
)
from sits_mech.cli.timed import through_history
from sits_mech.status import flags_of
from sits_mech.units import SceneError, frequency_range, quantity

if TYPE_CHECKING:
    from sits_mech.chain.cells.crosstalk import CellCrosstalk, CellTouch
    from sits_mech.quantities import Wrench
    from sits_mech.scene.cells import Cells
    from sits_mech.scene.sensor import Sensor


@app.command
def pose(
    scene: Scene, *, load: Load = Load(), way: Way = Way(), mechanics: Mechanics = "auto", tolerance: Tolerance = 1e-2,
    temperature: Warmth = None, accept: Accept = False, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """Displacement and rotation of the target under a load.

    Example: sits-mech pose biorob2018 --fx "0.5 N" --fz "2 N"
    """
    sensor, via = sensor_of(scene, overrides, temperature), way.loads()
    given = load.solved(sensor, mechanics, tolerance)
    loads = [*via, given.wrench]

    from sits_mech.chain.models import mechanical_model
    from sits_mech.chain.omitted.mechanical import mechanical_omissions, within_omissions
    from sits_mech.chain.plans.goal import rest_flags
    from sits_mech.chain.rests import at_rest
    from sits_mech.report.records import equilibrium_record, status_record
    from sits_mech.report.tables.plan import left_out_tables
    from sits_mech.report.tables.solves import equilibrium_table

    with solving(sensor, loads, tolerance, mechanics, None):
        layer, choice = mechanical_model(sensor, mechanics, tolerance, loads)
        left_out = mechanical_omissions(sensor, choice.name, loads[-1:], bent=choice.bent)
        layer = within_omissions(layer, choice, tolerance, left_out)
        found = at_rest(sensor, layer, loads[-1], left_out, via, known=given.found)
    flags = rest_flags(sensor, found, tolerance)
    tables = [equilibrium_table(found, flags=flags), *left_out_tables(left_out)]
    answer(equilibrium_record(found, left_out) | status_record(flags), tables, as_json)
    return exit_code_of(flags[:1], accept)


@app.command
def inductance(
    scene: Scene, *, place: Place = Place(), frequency: Frequency | None = None,
    magnetics: Magnetics = "auto", tolerance: Tolerance = 1e-3, temperature: Warmth = None, accept: Accept = False,
    overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """What the coils show with the target at a pose, or without a target, at one frequency or over a range.

    Example: sits-mech inductance biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 MHz"
    """
    from sits_mech.quantities import Pose, kept_report, report_of

    sensor = sensor_of(scene, overrides, temperature)
    pose = pose_of(place, overrides) if place.given or sensor.target is not None else Pose(0.0, 0.0, 0.0)
    check_request(sensor, {}, tolerance, magnetics=magnetics)
    hertz = [sensor.frequency] if frequency is None else frequency_range(frequency, "--frequency")

    from sits_mech.analysis.spectrum import at_terminals, spectrum
    from sits_mech.chain.models import magnetic_model
    from sits_mech.chain.plans.plan import POSE_GIVEN, magnetic_omissions
    from sits_mech.report.records import impedance_record, spectrum_record, status_record
    from sits_mech.report.tables.plan import left_out_tables
    from sits_mech.report.tables.solves import impedance_table, spectrum_table, terminal_table

    solver, choice = magnetic_model(sensor, magnetics, tolerance, [pose])
    slowest = sensor.model_copy(update={"frequency": min(hertz)})
    with announcing():
        data = spectrum(sensor, solver, pose, hertz) if len(hertz) > 1 else None
        found = solver.impedance(pose, min(hertz))
    found = replace(found, report=found.report.judged(tolerance))
    unsolved = (POSE_GIVEN, *magnetic_omissions(slowest, choice, (), (pose, found)))
    tables, names = left_out_tables(unsolved), sensor.coil_names
    report = found.report if data is None else report_of(data.attrs["report"]).judged(tolerance)
    bounded = not any(item.unbounded for item in found.report.left_out)
    flags = flags_of(report.estimated_error, tolerance, bounded=bounded)
    if data is None:
        seen, missing = at_terminals(sensor, found)
        tables = [impedance_table(names, found, flags), *tables, terminal_table(names, seen, missing)]
        record = impedance_record(pose, found, unsolved, seen, more=missing)
    else:
        data.attrs["report"] = kept_report(report)
        tables, record = [spectrum_table(data), *tables], spectrum_record(pose, data, unsolved)
    answer(record | status_record(flags), tables, as_json)
    return exit_code_of(flags[:1], accept)


@app.command
def simulate(
    scene: Scene, *, load: Load = Load(), way: Way = Way(), models: Models = Models(), temperature: Warmths = None,
    history: Annotated[Path | None, Parameter(help="CSV over time: t [s], F_z [N] or d_v [mm], ...")] = None,
    rcount: Annotated[int | None, Parameter(help="Reference count in a history; 65535 by default.")] = None,
    output: Output = None, picture: Picture = None, best: Best = True, accept: Accept = False,
    overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """What the sensor shows under a load, at one temperature or over a range (--picture draws the causes).

    With --history the load changes in time, and -o is a folder for the results.

    Example: sits-mech simulate biorob2018 --fx "0.5 N" --fz "2 N" --temperature "-10 degC:60 degC:8"
    """
    sensor, *others = sensors_of(scene, overrides, temperature)
    via = way.loads()
    check_request(sensor, {}, **asdict(models))
    if history is not None:
        if load != Load() or via or others or not best or picture is not None:
            raise SceneError("--history: must be given without a load, --via, --no-best, --picture or temperatures")
        return through_history(sensor, history, models, rcount, output, as_json, accept)
    if output is not None or rcount is not None:
        raise SceneError(f"{'-o' if output is not None else '--rcount'}: must come with --history; got no history")
    if others:
        wrench = load.wrench(sensor)
        check_request(sensor, vars(wrench), **asdict(models))
        return over_temperature([sensor, *others], wrench, via, models, best, picture, as_json, accept)
    if picture is not None:
        raise SceneError("--picture: needs a range of temperatures, --temperature \"first:last:count\"; got one")
    given = load.solved(sensor, models.mechanics, 0.5 * models.tolerance)
    wrench = given.wrench

    from sits_mech.analysis.spectrum import at_terminals
    from sits_mech.chain.models import Choice
    from sits_mech.chain.plans.plan import magnetic_omissions
    from sits_mech.chain.simulate import simulate as simulated
    from sits_mech.report.records import simulation_record
    from sits_mech.report.tables.plan import left_out_tables
    from sits_mech.report.tables.solves import equilibrium_table, impedance_table, signal_table

    with solving(sensor, [*via, wrench], **asdict(models)):
        found = simulated(sensor, given, via=via, best=best, **asdict(models))
    field, shown = Choice(found.impedance.report.model), (found.equilibrium.pose, found.impedance)
    unsolved = (*found.left_out, *magnetic_omissions(sensor, field, [*via, wrench], shown))
    tables = [
        equilibrium_table(found.equilibrium),
        impedance_table(sensor.coil_names, found.impedance),
        signal_table(found.signals, found.impedance.unit_L, found.flags),
        *left_out_tables(unsolved),
    ]
    answer(simulation_record(found, unsolved, at_terminals(sensor, found.impedance)[0]), tables, as_json)
    if found.promise is not None:
        planned, seconds, reached, off = found.promise
        warn(kept_promise((planned.seconds, planned.error), (seconds, reached), off))
    return exit_code_of(found.flags[:1], accept)


def over_temperature(
    sensors: Sequence[Sensor], wrench: Wrench, via: Sequence[Wrench], models: Models, best: bool,
    picture: Path | None, as_json: bool, accept: bool,
) -> int:
    """Answer what a sensor shows under one load at some temperatures."""
    from sits_mech.report.folder import checked_picture

    picture = picture and checked_picture(picture, "--picture")

    from sits_mech.chain.derivatives.temperature import relative_slopes
    from sits_mech.chain.simulate import simulate as simulated
    from sits_mech.report.tables.drift import drift_figure, temperatures_record, temperatures_table

    coils, T = sensors[0].coil_names, [sensor.temperature for sensor in sensors]
    middle = sensors[len(sensors) // 2]
    found = [simulated(sensor, wrench, via=via, best=best, **asdict(models)) for sensor in sensors]
    if picture is not None:  # before the answer: what fails here has none
        slopes = relative_slopes(middle, wrench, **asdict(models))
    answer(temperatures_record(T, found), [temperatures_table(coils, T, found)], as_json)
    deliver_picture(picture, lambda: drift_figure(coils, T, found, (middle.temperature, slopes)))
    return exit_code_of([each.status for each in found], accept)


@app.command
def envelope(
    scene: Scene, *, mechanics: Mechanics = "auto",
    tolerance: Annotated[Ratio, Parameter(help="Error of the pose that counts as a limit.")] = 0.05,
    rays: Annotated[int, Parameter(help="Rays in each plane of forces; a multiple of four.")] = 8,
    temperature: Warmth = None, output: Output = None, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """Which forces can the sensor carry, and what limits them: the silicone's data, contact, buckling?

    In the plane of F_x and F_z, and of F_y and F_z where coils stand apart along y; -o is a folder: picture, numbers.

    Example: sits-mech envelope biorob2018-w15 -o envelope
    """
    from sits_mech.analysis.envelope import envelope as found_envelope
    from sits_mech.cli.console import progress_bar
    from sits_mech.report.envelope import envelope_figure, envelope_record, envelope_table
    from sits_mech.report.folder import prepare_folder
    from sits_mech.report.pictures.style import save_figures
    from sits_mech.report.records import json_text
    from sits_mech.scene.files import write_text

    sensor = sensor_of(scene, overrides, temperature)
    check_request(sensor, {}, tolerance, mechanics)
    if rays < 4 or rays % 4:
        raise SceneError(f"--rays: must be a multiple of four; got {rays}")
    folder = None if output is None else prepare_folder(output, cases=False)
    with progress_bar("rays") as progress:
        found = found_envelope(sensor, tolerance=tolerance, mechanics=mechanics, rays=rays, progress=progress)
    record = envelope_record(found)
    answer(record, [envelope_table(found)], as_json)
    if folder is not None:
        write_text(folder / "envelope.json", json_text(record) + "\n")
        missed = save_figures(folder, {"envelope": partial(envelope_figure, found, sensor.name)})
        warn(*missed, f"written to {folder}")
    return 0


@app.command
def cells(
    scene: Scene, *, tolerance: Tolerance = 1e-2,
    load: Annotated[Quantity | None, Parameter(
        help="Force of the touch (default: touch.force); else of the press, and of --header, of finite strain (1 N)."
    )] = None,
    header: Annotated[Path | None, Parameter(help="C header to write: forces on cells by those that they read.")] =
    None, picture: Picture = None, accept: Accept = False, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """What does a cell read when its neighbour is pressed, or what do all of a [touch]: several [[targets]] on one pad.

    Of crosstalk --header writes sits_cell_forces(), which follows the sits_forces() of each cell (export --to c).

    Example: sits-mech cells fingertip.toml --set 'targets.B.centre.0="6 mm"' --picture cells.png
    """
    from sits_mech.report.folder import checked_file, checked_picture

    picture, header = picture and checked_picture(picture, "--picture"), header and checked_file(header, "--header")
    press = None if load is None else quantity(load, "N", "--load")

    from sits_mech.report.cells import cells_figure, cells_record, cells_tables
    from sits_mech.scene.cells import load_cells

    found = _solved_cells(load_cells(scene, overrides.all), tolerance, press, header)
    answer(cells_record(found), cells_tables(found), as_json)
    deliver_picture(picture, lambda: cells_figure(found))
    return exit_code_of(found.flags[:1], accept)


def _solved_cells(
    given: Cells, tolerance: float, press: float | None, header: Path | None
) -> CellCrosstalk | CellTouch:
    """Return what cells read, of the touch where there is one; write the header of their forces where it is wanted."""
    from sits_mech.chain.cells.crosstalk import cell_crosstalk, cell_touch
    from sits_mech.chain.cells.forces import cell_forces
    from sits_mech.export.cells import cells_header

    if given.touch is not None:
        if header is not None:
            raise SceneError("touch must be left out with --header; it is there")
        return cell_touch(given, tolerance, press)
    least = 1.0 if press is None else press
    if header is None:
        return cell_crosstalk(given, tolerance, least)
    found = cell_forces(given, tolerance, least)
    deliver(cells_header(found, given.sensor.name), header)
    return found.crosstalk
