"""What does `sits-mech calibrate` cost in processor time and memory, here and in another environment beside it?

Each repetition is a process of its own with an empty folder, and the environments take turns, so that what else the
machine does meets all of them. Run ``python studies/benchmark_calibrate.py [--coarse] [--other PYTHON] --output DIR``.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path
from typing import Any

from common.outputs import study_arguments, write_rows

SCENE = "biorob2018-w15"
COARSE = ("--fx", "0 N:0.5 N:2", "--fz", "0 N:1 N:2")
REPETITIONS = 5


def cost(python: str, extra: tuple[str, ...]) -> tuple[float, float]:
    """Return processor time, of user and system [s], and largest memory [MB] of one calibration."""
    kept = {name: value for name, value in os.environ.items() if python == sys.executable or name != "PYTHONPATH"}
    with tempfile.TemporaryDirectory() as folder:
        words = [python, "-m", "sits_mech", "calibrate", SCENE, *extra, "-o", f"{folder}/calibration"]
        quiet = subprocess.DEVNULL
        with subprocess.Popen(words, cwd=folder, env=kept, stdout=quiet, stderr=quiet) as process:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{python}: sits-mech calibrate must exit with 0; got {process.returncode}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


def row(name: str, costs: list[tuple[float, float]]) -> dict[str, Any]:
    """Return one row: medians over the repetitions, and the largest memory of all."""
    seconds, memory = zip(*costs, strict=True)
    spread = {"median_s": statistics.median(seconds), "least_s": min(seconds)}
    return {"environment": name, **spread, "memory_MB": max(memory)}


def main() -> None:
    """Write the table, print it, and the ratio where there are two environments."""
    parser = ArgumentParser(add_help=False)
    parser.add_argument("--other", type=Path, help="Interpreter of another environment.")
    other, sys.argv[1:] = parser.parse_known_args()
    coarse, folder = study_arguments(__doc__ or "")
    pythons = {"this": sys.executable} | ({} if other.other is None else {"other": str(other.other.absolute())})
    costs: dict[str, list[tuple[float, float]]] = {name: [] for name in pythons}
    for _ in range(1 if coarse else REPETITIONS):
        for name, python in pythons.items():
            costs[name].append(cost(python, COARSE if coarse else ()))
    rows = [row(name, found) for name, found in costs.items()]
    print(write_rows(rows, folder / "calibrate.csv"))
    if len(rows) == 2:
        ratio = rows[0]["median_s"] / rows[1]["median_s"]
        print(f"this over other: {ratio:.2f} in processor time")


if __name__ == "__main__":
    main()
