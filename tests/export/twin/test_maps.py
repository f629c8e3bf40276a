"""Polynomials of the twin: a known function is found, and the error that is told is the true one."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.readings.bench import sensor_calibration
from sits_mech.chain.models import loaded_model
from sits_mech.export.source import Source
from sits_mech.export.twin.maps import guess_of, over_poses, over_wrenches, readings_at, total_degree
from sits_mech.maps.chebyshev import design_matrix
from sits_mech.quantities import Pose, Wrench
from sits_mech.report.folder import read_calibration


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


def test_terms_of_a_total_degree() -> None:
    """As many as (d + P)! / d! P!; the design is the products by Chebyshev's own definition."""
    assert [len(total_degree(d, p)) for d, p in ((1, 4), (2, 3), (3, 8), (6, 4))] == [5, 10, 165, 210]
    x = np.random.default_rng(1).uniform(-1.0, 1.0, (7, 2))
    powers = total_degree(2, 3)
    by_angle = np.prod(np.cos(powers[None] * np.arccos(x)[:, None]), axis=-1)
    assert design_matrix(x, powers) == pytest.approx(by_angle, abs=1e-12) and not powers[0].any()


def test_poses_are_solved(source: Source) -> None:
    """Inductances of poses are those of the magnetic model, coil by coil; the map holds its stated error elsewhere."""
    found, note = over_poses(source, None)
    assert found is not None and "over d_h, d_v, alpha" in note
    random = np.random.default_rng(7).uniform(found.low, found.high, (40, 3))
    pose = Pose.of(np.pad(random, ((0, 0), (0, 3))))
    solved = readings_at(source, pose, None)
    model, _ = loaded_model(source.sensor, "planar", 1e-2, [Wrench(F_z=1.0)])
    raw = model.impedance(pose, source.sensor.frequency)
    relative = np.diagonal(raw.L, axis1=1, axis2=2) / np.diagonal(raw.L0)
    assert solved / solved[:1] == pytest.approx(relative / relative[:1], rel=1e-12)
    x = (2.0 * random - found.low - found.high) / (found.high - found.low)
    off = np.abs(design_matrix(x, found.powers) @ found.coefficients.T + found.base - solved).max(axis=0)
    assert np.all(off < 2.0 * found.error) and np.all(found.error <= 1e-6 * np.ptp(solved, axis=0))


def test_both_outputs_share_their_terms(source: Source) -> None:
    """The terms of inductances and codes together, each its own coefficients; codes count from a whole number."""
    cal = sensor_calibration(source.sensor, source.data)
    found = over_wrenches(source, cal, cal.code_calibration)
    terms = {tuple(row) for row in found.powers}
    assert len(found.coefficients) == 4 and {tuple(row) for row in cal.map.powers} <= terms
    assert np.array_equal(found.base[2:], np.rint(found.base[2:])) and np.all(found.coefficients[:2, 0] == 0.0)
    assert found.fixed.tolist() == [0.0] * 6 and found.columns.tolist() == [0, 1]


def test_a_guess_is_near(source: Source) -> None:
    """Of readings over the whole box, within a twentieth of half the range."""
    cal = sensor_calibration(source.sensor, source.data)
    base, scale = cal.forward(F_x=0.0, F_z=1.0), cal.full_scale
    guess, towards = guess_of(cal, base, scale)
    x = np.random.default_rng(3).uniform(-1.0, 1.0, (500, 2))
    off = (cal.map.at(cal.map.unscaled(x)) - base) / scale
    y = off @ towards[:, :-1].T + towards[:, -1]
    assert np.abs(design_matrix(y, guess.powers) @ guess.coefficients.T + guess.base - x).max() < 0.05
