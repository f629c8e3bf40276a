"""Layers over a coil: tabulated integrals, finite elements, images, limits."""

from typing import Any

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change, pair_change, reflection
from scipy.constants import mu_0

from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import mutual_loops, ring_mutual
from sits_mech.magnetics.coils.ring_field import STEP, Radial, coil_potential, source_spectrum, winding_potential
from sits_mech.memory import SECONDS
from sits_mech.scene.sensor import Coil, SceneError

MM = 1e-3
COPPER = 5.8e7
LOOP = Sections(*(np.array([value]) for value in (3 * MM, 0.0, 0.0, 0.0)))
RECTANGLE = {"shape": "rectangle", "inner_width": 4 * MM, "inner_length": 3 * MM}
COIL = coil_sections(
    Coil(
        name="C", centre=(0.0, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )
)


@pytest.mark.parametrize(
    ("thickness", "frequency", "delta_L_nH", "R_uohm"),
    [  # two independent quadratures of the Dodd-Deeds integral, 8 digits
        (np.inf, 5e3, -1.3451096, 19.709996),
        (np.inf, 1e5, -2.2008181, 156.01438),
        (np.inf, 5e6, -2.4479418, 1262.8877),
        (0.2 * MM, 5e3, -0.50617263, 26.281674),
        (0.2 * MM, 1e5, -2.271799, 187.45493),
        (0.2 * MM, 5e6, -2.4479419, 1262.8923),
    ],
)
def test_loop_over_half_space_and_plate(thickness, frequency, delta_L_nH, R_uohm):
    change = coil_change(LOOP, 1 * MM, frequency, [Layer(COPPER, thickness)])
    assert change.delta_L * 1e9 == pytest.approx(delta_L_nH, rel=1e-7)
    assert change.R * 1e6 == pytest.approx(R_uohm, rel=1e-7)
    assert change.error < 1e-7


@pytest.mark.parametrize(
    ("frequency", "delta_L", "R"),
    [(5e3, -5.8325180325808516e-08, 0.0025675831423334306), (5e6, -2.201923393250477e-07, 0.0939925486348742)],
)
def test_two_layer_coil_over_plate(frequency, delta_L, R):
    # Dodd-Deeds by another code, agreeing with NGSolve to 1e-5
    change = coil_change(COIL, 2 * MM, frequency, [Layer(COPPER, 0.2 * MM)])
    assert change.delta_L == pytest.approx(delta_L, rel=1e-8, abs=0)
    assert change.R == pytest.approx(R, rel=1e-8)


@pytest.mark.parametrize(
    ("frequency", "delta_L", "R"),
    [(5e3, -1.1488152e-07, 0.001015553), (5e6, -1.6194157e-07, 0.050466572)],
)
def test_planar_pair_over_half_space(frequency, delta_L, R):
    # two independent quadratures, 8 digits; conductivity 5.96e7 S/m
    change = pair_change(4.5 * MM, 2 * MM, frequency, [Layer(5.96e7)])
    assert change.delta_L == pytest.approx(delta_L, rel=1e-7, abs=0)
    assert change.R == pytest.approx(R, rel=1e-7)


def test_perfect_conductor_is_the_image():
    change = coil_change(COIL, 0.5 * MM, 1e3, [Layer(np.inf)])
    image = Sections(COIL.radius, 2 * 0.5 * MM - COIL.z, COIL.width, COIL.height)
    assert change.delta_L == pytest.approx(-ring_mutual(COIL, image).sum(), rel=1e-7, abs=0)
    assert change.R == 0.0
    loop = coil_change(LOOP, 1 * MM, 1e3, [Layer(np.inf)])
    assert loop.delta_L == pytest.approx(-mutual_loops(3 * MM, 3 * MM, 2 * MM), rel=1e-8, abs=0)
    pair = pair_change(4.5 * MM, 2 * MM, 1e3, [Layer(np.inf)])
    assert pair.delta_L == pytest.approx(-mu_0 / (2 * np.pi) * np.log(1 + (4.5 / 4) ** 2), rel=1e-8)


def test_soft_magnetic_insulator_attracts_the_image_of_the_other_sign():
    mu = 1e4
    change = coil_change(LOOP, 1 * MM, 1e3, [Layer(0.0, relative_permeability=mu)])
    assert change.delta_L == pytest.approx((mu - 1) / (mu + 1) * mutual_loops(3 * MM, 3 * MM, 2 * MM), rel=1e-8, abs=0)
    assert change.R == pytest.approx(0.0, abs=1e-15)


def test_splitting_a_layer_and_empty_layers_change_nothing():
    whole = [Layer(COPPER, 0.2 * MM, 3.0)]
    split = [Layer(0.0, 0.1 * MM), Layer(COPPER, 0.05 * MM, 3.0), Layer(COPPER, 0.15 * MM, 3.0), Layer(0.0, 1 * MM)]
    k = np.geomspace(1.0, 1e5, 50)
    omega = 2 * np.pi * 1e5
    expected = reflection(k, omega, whole) * np.exp(-2 * k * 0.1 * MM)
    np.testing.assert_allclose(reflection(k, omega, split), expected, rtol=1e-9)


def test_reflection_keeps_its_digits_at_low_frequency():
    # thick against 1/k, resistive: Gamma -> -j omega mu0 sigma / (4 k^2)
    k, omega, sigma = np.array([1e4]), 2 * np.pi, 1e3
    first_order = -1j * omega * mu_0 * sigma / (4 * k**2)
    np.testing.assert_allclose(reflection(k, omega, [Layer(sigma)]), first_order, rtol=1e-9)


def test_resistive_limit_grows_with_the_square_of_frequency_and_skin_limit_with_its_root():
    low = [float(coil_change(COIL, 1 * MM, f, [Layer(1e3, 0.1 * MM)]).R) for f in (10.0, 100.0)]
    assert low[1] / low[0] == pytest.approx(100.0, rel=1e-6)
    high = [float(coil_change(COIL, 1 * MM, f, [Layer(1e9)]).R) for f in (1e9, 4e9)]
    assert high[1] / high[0] == pytest.approx(2.0, rel=1e-3)


def test_gaps_are_vectorised_and_far_ones_vanish():
    gaps = np.array([[1.0, 2.0], [4.0, 50.0]]) * MM
    change = coil_change(COIL, gaps, 5e6, [Layer(COPPER, 0.2 * MM)])
    assert change.delta_L.shape == gaps.shape
    one = coil_change(COIL, 50 * MM, 5e6, [Layer(COPPER, 0.2 * MM)])
    assert change.delta_L[1, 1] == pytest.approx(float(one.delta_L), rel=1e-6, abs=0)
    assert np.all(change.delta_L < 0) and np.all(change.R > 0)


@pytest.mark.parametrize("gap", [0.0, -1e-3, float("nan")])
def test_gap_must_be_positive(gap):
    with pytest.raises(ValueError, match="gap: must be positive"):
        coil_change(COIL, gap, 5e6, [Layer(COPPER)])


def test_coils_of_too_many_turns_are_refused_before_anything_is_allocated():
    """A million turns at 5000 wave numbers: 12 arrays of 8 bytes, 447 GiB."""
    ones = np.ones(1_000_000)
    rings = Sections(ones, -ones, 1e-4 * ones, 1e-5 * ones)
    with pytest.raises(ValueError, match=r"1000000 turns of a coil, times 5000 .* take some 447 GiB, more than"):
        source_spectrum(rings, np.linspace(1.0, 2.0, 5000))


@pytest.mark.parametrize("height", [0.3, 2.0, 20.0])
def test_filaments_of_straight_tracks_meet_at_corners(height: float) -> None:
    """A square of one track 2 mm wide as of 20 narrow ones, a circle of short tracks as a ring."""
    sides = {"name": "C", "centre": (0.0, 0.0), "track_thickness": 35e-6}
    angle = np.linspace(0.0, 2 * np.pi, 721)
    circle = tuple((x, y, -17.5e-6) for x, y in (6 * MM * np.column_stack([np.cos(angle), np.sin(angle)])).tolist())
    wide, ring = sides | {"track_width": 2 * MM, "layers": 1, "turns": 1}, {"inner_diameter": 10 * MM}
    narrow = Coil(**wide | RECTANGLE | {"turns": 20, "track_width": 0.1 * MM, "track_gap": 1e-9})
    path = Coil(**sides, track_width=2 * MM, shape="path", path=(circle,))
    points = np.column_stack([np.linspace(0.1, 12.0, 30), np.full(30, 0.3), np.full(30, height)]) * MM
    for found, exact, turns in ((Coil(**wide | RECTANGLE), narrow, 20), (path, Coil(**wide | ring), 1)):
        A, B = coil_potential(found, points, height * MM), coil_potential(exact, points, height * MM) / turns
        assert np.abs(A - B).max() < 3e-4 * np.abs(B).max()


def test_filaments_are_fewer_where_points_are_farther_and_alike_for_a_point() -> None:
    """From 0.05 mm on, over the windings and beside them: no step shows, whatever else is asked at once."""
    coil = Coil(name="C", centre=(0.0, 0.0), layers=2, turns=3, inner_diameter=2.2 * MM, track_width=0.1 * MM,
                track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6)
    across, up = np.meshgrid(np.linspace(0.0, 6.0, 25), [0.05, 0.11, 0.4, 1.7])
    points = np.column_stack([across.ravel(), 0.0 * across.ravel(), up.ravel()]) * MM
    found, near = coil_potential(coil, points, 0.05 * MM), coil_potential(coil, points, 0.02 * MM)
    assert np.abs(found - near).max() < 1e-4 * np.abs(near).max()
    for k in (0, 30, 60, 99):
        np.testing.assert_array_equal(coil_potential(coil, points[k : k + 1], 0.05 * MM)[0], found[k])


def test_a_table_is_made_where_it_pays_and_what_takes_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.1 mm off at least 17 000 nodes: point by point below a thirtieth of them a pose, and alike by both."""
    coil = Coil(name="C", centre=(0.0, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
                track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6)
    points = np.column_stack([np.linspace(0.0, 5.0, 50), np.zeros(50), np.linspace(0.1, 0.3, 50)]) * MM
    region, exact = (0.1 * MM, 0.3 * MM, 6 * MM), coil_potential(coil, points, 0.1 * MM)[:, :2]
    found = winding_potential(coil, "rings", region, 300)(points.T[None])[0].T
    np.testing.assert_array_equal(found, exact)
    table = winding_potential(coil, "rings", region, 50_000)(points.T[None])[0].T
    assert 0.0 < np.abs(table - exact).max() < 2e-6 * np.abs(exact).max()
    rough = winding_potential(coil, "rings", region, 50_000, 4 * STEP)(points.T[None])[0].T
    assert 0.0 < np.abs(rough - exact).max() < 4**4 * 2e-6 * np.abs(exact).max()
    monkeypatch.setenv(SECONDS.variable, "1e-4")
    refused = "^coils: the field of 24 turns at 50 points from 0.1 mm on must take at most 0.0001 s"
    with pytest.raises(SceneError, match=refused):
        coil_potential(coil, points, 0.1 * MM)


def test_a_table_of_a_small_gap_holds_over_all_heights() -> None:
    """0.02 mm off, two to the fifth times as high at most: by steps that grow with the height, in all octaves alike."""
    coil = Coil(name="C", centre=(0.0, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
                track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6)
    some = np.random.default_rng(3)
    edges = np.array([coil.inner_diameter / 2, coil.outer_diameter / 2])
    rho = np.abs(np.r_[some.uniform(0.0, 9.0, 300) * MM, some.choice(edges, 300) + some.normal(0.0, 0.06, 300) * MM])
    points = np.column_stack([rho, 0.0 * rho, 0.02 * MM * 2.0 ** some.uniform(0.0, 5.0, 600)])
    found = winding_potential(coil, "rings", (0.02 * MM, 0.64 * MM, 9 * MM), 50_000)(points.T[None])[0].T
    exact = coil_potential(coil, points, 0.02 * MM)[:, :2]
    assert np.abs(found - exact).max() < 5e-7 * np.abs(exact).max()


@pytest.mark.parametrize("clearance", [0.07, 0.35, 3.0])
def test_steps_are_few_and_go_with_the_distance_from_the_windings(clearance: float) -> None:
    """A coil 7.8 to 11 mm wide, out to 0.1 m: even steps over it, growing ones beside it; 9,100 by asinh(rho / R)."""
    track = {"layers": 1, "track_width": 0.09 * MM, "track_gap": 0.01 * MM, "track_thickness": 35e-6}
    axis = Radial(Coil(name="C", centre=(0.0, 0.0), turns=32, inner_diameter=15.6 * MM, **track), clearance * MM)
    count = int(axis.steps(0.1))
    at = axis.at(np.arange(count + 1))
    np.testing.assert_allclose(axis.steps(at), np.arange(count + 1), atol=1e-9 * count)
    away = np.maximum(np.maximum(7.8 * MM - at, at - 11.0 * MM), 0.0)
    steps = np.diff(at) / np.hypot(clearance * MM, (away[1:] + away[:-1]) / 2)
    assert at[0] == pytest.approx(0.0, abs=1e-12) and count < 3.2 * MM / (STEP * clearance * MM) + 14.0 / STEP
    assert 0.8 * STEP < steps.min() and steps.max() < 1.1 * STEP


def test_wave_numbers_that_take_long_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before they are made: 120 000 of them took 9 s, of a scene that was refused afterwards."""
    rings = Sections(np.full(11, 5e-3), np.zeros(11), np.full(11, 2e-3), np.full(11, 35e-6))
    monkeypatch.setenv(SECONDS.variable, "0.01")
    with pytest.raises(SceneError, match="^coils: 20000 wave numbers of 11 turns must take at most 0.01 s"):
        source_spectrum(rings, np.linspace(1.0, 1e4, 20_000))


def test_the_spectrum_of_a_wide_ring_is_that_of_its_strips() -> None:
    """A ring 4 mm wide at wave numbers of up to ten waves across it."""
    radii, k = 4 * MM + 0.1 * MM * (np.arange(40) + 0.5), np.linspace(1.0, 2e4, 200)
    wide, strips = (
        Sections(radius, 0.0 * radius - 35e-6, np.full(radius.size, width), np.full(radius.size, 35e-6))
        for radius, width in ((np.array([6 * MM]), 4 * MM), (radii, 0.1 * MM))
    )
    flat = Sections(wide.radius, wide.z, wide.width, 0.0 * wide.height)
    np.testing.assert_allclose(
        source_spectrum(flat, k)[:3] / source_spectrum(wide, k)[:3], 1.0, rtol=1e-5
    )  # a foil is a ring
    exact = source_spectrum(strips, k) / 40
    assert np.abs(source_spectrum(wide, k) - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize(("shape", "away"), [
    ({"inner_diameter": 3 * MM}, 0.05), ({"inner_diameter": 3 * MM, "track_thickness": 1 * MM}, 0.5), (RECTANGLE, 0.5),
    (RECTANGLE | {"track_thickness": 1 * MM}, 5.0),
])
def test_filaments_for_a_track_are_as_many_as_its_distance_asks(shape: dict[str, Any], away: float) -> None:
    """A track 2 mm wide: to a share of the field's largest, what is right ten times nearer shows."""
    coil = Coil(**{"name": "C", "centre": (0.0, 0.0), "layers": 1, "turns": 1, "track_width": 2 * MM,
                   "track_thickness": 35e-6} | shape)
    across = np.linspace(0.0, 6 * MM, 61)
    points = np.column_stack([across, 0.1 * across, np.full(61, away * MM)])
    found, exact = (coil_potential(coil, points, clearance * MM) for clearance in (away, away / 10))
    assert np.abs(found - exact).max() < 3e-4 * np.abs(exact).max()
