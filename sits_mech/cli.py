"""The command line: ``sits-mech COMMAND SCENE ...``; see ``sits-mech --help``.

Answers go to stdout, progress and warnings to stderr. Exit 0 done, 2 bad input (one line), 3 not converged (what was
reached is printed and kept), 130 interrupted. Each command imports its rooms itself, so that help comes at once.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, CycloptsError, Parameter

from sits_mech.console import answer, not_converged, progress_bar, show, warn
from sits_mech.version import __version__

if TYPE_CHECKING:
    from sits_mech.quantities import Pose, Wrench
    from sits_mech.sensor import Sensor

app = App(
    name="sits-mech", version=__version__, help="Force in, inductance out: soft inductive tactile sensors.",
    suppress_keyboard_interrupt=False,
)  # fmt: skip

Quantity = Annotated[str, Parameter(allow_leading_hyphen=True)]
Scene = Annotated[str, Parameter(help="Path of a scene file, or a name of the catalogue.")]
Frequency = Annotated[str, Parameter(allow_leading_hyphen=True, help='One, or a range "first:last:count".')]
Tolerance = Annotated[float, Parameter(help="Asked relative error.")]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]
Overrides = Annotated[
    tuple[str, ...], Parameter(name="--set", negative="", help='Change a key of the scene: target.width="15 mm".')
]


@Parameter(name="*")
@dataclass(frozen=True)
class Load:
    """The load: forces along +x and downwards, and the moment that lifts the left edge."""

    fx: Annotated[Quantity, Parameter(help="Shear force, along +x.")] = "0 N"
    fz: Annotated[Quantity, Parameter(help="Normal force, pressing down.")] = "0 N"
    moment: Annotated[Quantity, Parameter(help="Moment that lifts the left edge.")] = "0 N*m"

    def wrench(self) -> Wrench:
        """Return the load in SI."""
        from sits_mech.quantities import Wrench
        from sits_mech.units import quantity

        return Wrench(
            quantity(self.fx, "N", "--fx"), quantity(self.fz, "N", "--fz"), quantity(self.moment, "N*m", "--moment")
        )


@Parameter(name="*")
@dataclass(frozen=True)
class Place:
    """A pose of the target, instead of a load."""

    dv: Annotated[Quantity | None, Parameter(help="Height of the target's bottom face above the coils.")] = None
    dh: Annotated[Quantity, Parameter(help="Where the target's centre is along x.")] = "0 mm"
    alpha: Annotated[Quantity, Parameter(help="Rotation that lifts the left edge.")] = "0 deg"

    def pose(self) -> Pose:
        """Return the pose in SI."""
        return _place(self.dh, self.dv or "0 m", self.alpha)


@Parameter(name="*")
@dataclass(frozen=True)
class Models:
    """Which model takes each half, and to what relative error."""

    mechanics: Annotated[str, Parameter(help="auto, planar or linear.")] = "auto"
    magnetics: Annotated[str, Parameter(help="auto, planar, planar-fem, axisymmetric or sheets.")] = "auto"
    tolerance: Tolerance = 1e-2


@app.command
def catalog() -> int:
    """List the catalogued sensors, silicones and metals.

    Example: sits-mech catalog
    """
    from sits_mech.materials import metals, silicones
    from sits_mech.report.tables import key_table
    from sits_mech.sensor import catalogue

    show(key_table("sensors", list(catalogue().items())))
    show(key_table("silicones", [(name, f"{item.law}: {item.source}") for name, item in silicones().items()]))
    lines = [(name, f"{item.conductivity:.3g} S/m: {item.source}") for name, item in metals().items()]
    show(key_table("metals", lines))
    return 0


@app.command
def doctor() -> int:
    """Tell whether everything that is needed is installed.

    Example: sits-mech doctor
    """
    from sits_mech.doctor import examine, healthy
    from sits_mech.report.tables import key_table

    parts = examine()
    show(key_table("parts", [(name, f"{version}  {purpose}") for name, version, purpose in parts]))
    return 0 if healthy(parts) else 2


@app.command
def explain(scene: Scene, *, load: Load = Load(), tolerance: Tolerance = 1e-2, overrides: Overrides = ()) -> int:
    """Tell which models a request takes, what it leaves out, and why.

    Example: sits-mech explain biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech.chain import magnetic_model, mechanical_model
    from sits_mech.plan import left_out
    from sits_mech.report.tables import key_table

    sensor, wrench = _sensor(scene, overrides), load.wrench()
    force = any((wrench.F_x, wrench.F_z, wrench.M))
    choice = magnetic_model(sensor, tolerance=tolerance)[1]
    rows = [("magnetics", f"{choice.name}: {choice.reason}")]
    if force:
        choice = mechanical_model(sensor, tolerance=tolerance)[1]
        rows.insert(0, ("mechanics", f"{choice.name}: {choice.reason}"))
    show(key_table(sensor.name, rows + [("left out", text) for text in left_out(sensor, force)]))
    return 0


@app.command
def pose(
    scene: Scene, *, load: Load = Load(), model: str = "auto", tolerance: Tolerance = 1e-2,
    overrides: Overrides = (), as_json: Json = False,
) -> int:  # fmt: skip
    """Where the target comes to rest under a load.

    Example: sits-mech pose biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech.chain import mechanical_model
    from sits_mech.plan import left_out
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import equilibrium_record
    from sits_mech.report.tables import equilibrium_table

    sensor = _sensor(scene, overrides)
    layer, _ = mechanical_model(sensor, model, tolerance)
    try:
        found = layer.equilibrium(load.wrench())
    except SolveFailed as error:
        return not_converged(error, as_json)
    answer(equilibrium_record(found, left_out(sensor, True)), [equilibrium_table(found)], as_json)
    return 0


@app.command
def inductance(
    scene: Scene, *, dv: Quantity, dh: Quantity = "0 mm", alpha: Quantity = "0 deg", frequency: Frequency | None = None,
    model: str = "auto", tolerance: Tolerance = 1e-3, overrides: Overrides = (), as_json: Json = False,
) -> int:  # fmt: skip
    """What the coils show with the target at a pose, at one frequency or over a range.

    Example: sits-mech inductance biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 MHz"
    """
    from sits_mech.chain import magnetic_model
    from sits_mech.plan import left_out
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import impedance_record, spectrum_record
    from sits_mech.report.tables import impedance_table, spectrum_table, terminal_table
    from sits_mech.spectrum import at_terminals, frequency_range, spectrum

    sensor, place = _sensor(scene, overrides), _place(dh, dv, alpha)
    hertz = [sensor.frequency] if frequency is None else frequency_range(frequency, "--frequency")
    solver, _ = magnetic_model(sensor, model, tolerance)
    unsolved = left_out(sensor, False)
    try:
        if len(hertz) > 1:
            data = spectrum(sensor, solver, place, hertz)
            answer(spectrum_record(place, data, unsolved), [spectrum_table(data)], as_json)
            return 0
        found = solver.impedance(place, hertz[0])
    except SolveFailed as error:
        return not_converged(error, as_json)
    seen, missing = at_terminals(sensor, found)
    names = [coil.name for coil in sensor.coils]
    tables = [impedance_table(names, found), terminal_table(names, seen, missing)]
    answer(impedance_record(place, found, (*unsolved, *missing), seen), tables, as_json)
    return 0


@app.command
def simulate(
    scene: Scene, *, load: Load = Load(), models: Models = Models(), overrides: Overrides = (), as_json: Json = False
) -> int:
    """What the sensor shows under a load.

    Example: sits-mech simulate biorob2018 --fx "0.5 N" --fz "2 N"
    """
    from sits_mech import chain
    from sits_mech.plan import left_out
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.records import simulation_record
    from sits_mech.report.tables import equilibrium_table, impedance_table, signal_table

    sensor = _sensor(scene, overrides)
    try:
        found = chain.simulate(sensor, load.wrench(), **asdict(models))
    except SolveFailed as error:
        return not_converged(error, as_json)
    tables = [
        equilibrium_table(found.equilibrium),
        impedance_table([coil.name for coil in sensor.coils], found.impedance),
        signal_table(found.signals, found.impedance.unit_L),
    ]
    answer(simulation_record(found, left_out(sensor, True)), tables, as_json)
    return 0


@app.command
def calibrate(
    scene: Scene, *, models: Models = Models(), fx: Quantity = "-1 N:1 N:9", fz: Quantity = "0 N:4 N:9",
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None, overrides: Overrides = (),
) -> int:  # fmt: skip
    """What the sensor shows over a grid of loads: table, netCDF, CSV and pictures; a stopped run goes on.

    Example: sits-mech calibrate biorob2018 --fx "-1 N:1 N:9" --fz "0 N:4 N:9" -o calibration
    """
    from sits_mech import chain
    from sits_mech.plan import quantity_range
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.folder import cases_folder, prepare_folder, write_calibration
    from sits_mech.report.tables import failures, load_table, remarks, summary_table

    sensor = _sensor(scene, overrides)
    F_x, F_z = quantity_range(fx, "N", "--fx"), quantity_range(fz, "N", "--fz")
    folder = prepare_folder(output if output is not None else Path(f"{Path(scene).stem}-calibration"))
    try:
        with progress_bar("loads") as progress:
            data = chain.calibrate(
                sensor, F_x=F_x, F_z=F_z, tolerance=models.tolerance, mechanics=models.mechanics,
                magnetics=models.magnetics, progress=progress, folder=cases_folder(folder),
            )  # fmt: skip
    except SolveFailed as error:
        return not_converged(error, False)
    for line in write_calibration(sensor, data, folder):
        warn(line)
    show(load_table(data))
    show(summary_table(data))
    missing = failures(data)
    for line in [*remarks(data), *missing, f"written to {folder}"]:
        warn(line)
    return 3 if missing else 0


@app.command
def fit(
    tensile: Annotated[Path, Parameter(help="Strain and engineering stress as CSV.")], *, law: str = "yeoh",
    max_strain: float = 1.0, terms: Annotated[int, Parameter(help="Of Ogden's law.")] = 2,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"], help="Picture of data and fit.")] = None,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Fit a silicone's constants to a tensile test, with the planar and biaxial ones of the same file.

    Example: sits-mech fit tensile.csv --law yeoh --max-strain 1.0 -o fit.png
    """
    from sits_mech.mechanics.fitting import fit_law, read_tensile
    from sits_mech.report.fit_view import fit_rows, save_fit
    from sits_mech.report.tables import key_table

    test = read_tensile(tensile)
    found = fit_law(test, law, max_strain, terms=terms)
    if output is not None:
        save_fit(test, found, output)
        warn(f"written to {output}")
    answer(asdict(found), [key_table(str(tensile), fit_rows(found))], as_json)
    return 0


@app.command
def view(
    scene: Scene, *, load: Load = Load(), place: Place = Place(),
    kind: Literal["field", "layer", "spatial"] | None = None,
    driven: Annotated[str | None, Parameter(help="Name of the coil that carries current; the last one.")] = None,
    frequency: Quantity | None = None, output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    overrides: Overrides = (),
) -> int:  # fmt: skip
    """Draw the deformed layer, the field around a pose, or coils, target and eddy currents in space.

    Example: sits-mech view biorob2018 --dv "2 mm" --dh "1 mm" --frequency "5 kHz" --kind field -o field.png
    """
    from sits_mech.quantities import SolveFailed
    from sits_mech.report.pictures import Request, draw, kind_of_picture, picture_path
    from sits_mech.units import quantity

    sensor, pose = _sensor(scene, overrides), None if place.dv is None else place.pose()
    kind = kind_of_picture(kind, load.wrench(), pose)
    path = picture_path(output, scene, kind)
    hertz = sensor.frequency if frequency is None else quantity(frequency, "Hz", "--frequency")
    try:
        draw(kind, sensor, Request(load.wrench(), pose, hertz, driven), path)
    except SolveFailed as error:
        return not_converged(error, False)
    warn(f"written to {path}")
    return 0


def _place(dh: str, dv: str, alpha: str) -> Pose:
    """Return a written pose in SI."""
    from sits_mech.quantities import Pose
    from sits_mech.units import quantity

    return Pose(quantity(dh, "m", "--dh"), quantity(dv, "m", "--dv"), quantity(alpha, "rad", "--alpha"))


def _sensor(scene: str, overrides: Sequence[str]) -> Sensor:
    """Return the scene a command is about."""
    from sits_mech.sensor import load_sensor

    return load_sensor(scene, overrides)


def run(tokens: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code.

    Parameters
    ----------
    tokens : sequence of str, optional
        The words of the command line; those of the process by default.
    """
    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except (CycloptsError, ValueError, OSError) as error:
        warn(f"error: {' '.join(str(error).split())}")
        return 2
    except KeyboardInterrupt:
        warn("interrupted: finished loads are kept; the same command goes on from them")
        return 130
    return code if isinstance(code, int) else 0


def main() -> None:
    """Run the command line and leave with its exit code."""
    sys.exit(run())
