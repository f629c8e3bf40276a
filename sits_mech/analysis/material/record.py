"""Read a test over time, by content, from a file: time, strain and engineering stress in their order.

Columns are those of `tensile`, with a time. Uniaxial, tension or compression (negative). What else the file holds is
passed over.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sits_mech.analysis.material.tensile import Sizes, read_pulls
from sits_mech.quantities import Array

_LEAST = 8  # rows


@dataclass(frozen=True)
class Record:
    """A uniaxial test over time."""

    time: Array  # (n,), not descending [s]; row number if the file has none
    strain: Array  # engineering, (n,)
    stress: Array  # engineering, (n,) [Pa]
    source: str  # file
    timed: bool = True  # the file has a time


def read_record(path: str | Path, given: Sizes | None = None, *, timed: bool = True) -> Record:
    """Read a test over time by content; `timed`: a column of time is required.

    Raise ValueError if the file cannot be read, columns are missing or of unknown unit, fewer than 8 rows are numbers,
    a stretch is not positive, or time stands still or runs back.
    """
    pulls = read_pulls(path, given or Sizes(), "a readable test over time", timed)
    if len(pulls) > 1:
        raise ValueError(f"{path}: must hold one specimen; got {len(pulls)}")
    mode, strain, stress, time, *_ = pulls[0]
    sign = {"uniaxial": 1.0, "compression": -1.0}.get(mode)
    if sign is None:
        raise ValueError(f"{path}: must be a uniaxial test, a pull or compression; got {mode}")
    if len(strain) < _LEAST:
        raise ValueError(f"{path}: must hold at least {_LEAST} rows of numbers; got {len(strain)}")
    timed, time = time is not None, np.arange(float(len(strain))) if time is None else time
    if not np.all(np.diff(time) > 0.0):
        back = int(np.argmin(np.diff(time) > 0.0))
        raise ValueError(f"{path}: time must rise; got {time[back]:g} s and then {time[back + 1]:g} s")
    if not np.all(sign * strain > -1.0):
        raise ValueError(f"{path}: strain must be above -1; got {strain.min():g}")
    slack = (given or Sizes()).slack or 0.0
    return Record(time, sign * (strain - slack), sign * stress, str(path), timed)
