"""What does a study leave behind? Its arguments on the command line, its rows as CSV and Markdown."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sits_mech.scene.files import write_text


def study_arguments(doc: str) -> tuple[bool, Path]:
    """Return whether a study runs at coarse settings, and the folder of its results, which is made.

    Parameters
    ----------
    doc : str
        The study's docstring: what it asks.
    """
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="few points and loose tolerances: does it still run?")
    parser.add_argument("--output", type=Path, required=True, help="folder of tables and pictures")
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    return asked.coarse, asked.output


def write_rows(rows: Sequence[Mapping[str, Any]], path: Path) -> str:
    """Write rows as CSV to `path` and as Markdown beside it, and return the Markdown.

    Parameters
    ----------
    rows : sequence of mapping
        The first one's keys are the headings; floats keep all digits in the CSV and four in the Markdown.
    path : Path
        The CSV.
    """
    names = list(rows[0])
    stream = io.StringIO()
    table = csv.DictWriter(stream, names, lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    lines = [f"| {' | '.join(names)} |", "|" + "---|" * len(names)]
    lines += [f"| {' | '.join(_cell(row.get(name)) for name in names)} |" for row in rows]
    text = "\n".join(lines) + "\n"
    write_text(path, stream.getvalue())
    write_text(path.with_suffix(".md"), text)
    return text


def _cell(value: Any) -> str:
    """Return a value as it stands in a table that is read."""
    return f"{value:.4g}" if isinstance(value, float) else str(value).replace("|", "/")
