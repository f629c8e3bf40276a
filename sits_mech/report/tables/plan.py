"""What does one print of a plan? The models and why, what is left out and its size, the error asked, the time."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from sits_mech.chain.omissions import skin_depths
from sits_mech.chain.plan import Plan
from sits_mech.mechanics.finite_length import FiniteLength, finite_length_factor
from sits_mech.report.tables.solves import key_table
from sits_mech.scene.sensor import Sensor


def plan_rows(sensor: Sensor, found: Plan) -> list[tuple[str, str]]:
    """Return the lines of a plan: name and text of each."""
    rows = []
    for half, choice in (("mechanics", found.mechanics), ("magnetics", found.magnetics)):
        if choice is not None:
            rows.append((half, f"{choice.name}: {choice.reason}"))
    rows.append(("resolution", "; ".join(found.rungs)))
    if found.mechanics is not None and (factor := plane_strain(sensor)) is not None:
        text = f"shear {factor.shear:.3g}, compression {factor.compression:.3g}, tilt {factor.tilt:.3g}"
        rows.append(("plane strain", f"too stiff for this pad by {text} (small strain, to {factor.error:.1g})"))
    if sensor.target is not None:
        rows.append(("skin", _skin(skin_depths(sensor))))
    rows += [("left out", item.text) for item in found.left_out]
    rows += [("note", note) for note in found.notes]
    asked = "of the change of inductance: tolerances, not below the finest rungs, and omissions; answers tell their own"
    rows.append(("asked error", f"{found.error:.1g} {asked}"))
    rows.append(("expected time", f"about {float(f'{found.seconds:.1g}'):g} s on one core, if the solve holds"))
    return rows


def plane_strain(sensor: Sensor) -> FiniteLength | None:
    """Return what the planar layer is worth for a pad; None where no planar layer stands for it at all."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None or target.shape == "outline":
        return None
    if elastomer.mesh is not None or elastomer.kind == "pillars":
        return None
    return finite_length_factor(sensor)


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
    factor = None if found.mechanics is None else plane_strain(sensor)
    return {
        **{
            half: None if choice is None else {"name": choice.name, "reason": choice.reason}
            for half, choice in choices.items()
        },
        "rungs": found.rungs,
        "skin_depths": skin_depths(sensor),
        "plane_strain": None if factor is None else vars(factor),
        "left_out": [vars(item) for item in found.left_out],
        "notes": found.notes,
        "asked_error": found.error,
        "expected_seconds": found.seconds,
    }
