"""Windings of the published coil: counts, diameters, signs, lengths."""

import numpy as np
import pytest

from sits_mech.geometry.windings import check_frequency, coil_bars, coil_sections, spiral_path, track_length, wave_notes
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
    path = spiral_path(coil, points_per_turn=400)
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length == pytest.approx(track_length(coil) + coil.layer_pitch, rel=1e-3)
    assert track_length(coil) == pytest.approx(2 * np.pi * coil_sections(coil).radius.sum())


def test_spiral_turns_counter_clockwise_in_every_layer(coil):
    path = spiral_path(coil) - [*coil.centre, 0.0]
    turning = path[:-1, 0] * path[1:, 1] - path[:-1, 1] * path[1:, 0]
    assert np.all(turning > -1e-18)


def test_frequencies_up_to_where_a_wave_is_as_long_as_the_track(coil):
    """24 turns of 2.25 mm mean radius are 0.339 m: 884 MHz; from a tenth of that on a note says so."""
    limit = 299792458.0 / (24 * 2 * np.pi * 2.25e-3)
    check_frequency([coil], 0.999 * limit)
    for wrong in (1.001 * limit, 0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="frequency: must be"):
            check_frequency([coil], wrong)
    with pytest.raises(ValueError, match="8.84e.08 Hz.*track of coil C2.*full-wave"):
        check_frequency([coil], 1e10)
    assert wave_notes([coil], 0.09 * limit) == () and "0.2 waves" in wave_notes([coil], 0.2 * limit)[0]
