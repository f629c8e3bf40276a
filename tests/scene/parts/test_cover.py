"""Covers of targets: sizes, what they are bonded on, and scenes that have none to be bonded on."""

import pytest

from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import (
    SceneError,
    check_provenance,
    load_sensor,
    provenance,
    scene_table,
    sensor_from,
    silicone_of,
    silicones_of,
)
from sits_mech.scene.thermal import at_temperature

COVER = 'cover={material="dragon-skin-30", thickness="1 mm", overhang="1.5 mm"}'
DISC = 'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}'
CYLINDER = 'elastomer={material="ecoflex-00-30", diameter="14 mm", thickness="2 mm"}'


def covered(*keys):
    return load_sensor("biorob2018", [COVER, *keys])


def test_a_cover_is_read_and_written():
    sensor = covered()
    assert sensor_from(scene_table(sensor)) == sensor
    assert scene_table(sensor)["cover"] == {"material": "dragon-skin-30", "thickness": 1e-3, "overhang": 1.5e-3}
    assert [each.name for each in silicones_of(sensor)] == ["ecoflex-00-30", "dragon-skin-30"]
    assert "cover" not in scene_table(load_sensor("biorob2018"))


@pytest.mark.parametrize(("keys", "size"), [
    ((), (11e-3, 11e-3)), ((DISC, CYLINDER), (11e-3, 11e-3)),
    (('elastomer.length="8 mm"',), (11e-3, 8e-3)),
])
def test_a_cover_reaches_beyond_the_target_where_there_is_pad(keys, size):
    sensor = covered(*keys)
    assert sensor.cover.extent(sensor.target, sensor.elastomer) == pytest.approx(size)


@pytest.mark.parametrize(("keys", "said"), [
    (('cover.thickness="0 mm"',), 'cover.thickness: must be a length from 1 nm to 1 km, such as "2 mm"; got "0 mm"'),
    (('cover.overhang="-1 mm"',), 'cover.overhang: must be a length from 1 nm to 1 km, such as "2 mm"; got "-1 mm"'),
    (('cover.overhang="7 mm"',), "cover.overhang must be at most 0.006 m, or it reaches beyond the pad; got 0.007 m"),
    (('cover.material="jelly"',), "cover.material: must be one of .*; got \"jelly\""),
    (('cover.thickness="1 um"',), "cover.thickness must be at least 0.001 of the pad's thickness, 2e-06 m"),
    (('target.thickness="1 um"',), "target.thickness must be at least 0.001 of the pad's thickness"),
    (('target.width="20 mm"', 'target.length="20 mm"'), "cover must have pad around the target to be bonded on; a "
     "target of 0.02 x 0.02 m covers one of 0.02 x 0.02 m"),
    (('target.width="22 mm"',), "cover must have pad around the target"),
    (('elastomer.edge_radius="0.3 mm"',), "elastomer.edge_radius must be left out under a cover; got 0.0003"),
    (('elastomer.shape="pillars"', 'elastomer.pitch="2 mm"', 'elastomer.diameter="1 mm"'),
     "elastomer.shape must be 'box' or 'cylinder' under a cover; got 'pillars'"),
    ((DISC, 'elastomer.width="11 mm"'), "cover.overhang must be at most 0.001425 m"),  # 0.95 of 1.5 mm
    ((CYLINDER, 'target.width="8 mm"', 'target.length="8 mm"'), "cover.overhang must be at most 0.00090226 m"),
    (('target={material="copper", shape="ring", diameter="8 mm", inner_diameter="4 mm", thickness="0.2 mm"}',),
     "target.shape must be 'rectangle' or 'disc' under a cover; got \"ring\""),
    (('conductors=[{name="nut", material="copper", shape="disc", diameter="1 mm", centre=["0 mm", "3 mm"], '
      'thickness="0.5 mm"}]',), "nut must be clear of cover, which reaches from z = 2 mm to"),
])
def test_what_has_no_place_is_refused_by_its_key(keys, said):
    with pytest.raises(SceneError, match=said.replace("(", r"\(")) as failure:
        covered(*keys)
    assert "\n" not in str(failure.value)


def test_a_cover_needs_pad_and_target():
    table = scene_table(covered())
    for part in ("target", "elastomer"):
        with pytest.raises(SceneError, match=f"cover must have a target and an elastomer .*; {part} is missing"):
            sensor_from({key: item for key, item in table.items() if key != part})


def test_a_cover_goes_with_its_pad_where_silicones_are_changed():
    sensor = covered()
    for name in ("modulus", "stiffening"):
        moved = parameter(sensor, name).changed(1e-3)
        assert moved.cover.silicone.constants != sensor.cover.silicone.constants
    assert parameter(sensor, "cover.thickness").changed(1e-6).cover.thickness == pytest.approx(1.001e-3)
    one = parameter(sensor, "cover.material.c10")
    assert one.changed(10.0).cover.silicone.constants["c10"] == pytest.approx(one.value + 10.0)


def test_a_warm_cover_grows_with_the_target_and_by_its_silicone():
    sensor = load_sensor("biorob2018", [COVER.replace("dragon-skin-30", "ecoflex-00-30")])
    warm = at_temperature(sensor, 333.15)
    grown = warm.target.thickness / sensor.target.thickness
    for key in ("thickness", "overhang"):
        assert getattr(warm.cover, key) == pytest.approx(grown * getattr(sensor.cover, key), rel=1e-12)
    assert warm.cover.free_stretch == pytest.approx(warm.elastomer.free_stretch, rel=1e-12)
    unknown = load_sensor("biorob2018", ['cover={material={law="neo-hookean", shear_modulus=1e4, bulk_modulus=1e6}, '
                                         'thickness="1 mm", overhang="1 mm"}'])
    with pytest.raises(SceneError, match="cover.material.expansion: must be given for a temperature"):
        at_temperature(unknown, 333.15)


def test_tables_are_of_one_cover():
    bare, own = load_sensor("biorob2018"), covered()
    check_provenance(own, provenance(own))
    for other in (bare, covered('cover.thickness="2 mm"')):
        with pytest.raises(SceneError, match="its cover differs"):
            check_provenance(own, provenance(other))


def test_a_cover_that_relaxes_by_itself_is_no_whole_with_its_pad():
    relaxing = '{law="neo-hookean", shear_modulus=2e4, bulk_modulus=1e6, prony=[{weight=0.3, time="0.1 s"}]}'
    with pytest.raises(SceneError, match="cover: must relax alike and have no mullins"):
        silicone_of(covered(f"cover.material={relaxing}"))
