"""What does the published study print, and in which settings can its figures be asked for?

Source of every number: D. Jones, J. Kow, A. Alazmani, P. Culmer, Computational Design Tools for Soft Inductive Tactile
Sensors, BioRob 2018 (doi:10.1109/BIOROB.2018.8487666), section IV; inductances in percent of the free-space L0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.chain.models import magnetic_model
from sits_mech.quantities import Array, Pose
from sits_mech.scene.sensor import Sensor, load_sensor

MM, DEGREE = 1e-3, np.pi / 180.0
Spots = dict[tuple[int, int], tuple[float, float]]
MEASURED: Spots = {(1, 0): (90.1, 92.0), (2, 0): (97.8, 97.2), (5, 0): (99.7, 99.8), (2, 20): (99.5, 92.8)}
"""d_v [mm], alpha [deg]: C1, C2 [% of L0]; those at 2 mm stand with the rotation, the others with the vertical one."""
SIMULATED: Spots = {(1, 0): (93.8, 93.8), (2, 0): (97.7, 97.7), (5, 0): (98.9, 98.9), (2, 20): (99.3, 96.2)}
FREE_MEASURED = (3.21e-6, 3.19e-6)  # [H]
FREE_SIMULATED = 0.43e-3  # of a coil: 0.43 uH is printed, without the depth; it must be 1 mm [H/m]
READS = 0.5  # 20 degrees at 2 mm, as shear [mm]
RANGES = {8: (29.6, 24.2), 15: (31.4, 71.0), 22: (12.8, 69.1)}  # width [mm]: shear, normal range [%]
BEST_WIDTH = 15.0  # [mm]


@dataclass(frozen=True)
class Setting:
    """How the figures are asked for.

    Attributes
    ----------
    name, short : str
        For tables, for titles.
    model : str
        "planar" or "sheets".
    both : bool
        Whether both coils carry the same current in the same sense: each then links what both drive.
    net_current : str
        Of the plate's section: "zero", or "free" to return where A = 0, at 100 mm.
    frequency : float
        [Hz].
    """

    name: str
    short: str
    model: str = "planar"
    both: bool = False
    net_current: str = "zero"
    frequency: float = 5e6

    def sensor(self, width: float = 8.0) -> Sensor:
        """Return the published sensor with a target of another width [mm]; the layer is as wide as it must be."""
        changes = [f'target.width="{width} mm"', "elastomer.width=0.03"]
        if self.net_current == "free":
            changes += ['target.net_current="free"', 'target.planar_boundary_radius="100 mm"']
        return load_sensor("biorob2018", changes)

    def percent(self, pose: Pose, tolerance: float, width: float = 8.0) -> Array:
        """Return the coils' inductances in percent of L0 at poses of shape (p,), shape (p, 2)."""
        found = magnetic_model(self.sensor(width), self.model, tolerance)[0].impedance(pose, self.frequency)
        if self.both:
            return np.asarray(100.0 * found.L.sum(axis=-1) / found.L0.sum(axis=-1))
        return np.asarray(100.0 * np.diagonal(found.L, axis1=-2, axis2=-1) / np.diagonal(found.L0))

    def free_inductance(self) -> float:
        """Return what a coil shows without target [H/m, H]."""
        model = magnetic_model(self.sensor(), self.model, 1e-2)[0]
        L0 = model.impedance(Pose(0.0, 2.0 * MM), self.frequency).L0
        return float(L0[0].sum() if self.both else L0[0, 0])


STATED = Setting("stated: one coil driven, no net current, 5 kHz", "stated", frequency=5e3)
FITTING = Setting("fitting: both coils, net current free, 5 MHz", "fitting", both=True, net_current="free")
ALONE = Setting("planar: one coil, no net current, 5 MHz", "one coil, 5 MHz")
SPATIAL = Setting("sheets (3D), 5 MHz", "sheets", model="sheets")


def poses(d_h: Array | float = 0.0, d_v: Array | float = 2.0, alpha: Array | float = 0.0) -> Pose:
    """Return poses [mm, deg] as one."""
    parts = np.broadcast_arrays(*(np.atleast_1d(np.asarray(part, float)) for part in (d_h, d_v, alpha)))
    return Pose(parts[0] * MM, parts[1] * MM, parts[2] * DEGREE)


def spots() -> Pose:
    """Return the poses of the printed points."""
    places = np.array([*SIMULATED], dtype=float)
    return poses(0.0, places[:, 0], places[:, 1])


def distances(found: Array, printed: Spots) -> tuple[float, float]:
    """Return the largest and the root mean square distance of inductances (p, 2) from printed ones [points]."""
    off = found - np.array([*printed.values()])
    return float(np.abs(off).max()), float(np.sqrt(np.mean(off**2)))
