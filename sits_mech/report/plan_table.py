"""What does one print of a plan? The models and why, what is left out and its size, the error and time to expect."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from sits_mech.omissions import skin_depths
from sits_mech.plan import Plan
from sits_mech.report.tables import key_table
from sits_mech.sensor import Sensor


def plan_rows(sensor: Sensor, found: Plan) -> list[tuple[str, str]]:
    """Return the lines of a plan: name and text of each."""
    rows = []
    for half, choice in (("mechanics", found.mechanics), ("magnetics", found.magnetics)):
        if choice is not None:
            rows.append((half, f"{choice.name}: {choice.reason}"))
    rows.append(("resolution", "; ".join(found.rungs)))
    if sensor.target is not None:
        rows.append(("skin", _skin(skin_depths(sensor))))
    rows += [("left out", item.text) for item in found.left_out]
    rows.append(("expected error", f"{found.error:.1g} of the change of inductance"))
    rows.append(("expected time", f"about {found.seconds:.1g} s on one core"))
    return rows


def _skin(depths: float) -> str:
    """Return what the current in the target looks like."""
    if depths < 1.0:
        return f"the target is {depths:.2g} skin depths thick: current through its whole thickness"
    if depths < 3.0:
        return f"the target is {depths:.2g} skin depths thick: current fades towards its inside"
    return f"the target is {depths:.2g} skin depths thick: current in its skins"


def plan_table(sensor: Sensor, found: Plan) -> Table:
    """Return a plan as a table."""
    return key_table(sensor.name, plan_rows(sensor, found))


def plan_record(sensor: Sensor, found: Plan) -> dict[str, Any]:
    """Return a plan for a program."""
    choices = {"mechanics": found.mechanics, "magnetics": found.magnetics}
    return {
        **{half: None if choice is None else vars(choice) for half, choice in choices.items()},
        "rungs": found.rungs,
        "skin_depths": skin_depths(sensor),
        "left_out": [vars(item) for item in found.left_out],
        "expected_error": found.error,
        "expected_seconds": found.seconds,
    }
