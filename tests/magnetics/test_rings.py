"""The axisymmetric model against finite elements, the infinite plate, limits and invariants; what it refuses."""

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change
from scipy.constants import mu_0

from sits_mech.geometry.collision import Collision
from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import ring_mutual
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Conductor, Sensor, Target

MM = 1e-3
COPPER = 5.8e7


def coil(name: str = "C", x: float = 0.0, y: float = 0.0) -> Coil:
    return Coil(
        name=name, centre=(x, y), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def sensor(radius: float, thickness: float = 0.2 * MM, conductivity: float = COPPER, **more: object) -> Sensor:
    target = Target(conductivity=conductivity, shape="disc", diameter=2 * radius, thickness=thickness)
    return Sensor(**({"name": "disc", "frequency": 5e6, "coils": (coil(),), "target": target} | more))


DISCS = [  # NGSolve 6.2, p = 6, axisymmetric: radius [mm], frequency, delta L, R at a gap of 2 mm
    (3.5, 5e3, -1.0940587457181086e-08, 0.0012601196119705871),
    (3.5, 5e6, -1.722086964359416e-07, 0.11527379963961844),
    (7.5, 5e3, -4.659030431522552e-08, 0.0026181746454115745),
    (7.5, 5e6, -2.1858741804936318e-07, 0.09520169200761902),
]


def check_row(row, tolerance, bounds):
    radius, frequency, delta_L, R = row
    found = axisymmetric(sensor(radius * MM), tolerance).impedance(Pose(0.0, 2 * MM), frequency)
    change, error = found.L[0, 0] - found.L0[0, 0], (abs(found.error_L[0, 0]), abs(found.error_R[0, 0]))
    assert found.L0[0, 0] == pytest.approx(2.507569757e-06, rel=1e-6)  # same source
    assert change == pytest.approx(delta_L, rel=bounds[0])
    assert found.R[0, 0] == pytest.approx(R, rel=bounds[1])
    assert error[0] <= tolerance * abs(change) and error[1] <= 10 * tolerance * found.R[0, 0]
    return abs(change - delta_L) - error[0], abs(found.R[0, 0] - R) - error[1]


@pytest.mark.parametrize("row", [DISCS[0], *(pytest.param(row, marks=pytest.mark.slow) for row in DISCS[1:])])
def test_disc_equals_finite_elements(row):
    excess = check_row(row, 1e-3, (1e-3, 1e-2))
    assert excess[0] <= 1e-5 * abs(row[2]) and excess[1] <= 1e-3 * row[3]


@pytest.mark.slow
@pytest.mark.parametrize("row", DISCS)
def test_disc_equals_finite_elements_closely(row):
    check_row(row, 1e-4, (1e-4, 1e-3))


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [5e3, 5e6])
def test_large_disc_tends_to_the_infinite_plate(frequency):
    plate = coil_change(coil_sections(coil()), 2 * MM, frequency, [Layer(COPPER, 0.2 * MM)])
    off = []
    for radius in (8 * MM, 16 * MM):
        found = axisymmetric(sensor(radius), 5e-3).impedance(Pose(0.0, 2 * MM), frequency)
        off.append(abs((found.L - found.L0)[0, 0] / plate.delta_L - 1))
    assert off[1] < off[0]
    assert off[1] < 3e-3
    assert found.R[0, 0] == pytest.approx(float(plate.R), rel=1e-2)


THICK = [(4.0, 1e4, 2e-2), (50.0, 1e4, 2e-3), (50.0, 5e6, 2e-2)]


@pytest.mark.slow
@pytest.mark.parametrize("radius, frequency, bounds", THICK)
def test_thick_disc_close_to_the_coil_tends_to_the_infinite_plate(radius, frequency, bounds):
    """5 mm of copper at 0.05 mm; delta = 0.66 mm and 29 um, the interior is a few cells; 4 mm still misses a margin."""
    thick, gap = 5 * MM, 0.05 * MM
    found = axisymmetric(sensor(radius * MM, thick), 1e-2).impedance(Pose(0.0, gap), frequency)
    plate = coil_change(coil_sections(coil()), gap, frequency, [Layer(COPPER, thick)])
    assert (found.L - found.L0)[0, 0] == pytest.approx(float(plate.delta_L), rel=min(bounds, 5e-3))
    assert found.R[0, 0] == pytest.approx(float(plate.R), rel=2 * bounds)
    assert found.report.unknowns < 3000


def test_poses_are_vectorised_and_fall_with_the_gap(caplog):
    model = axisymmetric(sensor(5 * MM), 1e-2)
    caplog.set_level("INFO", "sits_mech")
    gaps = np.array([[0.5, 1.0, 2.0], [4.0, 10.0, 50.0]]) * MM
    found = model.impedance(Pose(0.0, gaps), 1e6)
    assert found.L.shape == found.R.shape == (2, 3, 1, 1) and "a disc of" in caplog.text
    change = (found.L - found.L0)[..., 0, 0].ravel()
    assert np.all(change < 0) and np.all(np.diff(np.abs(change)) < 0) and np.all(found.R > 0)
    single = axisymmetric(sensor(5 * MM), 1e-2).impedance(Pose(0.0, 4 * MM), 1e6)
    assert (single.L - single.L0)[0, 0] == pytest.approx(change[3], rel=1e-2)


def test_resistive_limit_and_monotone_in_frequency():
    model = axisymmetric(sensor(5 * MM, 0.05 * MM, 1e3), 1e-3)
    low, high = (model.impedance(Pose(0.0, 1 * MM), f).R[0, 0] for f in (1.0, 10.0))
    assert high / low == pytest.approx(100.0, rel=1e-6)
    copper = axisymmetric(sensor(5 * MM), 1e-2)
    runs = [copper.impedance(Pose(0.0, 1 * MM), f) for f in (1e2, 1e4, 1e6)]
    change = [run.L[0, 0] - run.L0[0, 0] for run in runs]
    assert 0 > change[0] > change[1] > change[2] > -runs[0].L0[0, 0]
    assert runs[0].R[0, 0] < runs[1].R[0, 0] < runs[2].R[0, 0]


def test_perfect_disc_far_larger_than_the_gap_is_the_image():
    # skin depth 16 um: it moves the mirror by half of that
    rings, frequency, sigma = coil_sections(coil()), 1e5, 1e10
    depth = 1 / np.sqrt(np.pi * frequency * mu_0 * sigma)
    found = axisymmetric(sensor(7 * MM, 0.2 * MM, sigma), 1e-2).impedance(Pose(0.0, 0.5 * MM), frequency)
    image = Sections(rings.radius, 2 * (0.5 * MM + depth / 2) - rings.z, rings.width, rings.height)
    assert (found.L - found.L0)[0, 0] == pytest.approx(-ring_mutual(rings, image).sum(), rel=5e-3)


def test_no_target_is_free_space_only():
    found = axisymmetric(sensor(5 * MM, target=None)).impedance(Pose(0.0, np.array([1.0, 2.0]) * MM), 5e6)
    np.testing.assert_array_equal(found.L, np.broadcast_to(found.L0, (2, 1, 1)))
    assert found.report.left_out == () and not found.R.any()


def test_scenes_of_other_models_are_refused_by_name():
    rectangle = Target(conductivity=COPPER, shape="rectangle", width=8 * MM, length=8 * MM, thickness=0.2 * MM)
    with pytest.raises(ValueError, match="target.shape must be disc for axisymmetric; got rectangle$"):
        axisymmetric(sensor(5 * MM, target=rectangle))
    with pytest.raises(ValueError, match="coils must be one over coaxial discs for axisymmetric; got 2$"):
        axisymmetric(sensor(5 * MM, coils=(coil("C1", -4 * MM), coil("C2", 4 * MM))))
    plate = Conductor(
        name="P", conductivity=COPPER, shape="rectangle", centre=(0.0, 0.0, -3 * MM), width=8 * MM, length=8 * MM,
        thickness=0.2 * MM,
    )
    with pytest.raises(ValueError, match="conductors must be left out for axisymmetric; got 1$"):
        axisymmetric(sensor(5 * MM, conductors=(plate,)))
    steel = Target(conductivity=1e7, relative_permeability=100.0, shape="disc", diameter=8 * MM, thickness=0.2 * MM)
    with pytest.raises(ValueError, match="target.relative_permeability must be 1 for axisymmetric; got 100$"):
        axisymmetric(sensor(5 * MM, target=steel))
    with pytest.raises(ValueError, match="tolerance"):
        axisymmetric(sensor(5 * MM), 0.0)


def test_poses_off_the_axis_are_refused():
    model = axisymmetric(sensor(5 * MM))
    off, tilted = Pose(1 * MM, 2 * MM), Pose(0.0, 2 * MM, 0.1)
    for pose, said in ((off, "it is 1 mm off$"), (tilted, "must be 0 on a coil's axis")):
        with pytest.raises(ValueError, match=said):
            model.impedance(pose, 5e6)
    with pytest.raises(Collision):
        model.impedance(Pose(0.0, -1 * MM), 5e6)
    with pytest.raises(ValueError, match="frequency"):
        model.impedance(Pose(0.0, 2 * MM), 0.0)


@pytest.mark.parametrize("gap", [pytest.param(0.05, marks=pytest.mark.slow), 50.0])
def test_smallest_and_largest_gap_tend_to_the_infinite_plate(gap):
    """Far below its radius a disc is a plate (Dodd-Deeds); far above, its modes still answer."""
    found = axisymmetric(sensor(3.5 * MM), 1e-2).impedance(Pose(0.0, gap * MM), 5e6)
    change, plate = (found.L - found.L0)[0, 0], coil_change(coil_sections(coil()), gap * MM, 5e6, [Layer(COPPER, 2e-4)])
    assert found.report.estimated_error <= 1e-2
    assert (abs(change / float(plate.delta_L) - 1) < 1e-2) == (gap < 1.0)
    assert 0.0 > change > 1.001 * float(plate.delta_L) and found.R[0, 0] > 0.0
