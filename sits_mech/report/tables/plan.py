"""Tabulate a plan on one screen: what is solved, what is left out, the cost of smaller errors; and a ladder."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from itertools import chain
from typing import TYPE_CHECKING, Any

from rich.table import Table

from sits_mech.analysis.ladder import LadderPoint, LadderStep
from sits_mech.chain.models import Candidate, Choice, Why
from sits_mech.chain.plans.plan import Plan, PlannedHalf
from sits_mech.chain.plans.prices import LoadForecast
from sits_mech.magnetics.modes import skin_depths
from sits_mech.mechanics.models import ends_of_pad
from sits_mech.notes import Omission
from sits_mech.report.left_out import entry, reason, relative_words, size_text
from sits_mech.report.notes import sentences
from sits_mech.report.tables.solves import column_table, key_table
from sits_mech.scene.sensor import Sensor

if TYPE_CHECKING:
    from sits_mech.analysis.histories.price import HistoryPrice


def plan_tables(sensor: Sensor, found: Plan) -> list[Table]:
    """Return a plan as tables: what is solved, what is left out, what finer answers take, what else there is to say."""
    choices = {"mechanics": found.mechanics, "magnetics": found.magnetics}
    error = f"error of {'dL' if found.mechanics is None else 'the signals'}"
    solved = column_table(f"{sensor.name}: solved", ("part", "model", error, "seconds", "why"))
    for step in found.steps:
        solved.add_row(*_cells(step), choice_reason(choices[step.half]))
    models = [_models(half, choice) for half, choice in choices.items() if choice is not None]
    finer = column_table("finer answers", ("part", "model", error, "seconds", "overall error"))
    for step in found.finer:
        finer.add_row(*_cells(step), f"{step.whole:.2g} instead of {found.error:.2g}")
    rows = [("expected error", _error(found)), ("expected time", f"about {_short(found.seconds)} s on one core")]
    if sensor.target is not None:
        rows.append(("skin", _skin(skin_depths(sensor))))
    rows += [("note", words) for words in sentences(found.notes)]
    finer_tables = [finer] if found.finer else []
    return [solved, *models, left_out_table(found.left_out), *finer_tables, key_table("overall", rows)]


def price_table(found: HistoryPrice, source: str) -> Table:
    """Return what a history takes as a table."""
    rows = [("rows", f"{found.rows}"), ("solved", f"{found.solved} times at least, those between are interpolated"),
            ("expected time", f"about {_short(found.seconds)} s on one core, by these")]
    return key_table(source, rows)


def taken_words(seconds: Sequence[tuple[str, float]], counts: LoadForecast | None) -> str:
    """Say what a load is to take, by the model of each half, and what is solved of a pad in space."""
    words = [f"{name}, about {_short(own)} s" for name, own in seconds]
    if counts is not None:
        parts = f"{counts.increments} increments" if counts.increments > 1 else "1 increment"
        meshes = " and ".join(f"{count:,}" for count in counts.unknowns)
        touching = ", free faces pressed" if counts.touching else ""
        more = f"{_short(counts.most)} s with finer meshes{'' if counts.touching else ' or contact'}"
        words[0] = f"{seconds[0][0]}, meshes of some {meshes} unknowns, {parts}{touching}, about "
        words[0] += f"{_short(counts.seconds)} s, {more}"
    return f"to solve: {'; '.join(words)}"


def choice_reason(choice: Choice | None) -> str:
    """Say why a model was taken."""
    if choice is None:
        return ""
    held = [each for each in choice.candidates if each.refusal is None]
    cheaper = [each.model.name for each in held[: [each.model.name for each in held].index(choice.name)]]
    others = f"; {', '.join(cheaper)} would leave out too much" if cheaper else ""
    return {
        Why.NAMED: "asked for",
        Why.ONLY: "no other model holds the scene",
        Why.WITHIN: f"the cheapest within the tolerance{others}",
        Why.BENDS: "the cheapest that bends the target, which takes half of the tolerance or more",
        Why.LEAST: "no model is within the tolerance: the one with the least error",
    }[choice.why]


def _models(half: str, choice: Choice) -> Table:
    """Return all models of a half: whether they hold, their errors, what they leave out, their cost."""
    headings = ("", "model", "asked + left out", "of which left out", "operations", "seconds", "does not hold, as")
    found = column_table(f"models of the {half}", headings)
    for each in choice.candidates:
        found.add_row("taken" if each.model.name == choice.name else "", *_model_cells(each))
    return found


def _model_cells(each: Candidate) -> tuple[str, ...]:
    """Return the cells of a model."""
    if each.cost is None:
        return each.model.name, "-", "", "", "", str(each.refusal)
    counted = [item for item in each.left_out if item.weighs]
    parts = (f"{item.kind} {item.size:.1g} of {relative_words(item)}" for item in counted if not item.unbounded)
    left = "; ".join([*(f"{item.kind}: no size" for item in counted if item.unbounded), *parts])
    error = "not bounded" if math.isnan(each.error) else f"{each.error:.2g}"
    return each.model.name, error, left, f"{each.cost.operations:.0e}", _short(each.cost.seconds), ""


def left_out_table(items: Sequence[Omission]) -> Table:
    """Return omissions as a table, those without a size first, then the largest."""
    found = column_table("left out", ("what", "effect", "relative to", "in the errors", "why"))
    for item in sorted(items, key=lambda item: -math.inf if math.isnan(item.size) else -item.size):
        held = "" if item.size == 0.0 else "not requested" if not item.counts else "no" if item.unbounded else "yes"
        found.add_row(
            str(item.kind), size_text(item), relative_words(item) if item.size else "", held, reason(item)
        )
    return found


def left_out_tables(items: Sequence[Omission]) -> list[Table]:
    """Return omissions of known or unknown size: a table, or none."""
    some = [item for item in items if item.size > 0.0 or math.isnan(item.size)]
    if not some:
        return []
    found = left_out_table(some)
    unbounded = [str(item.kind) for item in some if item.unbounded]
    found.caption = f"in no error, as no size is known: {', '.join(unbounded)}" if unbounded else None
    return [found]


def _cells(step: PlannedHalf) -> tuple[str, str, str, str]:
    """Return half, model, asked error and seconds of a step."""
    return step.half, step.model, f"{step.error:.1g}", _short(step.seconds)


def _error(found: Plan) -> str:
    """Return the errors to expect of a planned answer."""
    names = ", ".join(str(item.kind) for item in found.unbounded)
    unknown = f", and {names}, of no known size" if names else ""
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
            half: None if choice is None else {"name": choice.name, "reason": choice_reason(choice)}
            for half, choice in choices.items()
        },
        "models": {
            half: [] if choice is None else [
                {"name": each.model.name, "refusal": None if each.refusal is None else str(each.refusal),
                 "error": each.error, "left_out": [entry(item) for item in each.left_out],
                 "cost": None if each.cost is None else each.cost._asdict()} for each in choice.candidates
            ] for half, choice in choices.items()
        },
        "rungs": found.rungs,
        "steps": [asdict(step) for step in found.steps],
        "finer": [asdict(step) for step in found.finer],
        "skin_depths": skin_depths(sensor),
        "plane_strain": None if factor is None else vars(factor),
        "left_out": [entry(item) for item in found.left_out],
        "not_estimated": [str(item.kind) for item in found.unbounded],
        "notes": sentences(found.notes),
        "asked_error": found.error,
        "expected_seconds": found.seconds,
    }


def ladder_tables(rungs: Sequence[LadderStep]) -> list[Table]:
    """Return the rungs as a table, and the sentence."""
    headings = ("tolerance", "error of dL", "from finest", "error of pose", "from finest", "seconds", "status")
    found = column_table("solved to smaller and smaller tolerances, each from the start", headings)
    for one in rungs:
        errors = (one.estimated, one.difference, one.estimated_pose, one.difference_pose)
        cells = ("-" if math.isnan(error) else f"{error:.2g}" for error in errors)
        found.add_row(power(one.tolerance), *cells, f"{one.seconds:.2g}", one.status.partition(";")[0])
    return [found, key_table("ladder", [("of the change of L", ladder_sentence([[one.asked for one in rungs]]))])]


def ladder_record(rungs: Sequence[LadderStep]) -> dict[str, Any]:
    """Return the rungs and their sentence for a program."""
    return {
        "ladder": [asdict(one) for one in rungs],
        "ladder_sentence": ladder_sentence([[one.asked for one in rungs]]),
    }


def rung_line(rung: LadderStep, left: int) -> str:
    """Return a rung in a line, with how many follow."""
    came = f"error {rung.estimated:.2g}" if rung.status == "converged" else rung.status.partition(";")[0]
    return f"{power(rung.tolerance)}: {came}, {rung.seconds:.2g} s" + (f"; {left} to come" if left else "")


def ladder_sentence(ladders: Sequence[Sequence[LadderPoint]]) -> str:
    """Summarize ladders: "ask 1e-2: 0.3 s; 3e-3: 1.1 s; errors below 1e-3 cannot be reached".

    A tolerance counts where the answer's own estimate is within it; where only some of several ladders reach it, how
    many do is shown. What cannot be reached is what is below the least estimate of a ladder whose finest rung misses.
    """
    parts, count, held = [], len(ladders), dict[float, list[float]]()
    for one in chain.from_iterable(ladders):
        if one.holds:
            held.setdefault(one.tolerance, []).append(one.seconds)
    for tolerance, times in sorted(held.items(), reverse=True):
        span = _span([f"{min(times):.2g}", f"{max(times):.2g}"])
        parts.append(f"{power(tolerance)}: {span} s{_share(len(times), count)}")
    reached = [min(one.estimated for one in row) for row in ladders if not _finest(row).holds]
    limits = sorted(filter(math.isfinite, reached))
    if limits:
        span = _span([power(limits[0]), power(limits[-1])])
        parts.append(f"errors below {span} cannot be reached{_share(len(reached), count)}")
    elif not reached:
        parts.append(f"errors below {power(_finest(ladders[0]).tolerance)} were not requested")
    return ("ask " if held else "") + "; ".join(parts) if parts else "no tolerance of the ladder can be reached"


def _share(some: int, count: int) -> str:
    """Say how many of several ladders it is, empty for all."""
    return f" ({some} of {count})" if some < count else ""


def power(value: float) -> str:
    """Format a tolerance as it is asked: 3e-3."""
    return f"{value:.0e}".replace("e-0", "e-")


def _span(ends: Sequence[str]) -> str:
    """Format the ends of a range, once where they are the same."""
    return ends[0] if ends[0] == ends[-1] else f"{ends[0]} to {ends[-1]}"


def _finest(row: Sequence[LadderPoint]) -> LadderPoint:
    """Return the rung of the least tolerance."""
    return min(row, key=lambda one: one.tolerance)
