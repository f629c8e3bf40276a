"""Loops and rings against closed forms, an independent finite-element code, limits and invariants."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import mu_0
from scipy.special import ellipe, ellipk, elliprd

from sits_mech.geometry.tracks import coil_lines
from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils import loops
from sits_mech.magnetics.coils.loops import (
    free_inductances,
    mutual_loops,
    mutual_side_by_side,
    reduced_mutual,
    ring_inductance,
    ring_mutual,
    series_inductance,
)
from sits_mech.scene.sensor import Coil, SceneError

MM = 1e-3


def coil(name: str = "C", x: float = 0.0, y: float = 0.0) -> Coil:
    return Coil(
        name=name, centre=(x, y), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def ring(radius: float, width: float, height: float, z: float = 0.0) -> Sections:
    return Sections(*(np.array([value]) for value in (radius, z, width, height)))


def test_a_ring_as_tall_as_its_radius_is_the_sum_of_low_ones() -> None:
    """By three points through its thickness it is 4e-4 off; one five thousand times as tall had less than none."""
    whole, parts = ring(1.0, 0.1, 1.0), Sections(*np.full((4, 40), [[1.0], [0.0], [0.1], [1.0 / 40]]))
    parts = replace(parts, z=(np.arange(40) + 0.5) / 40)
    assert series_inductance(whole) == pytest.approx(ring_inductance(parts).mean(), rel=1e-6)
    with pytest.raises(SceneError, match="coils: the inductance of a coil of 1 turns must take at most"):
        series_inductance(ring(1.0, 0.1, 5000.0))


def test_coaxial_rings_as_tall_as_their_radius_are_the_mean_of_low_ones() -> None:
    """By three points through their thicknesses they were 1e-5 off, one eight radii tall above a low one 3 %."""
    first = Sections(*np.full((4, 160), [[1.0], [0.0], [0.1], [0.05]]))
    first = replace(first, z=0.05 * (np.arange(160) - 79.5))
    for second in (ring(1.05, 0.1, 0.03, 4.115), ring(1.05, 0.1, 1.0, 4.6)):
        low = ring_mutual(first, second, points=(3, 24)).mean()
        assert mutual_side_by_side(ring(1.0, 0.1, 8.0), second, 0.0) == pytest.approx(low, rel=1e-6)


def test_many_rings_are_paired_some_at_once(monkeypatch):
    """Temporary arrays of all pairs of 3264 filaments took 2.5 GiB."""
    rings, sizes, once = coil_sections(coil()), [], loops.paired_mutual
    whole = ring_mutual(rings, rings)

    def counted(first, second, *points):
        sizes.append(first.radius.size * second.radius.size)
        return once(first, second, *points)

    monkeypatch.setattr(loops, "paired_mutual", counted)
    monkeypatch.setattr(loops, "PAIRS", 100)
    assert np.array_equal(ring_mutual(rings, rings), whole)
    assert max(sizes) <= 100 and sum(sizes) == whole.size


@pytest.mark.parametrize(
    ("a", "b", "d", "expected"),
    [  # elliptic integrals, from tables of coaxial loops
        (0.25, 0.25, 0.1, 3.376847185e-07),
        (0.2, 0.1, 0.05, 9.593293994e-08),
        (0.00115, 0.00335, 0.001, 7.01934432e-10),
        (0.0034, 0.0034, 0.002, 3.226370606e-09),
    ],
)
def test_coaxial_loops_equal_published_values(a, b, d, expected):
    assert mutual_loops(a, b, d) == pytest.approx(expected, rel=1e-9, abs=0)


def test_coaxial_loops_equal_first_form_with_complete_elliptic_integrals():
    a, b, d = 2.0, np.array([0.5, 1.0, 1.9, 2.5]), np.array([0.3, 1.0, 0.1, 2.0])
    m = 4 * a * b / ((a + b) ** 2 + d**2)
    k = np.sqrt(m)
    expected = mu_0 * np.sqrt(a * b) * ((2 / k - k) * ellipk(m) - 2 / k * ellipe(m))
    np.testing.assert_allclose(mutual_loops(a, b, d), expected, rtol=1e-12)


def test_nothing_cancels_in_any_regime():
    """By Carlson's R_D = 3 (K - E) / k^2: from loops that all but touch to a point on the axis, a million radii off."""
    b, d = (part.ravel() for part in np.meshgrid([0.0, 1e-9, 0.2, 1.0 - 1e-6, 1.0, 7.0], np.geomspace(1e-8, 1e6, 99)))
    far, near = np.hypot(1.0 + b, d), np.hypot(1.0 - b, d)
    exact = 16.0 / 3.0 * mu_0 / (far + near) ** 3 * elliprd(0.0, 4.0 * far * near / (far + near) ** 2, 1.0)
    np.testing.assert_allclose(reduced_mutual(np.ones(b.size), b, d), exact, rtol=1e-13)
    assert np.isinf(mutual_loops(1.0, 1.0, 0.0)) and mutual_loops(1.0, 0.0, 0.0) == 0.0


def test_far_loops_are_dipoles_without_loss_of_digits():
    a, b, d = 1e-3, 5e-6, 10.0
    assert mutual_loops(a, b, d) == pytest.approx(mu_0 * np.pi * a**2 * b**2 / (2 * d**3), rel=1e-7, abs=0)


def test_thin_square_ring_has_the_self_inductance_of_its_mean_distance():
    # Grover: L = mu0 a (ln(8 a / g) - 2) to order (w/a)^2, g = 0.44705 w for a square section
    a, w = 1.0, 1e-3
    expected = mu_0 * a * (np.log(8 * a / (0.44704917 * w)) - 2)
    assert float(ring_inductance(ring(a, w, w))[0, 0]) == pytest.approx(expected, rel=1e-6)


def test_ring_is_the_mean_over_its_quarters():
    whole = ring(1.0, 0.3, 0.2)
    quarters = Sections(
        np.array([0.925, 1.075, 0.925, 1.075]), np.array([-0.05, -0.05, 0.05, 0.05]), np.full(4, 0.15), np.full(4, 0.1)
    )
    assert float(ring_inductance(whole)[0, 0]) == pytest.approx(float(ring_inductance(quarters).mean()), rel=1e-5)
    near = ring(1.4, 0.1, 0.1, 0.05)
    assert float(ring_mutual(whole, near)[0, 0]) == pytest.approx(float(ring_mutual(quarters, near).mean()), rel=1e-5)


def test_quadrature_of_the_regular_part_converges():
    rings = coil_sections(coil())
    fine = ring_inductance(rings, points=(5, 5)).sum()
    errors = [abs(ring_inductance(rings, points=(n, n)).sum() / fine - 1) for n in (1, 2, 3)]
    assert errors[0] < 1e-4 and errors[1] < 1e-8 and errors[2] < 1e-8


def test_coils_equal_finite_elements():
    # NGSolve 6.2: axisymmetric p = 6 for L0 (1e-6); 3D for the mutual of coils 8 mm apart, printed to 1e-4 nH
    L = free_inductances((coil("C1", -4 * MM), coil("C2", 4 * MM),))
    np.testing.assert_allclose(np.diag(L), 2.507569757e-06, rtol=1e-6)
    assert L[0, 1] == pytest.approx(-47.4298e-9, rel=1e-5, abs=0)
    assert L[0, 1] == L[1, 0]


def test_side_by_side_tends_to_coaxial_and_to_dipoles():
    small, large = ring(0.2, 0.01, 0.01), ring(1.0, 0.02, 0.02, 0.3)
    coaxial = float(ring_mutual(small, large)[0, 0])
    assert mutual_side_by_side(small, large, 0.0) == pytest.approx(coaxial, rel=1e-7, abs=0)
    assert mutual_side_by_side(small, large, 1e-6) == pytest.approx(coaxial, rel=1e-7, abs=0)
    far = mutual_side_by_side(ring(0.2, 1e-3, 1e-3), ring(0.1, 1e-3, 1e-3), 100.0, error=1e-22)
    assert far == pytest.approx(-mu_0 * np.pi * 0.2**2 * 0.1**2 / (4 * 100.0**3), rel=1e-4, abs=0)


def test_side_by_side_is_reciprocal():
    first, second = coil_sections(coil()), ring(1 * MM, 0.2 * MM, 0.1 * MM, 0.4 * MM)
    forth = mutual_side_by_side(first, second, 6 * MM, error=1e-18)
    back = mutual_side_by_side(second, first, 6 * MM, error=1e-18)
    assert forth == pytest.approx(back, rel=1e-8, abs=0)


def test_array_of_four_is_symmetric_positive_and_scales_with_length():
    places = [(-4, -4), (4, -4), (-4, 4), (4, 4)]
    L = free_inductances(tuple(coil(f"C{i}", x * MM, y * MM) for i, (x, y) in enumerate(places)))
    np.testing.assert_allclose(L, L.T, rtol=0, atol=0)
    assert np.linalg.eigvalsh(L).min() > 0
    assert L[0, 1] == pytest.approx(L[0, 2], rel=1e-5)
    assert abs(L[0, 3]) < abs(L[0, 1])
    rings = coil_sections(coil())
    doubled = Sections(*(2 * value for value in (rings.radius, rings.z, rings.width, rings.height)))
    assert ring_inductance(doubled).sum() == pytest.approx(2 * ring_inductance(rings).sum(), rel=1e-12, abs=0)


def grid(count: int, pitch: float = 8 * MM, middle: tuple[float, float] = (0.0, 0.0)) -> list[Coil]:
    """Coils of the published winding on a square grid, row by row."""
    places = (np.arange(count) - (count - 1) / 2) * pitch
    return [coil(f"C{i}{j}", middle[0] + x, middle[1] + y) for i, x in enumerate(places) for j, y in enumerate(places)]


def around(rings: Sections, distance: float, counts: tuple[int, int]) -> float:
    """Mutual inductance by the definition: every Gauss filament at every angle, no polynomial between."""
    (r, wr), (z, wz) = map(np.polynomial.legendre.leggauss, counts)
    a = (rings.radius[:, None, None] + rings.width[:, None, None] / 2 * r[:, None] + 0 * z).ravel()
    za = (rings.z[:, None, None] + rings.height[:, None, None] / 2 * z + 0 * r[:, None]).ravel()
    weight = np.tile((wr[:, None] * wz / 4).ravel(), rings.radius.size)
    cosine, total = np.cos(np.pi * (np.arange(512) + 0.5) / 512), 0.0
    for radius, height, share in zip(a, za, weight, strict=True):
        rho = np.sqrt(radius**2 + distance**2 + 2 * radius * distance * cosine)
        M = weight @ mutual_loops(a[:, None], rho, (za - height)[:, None])
        total += share * float((M / rho**2 * radius * (radius + distance * cosine)).mean())
    return total


@pytest.mark.parametrize(("distance", "counts"), [(3.4, (4, 3)), (8.0, (2, 2)), (90.0, (2, 2))])
def test_polynomials_across_a_winding_lose_no_digits(distance: float, counts: tuple[int, int]) -> None:
    """Windings of three turns 0.2 mm apart, some way off, and at the corners of a large array."""
    rings = coil_sections(coil().model_copy(update={"turns": 3, "layers": 1}))
    direct = around(rings, distance * MM, counts)
    assert mutual_side_by_side(rings, rings, distance * MM, error=1e-20) == pytest.approx(direct, rel=1e-10, abs=0)


def test_grid_of_sixteen_has_the_symmetry_of_its_square() -> None:
    """Quarter turn and mirror of the grid permute its coils, and the matrix; exactly, as pairs are computed once."""
    L, index = free_inductances(tuple(grid(4))), np.arange(16).reshape(4, 4)
    for image in (np.rot90(index), index.T, index[::-1]):
        np.testing.assert_array_equal(L[np.ix_(image.ravel(), image.ravel())], L)
    assert np.unique(L).size == 1 + 9  # itself, and nine distances


def test_inductances_depend_on_neither_order_nor_place_nor_other_coils() -> None:
    """Two kinds of windings among six coils."""
    coils = [c.model_copy(update={"turns": 10}) if k % 2 else c for k, c in enumerate([*grid(2), *grid(2)[:2]])]
    coils[4], coils[5] = (c.model_copy(update={"name": f"D{k}", "centre": (k * 20 * MM, 30 * MM)})
                          for k, c in enumerate(coils[4:]))
    L, order = free_inductances(tuple(coils)), [3, 5, 0, 4, 2, 1]
    np.testing.assert_array_equal(free_inductances(tuple(coils[k] for k in order)), L[np.ix_(order, order)])
    np.testing.assert_array_equal(free_inductances(tuple(coils[1:3])), L[1:3, 1:3])
    moved = [c.model_copy(update={"centre": (c.centre[0] + 0.1, c.centre[1] - 0.037)}) for c in coils]
    np.testing.assert_allclose(free_inductances(tuple(moved)), L, rtol=1e-10)


def test_moving_a_coil_by_a_nanometre_moves_its_inductances_by_as_little() -> None:
    """No jump where distances stop to be equal."""
    near = free_inductances((coil("C1"), coil("C2", 8 * MM), coil("C3", 0.0, 8 * MM),))
    far = free_inductances((coil("C1"), coil("C2", 8 * MM), coil("C3", 0.0, 8 * MM + 1e-9),))
    assert 3e-9 / (8 * MM) < 1 - far[0, 2] / near[0, 2] < 6e-9 / (8 * MM)  # a little steeper than a dipole
    assert far[0, 1] == near[0, 1]


@pytest.mark.parametrize(("distance", "gap"), [(0.0, 0.1), (0.5, 0.1), (20.05, 0.0)])
def test_wide_tracks_close_together_are_worth_many_narrow_ones(distance: float, gap: float) -> None:
    """2 mm wide, stacked, off the axis, side by side, 0.1 mm or less between; as strips of 0.1 mm in parallel."""
    wide = ring(9 * MM, 2 * MM, 35e-6)
    radii = 8 * MM + 0.1 * MM * (np.arange(20) + 0.5)
    narrow = Sections(radii, *(np.full(20, side) for side in (0.0, 0.1 * MM, 35e-6)))
    down = gap * MM + 35e-6 if gap else 0.0
    pair = (wide, narrow), (replace(wide, z=wide.z - down), replace(narrow, z=narrow.z - down))
    (M, strips) = (
        mutual_side_by_side(one, other, distance * MM, error=1e-14) for one, other in zip(*pair, strict=True)
    )
    assert M == pytest.approx(strips / 400, rel=2e-4, abs=0)
    assert abs(M) < float(ring_inductance(wide)[0, 0])


# S. S. Mohan and others, IEEE J. Solid-State Circuits 34 (1999) 1419, table II: c1, c2, c3, c4 of current sheets.
SHEETS = {"circle": (1.0, 2.46, 0.0, 0.2), "octagon": (1.07, 2.29, 0.0, 0.19), "hexagon": (1.09, 2.23, 0.0, 0.17)}


def wound(shape: str, turns: int, inner: float, **keys: float) -> Coil:
    """A coil in one layer, tracks and gaps of 0.15 mm."""
    sizes = dict.fromkeys(("track_width", "track_gap"), 0.15 * MM) | {"track_thickness": 20e-6, "layer_pitch": 20e-6}
    return Coil(name="C", centre=(0, 0), shape=shape, layers=1, turns=turns, inner_diameter=inner, **sizes, **keys)


@pytest.mark.parametrize("turns, inner", [(5, 4 * MM), (8, 5 * MM)])
def test_polygons_are_as_current_sheets(turns: int, inner: float) -> None:
    """Within 3 %, windings from 0.6 of the outer size on; and in the order of what they enclose.

    Towards the middle the published hexagon's falls below the circle that it encloses (7 % at 0.13 of the outer size).
    """
    found = []
    for shape, (c1, c2, c3, c4) in SHEETS.items():
        coil = wound(shape, turns, inner)
        outer = coil.extent[0]
        mean, rho = (inner + outer) / 2, (outer - inner) / (outer + inner)
        sheet = mu_0 * turns**2 * mean * c1 / 2 * (np.log(c2 / rho) + c3 * rho + c4 * rho**2)
        found.append(float(free_inductances((coil,))[0, 0]))
        assert found[-1] == pytest.approx(sheet, rel=3e-2)
    assert found == sorted(found) and found[2] < 1.1 * found[0]


@pytest.mark.parametrize("shape", ["hexagon", "octagon", "D"])
def test_shapes_are_their_free_tracks(shape: str) -> None:
    """As the same lines in a scene's `path`, however they are turned."""
    sizes = {"inner_width": 2 * MM, "inner_length": 3 * MM} if shape == "D" else {"inner_diameter": 2 * MM}
    track = {"track_width": 0.1 * MM, "track_thickness": 35e-6}
    wound = {"name": "C", "centre": (1 * MM, 0.0), "layers": 2, "turns": 4, "track_gap": 0.1 * MM, "layer_pitch": 85e-6}
    coils = [Coil(**track, **wound, shape=shape, **sizes, alpha_z=angle) for angle in (0.0, 0.7)]
    for coil in coils:
        lines = [tuple(map(tuple, line.tolist())) for line, _ in coil_lines(coil)]
        free = Coil(**track, name="P", shape="path", path=lines)
        own, other = (float(free_inductances((each,))[0, 0]) for each in (coil, free))
        assert own == pytest.approx(other, rel=1e-8)
    first, second = (float(free_inductances((each,))[0, 0]) for each in coils)
    assert first == pytest.approx(second, rel=1e-12)
