"""Does every extreme case give a consistent answer, or a refusal with its name? Both physics and the chain.

What is asked and held against what: extreme/layers.py (stiff, thin, tall, pressed, pulled, sheared, tilted, overloaded
layers: work = energy, moment identity, path), extreme/plates.py (skin depth over thickness 1e-3 to 1e3, gaps from
0.05 mm, 1 Hz to 100 MHz: reciprocity, passivity, growth with frequency; whole sensors). Each row is converged and
within what is allowed, or, where it is an extreme indeed, refused by name; any other ends the study with exit code 1.

Run ``python studies/extremes.py [--coarse] [--only mechanics,magnetics,chain] --output DIR``: a table as CSV and
Markdown, and a picture of violations beside what is allowed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from extreme.layers import layers
from extreme.plates import chain, plates
from extreme.rows import DONE, Row
from threadpoolctl import threadpool_limits

from sits_mech.report.curves import new_figure, save_figure
from sits_mech.report.outputs import write_rows

PARTS = {"mechanics": layers, "magnetics": plates, "chain": chain}
SMALLEST = 1e-9  # where nothing at all, and less, is drawn
MARKS = "cross: refused, with the error of what it reached; star: does not hold"


def draw(rows: Sequence[Row], path: Path) -> None:
    """Write a picture: estimated error and violation over allowance of each row against its seconds."""
    with new_figure(height=0.7, columns=2) as (figure, (left, right)):
        for number, part in enumerate(PARTS):
            own = [row for row in rows if row.physics == part]
            over = [row.violation / row.allowed for row in own]
            for axes, values in ((left, [row.estimated for row in own]), (right, over)):
                done = [row.status == DONE for row in own]
                seconds = np.maximum([row.seconds for row in own], 1e-2)
                share = np.maximum(values, SMALLEST)
                axes.plot(seconds[done], share[done], f"C{number}o", label=part, alpha=0.7)
                stopped = ~np.array(done, dtype=bool)
                axes.plot(seconds[stopped], share[stopped], f"C{number}x")
        wrong = [row for row in rows if not row.holds]
        right.plot([max(row.seconds, 1e-2) for row in wrong], [1.0] * len(wrong), "r*")
        left.set(xscale="log", yscale="log", xlabel="wall time [s]", ylabel="estimated error [-]", ylim=(1e-6, 0.3))
        right.set(xscale="log", yscale="log", xlabel="wall time [s]", ylabel="violation over allowance [-]")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, title=MARKS)
        save_figure(figure, path)


def main() -> int:
    """Ask all cases; write table and picture; say whether all rows hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--coarse", action="store_true", help="the quick cases of each kind")
    parser.add_argument("--only", default=",".join(PARTS), help="parts, separated by commas")
    parser.add_argument("--output", type=Path, default=Path("."))
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    with threadpool_limits(limits=1):
        for part in asked.only.split(","):
            for row in PARTS[part](asked.coarse):
                rows.append(row)
                verdict = "" if row.holds else "DOES NOT HOLD  "
                print(f"{verdict}{row.physics}: {row.case}: {row.status}, {row.seconds:.1f} s", flush=True)
    write_rows([vars(row) | {"holds": row.holds} for row in rows], asked.output / "extremes.csv")
    draw(rows, asked.output / "extremes.png")
    wrong = sum(not row.holds for row in rows)
    print(f"{len(rows)} rows: {sum(row.status == DONE for row in rows)} converged, {wrong} do not hold")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
