"""What cells read of a touch: a press on one of them, over both by superposition, and plates moved at once."""

import numpy as np
import pytest

from sits_mech.chain.cells import cell_crosstalk
from sits_mech.chain.cells_touch import cell_touch
from sits_mech.scene.cells import load_cells
from sits_mech.units import SceneError

COILS = "coils=[" + ", ".join(
    f'{{name="{name}", centre=["{x}", 0], turns=4, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}' for name, x in (("L", "-2 mm"), ("R", "2 mm"))
) + "]"


def touched(touch, force, tolerance=0.1):
    places = 'targets=[{name="A", centre=["-5 mm", 0]}, {name="B", centre=["5 mm", 0]}]'
    cells = load_cells("biorob2018", [COILS, places, 'elastomer.width="30 mm"', f"touch={touch}"])
    return cells, cell_touch(cells, tolerance, force)


@pytest.fixture(scope="module")
def middle():
    return touched('{shape="sphere", radius="5 mm", x="5 mm"}', 0.05)


def test_a_press_in_the_middle_of_a_cell_is_read_as_its_crosstalk_says(middle):
    cells, found = middle
    crosstalk = cell_crosstalk(cells, 0.1)
    assert found.reads == crosstalk.reads == ("F_z", "F_x") and found.read.shape == (2, 2)
    assert found.read[1] == pytest.approx([0.05, 0.0], abs=1e-4)
    assert found.read[0] == pytest.approx(0.05 * crosstalk.total[0, :, 1, 0], abs=1e-4)
    assert found.L[1, 0] == pytest.approx(found.L[1, 1], rel=1e-9) and np.all(found.L[1] < found.L_rest)
    assert found.poses[1, 1] < 2e-3 < found.poses[0, 1] and 0.0 < found.finite_strain < 0.05


def test_pressures_on_two_cells_are_their_sum():
    """A pressure over both, the silicone between, and its parts: forces read add up, at small strain."""
    _, wide = touched('{shape="pressure", width="14 mm", length="4 mm"}', 0.05)
    parts = [touched(f'{{shape="pressure", width="{w} mm", length="4 mm", x="{x} mm"}}', 0.05 * w / 14.0)[1]
             for w, x in ((6, -4), (2, 0), (6, 4))]
    off = np.abs(wide.read - sum(part.read for part in parts))
    assert np.all(off < wide.read_error + sum(part.read_error for part in parts))
    assert wide.read[0] == pytest.approx(wide.read[1] * [1.0, -1.0], abs=1e-6)


def test_a_scene_without_touch_or_force_is_refused_in_one_line():
    places = 'targets=[{name="A", centre=["-5 mm", 0]}, {name="B", centre=["5 mm", 0]}]'
    with pytest.raises(SceneError, match="touch must be given to press on cells; it is missing"):
        cell_touch(load_cells("biorob2018", [COILS, places]))
    with pytest.raises(SceneError, match="touch.force must be a press above 0 N; got none"):
        touched('{shape="sphere", radius="5 mm", x="5 mm"}', None)
