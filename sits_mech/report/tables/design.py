"""Tabulate a design search: the recommendation, its figures, the prices of limits, why the other designs lost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rich.table import Table

from sits_mech.quantities import UNITS
from sits_mech.report.tables.solves import column_table, key_table
from sits_mech.synthesis.answer import DesignAnswer, Figure
from sits_mech.synthesis.around import Changes, Preview, Price
from sits_mech.synthesis.bounds import DesignPlan
from sits_mech.synthesis.required.kinds import INVERSE, figure_words, kind_of, shown_as
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.written import SPECIAL

_NOTHING = 5e-4  # of what is minimised: a gain that is none


def design_tables(asked: Requirements, found: DesignAnswer) -> list[Table]:
    """Return the tables of an answer: what is recommended, figures, prices, what numbers change, other values."""
    title = "recommended" if found.feasible else "nearest design"
    lines = [("limits", found.verdict)] + [(key, str(value)) for key, value in found.values.items()]
    if math.isfinite(found.share.value):
        asked_for = f"{100.0 * asked.least_yield:.3g} % required"
        value, low, high = (f"{100.0 * each:.3g}" for each in found.share)
        span = "" if low == high else f" ({low} to {high} % from the errors)"
        lines.append(("yield", f"{value} %{span} of the sensors made, {asked_for}"))
    lines += [("may be as good", words) for words in found.tied]
    lines += [("comes of", words) for words in found.causes]
    for name, most in found.guards.items():
        keep, limit = (figure_words(name, each) for each in (most, found.task.limits[name]))
        words = f"{name} <= {keep}, for {100.0 * asked.least_yield:.3g} % of those made to hold {limit}"
        lines.append(("to keep by design", words))
    lines.append(("solved", f"{found.solves} designs"))
    tables = [key_table(title, lines), figure_table(found)]
    prices = [(each.name, price_words(each, list(found.task.minimised))) for each in found.binding]
    tables += [key_table("what limits it", prices)] if prices else []
    if found.sensitivities:
        names = list(dict.fromkeys([*found.task.minimised, *found.task.limits, "yield"]))
        names = [name for name in names if name != INVERSE]
        tables.append(change_table("effect of moving a number by a tenth of its range", found.sensitivities, names))
        names = list(dict.fromkeys([*found.task.minimised, *(each.name for each in found.binding)]))
        limiting = "effect of 10 % more of each number on what limits it"
        tables += [change_table(limiting, found.ten_percent, names)] if names else []
    others = [(f"{each.key} = {each.value}", f"{each.design}: {each.why}") for each in found.lost]
    return tables + ([key_table("why not", others)] if others else [])


def design_plan_tables(found: DesignPlan) -> list[Table]:
    """Return what a search is to solve, the least of each size and strain, and the choices that are left out."""
    seconds = f"about {found.seconds:.2g} of the processor"
    if found.first_seconds < found.seconds:
        seconds += f"; {found.first_seconds:.2g} where none can hold the limits"
    lines = [("designs to solve", f"about {found.designs}"), ("seconds", seconds)]
    lines += [(f"least {name}", figure_words(name, size)) for name, size in found.least.items()]
    tables = [key_table("planned", lines)]
    return tables + ([key_table("not to be solved", [*found.not_solved.items()])] if found.not_solved else [])


def preview_table(found: Preview) -> Table:
    """Return what the first solved designs predict."""
    beyond = f"beyond limits: {', '.join(found.exceeded)}" if found.exceeded else "within the limits"
    lines = [("predicted by", f"{found.solved} solved designs, {beyond}")]
    lines += [(key, str(value)) for key, value in found.values.items()]
    for name, (value, error) in found.figures.items():
        unsure = f" +- {figure_words(name, error)}" if error > 0.0 else ""
        lines.append((kind_of(name).title or name, f"{figure_words(name, value)}{unsure}"))
    return key_table("preview", lines)


def preview_record(found: Preview) -> dict[str, Any]:
    """Return a preview for a program, figures in SI."""
    rows = {name: {"value": value, "error": error} for name, (value, error) in found.figures.items()}
    return {"recommended": found.values, "figures": rows, "exceeded": list(found.exceeded), "solves": found.solved}


def asked_table(asked: Requirements) -> Table:
    """Return the requirements: loads, manufacturing tolerances, what is minimised."""
    lines = [(name, f"{low:g} to {high:g} {UNITS[name]}") for name, (low, high) in asked.loads.items()]
    lines.append(("overload", f"{asked.overload:g} times the loads, carried within the data of the silicone"))
    varied = asked.space.variables
    lines += [(each.key, f"from {each.low:g} to {each.high:g} {each.unit}".strip()) for each in varied]
    lines += [(key, ", ".join(map(str, values))) for key, values in asked.space.lists.items()]
    for name, size in asked.tolerance.items():
        share = name in SPECIAL and not SPECIAL[name]
        lines.append((f"{name}, made", f"+- {100.0 * size:g} %" if share else f"+- {size:g} in SI units"))
    figures = " + ".join(f"{weight:g} {name}" if weight != 1.0 else name for name, weight in asked.minimised.items())
    return key_table("asked", [*lines, ("minimised", figures or "nothing: the first design that holds every limit")])


def price_words(price: Price, minimised: Sequence[str]) -> str:
    """Return a binding limit and its price in words."""
    held = "exceeded by" if price.excess > 0.0 else "held with" if price.excess < 0.0 else "just held"
    words = f"{held} {100.0 * abs(price.excess):.2g} % of it" + (" to spare" if price.excess < 0.0 else "")
    if not math.isfinite(price.gain):
        return words
    aim = " + ".join(minimised)
    if price.gain > -_NOTHING:
        return f"{words}; relaxing it by 10 % would gain nothing"
    return f"{words}; relaxing it by 10 % would gain {100.0 * -price.gain:.2g} % less of {aim}"


def change_table(title: str, changes: Changes, names: Sequence[str]) -> Table:
    """Return sensitivities of figures to the scene's numbers, in percent of each figure, a line a number."""
    some = [name for name in names if name in changes]
    table = column_table(title, ("number", *some), justify="right")
    table.columns[0].justify = "left"
    for key in dict.fromkeys(key for name in some for key in changes[name]):
        table.add_row(key, *(_percent(changes[name][key]) for name in some))
    return table


def _percent(share: float) -> str:
    """Return a relative change in percent: two digits, zero without sign."""
    if abs(share) < _NOTHING:
        return "0"
    return f"{100.0 * share:+.0f} %" if abs(share) >= 0.1 else f"{100.0 * share:+.2g} %"


def figure_table(found: DesignAnswer) -> Table:
    """Return the figures with their limits, those with a limit first."""
    table = column_table("figures", ("figure", "value", "+-", "limit", "holds"), justify="right")
    table.columns[0].justify = table.columns[-1].justify = "left"
    for each in sorted(found.figures, key=lambda own: own.limit is None):
        table.add_row(*figure_cells(each))
    return table


def figure_cells(each: Figure) -> tuple[str, str, str, str, str]:
    """Return a figure as cells of a table."""
    kind = kind_of(each.name)
    sign = ">=" if kind.least else "<="
    limit = "" if each.limit is None else f"{sign} {each.limit:.4g} {each.unit}"
    error = "not known" if math.isnan(each.error) else f"{float(f'{each.error:.2g}'):g}" if each.error else ""
    return kind.title or each.name, f"{each.value:.4g} {each.unit}", error, limit, each.holds


def design_record(found: DesignAnswer) -> dict[str, Any]:
    """Return an answer for a program, figures in SI."""
    rows = {}
    for each in found.figures:
        scale = shown_as(each.name)[1]
        own = {"value": each.value / scale, "error": each.error / scale, "holds": each.holds}
        rows[each.name] = own | {"limit": None if each.limit is None else each.limit / scale}
    return {
        "feasible": found.feasible,
        "within_error": list(found.undecided),
        "recommended": found.values,
        "figures": rows,
        "binding": [{"name": each.name, "excess": each.excess, "price": each.gain} for each in found.binding],
        "yield": found.share.value,
        "yield_between": list(found.share[1:]),
        "yield_of_each": found.held,
        "front": [
            {"choice": list(each.design.choice), "x": list(each.design.x)} | found.task.figures(each)
            for each in found.front
        ],
        "sensitivities": found.sensitivities,
        "ten_percent_more": found.ten_percent,
        "lost": [vars(each) for each in found.lost],
        "tied": list(found.tied),
        "guards": found.guards,
        "causes": list(found.causes),
        "solves": found.solves,
        "notes": list(found.notes),
    }
