"""A silicone with rate and softening, and the records of tests of it."""

import numpy as np
import pytest

from sits_mech.analysis.material.tensile import Record
from sits_mech.analysis.material.uniaxial import uniaxial_stress
from sits_mech.silicone.material import silicone_from

YEOH = {"law": "yeoh", "c10": 1.5e4, "c20": -300.0, "c30": 40.0, "bulk_modulus": 3e7}
PRONY = [{"weight": 0.08, "time": 0.4}, {"weight": 0.06, "time": 5.0}, {"weight": 0.1, "time": 60.0}]


@pytest.fixture
def rubber():
    return lambda **keys: silicone_from(YEOH | keys)


@pytest.fixture
def prony():
    return PRONY


@pytest.fixture
def measured():
    """Return the record of a strain over time, with white noise of a deviation [Pa]."""

    def record(silicone, time, strain, noise=0.0, factor=1.0):
        stress = factor * uniaxial_stress(silicone, time, strain)
        stress = stress + noise * np.random.default_rng(1).standard_normal(len(time))
        return Record(time, strain, stress, "made.csv")

    return record


@pytest.fixture
def cycles():
    """Return time and strain that rises to each peak and falls to nothing, at a rate of strain [1/s]."""

    def path(peaks, rate=0.1, count=60):
        ends = np.array([0.0, *(e for peak in peaks for e in (peak, 0.0))])
        turns = np.r_[0.0, np.cumsum(np.abs(np.diff(ends)))] / rate
        time = np.linspace(0.0, turns[-1], 2 * count * len(peaks) + 1)
        return time, np.interp(time, turns, ends)

    return path
