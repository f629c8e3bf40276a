"""Show what readings say of a built sensor or of a production, and which loads to read, for programs and readers."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.table import Table

from sits_mech.analysis.bench.load_plan import SOFTER, LoadPlan
from sits_mech.analysis.bench.unknowns import PARAMETERS
from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.analysis.built.delivered import MOST, Delivered
from sits_mech.analysis.built.mistakes import STRANGE
from sits_mech.analysis.built.production import Production
from sits_mech.analysis.readings.bench import convention, loads_over
from sits_mech.quantities import SURE, UNITS, Array
from sits_mech.report.records import named
from sits_mech.report.tables.solves import column_table, key_table

_SCALES = {"": (1.0, ""), "m": (1e6, "um"), "rad": (180.0 / np.pi, "deg"), "H": (1e9, "nH"), "F": (1e12, "pF")}
_STRONG = 0.95  # of a correlation: what is as strong cannot be separated


def force_errors(found: Adaptation) -> tuple[Array, Array]:
    """Return within what 90 % of each force's readings lie over the table's middle range, before and after, (d,) [N].

    Before: the calibration as it is, tared at rest.
    """
    prior = found.prior
    s = found.values[found.names.index("modulus")] if "modulus" in found.names else 1.0
    before, after = found.force_deviations(loads_over(s * prior.table.map.low, s * prior.table.map.high, 5))
    return SURE * np.sqrt(np.mean(before**2, axis=0)), SURE * np.sqrt(np.mean(after**2, axis=0))


def adaptation_record(found: Adaptation, mistake: str = "") -> dict[str, Any]:
    """Return what readings say for a program, SI."""
    prior, before, after = found.prior, *force_errors(found)
    known, strong = {each.name: each for each in prior.setup.parameters}, found.correlation
    unknowns = {
        name: {"value": float(value), "deviation": float(deviation), "known": known[name].value,
               "known_deviation": known[name].deviation, "identified": name in found.identified}
        for name, value, deviation in zip(found.names, found.values, found.deviations, strict=True) if name in known
    }
    return {
        "convention": convention(prior.sensor, other_idle=found.other_idle),
        "unknowns": unknowns,
        "alike": [  # pairs that the readings do not tell apart, with their correlation
            [found.names[i], found.names[j], round(float(strong[i, j]), 3)]
            for i in range(len(prior.setup.parameters)) for j in range(i) if abs(strong[i, j]) > _STRONG
        ],
        "p_value": found.p_value,
        "p_structured": found.p_structured,
        "freedom": found.freedom,
        "chi_square": found.chi_square,
        "numbers": found.numbers,
        "mistake": mistake,
        "force_error_before": named(prior.forces, before),
        "force_error": named(prior.forces, after),
        "residual": named(prior.sensor.coil_names, found.residual.T),
        "rows": len(found.measured.L),
        "source": found.measured.source,
    }


def unknown_scale(name: str) -> tuple[float, str]:
    """Return factor and unit in which a reader is shown an unknown."""
    return _SCALES[PARAMETERS[name]] if name in PARAMETERS else (1.0, "(SI)")


def shown_unknown(name: str, value: float | None, deviation: float) -> str:
    """Return a value and two of its deviations, or these alone, in the unit of an unknown."""
    scale, unit = unknown_scale(name)
    width = f"\u00b1 {2.0 * scale * deviation:.2g} {unit}".rstrip()
    return width if value is None else f"{scale * value:.4g} {width}"


def adaptation_table(record: dict[str, Any], title: str) -> Table:
    """Return what readings say as a table."""
    rows = [("readings", record["convention"])]
    for name, one in record["unknowns"].items():
        text = shown_unknown(name, one["value"], one["deviation"])
        rows.append((name, text if one["identified"] else f"{text}: as known before"))
    alike = "; ".join(f"{a} and {b} ({c:+.2f})" for a, b, c in record["alike"])
    rows += [("not told apart", alike)] if alike else []
    rows.append(("such a sensor", verdict(record)))
    for name, after in record["force_error"].items():
        before = record["force_error_before"][name]
        rows.append((f"error of {name}", f"{after:.2g} {UNITS[name]} on 90 % of loads, {before:.2g} before, tared"))
    return key_table(title, [*rows, ("rows", f"{record['rows']} of {record['source']}")])


def verdict(record: dict[str, Any]) -> str:
    """Return in words whether readings are of such a sensor."""
    p, structured = record["p_value"], record["p_structured"]
    if p >= STRANGE and structured >= STRANGE:
        left = "" if record["freedom"] else "; as many unknowns as readings: nothing is left to test"
        return f"yes, p = {p:.2g}{left}"
    if structured < STRANGE:
        why = "no unknown explains what is left: hysteresis, drift, another law, or a sensor of another kind"
        return f"hardly, p = {min(p, structured):.1g}: {why}"
    return f"hardly, p = {p:.1g}: readings of another sensor, or an unknown beyond what was known of it"


def adapt_plan_record(plan: LoadPlan) -> dict[str, Any]:
    """Return a plan of loads for a program, SI; errors over each range."""
    return {
        "rig": plan.rig,
        "loads": [named(plan.forces, load) for load in plan.loads],
        "kinds": list(plan.kinds),
        "range": {name: [float(ends.min()), float(ends.max())] for name, ends in
                  zip(plan.forces, plan.read.T, strict=True)},
        "errors": {name: each.tolist() for name, each in zip(plan.forces, plan.errors.T, strict=True)},
        "error_twice": named(plan.forces, plan.more),
        "softest": plan.least,
        "grow": plan.grow,
        "too_much": list(plan.too_much),
    }


def adapt_plan_tables(plan: LoadPlan) -> list[Any]:
    """Return a plan of loads, with what each brings, and in words what all do."""
    names = plan.forces
    table = column_table(
        f"Loads: {plan.rig}", ["", *(f"{name} [{UNITS[name]}]" for name in names),
                                    *(f"error of {name} [%]" for name in names)], justify="right",
    )
    used, rows = plan.rig == "use", [[f"{100.0 * error:.2g}" for error in errors] for errors in plan.errors]
    table.add_row("", "drifted" if used else "tared", *[""] * (len(names) - 1), *rows[0])
    for number, (load, errors) in enumerate(zip(plan.loads, rows[1:], strict=True)):
        kind = f" {plan.kinds[number]}" if used else ""
        table.add_row(f"{number + 1}{kind}", *(f"{value:.3g}" for value in load), *errors)
    words = "; ".join(
        f"{name} from {100.0 * first:.2g} % to {100.0 * last:.2g} % of its range ({len(plan.loads)} more: "
        f"{100.0 * more:.2g} %)" for name, first, last, more in
        zip(names, plan.errors[0], plan.errors[-1], plan.more, strict=True)
    )
    held = f"By this table they can be read of a sensor up to {1.0 / plan.least:.3g} times softer than calibrated"
    softer = f"one {SOFTER:g} times softer " + (f"leaves it: {plan.grow}" if plan.grow else "stays inside")
    left = [f"Left out: {each}." for each in plan.too_much]
    return [table, f"These {len(plan.loads)} loads bring the error of {words}.", f"{held}; {softer}.", *left]


def production_record(found: Production, plan: LoadPlan, delivered: list[Delivered], limit: float) -> dict[str, Any]:
    """Return what units say for a program, SI; errors of the next ones over each range."""
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
    """Return what units say as tables."""
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
