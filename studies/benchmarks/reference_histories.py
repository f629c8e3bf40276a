"""Where does an independent code put the target of pads that remember, along histories of their load?

NGSolve's elements of high order (common/ngsolve_history.py) for every pad and path of common/history_cases.py. Poses at
the recorded times come from two meshes with one time step each, of which the limit is taken by an assumed ratio of
their differences (of a thin layer from three, by the measured one), and from steps of a half (and of a quarter) on the
first mesh, carried on by the order of the rule, 2.
The error is the larger of what the limit of the meshes adds and of what the last halving leaves beside that order, over
the largest displacement of the history, an angle counted at the target's end.

NGSolve is no dependency: ``pip install ngsolve`` beside the package; without it the study says so and ends. Run
``python -m benchmarks.reference_histories [--coarse] --output DIR``; `--only WORD` makes the rows with that word in
their names, added to what is in DIR. common/reference_histories.json is its full run: half an hour of processor time.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np
from common.history_cases import PADS, PATHS, LoadPath, takes, wrenches
from common.ngsolve_history import PadHistory
from common.ngsolve_solve import discrete
from common.outputs import add_references
from common.reference_cases import Case

from sits_mech.quantities import Array

MESHES = {"plane": ((5, 2), (5, 3)), "round": ((5, 2), (5, 3)), "box": ((3, 1), (3, 2))}
SHRINK = {"plane": 0.5, "round": 0.5, "box": 0.25}  # of the differences of two meshes, where there is no third
THIN = 0.15  # of the target's width: layers that crease next to the bond take a third mesh and are held at every point
THIRD, POINTWISE = (5, 4), 50.0  # of these: the mesh, and part of the bulk modulus at every point [shear moduli]
PARTS = (2, 4)  # of the steps
QUICK = ("disc 6 on 10 x 4, neo-Hooke, two branches: step",)
ABOUT = (
    "Motion (d_h, sink, alpha) [m, m, rad] of the target of pads that remember, at time [s], under loads (F_x, F_z) "
    "[N] linear between these times; a layer in plane strain is 1 m long; contact off. error: of the reference, over "
    "the largest displacement of the history, an angle counted at the target's end. Made by "
    "benchmarks/reference_histories.py with NGSolve 6.2; source: elements and meshes, how their differences shrink, "
    "what halving the step changes."
)


def is_thin(pad: Case) -> bool:
    """Whether a pad creases next to the bond."""
    return pad.thickness < THIN * pad.target[0]


def followed(pad: Case, path: LoadPath, mesh: tuple[int, int], parts: int) -> Array:
    """Return d_h, sink [mm] and alpha at the recorded times, shape (n, 3), each step in equal parts."""
    began, times = time.process_time(), path.times(parts)
    loads = 1e3 / pad.mu * wrenches(pad, path, times) * (1e-3 if pad.kind == "plane" else 1.0)
    model = replace(discrete(pad, *mesh, not any(path.F_x)), pointwise=POINTWISE if is_thin(pad) else 0.0)
    found = PadHistory(model, pad.prony, pad.mullins).follow(times, loads)[::parts] * [1.0, -1.0, 1.0]
    print(f"   Q{mesh[0]}, {mesh[1]} layers, {len(times) - 1} steps: largest {np.abs(found).max(axis=0)}, "
          f"{time.process_time() - began:.0f} s", flush=True)
    return np.asarray(found)


def reference(pad: Case, path: LoadPath, coarse: bool) -> tuple[Array, float, str]:
    """Return the motion at the recorded times, its relative error and how it came about."""
    meshes = (*MESHES[pad.kind], *((THIRD,) if is_thin(pad) and not coarse else ()))
    row = [followed(pad, path, mesh, 1) for mesh in meshes]
    parts = PARTS[: 2 if is_thin(pad) and not coarse else 1]
    finer = [row[0], *(followed(pad, path, meshes[0], count) for count in parts)]
    lever = np.array([1.0, 1.0, 0.5 * pad.target[0]])
    size = float(np.max(np.abs(row[-1] * lever)))
    ratio, words = SHRINK[pad.kind], f"Q{meshes[0][0]}, meshes of {meshes[0][1]} to {meshes[-1][1]} layers"
    if len(row) > 2:
        far, near = ((b - a) * lever for a, b in zip(row[-3:-1], row[-2:], strict=True))
        ratio = float(np.sum(far * near) / np.sum(far * far))
    words += f", differences {'shrink' if len(row) > 2 else 'taken to shrink'} by {ratio:.2g}"
    added = (row[-1] - row[-2]) * (ratio / (1.0 - ratio) if 0.0 < ratio < 0.75 else 1.0)
    steps = [b - a for a, b in zip(finer[:-1], finer[1:], strict=True)]
    carried = sum(steps) + steps[-1] / 3.0
    left = np.abs(steps[-1] / 3.0 if len(steps) < 2 else steps[-1] - steps[-2] / 4.0)
    sizes = [float(np.max(np.abs(one) * lever)) / size for one in (added, left)]
    words += f", limit adds {sizes[0]:.1e}; steps in 1 to {2 ** len(steps)} parts, beside order 2 {sizes[1]:.1e}"
    return row[-1] + added + carried, max(sizes), words


def row_of(pad: Case, name: str, coarse: bool) -> dict[str, object]:
    """Return a history as a row of the file, in SI."""
    path = PATHS[name]
    found, error, words = reference(pad, path, coarse)
    times = path.times()
    moved = found * [1e-3, 1e-3, 1.0]
    return {
        "name": f"{pad.name}: {name}", "model": "planar" if pad.kind == "plane" else "block", "scene": pad.changes,
        "lever": 0.5e-3 * pad.target[0], "height": 1e-3 * pad.height, "time": [float(f"{x:.10g}") for x in times],
        "load": [[float(f"{x:.10g}") for x in one] for one in wrenches(pad, path, times)[:, :2]],
        "moved": [[float(f"{x:.7g}") for x in one] for one in moved],
        "error": float(f"{error:.2g}"), "source": words,
    }


def main() -> None:
    """Follow and write, history by history."""
    taken = ((pad, name) for pad in PADS for name in PATHS if takes(pad, PATHS[name]))
    rows = {f"{pad.name}: {name}": partial(row_of, pad, name) for pad, name in taken}
    add_references(__doc__, ABOUT, "reference_histories.json", QUICK, rows)


if __name__ == "__main__":
    main()
