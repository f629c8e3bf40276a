"""What does `sits-mech calibrate` cost in processor time and memory: two forces, three axes, another environment?

The default calibration over two forces, and beside it one of 5 x 5 x 5 loads of three forces. Each repetition is a
process of its own with an empty folder and an empty cache, and all take turns, so that what else the machine does meets
all of them; another environment has the first of them alone.

Run ``python -m benchmarks.calibrate [--coarse] [--other PYTHON] --output DIR``.
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

Words = tuple[str, ...]
TWO: Words = ("biorob2018-w15",)
THREE: Words = ("triaxial-4", "--fx", "-0.5 N:0.5 N:5", "--fy", "-0.5 N:0.5 N:5", "--fz", "0 N:2 N:5")
COARSE: Words = ("--fx", "0 N:0.5 N:2", "--fz", "0 N:1 N:2", "--tolerance", "0.1", "--mechanics", "linear")
REPETITIONS = 5


def cost(python: str, request: Words) -> tuple[float, float]:
    """Return processor time, of user and system [s], and largest memory [MB] of one calibration."""
    kept = {name: value for name, value in os.environ.items() if python == sys.executable or name != "PYTHONPATH"}
    with tempfile.TemporaryDirectory() as folder:
        kept["SITS_MECH_CACHE"] = f"{folder}/cache"
        words = [python, "-m", "sits_mech", "calibrate", *request, "-o", f"{folder}/calibration"]
        quiet = subprocess.DEVNULL
        with subprocess.Popen(words, cwd=folder, env=kept, stdout=quiet, stderr=quiet) as process:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 4):  # 4: some loads are above the tolerance, or beyond the data
        raise SystemExit(f"{python}: sits-mech calibrate must exit with 0 or 4; got {process.returncode}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


def row(name: str, costs: list[tuple[float, float]]) -> dict[str, Any]:
    """Return one row: medians over the repetitions, and the largest memory of all."""
    seconds, memory = zip(*costs, strict=True)
    spread = {"median_s": statistics.median(seconds), "least_s": min(seconds)}
    return {"calibration": name, **spread, "memory_MB": max(memory)}


def main() -> None:
    """Write the table, print it, and the ratios to the first row."""
    parser = ArgumentParser(add_help=False)
    parser.add_argument("--other", type=Path, help="Interpreter of another environment.")
    other, sys.argv[1:] = parser.parse_known_args()
    coarse, folder = study_arguments(__doc__ or "")
    asked = {"two forces": (sys.executable, TWO), "three axes": (sys.executable, THREE)}
    if other.other is not None:
        asked["two forces, other environment"] = (str(other.other.absolute()), TWO)
    costs: dict[str, list[tuple[float, float]]] = {name: [] for name in asked}
    for _ in range(1 if coarse else REPETITIONS):
        for name, (python, request) in asked.items():
            costs[name].append(cost(python, (*request[:1], *COARSE) if coarse else request))
    rows = [row(name, found) for name, found in costs.items()]
    print(write_rows(rows, folder / "calibrate.csv"))
    for found in rows[1:]:
        print(f"{found['calibration']} over {rows[0]['calibration']}: {found['median_s'] / rows[0]['median_s']:.2f}")


if __name__ == "__main__":
    main()
