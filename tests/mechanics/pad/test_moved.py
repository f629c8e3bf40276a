"""Pads of other sizes on the same cells: as meshed anew."""

import numpy as np
import pytest

from sits_mech.mechanics.pad.families import pad_family
from sits_mech.mechanics.pad.planar import layer_family
from sits_mech.mechanics.pad.solid import bonded_block, moved_block
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import load_sensor


@pytest.mark.parametrize("whole", [False, True], ids=["half", "whole"])
@pytest.mark.parametrize("name", ["elastomer.thickness", "target.length", "elastomer.material.c10"])
@pytest.mark.parametrize("scene", ["biorob2018-w15", "disc"])
def test_a_moved_mesh_is_the_one_made_anew(scene: str, name: str, whole: bool) -> None:
    """Nodes, gradients, weights, pressures and what is bonded, to rounding: bricks on lines and in rings."""
    round_one = ['target={material="copper", shape="disc", diameter="11 mm", thickness="0.2 mm"}']
    sensor = load_sensor("biorob2018-w15") if scene != "disc" else load_sensor("biorob2018", round_one)
    name = "target.diameter" if scene == "disc" and name == "target.length" else name
    found = parameter(sensor, name)
    other = found.changed(0.01 * found.value)
    body, anew = (bonded_block(each, 1, whole=whole).body for each in (sensor, other))
    moved = moved_block(body, other, (1, 2.0, 0))
    assert (np.max(np.abs(anew.mesh.nodes - body.mesh.nodes)) > 1e-3) == (not name.endswith("c10"))
    np.testing.assert_allclose(moved.mesh.nodes, anew.mesh.nodes, atol=1e-13)
    np.testing.assert_allclose(moved.mesh.inside.slope, anew.mesh.inside.slope, atol=1e-10)
    np.testing.assert_allclose(moved.mesh.inside.weights, anew.mesh.inside.weights, rtol=1e-11)
    np.testing.assert_allclose(moved.mesh.chi, anew.mesh.chi, atol=1e-12)
    np.testing.assert_allclose(moved.X, anew.X, atol=1e-13)
    assert np.array_equal(moved.laws.K, anew.laws.K) and moved.height == anew.height


def test_a_thicker_layer_moves_the_nodes_of_both_and_keeps_their_cells() -> None:
    sheets = '{material="rtv615", thickness="1 mm"}, {material="ecoflex-00-30", thickness="2 mm"}'
    sensor = load_sensor("biorob2018", [f'elastomer={{width="12 mm", length="12 mm", layers=[{sheets}]}}'])
    other = parameter(sensor, "elastomer.layers.0.thickness").changed(1e-4)
    body, anew = (bonded_block(each, 2, layers=1).body for each in (sensor, other))
    moved = moved_block(body, other, (2, 2.0, 1))
    np.testing.assert_allclose(moved.mesh.nodes, anew.mesh.nodes, atol=1e-13)
    np.testing.assert_array_equal(moved.laws.of, anew.laws.of)
    np.testing.assert_allclose(moved.laws.K, anew.laws.K, rtol=1e-12)


def test_other_cells_are_no_moved_ones() -> None:
    """A target of three half thicknesses takes one cell more than a smaller one."""
    sensor = load_sensor("biorob2018", ['target.width="12 mm"'])
    body = bonded_block(sensor, 1).body
    beside = [parameter(sensor, "target.width").changed(way) for way in (-1e-5, 1e-5)]
    assert [moved_block(body, other, (1, 2.0, 0)) is None for other in beside] == [True, False]


@pytest.mark.parametrize("family", [lambda sensor: pad_family(sensor)[0], lambda sensor: layer_family(sensor, True)])
@pytest.mark.parametrize("key", ["target.diameter", "elastomer.thickness", "elastomer.diameter"])
@pytest.mark.parametrize(("target", "pad", "thickness"), [(8, 12, 2), (12, 12, 1), (16, 24, 4), (12, 24, 1)])
def test_round_sizes_keep_their_cells_where_they_change_a_little(family, key, target, pad, thickness) -> None:
    """On one side at least, so that there is a derivative: discs whose cells are as many by one size as by another."""
    sizes = f'elastomer={{material="ecoflex-00-30", diameter="{pad} mm", thickness="{thickness} mm"}}'
    disc = f'target={{material="copper", shape="disc", diameter="{target} mm", thickness="0.2 mm"}}'
    sensor = load_sensor("biorob2018", [sizes, disc])
    levels = family(sensor)
    if not (key == "elastomer.diameter" and target == pad):
        assert parameter(sensor, key).stencil(lambda other: levels.changed(other, 0) is not None).places
