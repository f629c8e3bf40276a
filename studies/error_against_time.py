"""How much error for how much time? Of the flagship in one picture, of each question in a panel of another.

A load in 3D, a load in section, a pose, a calibration: each problem of a question is solved to finer and finer
tolerances, from the scene on, with caches emptied, on one BLAS thread; times are processor time. Problems differ, and
no front is drawn across them. A point whose reference is not five times better is not counted. The sentence
printed for each question counts what answers say of themselves: the seconds of those whose estimate is within the
requested tolerance, and the least estimate there is.

References. Loads: NGSolve 6.2, high-order elements on refined meshes (common/reference_pads.json says of each how, and
how sure; benchmarks/reference_pads.py makes them). Errors are over the size of the displacement, an angle counted at
the target's end. Poses: the change of inductance of coils below copper 0.2 mm thick at 5 MHz, NGSolve 6.2. In section p
= 5 within a radius of 20 m, which agrees with itself to 1e-7 and with GetDP 3.2 (1e-6); coaxial disc p = 6 (1e-6);
plate 8 x 8 mm orders 2 to 4 on two kinds of mesh (2e-4). Errors are over the largest change. Calibration: a refinement
with measured order (common/reference_calibrations.json, made by benchmarks/reference_calibrations.py). Errors: the
largest of a signal over the loads, of full scale.

Run ``python studies/error_against_time.py [--coarse] --output DIR``;
the pictures of docs/theory/errors.md and of the gallery are its full run.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from benchmarks.mechanics_accuracy import judged
from common.accuracy import Rung, forget, ladder_figure, machine, rung_rows, verdict
from common.calibrations import CALIBRATIONS, SIGNALS, Case, errors, reference, table
from common.outputs import study_arguments, write_rows
from common.references import stored_references
from threadpoolctl import threadpool_limits

from sits_mech.chain.models import MAGNETICS
from sits_mech.quantities import Pose
from sits_mech.report.pictures.style import save_figure
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
FULL, QUICK = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3), (1e-2,)
SOLID = (
    "disc 10 on 20 x 2, small press", "disc 10 on 20 x 2, small shear", "flush disc 20 x 0.1, film",
    "disc 8 on 12 x 3, gent", "biorob2018-w15, 0.5 N and 2 N",
)
PLANE = (
    "layer, small press", "layer, small shear", "flush layer, small press", "square section, pulled",
    "layer, pressed 5 %",
)


class Answered(NamedTuple):
    """A problem of magnetics: changes of biorob2018, pose, the coils' changes of L (SI), their error, tolerances."""

    model: str
    title: str
    changes: tuple[str, ...]
    pose: Pose
    change: tuple[float, ...]
    resolved: float
    tolerances: tuple[float, ...]


DISC = (
    'target={material="copper", shape="disc", diameter="7 mm", thickness="0.2 mm"}',
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
)
_SPACE, _SECTION = (1e-2, 3e-3, 1e-3, 3e-4), (1e-2, 1e-3, 1e-4, 1e-5)
_MIDDLE, _ASIDE = (-1.696012066246201e-05,) * 2, (-4.559785394394114e-06, -5.531686111106578e-05)
_ROUND, _SQUARE = (-1.722086964359416e-07,), (-59.0133840453461e-9,) * 2
SPACE = (
    Answered("axisymmetric", "coaxial disc", DISC, Pose(0.0, 2 * MM), _ROUND, 1e-6, _SPACE),
    Answered("sheets", "coaxial disc", DISC, Pose(0.0, 2 * MM), _ROUND, 1e-6, _SPACE),
    Answered("sheets", "plate over two coils", (), Pose(0.0, 2 * MM), _SQUARE, 2e-4, _SPACE),
)
SECTION = (
    Answered("planar", "plate in the middle", (), Pose(0.0, 2 * MM), _MIDDLE, 1e-6, _SECTION),
    Answered("planar-fem", "plate in the middle", (), Pose(0.0, 2 * MM), _MIDDLE, 1e-6, _SECTION),
    Answered("planar", "plate 2 mm aside", (), Pose(2 * MM, 2 * MM), _ASIDE, 1e-6, _SECTION),
)


def loads(names: Sequence[str], tolerances: Sequence[float]) -> list[Rung]:
    """Return the rungs of some stored loads, from rest."""
    stored = {one.name: one for one in stored_references()}
    found = []
    for name in names:
        for tolerance in tolerances:
            one = judged(stored[name], tolerance)
            errors_of = [item if np.isfinite(item) else np.inf for item in (one.true, one.estimated)]
            found.append(Rung(name, tolerance, one.seconds, *map(float, errors_of), stored[name].error))
    return found


def poses(problems: Sequence[Answered], count: int | None) -> list[Rung]:
    """Return the rungs of some poses, the first `count` tolerances of each."""
    found = []
    for one in problems:
        sensor = load_sensor("biorob2018", ['target.conductivity="58 MS/m"', *one.changes])
        for tolerance in one.tolerances[:count]:
            forget()
            began = time.process_time()
            z = MAGNETICS[one.model](sensor, tolerance).impedance(one.pose, 5e6)
            seconds = time.process_time() - began
            largest = float(np.max(np.abs(one.change)))
            error = float(np.max(np.abs(np.diagonal(z.L - z.L0) - one.change))) / largest
            estimated = float(np.max(np.diagonal(z.error_L))) / largest
            found.append(Rung(f"{one.model}: {one.title}", tolerance, seconds, error, estimated, one.resolved))
    return found


def calibrations(cases: Sequence[Case], tolerances: Sequence[float]) -> list[Rung]:
    """Return the rungs of some calibrations, a curve for each signal; the reference's own rung has no true error."""
    found = []
    for case in cases:
        for tolerance in tolerances:
            if tolerance < case.finest:
                continue
            forget()
            began = time.process_time()
            data = table(case, tolerance)
            seconds = time.process_time() - began
            for signal in SIGNALS:
                known, resolved = reference(case, signal)
                true, estimated = errors(data, signal, known)
                true = true if tolerance > case.rungs[-1] else np.nan
                found.append(Rung(f"{case.name}: {signal}", tolerance, seconds, true, estimated, resolved))
    return sorted(found, key=lambda rung: rung.model)


def flagship(parts: Mapping[str, Sequence[Rung]]) -> list[Rung]:
    """Return the rungs of a load and of a calibration of biorob2018-w15, in plain words."""
    words = {SOLID[-1]: "a load", f"biorob2018-w15: {SIGNALS[0]}": "a calibration of 3 x 3 loads"}
    return [replace(one, model=words[one.model]) for rungs in parts.values() for one in rungs if one.model in words]


def main() -> None:
    """Run the ladders and write tables and picture."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    asked, count = (QUICK, 1) if coarse else (FULL, None)
    with threadpool_limits(limits=1):
        parts = {
            "The pose under a load in 3D": loads(SOLID[:2] if coarse else SOLID, asked),
            "The pose under a load in section": loads(PLANE, asked),
            "The change of inductance at a pose": poses((*SPACE, *SECTION), count),
            "A calibration of 3 x 3 loads, of full scale": calibrations(CALIBRATIONS, asked),
        }
    save_figure(ladder_figure({"biorob2018-w15": flagship(parts)}), folder / "error_against_time.png")
    save_figure(ladder_figure(dict(list(parts.items())[:-1])), folder / "error_against_time_each.png")
    lines = [f"{title}: {verdict(rungs)}" for title, rungs in parts.items()]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    lines += [machine(), f"at most {peak:.0f} MiB, {time.process_time():.0f} s of processor time"]
    (folder / "error_against_time.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(write_rows(rung_rows(parts), folder / "error_against_time.csv"), *lines, sep="\n")


if __name__ == "__main__":
    main()
