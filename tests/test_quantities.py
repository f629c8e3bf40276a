"""What passes between the rooms: names and order of components, what leaves the plane, what JSON can hold."""

import itertools
import json
import math
import re

import numpy as np
import pytest

from sits_mech.quantities import (
    POSE,
    UNITS,
    WRENCH,
    Bounded,
    Pose,
    Wrench,
    as_jsonable,
    refuse_infinite,
    refuse_out_of_plane,
    shown_unit,
)
from sits_mech.units import SceneError

MAP = np.array([[1.0, 2.0], [3.0, 0.0]])


def test_components_come_back_in_their_order() -> None:
    """A pose of its components is itself, one or many; three components are those of the plane."""
    one = Pose(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert Pose.of(one.components) == one and Pose.of(one.components[:3]) == Pose(1.0, 2.0, 3.0)
    many = Pose(np.array([1.0, 7.0]), 2.0)
    assert many.components.shape == (2, 6) and np.array_equal(Pose.of(many.components).components, many.components)
    assert one.centre.tolist() == [1.0, 4.0, 2.0] and one.rotation.tolist() == [5.0, 3.0, 6.0]
    assert Wrench(*range(6)).components.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_work_has_one_unit() -> None:
    """Component by component a wrench works on a pose: newtons on metres, newton metres on radians."""
    assert {(UNITS[force], UNITS[motion]) for force, motion in zip(WRENCH, POSE, strict=True)} == {
        ("N", "m"), ("N*m", "rad"),
    }
    assert shown_unit("M_z") == "N m"


def test_what_leaves_the_plane_is_named() -> None:
    """Zeros are in the plane, the others are told, of one pose or of any of many."""
    assert Wrench(1.0, 2.0, 3.0).out_of_plane == () and Wrench(F_y=1e-9, M_z=-1.0).out_of_plane == ("F_y", "M_z")
    assert Pose(0.0, 1e-3, d_y=np.array([0.0, 1e-6])).out_of_plane == ("d_y",)


def test_arrays_become_json() -> None:
    """Arrays, tuples and numpy's numbers, at any depth."""
    given = {"a": np.eye(2), "b": (np.float64(0.5), [np.int64(3), "c"]), "d": None}
    expected = {"a": [[1.0, 0.0], [0.0, 1.0]], "b": [0.5, [3, "c"]], "d": None}
    assert json.loads(json.dumps(as_jsonable(given))) == expected


def test_components_are_the_askers_own() -> None:
    pose = Pose(1e-3, np.array([2e-3, 3e-3]))
    pose.components[0, 0] = 1.0
    assert pose.components[0, 0] == 1e-3


def test_parts_of_one_factor_may_cancel_in_a_map_and_the_rest_may_not():
    value, error = np.zeros(2), np.array([2.0, 1.0])

    def mapped(*shared):
        return Bounded.of(value, error, np.array(shared).reshape(-1, 2)).mapped(MAP[:1]).error[0]

    assert Bounded.of(value, error).mapped(MAP).error.tolist() == [4.0, 6.0]
    assert mapped([2.0, -1.0]) == 0.0 and mapped([2.0, 1.0]) == 4.0
    assert mapped([1.0, 0.0], [1.0, -1.0]) == 2.0  # each its own factor
    assert mapped([1.0, -0.5]) == 2.0  # half of both is left


def test_errors_hold_all_that_the_factors_allow_and_no_more():
    """Of maps and differences, at every corner of the box of factors: the largest deviation is the error."""
    draw = np.random.default_rng(3).normal
    one, other = (Bounded(draw(size=2), shared, np.abs(draw(size=2))) for shared in draw(size=(2, 2, 2)))
    found = one.mapped(MAP) - other.mapped(MAP)
    worst = np.zeros(2)
    for t in itertools.product((-1.0, 1.0), repeat=6):
        here = t[0] * (one.shared[0] - other.shared[0]) + t[1] * (one.shared[1] - other.shared[1])
        here = here + t[2:4] * one.own - t[4:] * other.own
        worst = np.maximum(worst, np.abs(MAP @ here))
    np.testing.assert_allclose(found.error, worst, rtol=1e-12)
    np.testing.assert_allclose(found.value, MAP @ (one.value - other.value), rtol=1e-12)


def test_some_of_many_keep_their_parts():
    many = Bounded.of(np.arange(6.0).reshape(3, 2), np.ones((3, 2)), np.full((1, 3, 2), 0.25))
    assert many[1].value.tolist() == [2.0, 3.0] and many[1:].shared.shape == (1, 2, 2)
    assert (many[2] - many[0]).error.tolist() == [1.5, 1.5]  # what all share is gone


def test_a_plane_model_refuses_what_leaves_the_plane() -> None:
    """Of one pose, or of any of many; zeros are in the plane."""
    many = Pose(0.0, 1e-3, d_y=np.array([0.0, 1e-6]))
    refuse_out_of_plane("planar", Pose(1e-3, 1e-3, 0.1))
    with pytest.raises(ValueError, match="pose: d_y must be zero for the model planar, which is plane$"):
        refuse_out_of_plane("planar", many)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_loads_are_finite(value: float) -> None:
    """The largest double is a load; what is none is refused."""
    refuse_infinite(Wrench(F_z=1e308))
    with pytest.raises(ValueError, match="wrench: must be finite numbers"):
        refuse_infinite(Wrench(F_z=value))


@pytest.mark.parametrize(
    ("kind", "values", "words"),
    [
        (Wrench, {"F_z": "1 N"}, 'F_z: must be a number [N]; got "1 N"'),
        (Wrench, {"M_x": None}, "M_x: must be a number [N*m]; got None"),
        (Wrench, {"F_x": np.array([1.0, 2.0])}, "F_x: must be a number [N]; got array"),
        (Pose, {"d_h": 0.0, "d_v": "1 mm"}, 'd_v: must be numbers [m]; got "1 mm"'),
        (Pose, {"d_h": 0.0, "d_v": 1e-3, "alpha": [1j]}, "alpha: must be numbers [rad]; got [1j]"),
    ],
)
def test_components_are_numbers(kind: type, values: dict[str, object], words: str) -> None:
    """Quantities with units are refused by name; numbers of numpy, integers and lists are numbers."""
    with pytest.raises(SceneError, match=re.escape(words)):
        kind(**values)
    assert Wrench(F_x=np.float32(0.5), F_z=np.int64(2)).components.tolist()[:2] == [0.5, 2.0]
    assert Pose(0, [1e-3, 2e-3]).centre.shape == (2, 3)
