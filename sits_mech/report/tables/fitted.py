"""Show the fit of a silicone's tests: a table each of law, rate and softening, and lines for a scene file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sits_mech.report.pictures.fit import fit_rows
from sits_mech.report.tables.solves import key_table
from sits_mech.scene.files import literal
from sits_mech.silicone.histories.fitted import Fitted
from sits_mech.silicone.histories.relaxing import Relaxation
from sits_mech.silicone.histories.softening import CyclicFit

if TYPE_CHECKING:
    from rich.table import Table


def fitted_tables(found: Fitted) -> list[Table | str]:
    """Return the tables of the fit of a silicone's tests."""
    tables: list[Table | str] = []
    if found.fit is not None and found.test is not None:
        tables.append(key_table(found.test.source, fit_rows(found.fit)))
    if found.relaxation is not None:
        tables.append(key_table("rate", relaxation_rows(found.relaxation)))
    if found.cyclic is not None:
        tables.append(key_table("softening", cyclic_rows(found.cyclic)))
    if found.relaxation is None and found.cyclic is None:
        return tables
    return [*tables, pasted(found)]


def pasted(found: Fitted) -> str:
    """Return what is known of a material as lines of a scene file."""
    lines = ["[elastomer.material]"]
    for key, value in found.table.items():
        entries = [literal(item) for item in value] if key == "prony" else []
        text = "\n".join(["[", *(f"    {entry}," for entry in entries), "]"]) if entries else literal(value)
        lines.append(f"{key} = {text}")
    return "\n".join([*lines, "# bulk_modulus: no test here shows it; catalogued silicones have 1000 shear moduli"])


def relaxation_rows(found: Relaxation) -> list[tuple[str, str]]:
    """Return a relaxation as rows of a table: name and text, each constant with its 95 % half-width."""
    rows = [
        (f"branch {k + 1}", f"weight {_with(weight, around)}, time {_with(time, about)} s")
        for k, ((weight, time), (around, about)) in enumerate(zip(found.prony, found.confidence, strict=True))
    ]
    if found.factor is not None:
        rows.append(("slow load", f"{found.factor:.4g} times the stress of the law"))
    rows += [
        ("identified", "yes" if found.slow_identified else "no"),
        ("times seen", f"{found.range[0]:.3g} s to {found.range[1]:.3g} s, at {100.0 * found.strain:.4g} % strain"),
        ("residual (rms)", f"{found.rms:.4g} Pa"),
        ("source", found.source),
    ]
    return rows + [("note", note) for note in found.notes]


def cyclic_rows(found: CyclicFit) -> list[tuple[str, str]]:
    """Return a softening as rows of a table: name and text, each constant with its 95 % half-width."""
    rows = []
    for name, value in ({} if found.mullins is None else vars(found.mullins)).items():
        rows.append((name, f"{_with(value, found.confidence[name])}{' Pa' if name == 'm' else ''}"))
    rows += [
        ("specimen", f"{found.factor:.4g} times the stress of the law"),
        ("peaks", f"{found.peaks}, up to {100.0 * found.max_strain:.4g} % strain"),
        ("residual (rms)", f"{found.rms:.4g} Pa"),
        ("source", found.source),
    ]
    return rows + [("note", note) for note in found.notes]


def _with(value: float, width: float | None) -> str:
    """Return a constant with its half-width where it has one."""
    return f"{value:.4g}" if width is None else f"{value:.4g} \u00b1 {width:.2g}"
