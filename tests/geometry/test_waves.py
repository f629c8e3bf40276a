"""Frequencies that no quasi-static model holds."""

import numpy as np
import pytest

from sits_mech.geometry.tracks import check_frequency, wave_notes
from sits_mech.scene.sensor import load_sensor


def test_frequencies_up_to_where_a_wave_is_as_long_as_the_track():
    """24 turns of 2.25 mm mean radius are 0.339 m: 884 MHz; from a tenth of that on a note says so."""
    coil = load_sensor("biorob2018").coils[1]
    limit = 299792458.0 / (24 * 2 * np.pi * 2.25e-3)
    check_frequency([coil], 0.999 * limit)
    for wrong in (1.001 * limit, 0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="frequency: must be"):
            check_frequency([coil], wrong)
    with pytest.raises(ValueError, match="8.84e.08 Hz.*track of coil C2.*full-wave"):
        check_frequency([coil], 1e10)
    assert wave_notes([coil], 0.09 * limit) == () and "0.2 waves" in wave_notes([coil], 0.2 * limit)[0]
