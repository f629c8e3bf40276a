"""Commands that inform, begin a scene or fit data: catalog, doctor, schema, new, explain, fit."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sits_mech.cli.console import answer, deliver, deliver_picture, print_table, solving, warn
from sits_mech.cli.options import (
    Json,
    Load,
    Models,
    Output,
    Overrides,
    Ratio,
    Scene,
    app,
    check_readable,
    check_request,
    flag,
    output_of,
    sensor_of,
)
from sits_mech.units import SceneError


@app.command
def catalog() -> int:
    """List the catalogued sensors, silicones and metals.

    Example: sits-mech catalog
    """
    from sits_mech.report.tables.solves import key_table
    from sits_mech.scene.materials import metals, silicones
    from sits_mech.scene.sensor import catalogue

    print_table(key_table("sensors", list(catalogue().items())))
    print_table(key_table("silicones", [(name, f"{item.law}: {item.source}") for name, item in silicones().items()]))
    lines = [(name, f"{item.conductivity:.3g} S/m: {item.source}") for name, item in metals().items()]
    print_table(key_table("metals", lines))
    return 0


@app.command
def doctor(*, clear: Annotated[bool, flag("Clear the cache of prepared plates.")] = False) -> int:
    """Check that everything needed is installed, and show the cache of earlier commands.

    Example: sits-mech doctor
    """
    from sits_mech import disk_cache
    from sits_mech.cli.doctor import examine, healthy
    from sits_mech.report.tables.solves import key_table

    if clear:
        print_table(f"removed {disk_cache.clear()} files from {disk_cache.folder()}")
    parts = examine()
    print_table(key_table("parts", [(name, f"{version}  {purpose}") for name, version, purpose in parts]))
    return 0 if healthy(parts) else 2


@app.command
def schema(file: Literal["scene", "study", "requirements", "bench"], *, output: Output = None) -> int:
    """Print the JSON Schema of a kind of file, for completion and checks in editors.

    Example: sits-mech schema scene -o scene.schema.json
    """
    from sits_mech.report.records import json_text
    from sits_mech.schemas import schema_of

    deliver(json_text(schema_of(file)) + "\n", output)
    return 0


@app.command
def new(
    output: Annotated[Path, Parameter(help="Scene file to write.")], *,
    ask: Annotated[
        bool | None, Parameter(help="Ask for what is not given; else as usual. By default in a terminal.")
    ] = None,
    **options: Annotated[str, Parameter(help="--coils 3, --size \"12 mm\", ...: what the file has a comment for.")],
) -> int:
    """Write a first scene, with comments: one to four coils, a round target on a layer of silicone.

    Options are name, coils, layers, turns, inner (diameter), track, gap, target, size, thickness, silicone, layer, pad,
    frequency and converter.

    Example: sits-mech new sensor.toml --coils 3 --size "12 mm" --silicone dragon-skin-30 --layer "3 mm"
    """
    import sys
    import tomllib

    from rich.prompt import Prompt

    from sits_mech.inputs import checked
    from sits_mech.scene.begun import Beginning, first_scene
    from sits_mech.scene.files import write_text
    from sits_mech.scene.sensor import sensor_from

    if output.exists():
        raise SceneError(f"{output}: must be a new file; it is there")
    found = checked(Beginning, options, "options")
    if sys.stdin.isatty() if ask is None else ask:
        asked = ((name, key) for name, key in Beginning.model_fields.items() if name not in options)
        own = {name: Prompt.ask(str(key.description), default=str(key.default)) for name, key in asked}
        found = checked(Beginning, options | own, "options")
    text = first_scene(found)
    sensor_from(tomllib.loads(text), str(output))
    write_text(output, text)
    warn(f"written to {output}; next: sits-mech view {output} -o scene.png, sits-mech explain {output}")
    return 0


@app.command
def explain(
    scene: Scene, *, load: Load = Load(), models: Models = Models(),
    ladder: Annotated[bool, flag("Solve the load at each tolerance from 1e-1 to a tenth of --tolerance.")] = False,
    history: Annotated[Path | None, Parameter(help="CSV of loads over time, in place of a load.")] = None,
    overrides: Overrides = Overrides(), as_json: Json = False,
) -> int:
    """What a load or pose would solve, in what time, what it neglects, and what smaller errors would cost.

    Of a history its largest load, how many of its rows are solved at least, and in what time.

    Example: sits-mech explain biorob2018 --fx "0.5 N" --fz "2 N" --ladder
    Example: sits-mech explain finger.toml --history press.csv
    """
    sensor = sensor_of(scene, overrides)
    check_request(sensor, {}, **asdict(models))
    if history is not None and (ladder or load != Load()):
        came = "--ladder" if ladder else "a load"
        raise SceneError(f"--history: must be given without a load or --ladder; got {came}")
    if history is not None:
        from sits_mech.analysis.histories.price import history_price, peak_load
        from sits_mech.analysis.histories.read import read_history
        from sits_mech.report.tables.plan import price_table

        course = read_history(history, sensor)
        wrench = peak_load(sensor, course)
    else:
        wrench = load.solved(sensor, models.mechanics, models.tolerance, rough=True).wrench
    check_request(sensor, vars(wrench), **asdict(models))

    from sits_mech.analysis.ladder import ladder as solved
    from sits_mech.chain.plans.plan import plan
    from sits_mech.report.tables.plan import ladder_record, ladder_tables, plan_record, plan_tables, rung_line

    loads = [wrench] if wrench.components.any() else []
    with solving(sensor, loads, **asdict(models)) if loads else nullcontext():
        found = plan(sensor, loads, **asdict(models))
    record, tables = plan_record(sensor, found), plan_tables(sensor, found)
    if history is not None:
        price = history_price(sensor, course, **asdict(models))
        record |= {"history": price._asdict()}
        tables.append(price_table(price, str(history)))
    rungs = []
    if ladder:
        rungs = solved(sensor, wrench, **asdict(models), each=lambda rung, left: warn(rung_line(rung, left)))
        record |= ladder_record(rungs)
        tables += ladder_tables(rungs)
    answer(record, tables, as_json)
    return 0 if not rungs or any(one.status == "converged" for one in rungs) else 3


def _of_mode(text: str) -> tuple[str, str]:
    """Return mode and file of "MODE=FILE", or refuse them."""
    mode, _, file = text.partition("=")
    if mode not in ("planar", "biaxial", "shear", "compression") or not file:
        raise SceneError(f"--mode: must be planar=FILE, biaxial=FILE, shear=FILE or compression=FILE; got {text}")
    check_readable(Path(file), f"a readable {mode} test")
    return mode, file


@app.command
def fit(
    tensile: Annotated[Path | None, Parameter(help="File of a test machine: strain and stress.")] = None, *,
    relaxation: Annotated[Path | None, Parameter(help="Ramp and hold over time: gives prony.")] = None,
    cyclic: Annotated[Path | None, Parameter(help="Rising peaks with unloading: gives mullins.")] = None,
    mode: Annotated[list[str] | None, Parameter(help="Other tests: planar, biaxial, shear, compression=FILE.")] = None,
    law: str = "yeoh", max_strain: Ratio = 1.0, terms: Annotated[int, Parameter(help="Number of Ogden terms.")] = 2,
    length: Annotated[str | None, Parameter(help='Free length of the specimen, "25 mm", for displacements.')] = None,
    area: Annotated[str | None, Parameter(help='Area of its section, "24 mm^2", for forces.')] = None,
    slack: Annotated[str | None, Parameter(help='Strain before the stress begins, "3 %"; else as found.')] = None,
    show_only: Annotated[bool, Parameter(name="--show", negative=(), help="Show what the file holds.")] = False,
    output: Annotated[Path | None, output_of("Picture of data and fit.")] = None,
    as_json: Json = False,
) -> int:
    """Fit a silicone's constants: a law to a tensile test, rate to a relaxation test, softening to a cyclic one.

    The file has rows of numbers below a row of names, in any order, in English, German, French, Spanish or Japanese:
    strain, stretch or displacement, stress or force, with units in brackets or in a row below; "planar strain",
    "biaxial ...", "shear ..." and "compressive ..." for other tests, or --mode biaxial=FILE for files of their own.
    Tests over time have "time (s)" too. Without a tensile test the law is fitted to the envelope of the cyclic one.
    --show says and with -o draws what of a tensile file is taken, and fits nothing.

    Example: sits-mech fit tensile.csv --law yeoh --max-strain 1.0 --relaxation hold.csv --cyclic cycles.csv -o fit.png
    """
    from sits_mech.report.folder import checked_picture

    output = output and checked_picture(output)
    for path, kind in ((tensile, "tensile"), (relaxation, "relaxation"), (cyclic, "cyclic")):
        if path is not None:
            check_readable(path, f"a readable {kind} test")

    from sits_mech.analysis.material.fitted import fit_tests
    from sits_mech.analysis.material.tensile import Sizes, read_tensile
    from sits_mech.report.plots.fit import fit_figure, fitted_tables, read_figure, read_rows
    from sits_mech.report.tables.solves import key_table
    from sits_mech.silicone.material import Silicone, implausible
    from sits_mech.units import quantity

    asked = (("--length", length, "m"), ("--area", area, "m^2"), ("--slack", slack, ""))
    sizes = [None if text is None else quantity(text, unit, name) for name, text, unit in asked]
    given = Sizes(sizes[0], sizes[1], sizes[2], also=tuple(_of_mode(each) for each in mode or ()))
    if given.also and tensile is None:
        raise SceneError("--mode: must come with a tensile test; got none")
    if show_only:
        if tensile is None:
            raise SceneError("--show: must have a tensile test; got none")
        test = read_tensile(tensile, given)
        deliver_picture(output, lambda: read_figure(test))
        rows = read_rows(test)
        answer({"source": test.source, "found": [list(row) for row in rows]}, [key_table(test.source, rows)], as_json)
        return 0
    found = fit_tests(tensile, relaxation, cyclic, law=law, max_strain=max_strain, terms=terms, given=given)
    if found.fit is not None:
        slips = implausible(Silicone("", found.fit.law, found.fit.constants, math.inf))  # a fit tells no bulk modulus
        found = replace(found, fit=replace(found.fit, notes=(*found.fit.notes, *slips)))
    if output is not None:
        if found.fit is None or found.test is None:
            raise SceneError("-o: must have a tensile or a cyclic test to draw; got a relaxation test alone")
        deliver_picture(output, partial(fit_figure, found.test, found.fit))
    answer(found.record, fitted_tables(found), as_json)
    return 0
