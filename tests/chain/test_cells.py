"""Crosstalk between cells: what it is made of, symmetries, far apart, plates moved one by one; one touch of several."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.cells import cell_crosstalk, cell_touch, signal_slopes
from sits_mech.chain.propagation import signal_weights
from sits_mech.magnetics.sheets import sheets
from sits_mech.mechanics.cells import cells_pad
from sits_mech.quantities import Pose
from sits_mech.scene.cells import load_cells
from sits_mech.scene.parts import Conductor, Plate
from sits_mech.units import SceneError

COIL = (
    '{{name="{}", centre=["{}", "{}"], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}}'
)
ONE = f'coils=[{COIL.format("C", "0 mm", "0 mm")}]'
REST = Pose(0.0, 2e-3)


def cells(centres, *keys):
    each = zip("ABC", centres, strict=False)
    places = ", ".join(f'{{name="{name}", centre=[{x}, {y}]}}' for name, (x, y) in each)
    return load_cells("biorob2018", [f"targets=[{places}]", *keys])


def shape_of(found):
    return {key: getattr(found.sensor.target, key) for key in Plate.model_fields}


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
    """By a coil in the middle: d_v alone, C_ij over C_ii, -8.0 % by NGSolve (tests/mechanics/test_cells.py)."""
    assert found.mechanical[0, 0, 1, 0] == pytest.approx(-0.00014250 / 0.0017629, rel=0.03)
    assert 1e-5 < abs(found.magnetic[0, 0, 1, 0]) < 1e-3 < found.finite_strain < 0.1


def test_cells_far_apart_read_nothing_of_each_other():
    far = cell_crosstalk(on_x(13e-3, ONE, 'elastomer.width="52 mm"'), 0.1)
    assert np.abs(far.total[0, :, 1]).max() < 1e-3 and np.abs(far.magnetic[0, :, 1]).max() < 1e-5


@pytest.mark.slow
def test_a_row_along_y_is_one_along_x():
    pair = [COIL.format("C1", "-2 mm", "0 mm"), COIL.format("C2", "2 mm", "0 mm")]
    turned = [COIL.format("C1", "0 mm", "-2 mm"), COIL.format("C2", "0 mm", "2 mm")]
    one = cell_crosstalk(on_x(4.8e-3, f"coils=[{', '.join(pair)}]"), 0.1)
    other = cell_crosstalk(cells([(0.0, -4.8e-3), (0.0, 4.8e-3)], f"coils=[{', '.join(turned)}]"), 0.1)
    assert one.reads == ("F_z", "F_x") and other.reads == ("F_z", "F_y")
    assert other.total[..., [0, 2]] == pytest.approx(one.total[..., :2], abs=1e-4)
    assert other.error[..., [0, 2]] == pytest.approx(one.error[..., :2], rel=0.05)


@pytest.mark.slow
def test_targets_that_are_moved_by_hand_change_a_coil_as_its_crosstalk_says():
    """B as a fixed plate in other places, alone by d_v, and both as a press and a shear on B move them, either way.

    A's coil is on the side of B. What comes through fields, 0.4 and 1.2 % of what is read, brings the whole nearer.
    """
    pair = on_x(4.8e-3, f'coils=[{COIL.format("C", "2 mm", "0 mm")}]', 'elastomer.width="30 mm"')
    S, off = (each[0, 0] for each in signal_slopes(pair, signal_weights(pair.sensor)[None, [0]].repeat(2, 0), 1e-2))

    def half_change(A, B):
        read = []
        for way in (1.0, -1.0):
            d_h, d_v, alpha, *_ = REST.components + way * B
            x, z = np.array([np.sin(alpha), np.cos(alpha)]) * pair.plates[0].thickness / 2.0
            plate = Conductor(name="B", centre=(9.6e-3 + d_h + x, 0.0, d_v + z), alpha=alpha, **shape_of(pair))
            scene = pair.sensor.model_copy(update={"elastomer": None, "conductors": (plate,)})
            pose = Pose(*(REST.components + way * A))
            read.append(sheets(scene, 1e-3).impedance(pose, scene.frequency).L[0, 0])
        return (read[0] - read[1]) / 2.0

    sunk = 1e-4 * np.eye(6)[1]
    assert S[1, 1] == pytest.approx(half_change(0.0 * sunk, sunk) / 1e-4, abs=off[1, 1]) and off[1, 1] < 0.1 * S[1, 1]
    found, C = cell_crosstalk(pair), cells_pad(pair).compliances[-1]
    own = S[0] @ C[0, :, 0, 1]
    for force, load, size in ((0, 1, 1.0), (1, 0, 0.3)):  # F_z, F_x
        by_hand = half_change(size * C[0, :, 1, load], size * C[1, :, 1, load]) / (size * own)
        whole, silicone = (each[0, 0, 1, force] for each in (found.total, found.mechanical))
        assert whole == pytest.approx(by_hand, rel=0.01) and abs(whole - by_hand) < 0.6 * abs(silicone - by_hand)


@pytest.mark.slow
def test_third_targets_change_slopes_by_no_more_than_their_share():
    """In a row at 1.2 widths the first one moves: seen by the next, and by the one beyond, among all and in pairs."""
    row = cells([(-9.6e-3, 0.0), (0.0, 0.0), (9.6e-3, 0.0)], ONE, 'elastomer.width="40 mm"')
    S, off = (each[:, 0, 0, 1] for each in signal_slopes(row, signal_weights(row.sensor)[None, [0]].repeat(3, 0), 1e-2))
    plates = tuple(Conductor(name=f"P{k}", centre=(k * 9.6e-3, 0.0, 2.1e-3), **shape_of(row)) for k in (1, 2))
    among = np.zeros(3)
    for seen in (1, 2):
        coils = row.coils_at(0, np.array([seen * 9.6e-3, 0.0]))
        scene = row.sensor.model_copy(update={"elastomer": None, "conductors": plates, "coils": coils})
        model = replace(sheets(scene, 1e-2), single=True)
        down, up = (model.impedance(Pose(0.0, 2e-3 + dz), scene.frequency).L[0, 0] for dz in (-2e-5, 2e-5))
        among[seen] = (up - down) / 4e-5
    assert np.all(np.abs(among - S)[1:] < off[1:])
    assert abs(among[2] / S[2] - 1.0) > 0.05 > abs(among[1] / S[1] - 1.0)  # so that a share is needed, and which


@pytest.mark.slow
def test_slopes_go_on_where_another_preparation_serves_a_gap():
    """At 2 mm, as wide as coils are deep: change of preparation has no part in differences, which was a slope twice."""
    wide, one = ONE.replace("turns=5", "turns=12"), np.ones((2, 1, 1))
    each = [signal_slopes(on_x(half, wide, 'elastomer.width="30 mm"'), one, 0.1)[0] for half in (5e-3, 5.02e-3)]
    before, after = (S[0, 0, 1, :3] for S in each)
    assert np.all(np.abs(after / before - 1.0) < 0.05)


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
