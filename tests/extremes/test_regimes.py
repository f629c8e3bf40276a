"""From hertz to 100 MHz, foil to block, touching to far: finite, reciprocal, lossy, bounded, monotone - or refused.

Without permeable parts, at any pose: L and R symmetric, R >= 0, -L0 <= Delta L <= 0, |Delta L| and R growing with
frequency; R ~ f^2 while the currents are weak, R ~ f^1/2 and Delta L constant when the skin is thin.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Impedance, MagneticModel, Pose, SolveFailed
from sits_mech.scene.sensor import Coil, Sensor, Target

MM = 1e-3
FREQUENCIES = (1.0, 1e4, 1e6, 1e8)


def rows(widest: float) -> list[tuple[float, float, float, float]]:
    """Width, thickness, gap [mm], conductivity [S/m]: the ends of all four, and values between them."""
    ends = product((0.5, widest), (0.005, 5), (0.05, 50), (1e3, 1e9))
    return [*ends, (0.5, 0.2, 0.05, 1e9), (8, 0.2, 2, 1e3), (8, 0.005, 2, 5.8e7), (100, 0.2, 50, 5.8e7),
            (0.5, 0.005, 50, 5.8e7), (8, 0.2, 0.5, 1e9)]


def coil(name: str = "C", x: float = 0.0) -> Coil:
    return Coil(
        name=name, centre=(x * MM, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def plate_scene(width: float, thickness: float, sigma: float, mu: float = 1.0) -> Sensor:
    """Two coils below a plate, the plate's length as its width."""
    target = Target(
        conductivity=sigma, relative_permeability=mu, shape="rectangle", width=width * MM, length=width * MM,
        thickness=thickness * MM,
    )
    return Sensor(name="plate", frequency=1e6, coils=(coil("C1", -4), coil("C2", 4)), target=target)


def disc_scene(width: float, thickness: float, sigma: float) -> Sensor:
    """One coil below a disc."""
    target = Target(conductivity=sigma, shape="disc", diameter=width * MM, thickness=thickness * MM)
    return Sensor(name="disc", frequency=1e6, coils=(coil(),), target=target)


def check_passive(z: Impedance) -> None:
    """Finite, reciprocal, lossy, with a reaction between nothing and all of L0."""
    for matrix in (z.L, z.R):
        assert np.all(np.isfinite(matrix))
        assert np.abs(matrix - np.swapaxes(matrix, -1, -2)).max() <= 1e-10 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(z.R).min() >= -1e-10 * np.abs(z.R).max()
    change, rounding = np.diagonal(z.L - z.L0, axis1=-2, axis2=-1), 1e-14 * z.L0.max()
    assert np.all(change <= rounding) and np.all(change >= -np.diag(z.L0))


def sweep(model: MagneticModel, pose: Pose) -> None:
    """All frequencies: invariants at each, growth from one to the next up to the asked error, or a refusal by name."""
    before: Impedance | None = None
    for frequency in FREQUENCIES:
        try:
            z = model.impedance(pose, frequency)
        except SolveFailed as refused:
            assert refused.report.status in ("too many bars", "too many rings", "not resolved")
            assert "ask for a larger tolerance, or for" in str(refused)
            continue
        check_passive(z)
        if before is not None:
            change, earlier = (np.diagonal(found.L - found.L0) for found in (z, before))
            assert np.all(change <= earlier + 2e-2 * np.abs(change) + 1e-14 * z.L0.max())
            assert np.all(np.diagonal(z.R) >= 0.9 * np.diagonal(before.R))
        before = z


@pytest.mark.slow
@pytest.mark.parametrize("width, thickness, gap, sigma", rows(100))
def test_planar(width: float, thickness: float, gap: float, sigma: float) -> None:
    sweep(planar_bars(plate_scene(width, thickness, sigma), 1e-2), Pose(0.3 * MM, gap * MM))


@pytest.mark.slow
@pytest.mark.parametrize("width, thickness, gap, sigma", rows(10))
def test_axisymmetric(width: float, thickness: float, gap: float, sigma: float) -> None:
    sweep(axisymmetric(disc_scene(width, thickness, sigma), 1e-2), Pose(0.0, gap * MM))


def weak(make: Callable[[Sensor, float], MagneticModel], sensor: Sensor) -> None:
    """A resistive target: R and Delta L go with frequency squared."""
    low, high = (make(sensor, 1e-2).impedance(Pose(0.0, 2 * MM), f) for f in (1e4, 1e5))
    assert high.R[0, 0] == pytest.approx(100 * low.R[0, 0], rel=1e-3)
    assert (high.L - high.L0)[0, 0] == pytest.approx(100 * (low.L - low.L0)[0, 0], rel=1e-2)


def strong(make: Callable[[Sensor, float], MagneticModel], sensor: Sensor) -> None:
    """A skin of 5 and 1.6 um under a gap of 2 mm: R goes with the root of frequency, Delta L stands still."""
    low, high = (make(sensor, 1e-2).impedance(Pose(0.0, 2 * MM), f) for f in (1e7, 1e8))
    assert high.R[0, 0] == pytest.approx(10**0.5 * low.R[0, 0], rel=5e-2)
    assert (high.L - high.L0)[0, 0] == pytest.approx((low.L - low.L0)[0, 0], rel=1e-2)


def test_planar_limits() -> None:
    weak(planar_bars, plate_scene(8, 0.2, 1e3))
    strong(planar_bars, plate_scene(8, 0.2, 1e9))


def test_axisymmetric_limits() -> None:
    weak(axisymmetric, disc_scene(8, 0.2, 1e3))
    strong(axisymmetric, disc_scene(8, 0.2, 1e9))


def test_sheets_limits() -> None:
    weak(sheets, plate_scene(8, 0.2, 1e3))


def test_too_wide_for_its_gap_is_refused_before_it_is_solved() -> None:
    with pytest.raises(SolveFailed, match=r"planar: a plate of 100 mm.*larger tolerance, or for 'planar-fem'"):
        planar_bars(plate_scene(100, 0.2, 5.8e7), 1e-3).impedance(Pose(0.0, 0.05 * MM), 1e6)


@pytest.mark.parametrize(
    "mu, frequency",
    [(1e4, 1.0), (1e4, 1e6)]
    + [pytest.param(mu, f, marks=pytest.mark.slow) for mu, f in ((1.0, 1e4), (1.0, 1e8), (1e2, 1e8), (1e4, 1e8))],
)
def test_permeable_plates(mu: float, frequency: float) -> None:
    """A permeable plate draws flux (Delta L > 0) until its eddy currents keep it out."""
    z = planar_fem(plate_scene(8, 0.2, 1e7, mu), 1e-2).impedance(Pose(0.0, 2 * MM), frequency)
    assert np.all(np.isfinite(z.L)) and np.abs(z.L - z.L.T).max() <= 1e-10 * z.L.max()
    assert np.abs(z.R - z.R.T).max() <= 1e-10 * z.R.max() and np.linalg.eigvalsh(z.R).min() >= 0.0
    assert np.linalg.eigvalsh(z.L).min() > 0.0
    if mu == 1.0:
        check_passive(z)
    if frequency == 1.0:
        assert (z.L - z.L0)[0, 0] > 0.0
    if frequency == 1e8 and mu < 1e4:  # at 1e4 the depth times mu is 1.6 mm, near the gap: flux is still drawn
        assert (z.L - z.L0)[0, 0] < 0.0
