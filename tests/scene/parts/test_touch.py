"""What touches the target in scene files: sizes of each shape, places on targets, lines that refuse others."""

import tomllib

import pytest

from sits_mech.scene.parts.coils import usual_loads
from sits_mech.scene.parts.touch import is_on
from sits_mech.scene.sensor import SceneError, load_sensor, scene_text, sensor_from

RING = 'target={material="copper", shape="ring", diameter="12 mm", inner_diameter="4 mm", thickness="0.2 mm"}'


def scene(touch, *more):
    return load_sensor("biorob2018-w15", [*more, f"touch={{{touch}}}"])


def test_a_scene_with_a_touch_reads_and_writes_as_it_is():
    sizes = 'shape="cylinder", radius="2 mm", length="4 mm", axis="y"'
    sensor = scene(f'{sizes}, x="1 mm", friction="sticking", force="2 N"')
    assert sensor.touch.place == sensor.touched_point == (1e-3, 0.0) and sensor.touch.force == 2.0
    assert sensor_from(tomllib.loads(scene_text(sensor))) == sensor
    assert load_sensor("biorob2018").touched_point == (0.0, 0.0)
    assert "touch" not in scene_text(load_sensor("biorob2018"))


@pytest.mark.parametrize(("touch", "line"), [
    ('shape="sphere"', "touch: radius must be given for a sphere; it is missing"),
    ('shape="sphere", radius="1 mm", x="7.6 mm"', "touch: must lie on the target, a rectangle 15 mm x 8 mm, "
     "as a whole; got a sphere of radius 1 mm at x = 7.6 mm, y = 0 mm"),
    ('shape="punch", width="4 mm", length="4 mm", y="2.5 mm"', "got a punch 4 mm x 4 mm at x = 0 mm, y = 2.5 mm"),
    ('shape="punch", diameter="9 mm"', "got a punch 9 mm across at x = 0 mm, y = 0 mm"),
    ('shape="punch", diameter="2 mm", width="2 mm"', "touch: width must not be given for a punch"),
    ('shape="pressure", width="2 mm"', "touch: length must be given for a pressure; it is missing"),
    ('shape="cylinder", radius="1 mm", length="9 mm", axis="y"', "got a cylinder of radius 1 mm, 9 mm long along y"),
    ('shape="cylinder", radius="1 mm", length="9 mm"', "touch: axis must be given for a cylinder"),
    ('shape="sphere", radius="1 mm", force="-1 N"', 'touch.force: must be a force that presses, .* got "-1 N"'),
    ('shape="sphere", radius="1 mm", deep="1 mm"', 'touch.deep: the key must be one of .* got "deep"'),
    ('shape="sphere", radius="1 mm", depth="-1 mm"', 'touch.depth: must be a length .* got "-1 mm"'),
    ('shape="sphere", radius="1 mm", depth="2 mm"', "touch.depth must be less than the pad, 2 mm; got 2 mm"),
    ('shape="sphere", radius="1 mm", depth="1 mm", force="1 N"', "depth must be left out beside force, .* 1 mm, 1 N"),
    ('shape="pressure", diameter="1 mm", depth="1 mm"', "depth must be left out of a pressure, .* got 1 mm"),
])
def test_what_is_no_touch_is_refused_in_one_line(touch, line):
    with pytest.raises(SceneError, match=line) as caught:
        scene(touch)
    assert "\n" not in str(caught.value)


def test_what_slides_on_the_target_is_tabled_over_its_force_alone():
    for friction, slides in (("none", True), ("sticking", False)):
        sensor = scene(f'shape="sphere", radius="1 mm", friction="{friction}"')
        assert sensor.slides == slides == ("F_x" not in usual_loads(sensor.coils, slides=sensor.slides))
    assert not load_sensor("biorob2018").slides


def test_a_touch_needs_a_target_and_its_top_face():
    with pytest.raises(SceneError, match="target.load_height must be left out with touch, .* got 0.1 mm"):
        scene('shape="sphere", radius="1 mm"', 'target.load_height="0.1 mm"')


def test_holes_and_rims_of_round_targets_count():
    """A sphere of a millimetre finds no hold in a hole of four; a punch on the ring's web does."""
    with pytest.raises(SceneError, match="touch: must lie on the target, a ring 12 mm across"):
        scene('shape="sphere", radius="1 mm"', RING)
    web = scene('shape="punch", diameter="3 mm", x="4 mm"', RING)
    assert is_on(web.touch, web.target, (0.0, 4e-3)) and not is_on(web.touch, web.target, (3e-3, 0.0))
    disc = scene('shape="punch", width="4 mm", length="2 mm"', RING.replace("ring", "disc").replace(
        'inner_diameter="4 mm", ', ""))
    assert is_on(disc.touch, disc.target, (3.9e-3, 0.0)) and not is_on(disc.touch, disc.target, (4.0e-3, 0.0))


COVER = 'cover={material="dragon-skin-30", thickness="1 mm", overhang="1 mm"}'


@pytest.mark.parametrize(("touch", "words"), [
    ('shape="sphere", radius="1 mm", y="5.1 mm"', "lie on the cover, a rectangle 17 mm x 10 mm, with its lowest point"),
    ('shape="pressure", width="9 mm", length="12 mm"', "lie on the cover, a rectangle 17 mm x 10 mm, as a whole"),
    ('shape="sphere", radius="1 mm", friction="sticking"', 'touch.friction must be "none" on a cover'),
    ('shape="cylinder", radius="1 mm", length="9 mm", axis="x"', "touch.length must reach beyond the cover"),
    ('shape="punch", width="2 mm", length="2 mm"', "touch.edge_radius must be at least 0.02 mm .* got none"),
    ('shape="sphere", radius="0.5 mm", depth="0.5 mm"', "touch.depth must be less than the radius, 0.5 mm; got 0.5 mm"),
    ('shape="sphere", radius="9 mm", depth="1 mm"', "touch.depth must be less than the cover, 1 mm; got 1 mm"),
    ('shape="punch", diameter="2 mm", edge_radius="2 mm"', "edge_radius must be at most half the punch, 1 mm"),
    ('shape="sphere", radius="1 mm", edge_radius="0.1 mm"', "edge_radius must be left out of a sphere"),
])
def test_what_does_not_press_on_a_cover_is_refused(touch, words):
    """Over a rim, with friction, with ends or sharp edges on it."""
    with pytest.raises(SceneError, match=words):
        scene(touch, COVER)


def test_what_presses_on_a_cover_is_taken():
    """Beside the target, and a platen beyond the cover, too."""
    for touch in ('shape="sphere", radius="1 mm", y="4.9 mm"', 'shape="punch", diameter="30 mm", edge_radius="1 mm"'):
        assert scene(touch, COVER).touch is not None
    with pytest.raises(SceneError, match="elastomer.friction must be 0 with a touch on a cover; got 0.3"):
        scene('shape="sphere", radius="1 mm"', COVER, "elastomer.friction=0.3")
