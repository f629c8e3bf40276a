"""The planar integral model where the gap is small against the plate's thickness: finite elements, the exact strip.

A corner of such a plate lies as near to its middle as the coils do, and the field along the plate is as rough as single
tracks make it: gaps from a quarter of the thickness on, thick blocks, an edge that almost touches.
"""

from __future__ import annotations

import numpy as np
import pytest
from common.strip import strip_reaction

from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.section.coils import bars_of_coils, free_space_inductance
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
# width, thickness, gap of the lowest edge [mm], angle [rad], frequency [Hz]
FAST = [pytest.param((8, 0.2, 0.2, 0.0, 5e6), marks=pytest.mark.slow), (8, 5, 0.5, 0.0, 5e3)]
SLOW = [(w, 0.2, gap, 0.0, f) for w in (8, 20) for gap in (0.05, 0.5) for f in (5e3, 5e6)]
SLOW += [(100, 5, 2, 0.0, 5e3), (100, 5, 2, 0.0, 5e6), (8, 5, 0.5, 0.0, 5e6), (8, 0.2, 0.05, 0.02, 5e6)]
SLOW += [(8, 0.2, 0.05, -0.2, 5e3), (8, 5, 0.05, 0.0, 5e6)]


def scene(width: float, thickness: float, *changes: str) -> Sensor:
    """The catalogue's coils under a copper plate [mm]."""
    size = [f'target.width="{width} mm"', f'target.thickness="{thickness} mm"', f'elastomer.width="{width + 10} mm"']
    return load_sensor("biorob2018", [*size, *changes])


def lowest(width: float, gap: float, alpha: float) -> Pose:
    """A pose whose lowest corner is `gap` above the coils [mm, rad]."""
    return Pose(0.3 * MM, (gap + width / 2 * abs(np.sin(alpha))) * MM, alpha)


def compare(row: tuple[float, float, float, float, float], asked: float, reference: float) -> None:
    """Delta L to 1e-3 and R to 1e-2 of the finite elements', and an estimated error that says so."""
    width, thickness, gap, alpha, frequency = row
    sensor, pose = scene(width, thickness), lowest(width, gap, alpha)
    z = planar_bars(sensor, asked).impedance(pose, frequency)
    fem = planar_fem(sensor, reference).impedance(pose, frequency)
    dL, exact = z.L - z.L0, fem.L - fem.L0
    error = np.abs(dL - exact).max()
    assert error < 1e-3 * np.abs(exact).max()
    assert error < 2 * z.error_L.max() + fem.error_L.max()
    assert np.abs(z.R - fem.R).max() < 1e-2 * np.abs(fem.R).max()


@pytest.mark.parametrize("row", FAST)
def test_close_and_thick_plates_agree_with_finite_elements(row: tuple[float, float, float, float, float]) -> None:
    compare(row, 1e-3, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("row", SLOW)
def test_close_and_thick_plates_agree_with_fine_finite_elements(row: tuple[float, float, float, float, float]) -> None:
    narrow_gap = row[2] < 0.2 and row[0] > 8
    compare(row, 1e-2 if narrow_gap else 1e-3, 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("alpha", [0.0, 0.02])
def test_perfect_strip_almost_touching_is_the_exact_one(alpha: float) -> None:
    """A strip of 0.2 um with a skin depth of 0.2 um, its edge 0.05 mm above the tracks: closed form to 1e-3."""
    sensor = scene(8, 0.0002, "target.conductivity=1.3e12")
    pose = lowest(8, 0.05, alpha)
    found = planar_bars(sensor, 1e-3).impedance(pose, 5e6)
    coils = []
    for bars in bars_of_coils(sensor):
        (gx, wx), (gz, wz) = np.polynomial.legendre.leggauss(8), np.polynomial.legendre.leggauss(4)
        z = 1j * (bars.z[:, None, None] + bars.thickness / 2 * gz)
        p = bars.x[:, None, None] + bars.width / 2 * gx[:, None] + z
        coils.append((p.ravel(), (bars.sign[:, None, None] * wx[:, None] * wz / 4).ravel()))
    exact = np.array([[i @ strip_reaction(p, q, pose, 8 * MM) @ j for q, j in coils] for p, i in coils])
    np.testing.assert_allclose(found.L - found.L0, exact, rtol=0, atol=1e-3 * np.abs(exact).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    "thickness, gap",
    [(5, 50), (0.005, 50), (0.005, 0.05), (5, 0.05)],
)
def test_passive_from_hertz_to_a_hundred_megahertz(thickness: float, gap: float) -> None:
    """Two coils' reaction lies between nothing and the free-space inductance, with losses, monotone in frequency."""
    model, before = planar_bars(scene(8, thickness), 1e-2), 0.0
    free = free_space_inductance(scene(8, thickness))
    for frequency in (1.0, 1e4, 1e6, 1e8):
        z = model.impedance(lowest(8, gap, 0.01), frequency)
        eigenvalues = np.linalg.eigvalsh(z.L - z.L0)
        assert np.all(eigenvalues <= 1e-13 * free[0, 0]) and np.linalg.eigvalsh(z.L).min() > 0.0
        assert np.linalg.eigvalsh(z.R).min() >= -1e-6 * np.abs(z.R).max()
        assert z.L[0, 0] - free[0, 0] <= before * (1 - 1e-2)
        before = z.L[0, 0] - free[0, 0]
        assert z.report.estimated_error < 2e-2
