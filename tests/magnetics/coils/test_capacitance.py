"""Own capacitance of tracks: plates of linear voltage, scaling."""

from typing import Any

import numpy as np
import pytest
from scipy.constants import epsilon_0

from sits_mech.analysis.readings.terminals import own_capacitance
from sits_mech.geometry.tracks import track_length
from sits_mech.scene.parts.coils import Coil

MM = 1e-3
KEYS: dict[str, Any] = {"name": "C", "centre": (0.0, 0.0), "turns": 20, "track_width": 0.5 * MM, "track_gap": 0.01 * MM}
KEYS |= {"track_thickness": 35e-6, "inner_diameter": 2 * MM, "layers": 2, "layer_pitch": 50e-6}


def test_two_layers_are_a_third_of_two_plates() -> None:
    """Tracks much wider than their distance: eps A / d / 3, the voltage between them falling from all to none."""
    coil = Coil(**KEYS)
    plates = epsilon_0 * 4.4 * track_length(coil) / 2 * coil.track_width / 15e-6
    assert own_capacitance(coil) == pytest.approx(plates / 3, rel=0.04)


def test_free_tracks_as_the_same_rectangle() -> None:
    """A path that winds inwards, and outwards below: as the layers of a rectangle do."""
    keys = {key: item for key, item in KEYS.items() if key != "inner_diameter"}
    keys |= {"shape": "rectangle", "inner_width": 4 * MM, "inner_length": 4 * MM, "turns": 6, "track_gap": 0.1 * MM}
    coil = Coil(**keys)
    corners, halves = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), 2.25 + 0.6 * np.arange(6)[::-1]
    inwards = [(*(half * corner * MM), ) for half in halves for corner in corners]
    outwards = [(*(half * corner * MM), ) for half in halves[::-1] for corner in corners[[3, 2, 1, 0]]]
    lines = [tuple((float(x), float(y), z) for x, y in line)
             for line, z in ((inwards, coil.heights[0]), (outwards, coil.heights[1]))]
    path = Coil(name="P", shape="path", path=tuple(lines), track_width=0.5 * MM, track_thickness=35e-6)
    assert own_capacitance(path) == pytest.approx(own_capacitance(coil), rel=0.15)


def test_scaling() -> None:
    """By the permittivity; one layer has little; four layers less than two of the same distance."""
    two = Coil(**KEYS)
    double = Coil(**KEYS | {"board_permittivity": 8.8})
    assert own_capacitance(double) == pytest.approx(2 * own_capacitance(two), rel=0.01)
    assert own_capacitance(Coil(**KEYS | {"layers": 1})) < 0.05 * own_capacitance(two)
    assert own_capacitance(Coil(**KEYS | {"layers": 4})) < own_capacitance(two)
