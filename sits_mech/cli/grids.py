"""Commands for many loads or scenes: calibrate, sweep."""

from __future__ import annotations

from collections import Counter
from contextlib import nullcontext
from dataclasses import asdict
from math import nan
from os import times
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from sits_mech.cli.console import (
    answer,
    exit_code_of,
    kept_promise,
    print_table,
    print_written,
    progress_bar,
    terminal_width,
    warn,
    write,
)
from sits_mech.cli.options import (
    Accept,
    Best,
    Json,
    LoadGrid,
    Models,
    Output,
    Overrides,
    Scene,
    Warmth,
    app,
    check_readable,
    check_request,
    flag,
    output_of,
    sensor_of,
)
from sits_mech.status import FAILED
from sits_mech.units import SceneError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import xarray as xr

    from sits_mech.batch.forecast import Forecast
    from sits_mech.batch.studies.asked import Study


@app.command
def calibrate(
    scene: Scene, *, loads: LoadGrid = LoadGrid(), models: Models = Models(), output: Output = None,
    temperature: Warmth = None,
    drift: Annotated[bool, flag("Add slopes by temperature, for quality, invert.")] = False,
    best: Best = True, accept: Accept = False, overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """What the sensor shows over a grid of loads: table, netCDF, CSV and pictures; a stopped run is resumed.

    Each force and moment is a range "first:last:count", or one quantity for the whole table.
    Only as many loads are solved as it takes to interpolate the others within the tolerance (of 9 x 9 some 13 to 21, of
    5 x 5 x 5 some 30); where pad and target are symmetric, mirrored loads are solved once. The table marks them.

    Example: sits-mech calibrate triaxial-4 --fx "-0.5 N:0.5 N:5" --fy "-0.5 N:0.5 N:5" --fz "0 N:2 N:5" -o calibration
    """
    from sits_mech.report.folder import cases_folder, prepare_folder

    sensor = sensor_of(scene, overrides, temperature)
    components = loads.components(sensor)
    check_request(sensor, components, **asdict(models))
    folder = prepare_folder(output if output is not None else Path(f"{Path(scene).stem}-calibration"))

    from sits_mech.chain.calibrate import calibrate as calibrated
    from sits_mech.readout.loads import each_of, varied
    from sits_mech.report.tables.loads import failures, in_width, load_table, remarks, summary_table
    from sits_mech.report.written import write_calibration
    from sits_mech.scene.sensor import untested_notes
    from sits_mech.store import claimed

    components = loads.borne(sensor, components, models.mechanics)
    began = process_time()
    with claimed(folder), progress_bar("loads") as progress:
        data = calibrated(
            sensor, **components, **asdict(models), progress=progress, folder=cases_folder(folder), drift=drift,
            best=best,
        )
    took = process_time() - began
    notes = (*untested_notes(sensor), *write_calibration(sensor, data, folder))
    missing, remarked = failures(data), []
    if not as_json and len(missing) < data["status"].size:  # else there is nothing to show
        remarked = remarks(data)
        width, whole = terminal_width(), load_table(data)
        for part in [whole] if width is None else in_width(whole, len(varied(data)), width):
            print_table(part)
        print_table(summary_table(data))
    statuses, off = each_of(data), float(data.attrs.get("error", nan))
    print_written(
        [folder], as_json, [*notes, *remarked, *missing], statuses=dict(Counter(statuses)), error=off, seconds=took
    )
    if "planned" in data.attrs:
        warn(kept_promise(data.attrs["planned"], (took, data.attrs["reached"]), off))
    return exit_code_of(statuses, accept)


@app.command
def sweep(
    study: Annotated[Path, Parameter(help="Study file: scene, request, vary, fixed; a folder for --watch.")], *,
    output: Annotated[Path | None, output_of("Folder for result and cases.")] = None,
    plan: Annotated[bool, flag("Try a few cases, and tell what all would take.")] = False,
    processes: Annotated[int, Parameter(name=["--processes", "-j"], help="Parallel processes.")] = 1,
    dask: Annotated[str | None, Parameter(help="Address of a running scheduler, instead of processes.")] = None,
    accept: Accept = False,
    watch: Annotated[bool, flag("Tell how far the sweep in a folder is.")] = False,
    yes: Annotated[bool, flag("Run more than a day, or than the disk holds.")] = False, as_json: Json = False,
) -> int:
    """Run the cases of a study and join them to one table; a stopped run is resumed.

    A study file, its values quantities or ranges:

        scene = "biorob2018"        # a scene file beside it, or a name of the catalogue
        request = "inductance"      # or pose, simulate, calibrate, quality
        [vary]                      # keys of the scene in quotes, arguments of the request bare
        "target.width" = ["8 mm", "15 mm", "22 mm"]
        dv = { from = "1 mm", to = "5 mm", count = 41 }
        [fixed]
        frequency = "5 MHz"

    It may also have several scenes, samples, derived keys, conditions, a refined grid, stages on the best cases: see
    "A batch" in the how-to pages.

    Example: sits-mech sweep study.toml -o widths -j 2
    """
    if watch:
        from sits_mech.batch.watch import watched

        for line in watched(study):
            write(f"{line}\n")
        return 0
    check_readable(study, "a readable study file")

    from sits_mech.batch.executors import workers
    from sits_mech.batch.forecast import noted
    from sits_mech.batch.studies.study import read_study
    from sits_mech.export.formats import check_exports

    asked = read_study(study)
    if plan:
        return _plan(asked, output, processes, dask)
    if output is None:
        raise SceneError("--output must be given: a folder for the result and finished cases; it is missing")
    check_exports(asked)
    with workers(processes, dask) as executor:
        planned = None if dask else noted(output, processes, yes=yes)
        statuses = _swept(asked, output, executor, as_json)
    taken = sum(times()[:4])
    if planned is not None:
        warn(f"planned: {planned:.3g} s of processor time; taken: {taken:.3g} s")
    if as_json:
        answer({"written": [str(output)], "statuses": dict(Counter(statuses)), "seconds": taken}, [], True)
    return exit_code_of(statuses, accept)


@app.command
def sensitivity(
    folder: Annotated[Path, Parameter(help='Folder of a sweep with combine = "saltelli".')], *,
    of: Annotated[str, Parameter(help="Variable of its table, such as L_v_percent.")], as_json: Json = False,
) -> int:
    """Sobol' indices: how much of a quantity's variance each varied key makes, alone and with others.

    Example: sits-mech sensitivity widths --of L_v_percent
    """
    from sits_mech.batch.run import open_sweep
    from sits_mech.batch.sensitivity import sensitivity as indices
    from sits_mech.quantities import as_jsonable
    from sits_mech.report.tables.cases import sensitivity_tables

    with open_sweep(folder) as data:
        found = indices(data, of)
    used, asked = found.design_rows
    if used < asked:
        warn(f"{used} of {asked} rows of the design: others have a case without a number, or are over a power of two")
    answer(as_jsonable(asdict(found)), sensitivity_tables(found), as_json)
    return 0


def _swept(asked: Study, output: Path, executor: Executor | None, as_json: bool) -> list[str]:
    """Run the stages of a study, print their tables, and return the statuses of all cases."""
    from sits_mech.batch.funnel import following, going_on
    from sits_mech.batch.run import keep_known
    from sits_mech.export.formats import export_case
    from sits_mech.readout.loads import each_of

    data = _ran(asked, output, executor, as_json)
    statuses, before, study = each_of(data), output, asked
    for number, stage in enumerate(asked.then, 1):
        chosen, place = going_on(data, stage), output / f"then-{number}"
        warn(f"then.{number}: {len(chosen)} of {data['status'].size} cases go on to {stage.name}")
        if not chosen:
            return [*statuses, FAILED]
        if stage.study is None:
            for case in (case + 1 for case in chosen):
                folder = place / f"case-{case}"
                warn(*export_case(before, case, stage.export, folder), f"written to {folder}")
            break
        first, study = (study, data), following(stage.study, study, chosen)
        keep_known(study, place, first, chosen)
        data = _ran(study, place, executor, as_json)
        statuses, before = statuses + each_of(data), place
    return statuses


def _ran(study: Study, folder: Path, executor: Executor | None, as_json: bool) -> xr.Dataset:
    """Run a study, print the table of its cases and what is to know about them, and return it."""
    from sits_mech.batch.adaptive import refinement_summary
    from sits_mech.batch.run import cases_aside, run_study
    from sits_mech.report.tables.cases import case_failures, case_remarks, case_table
    from sits_mech.store import STORE

    with progress_bar("cases") as progress:
        data = run_study(study, folder, executor=executor, progress=progress)
    if not as_json:
        print_table(case_table(data))
    aside = 0 if study.adaptive else cases_aside(study, folder)
    others = f"not in this table: {aside} finished case(s) of other values, kept in {folder / STORE}"
    others += " (latin: other samples for each number; sobol keeps them)" if study.combined == "latin" else ""
    chosen = [refinement_summary(data, study.adaptive)] if study.adaptive else []
    notes = [*_left_out(study), *chosen, *([others] if aside else [])]
    warn(*case_remarks(data), *case_failures(data), *notes, f"written to {folder}")
    return data


def _left_out(study: Study) -> list[str]:
    """Return a line on the cases that conditions leave out."""
    left = study.left_out
    return [f"left out: {left} of {left + study.count} cases, which break a condition of where"] if left else []


def _plan(study: Study, output: Path | None, processes: int, dask: str | None) -> int:
    """Print what is left of a study, and what it takes; cases that are tried are kept where there is a folder."""
    from tempfile import TemporaryDirectory

    from sits_mech.batch.executors import cluster_size
    from sits_mech.batch.forecast import forecast, note
    from sits_mech.batch.run import claim
    from sits_mech.report.tables.cases import plan_table, plan_words
    from sits_mech.store import opened, save_table

    if processes < 1:
        raise SceneError(f"processes must be one or more; got {processes}")
    processes = processes if dask is None else cluster_size(dask)
    begun = process_time()

    def extra() -> float:
        """Return the seconds before the first case, and of what a run imports at its end."""
        import xarray as xr

        here = process_time()
        with TemporaryDirectory() as folder:
            save_table(xr.Dataset({"status": ("case", ["ok"])}), Path(folder) / "result.nc")
        return begun + process_time() - here

    def tell(sofar: Forecast) -> None:
        """Print what is known so far."""
        warn(plan_words(sofar))

    if output is not None:
        claim(output, study)
    with nullcontext() if output is None else opened(output) as cases:
        found = forecast(study, cases, extra=extra, report=tell)
        if cases is not None:
            note(found, cases)
    print_table(plan_table(found, study.name, processes, cluster=dask is not None))
    warn(*_left_out(study))
    if study.adaptive:
        warn(f"adaptive: planned are the first cases of {study.count}; where the result bends more of them are solved")
    if study.then:
        warn("then: later stages are not planned, as their cases come from results")
    count, seconds = found.tried
    warn(f"tried {count} cases in {seconds:.2g} s{'' if output is None else f', kept in {output}'}")
    return 0
