"""Show a sensor over temperature: drift of its readout by cause, its readings at each temperature."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.analysis.drift import Drift
from sits_mech.chain.simulate import Simulation
from sits_mech.quantities import Array, as_jsonable, shown_unit
from sits_mech.report.pictures.style import new_figure
from sits_mech.report.records import simulation_record
from sits_mech.report.tables.solves import column_table, pose_names, short, shown_scale
from sits_mech.scene.thermal import CAUSES
from sits_mech.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Record = dict[str, Any]
_MOST_AT_ONCE = 8  # coils of a table


def drift_record(found: Drift, temperature: float) -> Record:
    """Return drift of zero and gain of each load component, total and by cause, SI; calibrated at `temperature`."""

    def of(values: Any) -> Record:
        by_cause = dict(zip(found.causes, as_jsonable(values), strict=True))
        return {"whole": as_jsonable(np.sum(values)), "by_cause": by_cause}

    names = enumerate(found.forces)
    each = {name: {"zero": of(found.zero[k]), "gain": of(found.gain[k])} for k, name in names}
    return {"temperature": temperature, **each}


def drift_table(record: Record) -> Table:
    """Return the tables of a `drift_record`."""
    forces = [name for name in record if name != "temperature"]
    here = record["temperature"] - ZERO_CELSIUS
    headings = ("cause", *(f"{name} [m{shown_unit(name)}/K], [%/K]" for name in forces))
    table = column_table(f"drift with temperature, at {here:.4g} degC: of zero, of gain", headings)
    causes = list(record[forces[0]]["zero"]["by_cause"])
    for cause in (*causes, "whole"):
        cells = []
        for name in forces:
            zero, gain = (
                part["whole"] if cause == "whole" else part["by_cause"][cause]
                for part in (record[name]["zero"], record[name]["gain"])
            )
            cells.append(f"{_number(zero, 1e3)}, {_number(gain, 100.0)}")
        table.add_row(cause, *cells, end_section=cause == causes[-1])
    return table


def _number(value: float | None, scale: float) -> str:
    """Return a number for a reader."""
    return "-" if value is None or not np.isfinite(value) else short(scale * value, 3)


def temperatures_record(temperatures: Sequence[float], found: Sequence[Simulation]) -> Record:
    """Return what a sensor shows under one load at each temperature [K], for a program, SI."""
    return {"temperature": list(temperatures), "temperatures": [*map(simulation_record, found)]}


def temperatures_table(coils: Sequence[str], temperatures: Sequence[float], found: Sequence[Simulation]) -> Table:
    """Return the same for a reader: pose, and each coil's inductance with its change from the first temperature."""
    unit, first = found[0].impedance.unit_L, np.diagonal(found[0].impedance.L)
    shown = unit.replace("H", "uH")
    places = {name: shown_scale(name) for name in pose_names([each.equilibrium for each in found])}
    headings = ["T [degC]", *(f"{name} [{unit}]" for name, (_, unit) in places.items())]
    headings += [f"{coil} [{shown}], change [ppm]" for coil in coils[:_MOST_AT_ONCE]]
    table = column_table("over temperature", [*headings, "status"])
    for T, each in zip(temperatures, found, strict=True):
        pose, L = each.equilibrium.pose, np.diagonal(each.impedance.L)
        own = [f"{k * getattr(pose, name):.{3 if unit == 'um' else 4}f}" for name, (k, unit) in places.items()]
        cells = [f"{1e6 * a:.6f}, {1e6 * (a / b - 1.0):.1f}" for a, b in zip(L, first, strict=True)]
        table.add_row(f"{T - ZERO_CELSIUS:.4g}", *own, *cells[:_MOST_AT_ONCE], "; ".join(each.flags))
    return table


_WORDS = {
    "conductivity": "metal's resistivity", "plates": "target's size", "pad": "pad's expansion",
    "modulus": "pad's modulus", "board": "board's expansion", "capacitor": "capacitor", "clock": "clock",
}


def drift_figure(
    coils: Sequence[str], temperatures: Sequence[float], found: Sequence[Simulation], slopes: tuple[float, Array]
) -> Figure:
    """Plot each coil's inductance under one load over temperature [K].

    `slopes` are the reference temperature [K] and the relative slopes (cause, coil) of the signal by `CAUSES` [1/K].
    """
    at, by_cause = slopes
    T = np.asarray(temperatures)
    L = np.array([np.diagonal(each.impedance.L) for each in found])
    middle = L[int(np.argmin(np.abs(T - at)))]
    with new_figure(height=0.75 * len(coils), rows=len(coils)) as (figure, every):
        for k, (name, axes) in enumerate(zip(coils, every, strict=True)):
            for number, cause in enumerate(CAUSES):
                if by_cause[number, k]:
                    line = 1e6 * by_cause[number, k] * (T - at)
                    axes.plot(T - ZERO_CELSIUS, line, f"C{number}-", label=_WORDS[cause])
            read = by_cause[-2:, k].sum() * (T - at)
            axes.plot(T - ZERO_CELSIUS, 1e6 * (L[:, k] / middle[k] - 1.0 + read), "ko", label="all, solved")
            axes.plot(T - ZERO_CELSIUS, 1e6 * by_cause[:, k].sum() * (T - at), "k-", label="sum of the lines")
            axes.set(ylabel=f"{name}: change [ppm]")
        every[0].legend(loc="upper left", fontsize="x-small")
        every[-1].set(xlabel="temperature [degC]")
        return figure
