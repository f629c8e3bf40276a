"""A scene at a temperature: each number against its coefficient by hand; what is not known is refused by name."""

import numpy as np
import pytest

from sits_mech.scene.parameters import TEMPERATURE, parameter
from sits_mech.scene.sensor import REFERENCE, SceneError, Sensor, load_sensor, scene_text
from sits_mech.scene.thermal import (
    CAUSES,
    at_temperature,
    check_temperature,
    clock_factor,
    unknown_coefficients,
    warmed,
)

WARM = REFERENCE + 40.0


def sensor(*keys: str) -> Sensor:
    """Return the two-coil sensor with keys changed."""
    return load_sensor("biorob2018", keys)


def test_every_number_by_its_coefficient() -> None:
    """40 K: copper 3930 and 17.3 ppm/K, silicone 300 ppm/K and entropic, board 16 and 50 ppm/K, capacitor as given."""
    cold = sensor('readout.capacitance_coefficient="-30 ppm/K"')
    warm = at_temperature(cold, WARM)
    resistive, grown, across, up = 1 + 40 * 3.93e-3, 1 + 40 * 1.73e-5, 1 + 40 * 16e-6, 1 + 40 * 50e-6
    assert warm.target.metal.conductivity == pytest.approx(5.8e7 / resistive, rel=1e-14)
    assert warm.coils[0].conductivity == pytest.approx(5.8e7 / resistive, rel=1e-14)
    assert [warm.target.width, warm.target.thickness] == pytest.approx([8e-3 * grown, 0.2e-3 * grown], rel=1e-14)
    assert warm.target.load_height == warm.target.thickness
    assert warm.elastomer.thickness == pytest.approx(2e-3 * grown, rel=1e-14)
    assert warm.elastomer.free_stretch == pytest.approx((1 + 40 * 3e-4) / grown, rel=1e-14)
    stiff = warm.elastomer.silicone.shear_modulus / cold.elastomer.silicone.shear_modulus
    assert stiff == pytest.approx(WARM / REFERENCE, rel=1e-14)
    assert warm.elastomer.silicone.bulk_modulus == cold.elastomer.silicone.bulk_modulus
    coil = warm.coils[0]
    assert (coil.centre[0], coil.track_width) == pytest.approx((-4e-3 * across, 0.1e-3 * across), rel=1e-14)
    assert (coil.layer_pitch, coil.track_thickness) == pytest.approx((85e-6 * up, 35e-6 * up), rel=1e-14)
    assert warm.readout.parallel_capacitance == pytest.approx(330e-12 * (1 - 40 * 30e-6), rel=1e-14)


def test_a_sensor_at_a_temperature_is_a_sensor() -> None:
    """Its scene is plain: at 20 degC, the same again, and one that a file holds; 20 degC changes nothing."""
    warm = at_temperature(sensor('temperature="60 degC"'))
    assert warm.temperature == REFERENCE and at_temperature(warm) is warm
    text = scene_text(warm)
    assert "free_stretch" in text and "temperature = " not in text.replace("_temperature", "")
    assert at_temperature(sensor(), REFERENCE) == sensor()
    assert scene_text(sensor('temperature="20 degC"')) == scene_text(sensor())
    assert "temperature = 333.15" in scene_text(sensor('temperature="60 degC"'))


def test_causes_alone_change_their_own_parts() -> None:
    """Pad, modulus, board, ... one after the other; all of them together are the whole."""
    cold = sensor('readout.capacitance_coefficient="-30 ppm/K"')
    parts = {"conductivity": {"target", "coils"}, "plates": {"target", "elastomer"}, "pad": {"elastomer"},
             "modulus": {"elastomer"}, "board": {"coils"}, "capacitor": {"readout"}, "clock": set()}
    assert set(parts) == set(CAUSES)
    for cause, changed in parts.items():
        warm = warmed(cold, {cause: WARM - REFERENCE})
        own = {part for part in ("target", "coils", "elastomer", "readout")
               if getattr(warm, part).__repr__() != getattr(cold, part).__repr__()}
        assert own == changed, cause


def test_parameters_stand_for_causes_at_the_scenes_temperature() -> None:
    """The free stretch goes by 300 ppm/K over that of the target; the resistivity's slope is that at 60 degC."""
    warm = sensor('temperature="60 degC"')
    pad, metal = (parameter(warm, TEMPERATURE + cause) for cause in ("pad", "conductivity"))
    assert pad.scene == at_temperature(warm) == metal.scene
    for number, of, expected in (
        (pad, lambda s: s.elastomer.free_stretch, 3e-4 / (1 + 40 * 1.73e-5)),
        (metal, lambda s: np.log(s.target.metal.conductivity), -3.93e-3 / (1 + 40 * 3.93e-3)),
    ):
        stencil = number.stencil()
        slope = sum(place.weight * of(place.sensor) for place in stencil.places) + stencil.own * of(number.scene)
        assert slope == pytest.approx(expected, rel=1e-7)
    with pytest.raises(SceneError, match=r"temperature\.wind: must be one of temperature\.conductivity"):
        parameter(warm, "temperature.wind")
    warmer = parameter(warm, "elastomer.thickness")  # of the scene as it is at its temperature
    assert warmer.value == pytest.approx(2e-3 * (1 + 40 * 1.73e-5), rel=1e-12)


@pytest.mark.parametrize(
    ("keys", "kelvin", "said"),
    [
        ((), 473.0, "temperature: must be from -40 degC to 150 degC, where what is known of elastomer: ecoflex-00-30"),
        ((), 200.0, "temperature: must be from -55 degC to 200 degC, where what is known of target: copper holds"),
        (("target.material=brass",), 300.0, "target.temperature_coefficient: must be given for a temperature other"),
        (("target.conductivity=3e7",), 300.0, "target.temperature_coefficient: must be given"),
        (("coils.C1.conductivity=3e7",), 300.0, r"coils.C1.temperature_coefficient: must be given"),
        (('elastomer.material={law="neo-hookean",shear_modulus="20 kPa",bulk_modulus="20 MPa"}',), 300.0,
         "elastomer.material.expansion: must be given"),
    ],
)
def test_what_is_not_known_is_named(keys: tuple[str, ...], kelvin: float, said: str) -> None:
    """One line: which input, what it must be, what came; at 20 degC nothing is asked."""
    scene = sensor(*keys)
    check_temperature(scene, REFERENCE)
    with pytest.raises(SceneError, match=said) as error:
        at_temperature(scene, kelvin)
    assert "\n" not in str(error.value) and f"{kelvin - 273.15:.6g} degC" in str(error.value)
    assert bool(unknown_coefficients(scene)) == bool(keys)


def test_given_coefficients_take_the_place_of_the_catalogues() -> None:
    """Steel as a fixed plate: resistivity, permeability and size by its own; its place stays."""
    steel = ('{name="bed",shape="rectangle",centre=["0 mm","-4 mm"],width="20 mm",length="20 mm",thickness="1 mm",'
             'conductivity="6 MS/m",relative_permeability=100.0,temperature_coefficient="5000 ppm/K",'
             'permeability_coefficient="1000 ppm/K",expansion="12 ppm/K"}')
    warm = at_temperature(sensor(f"conductors=[{steel}]"), REFERENCE + 10.0).conductors[0]
    assert warm.metal.conductivity == pytest.approx(6e6 / 1.05, rel=1e-14)
    assert warm.metal.relative_permeability == pytest.approx(101.0, rel=1e-14)
    assert warm.width == pytest.approx(20e-3 * (1 + 12e-5), rel=1e-14) and warm.centre == (0.0, 0.0, -4e-3)


def test_the_clock_runs_by_its_coefficient() -> None:
    scene = sensor('readout.clock_coefficient="2 ppm/K"', 'temperature="30 degC"')
    assert clock_factor(scene) == pytest.approx(1.0 + 2e-5, rel=1e-12)


@pytest.mark.parametrize(("text", "kelvin"), [('"-10 degC"', 263.15), ('"300 K"', 300.0), ('"68 degF"', 293.15)])
def test_temperatures_are_written_in_any_unit(text: str, kelvin: float) -> None:
    assert sensor(f"temperature={text}").temperature == pytest.approx(kelvin, rel=1e-12)
