"""Straight tracks: pairs by quadrature, squares by sums of other formulas and by published ones, circles by rings."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.constants import mu_0
from scipy.integrate import dblquad

from sits_mech.geometry.tracks import TrackBars, coil_tracks
from sits_mech.geometry.windings import coil_sections, turn_radii
from sits_mech.magnetics.coils.loops import free_inductances, ring_inductance
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.magnetics.coils.ring_field import coil_potential
from sits_mech.magnetics.coils.straight import linkage, track_potential
from sits_mech.memory import SECONDS
from sits_mech.scene.parts.coils import Coil
from sits_mech.units import SceneError

MM = 1e-3
ONE = np.zeros(1), np.ones(1)  # a filament in the middle


def line(start: Any, end: Any, width: float = 1e-10) -> TrackBars:
    """Return one track [mm]."""
    sides = np.array([width]), np.array([width])
    return TrackBars(MM * np.array([start], dtype=float), MM * np.array([end], dtype=float), *sides)


def square(turns: int, outer: float, width: float, gap: float, **keys: Any) -> Coil:
    """Return a square coil [mm]."""
    inner = (outer - 2 * (turns * width + (turns - 1) * gap)) * MM
    sizes = {"inner_width": inner, "inner_length": inner, "track_width": width * MM, "track_gap": gap * MM}
    sizes |= {"name": "S", "shape": "rectangle", "centre": (0.0, 0.0), "layers": 1, "turns": turns}
    return Coil(**sizes | {"track_thickness": 35e-6, "layer_pitch": 1e-3} | keys)


def own(coil: Coil) -> float:
    """Return L0 [H]."""
    return float(free_inductances((coil,))[0, 0])


@pytest.mark.parametrize("height", [0.0, 0.3])
@pytest.mark.parametrize("turn", [0.2, 1.1, 2.5, 3.3])
def test_tracks_at_an_angle_by_quadrature(turn: float, height: float) -> None:
    """Neumann's double integral of two filaments."""
    first = line((0, 0, 0), (2, 0, 0))
    second = line((0.5, 0.4, height), (0.5 + math.cos(turn), 0.4 + math.sin(turn), height))
    a, b = first.start[0], second.start[0]
    s, t = first.end[0] - a, second.end[0] - b
    found, _ = dblquad(lambda u, v: 1.0 / np.linalg.norm(a + u * s - b - v * t), 0, 1, 0, 1, epsabs=0, epsrel=1e-8)
    expected = mu_0 / (4 * np.pi) * float(s @ t) * found
    assert linkage(first, second) == pytest.approx(expected, rel=1e-7)
    assert linkage(second, first) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("turn", [1e-9, 1.1e-7, 4e-7, 1e-6, 2.9e-6, 3.1e-6, 1e-5])
def test_nearly_parallel_tracks(turn: float) -> None:
    """Rounding must not rule where the two lines meet far away: M goes with the turn, 2.32 of it (at 1e-4 and 1e-3)."""
    size = np.array([3e-4]), np.array([35e-6])
    own = TrackBars(np.array([[6.85e-3, 0.0, 0.0]]), np.array([[-6.85e-3, 0.0, 0.0]]), *size)
    ends = [[-5.85e-3, 1e-3 - angle * 11.7e-3, 0.0] for angle in (0.0, turn)]
    others = [TrackBars(np.array([[5.85e-3, 1e-3, 0.0]]), np.array([end]), *size) for end in ends]
    straight, turned = (linkage(own, other) for other in others)
    assert turned / straight - 1.0 == pytest.approx(2.32 * turn, abs=1e-6)


def test_parallel_bars_with_their_sections() -> None:
    """4 x 4 filaments in each bar, of 0.2 x 0.1 mm, 0.1 mm apart and shifted: Neumann's closed form for each pair."""
    first = TrackBars(*(np.array([p]) * MM for p in ([0.0, 0, 0], [5.0, 0, 0])), np.array([2e-4]), np.array([1e-4]))
    second = TrackBars(
        *(np.array([p]) * MM for p in ([1.0, 0.3, 0], [7.0, 0.3, 0])), np.array([2e-4]), np.array([1e-4])
    )
    nodes, weights = np.polynomial.legendre.leggauss(4)
    total = 0.0
    for a, wa in zip(nodes, weights, strict=True):
        for b, wb in zip(nodes, weights, strict=True):
            for c, wc in zip(nodes, weights, strict=True):
                for d, wd in zip(nodes, weights, strict=True):
                    gap = math.hypot(0.3 + 0.1 * (b - a), 0.05 * (d - c))
                    pair = line((0, 0, 0), (5, 0, 0)), line((1, gap, 0), (7, gap, 0))
                    total += wa * wb * wc * wd / 16 * linkage(*pair)
    assert linkage(first, second) == pytest.approx(total, rel=1e-4)


def test_a_track_in_pieces_is_the_same_track() -> None:
    """Cut anywhere."""
    whole = TrackBars(*(np.array([p]) * MM for p in ([0.0, 0, 0], [4.0, 0, 0])), np.array([1e-4]), np.array([4e-5]))
    x = MM * np.array([0.0, 0.1, 1.5, 1.7, 4.0])
    pieces = TrackBars(
        *(np.column_stack([p, 0 * p, 0 * p]) for p in (x[:-1], x[1:])), np.full(4, 1e-4), np.full(4, 4e-5)
    )
    assert linkage(pieces, pieces) == pytest.approx(linkage(whole, whole), rel=1e-12)


def _side(length: float, width: float, thickness: float) -> float:
    """Self-inductance of a bar: F. W. Grover, Inductance Calculations (1946), ch. 5."""
    both = width + thickness
    return mu_0 / (2 * np.pi) * length * (math.log(2 * length / both) + 0.5 + 0.2235 * both / length)


def _parallel(length: float, gap: float) -> float:
    """Mutual inductance of equal parallel filaments face to face: Grover, ch. 5."""
    x = length / gap
    return mu_0 / (2 * np.pi) * length * (math.asinh(x) - math.sqrt(1 + 1 / x**2) + 1 / x)


def _greenhouse(coil: Coil) -> float:
    """Sum over sides of concentric squares, with the mean distance of strips as a series in width over pitch.

    H. M. Greenhouse, IEEE Trans. Parts, Hybrids, Packag. 10 (1974) 101.
    """
    w, pitch = coil.track_width, coil.track_width + coil.track_gap
    sides = coil.inner_width + w + 2 * pitch * np.arange(coil.turns)
    total = 0.0
    for i, a in enumerate(sides):
        for j, b in enumerate(sides):
            near, far, over = abs(a - b) / 2, (a + b) / 2, abs(a - b) / 2
            short = min(a, b)
            for gap, sign in ((near, 1.0), (far, -1.0)):
                if gap == 0.0:
                    total += 4 * _side(a, w, coil.track_thickness)
                    continue
                q = (w / gap) ** 2
                mean = gap * math.exp(-(q / 12 + q**2 / 60 + q**3 / 168 + q**4 / 360))
                shared = _parallel(short + over, mean) - (_parallel(over, mean) if i != j else 0.0)
                total += 4 * sign * shared
    return total


@pytest.mark.parametrize(("turns", "gap"), [(1, 0.1), (5, 0.127), (18, 0.127), (10, 0.3)])
def test_squares_by_another_sum(turns: int, gap: float) -> None:
    """Greenhouse's sum with Grover's formulas; thin tracks, whose mean distance that series has."""
    coil = square(turns, 10.0, 0.127, gap, track_thickness=2e-6)
    assert own(coil) == pytest.approx(_greenhouse(coil), rel=3e-4)


def test_one_turn_by_the_formula_for_rectangles() -> None:
    """Grover, ch. 8, for two unlike sides: of the same parts, and with the published end correction."""
    a, b, w, t = 4 * MM, 9 * MM, 0.2 * MM, 35e-6
    coil = Coil(name="R", shape="rectangle", centre=(0.0, 0.0), layers=1, turns=1, inner_width=a - w,
                inner_length=b - w, track_width=w, track_thickness=t)
    g, d = 0.2235 * (w + t), math.hypot(a, b)
    expected = mu_0 / np.pi * (a * math.log(2 * a * b / (g * (a + d))) + b * math.log(2 * a * b / (g * (b + d)))
                               + 2 * d - 2 * (a + b))
    assert own(coil) == pytest.approx(expected, rel=3e-3)  # it leaves out g / a


def mohan(coil: Coil, outer: float) -> dict[str, float]:
    """The closed forms of S. S. Mohan et al., IEEE J. Solid-State Circuits 34 (1999) 1419: of circles, one."""
    n, w, s, is_square = coil.turns, coil.track_width, coil.track_gap, coil.shape == "rectangle"
    inner = outer - 2 * (n * w + (n - 1) * s)
    middle, fill = (outer + inner) / 2, (outer - inner) / (outer + inner)
    c1, c2, c3, c4 = (1.27, 2.07, 0.18, 0.13) if is_square else (1.00, 2.46, 0.00, 0.20)
    found = {"current sheet": mu_0 * n**2 * middle * c1 / 2 * (math.log(c2 / fill) + c3 * fill + c4 * fill**2)}
    if is_square:
        found["modified Wheeler"] = 2.34 * mu_0 * n**2 * middle / (1 + 2.75 * fill)
        um = 1e6
        found["monomial"] = 1e-9 * 1.62e-3 * (
            (outer * um) ** -1.21 * (w * um) ** -0.147 * (middle * um) ** 2.40 * n**1.78 * (s * um) ** -0.030
        )
    return found


@pytest.mark.parametrize("shape", ["rectangle", "circle"])
@pytest.mark.parametrize(
    ("turns", "outer", "width", "gap"),
    [(4, 2.0, 0.06, 0.03), (8, 4.0, 0.1, 0.1), (10, 6.0, 0.1, 0.1), (18, 10.0, 0.127, 0.127)],
)
def test_spirals_by_published_closed_forms(shape: str, turns: int, outer: float, width: float, gap: float) -> None:
    """Stated to 2 to 3 % of solved spirals."""
    coil = square(turns, outer, width, gap, track_thickness=1e-6)
    if shape == "circle":
        inner = coil.inner_width
        keys = coil.model_dump(exclude={"shape", "inner_width", "inner_length"})
        coil = Coil(**keys | {"inner_diameter": inner})
    for name, published in mohan(coil, outer * MM).items():
        assert own(coil) == pytest.approx(published, rel=0.03), name


def test_a_published_probe() -> None:
    """Square of 18 turns, 10 mm, 0.127 mm tracks and gaps: its designer's formula says 1.65 uH, of one layer.

    The board shows 3.57 uH; its layers are not known here: 18 turns in two layers give more, nine in each as much.
    """
    coil = square(18, 10.0, 0.127, 0.127)
    assert mohan(coil, 10 * MM)["modified Wheeler"] == pytest.approx(1.65e-6, rel=3e-3)
    assert own(coil) == pytest.approx(1.65e-6, rel=0.03)
    both = [own(square(18, 10.0, 0.127, 0.127, layers=2, layer_pitch=pitch)) for pitch in (0.2e-3, 1.53e-3)]
    assert both[0] > both[1] > 1.3 * 3.57e-6
    nine = [own(square(9, 10.0, 0.127, 0.127, layers=2, layer_pitch=pitch)) for pitch in (0.2e-3, 1.53e-3)]
    assert nine[0] > 3.57e-6 > nine[1]


def circle_path(coil: Coil, count: int) -> Coil:
    """Return a round coil's turns as polygons of free tracks."""
    angle = np.linspace(0.0, 2 * np.pi, count + 1)
    angle[-1] = 0.0
    lines = [
        tuple((float(r * np.cos(a)), float(r * np.sin(a)), z) for a in angle)
        for z in coil.heights for r in turn_radii(coil) * math.sqrt(2 * np.pi / count / math.sin(2 * np.pi / count))
    ]
    sizes = {key: getattr(coil, key) for key in ("name", "track_width", "track_thickness")}
    return Coil(**sizes, shape="path", path=tuple(lines))


def test_many_segments_are_a_circle() -> None:
    """Two layers of six turns, tracks of a fiftieth of the radius: to 1e-4 of the rings, polygons of the same area."""
    round_ = Coil(name="C", centre=(0.0, 0.0), layers=2, turns=6, inner_diameter=9 * MM, track_width=0.1 * MM,
                  track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=0.4 * MM)
    errors = [abs(own(circle_path(round_, count)) / own(round_) - 1.0) for count in (12, 24, 72)]
    assert errors[2] < 1e-4 and errors[0] > 4 * errors[1]


def test_fully_rounded_square_is_a_circle() -> None:
    """Corners as round as the innermost turn allows."""
    keys = {"turns": 5, "layers": 1, "track_width": 0.1 * MM, "track_gap": 0.1 * MM, "track_thickness": 35e-6}
    keys |= {"name": "C", "centre": (0.0, 0.0)}
    rounded = Coil(**keys, shape="rectangle", inner_width=4 * MM, inner_length=4 * MM, corner_radius=2.05 * MM)
    assert own(rounded) == pytest.approx(own(Coil(**keys, inner_diameter=4 * MM)), rel=5e-4)
    assert track_resistance(rounded) == pytest.approx(track_resistance(Coil(**keys, inner_diameter=4 * MM)), rel=2e-3)


def test_coils_of_unlike_shapes() -> None:
    """A rectangle beside rings: the flux by the rings' potential along its tracks."""
    ring = Coil(name="C", centre=(0.0, 0.0), layers=1, turns=3, inner_diameter=3 * MM, track_width=0.1 * MM,
                track_gap=0.1 * MM, track_thickness=35e-6)
    other = square(4, 5.0, 0.1, 0.1, name="S", centre=(5 * MM, 1 * MM))
    tracks, (nodes, weights) = coil_tracks(other), np.polynomial.legendre.leggauss(40)
    step = tracks.end - tracks.start
    flux = 0.0
    for node, weight in zip(nodes, weights, strict=True):
        A = coil_potential(ring, tracks.start + (1 + node) / 2 * step, 1 * MM)
        flux += weight / 2 * float((A * step).sum())
    L = free_inductances((ring, other,))
    assert L[0, 1] == L[1, 0] == pytest.approx(flux, rel=1e-3)
    assert L[0, 0] == pytest.approx(own(ring), rel=1e-12) and L[1, 1] == pytest.approx(own(other), rel=1e-12)


def test_layers_wound_against_each_other() -> None:
    """L = L1 + L2 - 2 M, of rings and of tracks."""
    keys = {"layers": 2, "track_thickness": 35e-6, "layer_pitch": 0.3e-3}
    for one in (square(5, 6.0, 0.1, 0.1, **keys), Coil(name="C", centre=(0.0, 0.0), turns=5, inner_diameter=3 * MM,
                                                       track_width=1e-4, track_gap=1e-4, **keys)):
        aiding, opposing = own(one), own(one.model_copy(update={"directions": (1, -1)}))
        alone = [own(one.model_copy(update={"layers": 1, "layer_z": (z,)})) for z in one.heights]
        assert (aiding + opposing) / 2 == pytest.approx(sum(alone), rel=1e-9)
        assert opposing < 0.3 * aiding


def test_long_coil_by_the_metre() -> None:
    """What a longer rectangle adds is the inductance per metre of its section: 1e-5 of 1 and 2 m."""
    from sits_mech.magnetics.section.coils import free_space_inductance
    from sits_mech.scene.sensor import Sensor

    short, long = (square(4, 6.0, 0.1, 0.1, inner_length=length) for length in (1.0, 2.0))
    section = free_space_inductance(Sensor(name="s", frequency=1e6, coils=(short,)))[0, 0]
    assert own(long) - own(short) == pytest.approx(section, rel=1e-5)


def test_tracks_without_number_are_refused_before_they_are_paired(monkeypatch: pytest.MonkeyPatch) -> None:
    tracks = coil_tracks(square(4, 6.0, 0.1, 0.1), "rings")
    monkeypatch.setenv(SECONDS.variable, "1e-6")
    with pytest.raises(SceneError, match="^coils: the inductance of 16 and 16 tracks must take at most 1e-06 s"):
        linkage(tracks, tracks)


@pytest.mark.slow
def test_many_layers_and_many_coils_share_their_distances() -> None:
    """A thousand layers by their thousand distances; two hundred squares by those of a grid."""
    keys = {"name": "C", "centre": (0.0, 0.0), "turns": 2, "inner_diameter": 3 * MM, "track_width": 1e-4}
    keys |= {"track_gap": 1e-4, "track_thickness": 35e-6, "layer_pitch": 50e-6}
    few = Coil(**keys, layers=12)
    assert own(few) == pytest.approx(ring_inductance(coil_sections(few)).sum(), rel=1e-12)
    assert own(Coil(**keys, layers=1000)) > 0.0
    places = [(i, j) for i in range(14) for j in range(15)]
    grid = [square(4, 4.0, 0.1, 0.1, name=f"{i} {j}", centre=(5 * MM * i, 5 * MM * j)) for i, j in places]
    L = free_inductances(tuple(grid))
    assert np.array_equal(L, L.T) and np.all(np.diag(L) == L[0, 0]) and L[0, 1] == L[1, 2] == L[15, 16]
    assert np.linalg.eigvalsh(L).min() > 0.0


def test_potential_of_tracks() -> None:
    """Grouped by direction or not: by the asinh of both ends, track by track."""
    rng = np.random.default_rng(1)
    places = rng.uniform(-4, 4, (12, 3)) * MM * (1, 1, 0)
    some = TrackBars(places[:-1], places[1:], *np.full((2, 11), 1e-4))
    points = rng.uniform(-4, 4, (3, 3, 5)) * MM + np.array([0, 0, 6 * MM])[:, None]
    for tracks in (some, coil_tracks(square(3, 4.0, 0.1, 0.1, layers=2))):
        expected = np.zeros((3, 2, 5))
        for start, end, way, length in zip(tracks.start, tracks.end, tracks.way, tracks.length, strict=True):
            seen = points - start[:, None]
            along = np.einsum("pkq,k->pq", seen[:, :2], way)
            away = np.sqrt((seen**2).sum(1) - along**2)
            expected += way[:, None] * (np.arcsinh((length - along) / away) + np.arcsinh(along / away))[:, None]
            assert np.allclose((end - start)[:2], length * way)
        np.testing.assert_allclose(track_potential(tracks, ONE, ONE)(points), 1e-7 * expected, rtol=1e-8, atol=1e-16)
