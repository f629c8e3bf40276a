"""Kinds of a design's figures: their names, units, and how they are shown."""

import pytest

from sits_mech.synthesis.required.kinds import ASKED, INVERSE, STRAIN, figure_names, figure_unit, figure_words, shown_as


def test_names_are_of_each_component_and_both_axes() -> None:
    assert figure_names(("F_x", "M_z"), ("drift", "rate", "footprint")) == (
        "drift.F_x", "drift.M_z", "rate", "footprint.x", "footprint.y")
    assert INVERSE not in ASKED and STRAIN not in ASKED and len(figure_names(("F_z",))) == 9


@pytest.mark.parametrize(("name", "unit", "shown", "words"), [
    ("resolution.F_x", "N", "mN", "12 mN"), ("drift.F_z", "N/K", "mN/K", "12 mN/K"), ("error.M", "", "%", "1.2 %"),
    ("footprint.x", "m", "mm", "12 mm"), ("rate", "Hz", "Hz", "0.012 Hz"), (INVERSE, "", "", "0.012"),
    (STRAIN, "", "%", "1.2 %"),
])
def test_units(name: str, unit: str, shown: str, words: str) -> None:
    assert (figure_unit(name), shown_as(name)[0], figure_words(name, 0.012)) == (unit, shown, words)
