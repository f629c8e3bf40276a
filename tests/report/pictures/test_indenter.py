"""Outlines of what touches the target: where they meet the face, and how they lie in a section."""

import numpy as np
import pytest

from sits_mech.report.pictures.cuts import Plane
from sits_mech.report.pictures.indenter import draw_from_above, draw_from_the_side, height_shown
from sits_mech.report.pictures.style import new_figure
from sits_mech.scene.parts.touch import Touch

PLACE, TILT = np.array([1e-3, 0.0, 2e-3]), 0.1
NORMAL = np.array([np.sin(TILT), 0.0, np.cos(TILT)])
SHAPES = {
    "sphere": Touch(shape="sphere", radius=4e-3, x=1e-3),
    "along": Touch(shape="cylinder", radius=4e-3, length=2e-3, axis="x", x=1e-3),
    "across": Touch(shape="cylinder", radius=4e-3, length=2e-3, axis="y", x=1e-3),
    "punch": Touch(shape="punch", width=2e-3, length=2e-3, x=1e-3),
    "pressure": Touch(shape="pressure", diameter=2e-3, x=1e-3),
}


def line(touch, *place):
    with new_figure(0.5) as (_, (axes,)):
        draw_from_the_side(axes, touch, *place) if place else draw_from_above(axes, touch)
        return axes.lines[0].get_xydata(), len(axes.texts)


@pytest.mark.parametrize("name", SHAPES)
def test_an_outline_stands_on_the_face_at_its_place(name):
    points, arrows = line(SHAPES[name], PLACE, NORMAL, Plane())
    up = (points - 1e3 * PLACE[[0, 2]]) @ NORMAL[[0, 2]]
    assert up.min() == pytest.approx(0.0, abs=1e-12)
    assert up.max() == pytest.approx(0.0 if name == "pressure" else height_shown(SHAPES[name]))
    assert arrows == (5 if name == "pressure" else 0)
    if name in ("sphere", "across"):  # on a circle about the centre
        centre = 1e3 * (PLACE + 4e-3 * NORMAL)[[0, 2]]
        assert np.hypot(*(points - centre).T) == pytest.approx(4.0)


def test_from_above_it_is_its_border_or_its_point():
    assert line(SHAPES["sphere"])[0].tolist() == [[1.0, 0.0]]
    assert sorted(line(SHAPES["across"])[0].tolist()) == [[1.0, -1.0], [1.0, 1.0]]
    assert np.ptp(line(SHAPES["punch"])[0], axis=0) == pytest.approx([2.0, 2.0])
