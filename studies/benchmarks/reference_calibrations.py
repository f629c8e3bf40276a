"""What does a published sensor show over a grid of loads, and how sure is that? A refinement whose order is measured.

Each calibration is solved on three rungs, the tolerances of which it stores. The value is the finest rung's. Where the
differences of the rungs shrink by a ratio r < 3/4 the error is what a geometric series leaves of them, the last
difference times r/(1 - r), r never below 1/4, by which an error of order 2 shrinks when cells are halved; where they do
not, no order is seen and the error is the finest rung's own estimate. Both are the largest over the loads, of full
scale, a signal each.

Run ``python -m benchmarks.reference_calibrations [--coarse] --output DIR``: writes reference_calibrations.json;
common/reference_calibrations.json is its full run. `error_against_time.py` takes it.
"""

from __future__ import annotations

import numpy as np
from common.accuracy import forget
from common.calibrations import CALIBRATIONS, FX, FZ, SIGNALS, Case, table
from common.outputs import study_arguments, write_references
from threadpoolctl import threadpool_limits

from sits_mech.quantities import Array

ABOUT = (
    "Signals [percent] of the catalogue's sensors over F_x [N] (rows) and F_z [N] (columns); error: the largest, "
    "over its full scale. Made by benchmarks/reference_calibrations.py: a refinement with measured order."
)


def left_by(first: Array, second: Array, third: Array, estimated: float) -> tuple[float, str]:
    """Return the error of the last of three refinements, and the words for it."""
    far, near = (float(np.max(np.abs(item))) for item in (second - first, third - second))
    ratio = near / far if far > 0.0 else 1.0
    if ratio >= 0.75:
        return estimated, f"differences {far:.1e} and {near:.1e} show no order: its own estimate"
    kept = max(ratio, 0.25)
    return near * kept / (1.0 - kept), f"differences {far:.1e} and {near:.1e} shrink by {ratio:.2g}"


def row_of(case: Case, tolerances: tuple[float, ...]) -> dict[str, object]:
    """Return a calibration as a row of the file."""
    solved = []
    for tolerance in tolerances:
        forget()
        solved.append(table(case, tolerance))
    row: dict[str, object] = {"name": case.name, "scene": case.scene, "mechanics": case.mechanics}
    row |= {"magnetics": case.magnetics, "F_x": list(FX), "F_z": list(FZ), "rungs": list(tolerances)}
    for signal in SIGNALS:
        values = [data[f"{signal}_percent"].to_numpy() for data in solved]
        full = float(np.ptp(values[-1]))
        own = float(solved[-1][f"error_{signal}_percent"].max()) / full
        error, words = left_by(*(item / full for item in values[-3:]), own)
        digits = [[float(f"{x:.8g}") for x in line] for line in values[-1]]
        row[signal] = {"percent": digits, "error": float(f"{error:.2g}"), "source": words}
    return row


def main() -> None:
    """Solve, measure, write."""
    coarse, folder = study_arguments(__doc__ or "")
    rows = []
    with threadpool_limits(limits=1):
        for case in CALIBRATIONS:
            rows.append(row_of(case, (3e-1, 1e-1, 3e-2) if coarse else case.rungs))
            print(case.name, *(rows[-1][signal] for signal in SIGNALS), sep="\n", flush=True)
    write_references(rows, ABOUT, folder / "reference_calibrations.json")


if __name__ == "__main__":
    main()
