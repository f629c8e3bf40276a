"""Tabulate a ladder of tolerances: each rung's errors and seconds, and the conclusion in one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table

from sits_mech.chain.ladder import Rung, power, sentence
from sits_mech.report.tables.solves import column_table, key_table


def ladder_tables(rungs: Sequence[Rung]) -> list[Table]:
    """Return the rungs as a table, and the sentence."""
    headings = ("tolerance", "error of dL", "from finest", "error of pose", "from finest", "seconds", "status")
    found = column_table("solved to smaller and smaller tolerances, each from the start", headings)
    for one in rungs:
        errors = (one.estimated, one.difference, one.estimated_pose, one.difference_pose)
        cells = ("-" if math.isnan(error) else f"{error:.2g}" for error in errors)
        found.add_row(power(one.tolerance), *cells, f"{one.seconds:.2g}", one.status.partition(";")[0])
    return [found, key_table("ladder", [("of the change of L", sentence([[one.asked for one in rungs]]))])]


def ladder_record(rungs: Sequence[Rung]) -> dict[str, Any]:
    """Return the rungs and their sentence for a program."""
    return {"ladder": [asdict(one) for one in rungs], "ladder_sentence": sentence([[one.asked for one in rungs]])}
