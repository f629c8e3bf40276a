"""Describe a bench file: JSON Schema of one row of the CSV that `read_measured` reads, by column headings.

A heading is a name with a unit in brackets or in the row below, SI without one; what precedes the headings or starts
with # is passed over.
"""

from __future__ import annotations

from typing import Any

from sits_mech.analysis.measured import HEADINGS
from sits_mech.schemas.scene import DIALECT

_UNIT = r"\s*([\[(].*[\])])?$"


def bench_schema() -> dict[str, Any]:
    """Return the schema of a row of a bench file: an object whose keys are the headings."""
    columns = {
        f"^{each.pattern}{_UNIT}": {"type": "number", "x-unit": each.unit or "1", "description": each.meaning}
        for each in HEADINGS
    }
    return {
        "$schema": DIALECT, "title": "Row of a bench file of sits-mech", "type": "object",
        "patternProperties": columns, "minProperties": 2,
    }
