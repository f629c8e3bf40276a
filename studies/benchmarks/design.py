"""Is what `sits-mech design` recommends the best, the same from any start, and does it hold what it says it holds?

Twelve requirement files (``requirements/``): fingertip, sole, gripper, a target's width and a long strip in space; a
strip that nothing satisfies; a round button on one axis, for the best, for the first that will do and as thin as skin;
sizes alone; three forces by four coils; a square coil that reads just not enough. For each of them

    held        the recommendation solved anew at a tenth of the tolerance: which limits does it miss, by how much
    grid        how much more is minimised than by the best design of a grid of up to 500, same chain and tolerance
    random      the same of Sobol's points, ten times as many as the search has solved, up to 200
    seeds       how far the answers from five seeds are from each other, and the error that is stated of the first
    predicted   how far the figures asked for of each next design were off the predictions of it: median, and at most
    tangents    the least r at the end of the data over that of tangents at another design (reach.py), of all pairs
    yield       told, by the derivatives for the very sensors that are drawn, and by these sensors solved one by one

Merits are what is minimised, exceeded limits added as the search weighs them. Counts are what was solved: designs in
space cost seconds each and get fewer. Solved designs are kept in DIR: a run that was stopped goes on. ``--trials 0``
searches alone, for the picture of predictions: minutes, where all of it takes hours.

Run ``python -m benchmarks.design [--coarse] [--only NAME ...] [--trials N] --output DIR``.
"""

from __future__ import annotations

import sys
import time
from argparse import ArgumentParser
from itertools import permutations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from common.outputs import study_arguments, write_rows
from common.stories import REQUIREMENTS
from common.trials import best_of, grid_designs, merit_of, random_designs, shares_made

from sits_mech.report.folder import cases_folder, prepare_folder
from sits_mech.synthesis.answer import DesignAnswer
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.reach import reads_evenly, tangents
from sits_mech.synthesis.required.kinds import figure_words, kind_of, shown_as
from sits_mech.synthesis.required.requirements import Requirements, read_requirements
from sits_mech.synthesis.run import design
from sits_mech.synthesis.search import MOST
from sits_mech.synthesis.solved.answered import Answered
from sits_mech.synthesis.solved.solve import COARSE, Solver

Row = dict[str, Any]


class Effort(NamedTuple):
    """What is spent on a file: designs of the grid, of random trials, sensors made, seeds, and the finest tolerance."""

    grid: int
    random: int
    made: int
    seeds: int
    tolerance: float

    def at_most(self, trials: int | None) -> Effort:
        """Return what is spent with so many designs of each kind, and sensors, at most; one seed without any."""
        if trials is None:
            return self
        counts = {name: min(getattr(self, name), trials) for name in ("grid", "random", "made")}
        return self._replace(**counts, seeds=self.seeds if trials else 1)


CHEAP, DEAR = Effort(500, 200, 200, 5, 1e-3), Effort(48, 60, 40, 5, 3e-3)
FILES = {
    "button_any": CHEAP, "button": CHEAP, "strip": DEAR, "low_profile": DEAR, "strip_exact": DEAR, "foot_sole": DEAR,
    "three_axes": DEAR, "fingertip": DEAR, "target_width": DEAR, "gripper_pad": DEAR, "skin_patch": CHEAP,
    "square_coil": DEAR,
}
QUICK, QUICK_FILES, FEW = Effort(2, 1, 1, 1, 5e-2), ("button_any",), 1


def goal_of(found: DesignAnswer) -> tuple[float, float]:
    """Return what is minimised, and its stated error, nan where a part of it is not known."""
    task, best = found.task, found.best
    figures, size = task.figures(best), task.sizes | (task.weighed or task.limits)
    error = {each.name: each.error / shown_as(each.name)[1] for each in found.figures}
    off = sum(w * error[name] / abs(size.get(name, 1.0)) for name, w in task.minimised.items())
    return task.objective(figures), off


def missed(asked: Requirements, found: DesignAnswer, tolerance: float, folder: Path) -> str:
    """Return the limits that the recommendation misses, solved at a tolerance, with the worst."""
    again = Solver(asked, tolerance, folder)(found.best.design)
    if not again.carried:
        return again.reason
    figures = found.task.figures(again)
    excess = {name: over for name, over in found.task.excess(figures, again.table).items() if over > 0.0}
    return "; ".join(
        f"{name} {figure_words(name, figures[name]) if name in figures else ''} by {100.0 * over:.2g} %"
        for name, over in excess.items()
    )


def more(merit: float, least: float) -> float:
    """Return how much more one merit is than another [%]; negative where it is less."""
    return 0.0 if merit == least else 100.0 * (merit - least) / max(abs(least), 1e-12)


def predicted_off(found: DesignAnswer) -> list[float]:
    """Return how far predicted figures were from those solved next, over these [%]."""
    before, off = dict[tuple[int, ...], list[Answered]](), list[float]()
    for each in (one for one in found.known if one.carried):
        own = before.setdefault(each.design.choice, [])
        if own:
            there = Prediction(own, ())
            figures = found.task.figures(there.at(each.point))
            asked = (name for name in {**found.task.limits, **found.task.minimised} if not kind_of(name).exact)
            known = found.task.figures(each)
            off += [abs(more(figures[name], known[name])) for name in asked if known.get(name)]
        own.append(each)
    return off


def above_tangents(asked: Requirements, found: DesignAnswer) -> float:
    """Return the least resolution at the end of the data over that of tangents elsewhere; NaN without a pair."""
    space, ratios = asked.space, [np.nan]
    names = [f"resolution.{name}" for name in asked.loads]
    for one, other in permutations([each for each in found.known if each.carried and each.table is not None], 2):
        pairs = enumerate(zip(one.design.choice, other.design.choice, strict=True))
        alike = all(a == b or k == space.silicone for k, (a, b) in pairs)
        if alike and reads_evenly(found.task, one):
            x, ends, here = one.point, other.point[None], Prediction([one], ())
            own = tangents(found.task, Prediction([other], ()), other.point, names, ends, space.growth)
            foreseen = tangents(found.task, here, x, names, ends, space.growth)
            ratios += [own[name][0] / (r * float(np.exp(falls.sum()))) for name, (r, falls) in foreseen.items()]
    return float(np.nanmin(ratios)) if len(ratios) > 1 else np.nan


def seeded(asked: Requirements, found: DesignAnswer, effort: Effort, most: int, folder: Path) -> Row:
    """Return the range of what is minimised over the seeds, in percent, and designs that are unlike the first."""
    others = [design(asked, folder=folder, most=most, seed=seed) for seed in range(1, effort.seeds)]
    aims = np.array([goal_of(each)[0] for each in (found, *others)])
    size = abs(aims[0]) or 1.0
    unlike = {asked.space.words(each.best.design) for each in others} - {asked.space.words(found.best.design)}
    row = {"seeds": 1 + len(others), "seeds_range_%": 100.0 * float(np.ptp(aims)) / size}
    return row | {"stated_error_%": 100.0 * goal_of(found)[1] / size, "other_answers": "; ".join(sorted(unlike))}


def row_of(name: str, effort: Effort, most: int, folder: Path) -> Row:
    """Return all that is told of a file."""
    asked, began = read_requirements(REQUIREMENTS / f"{name}.toml"), time.process_time()
    cases = cases_folder(prepare_folder(folder / name))
    found = design(asked, folder=cases, most=most)
    coarse, words = Solver(asked, COARSE, cases), asked.space.words(found.best.design)
    row: Row = {"file": name, "answer": words, "fits": found.feasible, "designs": found.solves}
    row |= {"seconds": sum(each.seconds for each in found.known) + found.best.seconds}
    row |= {"binds": ", ".join(each.name for each in found.binding)}
    row["missed"] = missed(asked, found, effort.tolerance, cases) if effort.grid else ""
    merit = merit_of(found.task, coarse(found.best.design))
    searched = min(merit_of(found.task, each) for each in found.known)
    row |= {"tolerance": effort.tolerance, "merit": merit, "merit_of_search": searched}
    trials = min(effort.random, 10 * found.solves)
    drawn = random_designs(asked.space, trials, 0) if trials else []
    for kind, designs in (("grid", grid_designs(asked.space, effort.grid)), ("random", drawn)):
        own = best_of(coarse, found.task, designs)
        over = more(merit, own.merit) if designs else np.nan
        row |= {kind: own.count, f"over_{kind}_%": over, f"best_of_{kind}": own.words}
    row |= seeded(asked, found, effort, most, cases)
    off = predicted_off(found) or [np.nan]
    row |= {"predicted_off_%": float(np.median(off)), "predicted_off_most_%": float(np.max(off))}
    row["above_tangents"] = above_tangents(asked, found)
    solved, foreseen = np.nan, np.nan
    if effort.made:
        solved, foreseen = shares_made(coarse, found.task, coarse(found.best.design), effort.made, 0)
    shares = {"told": float(np.ravel(found.share)[0]), "by_slopes": foreseen, "solved": solved}
    row |= {"made": effort.made, **{f"yield_{key}_%": 100.0 * value for key, value in shares.items()}}
    print(f"{name}: {time.process_time() - began:.0f} s here", *(f"   {key} {row[key]}" for key in row), sep="\n")
    return row


def draw(rows: list[Row], path: Path) -> None:
    """What is minimised against grid and random trials; predictions against solves; told yields against solved ones.

    What was not tried has no panel.
    """
    from matplotlib.figure import Figure

    panels = {
        "recommended over it [%], at most 30 shown": {"over_grid_%": "best of grid", "over_random_%": "best of random"},
        "next design's figures off their predictions [%]": {
            "predicted_off_%": "median", "predicted_off_most_%": "at most"},
        "sensors made that hold all limits [%]": {"yield_by_slopes_%": "by derivatives", "yield_solved_%": "solved"},
    }
    values = {title: np.array([[row[key] for key in keys] for row in rows]) for title, keys in panels.items()}
    shown = [title for title, own in values.items() if not np.isnan(own).all()]
    figure = Figure(figsize=(1.0 + 4.0 * len(shown), 4.0), layout="constrained")
    places, names = np.arange(len(rows)), [row["file"] for row in rows]
    for axes, title in zip(np.ravel(figure.subplots(1, len(shown))), shown, strict=True):
        logs = "predictions" in title
        low, high = (-30.0, 30.0) if "at most 30" in title else (0.1, 1000.0) if logs else (0.0, 100.0)
        for shift, label, own in zip((-0.2, 0.2), panels[title].values(), values[title].T, strict=True):
            axes.barh(places + shift, np.nan_to_num(np.clip(own, low, high)), 0.36, label=label)
        axes.set(xlabel=title, xlim=(low, high), xscale="log" if logs else "linear")
        for place in places[np.isnan(values[title]).all(axis=1)]:
            axes.text(low, place, " no next design" if logs else " not tried", va="center", fontsize=8)
        axes.set_yticks(places, names)
        axes.invert_yaxis()
        axes.legend(fontsize=7)
        axes.grid(True, axis="x", alpha=0.3)
        if low < 0.0:
            axes.axvline(10.0, color="0.4", linestyle=":")
    figure.savefig(path, dpi=150)


def main() -> None:
    """Write the table and its picture."""
    parser = ArgumentParser(add_help=False)
    parser.add_argument("--only", nargs="+", choices=FILES, help="Files that are answered, all by default.")
    parser.add_argument("--trials", type=int, help="Designs of grid and random trials, and sensors made, at most.")
    known, sys.argv[1:] = parser.parse_known_args()
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    names = known.only or (QUICK_FILES if coarse else FILES)
    rows = []
    for name in names:
        effort = (QUICK if coarse else FILES[name]).at_most(known.trials)
        rows.append(row_of(name, effort, FEW if coarse else MOST, folder))
        table = write_rows(rows, folder / "benchmark_design.csv")
    print(table)
    draw(rows, folder / "benchmark_design.png")


if __name__ == "__main__":
    main()
