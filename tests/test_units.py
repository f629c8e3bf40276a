"""Units that are read at once: the same as pint reads them, and pint stays away."""

import math
import re
import subprocess
import sys

import numpy as np
import pint
import pytest

from sits_mech import units
from sits_mech.batch.requests import SHARE
from sits_mech.units import SceneError, checked_tolerance, is_unit, quantity, quantity_or_range, quantity_range

REGISTRY = pint.UnitRegistry()
NUMBERS = (1.0, 85.0, 0.1, -33.3333, 7.0e-3, 123456.789)


@pytest.mark.parametrize("unit", ["m", "Hz", "N", "Pa", "H", "F", "ohm", "s", "rad"])
@pytest.mark.parametrize("prefix", ["", "G", "M", "k", "m", "u", "µ", "n", "p"])
def test_powers_of_ten_are_as_pint_has_them(prefix: str, unit: str) -> None:
    """To fifteen digits, which is what a quantity keeps."""
    for number in NUMBERS:
        expected = float(f"{REGISTRY.Quantity(number, prefix + unit).to(unit).magnitude:.15g}")
        assert quantity(f"{number!r} {prefix}{unit}", unit, "x") == expected


def test_degrees_are_as_pint_has_them() -> None:
    """The one unit of angle that people write."""
    for number in NUMBERS:
        expected = float(f"{REGISTRY.Quantity(number, 'deg').to('rad').magnitude:.15g}")
        assert quantity(f"{number!r} deg", "rad", "x") == expected


@pytest.mark.parametrize("text", ["1 mHz", "1 min", "1 mN", "1 m"])
def test_other_dimensions_are_refused(text: str) -> None:
    """A unit that ends like another one is not that one."""
    with pytest.raises(SceneError, match="must be a pressure"):
        quantity(text, "Pa", "x")


@pytest.mark.parametrize("text", ["2 %%", "2 % %", "2 %*%"])
def test_a_percent_of_a_percent_is_a_slip(text: str) -> None:
    """It would be 2e-4."""
    with pytest.raises(SceneError, match=f'x: must be a plain number; got "{re.escape(text)}"'):
        quantity(text, "", "x")
    assert quantity("2 %", "", "x") == 0.02 and quantity("2 %/K", "1/K", "x") == 0.02


def test_a_catalogued_sensor_needs_no_pint() -> None:
    """It takes a third of a second to come."""
    load = "from sits_mech.scene.sensor import load_sensor; load_sensor('biorob2018')"
    code = f"import sys; {load}; print('pint' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "False"


def test_tolerance_is_checked_in_one_place() -> None:
    """Any share of one; what a model cannot promise is refused with what came."""
    assert type(checked_tolerance(np.float32(0.5))) is float
    assert checked_tolerance(1e-3) == 1e-3 and checked_tolerance(1e-7, 1e-7) == 1e-7
    for wrong in (0.0, 1.0, -1.0, math.nan, math.inf):
        with pytest.raises(SceneError, match=f"tolerance must lie between 0 and 1; got {wrong}"):
            checked_tolerance(wrong)
    for wrong, words in (("1 %", '"1 %"'), (None, "None")):
        with pytest.raises(SceneError, match=f"tolerance must lie between 0 and 1; got {words}"):
            checked_tolerance(wrong)
    for share in (1e-16, 0.9995):  # of a study too
        assert SHARE.check(share) == checked_tolerance(share) == share
    for wrong in (0.0, 1.0, "100 %"):
        with pytest.raises(SceneError, match="must be a share .* between 0 and 1"):
            SHARE.check(wrong)
    with pytest.raises(SceneError, match="tolerance must lie between 1e-07 and 1; got 1e-08"):
        checked_tolerance(1e-8, 1e-7)


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


def test_one_quantity_is_one_number() -> None:
    """Where a single value is another thing than a list of one."""
    assert quantity_or_range("500 mN", "N", "--fz") == 0.5 and quantity_or_range("62 mil", "m", "--dv") == 1.5748e-3
    assert quantity_or_range("0 N:1 N:2", "N", "--fz") == [0.0, 1.0]


@pytest.mark.parametrize(("unit", "into"), [*units._NEAR_BY, ("N*m", "N*m"), ("S/m", "S/m"), ("kPa", "Pa")])
def test_units_read_at_once_are_those_of_pint(unit: str, into: str) -> None:
    for number in (1.0, 0.3, 57.3):
        expected = float(f"{REGISTRY.convert(number, unit, into):.15g}")
        assert units._converted(number, unit, into) == expected


def test_prose_is_no_unit() -> None:
    """Of any length and with any brackets, as pages of text in place of a table have it; a unit is."""
    assert not is_unit(f"{'a word ' * 20}(Figure") and not is_unit("(Figure") and not is_unit("m " * 60)
    assert is_unit("N mm") and is_unit("uH") and is_unit("%")
