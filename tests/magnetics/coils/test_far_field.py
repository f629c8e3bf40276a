"""Coils from far away: closed forms lie beyond the field and the inductance that they bound, and not far."""

import math

import numpy as np
import pytest

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.far_field import coil_field, field_bound
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
COIL = load_sensor("biorob2018").coils[0]


def test_field_on_the_axis() -> None:
    """Loops' own field there, a^2/(2 (a^2 + z^2)^1.5), the mean of a track's; beside it no flux leaves a closed box."""
    rings, z, (nodes, weights) = coil_sections(COIL), 9 * MM, np.polynomial.legendre.leggauss(4)
    a, h = rings.radius[:, None] + rings.width[:, None] / 2 * nodes, rings.z[:, None]
    exact = float((a * a / (2.0 * (a * a + (z - h) ** 2) ** 1.5) @ weights).sum() / 2.0)
    H = coil_field(COIL, np.array([[*COIL.centre, z]]), 1e-3 * MM)
    np.testing.assert_allclose(H, [[0.0, 0.0, exact]], rtol=1e-6, atol=1e-6 * exact)
    place, step = np.array([5e-3, 7e-3, 4e-3]), 0.01 * MM
    ways = np.vstack([np.eye(3), -np.eye(3)])
    sides = coil_field(COIL, place + step * ways, 1e-3 * MM)
    assert abs((sides * ways).sum()) < 1e-4 * np.abs(sides).max()


@pytest.mark.parametrize(("distance", "most"), [(6 * MM, 20.0), (20 * MM, 2.2), (400 * MM, 1.05)])
def test_no_place_has_more_field_than_its_bound(distance: float, most: float) -> None:
    """All around at a distance; far away the largest, on the axis, is the bound."""
    some = np.random.default_rng(0).normal(size=(400, 3))
    some[0] = 0.0, 0.0, 1.0
    points = np.array([*COIL.centre, 0.0]) + distance * some / np.linalg.norm(some, axis=1)[:, None]
    H = np.linalg.norm(coil_field(COIL, points, 1e-3 * distance), axis=1).max()
    assert H < field_bound(COIL, distance) < most * H


def test_within_the_coil_there_is_no_bound() -> None:
    """And none for windings that are not rings."""
    assert field_bound(COIL, 0.4 * COIL.outer_diameter) == math.inf
    square = load_sensor(
        "biorob2018",
        ['coils=[{name="S", shape="rectangle", centre=["0 mm", "0 mm"], layers=1, turns=4, inner_width="3 mm", '
         'inner_length="3 mm", track_width="0.1 mm", track_gap="0.1 mm", track_thickness="35 um"}]'],
    ).coils[0]
    assert field_bound(square, 1.0) == math.inf
