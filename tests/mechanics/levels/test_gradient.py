"""Derivatives of the pose at rest: laws of scaling that hold for every layer, differences of answers, refusals."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.levels.gradient import PoseSlopes
from sits_mech.mechanics.linear import linear_layer, linear_pad
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Equilibrium, Wrench
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

LEVER = np.array([1.0, 1.0, 5e-3, 1.0, 5e-3, 5e-3])  # of the components of a pose: half the target [m]
LENGTHS = (
    "elastomer.thickness", "elastomer.width", "elastomer.length", "elastomer.standoff", "target.width",
    "target.length", "target.thickness",
)
MODELS = {
    "block": lambda sensor: block_pad(sensor, 1e-2).rough,
    "planar": lambda sensor: planar_layer(sensor, 1e-2).rough,
    "linear": lambda sensor: linear_pad(sensor, 0.1),
    "linear layer": lambda sensor: linear_layer(sensor, 0.1),
}
LOAD = Wrench(F_x=0.3, F_z=1.5, M=5e-4)


def wide(*more: str) -> Sensor:
    """A pad whose cells do not change in number beside it."""
    return load_sensor("biorob2018-w15", ['elastomer.standoff="0.1 mm"', 'target.width="14 mm"', *more])


@cache
def at_rest(model: str, load: Wrench) -> tuple[Any, Equilibrium]:
    """A model of the wide pad, and where its target rests: solved once for all tests."""
    layer = MODELS[model](wide())
    return layer, layer.equilibrium(load)


def rested(model: str, sensor: Sensor, load: Wrench, names: tuple[str, ...]) -> tuple[Equilibrium, PoseSlopes]:
    """A pose with its derivatives."""
    if sensor == wide():
        layer, found = at_rest(model, load)
    else:
        layer = MODELS[model](sensor)
        found = layer.equilibrium(load)
    return found, layer.slopes(found, [parameter(sensor, name) for name in names])


def apart(one: Array, other: Array) -> float:
    """How far derivatives differ, over the largest, angles at the target's end."""
    lever = LEVER[: len(one)]
    return float(np.max(np.abs(one - other) * lever) / np.max(np.abs(other) * lever))


@pytest.mark.parametrize("model", MODELS)
def test_twice_the_modulus_under_twice_the_load_is_the_same_pose(model: str) -> None:
    """Euler's theorem on stresses: modulus d/dmodulus + K d/dK + sum F d/dF = 0, of any law."""
    load = LOAD if "linear" not in model else Wrench(F_x=0.02, F_z=0.1, M=5e-5)
    names = ("modulus", "elastomer.material.bulk_modulus")
    _, found = rested(model, wide(), load, names)
    values = [1.0, wide().elastomer.silicone.bulk_modulus]
    by_load = found.compliance[:, :3] @ load.components[:3]
    rest = (found.pose @ values + by_load)[:3] * LEVER[:3]
    assert np.max(np.abs(rest)) < 1e-6 * np.max(np.abs(by_load[:3] * LEVER[:3]))


@pytest.mark.parametrize("model", MODELS)
def test_a_scene_of_twice_the_size_moves_twice_as_far(model: str) -> None:
    """Euler's theorem on lengths: sum l d/dl + 2 sum F d/dF + 3 M d/dM = the pose's lengths; angles stay."""
    sensor = wide()
    load = LOAD if "linear" not in model else Wrench(F_x=0.02, F_z=0.1, M=5e-5)
    found, slopes = rested(model, sensor, load, LENGTHS)
    values = [parameter(sensor, name).value for name in LENGTHS]
    by_load = slopes.compliance[:, :3] @ (load.components[:3] * (2.0, 2.0, 3.0))
    whole = (slopes.pose @ values + by_load)[:3]
    lengths = found.pose.components[:3] * (1.0, 1.0, 0.0)
    size = np.max(np.abs(by_load[:3] * LEVER[:3]))
    np.testing.assert_allclose((whole - lengths) * LEVER[:3], 0.0, atol=2e-6 * size)


@pytest.mark.parametrize(
    ("model", "name"),
    [pytest.param("block", "elastomer.thickness", marks=pytest.mark.slow),
     pytest.param("block", "elastomer.material.c20", marks=pytest.mark.slow),
     ("planar", "target.width"), ("linear layer", "elastomer.width")],
)
def test_derivatives_are_those_of_differences(model: str, name: str) -> None:
    """Of answers made anew, over a step of 1e-3: to 1e-5."""
    sensor = wide()
    load = LOAD if "linear" not in model else Wrench(F_x=0.02, F_z=0.1)
    _, found = rested(model, sensor, load, (name,))
    number = parameter(sensor, name)
    h = 1e-3 * abs(number.value)
    poses = [MODELS[model](number.changed(way * h)).equilibrium(load).pose.components for way in (1, -1, 2, -2)]
    difference = (8.0 * (poses[0] - poses[1]) - (poses[2] - poses[3])) / (12.0 * h)
    assert apart(found.pose[:, 0], difference) < 1e-5


@pytest.mark.slow
def test_a_load_that_leaves_the_plane_turns_the_target_in_space() -> None:
    """All six components of the pose by some of the load and by a length; of a whole pad, to 1e-5."""
    sensor, load = wide(), Wrench(0.2, 1.0, 3e-4, 0.2, 3e-4, 2e-4)
    names = ("elastomer.thickness",)
    found, slopes = rested("block", sensor, load, names)
    layer = MODELS["block"](sensor)
    for k, name in ((0, "F_x"), (2, "M"), (4, "M_x")):
        h = 1e-3 if name.startswith("F") else 1e-6
        both = [load.components + way * h * (np.arange(6) == k) for way in (1.0, -1.0)]
        one, other = (layer.equilibrium(Wrench(*each.tolist()), start=found).pose.components for each in both)
        assert apart(slopes.compliance[:, k], (one - other) / (2.0 * h)) < 1e-5, name
    for k, name in enumerate(names):
        number = parameter(sensor, name)
        h = 1e-4 * number.value
        one, other = (
            MODELS["block"](number.changed(way * h)).equilibrium(load).pose.components for way in (1.0, -1.0)
        )
        assert apart(slopes.pose[:, k], (one - other) / (2.0 * h)) < 1e-5, name


@pytest.mark.slow
def test_half_a_pad_knows_what_its_symmetry_hides() -> None:
    """The compliance sideways of half a pad is that of the whole one near by."""
    layer, found = at_rest("block", LOAD)
    whole = layer.equilibrium(Wrench(*LOAD.components[:3], F_y=1e-6))
    half = layer.slopes(found, [], sideways=True).compliance
    np.testing.assert_allclose(
        half / np.outer(LEVER, LEVER) ** -1, layer.slopes(whole, []).compliance / np.outer(LEVER, LEVER) ** -1,
        atol=1e-5 * np.max(np.abs(half * np.outer(LEVER, LEVER))),
    )
    assert np.all(np.isnan(layer.slopes(found, []).compliance[3:]))


@pytest.mark.slow
def test_finer_levels_count_as_they_do_in_the_pose() -> None:
    """Derivatives on as many levels as the tolerance takes are off by at most three times what they say, and little."""
    sensor, names = wide(), ("elastomer.thickness", "target.width", "modulus")
    slopes = []
    for tolerance in (1e-2, 1e-4, 1e-6):
        layer = planar_layer(sensor, tolerance)
        found = layer.equilibrium(LOAD)
        slopes.append((layer.slopes(found, [parameter(sensor, name) for name in names]), len(found.finer)))
    best, more = slopes.pop()
    assert more > slopes[0][1]
    for found, _ in slopes:
        each = (np.abs(found.pose - best.pose), found.error, np.abs(best.pose))
        off, error, size = (np.max(one[:3] * LEVER[:3, None], axis=0) for one in each)
        assert np.all(off < 3.0 * error)
        assert np.all(error < 1e-2 * size)  # as it was asked


@pytest.mark.slow
def test_a_finer_level_is_differentiated_where_it_rests() -> None:
    """A finest level that is only nearly at rest: by differences of answers made anew, to 1e-4."""
    sensor = wide()
    layer, number = block_pad(sensor, 1e-2), parameter(sensor, "modulus")
    found = layer.equilibrium(LOAD)
    assert len(found.finer) == 1
    one, other = (block_pad(number.changed(way), 1e-2).equilibrium(LOAD).pose.components for way in (1e-3, -1e-3))
    assert apart(layer.slopes(found, [number]).pose[:, 0], (one - other) / 2e-3) < 1e-4


@pytest.mark.slow
def test_a_small_target_is_differentiated_where_its_rims_rest() -> None:
    """Its third level starts from the second; by differences of answers made anew, to a tenth of the error."""
    layer, load = block_pad(load_sensor("biorob2018"), 1e-2), Wrench(F_x=0.3, F_z=1.0)
    number = parameter(layer.sensor, "modulus")
    found = layer.slopes(layer.equilibrium(load), [number])
    one, other = (block_pad(number.changed(way), 1e-2).equilibrium(load).pose.components for way in (1e-3, -1e-3))
    assert np.all(np.abs(found.pose[:3, 0] - (one - other)[:3] / 2e-3) < 0.1 * found.error[:3, 0])


def test_corners_of_a_flush_pad_fold_in_derivatives_as_in_poses() -> None:
    """A square of 8 mm under 0.7 N of shear, x = 0.8: by differences of loads: the order is that of the pose."""
    layer = block_pad(load_sensor("biorob2018", [
        'elastomer={width="8 mm", length="8 mm", thickness="2 mm", contact="never", material={law="neo-hookean", '
        'shear_modulus=3e4, bulk_modulus=1490100.0}}',
    ]), 1e-2)
    found, one, other = (layer.equilibrium(Wrench(F_x=0.7 + way)) for way in (0.0, 1e-3, -1e-3))
    slope = (one.pose.components - other.pose.components) / 2e-3
    assert apart(layer.slopes(found, []).compliance[:3, 0], slope[:3]) < 1e-5


@pytest.mark.slow
def test_a_level_whose_corners_fold_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The third level of a small target is not at rest at its corners: two levels tell, and a larger error.

    A pose in space takes no third level where J foretells such a fold; here it takes one all the same.
    """
    monkeypatch.setattr("sits_mech.mechanics.levels.family._CREASED", 0.0)
    layer = block_pad(load_sensor("biorob2018"), 1e-2)
    found = layer.equilibrium(Wrench(F_x=0.5, F_z=2.0))
    number = parameter(layer.sensor, "modulus")
    assert len(found.finer) == 1
    own, two = (layer.slopes(each, [number]) for each in (found, replace(found, finer=())))
    np.testing.assert_array_equal(own.pose, two.pose)
    assert np.max(own.error[:2]) < 0.03 * np.max(np.abs(own.pose[:2]))


@pytest.mark.slow
@pytest.mark.parametrize("model", ["planar", pytest.param("block", marks=pytest.mark.slow)])
def test_faces_in_contact_move_with_the_cells(model: str) -> None:
    """A flush layer that folds onto its plates, under a load that contact carries: by differences, to 1e-3."""
    sides = [f'{part}.{side}="8.3 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    stiff = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e6}'
    sensor = load_sensor("biorob2018", [*sides, stiff, 'elastomer.contact="always"'])
    load, names = Wrench(F_x=0.5, F_z=8.0), ("elastomer.thickness", "modulus", "target.thickness")
    found, slopes = rested(model, sensor, load, names)
    assert any(note == Note.of(NoteKind.FACE_TOUCHES, surface="ground", friction=0.0) for note in found.report.notes)
    for k, name in enumerate(names):
        number = parameter(sensor, name)
        h = 1e-4 * number.value
        one, other = (
            MODELS[model](number.changed(way * h)).equilibrium(load).pose.components for way in (1.0, -1.0)
        )
        assert apart(slopes.pose[:, k], (one - other) / (2.0 * h)) < 1e-3, name


@pytest.mark.slow
def test_one_side_is_enough_where_the_cells_change_on_the_other() -> None:
    """A target as wide as three thicknesses of half its width takes another cell when it shrinks."""
    sensor = load_sensor("biorob2018-w15", ['target.width="12 mm"'])
    _, found = rested("block", sensor, LOAD, ("target.width",))
    number, h = parameter(sensor, "target.width"), 1e-5
    poses = [MODELS["block"](number.changed(k * h)).equilibrium(LOAD).pose.components for k in range(3)]
    assert apart(found.pose[:, 0], (4.0 * poses[1] - 3.0 * poses[0] - poses[2]) / (2.0 * h)) < 1e-4


@pytest.mark.slow
def test_what_has_no_derivative_is_refused_by_name() -> None:
    """Friction where faces touch: the answer depends on its way."""
    sides = [f'{part}.{side}="8 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    sensor = load_sensor("biorob2018", [*sides, "elastomer.friction=0.3", 'elastomer.contact="always"'])
    layer = MODELS["planar"](sensor)
    found = layer.equilibrium(Wrench(F_z=0.2))
    with pytest.raises(SceneError, match=r"elastomer\.friction: must be 0 for a gradient"):
        layer.slopes(found, [parameter(sensor, "modulus")])
