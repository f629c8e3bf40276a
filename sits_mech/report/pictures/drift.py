"""Plot an inductance over temperature: the total as solved, and a line for each cause."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sits_mech.chain.simulate import Simulation
from sits_mech.quantities import Array
from sits_mech.report.pictures.curves import new_figure
from sits_mech.scene.thermal import CAUSES
from sits_mech.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
