"""Where does the target go, what do the coils show? pose, inductance, simulate, cycle."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from sits_mech.cli.console import answer, not_converged, progress_bar, warn
from sits_mech.cli.options import (
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
    Scene,
    Tolerance,
    Way,
    app,
    pose_of,
    sensor_of,
)  # fmt: skip

if TYPE_CHECKING:
    from sits_mech.scene.sensor import Sensor


@app.command
def pose(
    scene: Scene, *, load: Load = Load(), way: Way = Way(), mechanics: Mechanics = "auto", tolerance: Tolerance = 1e-2,
    overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:  # fmt: skip
    """Where the target comes to rest under a load.

    Example: sits-mech pose biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech.chain.models import mechanical_model
    from sits_mech.chain.omissions import omissions
    from sits_mech.chain.simulate import at_rest
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import equilibrium_record
    from sits_mech.report.tables.plan import left_out_tables
    from sits_mech.report.tables.solves import equilibrium_table

    sensor, via = sensor_of(scene, overrides), way.loads()
    loads = [*via, load.wrench()]
    layer, choice = mechanical_model(sensor, mechanics, tolerance, loads)
    try:
        found = at_rest(sensor, layer, loads[-1], via)
    except SolveFailed as error:
        return not_converged(error, as_json)
    unsolved = omissions(sensor, loads, choice.name, None)
    answer(equilibrium_record(found, unsolved), [equilibrium_table(found), *left_out_tables(unsolved)], as_json)
    return 0


@app.command
def inductance(
    scene: Scene, *, place: Place = Place(), frequency: Frequency | None = None,
    magnetics: Magnetics = "auto", tolerance: Tolerance = 1e-3, overrides: Overrides = Overrides(),
    as_json: Json = False,
) -> int:  # fmt: skip
    """What the coils show with the target at a pose, or without a target, at one frequency or over a range.

    Example: sits-mech inductance biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 MHz"
    """
    from sits_mech.analysis.spectrum import at_terminals, frequency_range, spectrum
    from sits_mech.chain.models import magnetic_model
    from sits_mech.chain.omissions import Shown, omissions
    from sits_mech.quantities import Pose, SolveFailed
    from sits_mech.report.records import impedance_record, spectrum_record
    from sits_mech.report.tables.plan import left_out_tables
    from sits_mech.report.tables.solves import impedance_table, spectrum_table, terminal_table

    sensor = sensor_of(scene, overrides)
    pose = pose_of(place, overrides) if place.given or sensor.target is not None else Pose(0.0, 0.0, 0.0)
    hertz = [sensor.frequency] if frequency is None else frequency_range(frequency, "--frequency")
    solver, choice = magnetic_model(sensor, magnetics, tolerance, [pose])
    slowest = sensor.model_copy(update={"frequency": min(hertz)})
    try:
        data = spectrum(sensor, solver, pose, hertz) if len(hertz) > 1 else None
        found = solver.impedance(pose, min(hertz))
    except SolveFailed as error:
        return not_converged(error, as_json)
    unsolved = omissions(slowest, (), None, choice.name, Shown(pose, found), not choice.by_name)
    beside = left_out_tables(unsolved)
    if data is not None:
        answer(spectrum_record(pose, data, unsolved), [spectrum_table(data), *beside], as_json)
        return 0
    seen, missing = at_terminals(sensor, found)
    names = [coil.name for coil in sensor.coils]
    tables = [impedance_table(names, found), *beside, terminal_table(names, seen, missing)]
    answer(impedance_record(pose, found, unsolved, seen, more=missing), tables, as_json)
    return 0


@app.command
def simulate(
    scene: Scene, *, load: Load = Load(), way: Way = Way(), models: Models = Models(),
    history: Annotated[Path | None, Parameter(help="CSV of loads over time: t [s], F_z [N], ...")] = None,
    output: Output = None, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:  # fmt: skip
    """What the sensor shows under a load, or with --history under one that changes in time; -o is its folder.

    Example: sits-mech simulate biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech.chain.omissions import Shown, omissions
    from sits_mech.chain.simulate import simulate as simulated
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import simulation_record
    from sits_mech.report.tables.plan import left_out_tables
    from sits_mech.report.tables.solves import equilibrium_table, impedance_table, signal_table
    from sits_mech.units import SceneError

    sensor, wrench = sensor_of(scene, overrides), load.wrench()
    via = way.loads()
    if history is not None:
        if load != Load() or via:
            raise SceneError("--history: must be given alone; got a load or --via beside it")
        return _in_time(sensor, history, models, output, as_json)
    if output is not None:
        raise SceneError("-o: must come with --history, whose folder it is; got no history")
    try:
        found = simulated(sensor, wrench, via=via, **asdict(models))
    except SolveFailed as error:
        return not_converged(error, as_json, True)
    shown, names = found.impedance, (found.equilibrium.report.model, found.impedance.report.model)
    unsolved = omissions(sensor, [*via, wrench], *names, Shown(found.equilibrium.pose, shown))
    tables = [
        equilibrium_table(found.equilibrium),
        impedance_table([coil.name for coil in sensor.coils], found.impedance),
        signal_table(found.signals, found.impedance.unit_L),
        *left_out_tables(unsolved),
    ]
    answer(simulation_record(found, unsolved), tables, as_json)
    return 0


def _in_time(sensor: Sensor, path: Path, models: Models, output: Path | None, as_json: bool) -> int:
    """Follow a history of loads."""
    from sits_mech.analysis.histories.read import read_history
    from sits_mech.analysis.histories.response import in_time
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.folder import prepare_folder
    from sits_mech.report.histories.folder import write_history
    from sits_mech.report.histories.shown import history_record, history_table

    loads = read_history(path)
    folder = None if output is None else prepare_folder(output, cases=False)
    try:
        with progress_bar("history [%]") as progress:
            data = in_time(sensor, loads, **asdict(models), progress=progress)
    except SolveFailed as error:
        return not_converged(error, as_json, True)
    answer(history_record(data), [history_table(data)], as_json)
    if folder is not None:
        for line in write_history(sensor, data, folder):
            warn(line)
        warn(f"written to {folder}")
    return 0


@app.command
def cycle(
    scene: Scene, *, load: Load = Load(), models: Models = Models(), period: Quantity = "1 s", cycles: int = 2,
    full: Annotated[bool, Parameter(negative="", help="Also with a memory at every point: the difference.")] = False,
    output: Output = None, picture: Picture = None, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:  # fmt: skip
    """How wide is the loop of the signals while a load comes and goes? For silicones with prony or mullins.

    The pad answers as a whole, which is cheap; --full follows every point of it as `simulate --history` does, and tells
    what that changes. -o writes the table over time as netCDF, --picture the loops; of the full one where it was asked.

    Example: sits-mech cycle soft.toml --fz "4 N" --period "2 s" --cycles 3 -o cycle.nc --picture loops.pdf
    """
    from sits_mech.analysis.cycle import load_cycle, triangle
    from sits_mech.analysis.histories.full_cycle import full_cycle
    from sits_mech.cases import save_table
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.pictures.curves import checked_picture, save_figure
    from sits_mech.report.tables.loops import difference_record, difference_table, loop_curves, loop_record, loop_table
    from sits_mech.units import quantity

    drawn = None if picture is None else checked_picture(picture, "--picture")
    sensor, seconds = sensor_of(scene, overrides), quantity(period, "s", "--period")
    try:
        data, beside = load_cycle(sensor, load.wrench(), triangle(seconds, cycles), **asdict(models)), None
        if full:
            with progress_bar("full cycle [%]") as progress:
                beside = full_cycle(
                    sensor, load.wrench(), triangle(seconds, cycles), **asdict(models), progress=progress
                )  # fmt: skip
    except SolveFailed as error:
        return not_converged(error, as_json)
    if beside is None:
        answer(loop_record(data), [loop_table(data)], as_json)
    else:
        record = loop_record(beside) | {"cheap": difference_record(data, beside)}
        answer(record, [loop_table(beside), difference_table(data, beside)], as_json)
        data = beside
    if output is not None:
        save_table(data, output)
        warn(f"written to {output}")
    if drawn is not None:
        save_figure(loop_curves(data), drawn)
        warn(f"written to {drawn}")
    return 0
