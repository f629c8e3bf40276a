"""Where does the target go, what do the coils show? pose, inductance, simulate, calibrate, cycle."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from sits_mech.commands.options import (
    Frequency,
    Json,
    Load,
    LoadGrid,
    Models,
    Output,
    Overrides,
    Place,
    Quantity,
    Scene,
    Tolerance,
    app,
    sensor_of,
)  # fmt: skip
from sits_mech.console import answer, not_converged, progress_bar, show, warn


@app.command
def pose(
    scene: Scene, *, load: Load = Load(), model: str = "auto", tolerance: Tolerance = 1e-2,
    overrides: Overrides = (), as_json: Json = False,
) -> int:  # fmt: skip
    """Where the target comes to rest under a load.

    Example: sits-mech pose biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech.chain.models import mechanical_model
    from sits_mech.chain.omissions import omissions
    from sits_mech.chain.simulate import at_rest
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import equilibrium_record
    from sits_mech.report.tables import equilibrium_table

    sensor, loads = sensor_of(scene, overrides), [load.wrench()]
    layer, choice = mechanical_model(sensor, model, tolerance, loads)
    try:
        found = at_rest(sensor, layer, *loads)
    except SolveFailed as error:
        return not_converged(error, as_json)
    unsolved = tuple(item.text for item in omissions(sensor, loads, choice.name, None))
    answer(equilibrium_record(found, unsolved), [equilibrium_table(found)], as_json)
    return 0


@app.command
def inductance(
    scene: Scene, *, place: Place = Place(), frequency: Frequency | None = None,
    model: str = "auto", tolerance: Tolerance = 1e-3, overrides: Overrides = (), as_json: Json = False,
) -> int:  # fmt: skip
    """What the coils show with the target at a pose, at one frequency or over a range.

    Example: sits-mech inductance biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 MHz"
    """
    from sits_mech.analysis.spectrum import at_terminals, frequency_range, spectrum
    from sits_mech.chain.models import magnetic_model
    from sits_mech.chain.omissions import omissions
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import impedance_record, spectrum_record
    from sits_mech.report.tables import impedance_table, spectrum_table, terminal_table

    sensor, pose = sensor_of(scene, overrides), place.pose()
    hertz = [sensor.frequency] if frequency is None else frequency_range(frequency, "--frequency")
    solver, choice = magnetic_model(sensor, model, tolerance, [pose])
    slowest = sensor.model_copy(update={"frequency": min(hertz)})
    unsolved = tuple(item.text for item in omissions(slowest, (), None, choice.name))
    try:
        if len(hertz) > 1:
            data = spectrum(sensor, solver, pose, hertz)
            answer(spectrum_record(pose, data, unsolved), [spectrum_table(data)], as_json)
            return 0
        found = solver.impedance(pose, hertz[0])
    except SolveFailed as error:
        return not_converged(error, as_json)
    seen, missing = at_terminals(sensor, found)
    names = [coil.name for coil in sensor.coils]
    tables = [impedance_table(names, found), terminal_table(names, seen, missing)]
    answer(impedance_record(pose, found, (*unsolved, *missing), seen), tables, as_json)
    return 0


@app.command
def simulate(
    scene: Scene, *, load: Load = Load(), models: Models = Models(),
    overrides: Overrides = (), as_json: Json = False,
) -> int:  # fmt: skip
    """What the sensor shows under a load.

    Example: sits-mech simulate biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech.chain.models import plan
    from sits_mech.chain.simulate import simulate as simulated
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import simulation_record
    from sits_mech.report.tables import equilibrium_table, impedance_table, signal_table

    sensor, wrench = sensor_of(scene, overrides), load.wrench()
    unsolved = plan(sensor, [wrench], **asdict(models)).left_out
    try:
        found = simulated(sensor, wrench, **asdict(models))
    except SolveFailed as error:
        return not_converged(error, as_json, True)
    tables = [
        equilibrium_table(found.equilibrium),
        impedance_table([coil.name for coil in sensor.coils], found.impedance),
        signal_table(found.signals, found.impedance.unit_L),
    ]
    answer(simulation_record(found, unsolved), tables, as_json)
    return 0


@app.command
def calibrate(
    scene: Scene, *, loads: LoadGrid = LoadGrid(), models: Models = Models(), output: Output = None,
    overrides: Overrides = (),
) -> int:  # fmt: skip
    """What the sensor shows over a grid of loads: table, netCDF, CSV and pictures; a stopped run goes on.

    Each force and moment is a range "first:last:count", a dimension of the table, or one quantity, the same for all.
    No more loads are solved than a smooth map through them needs to foretell the others within the tolerance (of 9 x 9
    usually 25, and half of those again where the sensor is its own mirror image); the table says which.

    Example: sits-mech calibrate biorob2018 --fx "-1 N:1 N:9" --fz "0 N:4 N:9" -o calibration
    """
    from sits_mech.chain.calibrate import calibrate as calibrated
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.folder import cases_folder, prepare_folder, write_calibration
    from sits_mech.report.load_tables import failures, load_table, remarks, summary_table

    sensor, components = sensor_of(scene, overrides), loads.components()
    folder = prepare_folder(output if output is not None else Path(f"{Path(scene).stem}-calibration"))
    try:
        with progress_bar("loads") as progress:
            data = calibrated(
                sensor, **components, **asdict(models), progress=progress, folder=cases_folder(folder)
            )
    except SolveFailed as error:
        return not_converged(error, False)
    for line in write_calibration(sensor, data, folder):
        warn(line)
    show(load_table(data))
    show(summary_table(data))
    missing = failures(data)
    flat = ["per metre of depth: ends along y are not in the signals, shear above all; --magnetics sheets has them"]
    for line in [*remarks(data), *(flat if data.attrs["unit_L"] == "H/m" else []), *missing, f"written to {folder}"]:
        warn(line)
    return 3 if missing else 0


@app.command
def cycle(
    scene: Scene, *, load: Load = Load(), models: Models = Models(), period: Quantity = "1 s", cycles: int = 2,
    output: Output = None, overrides: Overrides = (), as_json: Json = False,
) -> int:  # fmt: skip
    """How wide is the loop of the signals while a load comes and goes? For silicones with prony or mullins.

    Example: sits-mech cycle soft.toml --fz "4 N" --period "2 s" --cycles 3 -o cycle.nc
    """
    from sits_mech.analysis.cycle import load_cycle, triangle
    from sits_mech.cases import save_table
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.loops import loop_record, loop_table
    from sits_mech.units import quantity

    sensor, seconds = sensor_of(scene, overrides), quantity(period, "s", "--period")
    try:
        data = load_cycle(sensor, load.wrench(), triangle(seconds, cycles), **asdict(models))
    except SolveFailed as error:
        return not_converged(error, as_json)
    answer(loop_record(data), [loop_table(data)], as_json)
    if output is not None:
        save_table(data, output)
        warn(f"written to {output}")
    return 0
