"""Scenes that the choice and the plan of models are asked about, and coils that stand in for a magnetic model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.chain.models import MAGNETICS
from sits_mech.description import Description
from sits_mech.quantities import Impedance, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Sensor

LONG = ("elastomer.length=0.2", "target.length=0.2")
COAXIAL = (
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
    'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}',
)
BACKING = (
    'conductors=[{name="backing", material="ferrite", shape="disc", centre=["0 mm", "-1 mm"], diameter="18 mm", '
    'thickness="0.5 mm"}]',
)


@dataclass(frozen=True)
class Coils:
    """Answers by the height alone, with an error of its report, or fails."""

    sensor: Sensor
    tolerance: float
    fails: bool = False
    absolute: bool = False
    error: float = 0.0

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        report = SolveReport("any", 1, 1, 0.0, self.error, 0.0)
        if self.fails:
            raise SolveFailed("no", report)
        n = len(self.sensor.coils)
        L = (2e-6 - 1e-4 * (3e-3 - np.asarray(pose.d_v)))[..., None, None] * np.eye(n)
        return Impedance(frequency, L, 0.0 * L, 2e-6 * np.eye(n), np.ones(n), 0.0 * L, 0.0 * L, "H", report)


def coils_for_all(error: float) -> tuple[list[Coils], Mapping[str, Description]]:
    """Return a list of the coils that are made, and all models by name, each of which makes one."""
    made = list[Coils]()

    def make(sensor: Sensor, tolerance: float) -> Coils:
        made.append(Coils(sensor, tolerance, error=error))
        return made[-1]

    return made, {name: replace(each, factory=make) for name, each in MAGNETICS.items()}
