"""What does a study leave behind? Its arguments on the command line, its rows as CSV and Markdown."""

from __future__ import annotations

import argparse
import csv
import io
import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sits_mech.disk_cache import keep_nothing
from sits_mech.scene.files import write_text


def study_arguments(doc: str, *, timed: bool = False) -> tuple[bool, Path]:
    """Return whether a study runs at coarse settings, and the folder of its results, which is made.

    Parameters
    ----------
    doc : str
        The study's docstring: what it asks.
    timed : bool
        Whether it tells what solves take: then it uses nothing that others have prepared (SITS_MECH_CACHE).
    """
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="few points and loose tolerances: does it still run?")
    parser.add_argument("--output", type=Path, required=True, help="folder of tables and pictures")
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    if timed:
        keep_nothing()
    return asked.coarse, asked.output


def kept_rows(
    numbers: Iterable[int], measure: Callable[[int], dict[str, Any]], folder: Path
) -> list[dict[str, Any]]:
    """Return the row of each scene: one that is kept in `folder` from a stopped run, or measured, told and kept."""
    rows = list[dict[str, Any]]()
    for number in numbers:
        path = folder / f"scene_{number:03d}.json"
        if not path.exists():
            row = measure(number)
            write_text(path, json.dumps(row))
            print(*(f"{item:.3g}" if isinstance(item, float) else item for item in row.values()), flush=True)
        rows.append(json.loads(path.read_text(encoding="utf-8")))
    return rows


def write_rows(rows: Sequence[Mapping[str, Any]], path: Path, missing: Any = "") -> str:
    """Write rows as CSV to `path` and as Markdown beside it, and return the Markdown.

    Parameters
    ----------
    rows : sequence of mapping
        All their keys are the headings; floats keep all digits in the CSV and four in the Markdown.
    path : Path
        The CSV.
    missing : Any
        What stands where a row lacks a key.
    """
    names = list(dict.fromkeys(name for row in rows for name in row))
    stream = io.StringIO()
    table = csv.DictWriter(stream, names, missing, lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    lines = [f"| {' | '.join(names)} |", "|" + "---|" * len(names)]
    lines += [f"| {' | '.join(_cell(row.get(name, missing)) for name in names)} |" for row in rows]
    text = "\n".join(lines) + "\n"
    write_text(path, stream.getvalue())
    write_text(path.with_suffix(".md"), text)
    return text


def write_references(rows: Iterable[Mapping[str, Any]], what: str, path: Path) -> None:
    """Write references as JSON, a row a line below what they are."""
    lines = ",\n".join(" " + json.dumps(row) for row in rows)
    write_text(path, f'{{"what": {json.dumps(what)},\n"rows": [\n{lines}\n]}}\n')


def add_references(
    doc: str | None, about: str, file: str, quick: Sequence[str], rows: Mapping[str, Callable[[bool], dict[str, Any]]],
) -> None:
    """Make references by NGSolve, row by row by their names, and add each to DIR/FILE; `quick` ones are the coarse run.

    A row that does not settle, an ArithmeticError, is left out.
    """
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="few and quick rows: does it still run?")
    parser.add_argument("--output", type=Path, required=True, help=f"folder of {file}")
    parser.add_argument("--only", action="append", help="rows whose names have this in them; may be repeated")
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    if find_spec("ngsolve") is None:
        print("not installed, no references are made: pip install ngsolve")
        return
    path, words = asked.output / file, quick if asked.coarse else asked.only
    for name, row_of in rows.items():
        if words and not any(word in name for word in words):
            continue
        began = time.process_time()
        try:
            row = row_of(asked.coarse)
        except ArithmeticError as failure:
            print(f"{name}: left out: {failure}", flush=True)
            continue
        print(f"{name}: {row['error']}, {row['source']}, {time.process_time() - began:.0f} s", flush=True)
        kept = {one["name"]: one for one in json.loads(path.read_text())["rows"]} if path.exists() else {}
        every = kept | {name: row}
        write_references([every[each] for each in rows if each in every], about, path)


def _cell(value: Any) -> str:
    """Return a value as it stands in a table that is read."""
    return f"{value:.4g}" if isinstance(value, float) else str(value).replace("|", "/")
