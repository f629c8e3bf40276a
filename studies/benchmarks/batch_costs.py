"""What does a batch add to its solves, and what is left of one that is killed?

A hundred thousand magnetic cases over three plates (`inductance` in section) run in one process: what the engine adds
to a case is the processor time less that of the requests; beside it the memory, the files that it leaves, and what it
costs to open the table and to find every case done. Snapshots are the tables that were written before the last one.
Then loads of the nonlinear layer in one and in two processes, one BLAS thread each: what a second process costs in
processor time (its start, what it prepares anew), and what gain that leaves on two idle cores. Then a run that is
killed (SIGKILL) at instants by chance and begun again: rows that were kept and are no longer what they were, and
whether the table is that of a run without a stop. The same on a dask cluster of this machine, one of whose workers,
by chance, is killed every 10 s for two minutes. And the processor time of four workers over that of two and of one: on
two cores four are as fast as two, by as much as that ratio is near one.

What sharing saves is planned from some cases: of two thousand that differ in thickness, width and silicone, and of some
of six coils that rest under the same loads, which are then run.

Checked are counts and ratios, not seconds; the exit code is 1 where one is above its limit.
Run ``python -m benchmarks.batch_costs [--coarse] --output DIR``.
"""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from common.outputs import study_arguments, write_rows

import sits_mech as sm
from sits_mech import cases
from sits_mech.batch import run
from sits_mech.batch.executors import workers
from sits_mech.batch.forecast import forecast
from sits_mech.batch.studies.study import read_study
from sits_mech.store import STORE, Row, opened, read_table

if TYPE_CHECKING:
    from distributed import LocalCluster

MAGNETIC = """
scene = "biorob2018"
request = "inductance"
[vary]
"target.width" = ["8 mm", "10 mm", "12 mm"]
dh = {{ from = "-1 mm", to = "1 mm", count = {0} }}
dv = {{ from = "2 mm", to = "3 mm", count = {1} }}
[fixed]
model = "planar"
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
SIMULATE = """
scene = "biorob2018-w15"
request = "simulate"
[vary]
"elastomer.material" = ["ecoflex-00-10", "ecoflex-00-30", "ecoflex-00-50"]
"elastomer.thickness" = {{ from = "1.5 mm", to = "4 mm", count = 26 }}
"target.width" = {{ from = "8 mm", to = "18 mm", count = 26 }}
[fixed]
fz = "1 N"
{0}
"""
COILS = """
scene = "biorob2018-w15"
request = "simulate"
[vary]
"coils.C1.turns" = [8, 10, 12]
frequency = ["3 MHz", "5 MHz"]
"elastomer.thickness" = ["1.5 mm", "2 mm"]
fz = ["1 N", "2 N"]
[fixed]
{0}
"""
EXACT = ("", "")  # more of what is fixed, in SIMULATE and COILS
COARSE = ('mechanics = "linear"\nmagnetics = "planar"\ntolerance = 0.1',) * 2
Found = list[tuple[str, float, float]]
"""What, value, and its limit: NaN of none."""
FREE = float("nan")
STUDY_FILES = 4  # with SQLite's own
MORE = 1.5  # two more workers: each start takes some 7 s, plates with it, of 85; 1.3 on cores that others used as well
WHOLE = dict[tuple[int, int], Path]()  # folders of runs in this process that nothing stopped
FIRST = 20_000  # bytes of SQLite's log, more than before the first case


class Watch:
    """Processor seconds of the requests, and tables written, of runs in this process."""

    def __init__(self) -> None:
        self.solves, self.tables = 0.0, 0
        self._attempt, self._save = cases.attempt, run.save_table
        cases.attempt, run.save_table = self.attempt, self.save

    def attempt(self, function: Any, point: Mapping[str, Any]) -> Row:
        """Answer a case."""
        began = time.process_time()
        row = self._attempt(function, point)
        self.solves += time.process_time() - began
        return row

    def save(self, *table: Any) -> None:
        """Write a table."""
        self.tables += 1
        self._save(*table)


def timed(path: Path, folder: Path, processes: int = 1) -> float:
    """Return the processor seconds of a study, of this process and those that it started and that ended."""
    before = os.times()
    with workers(processes) as executor:
        run.run_study(read_study(path), folder, executor=executor)
    return sum(os.times()[:4]) - sum(before[:4])


def written(folder: Path, name: str, text: str) -> tuple[Path, Path]:
    """Return a study's file and a folder for it that holds nothing of an earlier run."""
    path = folder / f"{name}.toml"
    path.write_text(text)
    shutil.rmtree(folder / name, ignore_errors=True)
    return path, folder / name


def overhead(folder: Path, counts: tuple[int, int], most: float) -> Found:
    """Return what the engine adds to a magnetic case, what it leaves, and what a run costs that finds all done."""
    path, out = written(folder, "magnetic", MAGNETIC.format(*counts))
    timed(*written(folder, "first", MAGNETIC.format(2, 2)))  # imports, which a batch has once
    watch, count, WHOLE[counts] = Watch(), 3 * counts[0] * counts[1], out
    whole = timed(path, out)
    first, tables, solves = 1e3 * (whole - watch.solves) / count, watch.tables, watch.solves
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    before = time.process_time()
    with sm.open_sweep(out) as data:
        size = float(data["status"].size)
    opening = time.process_time() - before
    again = timed(path, out)
    return [
        ("magnetic cases", size, FREE), ("a solve [ms]", 1e3 * solves / count, FREE),
        ("overhead a case [ms]", first, FREE), ("overhead over solves", (whole - solves) / solves, most),
        ("snapshots", tables - 1, FREE), ("files", len(os.listdir(out)), STUDY_FILES), ("memory [MiB]", memory, 600.0),
        ("kept a case [bytes]", (out / STORE).stat().st_size / count, 2500.0),
        ("table opened in [s]", opening, FREE), ("the same again, all done, a case [ms]", 1e3 * again / count, FREE),
        ("solved again", float(watch.solves > solves), 0.0),
    ]


def two_processes(folder: Path, counts: tuple[int, int, float]) -> Found:
    """Return what a second process costs with loads of the layer, and the gain that leaves."""
    text = LOADS.format(*counts)
    one, both = timed(*written(folder, "one", text)), timed(*written(folder, "two", text), 2)
    return [
        ("mechanical cases", counts[0] * counts[1], FREE), ("processor, one process [s]", one, FREE),
        ("processor, two [s]", both, FREE), ("two over one, idle cores", 2.0 * one / both, FREE),
        ("another table", float(not same(folder / "one", folder / "two")), 0.0),
    ]


def sharing(folder: Path, fixed: tuple[str, ...]) -> Found:
    """Return what cases that share coils, pads or rests take over those that are solved alone, planned and taken."""
    rows = list[tuple[str, float, float]]()
    asked = {"thickness, width, silicone": SIMULATE.format(fixed[0]), "coils and loads": COILS.format(fixed[1])}
    for name, text in asked.items():
        path, out = written(folder, f"shared by {name}", text)
        plan = forecast(read_study(path))
        whole = plan.seconds()
        rows += [(f"{name}: cases", plan.cases, FREE), (f"{name}: planned [s]", whole, FREE)]
        rows += [(f"{name}: over the sum of single ones", whole / (whole + sum(plan.saved)), 0.6)]
    taken = timed(path, out)  # of the last
    return [*rows, (f"{name}: taken [s]", taken, FREE), (f"{name}: taken over planned", taken / whole, FREE)]


def same(one: Path, other: Path) -> bool:
    """Return whether the tables of two folders are the same to the last digit, but for the seconds."""
    first, second = (read_table(folder / run.TABLE).drop_vars("seconds") for folder in (one, other))
    return first.identical(second)


def unstopped(folder: Path, counts: tuple[int, int]) -> Path:
    """Return the folder of a run in this process that nothing stops."""
    if counts not in WHOLE:
        path, WHOLE[counts] = written(folder, f"whole, {counts[0]} x {counts[1]}", MAGNETIC.format(*counts))
        timed(path, WHOLE[counts])
    return WHOLE[counts]


def killed(folder: Path, counts: tuple[int, int], times: int) -> Found:
    """Return what is left of a run that is killed so many times, begun again, and at last let go on."""
    some = np.random.default_rng(36)
    path, out = written(folder, "killed", MAGNETIC.format(*counts))
    command = [sys.executable, "-c", "from sits_mech.cli.main import main; main()", "sweep", str(path), "-o", str(out)]
    log = out / f"{STORE}-wal"  # SQLite's, of what a run has written; the rows themselves are the run's alone
    known, lost, kills, most = dict[str, Row | None](), 0, 0, 0
    while kills < times:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while process.poll() is None and (not log.exists() or log.stat().st_size < FIRST):
            time.sleep(0.01)
        try:
            process.wait(some.uniform(0.0, 1.0))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            kills += 1
        else:
            break
        with opened(out) as found:
            rows = {name: found.get(name) for name in found.names}
        lost += sum(rows.get(name) != row for name, row in known.items())
        known, most = rows, max(most, len(rows) - len(known))
    timed(path, out)
    return [
        ("kills", kills, FREE), ("kept at the last", len(known), FREE), ("most of one run", most, FREE),
        ("kept rows lost", lost, 0.0),
        ("another table than without a stop", float(not same(out, unstopped(folder, counts))), 0.0),
    ]


def cluster(count: int) -> LocalCluster:
    """Return a cluster of this machine, of processes of one thread each, which may take their time to begin anew."""
    import dask
    from distributed import LocalCluster

    dask.config.set({"distributed.deploy.lost-worker-timeout": "5 minutes"})
    return LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None, silence_logs=50)


def workers_killed(folder: Path, counts: tuple[int, int], count: int, pause: float, times: int) -> Found:
    """Return what is lost where one of some workers is killed after each pause, so many times if the run lasts."""
    from distributed import Client

    some, kills = np.random.default_rng(36), list[float]()
    path, out = written(folder, "lost", MAGNETIC.format(*counts))
    with cluster(count) as found, Client(found) as client:
        done = threading.Event()

        def kill() -> None:
            while len(kills) < times and not done.wait(pause):
                alive = [each.pid for each in found.workers.values() if each.worker_address in found.scheduler.workers]
                if alive:  # else all are being begun anew; a nanny gives up a process that never was a worker
                    os.kill(int(some.choice(alive)), signal.SIGKILL)
                    kills.append(time.monotonic())

        killing = threading.Thread(target=kill)
        killing.start()
        data = sm.sweep(path, folder=out, executor=client)
        done.set()
        killing.join()
    with opened(out) as kept:
        lost = data["status"].size - len(kept.names)
    return [
        (f"cases on {count} workers", data["status"].size, FREE), ("workers killed", len(kills), FREE),
        ("seconds from first to last", kills[-1] - kills[0] if kills else 0.0, FREE), ("kept rows lost", lost, 0.0),
        ("another table than of one process", float(not same(out, unstopped(folder, counts))), 0.0),
    ]


def worker_counts(folder: Path, counts: tuple[int, int]) -> Found:
    """Return the processor time of four workers over that of two and of one, with the scheduler's and the run's own."""
    from distributed import Client

    seconds = dict[int, float]()
    for count in (1, 2, 4):
        path, out = written(folder, f"workers-{count}", MAGNETIC.format(*counts))
        with cluster(count) as found, Client(found) as client:
            before = time.process_time()
            sm.sweep(path, folder=out, executor=client)
            seconds[count] = time.process_time() - before + sum(client.run(time.process_time).values())
    return [
        ("processor, one worker [s]", seconds[1], FREE), ("four workers over one", seconds[4] / seconds[1], FREE),
        ("four workers over two", seconds[4] / seconds[2], MORE),
        ("another table of four", float(not same(folder / "workers-4", folder / "workers-1")), 0.0),
    ]


def main() -> int:
    """Run the batches and write what they cost."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    found = [
        *(overhead(folder, (8, 12), 0.5) if coarse else overhead(folder, (160, 210), 0.2)),
        *two_processes(folder, (3, 2, 3e-2) if coarse else (16, 8, 3e-3)),
        *sharing(folder, COARSE if coarse else EXACT),
        *killed(folder, (8, 12) if coarse else (40, 40), 2 if coarse else 20),
        *(workers_killed(folder, (8, 12), 2, 2.0, 1) if coarse else workers_killed(folder, (80, 150), 3, 10.0, 12)),
        *([] if coarse else worker_counts(folder, (60, 50))),
    ]
    rows = [{"what": what, "value": value, "limit": "" if limit != limit else limit} for what, value, limit in found]
    print(write_rows(rows, folder / "batch.csv"))
    return int(any(value > limit for _, value, limit in found))


if __name__ == "__main__":
    sys.exit(main())
