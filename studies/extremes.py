"""Does every extreme case give a consistent answer, or a refusal with its name? Both physics and the chain.

What is asked and held against what: extreme/layers.py and extreme/solids.py (stiff, thin, tall, pressed, pulled,
sheared, tilted, overloaded layers and pads: work = energy, moment identity, path), extreme/films.py and walls.py (pads
of 0.02 mm: thin-layer limit; columns that fall over: beams), extreme/plates.py (skin depth over thickness 1e-3 to 1e3,
gaps from 0.05 mm, 1 Hz to 100 MHz: reciprocity, passivity, growth with frequency; whole sensors). Each row is
converged and within what is allowed, or, where it is an extreme indeed, refused by name; any other ends the study with
exit code 1.

Run ``python studies/extremes.py [--coarse] [--only mechanics,magnetics,chain] --output DIR``: a table as CSV and
Markdown, written anew after every row, and a picture of violations beside what is allowed.
"""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterator, Sequence
from itertools import chain as joined
from pathlib import Path

import numpy as np
from common.outputs import write_rows
from extreme.films import films
from extreme.layers import layers
from extreme.plates import chain, plates
from extreme.rows import DONE, Row
from extreme.solids import solids
from extreme.walls import walls
from threadpoolctl import threadpool_limits

from sits_mech.report.pictures.curves import new_figure, save_figure


def mechanics(coarse: bool) -> Iterator[Row]:
    """Yield the rows of layers in plane strain and of pads in three dimensions."""
    return joined(layers(coarse), solids(coarse), films(coarse), walls(coarse))


PARTS = {"mechanics": mechanics, "magnetics": plates, "chain": chain}
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
        for axes, words in ((left, "estimated error [-]"), (right, "violation over allowance [-]")):
            axes.set(xscale="log", yscale="log", xlabel="processor time [s]", ylabel=words)
        left.set_ylim(1e-6, 0.3)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, title=MARKS)
        save_figure(figure, path)


def tabled(row: Row) -> dict[str, object]:
    """Return a row as it stands in the table."""
    return {
        "physics": row.physics, "case": row.case, "status": row.status, "holds": row.holds, "min J": row.min_J,
        "estimated error": row.estimated, "violation": row.violation, "allowed": row.allowed,
        "violation / allowed": row.violation / row.allowed, "seconds": row.seconds, "remark": row.remark,
    }  # fmt: skip


def ask(parts: Sequence[str], coarse: bool, folder: Path) -> list[Row]:
    """Return the rows of some parts; the table is written after each, so that an interrupt leaves what there is."""
    rows: list[Row] = []
    try:
        for row in joined.from_iterable(PARTS[part](coarse) for part in parts):
            rows.append(row)
            write_rows([tabled(item) for item in rows], folder / "extremes.csv")
            verdict = "" if row.holds else "DOES NOT HOLD  "
            print(f"{verdict}{row.physics}: {row.case}: {row.status}, {row.seconds:.1f} s", flush=True)
    except KeyboardInterrupt:
        rows.append(Row("", "the rows that follow", "interrupted"))
    return rows


def main() -> int:
    """Ask all cases; write table and picture; say whether all rows hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="the quick cases of each kind")
    parser.add_argument("--only", default=",".join(PARTS), help="parts, separated by commas")
    parser.add_argument("--output", type=Path, default=Path("."))
    asked = parser.parse_args()
    parts = asked.only.split(",")
    if not set(parts) <= set(PARTS):
        parser.error(f"--only must name parts of {', '.join(PARTS)}; got {asked.only}")
    asked.output.mkdir(parents=True, exist_ok=True)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with threadpool_limits(limits=1):
        rows = ask(parts, asked.coarse, asked.output)
    write_rows([tabled(row) for row in rows], asked.output / "extremes.csv")
    draw(rows, asked.output / "extremes.png")
    wrong = sum(not row.holds for row in rows)
    seconds = sum(row.seconds for row in rows)
    done = sum(row.status == DONE for row in rows)
    print(f"{len(rows)} rows in {seconds:.0f} s: {done} converged, {len(rows) - done} refused, {wrong} do not hold")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
