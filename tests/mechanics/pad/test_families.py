"""Families of meshes of a pad: in which order they are tried, and that half a pad is half of the whole one."""

import numpy as np
import pytest

from sits_mech.mechanics.pad.families import FINENESS, meshes_in_line, pad_family, terms_of
from sits_mech.mechanics.pad.shapes import GRADING
from sits_mech.scene.sensor import load_sensor


@pytest.mark.parametrize(("contact", "touching"), [("never", [0, 0]), ("always", [1, 1]), ("auto", [0, 0, 1, 1])])
def test_families_are_tried_without_contact_first(contact: str, touching: list[bool]) -> None:
    """Free, then guarded."""
    line = meshes_in_line(load_sensor("biorob2018", [f'elastomer.contact="{contact}"']), 0.1, whole=False)
    assert len(line.makers) == len(touching)
    families = [line[number] for number in range(len(touching))]
    assert [bool(each.coarse.parts) for each in families] == touching
    assert [each.coarse.laws.guarded for each in families] == [number % 2 == 1 for number in range(len(families))]


def test_the_whole_pad_has_twice_the_cells_across() -> None:
    half, whole = (pad_family(load_sensor("biorob2018"), whole=all_of_it) for all_of_it in (False, True))
    for level in range(len(FINENESS)):
        along, across, through = half[0].cells(level)
        assert whole[0].cells(level) == (along, 2 * across, through)
    assert (half[1], whole[1]) == (0.5, 1.0)


def test_the_terms_of_levels_fall_where_cells_are_divided() -> None:
    """At the edges and away from them, each by the sizes of its own cells; orders are those measured."""
    terms = terms_of(FINENESS, 0.5)
    sizes = np.array([(split * 2.0**layers, split) for split, layers in FINENESS])
    assert np.all((np.diff(terms, axis=0) < 0.0) == (np.diff(sizes, axis=0) > 0.0)) and np.all(terms > 0.0)
    order = np.log(terms[0] / terms[3]) / np.log(4.0)
    assert order == pytest.approx([2.0 * 0.5 * GRADING, 3.0])
