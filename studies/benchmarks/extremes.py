"""Does every extreme case give a consistent answer, or a refusal with its name? Both physics and the chain.

What is asked and held against what: extreme/layers.py and extreme/solids.py (stiff, thin, tall, pressed, pulled,
sheared, tilted, overloaded layers and pads: work = energy, moment identity, path), extreme/films.py and walls.py (pads
of 0.01 mm: thin-layer limit; columns that fall over: beams), extreme/plates.py (skin depth over thickness 1e-3 to 1e3,
gaps from 0.05 mm, 1 Hz to 100 MHz: reciprocity, passivity, growth with frequency; whole sensors), extreme/poses.py
(gaps of 10 um, tilts to touching, foils and blocks, 1 to 60 turns, 64 coils: against richer models) and
extreme/any_answer.py (500 random scenes from all that the loader accepts: answered or refused by name). Each row is
converged and within what is allowed, or, where it is an extreme indeed, refused by name; any other ends the study with
exit code 1.

Run ``python -m benchmarks.extremes [--coarse] [--only mechanics,magnetics,chain,scenes] --output DIR``: a table as CSV
and Markdown, written anew after every row, and a picture of each row's violation over what is allowed, grouped by kind.
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
from extreme.any_answer import any_scenes
from extreme.films import films
from extreme.layers import layers
from extreme.plates import chain, plates
from extreme.poses import poses
from extreme.rows import DONE, Row
from extreme.solids import solids
from extreme.walls import walls
from threadpoolctl import threadpool_limits

from sits_mech.disk_cache import keep_nothing
from sits_mech.report.pictures.style import COLUMN, new_figure, save_figure


def mechanics(coarse: bool) -> Iterator[Row]:
    """Yield the rows of layers in plane strain and of pads in three dimensions."""
    return joined(layers(coarse), solids(coarse), films(coarse), walls(coarse))


def magnetics(coarse: bool) -> Iterator[Row]:
    """Yield the rows of plates and of poses."""
    return joined(plates(coarse), poses(coarse))


PARTS = {"mechanics": mechanics, "magnetics": magnetics, "chain": chain, "scenes": any_scenes}
SMALLEST, LARGEST = 1e-4, 1e2  # between which is drawn
MARKS = (
    "full: true over stated error, against a richer or another model; hollow: violation of an identity over what is "
    "allowed; cross: refused by name; star: does not hold"
)


def draw(rows: Sequence[Row], path: Path) -> None:
    """Write a picture: each row's violation over what is allowed, one line each under its name, grouped by kind.

    Random scenes are too many for names: they share the lines of how they ended.
    """
    named = [row for row in rows if row.physics != "any scene"]
    drawn = [row for row in rows if row.physics == "any scene"]
    labels = [f"{row.physics}: {row.case}" for row in named]
    kinds = list(dict.fromkeys(row.status for row in drawn))
    labels += [f"{sum(row.status == kind for row in drawn)} random scenes: {kind}" for kind in kinds]
    places = [*range(len(named)), *(len(named) + kinds.index(row.status) for row in drawn)]
    height, width = max(0.5, 0.014 * len(labels)), 2.0 * COLUMN
    with new_figure(height=height, width=width) as (figure, (axes,)):
        for place, row in zip(places, [*named, *drawn], strict=True):
            share = min(max(row.violation / row.allowed, SMALLEST), LARGEST)
            refused = row.status != DONE
            mark = "*" if not row.holds else "x" if refused else "o"
            color = "r" if not row.holds else f"C{(0, 1, 2, 4)[list(PARTS).index(row.part)]}"
            fill = color if row.against and not refused else "none"
            at = share if np.isfinite(share) else 1.0
            axes.plot(at, place, mark, color=color, markerfacecolor=fill, markersize=3)
        axes.axvline(1.0, color="0.5", lw=0.8)
        axes.set(xscale="log", xlabel="violation over what is allowed [-]", ylim=(len(labels), -1.0))
        axes.set_yticks(range(len(labels)), labels, fontsize=4.5)
        axes.grid(axis="y", lw=0.2)
        figure.suptitle(MARKS, fontsize=5, wrap=True)
        save_figure(figure, path)


def tabled(row: Row) -> dict[str, object]:
    """Return a row as it stands in the table."""
    return {
        "physics": row.physics, "case": row.case, "status": row.status, "holds": row.holds, "min J": row.min_J,
        "estimated error": row.estimated, "violation": row.violation, "allowed": row.allowed,
        "violation / allowed": row.violation / row.allowed, "reference": "yes" if row.against else "",
        "seconds": row.seconds, "remark": row.remark,
    }


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
    keep_nothing()  # rows tell their seconds
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
