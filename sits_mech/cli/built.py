"""The commands for built sensors: adapt, lot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from sits_mech.cli.console import answer, progress_bar, warn
from sits_mech.cli.options import (
    Clock,
    Folder,
    Idle,
    Json,
    Output,
    Quantity,
    app,
    check_readable,
    clock_of,
    flag,
    si_of,
)
from sits_mech.units import SceneError, quantity

if TYPE_CHECKING:
    import xarray as xr

    from sits_mech.analysis.built.adaptation import Adaptation
    from sits_mech.analysis.built.fit import EndReached
    from sits_mech.analysis.built.prior import Prior
    from sits_mech.analysis.built.production import Production
    from sits_mech.analysis.readings.measured import Tank
    from sits_mech.scene.sensor import Sensor


Rigs = Literal["weights", "press", "stage", "use"]


@Parameter(name="*")
@dataclass(frozen=True)
class PriorOptions:
    """What is known of sensor and bench beforehand."""

    free: Annotated[str, Parameter(help='What is unknown: "modulus, gap=0+-0.3 mm"; by default all that may be.')] = ""
    lot: Annotated[Path | None, Parameter(help="What other units have shown: lot.json of sits-mech lot.")] = None
    noise: Annotated[Quantity | None, Parameter(help="Noise of a reading; by default the converter's.")] = None
    load_noise: Annotated[Quantity | None, Parameter(help="Noise of a load; 0.1 % of the largest.")] = None
    depth_noise: Annotated[Quantity, Parameter(help="Noise of the way down.")] = "10 um"
    clock: Clock = None

    @property
    def noises(self) -> dict[str, Any]:
        """Return the noises of loads, as arguments."""
        by_load = si_of(self.load_noise, "N", "--load-noise")
        return {"load_noise": by_load, "depth_noise": si_of(self.depth_noise, "m", "--depth-noise")}

    def prior(self, sensor: Sensor, data: xr.Dataset) -> Prior:
        """Return a calibrated sensor with what is unknown of it."""
        from sits_mech.analysis.built.delivered import known_by
        from sits_mech.analysis.built.prior import prior_of

        prior = prior_of(sensor, data, _listed(self.free), noise=si_of(self.noise, "H", "--noise"))
        return prior if self.lot is None else known_by(prior, self.lot)

    def tank(self, prior: Prior) -> Tank | None:
        """Return how codes become inductances."""
        from sits_mech.analysis.readings.codes import tank_of

        return tank_of(prior.sensor, prior.data, clock_of(self.clock, prior.sensor.readout.converter))


def _listed(text: str) -> list[str]:
    """Return the parts of a text between commas."""
    return [part.strip() for part in text.split(",") if part.strip()]


@app.command
def adapt(
    folder: Folder, *,
    bench: Annotated[Path | None, Parameter(help="CSV: F_x, F_z, ..., L1 [uH] or code1, ..., depth [mm].")] = None,
    plan: Annotated[int | None, Parameter(help="How many loads to choose, before anything is read.")] = None,
    rig: Annotated[Rigs | None, Parameter(help="What loads are made with (stage); use: read without a bench.")] = None,
    weights: Annotated[str, Parameter(help='Of --plan: the weights at hand, "50 g, 100 g, 200 g".')] = "",
    step: Annotated[Quantity | None, Parameter(help='Of --plan: loads are multiples of it, "0.5 N".')] = None,
    known: PriorOptions = PriorOptions(), idle: Idle = None,
    strict: Annotated[bool, flag("Refuse readings that hardly are of such a sensor.")] = False,
    grow: Annotated[bool, flag("Calibrate further where readings of a softer sensor end at the table.")] = False,
    output: Output = None, as_json: Json = False,
) -> int:
    """Which sensor was built? A few readings correct a calibration, or --plan says which loads to read.

    Five readings under known loads (--bench) find what is not known of the built sensor: modulus, gap, tilt, leads, the
    load cell's scale. Inductances are those at the terminals; ones that clearly fit idle coils the other way are
    refused. With -o scene and table of what was found are written as a calibration, for invert and export,
    and unit.h, the constants of this unit for the firmware of the calibration that was adapted. A sensor so soft
    that its readings end at the table needs a calibration to larger loads: --grow solves the few that are not there,
    and writes them to the folder.

    Example: sits-mech adapt calibration --plan 5 --rig stage
    Example: sits-mech adapt calibration --plan 3 --weights "50 g, 100 g, 200 g, 500 g"
    Example: sits-mech adapt calibration --bench bench.csv -o built
    Example: sits-mech adapt built --plan 2 --rig use --free "modulus=1+-0.05, lead=0+-5 nH"
    """
    if (bench is None) == (plan is None):
        raise SceneError(f"adapt: must have either --bench FILE or --plan N; got {'both' if bench else 'none'}")
    if plan is not None and plan < 1:
        raise SceneError(f"plan: must be one or more loads; got {plan}")
    if plan is not None and (strict or grow or any(each is not None for each in (idle, output))):
        raise SceneError("--plan: must be given without --strict, --grow, --idle, -o, which are of readings")
    if bench is not None and (weights or step is not None):
        raise SceneError("--weights, --step: must be given with --plan, whose loads they are")
    if bench is not None:
        check_readable(bench, "a readable measurement")

    from sits_mech.report.folder import cases_folder, prepare_folder, read_calibration

    sensor, data = read_calibration(folder)
    prior = known.prior(sensor, data)
    if plan is not None:
        from sits_mech.analysis.bench.load_plan import Bench, plan_loads
        from sits_mech.report.tables.built import adapt_plan_record, adapt_plan_tables

        rig, at_hand = rig or ("weights" if weights else "stage"), Bench.written(weights, step)
        chosen = plan_loads(prior, plan, rig, bench=at_hand, **known.noises)
        answer(adapt_plan_record(chosen), adapt_plan_tables(chosen), as_json)
        return 0

    from sits_mech.analysis.built.grown import grown
    from sits_mech.export.calibrations import adapted_as_read, read_bench
    from sits_mech.report.tables import built as tables
    from sits_mech.store import claimed

    measured = read_bench(prior, Path(str(bench)), known.tank(prior))

    def further(prior: Prior, end: EndReached) -> Prior:
        """Return the same by more loads."""
        kept = cases_folder(prepare_folder(folder))
        with claimed(folder), progress_bar("loads") as progress:
            return known.prior(sensor, grown(prior, measured.forces, end, kept, progress=progress))

    found, remark = adapted_as_read(prior, measured, known.noises, _listed(known.free), idle, further if grow else None)
    if found.prior.data is not data:
        _write_longer(sensor, found.prior.data, folder)
    record = tables.adaptation_record(found, remark)
    answer(record, [tables.adaptation_table(record, str(bench))], as_json)
    if remark:
        warn(f"{bench}: {remark}")
    if strict and tables.verdict(record).startswith("hardly"):
        raise SceneError(f"{bench}: must be readings of such a sensor; {tables.verdict(record)}")
    if output is not None:
        _write(replace(found, prior=found.prior.read_by(sensor.readout.idle_coil)), output)
    return 0


@app.command
def lot(
    folder: Folder, *,
    bench: Annotated[Path, Parameter(help="CSV as of adapt, with a column unit.")],
    within: Annotated[str, Parameter(help='Deviations between units, where known: "modulus=2 %, gap=20 um".')] = "",
    limit: Annotated[Quantity, Parameter(help="Error of a good unit on 90 % of loads, over each range.")] = "2 %",
    plan: Annotated[int, Parameter(help="Loads that the next units may be read under, at most.")] = 2,
    rig: Annotated[Rigs, Parameter(help="What these are made with.")] = "stage",
    known: PriorOptions = PriorOptions(), output: Output = None, as_json: Json = False,
) -> int:
    """What do units of one production share? Readings of some say how few loads the next ones need.

    Each unit is found by its own readings and by what the others tell of silicone, bench and jig; then the error and
    the yield of the next units after no reading, a tare, one load, two. With -o are written lot.json, for --lot of
    adapt, units.csv, a row of constants for the firmware of each unit, and a picture.

    Example: sits-mech lot calibration --bench units.csv -o lot
    Example: sits-mech adapt calibration --lot lot/lot.json --plan 1
    """
    share = quantity(limit, "", "--limit")
    if not 0.0 < share < 1.0 or plan < 1:
        raise SceneError(f"lot: must have --limit between 0 and 100 % and --plan of one or more; got {limit}, {plan}")
    check_readable(bench, "a readable measurement")

    from sits_mech.analysis.bench.load_plan import plan_loads
    from sits_mech.analysis.built.delivered import delivered, spread_of
    from sits_mech.analysis.built.production import produced
    from sits_mech.analysis.readings.measured import read_units
    from sits_mech.export.calibrations import read_with
    from sits_mech.readout.loads import fixed
    from sits_mech.report.folder import read_calibration
    from sits_mech.report.tables import built as tables

    prior = known.prior(*read_calibration(folder))
    spread, held, coils = spread_of(prior, _listed(within)), fixed(prior.data), prior.sensor.coil_names
    units = read_units(bench, prior.forces, coils, known.tank(prior), held)
    prior = read_with(prior, all(one.coded for one in units.values()), _listed(known.free))
    with progress_bar("units") as progress:
        found = produced(prior, units, spread, progress=progress, **known.noises)
    chosen = plan_loads(found.next, plan, rig, **known.noises)
    record = tables.production_record(found, chosen, delivered(found, chosen, share), share)
    answer(record, tables.production_tables(record, str(bench)), as_json)
    if output is not None:
        _write_lot(found, record, output)
    return 0


def _write_longer(sensor: Sensor, data: xr.Dataset, folder: Path) -> None:
    """Write a calibration with more loads in place of the one that it goes on from."""
    from sits_mech.readout.loads import load_words
    from sits_mech.report.written import write_calibration

    ends = {str(name): float(data[name].max()) for name in data["status"].dims}
    warn(*write_calibration(sensor, data, folder))
    warn(f"{folder}: calibrated further, to {load_words(ends)}: export its firmware anew, and adapt other units")


def _write(found: Adaptation, output: Path) -> None:
    """Write scene, table and pictures of what was found as a calibration."""
    from sits_mech.analysis.built.corrected import corrected
    from sits_mech.report.folder import prepare_folder
    from sits_mech.report.pictures.style import save_figures
    from sits_mech.report.plots.built import adaptation_figure
    from sits_mech.report.written import write_calibration

    folder = prepare_folder(output)
    sensor, data = corrected(found)
    missed = write_calibration(sensor, data, folder, layer=False)  # no layer is solved anew
    missed += save_figures(folder, {"adapted": partial(adaptation_figure, found)})
    _write_unit(found, folder / "unit.h")
    warn(*dict.fromkeys(missed), f"written to {folder}")


def _write_unit(found: Adaptation, path: Path) -> None:
    """Write the constants of a unit for the firmware of the calibration that was adapted; say why there are none."""
    from sits_mech.analysis.built.constants import constants_of
    from sits_mech.export.firmware import unit_header
    from sits_mech.export.source import Source
    from sits_mech.scene.files import write_text

    prior, rows = found.prior, len(found.measured.L)
    try:
        text = unit_header(
            f"{prior.sensor.name}, adapted to {rows} readings of {found.measured.source}",
            Source(prior.sensor, prior.data), constants_of(found),
        )
    except ValueError as error:
        path.unlink(missing_ok=True)
        warn(f"no constants for firmware: {error}")
        return
    write_text(path, text)


def _write_lot(found: Production, record: dict[str, Any], output: Path) -> None:
    """Write what the next units are known by, a row of each unit, and a picture."""
    from sits_mech.analysis.built.delivered import lot_record
    from sits_mech.report.folder import prepare_folder
    from sits_mech.report.pictures.style import save_figures
    from sits_mech.report.plots.built import production_figure
    from sits_mech.report.records import json_text
    from sits_mech.scene.files import write_text

    folder = prepare_folder(output)
    write_text(folder / "lot.json", json_text(lot_record(found.next)) + "\n")
    write_text(folder / "units.csv", _unit_rows(found, record))
    warn(*save_figures(folder, {"lot": partial(production_figure, found, record)}), f"written to {folder}")


def _unit_rows(found: Production, record: dict[str, Any]) -> str:
    """Return a row of each unit as CSV: what was found of it, and its constants for firmware."""
    import csv
    import io

    from sits_mech.analysis.built.constants import constants_of
    from sits_mech.analysis.readings.bench import code_calibration
    from sits_mech.export.firmware import unit_numbers

    prior, rows, cal = found.start, [], None
    try:
        cal = code_calibration(prior.sensor, prior.data)
    except ValueError as error:
        warn(f"no constants for firmware: {error}")
    for name, one in record["units"].items():
        row = {"unit": name, **{key: value for key, value in one.items() if not isinstance(value, dict)}}
        row |= {f"error_{force}": error for force, error in one.get("force_error", {}).items()}
        row |= one.get("unknowns", {})
        if cal is not None and name in found.units:
            constants = constants_of(found.units[name], cal)
            row |= {f"left_{force}": left for force, left in zip(prior.forces, constants.left.tolist(), strict=True)}
            row |= unit_numbers(prior.data, prior.forces, constants)
        rows.append(row)
    text = io.StringIO()
    table = csv.DictWriter(text, list(dict.fromkeys(key for row in rows for key in row)), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return text.getvalue()
