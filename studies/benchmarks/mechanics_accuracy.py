"""Does the mechanics deliver the error that is asked, and say the error that it has?

Pads and layers of every kind (boxes and cylinders, five laws, flush and narrow targets, 1:1 to 1000:1, nu 0.45 to
0.4999, pressed, pulled, sheared, turned) are asked for their pose to 1 %, 0.3 % and 0.1 %, from the scene on, with
empty caches, on one thread; forty of them by chance, to 14 % press and 45 % shear. True errors are against the
references of common/reference_pads.json, made by an independent code (benchmarks/reference_pads.py); each judges only
what is five times its own error. Errors are over the size of the displacement, an angle counted at the target's end;
times are processor time.

Run ``python -m benchmarks.mechanics_accuracy [--coarse] --output DIR``; `--only WORD` takes the pads whose names have
that word in them, such as "by chance", `--tolerance 1e-2` one tolerance.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from common.accuracy import forget, machine
from common.outputs import write_rows
from common.references import FINER, Judged, Reference, counts, stored_references
from threadpoolctl import threadpool_limits

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.layer import axisymmetric_pad, planar_layer
from sits_mech.quantities import MechanicalModel, SolveFailed
from sits_mech.report.pictures.style import COLUMN, new_figure, save_figure
from sits_mech.scene.sensor import Sensor

TOLERANCES = (1e-2, 3e-3, 1e-3)
MODELS: Mapping[str, Callable[[Sensor, float], MechanicalModel]] = {
    "block": block_pad, "planar": planar_layer, "axisymmetric": axisymmetric_pad
}
DRAWN = (
    "15 x 15 on 20 x 20 x 2, small shear", "disc 10 on 20 x 2, small shear", "flush disc 15 x 2, small shear",
    "flush disc 15 x 2, pressed 1 %", "flush disc 15 x 2, pulled 8 %", "flush disc 10 x 10, pulled 10 %",
)
QUICK = ("layer, sheared 10 %", "flush disc 15 x 2, pressed 1 %")  # the coarse run


def judged(reference: Reference, tolerance: float) -> Judged:
    """Return one solve, from the scene on."""
    forget()
    began = time.process_time()
    try:
        model: MechanicalModel = MODELS[reference.model](reference.sensor, tolerance)
        found = model.equilibrium(reference.wrench)
    except (SolveFailed, ValueError, MemoryError) as failure:
        spent = time.process_time() - began
        return Judged(reference, tolerance, np.nan, np.nan, spent, 0, f"{type(failure).__name__}: {failure}")
    spent, report = time.process_time() - began, found.report
    return Judged(
        reference, tolerance, reference.true_error(found), report.estimated_error, spent, report.unknowns, report.status
    )


def row_of(one: Judged) -> dict[str, object]:
    """Return a solve as a row of the table."""
    row: dict[str, object] = {"pad and load": one.reference.name, "asked": one.tolerance, "true": one.true}
    row |= {"estimated": one.estimated, "true/estimated": one.ratio, "reference's own": one.reference.error}
    return row | {"processor s": one.seconds, "unknowns": one.unknowns, "status": one.status.partition("\n")[0][:60]}


def draw(every: Sequence[Judged], names: Sequence[str], path: Path) -> None:
    """Write the picture: true (full) and estimated errors (hollow) of pads, a mark for each tolerance.

    A point whose reference is not five times better is left out; of none there is no picture.
    """
    from matplotlib.ticker import LogLocator

    drawn = [one for one in every if one.reference.name in names and FINER * one.reference.error <= one.true]
    if not drawn:
        return
    marks = dict(zip(TOLERANCES, "os^", strict=True))
    with new_figure(height=0.6, width=1.6 * COLUMN) as (figure, (spot,)):
        for number, name in enumerate(names):
            own = [one for one in drawn if one.reference.name == name]
            for one in own:
                mark, colour = marks.get(one.tolerance, "d"), f"C{number}"
                words = name if one is own[0] else None
                spot.plot(one.seconds, one.true, colour + mark, ms=4, label=words)
                spot.plot(one.seconds, one.estimated, colour + mark, ms=4, mfc="none")
                spot.plot([one.seconds] * 2, [one.true, one.estimated], colour, lw=0.4)
        for tolerance in dict.fromkeys(one.tolerance for one in drawn):
            spot.axhline(tolerance, color="0.7", lw=0.5, ls="--", zorder=0)
            spot.plot([], [], "k" + marks.get(tolerance, "d"), ms=4, label=f"asked to {100.0 * tolerance:g} %")
        spot.set(xscale="log", yscale="log", xlabel="processor time [s]", ylabel="relative error [-]")
        spot.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        spot.xaxis.set_major_formatter("{x:g}")
        spot.xaxis.set_minor_formatter("")
        few = f"{len(names)} of {len({one.reference.name for one in every})} cases, a load from rest"
        spot.set_title(f"{few}; full: true error, hollow: estimated, dashed: asked", fontsize=7)
        spot.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), fontsize=6, handlelength=1.0)
        save_figure(figure, path)


def arguments() -> argparse.Namespace:
    """Return what is asked on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="two quick pads to 1 %%: does it still run?")
    parser.add_argument("--output", type=Path, required=True, help="folder of tables and pictures")
    parser.add_argument("--only", action="append", help="pads whose names have this in them; may be repeated")
    parser.add_argument("--tolerance", type=float, action="append", help="asked error; may be repeated")
    return parser.parse_args()


def main() -> None:
    """Solve, judge, write table and picture."""
    asked = arguments()
    asked.output.mkdir(parents=True, exist_ok=True)
    tolerances = asked.tolerance or (TOLERANCES[:1] if asked.coarse else TOLERANCES)
    stored = stored_references()
    chosen = [one for one in stored if not asked.only or any(word in one.name for word in asked.only)]
    chosen = [one for one in stored if one.name in QUICK] if asked.coarse else chosen
    every: list[Judged] = []
    with threadpool_limits(limits=1):
        for reference in chosen:
            for tolerance in tolerances:
                every.append(judged(reference, tolerance))
                print(" | ".join(f"{x:.3g}" if isinstance(x, float) else str(x) for x in row_of(every[-1]).values()),
                      flush=True)
    write_rows([row_of(one) for one in every], asked.output / "mechanics_accuracy.csv")
    summary = "\n".join([*counts(every), machine()]) + "\n"
    (asked.output / "mechanics_accuracy.txt").write_text(summary, encoding="utf-8")
    print(summary)
    names = [one.name for one in chosen] if asked.only or asked.coarse else DRAWN
    draw(every, names, asked.output / "mechanics_accuracy.png")


if __name__ == "__main__":
    main()
