"""Crosstalk between cells: what it is made of, symmetries, far apart, plates moved one by one; one touch of several."""

import numpy as np
import pytest

from sits_mech.chain.cells.crosstalk import cell_crosstalk, cell_touch, forces_read, own_calibration
from sits_mech.scene.cells import load_cells
from sits_mech.units import SceneError

COIL = (
    '{{name="{}", centre=["{}", "{}"], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}}'
)
ONE = f'coils=[{COIL.format("C", "0 mm", "0 mm")}]'


def cells(centres, *keys):
    each = zip("ABC", centres, strict=False)
    places = ", ".join(f'{{name="{name}", centre=[{x}, {y}]}}' for name, (x, y) in each)
    return load_cells("biorob2018", [f"targets=[{places}]", *keys])


def on_x(half, *keys):
    return cells([(-half, 0.0), (half, 0.0)], *keys)


@pytest.fixture(scope="module")
def found():
    return cell_crosstalk(on_x(4.8e-3, ONE, 'elastomer.width="30 mm"'), 0.1)


def test_a_cell_reads_the_force_on_itself_and_less_of_its_neighbour(found):
    total, names = found.total, ("mechanical", "magnetic", "error")
    assert found.reads == ("F_z",) and all(getattr(found, name).shape == (2, 1, 2, 3) for name in names)
    assert total[0, 0, 0, 0] == pytest.approx(1.0, abs=1e-12) == total[1, 0, 1, 0]
    assert total[0, 0, 1, 0] == pytest.approx(total[1, 0, 0, 0], rel=1e-3)  # mirror images
    assert total[0, 0, 1, 1] == pytest.approx(-total[1, 0, 0, 1], rel=1e-3)
    assert np.abs(total[..., 2]) == pytest.approx(0.0, abs=float(found.error[..., 2].max()))  # by symmetry


def test_one_coil_reads_what_its_neighbour_sinks_of_it(found):
    """By a coil in the middle: d_v alone, C_ij over C_ii, -8.0 % by NGSolve (tests/mechanics/cells/test_targets.py)."""
    assert found.mechanical[0, 0, 1, 0] == pytest.approx(-0.00014250 / 0.0017629, rel=0.03)
    assert 1e-5 < abs(found.magnetic[0, 0, 1, 0]) < 1e-3 < found.finite_strain < 0.1


def test_cells_far_apart_read_nothing_of_each_other():
    far = cell_crosstalk(on_x(13e-3, ONE, 'elastomer.width="52 mm"'), 0.1)
    assert np.abs(far.total[0, :, 1]).max() < 1e-3 and np.abs(far.magnetic[0, :, 1]).max() < 1e-5


def test_cells_of_other_coils_read_other_forces_by_their_own_calibrations():
    """Of a cell with a coil the part of G_ii is a number, of one with two along y a matrix of two."""
    coils = [COIL.format("M", "0 mm", "0 mm"), COIL.format("U", "0 mm", "2 mm"), COIL.format("D", "0 mm", "-2 mm")]
    found = on_x(5e-3, f"coils=[{', '.join(coils)}]", 'targets.A.coils=["M"]', 'targets.B.coils=["U", "D"]')
    reads, weights = forces_read(found)
    assert reads == ("F_z", "F_y") and found.coil_names == ["M", "U", "D"]
    assert np.array_equal(weights != 0.0, [[[1, 0, 0], [0, 0, 0]], [[0, 1, 1], [0, 1, 1]]])
    C = np.random.default_rng(0).normal(size=(2, 6, 2, 6))
    S = np.einsum("irc,icp->irp", weights, np.random.default_rng(1).normal(size=(2, 3, 6)))
    every = np.einsum("irp,ik->irkp", S, np.eye(2))
    first, second = own_calibration(every, C, reads)
    own = S[1] @ C[1, :, 1][:, [1, 3]]  # by F_z and F_y
    assert second == pytest.approx(np.linalg.inv(own)) and first[0, 0] == pytest.approx(1.0 / (S[0, 0] @ C[0, :, 0, 1]))
    assert np.count_nonzero(first) == 1


@pytest.mark.slow
def test_cells_that_differ_read_each_other_by_their_own_coils():
    """A small target sinks deeper and moves the large one less; what a cell does not read is none."""
    pair = f"coils=[{COIL.format('M', '0 mm', '0 mm')}, {COIL.format('L', '-2 mm', '0 mm')}, " \
           f"{COIL.format('R', '2 mm', '0 mm')}]"
    found = cell_crosstalk(on_x(4.8e-3, pair, 'elastomer.width="30 mm"', 'targets.A.coils=["L", "R"]',
                                'targets.B.coils=["M"]', 'targets.B.width="6 mm"', 'targets.B.length="4 mm"'), 0.1)
    assert found.reads == ("F_z", "F_x") and np.all(np.isnan(found.total[1, 1])) and np.all(np.isfinite(found.total[0]))
    assert found.total[1, 0, 1, 0] == pytest.approx(1.0) and found.total[0, 1, 0, 1] == pytest.approx(1.0)
    by_small, by_large = found.total[0, 0, 1, 0], found.total[1, 0, 0, 0]
    assert by_small < by_large < 0.0  # reciprocal motions, over an own one that is larger of the small target
    assert np.all(np.isfinite(found.largest))


@pytest.mark.slow
def test_a_row_along_y_is_one_along_x():
    pair = [COIL.format("C1", "-2 mm", "0 mm"), COIL.format("C2", "2 mm", "0 mm")]
    turned = [COIL.format("C1", "0 mm", "-2 mm"), COIL.format("C2", "0 mm", "2 mm")]
    one = cell_crosstalk(on_x(4.8e-3, f"coils=[{', '.join(pair)}]"), 0.1)
    other = cell_crosstalk(cells([(0.0, -4.8e-3), (0.0, 4.8e-3)], f"coils=[{', '.join(turned)}]"), 0.1)
    assert one.reads == ("F_z", "F_x") and other.reads == ("F_z", "F_y")
    assert other.total[..., [0, 2]] == pytest.approx(one.total[..., :2], abs=1e-4)
    assert other.error[..., [0, 2]] == pytest.approx(one.error[..., :2], rel=0.05)


COILS = "coils=[" + ", ".join(
    f'{{name="{name}", centre=["{x}", 0], turns=4, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}' for name, x in (("L", "-2 mm"), ("R", "2 mm"))
) + "]"


def touched(touch, force, tolerance=0.1):
    places = 'targets=[{name="A", centre=["-5 mm", 0]}, {name="B", centre=["5 mm", 0]}]'
    scene = load_cells("biorob2018", [COILS, places, 'elastomer.width="30 mm"', f"touch={touch}"])
    return scene, cell_touch(scene, tolerance, force)


@pytest.fixture(scope="module")
def middle():
    return touched('{shape="sphere", radius="5 mm", x="5 mm"}', 0.05)


def test_a_press_in_the_middle_of_a_cell_is_read_as_its_crosstalk_says(middle):
    scene, found = middle
    crosstalk = cell_crosstalk(scene, 0.1)
    assert found.reads == crosstalk.reads == ("F_z", "F_x") and found.read.shape == (2, 2)
    assert found.read[1] == pytest.approx([0.05, 0.0], abs=1e-4)
    assert found.read[0] == pytest.approx(0.05 * crosstalk.total[0, :, 1, 0], abs=1e-4)
    assert found.L[1, 0] == pytest.approx(found.L[1, 1], rel=1e-9) and np.all(found.L[1] < found.L_rest)
    assert found.moved[1, 1] < 0.0 < found.moved[0, 1] and 0.0 < found.finite_strain < 0.05


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
