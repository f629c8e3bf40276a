"""Arguments of public functions of another kind than their signatures say are refused in one line."""

import inspect
from pathlib import Path

import pytest

import sits_mech as sm
from sits_mech.arguments import _KINDS

FUNCTIONS = [name for name in sm.__all__ if inspect.isfunction(getattr(sm, name))]
CASES = [
    (name, key) for name in FUNCTIONS for key, each in inspect.signature(getattr(sm, name)).parameters.items()
    if str(each.annotation).replace(" | None", "") in _KINDS
]


@pytest.mark.parametrize(("name", "key"), CASES)
def test_an_argument_of_another_kind_is_refused_by_its_name(name: str, key: str) -> None:
    """Before anything is computed, whatever else is missing."""
    function = getattr(sm, name)
    needed = [each for each, one in inspect.signature(function).parameters.items() if one.default is one.empty]
    others = dict.fromkeys([each for each in needed if (name, each) not in CASES])
    for wrong in (float("nan"), object(), [[1]], *["closed"] * (key == "idle")):
        with pytest.raises(sm.SceneError, match=f"^{key}: must be .*; got ") as refused:
            function(**{key: wrong}, **others)
        assert len(str(refused.value).splitlines()) == 1


def test_every_public_function_of_a_sensor_is_checked() -> None:
    """None was forgotten."""
    takes = {name for name in FUNCTIONS if "Sensor" in str(inspect.signature(getattr(sm, name)))}
    assert {"simulate", "calibrate", "plan", "envelope", "slopes", "spectrum"} <= takes
    assert [name for name in takes if not hasattr(getattr(sm, name), "__wrapped__")] == []


def test_what_is_of_its_kind_passes(tmp_path: Path) -> None:
    """Texts and paths, lists, tuples and what is read once, a pair as a calibration, None where it may be."""
    sensor = sm.load_sensor("biorob2018", ('target.width="10 mm"',))
    assert sm.load_sensor("biorob2018", iter(['target.width="10 mm"'])) == sensor
    sm.save_sensor(sensor, tmp_path / "scene.toml")
    assert sm.load_sensor(tmp_path / "scene.toml").target == sensor.target
    with pytest.raises(sm.SceneError, match="calibration: must be the folder of a calibration, or its Sensor and"):
        sm.quality((sensor, sensor))
