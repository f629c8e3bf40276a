"""Describe a bench file: JSON Schema of one row of the CSV that `read_measured` reads, by column headings.

A heading is a name with a unit in brackets or in the row below, SI without one; what precedes the headings or starts
with # is passed over.
"""

from __future__ import annotations

from typing import Any

from sits_mech.quantities import POSE, UNITS, WRENCH
from sits_mech.schemas.scene import DIALECT

_UNIT = r"\s*([\[(].*[\])])?$"


def bench_schema() -> dict[str, Any]:
    """Return the schema of a row of a bench file: an object whose keys are the headings."""
    number = {"type": "number"}
    loads, poses = (
        {f"^{name.replace('_', '_?')}{_UNIT}": _column(UNITS[name], what) for name in names}
        for names, what in ((WRENCH, "a force or moment on the target"), (POSE, "where stages put the target"))
    )
    depth = {f"^depth{_UNIT}": _column("m", "how far the target was pressed down from where it rests without load")}
    coils = {
        rf"^L(\d+|_.+?){_UNIT}": _column("H", "the inductance of a coil at its terminals, by number or by name"),
        r"^code(\d+|_.+)$": number | {"x-unit": "1", "description": "the converter's code of a coil"},
    }
    return {
        "$schema": DIALECT, "title": "Row of a bench file of sits-mech", "type": "object",
        "patternProperties": loads | poses | depth | coils, "minProperties": 2,
    }


def _column(unit: str, what: str) -> dict[str, Any]:
    """Return the schema of a column."""
    return {"type": "number", "x-unit": unit, "description": f"{what}; {unit.replace('*', ' ')} without a unit"}
