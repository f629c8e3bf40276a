"""How fast are forward map and inverse, and does the map's stated error hold? For two and three forces.

Closed-form coils around a centre, over the loads of the default calibrations: pressing lowers all, shear parts them. By
one core's processor time, many loads at once, the second run of two. The inverse is timed with the loads' readings as
they are, without the map's error; the share of random loads whose true error is within the stated one is beside it.
Run ``python -m benchmarks.readout [--coarse] --output DIR``.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common.outputs import study_arguments, write_rows

from sits_mech.quantities import Array
from sits_mech.readout.calibration import Calibration, calibration_of

ENDS = {"F_x": (-0.5, 0.5), "F_y": (-0.5, 0.5), "F_z": (0.0, 2.0)}
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
TRIANGLE = np.array([[0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]])
PAIR = np.array([[-1.0, 0.0], [1.0, 0.0]])
CASES = (  # coils, forces, loads along each force
    ("two forces, 9 x 9 loads, 2 coils", PAIR, ("F_x", "F_z"), 9),
    ("three forces, 5 x 5 x 5 loads, 3 coils", TRIANGLE, ("F_x", "F_y", "F_z"), 5),
    ("three forces, 5 x 5 x 5 loads, 4 coils", SQUARE, ("F_x", "F_y", "F_z"), 5),
    ("three forces, 9 x 9 x 9 loads, 4 coils", SQUARE, ("F_x", "F_y", "F_z"), 9),
)


def shown(forces: dict[str, Array], coils: Array) -> Array:
    """Return the inductances at forces [N], shape (m, n) [H]."""
    x, z = forces["F_x"], forces["F_z"]
    y = forces.get("F_y", np.zeros_like(x))
    common = 2.0e-6 * np.exp(-0.02 * z) * (1.0 + 0.004 * (x**2 + y**2))
    odd = [(a * np.sin(0.8 * x) + b * np.sin(0.8 * y)) * (1.0 + 0.1 * z) + 0.02 * a * b * x * y for a, b in coils]
    return common[:, None] + 3e-8 * np.stack(odd, -1)


def known(coils: Array, names: tuple[str, ...], count: int) -> Calibration:
    """Return the calibration through a grid of loads."""
    axes = np.meshgrid(*(np.linspace(*ENDS[name], count) for name in names), indexing="ij")
    points = np.stack([axis.ravel() for axis in axes], -1)
    values = shown(dict(zip(names, points.T, strict=True)), coils)
    labels = [f"C{k + 1}" for k in range(len(coils))]
    return calibration_of(points, values, forces=names, coils=labels, free=("H", np.full(len(coils), 2e-6)))


def row(case: tuple[str, Array, tuple[str, ...], int], count: int) -> dict[str, Any]:
    """Return times and errors of a case, over so many loads."""
    title, coils, names, size = case
    began = time.process_time()
    cal = known(coils, names, size)
    made = time.process_time() - began
    F = np.random.default_rng(1).uniform(cal.low, cal.high, (count, len(names)))
    for _ in range(2):
        began = time.process_time()
        L = cal.forward(F)
        forward = time.process_time() - began
        began = time.process_time()
        back = cal.inverse(L)
        inverse = time.process_time() - began
    true = cal.inverse(shown(dict(zip(names, F.T, strict=True)), coils))
    inside = np.abs(true.forces - F) <= true.error + 1e-9
    return {
        "case": title, "map_s": made, "loads_per_s": count / forward, "us_per_reading": 1e6 * inverse / count,
        "back": float(np.nanmax(np.abs(back.forces - F))), "ok": float(np.mean(true.status == "ok")),
        "within_error": float(np.mean(inside)), "error_N": float(np.nanmax(true.error)),
    }


def main() -> None:
    """Write the table and print it."""
    coarse, folder = study_arguments(__doc__ or "")
    print(write_rows([row(case, 2_000 if coarse else 200_000) for case in CASES], folder / "readout.csv"))


if __name__ == "__main__":
    main()
