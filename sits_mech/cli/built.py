"""The command for a built sensor: adapt."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from sits_mech.cli.console import answer, warn
from sits_mech.cli.options import Folder, Json, Output, Quantity, app, check_readable, si_of

if TYPE_CHECKING:
    from sits_mech.analysis.built.adaptation import Adaptation
    from sits_mech.analysis.built.prior import Prior
    from sits_mech.readout.measured import Measured


@app.command
def adapt(
    folder: Folder, *,
    bench: Annotated[Path | None, Parameter(help="CSV: F_x, F_z, ..., L1 [uH] or code1, ..., depth [mm].")] = None,
    plan: Annotated[int | None, Parameter(help="How many loads to choose, before anything is read.")] = None,
    rig: Annotated[Literal["weights", "press", "stage"], Parameter(help="What the loads are made with.")] = "stage",
    free: Annotated[str, Parameter(help='What is unknown: "modulus, gap=0+-0.3 mm"; by default all that may be.')] = "",
    noise: Annotated[Quantity | None, Parameter(help="Noise of a reading; by default the converter's.")] = None,
    load_noise: Annotated[Quantity | None, Parameter(help="Noise of a load; 0.1 % of the largest.")] = None,
    depth_noise: Annotated[Quantity, Parameter(help="Noise of the way down.")] = "10 um",
    clock: Annotated[Quantity | None, Parameter(help="External clock of the codes; the part's largest.")] = None,
    check: Annotated[int | None, Parameter(help="Samples of the posterior, to check its approximation.")] = None,
    strict: Annotated[bool, Parameter(negative="", help="Refuse readings that hardly are of such a sensor.")] = False,
    output: Output = None, as_json: Json = False,
) -> int:
    """Which sensor was built? A few readings correct a calibration, or --plan says which loads to read.

    Five readings under known loads (--bench) find what is not known of the built sensor: modulus, gap, tilt, leads, the
    load cell's scale. With -o scene and table of what was found are written as a calibration, for invert and export.

    Example: sits-mech adapt calibration --plan 5 --rig stage
    Example: sits-mech adapt calibration --bench bench.csv -o built
    """
    from sits_mech.units import SceneError

    if (bench is None) == (plan is None):
        raise SceneError(f"adapt: must have either --bench FILE or --plan N; got {'both' if bench else 'none'}")
    if bench is not None:
        check_readable(bench, "a readable measurement")

    from sits_mech.analysis.built.prior import prior_of
    from sits_mech.report.folder import read_calibration
    from sits_mech.report.tables import built as tables

    sensor, data = read_calibration(folder)
    unknown = [part.strip() for part in free.split(",") if part.strip()]
    by_load, by_depth = si_of(load_noise, "N", "--load-noise"), si_of(depth_noise, "m", "--depth-noise")
    noises: dict[str, Any] = {"load_noise": by_load, "depth_noise": by_depth}
    prior = prior_of(sensor, data, unknown, noise=si_of(noise, "H", "--noise"))
    if plan is not None:
        from sits_mech.analysis.built.load_plan import plan_loads

        chosen = plan_loads(prior, plan, rig, **noises)
        answer(tables.plan_record(chosen), tables.plan_tables(chosen), as_json)
        return 0
    found, said = _adapted(prior, _read(prior, Path(str(bench)), si_of(clock, "Hz", "--clock")), noises)
    record = tables.adaptation_record(found, said)
    answer(record, [tables.adaptation_table(record, str(bench))], as_json)
    if said:
        warn(f"{bench}: {said}")
    if check is not None:
        warn(_checked(found, check))
    if strict and tables.verdict(record).startswith("hardly"):
        raise SceneError(f"{bench}: must be readings of such a sensor; {tables.verdict(record)}")
    if output is not None:
        _write(found, output)
    return 0


def _read(prior: Prior, path: Path, clock: float | None) -> Measured:
    """Return what a bench recorded of a sensor."""
    from sits_mech.analysis.built.comparison import tank_of
    from sits_mech.readout.loads import fixed
    from sits_mech.readout.measured import read_measured
    from sits_mech.units import SceneError

    tank, held = tank_of(prior.sensor, prior.data, clock), fixed(prior.data)
    found = read_measured(path, prior.forces, prior.sensor.coil_names, tank, held, least=1, unseen=True)
    if found.poses is not None:
        raise SceneError(f"{path}: must be of loads, or depths and loads that are nan; got poses: sits-mech compare")
    return found


def _adapted(prior: Prior, measured: Measured, noises: dict[str, Any]) -> tuple[Adaptation, str]:
    """Return what readings tell, and what is wrong with strange ones; raise SceneError where they tell nothing."""
    from sits_mech.analysis.built.adaptation import adapt as adapted
    from sits_mech.analysis.built.mistakes import STRANGE, mistake
    from sits_mech.units import SceneError

    try:
        found = adapted(prior, measured, **noises)
    except SceneError as error:
        said = mistake(prior, measured, None, **noises)
        raise SceneError(f"{error}{f'; {said}' if said else ''}") from None
    return found, mistake(prior, measured, found, **noises) if found.p_value < STRANGE else ""


def _checked(found: Adaptation, count: int) -> str:
    """Return in words how far the approximation of a posterior is from its samples."""
    from sits_mech.analysis.built.adaptation import sampled
    from sits_mech.units import SceneError

    if count < 2:
        raise SceneError(f"--check: must be two or more samples; got {count}")
    by = sampled(found, count)
    return (f"posterior by {count} samples ({100.0 * by.settled:.0f} % of them settled): means within {by.shift:.2g} "
            f"deviations, widths within {100.0 * by.width:.0f} %, of forces within {100.0 * by.force_width:.0f} %")


def _write(found: Adaptation, output: Path) -> None:
    """Write scene, table and pictures of what was found as a calibration."""
    from sits_mech.analysis.built.corrected import corrected
    from sits_mech.report.folder import prepare_folder
    from sits_mech.report.pictures.built import adaptation_figure
    from sits_mech.report.pictures.curves import save_figure
    from sits_mech.report.written import write_calibration

    folder = prepare_folder(output)
    sensor, data = corrected(found)
    for line in write_calibration(sensor, data, folder):
        warn(line)
    save_figure(adaptation_figure(found), folder / "adapted.png")
    warn(f"written to {folder}")
