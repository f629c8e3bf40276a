"""Commands for loads in time: simulate --history, cycle."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from sits_mech.cli.console import answer, deliver_picture, exit_code_of, progress_bar, warn
from sits_mech.cli.options import (
    Accept,
    Json,
    Load,
    Models,
    Output,
    Overrides,
    Picture,
    Quantity,
    Scene,
    app,
    check_request,
    flag,
    sensor_of,
)
from sits_mech.units import quantity

if TYPE_CHECKING:
    from sits_mech.scene.sensor import Sensor


def through_history(
    sensor: Sensor, path: Path, models: Models, rcount: int | None, output: Path | None, as_json: bool, accept: bool
) -> int:
    """Follow a history of loads, and the converter through it."""
    from sits_mech.analysis.histories.price import history_price
    from sits_mech.analysis.histories.read import read_history
    from sits_mech.analysis.histories.response import in_time
    from sits_mech.analysis.histories.scan import checked_count, with_codes
    from sits_mech.notes import unpacked_omissions
    from sits_mech.report.folder import prepare_folder
    from sits_mech.report.history import history_record, history_table, write_history
    from sits_mech.report.tables.plan import left_out_tables

    loads, count = read_history(path, sensor), checked_count(sensor, rcount)
    folder = None if output is None else prepare_folder(output, cases=False)
    price = history_price(sensor, loads, **asdict(models))
    warn(f"to solve: {price.solved} times of {price.rows} rows or more, about {price.seconds:.2g} s")
    with progress_bar("history [%]") as progress:
        data = with_codes(sensor, in_time(sensor, loads, **asdict(models), progress=progress), rcount=count)
    unsolved = unpacked_omissions(data.attrs["left_out"])
    answer(history_record(data, unsolved), [history_table(data), *left_out_tables(unsolved)], as_json)
    if folder is not None:
        warn(*write_history(sensor, data, folder))
        warn(f"written to {folder}")
    return exit_code_of(data["status"].to_numpy().tolist(), accept, (data.attrs["error"], models.tolerance))


@app.command
def cycle(
    scene: Scene, *, load: Load = Load(), models: Models = Models(), period: Quantity = "1 s", cycles: int = 2,
    full: Annotated[bool, flag("Also solve each point of the pad: the difference.")] = False,
    output: Output = None, picture: Picture = None, accept: Accept = False,
    overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """How wide is the hysteresis loop of the signals under a cyclic load? For silicones with prony or mullins.

    The pad is taken as a whole, which is fast; --full solves every point of it as `simulate --history` does, and prints
    the difference. -o writes the table over time as netCDF, --picture the loops; with --full those of the full solve.

    Example: sits-mech cycle soft.toml --fz "4 N" --period "2 s" --cycles 3 -o cycle.nc --picture loops.pdf
    """
    from sits_mech.report.folder import checked_file, checked_picture

    output = output and checked_file(output)
    picture = picture and checked_picture(picture, "--picture")
    sensor, seconds = sensor_of(scene, overrides), quantity(period, "s", "--period")
    check_request(sensor, vars(load.wrench(sensor)), **asdict(models))

    from sits_mech.analysis.cycle import load_cycle, triangle
    from sits_mech.analysis.histories.full_cycle import full_cycle
    from sits_mech.report.tables.loops import difference_record, difference_table, loop_curves, loop_record, loop_table
    from sits_mech.store import save_table

    asked = sensor, load.wrench(sensor), triangle(seconds, cycles)
    data = load_cycle(*asked, **asdict(models))
    if not full:
        answer(loop_record(data), [loop_table(data)], as_json)
    else:
        with progress_bar("full cycle [%]") as progress:
            solved = full_cycle(*asked, **asdict(models), progress=progress)
        record = loop_record(solved) | {"cheap": difference_record(data, solved)}
        answer(record, [loop_table(solved), difference_table(data, solved)], as_json)
        data = solved
    if output is not None:
        save_table(data, output)
        warn(f"written to {output}")
    deliver_picture(picture, lambda: loop_curves(data))
    return exit_code_of([data.attrs["status"]], accept, (data.attrs["error"], models.tolerance))
