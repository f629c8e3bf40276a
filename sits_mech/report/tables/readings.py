"""Show readings: forces from inductances and the converter's settings, as tables and records."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from sits_mech.analysis.readings.bench import loads_over
from sits_mech.quantities import SURE, Array, shown_unit
from sits_mech.readout.budget import budget
from sits_mech.readout.calibration import OK, OUTSIDE, Calibration
from sits_mech.readout.converter import FrontEnd
from sits_mech.readout.front_end import register_text
from sits_mech.report.records import named
from sits_mech.report.tables.solves import key_table, with_error

Record = dict[str, Any]
_CAUSES = {
    "map": "the map between loads", "table": "the table's inductances", "silicone": "its sources, which differ",
    "noise": "noise of the reading", "temperature": "what the correction for temperature leaves",
}
_SIDE, _MOST = 21, 10_000  # loads along each force, and in all


def refusal(cal: Calibration, status: str, given: Sequence[tuple[str, str]], reading: Array) -> str:
    """Return in one line why a reading (n,) [unit of the calibration] has no answer; empty where it has one.

    `given` has each coil's option and what was written.
    """
    if status == OK:
        return ""
    options = " ".join(f'{option} "{text}"' for option, text in given)
    spans = [f"{n} {a:.4g} to {b:.4g}" for n, a, b in zip(cal.forces, cal.low, cal.high, strict=True)]
    if status == "ambiguous":
        why = "; ".join(cal.domain.regions) or "the edge of the table"
        return f"{options}: must belong to one load; ambiguous, more than one produces these readings ({why})"
    came = f"readings {'of a load outside' if status == OUTSIDE else 'that fit no load'}; {_nearest(cal, reading)}"
    return f"{options}: must belong to a load of the calibration ({', '.join(spans)}); got {came}"


def _nearest(cal: Calibration, reading: Array) -> str:
    """Return which load's inductances are nearest to a reading (n,), and how far they are, in words."""
    loads = loads_over(cal.low, cal.high, min(_SIDE, int(_MOST ** (1.0 / len(cal.forces)))))
    off = np.abs(cal.forward(loads) - reading) / cal.full_scale
    best = int(np.argmin(np.max(off, axis=1)))
    coil = int(np.argmax(off[best]))
    load = ", ".join(f"{n} = {value:.3g}" for n, value in zip(cal.forces, loads[best].tolist(), strict=True))
    share = 100.0 * float(off[best, coil])
    return f"the nearest, {load}, is off in coil {cal.coils[coil]} by {share:,.0f} % of its range"


def inversion_record(cal: Calibration, reading: Array, by_temperature: Array | None) -> Record:
    """Return forces with errors, status and domain of a reading (n,) [unit of the calibration].

    `by_temperature` (d,) is what temperature leaves in each force after a correction [N, N m].
    """
    found = cal.inverse(reading)
    left = budget(cal, found.forces, temperature=by_temperature)
    ends = zip(cal.forces, cal.low, cal.high, strict=True)
    each = {"forces": found.forces, "error": found.error}
    by_model, at = found.error_by_model, found.forces[None]
    if cal.table_errors is not None:  # with their signs
        by_model = cal.table_errors.at_most(cal.answers(at), at)[0]
    each |= {"error_by_model": by_model, "error_by_noise": found.error_by_noise}
    each |= {} if by_temperature is None else {"error_by_temperature": by_temperature}
    each |= {"force_error": left.total}
    shown = {"L" if cal.unit != "code" else "codes": reading} | ({"L0": cal.L0} if cal.unit != "code" else {})
    return {
        **{name: named(cal.forces, values) for name, values in each.items()},
        "budget": {cause: named(cal.forces, SURE * part) for cause, part in left.parts.items()},
        "status": str(found.status),
        "residual": float(found.residual),
        **{name: named(cal.coils, values) for name, values in shown.items()},
        "unit_L": cal.unit,
        "map_error": cal.error,
        "domain": {name: [float(a), float(b)] for name, a, b in ends},
        "no_inverse": list(cal.domain.regions),
    }


def inversion_table(record: Record, *, parts: bool = False) -> Table:
    """Return the forces of a reading within their errors, on request with the parts of these."""
    rows = [("readings", record["convention"])] if "convention" in record else []
    for name, force in record["forces"].items():
        unit, size = shown_unit(name), max(map(abs, record["domain"][name]))
        rows.append((name, f"{with_error(force, record['force_error'][name], size)} {unit} (90 %){_but(record, name)}"))
        if parts:
            rows += [("", f"{each[name]:.2g} {unit} by {_CAUSES[cause]}") for cause, each in record["budget"].items()]
    span = ", ".join(f"{name} {low:.4g} to {high:.4g}" for name, (low, high) in record["domain"].items())
    rows.append(("table", span))
    coils = record["codes" if record["unit_L"] == "code" else "L"]
    if len(coils) > len(record["forces"]):
        rows.append(("residual", f"{100.0 * record['residual']:.2g} % of the coils' range"))
    return key_table("forces", [*rows, *(("no inverse", region) for region in record["no_inverse"])])


def _but(record: Record, name: str) -> str:
    """Return in words what a force's error is without the silicone's part, where that is most of it."""
    whole, part = record["force_error"][name], record["budget"].get("silicone", {}).get(name, 0.0)
    if not part**2 > 0.5 * whole**2:
        return ""
    left = float(np.sqrt(max(whole**2 - part**2, 0.0)))
    return f"; {left:.2g} {shown_unit(name)} without the silicone's part, which sits-mech adapt finds"


def front_end_record(found: FrontEnd, coils: Sequence[str], left_out: Sequence[str]) -> Record:
    """Return a converter's settings and what they give, ready for JSON."""
    shown = ("frequency", "code", "R_p", "Q", "amplitude")
    each = {
        name: {item: getattr(found, item)[k].tolist() for item in shown}
        | {"window": found.window[k].tolist(), "offset": int(found.offset[k])}
        | {"settlecount": int(found.settlecount[k]), "drive": int(found.drive[k])}
        | {"drive_current": found.part.drive[found.drive[k]], "noise_L": float(found.noise[k])}
        | {"channel_time": float(found.channel_time[k])}
        for k, name in enumerate(coils)
    }
    return {
        "converter": found.part.name,
        "source": found.part.source,
        "reference": found.reference,
        "rcount": found.rcount,
        "input_divider": found.input_divider,
        "reference_divider": found.reference_divider,
        "gain": found.gain,
        "rate": found.rate,
        "coils": each,
        "registers": [{"address": a, "name": name, "value": value} for a, name, value in found.registers],
        "warnings": list(found.warnings),
        "left_out": list(left_out),
    }


def front_end_table(found: FrontEnd, coils: Sequence[str], left_out: Sequence[str]) -> Table:
    """Return a converter's settings and what they give, for a reader."""
    rows = [
        ("part", f"{found.part.name}, {found.part.bits} bits ({found.part.source}), RCOUNT {found.rcount}"),
        ("reference", f"{1e-6 * found.reference:.4g} MHz; {found.rate:.4g} readings of all coils a second"),
    ]
    for k, name in enumerate(coils):
        f, code, R_p = found.frequency[k], found.code[k], found.R_p[k]
        rows.append((name, f"{1e-6 * f[0]:.6g} to {1e-6 * f[1]:.6g} MHz, code {code[0]:.0f} to {code[1]:.0f}"))
        if found.gain > 1:
            low, high = 1e-6 * found.window[k]
            rows.append(("", f"window {low:.4g} to {high:.4g} MHz, gain {found.gain}, offset {found.offset[k]:.0f}"))
        current = 1e6 * found.part.drive[found.drive[k]]
        swing = f"{found.amplitude[k, 0]:.3g} to {found.amplitude[k, 1]:.3g} V at {current:.4g} uA"
        rows.append(("", f"R_p {1e-3 * R_p[0]:.4g} to {1e-3 * R_p[1]:.4g} kohm, Q {found.Q[k, 0]:.3g}, {swing}"))
        rows.append(("", f"{1e3 * found.channel_time[k]:.4g} ms; noise {1e15 * found.noise[k]:.3g} fH"))
    rows += [("registers" if k == 0 else "", line) for k, line in enumerate(register_text(found).splitlines())]
    rows += [("warning", line) for line in found.warnings]
    return key_table("converter", [*rows, *(("left out", line) for line in left_out)])
