"""Requests: ranges, choices, what is left out."""

import pytest

from sits_mech.plan import choose_magnetics, choose_mechanics, left_out, quantity_range
from sits_mech.sensor import load_sensor
from sits_mech.units import SceneError


def test_ranges_by_hand() -> None:
    """Ends, count, units; a symmetric one is its own mirror image to the last bit."""
    assert quantity_range("0 N:4 N:5", "N", "--fz") == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert quantity_range("500 mN", "N", "--fz") == [0.5]
    values = quantity_range("-0.7 N:0.7 N:9", "N", "--fx")
    assert values == [-value for value in reversed(values)] and values[4] == 0.0 and values[-1] == 0.7


@pytest.mark.parametrize("text", ["", "1 N:2 N", "1 N:1 N:3", "0 N:1 N:1", "0 N:1 N:two", "0 N:1 mm:3", "0 N:1 N:3:4"])
def test_what_is_no_range(text: str) -> None:
    """One line that names the option."""
    with pytest.raises(SceneError, match="^--fx: must be"):
        quantity_range(text, "N", "--fx")


def test_choices_have_reasons() -> None:
    """What was asked for is taken; auto says why."""
    sensor = load_sensor("biorob2018")
    assert choose_mechanics(sensor, "linear", ("planar", "linear")).reason == "asked for"
    assert choose_mechanics(sensor, "auto", ("planar", "linear")).name == "planar"
    assert choose_mechanics(sensor, "auto", ("planar", "block")).name == "block"
    long = load_sensor("biorob2018", ['elastomer.length="200 mm"'])
    assert choose_mechanics(long, "auto", ("planar", "block")).name == "planar"
    bare = sensor.model_copy(update={"target": None})
    assert "no target" in choose_magnetics(bare, "auto", ("planar",)).reason
    assert any("no target" in text for text in left_out(bare, False))
    assert not any("mechanics" in text for text in left_out(sensor, True))
