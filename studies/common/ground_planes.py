"""Ground planes by chance below a coil, each as a drawn outline and as a rectangle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from sits_mech.scene.sensor import Coil, Sensor

SIZES = 5e-3, 14e-3  # [m]
GAPS, FREQUENCIES, THICKNESSES = (1.5e-4, 3e-3), (1e5, 1e7), (1.8e-5, 2e-4)  # below the windings [m], [Hz], [m]
OFF, LOWEST = 2e-3, 4e-4  # the planes' middles from the axis, at most; the lowest windings' depth [m]


class GroundPlane(NamedTuple):
    """A coil over a plane of copper, in two forms of one scene."""

    name: str
    gap: float  # [m]
    frequency: float  # [Hz]
    drawn: Sensor
    rectangle: Sensor


def ground_planes(coils: tuple[Coil, ...], count: int) -> Iterator[GroundPlane]:
    """Yield so many, the same in every run."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        width, length = rng.uniform(SIZES[0], SIZES[1], 2).tolist()
        gap = float(np.exp(rng.uniform(*np.log(GAPS))))
        x, y = rng.uniform(-OFF, OFF, 2).tolist()
        frequency, thickness = (float(np.exp(rng.uniform(*np.log(ends)))) for ends in (FREQUENCIES, THICKNESSES))
        corners = tuple((a * width / 2, b * length / 2) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
        forms = {"shape": "outline", "points": corners}, {"shape": "rectangle", "width": width, "length": length}
        shared = {"name": "GND", "material": "copper", "centre": (x, y, -gap - LOWEST), "thickness": thickness}
        drawn, rectangle = (
            Sensor.model_validate({"name": "s", "frequency": 1e6, "coils": coils, "conductors": [shared | form]})
            for form in forms
        )
        name = f"{1e3 * width:.3g} x {1e3 * length:.3g} x {1e3 * thickness:.2g} mm, drawn"
        yield GroundPlane(name, gap, frequency, drawn, rectangle)
