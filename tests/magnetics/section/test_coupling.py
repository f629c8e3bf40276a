"""Several plates in the planar integral model: against the finite elements, against one plate, reciprocity."""

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision
from sits_mech.geometry.plates import distance, section_plates
from sits_mech.magnetics.bars import LADDER, _answering, planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.section.coils import bars_of_coils
from sits_mech.magnetics.section.coupling import coupled_reaction, filaments, samples
from sits_mech.memory import SECONDS
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Conductor, SceneError, load_sensor

MM = 1e-3
POSE = Pose(1 * MM, 2 * MM, 0.05)


def plate(x, z, width, thickness, material="aluminium"):
    return Conductor(
        name="other", material=material, shape="rectangle", centre=(x * MM, 0.0, z * MM), width=width * MM,
        length=18 * MM, thickness=thickness * MM,
    )


def scene(*parts, **changes):
    return load_sensor("biorob2018").model_copy(update={"conductors": parts, "elastomer": None, **changes})


def test_filaments_without_number_are_refused(monkeypatch):
    """Of bars 0.1 um from the plate, as many as the distance asks."""
    source = filaments(bars_of_coils(load_sensor("biorob2018")), 1e-7, 1e-4, None)
    monkeypatch.setenv(SECONDS.variable, "1e-6")
    with pytest.raises(SceneError, match="^planar: the field of .* at 3 points must take at most 1e-06 s"):
        samples(source, POSE, 35e-6, np.array([0.0, 1j, 1.0]) * MM)


SIDE, GROUND = plate(12.0, 1.0, 6.0, 0.5), plate(0.0, -1.5, 8.0, 0.2, "copper")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "frequency"),
    [(SIDE, 5e3), *(pytest.param(part, 5e6, marks=pytest.mark.slow) for part in (SIDE, GROUND))],
)
def test_agrees_with_finite_elements(part, frequency):
    sensor = scene(part)
    one, two = planar_bars(sensor, 1e-3).impedance(POSE, frequency), planar_fem(sensor, 1e-3).impedance(POSE, frequency)
    np.testing.assert_allclose(one.L - one.L0, two.L - two.L0, rtol=0, atol=2e-3 * np.abs(two.L - two.L0).max())
    np.testing.assert_allclose(one.R, two.R, rtol=0, atol=1e-2 * np.abs(two.R).max())


def test_far_neighbour_changes_nothing():
    alone = planar_bars(scene(), 1e-2).impedance(POSE, 5e6)
    beside = planar_bars(scene(plate(300.0, 0.0, 5.0, 0.2)), 1e-2).impedance(POSE, 5e6)
    np.testing.assert_allclose(beside.L - beside.L0, alone.L - alone.L0, rtol=5e-3)


def test_fixed_plate_without_target_is_a_target_in_its_place():
    flat = Pose(0.0, 2 * MM, 0.0)
    as_target = planar_bars(scene(), 1e-3).impedance(flat, 5e6)
    fixed = scene(plate(0.0, 2.1, 8.0, 0.2, "copper"), target=None)
    as_part = planar_bars(fixed, 1e-3).impedance(flat, 5e6)
    np.testing.assert_allclose(as_part.L, as_target.L, rtol=1e-6)


def test_reciprocal_before_it_is_made_so():
    sensor, frequency = scene(SIDE), 5e6
    resolution = LADDER[1][1]
    gap = 0.5e-3
    plates = _answering(section_plates(sensor, POSE), resolution, [gap, gap], 1e7)
    source = filaments(bars_of_coils(sensor), gap, np.exp(-resolution.terms), None)
    Z = coupled_reaction(plates, source, 2 * np.pi * frequency)
    assert abs(Z[0, 1] - Z[1, 0]) < 1e-4 * np.abs(Z).max()


def test_plate_in_the_target_is_refused():
    for part in (plate(0.0, 2.1, 8.0, 0.2), plate(3.0, 2.0, 2.0, 0.5)):
        with pytest.raises(Collision, match="must stay clear of conductors.other"):
            planar_bars(scene(part), 1e-2).impedance(POSE, 5e6)


def test_distance_of_polygons():
    square = np.array([0, 1, 1 + 1j, 1j])
    assert distance(square, square + 3) == pytest.approx(2.0)
    assert distance(square, square + 2 + 2j) == pytest.approx(np.sqrt(2.0))
    assert distance(square, 0.2 * square + 0.4 + 0.4j) == 0.0
