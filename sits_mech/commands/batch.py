"""What does a whole study give? sweep."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sits_mech.commands.options import app
from sits_mech.console import progress_bar, show, warn


@app.command
def sweep(
    study: Annotated[Path, Parameter(help="Study file: scene, request, vary, fixed.")], *,
    output: Annotated[Path, Parameter(name=["--output", "-o"], help="Folder of the result and of finished cases.")],
    processes: Annotated[int, Parameter(name=["--processes", "-j"], help="Of this machine.")] = 1,
    dask: Annotated[str | None, Parameter(help="Address of a running scheduler, instead of processes.")] = None,
) -> int:  # fmt: skip
    """Run the cases of a study and join them to one table; a stopped run goes on.

    Example: sits-mech sweep study.toml -o widths -j 2
    """
    from sits_mech.batch.executors import workers
    from sits_mech.batch.run import cases_aside, run_study
    from sits_mech.batch.study import read_study
    from sits_mech.report.case_table import case_failures, case_table

    asked = read_study(study)
    with workers(processes, dask) as executor, progress_bar("cases") as progress:
        data = run_study(asked, output, executor=executor, progress=progress)
    show(case_table(data))
    missing, aside = case_failures(data), cases_aside(asked, output)
    others = f"not in this table: {aside} finished case(s) of other values, kept in {output / 'cases'}"
    for line in [*missing, *([others] if aside else []), f"written to {output}"]:
        warn(line)
    return 3 if missing else 0
