"""How long do FElupe and NGSolve take for a combined load from rest, in the plane and in space, and this package?

In the plane: a neo-Hookean layer 20 x 2 mm under a rigid 15 mm target, K = 1000 mu, 267 N/m shear and 4050 N/m normal
force. In space: the pad of biorob2018-w15, 20 x 20 x 2 mm of ecoflex-00-30 under 15 x 8 mm, 0.5 N shear and 2 N normal
force. All on the lines of this package's meshes (common/other_codes.py), on one thread, free faces without contact,
processor time of the best of some runs, from making the mesh to the pose. Error: the largest of d_h, sink and tilt at
the target's end, over the displacement, against the references of common/reference_pads.json (0.28 % in the plane). Of
the other codes meshes are searched, in the plane gradings, load steps and damping, too; in space all cut their steps
themselves.

Ratios, at equal error. "with an estimate": this package as it is asked, all of its levels and checks, its estimate
included, against one solve of the other code without any estimate, its mesh chosen by hindsight: its front of error
against time, interpolated on logarithmic axes at this package's true error (the reference's own where that is larger),
or, "at least", the time of its most exact mesh where that one's error is still larger. "one solve": each code's fastest
mesh below 1 %, this package's by one Newton solve from rest, J watched at the quadrature points only (the other codes
do not look at it). Every run of this package begins with its caches empty.

Neither code is a dependency: install ``felupe`` and ``ngsolve`` beside the package to run it; what is missing is named
and left out. A picture shows error against time; `--beside` draws the package's answers of another run, such as that of
an older commit, as well. Combined loads on biorob2018 that have a reference are drawn in one panel, beside NGSolve's
fastest meshes; `--stored` draws those of common/three_loads.csv, one run in which commit 1c7001c7, before cells at rims
were eliminated, took turns with the next version. `--only "0.3 N, 1 N"` takes one load. Run
``python -m benchmarks.other_codes [--coarse] [--beside CSV] --output DIR``.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import product
from pathlib import Path

import numpy as np
from common.accuracy import forget, machine
from common.other_codes import Question, Solved, condensed_pose, felupe_pose, taylor_hood_pose
from common.reference_cases import CASES
from common.references import stored_references
from matplotlib.figure import Figure
from threadpoolctl import threadpool_limits

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.newton import SETTLED, newton
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body, layer_scales
from sits_mech.mechanics.pad.solid import bonded_block, pad_scales
from sits_mech.quantities import Wrench
from sits_mech.report.pictures.style import COLUMN, MARKS, new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

THREE = {  # as far as they have a reference
    one.name.partition(", ")[2].replace(" and", ","): one.name for one in stored_references()
    if one.name.startswith("biorob2018, ") and one.wrench.F_x
}
LOADS = {"plane": "layer, sheared and pressed", "space": "biorob2018-w15, 0.5 N and 2 N", **THREE}
OWN, ASKED = "sits_mech", "with an estimate"
STORED = Path(__file__).parents[1] / "common" / "three_loads.csv"
BELOW = 1e-2  # error that counts for "one solve"
LONG = 2.0  # seconds of a solve that is run once
MEANS = "not installed, left out: pip install"


@dataclass(frozen=True)
class Line:
    """One way to solve: settings, processor seconds, error, unknowns."""

    load: str
    code: str
    element: str
    cells: int
    grading: float
    settings: str
    seconds: float
    error: float
    unknowns: int


Way = tuple[str, str, int, float, str, Callable[[], Solved]]  # code, element, cells, grading, settings, the solve


def asked_of(load: str) -> Question:
    """Return a load with its reference."""
    case = next(case for case in CASES if case.name == LOADS[load])
    known = next(one for one in stored_references() if one.name == case.name)
    return Question(case, known.moved[:3] * [1e3, -1e3, 1.0], known.error)


def timed(load: str, asked: Question, way: Way, runs: int) -> Line:
    """Return the best of some runs; what does not converge has no number for an error."""
    *names, settings, solve = way
    best, error, unknowns = np.inf, np.nan, 0
    for number in range(runs):
        if number and best > LONG:
            break
        forget()
        began = time.process_time()
        try:
            pose, unknowns = solve()
        except Exception as failure:  # whatever stops another code
            return Line(load, *names, f"{settings}: {type(failure).__name__}", np.inf, np.nan, 0)
        best = min(best, time.process_time() - began)
        error = asked.away(pose)
    return Line(load, *names, settings, best, error, unknowns)


def own_pose(sensor: Sensor, asked: Question, tolerance: float) -> Solved:
    """Return this package's pose as it is asked, with its estimated error."""
    model = block_pad(sensor, tolerance) if asked.spatial else planar_layer(sensor, tolerance)
    found = model.equilibrium(Wrench(*asked.case.load[:2]))
    pose = found.pose
    sink = asked.case.thickness - 1e3 * pose.d_v
    return np.array([1e3 * pose.d_h, sink, pose.alpha], dtype=float), found.report.unknowns


def own_solve(sensor: Sensor, asked: Question, cells: int, grading: float, split: bool) -> Solved:
    """Return this package's pose by one Newton solve from rest on one mesh, in the plane with corners split or not."""
    if asked.spatial:
        solid = bonded_block(sensor, cells, grading)
        body, scales = solid.body, pad_scales(sensor, solid.share)
    else:
        body, scales = bonded_body(sensor, SectionFineness(cells, grading, split)), layer_scales(sensor)
    state = newton(body, rest(body), scales.load(Wrench(*asked.case.load[:2]))[:3]).state
    if not state.residual <= SETTLED or not state.min_J > 0.0:
        raise ArithmeticError(f"residual {state.residual:.1e}")
    t = asked.case.thickness
    return state.q * [t, -t, 1.0], len(body.free) + 3


def own_ways(asked: Question, coarse: bool) -> Iterator[Way]:
    """Yield what this package is asked, and its single solves."""
    sensor = load_sensor("biorob2018", asked.case.changes)
    tolerances = (1e-1, 3e-2, 1e-2, 3e-3) if asked.case.name in THREE.values() else (1e-1, 1e-2, 1e-3)
    for tolerance in (1e-2,) if coarse else tolerances:
        yield OWN, ASKED, 0, 0.0, f"tolerance {tolerance:g}", lambda t=tolerance: own_pose(sensor, asked, t)
    cells = (2,) if asked.spatial or coarse else (2, 4)
    gradings = (2.0,) if asked.spatial else (1.5,) if coarse else (1.0, 1.5)
    for size, grading, split in product(cells, gradings, (False,) if asked.spatial else (False, True)):
        words, mesh = "corners split" if split else "corners whole", (size, grading, split)
        yield OWN, "Q2P1", size, grading, words, lambda mesh=mesh: own_solve(sensor, asked, *mesh)


def felupe_ways(asked: Question, coarse: bool) -> Iterator[Way]:
    """Yield FElupe's elements, meshes and load steps."""
    low, gradings, steps_of = ((2, 4), (2.0,), (1,)) if asked.spatial else ((8, 10), (1.0, 1.5), (1, 4))
    kinds = [("Q2Q1", cells) for cells in ((1, 2, 3) if asked.spatial else (2, 4))] + [("Q1P0", c) for c in low]
    kinds = kinds[:1] if coarse else kinds
    for (element, cells), grading, steps in product(kinds, gradings[-1:] if coarse else gradings, steps_of):
        mesh = (element, cells, grading)
        yield "FElupe", *mesh, f"{steps} steps", lambda mesh=mesh, steps=steps: felupe_pose(asked, *mesh, steps)


def ngsolve_ways(asked: Question, coarse: bool) -> Iterator[Way]:
    """Yield NGSolve's elements, meshes, load steps and damping; Taylor-Hood's in the plane alone."""
    gradings, sizes = ((2.0,), (1, 2, 3, 4)) if asked.spatial else ((1.0, 1.5), (2, 4))
    orders = (2, 3)
    if asked.case.name in THREE.values():
        sizes, orders = range(1, 1 + max(asked.case.meshes[2])), (*range(2, 1 + max(asked.case.meshes)),)
    gradings, sizes = (gradings[-1:], sizes[:1]) if coarse else (gradings, sizes)
    for order, cells, grading, steps in product(orders, sizes, gradings, (1,) if asked.spatial else (1, 2)):
        if order > 2 and cells == max(sizes) and not coarse:
            continue
        case, words = (order, cells, grading, steps), f"{steps} steps, condensed"
        yield "NGSolve", f"Q{order}P{order - 1}", cells, grading, words, lambda case=case: condensed_pose(asked, *case)
        for damping in () if asked.spatial else (1.0, 0.3):
            words, more = f"{steps} steps, damping {damping:g}", (*case, damping)
            name = f"Q{order}Q{order - 1}"
            yield "NGSolve", name, cells, grading, words, lambda more=more: taylor_hood_pose(asked, *more)


def search(load: str, coarse: bool) -> Iterator[Line]:
    """Yield this package's answers, then the other codes' meshes and settings."""
    asked = asked_of(load)
    ways = [(None, own_ways), ("felupe", felupe_ways), ("ngsolve", ngsolve_ways)]
    timed(load, asked, next(own_ways(asked, coarse)), 1)  # what is imported late
    for code, every in ways:
        if code == "felupe" and load in THREE:
            continue
        if code is not None and find_spec(code) is None:
            print(code, MEANS, code)
            continue
        for way in every(asked, coarse):
            yield timed(load, asked, way, 1 if coarse else 6 if code is None else 3)


def front(lines: Sequence[Line]) -> list[Line]:
    """Return the solves that no faster one is as exact as, in the order of their times."""
    kept: list[Line] = []
    for line in sorted(lines, key=lambda line: line.seconds):
        if line.error < (kept[-1].error if kept else np.inf):
            kept.append(line)
    return kept


def distinct(lines: Sequence[Line]) -> list[Line]:
    """Return the fastest of the solves that end on the same mesh, in the order of their times."""
    fastest = {line.unknowns: line for line in sorted(lines, key=lambda line: -line.seconds)}
    return sorted(fastest.values(), key=lambda line: line.seconds)


def seconds_at(lines: Sequence[Line], error: float) -> tuple[float, bool]:
    """Return the time of a code at some error, along its front on logarithmic axes, and whether it reaches it.

    Where no mesh is as exact it is the time of the most exact one; where all are, that of the fastest.
    """
    kept = front(lines)
    errors = np.log([line.error for line in kept])[::-1]
    found = np.interp(np.log(error), errors, np.log([line.seconds for line in kept])[::-1])
    return float(np.exp(found)), bool(kept[-1].error <= error)


def ratios(lines: Sequence[Line], sure: float = 0.0) -> Iterator[str]:
    """Yield how much longer the other codes take for a load, by both measures; `sure` is the reference's error."""
    mine = [line for line in lines if line.code == OWN]
    whole = min((line for line in mine if line.element == ASKED), key=lambda line: line.seconds)
    alone = [line for line in mine if line.element != ASKED and line.error <= BELOW]
    one, load = min(alone, key=lambda line: line.seconds, default=None), whole.load
    yield from (f"{load}: {OWN}, {_mesh(line)}" for line in (whole, *([one] if one else [])))
    for code in dict.fromkeys(line.code for line in lines if line.code != OWN):
        own = [line for line in lines if line.code == code and np.isfinite(line.error)]
        seconds, reached = seconds_at(own, max(whole.error, sure))
        words, best = f"{'' if reached else 'at least '}{seconds / whole.seconds:.2g}", front(own)[-1]
        yield f"{load}: {code}, ratio {ASKED}: {words}; most exact {_mesh(best)}"
        good = [line for line in own if line.error <= BELOW]
        if good and one and (fast := min(good, key=lambda line: line.seconds)):
            yield f"{load}: {code}, ratio one solve: {fast.seconds / one.seconds:.2g}; {_mesh(fast)}"


def _mesh(line: Line) -> str:
    """Element, mesh, settings, time and error in words."""
    mesh = f"{line.cells} cells, grading {line.grading:g}, " if line.cells else ""
    return f"{line.element}, {mesh}{line.settings}: {line.seconds:.3g} s, error {line.error:.2%}"


def draw(lines: Sequence[Line], before: Sequence[Line], path: Path) -> None:
    """Draw the error of every code over its processor time, each load by itself; `before` are of an older package."""
    loads = list(dict.fromkeys(line.load for line in lines))
    figure = Figure(figsize=(5.5 * len(loads), 4.2), layout="constrained")
    for axes, load in zip(np.atleast_1d(figure.subplots(1, len(loads))), loads, strict=True):
        series = {f"{OWN}, {ASKED}": [line for line in lines if line.code == OWN and line.element == ASKED]}
        series["the same, before"] = [line for line in before if line.code == OWN and line.element == ASKED]
        for code in dict.fromkeys(line.code for line in lines if line.code != OWN):
            series[f"{code}, fastest of its meshes"] = front([line for line in lines if line.code == code])
        for name, every in series.items():
            own = [line for line in every if line.load == load and np.isfinite(line.error)]
            if own:
                axes.loglog([line.seconds for line in own], [line.error for line in own], "o-", label=name)
        axes.set(title=LOADS[load], xlabel="processor time [s]", ylabel="error over the displacement")
        axes.axhline(asked_of(load).sure, color="0.7", zorder=0)
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=150)


def three_figure(lines: Sequence[Line]) -> Figure:
    """Draw the loads of `THREE` in one panel: this package, the same before if it is there, and NGSolve, a line a load.

    Of this package every mesh that a tolerance led to is drawn, of NGSolve the fastest; bars: error of the reference.
    """
    groups = {
        "before": ("0.5", [one for one in lines if one.code.startswith(f"{OWN} ")]),
        "sits-mech": ("C0", [one for one in lines if one.code == OWN and one.element == ASKED]),
        "NGSolve": ("C1", [one for one in lines if one.code == "NGSolve"]),
    }
    with new_figure(height=0.5, width=2.0 * COLUMN) as (figure, (axes,)):
        for mark, load in zip(MARKS, THREE, strict=False):
            axes.plot([], [], f"{mark}-", color="0.3", ms=5, label=f"$F_x$, $F_z$: {load}")
        for name, (colour, every) in groups.items():
            given = [[one for one in every if one.load == load and np.isfinite(one.error)] for load in THREE]
            drawn = [front(own) if name == "NGSolve" else distinct(own) for own in given]
            for mark, load, own in zip(MARKS, THREE, drawn, strict=False):
                seconds, errors = [one.seconds for one in own], [one.error for one in own]
                style = {"fmt": f"{mark}-", "color": colour, "lw": 1.5, "ms": 5, "elinewidth": 0.6}
                axes.errorbar(seconds, errors, asked_of(load).sure, **style)
            if ends := [own[-1] for own in drawn if own]:
                last = max(ends, key=lambda one: one.seconds)
                spot, style = (last.seconds, last.error), {"va": "center", "color": colour, "fontsize": 10}
                axes.annotate(name, spot, (8, 0), textcoords="offset points", **style)
        errors = [one.error for _, every in groups.values() for one in every if np.isfinite(one.error)]
        axes.set(xscale="log", yscale="log", ylim=(0.4 * min(errors), 1.4 * max(errors)))
        axes.set_xlim(right=2.2 * axes.get_xlim()[1])
        axes.set(xlabel="processor time [s]", ylabel="error over the displacement [-]")
        axes.legend(fontsize=8, loc="upper right", title="bars: error of the reference")
        figure.suptitle(title_of(lines), fontsize=10)
    return figure


def title_of(lines: Sequence[Line]) -> str:
    """Say how much longer NGSolve takes for the loads of `THREE` at the errors of this package's fastest answers."""
    found = []
    for load in THREE:
        own, other = ([one for one in lines if one.load == load and one.code == code and np.isfinite(one.error)]
                      for code in (OWN, "NGSolve"))
        if own and other:
            fast = min((one for one in own if one.element == ASKED), key=lambda one: one.seconds)
            found.append(seconds_at(other, max(fast.error, asked_of(load).sure))[0] / fast.seconds)
    words = f": at equal error NGSolve takes {min(found):.0f} times as long and more" if found else ""
    return f"Combined loads on biorob2018{words}"


def read(path: Path | None) -> list[Line]:
    """Return the lines of a table that was written; none without one."""
    if path is None:
        return []
    kinds = (str, str, str, int, float, str, float, float, int)
    with path.open(encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    return [Line(*(kind(item) for kind, item in zip(kinds, row, strict=True))) for row in rows]


def main() -> None:
    """Measure; write and print the table, the picture and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="one run of few meshes")
    parser.add_argument("--only", choices=LOADS, action="append", help="a load; may be repeated")
    parser.add_argument("--beside", type=Path, help="table of another run, drawn as well")
    parser.add_argument("--stored", action="store_true", help="draw loads on biorob2018 from common/three_loads.csv")
    parser.add_argument("--output", type=Path, default=Path("."))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    if options.stored:
        save_figure(three_figure(read(STORED)), options.output / "three_loads.png")
        return
    before, lines = read(options.beside), []
    with threadpool_limits(limits=1):
        for load in options.only or list(LOADS)[: 3 if options.coarse else None]:
            for line in search(load, options.coarse):
                lines.append(line)
                print(*(f"{item:.3g}" if isinstance(item, float) else item for item in vars(line).values()), flush=True)
        caption = machine()
    with (options.output / "other_codes.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([vars(lines[0]).keys(), *(vars(line).values() for line in lines)])
    first, three = ([line for line in lines if (line.load in THREE) == whether] for whether in (False, True))
    if first:
        draw(first, before, options.output / "other_codes.png")
    if three:
        own = (one for one in before if one.code == OWN and one.element == ASKED)
        older = [replace(one, code=f"{OWN} {options.beside.stem}") for one in own]
        save_figure(three_figure([*three, *older]), options.output / "three_loads.png")
    every = {load: [line for line in lines if line.load == load] for load in LOADS}
    words = [one for load, own in every.items() if own for one in ratios(own, asked_of(load).sure)]
    summary = "\n".join([*words, caption]) + "\n"
    (options.output / "other_codes.txt").write_text(summary, encoding="utf-8")
    print(summary)


if __name__ == "__main__":
    main()
