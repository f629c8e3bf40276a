"""Numbers of a scene by key: found, moved, refused."""

from __future__ import annotations

import pytest

from sits_mech.scene.lengths import moved, numbers_at
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


def test_found(sensor: Sensor) -> None:
    assert numbers_at(sensor, "target.width") == (("target.width", 8e-3),)
    assert numbers_at(sensor, "coils.*.track_width") == (("coils.0.track_width", 1e-4), ("coils.1.track_width", 1e-4))
    first = sensor.coils[0].name
    assert numbers_at(sensor, f"coils.{first}.centre.0") == (("coils.0.centre.0", -4e-3),)


def test_moved(sensor: Sensor) -> None:
    found = moved(sensor, ["coils.*.inner_diameter"], 1e-5)
    assert [coil.inner_diameter for coil in found.coils] == pytest.approx([2.21e-3] * 2)
    assert found.target == sensor.target
    thicker = moved(sensor, ["target.thickness"], 1e-5).target
    assert thicker is not None and thicker.thickness == pytest.approx(2.1e-4)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("target.nope", '"target.nope" must be a number that the scene gives'),
        ("coils.7.track_width", '"coils.7.track_width" must be a number'),
        ("coils.*.turns", "coils.0.turns must be a number that can go up and down a little; got 12"),
        ("target.material", 'target.material must be a number .* got "copper"'),
        ("coils.*.centre", "coils.0.centre must be a number"),
    ],
)
def test_refused(sensor: Sensor, key: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        numbers_at(sensor, key)


def test_what_cannot_be_is_refused(sensor: Sensor) -> None:
    with pytest.raises(SceneError, match="target"):
        moved(sensor, ["target.thickness"], -1.0)
