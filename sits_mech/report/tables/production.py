"""Show what units of a production share and what the next ones are delivered with, for programs and for readers."""

from __future__ import annotations

from typing import Any

import numpy as np

from sits_mech.analysis.built.delivered import MOST, Delivered
from sits_mech.analysis.built.load_plan import LoadPlan
from sits_mech.analysis.built.production import Production
from sits_mech.quantities import UNITS
from sits_mech.report.records import named
from sits_mech.report.tables.built import force_errors, shown_unknown
from sits_mech.report.tables.solves import column_table


def production_record(
    found: Production, plan: LoadPlan, delivered: list[Delivered], limit: float
) -> dict[str, Any]:
    """Return what units told for a program, SI; errors of the next ones over each range."""
    count, forces = len(found.start.setup.parameters), found.next.forces
    known = zip(found.start.known[:count], found.next.known[:count], found.within.tolist(), strict=False)
    units = {}
    for name, one in found.units.items():
        after = force_errors(one)[1]
        units[name] = {
            "rows": len(one.measured.L), "p_value": one.p_value, "refused": "",
            "force_error": named(forces, after),
            "unknowns": named(one.names[:count], one.values[:count]),
        }
    return {
        "unknowns": {
            new.name: {"known": old.value, "known_deviation": old.deviation, "value": new.value,
                       "deviation": new.deviation, "within": within} for old, new, within in known
        },
        "units": units | {name: {"refused": why} for name, why in found.refused.items()},
        "limit": limit,
        "loads": [named(plan.forces, load) for load in plan.loads],
        "delivered": [
            {"after": one.after, "force_error": named(forces, one.error), "yield": one.good,
             "yield_of_lots": list(one.lots)} for one in delivered
        ],
    }


def production_tables(record: dict[str, Any], title: str) -> list[Any]:
    """Return what units told as tables."""
    shared = column_table(title, ["", "known before", "next unit", "between units"], justify="right")
    for name, one in record["unknowns"].items():
        shared.add_row(
            name, shown_unknown(name, one["known"], one["known_deviation"]),
            shown_unknown(name, one["value"], one["deviation"]), shown_unknown(name, None, one["within"]),
        )
    forces = list(record["delivered"][0]["force_error"])
    units = column_table("Units", ["", "rows", "p", *(f"error of {name} [{UNITS[name]}]" for name in forces)],
                         justify="right")
    for name, one in record["units"].items():
        if one["refused"]:
            units.add_row(name, one["refused"])
            continue
        units.add_row(name, str(one["rows"]), f"{one['p_value']:.2g}",
                      *(f"{one['force_error'][force]:.2g}" for force in forces))
    percent = 100.0 * record["limit"]
    columns = ["", *(f"error of {name} [%]" for name in forces), f"within {percent:.3g} % [%]", "in single lots [%]"]
    table = column_table("Next units", columns, justify="right")
    for one in record["delivered"]:
        table.add_row(one["after"], *(f"{100.0 * one['force_error'][force]:.2g}" for force in forces),
                      f"{100.0 * one['yield']:.0f}", " to ".join(f"{100.0 * end:.0f}" for end in one["yield_of_lots"]))
    loads = "; ".join(", ".join(f"{name} {np.round(value, 4):g} {UNITS[name]}" for name, value in load.items())
                      for load in record["loads"])
    words = f"Errors of {100.0 * MOST:.0f} % of loads, on {100.0 * MOST:.0f} % of units. Loads: {loads}."
    return [shared, units, table, words]
