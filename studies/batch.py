"""What does a scripted batch run cost? Overhead of a case, gain of a second process, a kill and what is left to do.

A thousand magnetic cases (25 places by 40 gaps over the published coils) run in one process: what the engine adds to a
case is the wall time less that of the solves. The same study again finds every case done. Then loads of the nonlinear
layer in one and in two processes, one BLAS thread each, started cold: wall seconds, and seconds of the processor, which
tell on a busy machine, too, what a second process costs (its start, what it prepares anew) and what gain is left on two
idle cores. Last a run that is killed (SIGKILL) once a third of its cases are kept, then resumed: no kept case is
computed again, the table is that of the uninterrupted run.

Run ``python studies/batch.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from common.outputs import study_arguments, write_rows

from sits_mech.batch.executors import workers
from sits_mech.batch.run import run_study
from sits_mech.batch.study import read_study
from sits_mech.cases import read_table

MAGNETIC = """
scene = "biorob2018"
request = "inductance"
[vary]
dh = {{ from = "-1 mm", to = "1 mm", count = {0} }}
dv = {{ from = "2 mm", to = "3 mm", count = {1} }}
"""
LOADS = """
scene = "biorob2018"
request = "pose"
[vary]
fx = {{ from = "0.1 N", to = "1 N", count = {0} }}
fz = {{ from = "1 N", to = "4 N", count = {1} }}
[fixed]
model = "planar"
tolerance = {2}
"""


def timed(path: Path, folder: Path, processes: int = 1) -> float:
    """Return the wall seconds of a study."""
    began = time.perf_counter()
    with workers(processes) as executor:
        run_study(read_study(path), folder, executor=executor)
    return time.perf_counter() - began


def overhead(folder: Path, counts: tuple[int, int]) -> list[tuple[str, float]]:
    """Return what the engine adds to a magnetic case, and what a run costs that finds all done."""
    path, out = folder / "magnetic.toml", folder / "magnetic"
    path.write_text(MAGNETIC.format(*counts))
    wall, cases = timed(path, out), counts[0] * counts[1]
    solves = float(read_table(out / "result.nc")["seconds"].sum())
    return [
        ("magnetic cases", cases), ("wall [s]", wall), ("of it solves [s]", solves),
        ("overhead a case [ms]", 1e3 * (wall - solves) / cases), ("the same again, all done [s]", timed(path, out)),
    ]


def two_processes(folder: Path, counts: tuple[int, int, float]) -> list[tuple[str, float]]:
    """Return how much sooner two processes are done with loads of the layer."""
    path = folder / "loads.toml"
    path.write_text(LOADS.format(*counts))
    before = os.times()
    one, between = timed(path, folder / "one"), os.times()
    two, after = timed(path, folder / "two", 2), os.times()
    own = between.user + between.system - before.user - before.system
    both = after.children_user + after.children_system - between.children_user - between.children_system
    same = read_table(folder / "one" / "result.nc").drop_vars("seconds").identical(
        read_table(folder / "two" / "result.nc").drop_vars("seconds")
    )
    return [
        ("mechanical cases", counts[0] * counts[1]), ("one process [s]", one), ("two processes [s]", two),
        ("two over one", one / two), ("processor, one process [s]", own), ("processor, both of two [s]", both),
        ("two over one, idle cores", 2.0 * own / both), ("same table", float(same)),
    ]


def killed(folder: Path, counts: tuple[int, int, float]) -> list[tuple[str, float]]:
    """Return what is kept of a killed run, what of it is computed again, and whether the resumed table is the same."""
    path, out = folder / "killed.toml", folder / "killed"
    path.write_text(LOADS.format(*counts))
    command = "from sits_mech.cli.main import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command, "sweep", str(path), "-o", str(out)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )
    cases, third = out / "cases", counts[0] * counts[1] // 3
    while process.poll() is None and (not cases.exists() or len(os.listdir(cases)) < third):
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = {item.name: item.stat().st_mtime_ns for item in cases.glob("*.json")}
    seconds = timed(path, out)
    again = sum((cases / name).stat().st_mtime_ns != when for name, when in kept.items())
    same = read_table(out / "result.nc").drop_vars("seconds").identical(
        read_table(folder / "one" / "result.nc").drop_vars("seconds")
    )
    return [
        ("cases kept of the killed run", len(kept)), ("of them computed again", again), ("resumed in [s]", seconds),
        ("same table as uninterrupted", float(same)),
    ]


def main() -> None:
    """Run the batches and write what they cost."""
    coarse, folder = study_arguments(__doc__ or "")
    loads = (3, 2, 3e-2) if coarse else (8, 6, 3e-3)
    for name in ("magnetic", "one", "two", "killed"):  # of an earlier run, which would leave nothing to time
        shutil.rmtree(folder / name, ignore_errors=True)
    found = [
        *overhead(folder, (4, 5) if coarse else (25, 40)), *two_processes(folder, loads), *killed(folder, loads),
    ]
    print(write_rows([{"what": what, "value": value} for what, value in found], folder / "batch.csv"))


if __name__ == "__main__":
    main()
