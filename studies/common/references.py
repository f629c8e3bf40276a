"""Which poses of loaded pads are known, and how far is a model from them? The stored references and the measure.

reference_pads.json holds scenes (changes of the catalogue's biorob2018), loads, the target's motions and how sure they
are; benchmarks/reference_pads.py says how they are made. The error of a pose is the largest of its components over the
size of the displacement, an angle counted at the target's end.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sits_mech.quantities import POSE, Array, Equilibrium, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

STORED = Path(__file__).with_name("reference_pads.json")
FINER = 5.0
"""A reference judges what is as many times its own error."""
VAIN = 1.3
"""Times the processor time of the same answer that is no scatter."""


@dataclass(frozen=True)
class Reference:
    """A pad, its load and where the target goes.

    Attributes
    ----------
    name, model : str
        The model is "block", "planar" or "axisymmetric".
    changes : tuple of str
        What makes the scene from the catalogue's biorob2018.
    wrench : Wrench
    moved : ndarray, shape (6,)
        The target's motion from rest, in the order of a pose [m, rad].
    error : float
        Of the reference, over the size of the displacement [-].
    source : str
    """

    name: str
    model: str
    changes: tuple[str, ...]
    wrench: Wrench
    moved: Array
    error: float
    source: str

    @property
    def sensor(self) -> Sensor:
        """The scene."""
        return load_sensor("biorob2018", list(self.changes))

    def true_error(self, found: Equilibrium) -> float:
        """Return how far a pose is from the reference, over the size of the displacement."""
        sensor = self.sensor
        if sensor.target is None or sensor.elastomer is None:
            raise ValueError(f"{self.name}: must have a target on an elastomer")
        x, y = (0.5 * size for size in sensor.target.extent)
        lever = np.array([1.0, 1.0, x, 1.0, y, max(x, y)])
        moved = found.pose.components.copy()
        moved[1] -= sensor.elastomer.standoff + sensor.elastomer.thickness
        return float(np.max(np.abs(moved - self.moved) * lever) / np.max(np.abs(self.moved) * lever))


@dataclass(frozen=True)
class Judged:
    """One solve beside its reference.

    Attributes
    ----------
    reference : Reference
    tolerance : float
        Asked.
    true, estimated : float
        Errors over the size of the displacement; not a number where there is no answer.
    seconds : float
        Processor time, from the scene on.
    unknowns : int
    status : str
    """

    reference: Reference
    tolerance: float
    true: float
    estimated: float
    seconds: float
    unknowns: int
    status: str

    @property
    def ratio(self) -> float:
        """True over estimated error."""
        return self.true / self.estimated if self.estimated > 0.0 else np.inf

    @property
    def sees_tolerance(self) -> bool:
        """Whether the reference is sure enough to say that the tolerance is met."""
        return FINER * self.reference.error <= self.tolerance

    @property
    def sees_ratio(self) -> bool:
        """Whether the reference is sure enough to say how good the estimate is; no answer has none."""
        return bool(np.isfinite(self.true) and FINER * self.reference.error <= max(self.true, self.estimated))

    @property
    def too_small(self) -> bool:
        """Whether the true error is above three times the estimated one, whatever the reference's own error hides."""
        return bool(np.isfinite(self.true) and self.true - self.reference.error > 3.0 * self.estimated)


def stored_references(path: Path = STORED) -> list[Reference]:
    """Return the references of a file."""
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"]
    found = []
    for row in rows:
        moved = np.array([row["moved"].get(name, 0.0) for name in POSE])
        moved[1] = -row["moved"].get("sink", 0.0)
        load = Wrench(**row["wrench"])
        found.append(
            Reference(row["name"], row["model"], tuple(row["scene"]), load, moved, row["error"], row["source"])
        )
    return found


def counts(every: Sequence[Judged]) -> list[str]:
    """Return in words how often tolerances were met and estimates good."""
    lines = []
    for tolerance in sorted({one.tolerance for one in every}, reverse=True):
        own = [one for one in every if one.tolerance == tolerance]
        seen = [one for one in own if one.sees_tolerance]
        met = sum(bool(one.true - one.reference.error <= tolerance) for one in seen)
        lines.append(f"asked {tolerance:g}: met by {met} of {len(seen)} that the references can tell, {len(own)} asked")
    judged = [one for one in every if one.sees_ratio]
    good = sum(bool(0.3 <= one.ratio <= 1.0) for one in judged)
    over = sum(one.true - one.reference.error > one.estimated for one in every)
    lines.append(f"true over estimated error from 0.3 to 1: {good} of {len(judged)} that the references can tell")
    high = sum(one.too_small for one in every)
    lines.append(f"true error above the estimated one: {over}, three times: {high} of {len(every)}")
    return [*lines, *dearer(every)]


def dearer(every: Sequence[Judged]) -> list[str]:
    """Return in words what a load takes, and what the next finer tolerance takes and gains, pad by pad."""
    lines, tolerances = [], sorted({one.tolerance for one in every}, reverse=True)
    rows = [{one.reference.name: one for one in every if one.tolerance == tolerance} for tolerance in tolerances]
    for tolerance, row in zip(tolerances, rows, strict=True):
        seconds = [one.seconds for one in row.values()]
        lines.append(f"asked {tolerance:g}: {np.median(seconds):.2g} s in the median, {max(seconds):.2g} s at most")
    for tolerance, row, finer in zip(tolerances[1:], rows, rows[1:], strict=False):
        both = [(row[name], one) for name, one in finer.items() if name in row]
        above = sum(one.seconds > 4.0 * first.seconds for first, one in both)
        vain = sum(one.seconds > VAIN * first.seconds and one.estimated >= first.estimated for first, one in both)
        words = f"takes over four times the time of {above}, more without gain of {vain} of {len(both)}"
        lines.append(f"{tolerance:g} {words}")
    return lines
