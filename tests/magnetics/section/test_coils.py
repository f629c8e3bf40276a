"""The coils' own field in the section: against quadrature, and zero on the grounded circle."""

import numpy as np
import pytest

from sits_mech.magnetics.section.coils import coil_potentials, mean_log_at, tracks
from sits_mech.scene.sensor import load_sensor


def test_bar_potential_is_the_mean_over_its_section() -> None:
    """Against 60 x 60 Gauss points; on both sides of where filaments take over."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for place in (9e-5 + 3e-5j, 1.4142e-3 + 1.4142e-3j, 1.4143e-3 + 1.4143e-3j, 0.05 + 0.05j):
        inside = np.abs(place - 5e-5 * nodes[:, None] - 1j * 17.5e-6 * nodes)
        expected = weights @ np.log(inside) @ weights / 4
        found = mean_log_at(np.array([place.real]), np.array([place.imag]), 1e-4, 35e-6)
        assert found[0] == pytest.approx(expected, abs=1e-11)


def test_coil_potential_vanishes_on_the_grounded_circle() -> None:
    circle = 0.05 * np.exp(1j * np.linspace(0, 2 * np.pi, 50))
    coils = tracks(load_sensor("biorob2018"))
    free, grounded = coil_potentials(coils, circle), coil_potentials(coils, circle, 0.05)
    assert np.abs(grounded).max() < 1e-5 * np.abs(free).max()
