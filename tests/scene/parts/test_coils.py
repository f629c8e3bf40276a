"""Coils as a scene has them: what each shape takes, what is refused with one line, and how large they are."""

import math
import tomllib
from typing import Any

import numpy as np
import pytest

from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.parts.outlines import lines_crossing
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor, scene_text, sensor_from

TRACK = {"track_width": "0.1 mm", "track_thickness": "35 um"}
CIRCLE = {"name": "C", "centre": [0, 0], "layers": 2, "turns": 5, "inner_diameter": "2 mm"} | TRACK
CIRCLE |= {"track_gap": "0.1 mm", "layer_pitch": "85 um"}
RECTANGLE = {key: item for key, item in CIRCLE.items() if key != "inner_diameter"}
RECTANGLE |= {"shape": "rectangle", "inner_width": "2 mm", "inner_length": "3 mm"}
TOP, DEEP = -0.05e-3, -0.5e-3
LOOP = [[1e-3, 0.0, TOP], [6e-3, 0.0, TOP], [6e-3, 4e-3, TOP], [1e-3, 4e-3, TOP]]
PATH = {"name": "C", "shape": "path", "path": [LOOP]} | TRACK


def scene(*coils: dict[str, Any]) -> dict[str, Any]:
    """Return a scene of coils."""
    return {"name": "coils", "frequency": 1e6, "coils": list(coils)}


def made(*coils: dict[str, Any]) -> tuple[Coil, ...]:
    """Return the coils of a scene, which its own file gives back."""
    sensor = sensor_from(scene(*coils))
    assert sensor_from(tomllib.loads(scene_text(sensor))) == sensor
    return sensor.coils


def without(coil: dict[str, Any], *keys: str) -> dict[str, Any]:
    """Return a coil's keys without some."""
    return {key: item for key, item in coil.items() if key not in keys}


def test_a_circle_is_written_as_before() -> None:
    """The keys of a round coil are those of the first scenes, no others: scenes keep their hash."""
    (coil,) = made(CIRCLE)
    assert set(coil.model_dump()) == {*CIRCLE, "winding"}
    assert coil.heights == (-17.5e-6, -102.5e-6) and coil.extent == (coil.outer_diameter,) * 2


def test_sizes_of_a_rectangle() -> None:
    """Five turns of 0.1 mm with gaps of 0.1 mm add 0.9 mm to each side; the circle around it has its diagonal."""
    (coil,) = made(RECTANGLE)
    assert coil.extent == pytest.approx((3.8e-3, 4.8e-3), rel=1e-12)
    assert coil.outer_diameter == pytest.approx(math.hypot(3.8e-3, 4.8e-3), rel=1e-12)
    (rounded,) = made(RECTANGLE | {"inner_length": "2 mm", "corner_radius": "1.05 mm"})
    assert rounded.outer_diameter == pytest.approx(3.8e-3, rel=1e-9)  # a circle


HEXAGON = {key: item for key, item in CIRCLE.items() if key != "inner_diameter"}
HEXAGON |= {"shape": "hexagon", "inner_diameter": "2 mm"}
D = RECTANGLE | {"shape": "D", "inner_width": "2 mm", "inner_length": "3 mm"}


def test_sizes_of_polygons() -> None:
    """Five turns add 0.9 mm to each side: 3.8 mm across flats, corners at 1 / cos(pi / n), wherever they are turned."""
    for shape, n in (("hexagon", 6), ("octagon", 8)):
        (coil,) = made(HEXAGON | {"shape": shape})
        assert coil.outer_diameter == pytest.approx(3.8e-3 / math.cos(math.pi / n), rel=1e-12)
        assert coil.extent[0] == pytest.approx(3.8e-3, rel=1e-12)
        (other,) = made(HEXAGON | {"shape": shape, "alpha_z": "90 deg"})
        assert other.extent == pytest.approx(coil.extent[::-1], rel=1e-12)
        (other,) = made(HEXAGON | {"shape": shape, "alpha_z": f"{180 / n} deg"})
        assert other.extent[0] == pytest.approx(coil.outer_diameter, rel=1e-12)


def test_sizes_of_a_d() -> None:
    """2 and 3 mm inside, 3.8 and 4.8 outside; its flat corners reach farthest, whatever it is turned by."""
    (coil,) = made(D)
    assert coil.extent == pytest.approx((3.8e-3, 4.8e-3), rel=1e-12)
    assert coil.outer_diameter == pytest.approx(math.hypot(3.8e-3, 4.8e-3), rel=1e-12)
    points = np.array(coil.rim)
    for degrees in (30.0, 90.0, 135.0, -160.0):
        (other,) = made(D | {"alpha_z": f"{degrees} deg"})
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        far = 2.0 * np.abs(points @ np.array([[c, s], [-s, c]])).max(axis=0)  # its arc is off by a few um
        assert other.extent == pytest.approx(tuple(far), rel=4e-3) and other.outer_diameter == coil.outer_diameter


def test_hexagons_stand_in_a_honeycomb() -> None:
    """Side by side at 60 degrees, where the boxes around them overlap; half a track nearer they overlap themselves."""
    places = {"D": [3.85e-3, 0.0], "E": [1.925e-3, 3.85e-3 * math.sqrt(0.75)]}
    made(HEXAGON, *(HEXAGON | {"name": name, "centre": place} for name, place in places.items()))
    near = HEXAGON | {"name": "D", "centre": [0.49 * 3.8e-3, 0.49 * 3.8e-3 * math.sqrt(3.0)]}
    with pytest.raises(SceneError, match="C and coils.D overlap: the rims of them must be clear of each other"):
        made(HEXAGON, near)


def test_layers_at_given_heights() -> None:
    """Inner planes: the copper's middles instead of a pitch; layers need no count."""
    own = {"layer_z": ["-0.2 mm", "-1.4 mm"], "directions": [1, -1]}
    (coil,) = made(without(CIRCLE, "layers", "layer_pitch") | own)
    assert coil.layers == 2 and coil.heights == (-0.2e-3, -1.4e-3)
    assert coil.height == pytest.approx(1.4175e-3, rel=1e-12)


def test_a_path_is_moved_to_its_middle() -> None:
    """Wherever its points count from, it is one coil; equal ones differ by their centres alone."""
    moved = [[x + 0.02, y - 0.01, z] for x, y, z in LOOP]
    here, there = made(PATH, PATH | {"name": "D", "path": [moved]})
    assert here.centre == pytest.approx((3.5e-3, 2e-3), abs=1e-12)
    assert there.centre == pytest.approx((23.5e-3, -8e-3), abs=1e-12)
    assert here.path == there.path and here.heights == (TOP,)
    assert here.extent == pytest.approx((5.1e-3, 4.1e-3), rel=1e-12)


HEIGHTS = without(CIRCLE, "layer_pitch")
BAD = [
    (CIRCLE | {"shape": "oval"}, r"coils.C.shape: must be"),
    (CIRCLE | {"inner_width": "1 mm"}, r"inner_width must not be given for a circle"),
    (without(RECTANGLE, "inner_length"), r"inner_length must be given for a rectangle; it is missing"),
    (RECTANGLE | {"winding": "spiral"}, r"winding must not be given for a rectangle"),
    (RECTANGLE | {"corner_radius": "1.2 mm"}, r"corner_radius must be 0, or from .* \(1.05 mm\); got 1.2 mm"),
    (RECTANGLE | {"corner_radius": "1 um"}, r"corner_radius must be 0, or from half the track_width .* got 0.001 mm"),
    (CIRCLE | {"layer_z": ["-0.1 mm", "-0.2 mm"]}, r"layer_pitch must not be given beside layer_z"),
    (HEIGHTS | {"layer_z": ["-0.1 mm"]}, r"layers must be the 1 of layer_z; got 2"),
    (HEIGHTS | {"layer_z": ["-0.1 mm", "-0.12 mm"]}, r"layer_z: layers must go down by at least"),
    (HEIGHTS | {"layer_z": ["0 mm", "-0.1 mm"]}, r"layer_z: .* top face at or below z = 0; got 0"),
    (HEXAGON | {"corner_radius": "1 mm"}, r"corner_radius must not be given for a hexagon"),
    (HEXAGON | {"alpha_z": 4.0}, r"coils.C.alpha_z: must be an angle up to half a turn .*; got 4"),
    (RECTANGLE | {"alpha_z": 1.0}, r"alpha_z must not be given for a rectangle"),
    (D | {"inner_width": "1.4 mm"}, r"inner_width must be at least half the inner_length \(1.5 mm\) of a D; got 1.4"),
    (CIRCLE | {"directions": [1]}, r"directions must be one for each of 2 layers; got 1"),
    (CIRCLE | {"directions": [1, 0]}, r"directions.1: must be 1 .* or -1; got 0"),
    (PATH | {"path": []}, r"path: must be one polyline or more"),
    (PATH | {"path": [LOOP[:1]]}, r"path: polyline 0 must have two points or more; got 1"),
    (PATH | {"path": [[LOOP[0], [0, 0, DEEP]]]}, r"path: polyline 0 must lie in one layer"),
    (PATH | {"path": [[LOOP[0], LOOP[0], LOOP[1]]]}, r"path: polyline 0 must go on from point to point; got point 0"),
    (PATH | {"path_widths": [1e-4, 2e-4]}, r"path_widths: must be one for each of 1 polylines; got 2"),
    (PATH | {"path": [[*LOOP, [3e-3, -1e-3, TOP]]]}, r"path: tracks must not cross in one layer; .* at x = 2.6 mm"),
    (PATH | {"path": [LOOP, [[1e-3, 4e-3, -0.06e-3], [0, 4e-3, -0.06e-3]]]}, r"path: layers must go down by at least"),
    (PATH | {"turns": 3}, r"the key turns|turns must not be given for a path"),
]


@pytest.mark.parametrize(("coil", "message"), BAD)
def test_impossible_coils_are_refused_on_one_line(coil: dict[str, Any], message: str) -> None:
    """Which input, what it must be, what came."""
    with pytest.raises(SceneError, match=message) as caught:
        sensor_from(scene(coil))
    assert "\n" not in str(caught.value)


def test_tracks_may_cross_in_different_layers() -> None:
    """A way out of a spiral passes below its turns."""
    out = [[1e-3, 4e-3, DEEP], [3e-3, -1e-3, DEEP]]
    (coil,) = made(PATH | {"path": [LOOP, out]})
    assert coil.heights == (TOP, DEEP)


def test_crossings_of_polylines() -> None:
    """Cross, touch, fold back on themselves; not end to end, nor far away."""
    line = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])
    assert lines_crossing([line, np.array([[2.0, 2.0], [0.0, 2.0], [0.0, 1.0]])]) is None
    assert lines_crossing([line, np.array([[1.0, 1.0], [1.0, -1.0]])]) == pytest.approx((1.0, 0.0))
    assert lines_crossing([line, np.array([[1.0, 1.0], [2.0, 1.0]])]) is not None  # touches
    assert lines_crossing([np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]])]) is not None  # folds
    assert lines_crossing([line, np.array([[0.5, 0.0], [1.5, 0.0]])]) is not None  # lies on it


def test_coils_side_by_side_and_over_each_other() -> None:
    """Squares may stand edge to edge, as circles of that diameter could not at an angle; layers apart pass."""
    square = RECTANGLE | {"inner_length": "2 mm"}
    beside = [{"name": name, "centre": place} for name, place in (("D", ["3.8 mm", "3.8 mm"]), ("E", [0, "3.8 mm"]))]
    made(square, *(square | each for each in beside))
    with pytest.raises(SceneError, match="C and coils.D overlap: the boxes .* overlap by 0.1 mm"):
        made(square, square | {"name": "D", "centre": ["3.7 mm", 0]})
    deep = without(CIRCLE, "layer_pitch") | {"name": "D", "layer_z": ["-0.3 mm", "-0.5 mm"]}
    made(CIRCLE, deep)
    with pytest.raises(SceneError, match="coils.C and coils.D overlap"):
        made(CIRCLE, deep | {"layer_z": ["-0.11 mm", "-0.5 mm"]})


def test_free_tracks_may_reach_into_each_other() -> None:
    """Two windings of one board interleave; where their tracks cross in one layer they do not."""
    inner = [[2e-3, 1e-3, TOP], [5e-3, 1e-3, TOP], [5e-3, 3e-3, TOP], [2e-3, 3e-3, TOP]]
    made(PATH, PATH | {"name": "D", "path": [inner]})
    with pytest.raises(SceneError, match="C and coils.D overlap: tracks must not cross"):
        made(PATH, PATH | {"name": "D", "path": [[*inner, [0.0, 3e-3, TOP], [0.0, -1e-3, TOP], [3e-3, -1e-3, TOP],
                                                  [3e-3, 0.5e-3, TOP]]]})


def test_plates_between_a_boards_layers() -> None:
    """A plane between the layers of a rectangle is clear of them; one in a layer is not."""
    coil = without(RECTANGLE, "layer_pitch") | {"layer_z": ["-0.1 mm", "-1.5 mm"]}
    plate = {"name": "pour", "material": "copper", "shape": "rectangle", "width": "9 mm", "length": "9 mm"}
    plate |= {"thickness": "35 um", "centre": [0, "-0.8 mm"]}
    sensor_from(scene(coil) | {"conductors": [plate]})
    with pytest.raises(SceneError, match="conductors.pour must be clear of coils.C"):
        sensor_from(scene(coil) | {"conductors": [plate | {"centre": [0, "-1.5 mm"]}]})


def test_a_scene_of_many_points_is_read_in_a_second() -> None:
    """A board's spiral of a thousand points, as SI numbers."""
    angle = np.linspace(0.0, 40.0 * np.pi, 1000)
    x, y = (1e-3 + 2e-5 * angle) * np.array([np.cos(angle), np.sin(angle)])
    (coil,) = made(PATH | {"path": [np.column_stack([x, y, np.full(angle.size, TOP)]).tolist()], "track_width": 5e-5})
    assert isinstance(load_sensor("biorob2018"), Sensor) and len(coil.path[0]) == 1000
