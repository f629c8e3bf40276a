"""Cells on one pad in scene files: what they are made of, lines that refuse others."""

import numpy as np
import pytest

from sits_mech.scene.cells import load_cells
from sits_mech.scene.sensor import SceneError, load_sensor

COIL = (
    'coils=[{name="C", centre=["1 mm", 0], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]'
)


OTHER = COIL[:-1] + ", " + COIL[len("coils=["):].replace('"C"', '"D"')  # in the same place
COVER = 'cover={material="ecoflex-00-30", thickness="0.5 mm", overhang="1 mm"}'


def two(x="10 mm", y="0 mm"):
    return f'targets=[{{name="A", centre=["-5 mm", "0 mm"]}}, {{name="B", centre=["{x}", "{y}"]}}]'


def cells(*keys, x="5 mm", y="0 mm"):
    return load_cells("biorob2018", [COIL, two(x, y), *keys])


def test_a_cell_is_the_scene_without_its_places():
    found = cells('targets.B.centre.0="5.5 mm"')
    assert found.sensor == load_sensor("biorob2018", [COIL]) and found.names == ["A", "B"]
    assert np.array_equal(found.centres, [[-5e-3, 0.0], [5.5e-3, 0.0]])
    (coil,) = found.coils_at(1, found.centres[1], "B.")
    assert coil.name == "B.C" and coil.centre == (6.5e-3, 0.0)


def test_cells_may_have_coils_and_sizes_of_their_own():
    """Coils of different cells may be in one place about their targets' centres; what is written anew is as before."""
    found = cells(OTHER, 'targets.A.coils=["C"]', 'targets.B.coils=["D"]', 'targets.B.width="6 mm"',
                  'targets.B.thickness="1 mm"')
    assert [own.coil_names for own in found.sensors] == [["C"], ["D"]] == [[name] for name in found.coil_names]
    assert [plate.extent for plate in found.plates] == [(8e-3, 8e-3), (6e-3, 8e-3)] and found.kinds == [0, 1]
    assert [plate.load_height for plate in found.plates] == [2e-4, 1e-3] == found.thicknesses.tolist()
    assert found.gaps[0, 1] == pytest.approx(3e-3) and np.isinf(found.gaps[0, 0])
    alike = cells('targets.B.coils=["C"]', 'targets.A.width="8 mm"', 'targets.A.length="8 mm"')
    assert alike.sensors == cells().sensors and alike.kinds == [0, 0]


@pytest.mark.parametrize(("keys", "place", "line"), [
    ([], {"x": "2 mm"}, "targets.A and targets.B overlap: their centres must be at least 8.002 mm apart along x or "
     "8.002 mm along y; got 7 mm and 0 mm"),
    ([], {"x": "3 mm"}, "got 8 mm and 0 mm"),  # flush targets would be one
    ([], {"x": "6.5 mm"}, "targets.B must lie on the pad, 20 mm x 20 mm; got a target that reaches 0.5 mm over its "
     "side along x"),
    (['coils.C.turns=30'], {}, "coils.A.C and coils.B.C overlap"),
    (['targets.1.name="A"'], {}, "targets must have a name of their own each; got 'A' twice"),
    (['targets=[{name="A", centre=[0, 0]}]'], {}, "targets must be two to 9; got 1"),
    (['targets.A.diameter="3 mm"'], {}, "targets.A.diameter: the key must be one of"),
    (['targets.B.width="9 mm"'], {"x": "3 mm"}, "targets.A and targets.B overlap: their centres must be at least 8.502 "
     "mm apart along x or 8.002 mm along y; got 8 mm and 0 mm"),
    (['targets.B.length="21 mm"'], {}, "targets.B must lie on the pad, 20 mm x 20 mm; got a target that reaches 0.5 mm "
     "over its side along y"),
    (['targets.A.coils=["D"]'], {}, 'targets.A.coils must be one of C; got "D"'),
    (['targets.A.coils=[]'], {}, "targets.A.coils must name one coil of the scene or more, each once; got none"),
    (['targets.A.coils=["C", "C"]'], {}, "must name one coil of the scene or more, each once; got C, C"),
    ([OTHER, 'targets.A.coils=["C"]', 'targets.B.coils=["C"]'], {}, "coils.D must be of a cell, in coils of one of the "
     "targets; it is in none"),
    ([COVER, 'targets.B.thickness="1 mm"'], {}, "targets.B must be as thick as all under one cover, 0.2 mm; got 1 mm"),
    ([COVER, 'slots=[{x=0, width="1 mm"}]'], {}, "slots must be left out under a cover, which would bridge them; "
     "got 1"),
    (['slots=[{x=0, width="1 mm"}]', 'touch={shape="pressure", width="4 mm", length="2 mm"}'], {}, "touch must lie "
     "beside slots.0, a slot from x = -0.5 mm to 0.5 mm; got a pressure 4 mm x 2 mm at 0 mm, 0 mm"),
    (['target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}'], {},
     'target.shape must be "rectangle" where several stand on one pad; got "disc"'),
    (['elastomer={material="ecoflex-00-30", diameter="30 mm", thickness="2 mm"}'], {}, "elastomer must be a box under "
     "several targets; got cylinder"),
    (['conductors=[{name="B", material="copper", shape="rectangle", width="5 mm", length="5 mm", thickness="1 mm", '
      'centre=["0 mm", "-9 mm"]}]'], {}, "conductors must be left out with .*targets"),
    (['touch={shape="pressure", width="4 mm", length="2 mm", x="9 mm"}'], {}, "touch must lie on the pad, 20 mm x 20 "
     "mm, as a whole; got a pressure 4 mm x 2 mm at 9 mm, 0 mm"),
    (['touch={shape="punch", width="4 mm", length="2 mm", x="2 mm"}'], {}, "touch must lie on one target or on the "
     "silicone beside all, of bare targets 0.2 mm thick, and not over the rim of targets.B; got a punch 4 mm x 2 mm"),
    (['touch={shape="sphere", radius="10 mm"}'], {}, "not over the rim of targets.A; got a sphere of radius 10 mm"),
    (['touch={shape="sphere"}'], {}, "touch: radius must be given for a sphere"),
    ([COVER, 'touch={shape="sphere", radius="5 mm", y="6 mm"}'], {}, "touch must lie on the cover, 20 mm x 10 mm, as a "
     "whole; got a sphere of radius 5 mm at 0 mm, 6 mm"),
    ([COVER.replace("1 mm", "2 mm")], {}, "cover.overhang must be at most 1 mm beyond the outer targets, or it reaches "
     "beyond the pad; got 2 mm"),
])
def test_cells_that_cannot_be_are_refused_in_one_line(keys, place, line):
    with pytest.raises(SceneError, match=line) as caught:
        cells(*keys, **place)
    assert "\n" not in str(caught.value)


def test_a_rigid_touch_knows_its_target_and_what_it_would_meet_beside():
    sphere = cells('touch={shape="sphere", radius="0.9 mm"}')
    assert sphere.pressed_target is None and np.all(np.isinf(sphere.heights_over(sphere.touch)))  # 1 mm from both
    ball = cells('touch={shape="sphere", radius="2 mm"}')
    assert ball.heights_over(ball.touch) == pytest.approx(2e-3 - np.sqrt(3.0) * 1e-3)
    assert cells('touch={shape="punch", diameter="6 mm", x="5 mm"}').pressed_target == 1


def test_scenes_of_one_target_and_of_several_name_each_other():
    with pytest.raises(SceneError, match="biorob2018: targets must be left out here: `sits-mech cells` solves"):
        load_sensor("biorob2018", [COIL, two()])
    with pytest.raises(SceneError, match=r"biorob2018: targets must be given, \[\[targets\]\] with name and centre"):
        load_cells("biorob2018")
