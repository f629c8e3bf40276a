"""The fields of the form, by the scene's schema; their elements are tested in a browser (test_studio.py)."""

from sits_mech.scene.parameters import numbers_of
from sits_mech.scene.sensor import load_sensor
from sits_mech.studio.form import form_entry, slider_range


def test_every_key_of_a_scene_is_described() -> None:
    """Units, choices, bounds and meaning; nothing of a key that the schema does not know."""
    thickness, shape = form_entry("elastomer.thickness"), form_entry("elastomer.shape")
    assert thickness["x-unit"] == "m" and thickness["minimum"] == 1e-9 and "z" in thickness["description"]
    assert shape["enum"] == ["box", "cylinder", "pillars"] and form_entry("coils.1.turns")["type"] == "integer"
    assert "ecoflex-00-30" in form_entry("elastomer.material")["enum"] and form_entry("elastomer.nothing") == {}
    layers = '[{material="rtv615", thickness="1 mm"}, {material="ecoflex-00-30", thickness="1 mm"}]'
    layered = load_sensor("biorob2018", [f'elastomer={{width="20 mm", length="20 mm", layers={layers}}}'])
    for sensor in (load_sensor("biorob2018-w15"), load_sensor("triaxial-4"), layered):
        for key in numbers_of(sensor):
            assert form_entry(key), key
    assert form_entry("elastomer.layers.1.thickness")["x-unit"] == "m"


def test_a_slider_of_turns_stops_at_every_number() -> None:
    """From half of an odd number too, and from one on."""
    assert slider_range("coils.*.turns", 25.0) == (12.0, 50.0, 1.0) and slider_range("coils.*.turns", 1.0)[0] == 1.0
    assert slider_range("target.width", 0.01)[:2] == (0.005, 0.02)
