"""Numbers of a scene that answers are differentiated by: what a change of one makes, differences, refusals."""

import numpy as np
import pytest

from sits_mech.scene.parameters import keys_of, parameter, value_of
from sits_mech.scene.sensor import SceneError, load_sensor


def test_keys_stand_for_numbers_of_the_scene() -> None:
    """A length, one of all coils, a constant of a catalogued silicone and of a list; the scene stays as it is."""
    sensor = load_sensor("biorob2018")
    assert parameter(sensor, "elastomer.thickness").changed(1e-4).elastomer.thickness == pytest.approx(2.1e-3)
    both = parameter(sensor, "coils.*.inner_diameter").changed(1e-4)
    assert [coil.inner_diameter for coil in both.coils] == pytest.approx([2.3e-3, 2.3e-3])
    one = parameter(sensor, "coils.C2.track_width").changed(1e-5)
    assert [coil.track_width for coil in one.coils] == pytest.approx([1e-4, 1.1e-4])
    assert sensor.elastomer.thickness == 2e-3
    c10 = parameter(sensor, "elastomer.material.c10")
    assert c10.changed(100.0).elastomer.silicone.constants["c10"] == pytest.approx(c10.value + 100.0)
    law = 'elastomer.material={law="ogden", mu=[3e4, 1e3], alpha=[2.0, -2.0], bulk_modulus=3e7}'
    ogden = parameter(load_sensor("biorob2018", [law]), "elastomer.material.mu.1")
    assert ogden.changed(500.0).elastomer.silicone.constants["mu"] == (3e4, 1500.0)


def test_the_modulus_is_a_factor_of_all_stresses() -> None:
    """Of the shear modulus, of every constant that is a stress; the bulk modulus stays."""
    sensor = load_sensor("biorob2018")
    stiffer, old = parameter(sensor, "modulus").changed(0.1).elastomer.silicone, sensor.elastomer.silicone
    assert stiffer.shear_modulus == pytest.approx(1.1 * old.shear_modulus, rel=1e-14)
    assert stiffer.bulk_modulus == old.bulk_modulus
    assert all(stiffer.constants[name] == pytest.approx(1.1 * value) for name, value in old.constants.items())


def test_a_target_that_is_loaded_on_top_gets_thicker_with_its_load() -> None:
    """The height of the load follows the thickness unless the scene gives it."""
    sensor = load_sensor("biorob2018")
    assert parameter(sensor, "target.thickness").changed(1e-4).target.load_height == pytest.approx(3e-4)


@pytest.mark.parametrize("name", ["elastomer.thickness", "elastomer.standoff"])
def test_derivatives_are_of_second_order_on_both_sides_and_on_one(name: str) -> None:
    """A stand-off of zero has one side; a cubic is off by h^2: nothing beside 1."""
    found = parameter(load_sensor("biorob2018"), name)

    def cubic(sensor) -> float:
        x = (getattr(sensor.elastomer, name.split(".")[1]) - found.value) / 1e-3
        return 1.0 + 2e-3 * x + 0.1 * x**2 + x**3

    places, own = found.stencil()
    assert len(places) == 2
    assert (own == 0.0) == (name == "elastomer.thickness")
    assert sum(weight * cubic(sensor) for sensor, _, weight in places) + own == pytest.approx(2.0, rel=1e-5)


def test_a_kind_of_scene_that_is_on_one_side_alone() -> None:
    """Such as targets no wider than their pad; none at all is refused."""
    found = parameter(load_sensor("biorob2018"), "target.width")
    places, _ = found.stencil(lambda sensor: sensor.target.width <= found.value)
    assert [sensor.target.width < found.value for sensor, *_ in places] == [True, True]
    assert sum(weight * sensor.target.width for sensor, _, weight in places) < 0.0
    with pytest.raises(SceneError, match=r"target.width: must be a number that can be changed a little"):
        found.stencil(lambda _: False)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("coils.0.turns", r"coils\.C1\.turns: must be a number that can go up and down a little; got 12"),
        ("coils.*.turns", r"coils\.C1\.turns: must be a number that can go up and down a little; got 12"),
        ("coils.*.centre", r"coils\.C1\.centre: must be a number that can go up"),
        ("target.material", r'target\.material: must be a number .* got "copper"'),
        ("elastomer.hight", r"elastomer\.hight: must be a number that the scene gives"),
        ("coils.C9.inner_diameter", r"coils\.C9\.inner_diameter: must be a number that the scene gives"),
        ("conductors.*.width", r"conductors\.\*\.width: must be a number that the scene gives"),
    ],
)
def test_what_is_no_number_is_refused(name: str, words: str) -> None:
    """Counts, texts, keys that are not there: by their name, in one line."""
    with pytest.raises(SceneError, match=f"^{words}") as error:
        parameter(load_sensor("biorob2018"), name)
    assert "\n" not in str(error.value)


def test_a_star_is_every_entry_of_a_list() -> None:
    """Coils move together, each from where it is; by the largest of them the step is."""
    sensor = load_sensor("biorob2018", ['coils.C2.centre.0="3 mm"'])
    found = parameter(sensor, "coils.*.centre.0")
    assert found.numbers == (("coils.C1.centre.0", -4e-3), ("coils.C2.centre.0", 3e-3))
    assert found.step == pytest.approx(4e-9)
    assert [coil.centre[0] for coil in found.changed(1e-4).coils] == pytest.approx([-3.9e-3, 3.1e-3])
    assert list(found.scenes((1, 3))) == [1, 3]
    assert parameter(sensor, "coils.C1.centre.0").numbers == parameter(sensor, "coils.0.centre.0").numbers


def test_names_that_look_like_numbers_of_a_list_are_names() -> None:
    """Coils "1" and "0": a number is read and changed where a scene file would set it."""
    sensor = load_sensor("biorob2018", ['coils.C1.name="1"', 'coils.C2.name="0"', 'coils.0.track_width="0.09 mm"'])
    narrow = parameter(sensor, "coils.0.track_width")
    assert narrow.value == 9e-5
    assert [coil.track_width for coil in narrow.changed(1e-6).coils] == pytest.approx([1e-4, 9.1e-5])
    both = parameter(sensor, "coils.*.track_width").changed(1e-6)
    assert [coil.track_width for coil in both.coils] == pytest.approx([1.01e-4, 9.1e-5])
    dotted = parameter(load_sensor("biorob2018", ['coils.C2.name="U2.L"']), "coils.*.track_width").changed(1e-6)
    assert [coil.track_width for coil in dotted.coils] == pytest.approx([1.01e-4, 1.01e-4])


def test_values_by_keys() -> None:
    """Lengths, counts, entries of a list, constants of a catalogued silicone; no texts, nothing that is not there."""
    sensor = load_sensor("biorob2018")
    assert value_of(sensor, "target.width") == 8e-3
    assert value_of(sensor, "coils.*.turns") == 12.0
    assert value_of(sensor, "coils.C2.centre.0") == 4e-3
    assert value_of(sensor, "elastomer.material.c10") == sensor.elastomer.silicone.constants["c10"]
    for key in ("target.material", "coils.*.centre", "coils.C9.turns", "elastomer.hight", "target.width.0"):
        assert value_of(sensor, key) is None
    welded = sensor.model_copy(update={"elastomer": sensor.elastomer.model_copy(update={"weld": True})})
    assert value_of(welded, "elastomer.weld") is None
    assert value_of(sensor.model_copy(update={"elastomer": None}), "elastomer.material.c10") is None
    assert keys_of(sensor, "coils.*.layer_z") == ["coils.C1.layer_z", "coils.C2.layer_z"]
    assert keys_of(sensor, "elastomer.material") == ["elastomer.material"]


def test_a_scene_without_a_silicone_has_no_modulus() -> None:
    """Said by name."""
    sensor = load_sensor("biorob2018").model_copy(update={"elastomer": None})
    with pytest.raises(SceneError, match="modulus: needs an elastomer"):
        parameter(sensor, "modulus")
    assert np.isfinite(parameter(sensor, "target.width").value)


def test_a_silicone_may_stiffen_more() -> None:
    """By a square of the first invariant that is no number of the scene; small strain stays as it is."""
    sensor = load_sensor("biorob2018")
    other = parameter(sensor, "stiffening").changed(0.1).elastomer.silicone
    c10, c20 = (sensor.elastomer.silicone.constants[name] for name in ("c10", "c20"))
    assert other.constants["c20"] == pytest.approx(c20 + 0.1 * c10)
    assert other.shear_modulus == sensor.elastomer.silicone.shear_modulus
