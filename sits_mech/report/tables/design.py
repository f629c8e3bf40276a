"""What does one print of a search for a design? The recommendation, its figures, prices, why the others lost."""

from __future__ import annotations

import math
from typing import Any

from rich.table import Table

from sits_mech.report.tables.solves import key_table
from sits_mech.synthesis.answer import DesignAnswer, Figure, unit_of
from sits_mech.synthesis.answered import Answered
from sits_mech.synthesis.figures import INVERSE
from sits_mech.synthesis.requirements import LEAST, Requirements


def design_tables(asked: Requirements, found: DesignAnswer) -> list[Table]:
    """Return the tables of an answer: what is recommended, figures, prices and other values."""
    title = "recommended" if found.feasible else "nearest design: no solved one holds every limit"
    lines = [(key, str(value)) for key, value in found.values.items()]
    if math.isfinite(found.share):
        asked_for = f"{100.0 * asked.least_yield:.3g} % asked"
        lines.append(("yield", f"{100.0 * found.share:.3g} % of the sensors made, {asked_for}"))
    lines += [("as good", words) for words in found.tied]
    lines.append(("solved", f"{found.solves} designs"))
    tables = [key_table(title, lines), figure_table(found)]
    prices = [(each.name, price_words(each.excess, each.gain)) for each in found.binding]
    tables += [key_table("what limits it", prices)] if prices else []
    others = [(f"{each.key} = {each.value}", f"{each.design}: {each.why}") for each in found.lost]
    return tables + ([key_table("why not", others)] if others else [])


def price_words(excess: float, gain: float) -> str:
    """Return a binding limit and its price in words."""
    held = "exceeded by" if excess > 0.0 else "held by"
    price = f"; a tenth looser would change what is minimised by {100.0 * gain:+.2g} %" if math.isfinite(gain) else ""
    return f"{held} {100.0 * abs(excess):.2g} % of it{price}"


def figure_table(found: DesignAnswer) -> Table:
    """Return the figures with their limits, those with a limit first."""
    table = Table(title="figures", show_edge=False)
    for heading in ("figure", "value", "+-", "limit", "holds"):
        table.add_column(heading, justify="left" if heading in ("figure", "holds") else "right")
    for each in sorted(found.figures, key=lambda own: own.limit is None):
        table.add_row(*figure_cells(each))
    return table


def figure_cells(each: Figure) -> tuple[str, str, str, str, str]:
    """Return a figure as cells of a table."""
    sign = ">=" if each.name in (*LEAST, INVERSE) else "<="
    limit = "" if each.limit is None else f"{sign} {each.limit:.4g} {each.unit}"
    error = "not known" if math.isnan(each.error) else f"{each.error:.1g}" if each.error else ""
    return each.name, f"{each.value:.4g} {each.unit}", error, limit, each.holds


def _front_record(found: DesignAnswer, each: Answered) -> dict[str, Any]:
    """Return a design of the front: its values, as coordinates, and figures."""
    return {"choice": list(each.design.choice), "x": list(each.design.x)} | found.task.figures(each.table, each.plain)


def design_record(found: DesignAnswer) -> dict[str, Any]:
    """Return an answer for a program, figures in SI."""
    rows = {}
    for each in found.figures:
        scale = unit_of(each.name)[1]
        own = {"value": each.value / scale, "error": each.error / scale, "holds": each.holds}
        rows[each.name] = own | {"limit": None if each.limit is None else each.limit / scale}
    return {
        "feasible": found.feasible,
        "recommended": found.values,
        "figures": rows,
        "binding": [{"name": each.name, "excess": each.excess, "price": each.gain} for each in found.binding],
        "yield": found.share,
        "front": [_front_record(found, each) for each in found.front],
        "sensitivities": found.sensitivities,
        "lost": [vars(each) for each in found.lost],
        "tied": list(found.tied),
        "solves": found.solves,
        "notes": list(found.notes),
    }
