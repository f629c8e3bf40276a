"""Where a law stops being stable: limits in closed form, by name of the test and stretch."""

import numpy as np
import pytest
from scipy.optimize import brentq

from sits_mech.notes import Note, NoteKind
from sits_mech.scene.materials import silicones
from sits_mech.silicone.material import Silicone
from sits_mech.silicone.stability import ellipticity, layer_notes, layer_words, renewed_notes, stability


def law(name: str, fitted_range: tuple[float, float] | None = None, **constants: object) -> Silicone:
    """Return a silicone without a name."""
    return Silicone("", name, constants, 1e9, fitted_range=fitted_range)


FALLING = law("yeoh", c10=10e3, c20=-500.0, c30=0.0)


def uniaxial_limit(c10: float, c20: float) -> float:
    """W(e), e = ln lambda: W'' = w1 I1'' + w11 I1'^2 with I1' = 2 l^2 - 2/l, I1'' = 4 l^2 + 2/l, by hand."""

    def curvature(x: float) -> float:
        excess = x**2 + 2 / x - 3
        return (c10 + 2 * c20 * excess) * (4 * x**2 + 2 / x) + 2 * c20 * (2 * x**2 - 2 / x) ** 2

    return brentq(curvature, 1.0, 3.0)


def planar_ellipticity_limit(c10: float, c20: float) -> float:
    """W = c10 g^2 + c20 g^4 in simple shear g: W'' = 0 at g^2 = -c10/(6 c20); its stretch is g/2 + sqrt(1 + g^2/4)."""
    g = np.sqrt(-c10 / (6 * c20))
    return float(g / 2 + np.sqrt(1 + g**2 / 4))


def test_shear_bands_are_as_soft_as_simple_shear_where_it_is_largest() -> None:
    """Planar: the softest band is simple shear's, W''(g) = 0 by hand; the same in tension and compression."""
    limits = dict(ellipticity(FALLING, (0.2, 4.0)).limits)
    assert limits["planar tension"] == pytest.approx(planar_ellipticity_limit(10e3, -500.0), rel=1e-6)
    assert limits["planar compression"] == pytest.approx(1 / limits["planar tension"], rel=1e-6)
    assert limits["uniaxial tension"] == pytest.approx(limits["biaxial compression"] ** -2, rel=1e-6)


def test_laws_of_growing_shear_stress_are_elliptic_and_flat_powers_are_not() -> None:
    """Ogden, one term: simple shear's stress ~ sinh(alpha e)/cosh(e) grows for ever where |alpha| >= 1.

    Where |alpha| < 1 it is largest at tanh(alpha e) tanh(e) = alpha, e the logarithmic strain.
    """
    for sound in (law("neo-hookean", shear_modulus=1.0), law("ogden", mu=(1.0, 1.0), alpha=(1.2, -2.0))):
        assert ellipticity(sound, (0.05, 20.0)).stable
    flat = law("ogden", mu=(1.0,), alpha=(0.5,))
    assert stability(flat, (0.1, 10.0)).stable
    e = brentq(lambda x: np.tanh(0.5 * x) * np.tanh(x) - 0.5, 0.1, 3.0)
    found = ellipticity(flat, (1.0, 6.0), ("planar",))
    assert found.first_unstable == pytest.approx(np.exp(e), rel=1e-6)


def test_falling_yeoh_is_named_by_test_and_stretch() -> None:
    """c20 < 0 and c30 = 0: the limit is the root of the curvature along the pull; every test has one."""
    found = stability(FALLING, (1.0, 4.0), ("uniaxial",))
    assert (found.stable, found.mode) == (False, "uniaxial tension")
    assert found.first_unstable == pytest.approx(uniaxial_limit(10e3, -500.0), rel=1e-9)
    everywhere = stability(FALLING, (0.2, 4.0))
    assert {name for name, _ in everywhere.limits} == {
        f"{mode} {way}" for mode in ("uniaxial", "planar", "biaxial") for way in ("tension", "compression")
    }
    limits = dict(everywhere.limits)
    assert limits["planar tension"] == pytest.approx(1 / limits["planar compression"], rel=1e-9)
    assert limits["biaxial tension"] == pytest.approx(limits["uniaxial compression"] ** -0.5, rel=1e-9)
    assert limits["biaxial compression"] == pytest.approx(limits["uniaxial tension"] ** -0.5, rel=1e-9)
    assert everywhere.first_unstable == limits[everywhere.mode]


def test_planar_limit_is_where_the_tangent_is_singular() -> None:
    """Planar, by hand: at (e, 0, -e), the smaller eigenvalue of the second differences of W changes sign."""
    limit = stability(FALLING, (1.0, 4.0), ("planar",)).first_unstable
    assert limit is not None

    def smallest(stretch: float) -> float:
        def w(a: float, b: float) -> float:
            excess = np.exp(2 * (np.log(stretch) + a)) + np.exp(2 * b) + np.exp(-2 * (np.log(stretch) + a + b)) - 3
            return 10e3 * excess - 500.0 * excess**2

        h = 1e-3
        aa, bb = (w(h, 0) - 2 * w(0, 0) + w(-h, 0)) / h**2, (w(0, h) - 2 * w(0, 0) + w(0, -h)) / h**2
        ab = (w(h, h) - w(h, -h) - w(-h, h) + w(-h, -h)) / (4 * h**2)
        return float(np.linalg.eigvalsh([[aa, ab], [ab, bb]])[0])

    assert smallest(limit * 0.999) > 0.0 > smallest(limit * 1.001)


def test_ogden_of_opposite_sign() -> None:
    """mu < 0 on the larger exponent: along the pull h = sum 2 mu (2/3 l^a + 1/3 l^(-a/2)), zero at the limit."""
    mixed = law("ogden", mu=(30e3, -1e3), alpha=(2.0, 6.0))

    def stiffness(x: float) -> float:
        return sum(2 * m * (2 / 3 * x**a + 1 / 3 * x ** (-a / 2)) for m, a in ((30e3, 2.0), (-1e3, 6.0)))

    found = stability(mixed, (1.0, 4.0), ("uniaxial",))
    assert found.mode == "uniaxial tension"
    assert found.first_unstable == pytest.approx(brentq(stiffness, 1.0, 4.0), rel=1e-9)
    assert stability(law("ogden", mu=(30e3, 1e3), alpha=(2.0, -6.0)), (0.1, 10.0)).stable


def test_gent_locks_and_mooney_of_negative_c01_fails_where_its_shear_stiffness_does() -> None:
    """Gent: lambda^2 + 2/lambda = 3 + j_m. Mooney: c10 + c01 lambda^2 = 0, the tangent across a pull, comes first."""
    found = stability(law("gent", shear_modulus=30e3, j_m=5.0), (1.0, 4.0), ("uniaxial",))
    assert found.first_unstable == pytest.approx(brentq(lambda x: x**2 + 2 / x - 8.0, 1.0, 4.0), rel=1e-9)
    found = stability(law("mooney-rivlin", c10=10e3, c01=-2.5e3), (1.0, 4.0), ("uniaxial",))
    assert found.first_unstable == pytest.approx(2.0, rel=1e-9)


def test_one_that_is_unstable_from_the_start() -> None:
    """A negative stiffness at rest is found at stretch one."""
    assert stability(law("yeoh", c10=-1.0, c20=0.0, c30=0.0), (0.9, 1.1)).first_unstable == 1.0


def test_neo_hookean_never_fails() -> None:
    """Its energy is convex in the logarithmic strains."""
    assert stability(law("neo-hookean", shear_modulus=1.0), (0.02, 50.0)).stable


@pytest.mark.parametrize("name", silicones())
def test_catalogue_is_stable_over_its_data(name: str) -> None:
    """Tension up to the data's end and compression to its reciprocal, all three tests, without a note."""
    silicone = silicones()[name]
    reach = 1.0 + (silicone.fitted_range[1] if silicone.fitted_range else 1.0)
    assert stability(silicone, (1.0 / reach, reach)).stable
    assert layer_notes(silicone, reach) == ()


def test_notes_for_a_solve_name_law_test_and_stretch() -> None:
    """Silent within the limits; beyond them one line each for stability, locking, and the end of the data."""
    assert layer_notes(FALLING, 1.2) == ()
    (note,) = layer_notes(FALLING, 3.0)
    first = planar_ellipticity_limit(10e3, -500.0)
    assert first < min(stability(FALLING, (1.0, 3.0), ("planar",)).first_unstable or 9, uniaxial_limit(10e3, -500.0))
    assert note.kind is NoteKind.LAW_END and note.known["reached"] == 3.0 and note.known["silicone"] == "the yeoh law"
    assert note.known["stretch"] == pytest.approx(first, rel=1e-6)
    assert layer_words(note).startswith("the yeoh law is unstable from stretch")
    assert f"{first:.4g}" in layer_words(note) and "this solve reached 3" in layer_words(note)
    (note,) = layer_notes(law("gent", shear_modulus=30e3, j_m=5.0), 3.0)
    assert note.kind is NoteKind.LAW_END and "the gent law locks from stretch" in layer_words(note)
    (note,) = layer_notes(law("neo-hookean", fitted_range=(0.05, 1.0), shear_modulus=1.0), 2.5)
    assert note == Note.of(NoteKind.DATA_END, silicone="the neo-hookean law", stretch=2.0, reached=2.5)
    assert layer_words(note) == "the data of the neo-hookean law end at stretch 2, this solve reached 2.5"


def test_notes_follow_a_corrected_stretch() -> None:
    """What was said of the stretch goes or is said of the new one; other notes stay."""
    silicone = law("neo-hookean", fitted_range=(0.05, 1.0), shear_modulus=1.0)
    other = Note.of(NoteKind.STATED, text="wide faces")
    said = (other, *layer_notes(silicone, 2.5))
    assert renewed_notes(said, silicone, 1.9) == (other,)
    assert renewed_notes(said, silicone, 2.2) == (other, *layer_notes(silicone, 2.2)) != said
    assert renewed_notes((), silicone, 1.9) == ()


def test_impossible_ranges_are_refused() -> None:
    """A range without rest in it, a stretch below one, a test that does not exist."""
    for ends in ((1.1, 2.0), (0.0, 2.0), (0.5, 0.9), (0.5, float("inf")), (float("nan"), 2.0)):
        with pytest.raises(ValueError, match="stretch_range: must be positive, finite, with 1 between"):
            stability(FALLING, ends)
    for reach in (0.5, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="largest_stretch: must be finite and at least 1"):
            layer_notes(FALLING, reach)
    with pytest.raises(ValueError, match="mode: must be one of"):
        stability(FALLING, (0.5, 2.0), ("torsion",))
