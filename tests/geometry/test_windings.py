"""Windings of the published coil: counts, diameters, signs, lengths."""

import numpy as np
import pytest

from sits_mech.geometry.tracks import coil_bars, track_length
from sits_mech.geometry.windings import coil_sections, spiral_path
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def coil():
    return load_sensor("biorob2018").coils[1]


def test_bars_are_go_and_return_about_the_axis(coil):
    bars = coil_bars(coil)
    assert bars.x.size == 2 * 12 * 2 and bars.sign.sum() == 0
    assert np.ptp(bars.x) + bars.width == pytest.approx(coil.outer_diameter)
    assert np.all((bars.x > coil.centre[0]) == (bars.sign > 0))
    assert bars.z.max() + bars.thickness / 2 == pytest.approx(0.0, abs=1e-18)
    assert bars.z.min() == pytest.approx(-17.5e-6 - 85e-6)


def test_spiral_has_the_rings_length(coil):
    layers = spiral_path(coil, points_per_turn=400)
    length = sum(np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in layers)
    assert length == pytest.approx(track_length(coil), rel=1e-3)
    assert track_length(coil) == pytest.approx(2 * np.pi * coil_sections(coil).radius.sum())


def test_spiral_turns_counter_clockwise_in_every_layer(coil):
    for path in spiral_path(coil.model_copy(update={"centre": (0.0, 0.0)})):
        assert np.all(path[:-1, 0] * path[1:, 1] - path[:-1, 1] * path[1:, 0] > 0.0)
