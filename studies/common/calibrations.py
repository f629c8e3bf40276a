"""Which calibrations are known, and how far is one from them? Sensors, loads, and the stored references.

reference_calibrations.json holds the signals of the catalogue's sensors over a grid of loads and how sure they are;
benchmarks/reference_calibrations.py says how they are made.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from sits_mech.chain.calibrate import calibrate
from sits_mech.scene.sensor import load_sensor
from sits_mech.status import ANSWERED

STORED = Path(__file__).with_name("reference_calibrations.json")
FX, FZ = (-0.5, 0.0, 0.5), (0.0, 1.0, 2.0)  # N
SIGNALS = ("L_v", "L_h")


@dataclass(frozen=True)
class Case:
    """A sensor of the catalogue, the models of both halves, the rungs of its reference, the finest that is timed."""

    name: str
    scene: str
    mechanics: str
    magnetics: str
    rungs: tuple[float, ...]
    finest: float


RIGID = 'target.backing_thickness="8 mm"', 'target.backing_modulus="200 GPa"'
"""The reference's targets do not bend: these have steel glued on them."""
CALIBRATIONS = (Case("biorob2018-w15", "biorob2018-w15", "block", "sheets", (1e-2, 3e-3, 1e-3), 3e-3),)


def table(case: Case, tolerance: float) -> xr.Dataset:
    """Return the calibration of a case; stop where a load is not carried."""
    chosen = {"mechanics": case.mechanics, "magnetics": case.magnetics}
    data = calibrate(load_sensor(case.scene, RIGID), F_x=FX, F_z=FZ, tolerance=tolerance, **chosen)
    if not bool(data.status.isin(ANSWERED).all()):
        raise SystemExit(f"{case.name}, tolerance {tolerance:g}: does not carry every load")
    return data


def reference(case: Case, signal: str, path: Path = STORED) -> tuple[np.ndarray, float]:
    """Return the stored signal [percent] over the loads and its error over full scale."""
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"]
    row = next(row for row in rows if row["name"] == case.name)
    return np.array(row[signal]["percent"]), float(row[signal]["error"])


def errors(data: xr.Dataset, signal: str, known: np.ndarray) -> tuple[float, float]:
    """Return the largest true and the largest estimated error of a signal over the loads, of full scale."""
    full = float(np.ptp(known))
    true = np.abs(data[f"{signal}_percent"].to_numpy() - known) / full
    return float(np.max(true)), float(data[f"error_{signal}_percent"].max()) / full
