"""Commands for readings and the converter: invert, converter, quality, compare."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from sits_mech.cli.console import answer, deliver_picture, warn
from sits_mech.cli.options import (
    Case,
    Clock,
    Folder,
    Idle,
    Json,
    Magnetics,
    Quantity,
    app,
    check_readable,
    clock_of,
    flag,
    output_of,
    si_of,
)
from sits_mech.units import SceneError, quantity

if TYPE_CHECKING:
    import xarray as xr

    from sits_mech.analysis.limits import Limits
    from sits_mech.analysis.tolerances import ForceSpread
    from sits_mech.quantities import Array
    from sits_mech.readout.calibration import Calibration
    from sits_mech.scene.sensor import Sensor


@app.command
def invert(
    folder: Folder, *,
    reading: Annotated[tuple[str, ...], Parameter(negative="", help='Inductance of a coil by name: "C1=91.2 %".')] = (),
    code: Annotated[tuple[str, ...], Parameter(negative="", help="Code of the converter: C1=38900874.")] = (),
    clock: Clock = None,
    idle: Idle = None,
    temperature: Annotated[Quantity | None, Parameter(help="Measured temperature of the sensor.")] = None,
    budget: Annotated[bool, flag("Print what the errors of the forces are made of.")] = False,
    as_json: Json = False,
    **inductances: Annotated[Quantity, Parameter(help="--l1, --l2, ...: inductance of each coil by number.")],
) -> int:
    """Which forces belong to these readings? One per coil: in H, in "%" of free space, or in the table's unit.

    Inductances are those at the terminals, as a converter or a meter reads them, with leads, and idle coils as the
    scene says: those of the catalogue shorted, open by default where a scene has no converter.

    Each force comes within its error: 90 % of the true forces lie there, by what is not known of the map, the table's
    inductances, the silicone's modulus and the reading; --budget shows these parts.

    With --temperature a calibration made with --drift is corrected along its slopes; the sensor is then solved at the
    load found, one to three times of a few seconds, to correct what the straight lines leave out.

    Example: sits-mech invert calibration --l1 "92.1 %" --l2 "91.8 %"
    """
    from sits_mech.cli.readings import CalibratedReading, given_codes, given_inductances, given_texts, other_convention
    from sits_mech.readout.loads import check_enough
    from sits_mech.report.folder import look_at, read_calibration
    from sits_mech.scene.sensor import untested_notes

    if idle is not None and code:
        raise SceneError(f"--idle: must come without --code, the scene says what its converter does; got {idle}")
    if clock is not None and not code:
        raise SceneError(f"--clock: must come with --code, it makes codes of frequencies; got {clock} alone")
    warm = si_of(temperature, "K", "--temperature")
    sensor, forces = look_at(folder)
    texts = given_texts(sensor.coil_names, inductances, reading, code)
    check_enough(sensor.coils, forces)
    sensor, data = read_calibration(folder)

    from sits_mech.chain.derivatives.temperature import read_at
    from sits_mech.report.tables.readings import inversion_record, inversion_table, refusal

    def asked_of(table: xr.Dataset) -> CalibratedReading:
        """Return the reading beside a table in its unit."""
        return given_codes(sensor, table, texts, clock) if code else given_inductances(sensor, table, texts, idle)

    left = None
    if warm is not None:
        data, left = read_at(sensor, data, warm, lambda table: (one := asked_of(table)).cal.inverse(one.values))
    asked = asked_of(data)
    record = {"convention": asked.convention} | inversion_record(asked.cal, asked.values, left)
    why = refusal(asked.cal, record["status"], texts, asked.values)
    if why:
        cause = "" if code else other_convention(sensor, data, asked.values, idle)
        raise SceneError(f"{why}; {cause}" if cause else why)
    answer(record, [inversion_table(record, parts=budget)], as_json)
    warn(*untested_notes(sensor))
    return 0


@app.command
def converter(
    folder: Folder, *,
    clock: Annotated[Quantity | None, Parameter(help="External clock; the part's largest.")] = None,
    rcount: Annotated[int, Parameter(help="Reference count: more is slower and quieter.")] = 0xFFFF,
    as_json: Json = False,
) -> int:
    """How to set the converter for a calibrated sensor, and what it then reads.

    Example: sits-mech converter calibration --clock "40 MHz" --rcount 4096
    """
    from sits_mech.readout import converter as converters
    from sits_mech.readout.front_end import check_settings
    from sits_mech.report.folder import look_at, read_calibration

    part = look_at(folder)[0].readout.converter
    hertz = clock_of(clock, part)
    if part != "none":
        check_settings(converters.converter(part), hertz, rcount)
    sensor, data = read_calibration(folder)

    from sits_mech.analysis.readings.bench import sensor_front_end
    from sits_mech.report.tables.readings import front_end_record, front_end_table

    found, missing = sensor_front_end(sensor, data, clock=hertz, rcount=rcount)
    names = sensor.coil_names
    answer(front_end_record(found, names, missing), [front_end_table(found, names, missing)], as_json)
    warn(*found.warnings)
    return 0


@Parameter(name="*")
@dataclass(frozen=True)
class Deviations:
    """Standard deviations of what is made; those that are given count."""

    thickness: Annotated[Quantity | None, Parameter(help="Deviation of the layer's thickness.")] = None
    modulus: Annotated[Quantity | None, Parameter(help='Relative deviation of the modulus: "5 %".')] = None
    gap: Annotated[Quantity | None, Parameter(help="Deviation of the gap.")] = None
    offset: Annotated[Quantity | None, Parameter(help="Deviation of the coils along x.")] = None

    def given(self) -> dict[str, float]:
        """Return those that are given, in SI."""
        units = {"thickness": "m", "modulus": "", "gap": "m", "offset": "m"}
        texts = {name: getattr(self, name) for name in units}
        return {name: quantity(text, units[name], f"--{name}") for name, text in texts.items() if text is not None}


@app.command
def quality(
    folder: Folder, *, deviations: Deviations = Deviations(),
    noise: Annotated[Quantity | None, Parameter(help="Noise of an inductance; the converter's by default.")] = None,
    samples: Annotated[int, Parameter(help="Sampled sensors for the deviations, a power of two.")] = 32,
    period: Annotated[Quantity | None, Parameter(help="Period of a load cycle, for the hysteresis.")] = None,
    components: Annotated[bool, Parameter(help="Which of the six forces and moments do the coils resolve?")] = False,
    within: Annotated[Quantity | None, Parameter(help="Errors of forces for a touch this far away.")] = None,
    capacity: Annotated[bool, Parameter(help="How far can the corner loads grow, and what limits them?")] = False,
    case: Case = None, as_json: Json = False,
) -> int:
    """Range, linearity, crosstalk, resolution, condition, limits of a calibrated sensor; effect of tolerances.

    Example: sits-mech quality calibration --modulus "5 %" --gap "20 um"
    """
    import numpy as np

    from sits_mech.report.folder import read_calibration

    if samples < 2 or samples & (samples - 1):
        raise SceneError(f"--samples: must be a power of two, such as 32; got {samples}")
    off, one = deviations.given(), si_of(noise, "H", "--noise")
    seconds, distance = si_of(period, "s", "--period"), si_of(within, "m", "--within")
    sensor, data = read_calibration(folder, case)
    if noise is None and sensor.readout.converter == "none":
        raise SceneError('--noise: must be given, such as "1 pH": the scene has readout.converter = "none"')

    from sits_mech.analysis.readings.bench import sensor_calibration, sensor_front_end
    from sits_mech.analysis.wrenches import resolved_components
    from sits_mech.chain.derivatives.temperature import has_slopes
    from sits_mech.export.calibrations import quality as figures
    from sits_mech.quantities import TOUCH
    from sits_mech.readout.misplaced import misplaced
    from sits_mech.report.tables import quality as tables
    from sits_mech.report.tables.drift import drift_table

    cal = sensor_calibration(sensor, data)
    sizes = sensor_front_end(sensor, data)[0].noise if one is None else np.full(len(cal.coils), one)
    loop = None if seconds is None else _loop(sensor, data, seconds)
    found = figures((sensor, data), noise=sizes, branches=loop)
    scatter = _scatter(sensor, data, cal, off, samples)
    record = tables.quality_record(found, data, scatter) | {"noise": sizes.tolist()}
    record |= {"limits": tables.limits_record(_limits(sensor, data, capacity))}
    if has_slopes(data):
        record |= _drift(sensor, data, cal)
    if distance is not None:
        place = dict(zip(TOUCH, sensor.touched_point, strict=True))
        record |= {"misplaced": {"within": distance, "error": misplaced(cal, place, distance)}}
    if components:
        record["components"] = tables.components_record(resolved_components(sensor, data, sizes))
    more = [drift_table(record["drift"])] if "drift" in record else []
    answer(record, [*tables.quality_tables(record), *more], as_json)
    _warn_of(sensor, period, noise, has_slopes(data))
    return 0


@app.command
def compare(
    folder: Annotated[Path, Parameter(help="Folder of a calibration; or a scene, if stages set poses.")],
    measured: Annotated[Path, Parameter(help="CSV: F_x, ... or d_v [mm], alpha [deg], ...; L1 [uH] or code1, ...")], *,
    free: Annotated[str, Parameter(help='To fit: modulus, "gap=0+-0.3 mm", a key of the scene, ...')] = "",
    noise: Annotated[Quantity | None, Parameter(help="Noise of a reading, the weight of the data.")] = None,
    magnetics: Magnetics = "auto",
    clock: Clock = None, idle: Idle = None,
    output: Annotated[Path | None, output_of("Picture of data and model.")] = None,
    as_json: Json = False,
) -> int:
    """How far is a measurement from the model, and which modulus, gap, leads, tilt, ... fit it best?

    Inductances are those at the terminals; ones that clearly fit idle coils the other way are refused.

    Example: sits-mech compare calibration bench.csv --free modulus,lead -o residual.png
    """
    from sits_mech.report.folder import checked_picture

    alone, picture = not folder.is_dir(), output and checked_picture(output)
    if magnetics != "auto" and not alone:
        raise SceneError(f"--magnetics: must be given with a scene alone, a calibration has its own; got {magnetics}")
    check_readable(measured, "a readable measurement")

    from sits_mech.analysis.readings.bench import convention, with_idle
    from sits_mech.export import calibrations
    from sits_mech.report.plots.measured import comparison_figure, comparison_record, comparison_rows
    from sits_mech.report.tables.solves import key_table
    from sits_mech.scene.sensor import load_sensor

    sensor = load_sensor(str(folder) if alone else folder / "scene.toml")
    hertz, names, read = clock_of(clock, sensor.readout.converter), sensor.coil_names, with_idle(sensor, idle)
    found = calibrations.compare(
        folder, measured, free=[part.strip() for part in free.split(",")] if free else (),
        noise=si_of(noise, "H", "--noise"), magnetics=magnetics, clock=hertz, idle=idle,
    )
    deliver_picture(picture, lambda: comparison_figure(found, names))
    words = convention(read, other_idle=found.other_idle)
    rows = [("readings", words), *comparison_rows(found)]
    record = {"convention": words} | comparison_record(found, names)
    answer(record, [key_table(str(measured), rows)], as_json)
    return 0


def _limits(sensor: Sensor, data: xr.Dataset, capacity: bool) -> Limits:
    """Return the limits of a calibrated sensor's pad, on request with what it carries."""
    from sits_mech.analysis.limits import limits_of, with_capacity
    from sits_mech.cli.console import progress_bar

    found = limits_of(sensor, data)
    if not capacity:
        return found
    with progress_bar("corner loads") as progress:
        return with_capacity(found, sensor, data, progress)


def _scatter(
    sensor: Sensor, data: xr.Dataset, cal: Calibration, deviations: dict[str, float], samples: int
) -> ForceSpread | None:
    """Return the errors of forces by deviations of what is made, None without any."""
    from sits_mech.analysis.tolerances import force_spread, loads_inside
    from sits_mech.cli.console import progress_bar

    if not deviations:
        return None
    with progress_bar("sensors") as progress:
        found = force_spread(sensor, data, deviations, loads_inside(cal).tolist(), samples=samples, progress=progress)
    if found.spread.failed:
        warn(f"tolerances: {found.spread.failed} of {samples} sensors cannot be solved and are left out")
    return found


def _warn_of(sensor: Sensor, period: str | None, noise: str | None, drift: bool) -> None:
    """Tell what is not known of a silicone, and what was not asked for."""
    from sits_mech.scene.sensor import silicones_of, untested_notes

    warn(*untested_notes(sensor))
    if any(silicone.has_history for silicone in silicones_of(sensor)) and period is None:
        warn("hysteresis: the silicone has prony or mullins; --period shows what they make of the forces")
    if not drift:
        warn("drift with temperature: not in this calibration; calibrate --drift adds it")
    unset = [part for part in ("capacitance", "clock") if f"{part}_coefficient" not in sensor.readout.model_fields_set]
    if drift and unset:
        keys = ", ".join(f"readout.{part}_coefficient" for part in unset)
        warn(f"drift by {' and '.join(unset)}: not known, and not in the figures: set {keys}")
    if noise is None:
        warn("noise: by default the converter's at its longest conversion; --noise takes that of your board")


def _drift(sensor: Sensor, data: xr.Dataset, cal: Calibration) -> dict[str, Any]:
    """Return the drift of a calibrated sensor with temperature; nothing, and why, where readings have no inverse."""
    from sits_mech.analysis.drift import drift
    from sits_mech.analysis.readings.bench import coil_table
    from sits_mech.analysis.readings.codes import code_slopes
    from sits_mech.report.tables.drift import drift_record

    try:
        if sensor.readout.converter == "none":
            found = drift(cal, coil_table(sensor, data)["slope_T_L_by"])
        else:
            found = drift(cal.code_calibration, code_slopes(sensor, data).squeeze(drop=True))
    except ValueError as error:
        warn(f"drift with temperature: {error}")
        return {}
    return {"drift": drift_record(found, sensor.temperature)}


def _loop(sensor: Sensor, data: xr.Dataset, period: float) -> tuple[Array, Array]:
    """Return the inductances of a table's largest load while it comes and goes, the second time."""
    from sits_mech.analysis.cycle import load_cycle, triangle
    from sits_mech.analysis.readings.bench import branches
    from sits_mech.quantities import Wrench
    from sits_mech.readout.loads import ends_of, fixed, load_words, request_of, varied

    request = request_of(data)
    models = {name: request[name] for name in ("mechanics", "magnetics", "tolerance")}
    held = load_words(fixed(data))
    if held:
        raise SceneError(f"--period: needs a table whose loads start from none; this one holds {held}")
    ends = ends_of(data, varied(data)).items()
    peak = Wrench(**{name: low if -low > high else high for name, (low, high) in ends})
    return branches(sensor, load_cycle(sensor, peak, triangle(period), **models))
