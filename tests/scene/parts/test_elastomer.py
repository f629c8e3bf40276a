"""Layers of every shape: where pillars stand, by hand; what is refused."""

import math

import pytest

from sits_mech.scene.parts.elastomer import Elastomer, pad_volume, pillar_middles
from sits_mech.scene.sensor import SceneError, changed, load_sensor, scene_text

PILLARS = 'elastomer={material="rtv615", shape="pillars", pitch="2.5 mm", diameter="1.5 mm", thickness="2 mm"}'


def pillars(**keys):
    table = {"material": "rtv615", "shape": "pillars", "pitch": 2.5e-3, "diameter": 1.5e-3, "thickness": 2e-3}
    return Elastomer.model_validate({"width": 8e-3, "length": 8e-3} | table | keys)


@pytest.mark.parametrize(
    ("keys", "extent", "is_round", "count"),
    [
        ({}, (8e-3, 8e-3), False, 9),  # 1.5 + 2 * 2.5 = 6.5 mm of 8
        ({"width": 9e-3}, (9e-3, 8e-3), False, 12),  # 1.5 + 3 * 2.5 = 9.0 mm: they just fit
        ({"width": 8.99e-3}, (9e-3, 8e-3), False, 9),
        ({}, (8e-3, 8e-3), True, 5),  # a corner's reaches to 3.54 + 0.75 = 4.29 mm
        ({}, (8.58e-3, 8.58e-3), True, 9),
        ({"width": 20e-3, "length": 20e-3}, (8e-3, 8e-3), False, 4),  # eight by eight, four of them under the target
    ],
)
def test_pillars_that_stand_wholly_under_the_target(keys, extent, is_round, count):
    found = pillar_middles(pillars(**keys), extent, is_round)
    assert len(found) == count
    assert {(-x, y) for x, y in found} == {(x, -y) for x, y in found} == set(found)


def test_pillars_fill_what_is_under_the_target_and_follow_it():
    sensor = load_sensor("biorob2018", [PILLARS])
    assert sensor.elastomer.extent == sensor.target.extent == (8e-3, 8e-3)
    wider = changed(sensor, ['target.width="12 mm"'])
    assert wider.elastomer.extent == (12e-3, 8e-3)
    kept = changed(changed(sensor, ['elastomer.width="6 mm"', 'elastomer.length="8 mm"']), ['target.width="12 mm"'])
    assert kept.elastomer.extent == (6e-3, 8e-3)
    assert "width" not in scene_text(sensor).split("[elastomer]")[1]


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"pitch": None}, "pitch must be given for pillars; it is missing"),
        ({"diameter": None}, "diameter must be given for pillars; it is missing"),
        ({"pitch": 1.5e-3}, r"pitch must be larger than diameter \(1.5 mm\); got 1.5 mm"),
        ({"shape": "box"}, "diameter must not be given for a box; got 0.0015"),
        ({"shape": None}, "width must not be given for a cylinder"),
        ({"standoff": 2.1e-3}, r"no thicker than the layer \(thickness 2 mm\); got 2.1 mm"),
    ],
)
def test_refusals(keys, said):
    with pytest.raises(ValueError, match=said):
        pillars(**keys)


def test_a_target_over_no_pillar_is_refused():
    with pytest.raises(SceneError, match="must have a pillar of diameter 1.5 mm wholly under the target, 1 mm"):
        load_sensor("biorob2018", [PILLARS, 'target.width="1 mm"'])


def test_volume_of_each_shape():
    """By hand: 20 x 10 x 2 mm; pi/4 d^2 t of a cylinder; the nine pillars that stand under the target."""
    box = Elastomer(material="ecoflex-00-30", width=20e-3, length=10e-3, thickness=2e-3)
    assert pad_volume(box, (8e-3, 8e-3), False) == pytest.approx(4e-7)
    cylinder = Elastomer(material="ecoflex-00-30", diameter=2e-3, thickness=3e-3)
    assert pad_volume(cylinder, (8e-3, 8e-3), False) == pytest.approx(math.pi * 3e-9)
    assert pad_volume(pillars(), (8e-3, 8e-3), False) == pytest.approx(9 * math.pi / 4 * 1.5e-3**2 * 2e-3)


SHEETS = [{"material": "dragon-skin-30", "thickness": "1 mm"}, {"material": "ecoflex-00-30", "thickness": "3 mm"}]


def layers(*more, **keys):
    """A pad of two layers, or with other ones."""
    pad = {"width": "12 mm", "length": "10 mm", "layers": [*SHEETS, *more]} | keys
    return Elastomer.model_validate(pad)


def test_layers_have_a_height_and_moduli_in_series():
    pad, (stiff, soft) = layers(), (each.silicone for each in layers().stack)
    assert pad.thickness == pytest.approx(4e-3) and pad.interfaces == pytest.approx((1e-3,))
    assert pad.shear_modulus == pytest.approx(4.0 / (1.0 / stiff.shear_modulus + 3.0 / soft.shear_modulus))
    assert pad.bulk_modulus == pytest.approx(4.0 / (1.0 / stiff.bulk_modulus + 3.0 / soft.bulk_modulus))
    thick = pad.of_thickness(8e-3)
    assert [each.thickness for each in thick.layers] == pytest.approx([2e-3, 6e-3]) and thick.thickness == 8e-3
    assert pad.words == "1 mm dragon-skin-30, 3 mm ecoflex-00-30"


def test_one_layer_is_a_pad_of_one_silicone():
    one, plain = (
        Elastomer.model_validate({"width": "8 mm", "length": "8 mm"} | keys)
        for keys in ({"layers": SHEETS[1:]}, {"material": "ecoflex-00-30", "thickness": "3 mm"})
    )
    assert one.stack == plain.stack and one.silicone == plain.silicone and one.shear_modulus == plain.shear_modulus


def test_a_scene_of_layers_is_written_and_read_back_and_changed_by_key():
    sheets = ", ".join(f'{{material="{each["material"]}", thickness="{each["thickness"]}"}}' for each in SHEETS)
    sensor = load_sensor("biorob2018", [f'elastomer={{width="20 mm", length="20 mm", layers=[{sheets}]}}'])
    assert "[[elastomer.layers]]" in scene_text(sensor) and "free_stretch" not in scene_text(sensor)
    assert changed(sensor, []) == sensor
    assert changed(sensor, ['elastomer.layers.1.thickness="2 mm"']).elastomer.thickness == pytest.approx(3e-3)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ('elastomer.layers.1.thickness="0 mm"', "elastomer.layers.1.thickness: must be a length from 1 nm to 1 km"),
        ('elastomer.layers.1.thickness="1 um"', "layers.1.thickness must be at least 0.001 of the pad's, 1.001 mm"),
        ("elastomer.layers.1.material=ecoflex", "elastomer.layers.1.material: must be one of ecoflex-00-10"),
        ('elastomer.thickness="2 mm"', 'elastomer: thickness must be left out beside layers, each of which has'),
        ("elastomer.material=rtv615", 'elastomer: material must be left out beside layers, each of which has'),
        ("elastomer.free_stretch=1.01", "elastomer: free_stretch must be left out beside layers"),
        ('elastomer.edge_radius="0.1 mm"', "elastomer: edge_radius must be left out beside layers, whose edges are"),
        ("elastomer.mesh=pad.msh", "elastomer: mesh must be left out beside layers, which are meshed here"),
        ("elastomer.layers=3", r"elastomer.layers: must be a list of tables, as under \[\[elastomer.layers\]\]; got 3"),
        ("elastomer.layers=[]", "elastomer.material: must be given; it is missing"),
        ("elastomer.layers=[{thickness=1e-3}]", "elastomer.layers.0.material: must be given; it is missing"),
    ],
)
def test_refusals_of_layers(override, said):
    sheets = '{material="rtv615", thickness="1 mm"}'
    sensor = load_sensor("biorob2018", [f'elastomer={{width="20 mm", length="20 mm", layers=[{sheets}, {sheets}]}}'])
    with pytest.raises(SceneError, match=said) as refusal:
        changed(sensor, [override])
    assert "\n" not in str(refusal.value)
