"""Designs as scenes: values at coordinates, round numbers, every coil at once."""

import pytest

from sits_mech.scene.sensor import SceneError, load_sensor
from sits_mech.synthesis.required.space import Design, Variable, size_of, space_of

SENSOR = load_sensor("biorob2018")
SPACE = space_of(SENSOR, {
    "elastomer.thickness": (1.0, 6.0, "mm"), "coils.*.turns": [8, 10], "target.width": (0.006, 0.01, ""),
})


def test_a_design_is_a_scene() -> None:
    """Bounds in their own unit, or SI; lists by their place; all coils together."""
    found = SPACE.sensor(Design((1,), (0.5, 0.25)))
    assert found.elastomer is not None and found.target is not None
    assert found.elastomer.thickness == pytest.approx(3.5e-3) and found.target.width == pytest.approx(7e-3)
    assert [coil.turns for coil in found.coils] == [10, 10]
    assert SPACE.words(Design((1,), (0.5, 0.25))) == "turns 10, thickness 3.5 mm, width 0.007"
    assert SPACE.width(SPACE.variables[0], SENSOR) == pytest.approx(5e-3)


@pytest.mark.parametrize(("x", "near"), [(0.1613, (1.8, 1.9)), (0.5, (3.5,)), (1.0, (6.0,)), (0.0, (1.0,))])
def test_round_numbers_are_those_of_a_workshop(x: float, near: tuple[float, ...]) -> None:
    """A fiftieth of the bounds' distance apart: 0.1 mm of 5 mm."""
    variable = Variable("elastomer.thickness", 1.0, 6.0, "mm")
    found = [variable.value(each) for each in variable.round_neighbours(x)]
    assert found[0] == pytest.approx(min(near, key=lambda each: abs(each - variable.value(x))))
    assert all(abs(each / 0.1 - round(each / 0.1)) < 1e-6 for each in found)


def test_sizes_hold_all_parts() -> None:
    """Coils below, layer, target: their boxes together."""
    sensor = SENSOR
    found, coil = size_of(sensor), sensor.coils[0]
    assert found["height"] == pytest.approx(2.2e-3 + coil.height)
    assert found["footprint.x"] == pytest.approx(max(20e-3, 8e-3 + coil.extent[0]))


def test_a_cover_is_as_high_as_it_stands_over_the_target() -> None:
    covered = load_sensor("biorob2018", ['cover={material="ecoflex-00-30", thickness="1.5 mm", overhang="1 mm"}'])
    assert size_of(covered)["height"] == pytest.approx(size_of(SENSOR)["height"] + 1.5e-3)


def test_the_least_sizes_are_those_of_the_smallest_scene() -> None:
    """Thinnest layer and fewest turns; too many corners are not looked at."""
    smallest = SPACE.sensor(Design((0,), (0.0, 0.0)))
    assert SPACE.least_sizes() == pytest.approx(size_of(smallest))
    many = space_of(SENSOR, {"coils.*.turns": list(range(2, 8)), "frequency": list(range(1_000_000, 1_000_050))})
    assert many.least_sizes() == {}


def test_what_leaves_no_scene_by_itself_is_named() -> None:
    """Not a list beside it, all of whose values are as impossible with it."""
    with pytest.raises(SceneError, match="vary.elastomer.thicknes: .*must leave a possible scene"):
        space_of(SENSOR, {"coils.*.turns": [8, 10], "elastomer.thicknes": (1.0, 2.0, "mm")})
    with pytest.raises(SceneError, match="vary.coils.*turns: 99 must leave a possible scene"):
        space_of(SENSOR, {"elastomer.thickness": (1.0, 2.0, "mm"), "coils.*.turns": [8, 99]})
