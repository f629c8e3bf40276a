"""One pose has one answer whatever else is asked, and curves have no steps: the ladders of preparations."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.magnetics.answer import clearance_of, clearances, lowest_served, served, together, tops
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.rings import Axisymmetric, axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Impedance, MagneticModel, Pose
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
BESIDE = 'conductors=[{name="nut", material="brass", shape="rectangle", centre=["12 mm", "3 mm"], width="3 mm", ' \
    'length="4 mm", thickness="2 mm"}]'


def steps(Z: Impedance) -> tuple[float, float]:
    """Largest step of L and R along a curve of poses, over their largest: what no cubic through five points has."""
    found = []
    for values in (Z.L - Z.L0, Z.R):
        fourth = np.diff(values, 4, axis=0)
        found.append(float(np.abs(fourth).max() / np.abs(values).max()))
    return found[0], found[1]


def test_shares_add_up_and_each_gap_is_carried() -> None:
    gap = np.geomspace(1e-5, 1.0, 2001)
    (near, share), (nearer, rest) = clearances(gap, 1.8 * MM)
    np.testing.assert_allclose(share + rest, 1.0, rtol=0, atol=1e-15)
    assert np.all(nearer == near - 1)
    assert all(clearance_of(int(k), 1.8 * MM) <= g * (1 + 1e-12) for k, g in zip(near, gap, strict=True))
    assert np.mean(share == 1.0) > 0.7  # most gaps need one preparation
    assert np.abs(np.diff(share * (near % 2) + rest * (nearer % 2))).max() < 0.08  # and none takes over at once


def test_an_anchor_is_served_alone() -> None:
    ((step, share), (_, rest)) = clearances(np.array([0.3 * MM]), 0.3 * MM)
    assert (step[0], share[0], rest[0]) == (0, 1.0, 0.0)


@pytest.mark.parametrize("frequency, count", [(5e6, 1), (2.5e7, 1), (2.4e7, 2), (1e4, 1), (2.5e7 * 1.0001, 1)])
def test_frequencies_are_below_their_tops(frequency: float, count: int) -> None:
    found = tops(frequency)
    assert len(found) == count and sum(share for _, share in found) == pytest.approx(1.0, abs=1e-15)
    assert all(top >= frequency for top, _ in found)


def test_steps_serve_what_they_have_a_share_of() -> None:
    gap = np.geomspace(1e-4, 1e-2, 4001)
    for step, share in clearances(gap, 1.8 * MM):
        for k in np.unique(step).tolist():
            low, high = served(clearance_of(k, 1.8 * MM))
            some = gap[(step == k) & (share > 0.0)]
            assert low <= some.min() * (1 + 1e-12) and some.max() <= high * (1 + 1e-12)
    for frequency in np.geomspace(1e3, 1e8, 400).tolist():
        assert all(lowest_served(top) <= frequency <= top * (1 + 1e-12) for top, _ in tops(frequency))


def test_several_plates_together() -> None:
    gaps = [(np.array([2.0, 3.1, 3.2]) * MM, 1.8 * MM), (np.array([0.5, 0.5, 0.45]) * MM, 0.5 * MM)]
    total = np.zeros(3)
    for _, some, share in together([clearances(*own) for own in gaps]):
        total[some] += share
    np.testing.assert_allclose(total, 1.0, rtol=0, atol=1e-15)


@pytest.fixture(
    scope="module",
    params=["planar", *(pytest.param(name, marks=pytest.mark.slow) for name in ("sheets", "beside"))],
)
def model(request: pytest.FixtureRequest) -> MagneticModel:
    if request.param == "planar":
        return planar_bars(load_sensor("biorob2018"), 1e-2)
    return sheets(load_sensor("biorob2018", [BESIDE] if request.param == "beside" else []), 1e-2)


def test_a_pose_alone_and_among_others(model: MagneticModel) -> None:
    alone = model.impedance(Pose(0.0, 3 * MM), 5e6)
    among = model.impedance(Pose(np.array([0.0, 1 * MM]), np.array([3 * MM, 1 * MM]), np.array([0.0, 0.01])), 5e6)
    np.testing.assert_allclose(among.L[0] - among.L0, alone.L - alone.L0, rtol=1e-9)
    np.testing.assert_allclose(among.R[0], alone.R, rtol=1e-9, atol=1e-9 * alone.R.max())
    np.testing.assert_allclose(among.error_L[0], alone.error_L, rtol=1e-6)


@pytest.mark.slow
def test_no_steps_over_gap_and_tilt() -> None:
    for model in (sheets(load_sensor("biorob2018"), 1e-2), planar_bars(load_sensor("biorob2018"), 1e-2)):
        gap = np.linspace(1.4, 2.4, 1601) * MM
        assert max(steps(model.impedance(Pose(0 * gap, gap), 5e6))) < 1e-7
        tilt = np.linspace(-0.05, 0.05, 401)
        assert max(steps(model.impedance(Pose(0 * tilt, 3.3 * MM + 0 * tilt, tilt), 5e6))) < 1e-7


def check_frequencies(model: MagneticModel) -> None:
    """No steps from 1.6 to 3 MHz."""
    found = [model.impedance(Pose(0.0, 3 * MM), f) for f in np.geomspace(1.6e6, 3e6, 251)]
    for values, least in (([z.L for z in found], 1e-6), ([z.R / np.sqrt(z.frequency) for z in found], 1e-5)):
        change = np.array(values) - (found[0].L0 if least == 1e-6 else 0.0)
        assert np.abs(np.diff(change, 4, axis=0)).max() < least * np.abs(change).max()


@pytest.mark.slow
def test_no_steps_over_frequency() -> None:
    check_frequencies(sheets(load_sensor("biorob2018"), 1e-2))


def rings(tolerance: float) -> Axisymmetric:
    """One of the published coils under a coaxial disc."""
    changes = ['coils.C2.centre=["30 mm", "0 mm"]', 'target={material="copper", shape="disc", diameter="7 mm", '
               'thickness="0.2 mm"}']
    sensor = load_sensor("biorob2018", changes)
    coil = sensor.coils[0].model_copy(update={"centre": (0.0, 0.0)})
    return axisymmetric(sensor.model_copy(update={"coils": (coil,)}), tolerance)


@pytest.mark.slow
def test_rings_of_a_pose_alone_and_among_others() -> None:
    model = rings(1e-3)
    alone = model.impedance(Pose(0.0, 3 * MM), 5e6)
    among = rings(1e-3).impedance(Pose(0.0, np.array([3.0, 1.0, 20.0]) * MM), 5e6)
    np.testing.assert_allclose(among.L[0] - among.L0, alone.L - alone.L0, rtol=1e-9)
    np.testing.assert_allclose(among.R[0], alone.R, rtol=1e-9)
    np.testing.assert_allclose(among.error_L[0], alone.error_L, rtol=1e-9)


def test_no_steps_of_rings_over_gap_and_frequency() -> None:
    """Across the places where one preparation takes over: 1.51 and 1.8 mm, 1.77 and 2.5 MHz."""
    model, gap = rings(1e-2), np.linspace(1.4, 3.2, 1601) * MM
    assert max(steps(model.impedance(Pose(0.0 * gap, gap), 5e6))) < 1e-6
    check_frequencies(model)
