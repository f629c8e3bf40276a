"""How is a twin of a calibrated sensor computed: what it shows under loads, and what an adapted sensor reads of that?

A twin has another law of the same modulus, computed by a finer tolerance, and is set up otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.bench.force_maps import ForceMaps, force_maps_of
from sits_mech.analysis.bench.setup import Setup
from sits_mech.analysis.bench.unknowns import PriorParameter
from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import loaded_model
from sits_mech.quantities import Array
from sits_mech.readout.loads import points, wrench_of
from sits_mech.scene.materials import silicones
from sits_mech.scene.sensor import Sensor
from sits_mech.scene.thermal import stiffer

LAWS = ("ecoflex-00-30-neo-hookean", "dragon-skin-10", "ecoflex-00-10")
SOFTEST, STIFFEST = 0.72, 1.3
CELL = 0.01  # deviation of a load cell's scale
NARROWEST = -1.5e-4  # gap [m]: a target turned as well would touch the coils
_PLACES = ("gap", "d_h", "d_y", "alpha", "alpha_x", "lead", "capacitance")
_LARGER = 1.5  # loads of a twin over the table's, as softer sensors need them


@dataclass(frozen=True)
class Truth:
    """A sensor of another law, computed by a finer tolerance."""

    setup: Setup
    table: ForceMaps

    def readings(self, modulus: float, places: Mapping[str, float], forces: Array) -> Array:
        """Return L (m, n) [H] under true forces (m, d), set up at places [SI], zero by default."""
        return self.shown(self.poses(forces / modulus), places)

    def poses(self, forces: Array) -> Array:
        """Return the poses (m, 6) under forces (m, d), nothing changed."""
        return self.table.at(forces[None])[1][0]

    def shown(self, poses: Array, places: Mapping[str, float]) -> Array:
        """Return L (m, n) [H] at poses (m, 6), set up at places."""
        row = np.array([[places.get(name, 0.0) for name in self.setup.names]])
        return np.asarray(self.setup.readings(poses[None], row)[0])


def made(
    sensor: Sensor, law: str, ranges: Mapping[str, float], count: int, tolerance: float, mechanics: str = "auto"
) -> Truth:
    """Return the truth of a law."""
    scene, data = finer(sensor, law, ranges, count, tolerance, mechanics)
    rows = [wrench_of(row) for row in points(data)]
    setup = Setup(
        scene, tuple(map(PriorParameter, _PLACES)), lambda one: loaded_model(one, "sheets", tolerance, rows)[0]
    )
    return Truth(setup, force_maps_of(scene, data, tuple(ranges)))


def finer(
    sensor: Sensor, law: str, ranges: Mapping[str, float], count: int, tolerance: float, mechanics: str = "auto"
) -> tuple[Sensor, xr.Dataset]:
    """Return the sensor of another law, of the same modulus, and its table over larger loads."""
    layer = sensor.elastomer
    assert layer is not None
    other = silicones()[law]
    other = stiffer(other, layer.silicone.shear_modulus / other.shear_modulus)
    scene = sensor.model_copy(update={"elastomer": layer.model_copy(update={"material": other})})
    larger = loads({name: _LARGER * end for name, end in ranges.items()}, count)
    return scene, calibrate(scene, **larger, tolerance=tolerance, mechanics=mechanics)


def loads(ranges: Mapping[str, float], count: int) -> dict[str, Any]:
    """Return values of each force, shear to both sides."""
    return {name: np.linspace(0.0 if name == "F_z" else -end, end, count).tolist() for name, end in ranges.items()}


def inverted(found: Adaptation, L: Array, start: Array) -> Array:
    """Return the forces (m, d) that the adapted sensor reads, by slopes at loads near them."""
    prior, forces = found.prior, start
    at = prior.used(found.values)
    slopes, _ = prior.force_slopes(found.values, start)
    for _ in range(3):
        forces = forces + np.einsum("mdn,mn->md", slopes, L - prior.bench(forces).model(at[None])[0])
    return forces
