"""Tabulate a plan on one screen: what is solved, what is left out, the cost of smaller errors; and a ladder."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table

from sits_mech.analysis.ladder import Rung, power, sentence
from sits_mech.chain.ends import ends_of_pad
from sits_mech.chain.omissions import Omission, beside_errors, skin_depths
from sits_mech.chain.prices import Step
from sits_mech.chain.request import Plan
from sits_mech.report.tables.solves import column_table, key_table
from sits_mech.scene.sensor import Sensor


def plan_tables(sensor: Sensor, found: Plan) -> list[Table]:
    """Return a plan as tables: what is solved, what is left out, what finer answers take, what else there is to say."""
    solved = column_table(f"{sensor.name}: solved", ("part", "model", "error", "seconds", "why"))
    reasons = {"magnetics": found.magnetics.reason}
    reasons |= {} if found.mechanics is None else {"mechanics": found.mechanics.reason}
    for step in found.steps:
        solved.add_row(*_cells(step), reasons[step.half])
    finer = column_table("finer answers", ("part", "model", "error", "seconds", "overall error"))
    for step in found.finer:
        finer.add_row(*_cells(step), f"{step.whole:.2g} instead of {found.error:.2g}")
    rows = [("expected error", _error(found)), ("expected time", f"about {_short(found.seconds)} s on one core")]
    if sensor.target is not None:
        rows.append(("skin", _skin(skin_depths(sensor))))
    rows += [("note", note) for note in found.notes]
    return [solved, _omitted(found.left_out), *([finer] if found.finer else []), key_table("overall", rows)]


def left_out_tables(items: Sequence[Omission]) -> list[Table]:
    """Return omissions of known or unknown size that count: a table, or none."""
    some = [item for item in items if item.size > 0.0 or math.isnan(item.size)]
    if not some:
        return []
    found, (size, unknown) = _omitted(some), beside_errors(items)
    parts = [f"not in the errors above: {size:.2g}"] if size > 0.0 else []
    parts += [f"not estimated: {', '.join(unknown)}"] if unknown else []
    found.caption = "; ".join(parts)
    return [found]


def _omitted(items: Sequence[Omission]) -> Table:
    """Return omissions as a table, the largest first."""
    found = column_table("left out", ("what", "effect at most", "relative to", "in the errors", "why"))
    for item in sorted(items, key=lambda item: -math.inf if math.isnan(item.size) else -item.size):
        size = "not estimated" if math.isnan(item.size) else f"{item.size:.2g}" if item.size else "none"
        of = "L0" if not item.of_change else "the displacement" if item.half == "mechanics" else "the change"
        held = "" if item.size == 0.0 else "not requested" if not item.counts else "yes" if item.in_error else "no"
        found.add_row(item.what, size, of if item.size else "", held, item.reason)
    return found


def _cells(step: Step) -> tuple[str, str, str, str]:
    """Return half, model, asked error and seconds of a step."""
    return step.half, step.model, f"{step.error:.1g}", _short(step.seconds)


def _error(found: Plan) -> str:
    """Return the errors to expect of a planned answer."""
    unknown = f", and {', '.join(found.not_estimated)}, not estimated" if found.not_estimated else ""
    of = "the change of inductance" if found.mechanics is None else "the signals' full scale"
    return f"{found.error:.2g} of {of}, from tolerances and omissions{unknown}"


def _short(seconds: float) -> str:
    """Return seconds to one digit."""
    return f"{float(f'{seconds:.1g}'):g}"


def _skin(depths: float) -> str:
    """Return a description of the current in the target."""
    inside = "fades towards its inside" if depths < 3.0 else "in thin layers at its surfaces"
    how = "through its whole thickness" if depths < 1.0 else inside
    return f"the target is {depths:.2g} skin depths thick: current {how}"


def plan_record(sensor: Sensor, found: Plan) -> dict[str, Any]:
    """Return a plan for a program."""
    choices = {"mechanics": found.mechanics, "magnetics": found.magnetics}
    factor = None if found.mechanics is None else ends_of_pad(sensor)
    return {
        **{
            half: None if choice is None else {"name": choice.name, "reason": choice.reason}
            for half, choice in choices.items()
        },
        "rungs": found.rungs,
        "steps": [asdict(step) for step in found.steps],
        "finer": [asdict(step) for step in found.finer],
        "skin_depths": skin_depths(sensor),
        "plane_strain": None if factor is None else vars(factor),
        "left_out": [vars(item) for item in found.left_out],
        "not_estimated": found.not_estimated,
        "notes": found.notes,
        "asked_error": found.error,
        "expected_seconds": found.seconds,
    }


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
