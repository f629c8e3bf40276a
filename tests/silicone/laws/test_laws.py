"""The laws, each for itself, and what a new one takes: one `Law` in the table, and all that reads laws takes it."""

import numpy as np
import pytest

from sits_mech.analysis.material.fitted import fit_law
from sits_mech.analysis.material.tensile import TensileTest
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.energy import isochoric_energy
from sits_mech.silicone.homogeneous import energy_density, engineering_stress, principal_stretches, tangent
from sits_mech.silicone.kinematics import in_plane, in_space
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.laws.law import InvariantDerivatives, Invariants, Law, LinearFit, OfInvariants, TermFit
from sits_mech.silicone.material import Silicone
from sits_mech.silicone.stability import stability


def _mixed(c, at):
    """w = a x + b x y + c y^2 of x = I1 - 3, y = I2 - 3: every second derivative but one."""
    x, y, one = at.I1 - 3.0, at.I2 - 3.0, np.ones_like(at.I1)
    w = c["a"] * x + c["b"] * x * y + c["c"] * y**2
    return InvariantDerivatives(
        w, c["a"] + c["b"] * y, c["b"] * x + 2.0 * c["c"] * y, w_12=c["b"] * one, w_22=2.0 * c["c"] * one
    )


def _exponential(c, at):
    """w = mu/(2 b) (exp(b (I1 - 3)) - 1): H. Demiray, J. Biomech. 5 (1972) 309."""
    slope = 0.5 * c["mu"] * np.exp(c["b"] * (at.I1 - 3.0))
    return InvariantDerivatives((slope - 0.5 * c["mu"]) / c["b"], slope, w_11=c["b"] * slope)


NEW = {
    "mixed": Law(
        name="mixed",
        units={"a": "Pa", "b": "Pa", "c": "Pa"},
        shear_modulus=lambda c: 2.0 * c["a"],
        energy=OfInvariants(_mixed),
        fit=LinearFit(),
    ),
    "exponential": Law(
        name="exponential",
        units={"mu": "Pa", "b": ""},
        shear_modulus=lambda c: c["mu"],
        energy=OfInvariants(_exponential),
        fit=TermFit(
            constants=lambda m, x: {"mu": float(m[0]), "b": float(x[0])},
            starts=lambda reach: np.array([0.1, 1.0]) / reach,
            limits=lambda x, reach: (np.full_like(x, 1e-6 / reach), np.full_like(x, 10.0 / reach)),
            held=lambda x, reach: x < 1e-4 / reach,
            note="the data show no stiffening",
        ),
    ),
}
CONSTANTS = {"mixed": {"a": 12e3, "b": 300.0, "c": 200.0}, "exponential": {"mu": 25e3, "b": 0.12}}


@pytest.fixture(params=[*NEW])
def new_law(request, monkeypatch):
    """One entry more among the laws."""
    monkeypatch.setitem(LAWS, request.param, NEW[request.param])
    return request.param


def test_the_table_names_each_law_by_its_own_name():
    assert [*LAWS] == ["neo-hookean", "mooney-rivlin", "yeoh", "ogden", "gent"]
    assert all(name == law.name for name, law in LAWS.items())


OF_INVARIANTS = {
    "neo-hookean": {"shear_modulus": 3e4},
    "mooney-rivlin": {"c10": 1e4, "c01": 5e3},
    "yeoh": {"c10": 1.5e4, "c20": -300.0, "c30": 40.0},
    "gent": {"shear_modulus": 3e4, "j_m": 20.0},
}


@pytest.mark.parametrize("name", OF_INVARIANTS)
def test_derivatives_by_the_invariants_are_exact(name):
    """Central differences; a derivative left out is zero."""
    law, constants = LAWS[name], OF_INVARIANTS[name]
    I1, I2, h = np.linspace(3.0, 8.0, 7), np.linspace(3.1, 6.0, 7), 1e-5

    def at(one, two):
        found = law.energy.derivatives(constants, Invariants(I1 + one, lambda: I2 + two))
        return [np.zeros(7) if item is None else item for item in found]

    mid, up, down = at(0, 0), (at(h, 0), at(0, h)), (at(-h, 0), at(0, -h))
    for k, (value, slope) in enumerate(((0, 1), (0, 2), (1, 3), (1, 4), (2, 4), (2, 5))):
        way = k % 2
        difference = (up[way][value] - down[way][value]) / (2 * h)
        np.testing.assert_allclose(difference, mid[slope], rtol=1e-7, atol=1e-3)


def test_derivatives_by_the_strains_are_exact():
    """Ogden's: central differences, and the quotient of two strains far apart, close, and equal."""
    energy, c = LAWS["ogden"].energy, {"mu": (2e4, 1e4), "alpha": (1.7, -2.6)}
    e, h = np.array([[0.3, -0.1, -0.2], [0.2, 0.2 + 1e-10, -0.4], [0.1, 0.1, -0.2], [0.0, 0.0, 0.0]]), 1e-5
    d, up, down = (energy.derivatives(c, e + step) for step in (0.0, h, -h))
    np.testing.assert_allclose((up.f - down.f) / (2 * h), d.f_1, rtol=1e-8)
    np.testing.assert_allclose((up.f_1 - down.f_1) / (2 * h), d.f_11, rtol=1e-8)
    for pair, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        exact = (d.f_1[0, i] - d.f_1[0, j]) / (np.exp(e[0, i]) - np.exp(e[0, j]))
        assert d.quotient[0, pair] == pytest.approx(exact, rel=1e-12)
    limit = d.f_11[1:, 0] / np.exp(e[1:, 0])
    np.testing.assert_allclose(d.quotient[1:, 2], limit, rtol=1e-9)


def test_new_law_has_the_stress_and_tangent_of_its_energy(new_law):
    """By differences, in space; and the plane is a case of it."""
    rng, law = np.random.default_rng(2), isochoric_energy(Silicone("", new_law, CONSTANTS[new_law], 1e9), 1.5)
    F, h = np.eye(3).ravel() + 0.2 * rng.normal(size=(12, 9)), 1e-6
    F = F[in_space(F).J > 0.2]
    _, P, A = law(in_space(F))
    ends = [[law(in_space(F + way * h * step))[:2] for way in (1, -1)] for step in np.eye(9)]
    slope, stiffness = (np.stack([(up[k] - down[k]) / (2 * h) for up, down in ends], axis=-1) for k in (0, 1))
    np.testing.assert_allclose(P, slope, atol=1e-7 * np.abs(P).max())
    np.testing.assert_allclose(A, stiffness, atol=1e-6 * np.abs(A).max())
    flat = np.tile(np.eye(3).ravel(), (len(F), 1))
    some = [0, 2, 6, 8]
    flat[:, some] += 0.2 * rng.normal(size=(len(F), 4))
    for one, other in zip(law(in_plane(flat[:, some])), law(in_space(flat)), strict=True):
        other = other if other.ndim == 1 else other[:, some]
        np.testing.assert_allclose(one, other if other.ndim < 3 else other[:, :, some], atol=1e-12)


def test_new_law_is_pulled_fitted_and_judged(new_law):
    """Stress by hand, 3 mu at rest, exact constants from exact data, a limit where its curvature ends."""
    c, strain = CONSTANTS[new_law], np.linspace(0.0, 1.0, 51)
    stress = engineering_stress(new_law, c, strain)
    x, y = 2.0, 2.0 * 2.0 + 0.25 - 3.0  # stretch 2: I1 = 5, I2 = 2 lambda + lambda^-2
    w_1, w_2 = {
        "mixed": (c.get("a", 0) + c.get("b", 0) * y, c.get("b", 0) * x + 2 * c.get("c", 0) * y),
        "exponential": (0.5 * c.get("mu", 0) * np.exp(c["b"] * x), 0.0),
    }[new_law]
    assert stress[-1] == pytest.approx(2 * (w_1 + w_2 / 2) * 1.75, rel=1e-12)
    mu = Silicone("", new_law, c, 1e9).shear_modulus
    assert tangent(new_law, c, np.ones((1, 3)))[0] == pytest.approx(2 * mu * np.eye(2), rel=1e-12, abs=1e-12 * mu)
    fit = fit_law(TensileTest(strain, stress, "made"), new_law)
    assert fit.stable and fit.notes == ()
    assert fit.constants == pytest.approx(c, rel=1e-6)
    assert stability(Silicone("", new_law, c, 1e9), (0.4, 2.5)).stable
    softening = c | ({"c": -900.0} if new_law == "mixed" else {"b": -0.3})
    assert not stability(Silicone("", new_law, softening, 1e9), (0.4, 2.5)).stable


def test_tangent_in_uniform_tests_is_the_curvature_of_the_energy(new_law):
    """Second differences of ``W(I1, I2)`` in logarithmic strain; mixed derivatives of the invariants take part."""
    c, strains, h = CONSTANTS[new_law], np.log(principal_stretches("uniaxial", np.array([0.7, 1.0, 1.6]))), 1e-3
    basis = np.array([[2.0, -1.0, -1.0], [0.0, 1.0, -1.0]]) / np.sqrt([[6.0], [2.0]])

    def w(e):
        square = np.exp(2 * e)
        at = Invariants(square.sum(axis=1), lambda: (1 / square).sum(axis=1))
        return NEW[new_law].energy.derivatives(c, at).w

    found = tangent(new_law, c, np.exp(strains))
    for way in ([1.0, 0.0], [0.0, 1.0], [0.6, 0.8]):
        way = np.array(way)
        curvature = (w(strains + h * (way @ basis)) - 2 * w(strains) + w(strains - h * (way @ basis))) / h**2
        assert way @ found @ way == pytest.approx(curvature, rel=1e-4)


def test_new_law_stands_in_a_scene(new_law):
    """The scene's schema reads the table of laws."""
    table = ", ".join(f"{name}={value}" for name, value in CONSTANTS[new_law].items())
    sensor = load_sensor("biorob2018", [f'elastomer.material={{law="{new_law}", {table}, bulk_modulus="30 MPa"}}'])
    assert sensor.elastomer is not None
    assert dict(sensor.elastomer.silicone.constants) == CONSTANTS[new_law]


@pytest.mark.parametrize(("law", "constants"), [
    ("neo-hookean", {"shear_modulus": 3e4}), ("mooney-rivlin", {"c10": 1e4, "c01": 4e3}),
    ("yeoh", {"c10": 1.5e4, "c20": 500.0, "c30": 10.0}), ("ogden", {"mu": (2e4, 1e4), "alpha": (1.6, -3.0)}),
    ("gent", {"shear_modulus": 3e4, "j_m": 12.0}),
])
def test_a_stiffer_law_has_a_square_of_the_first_invariant_more(law, constants) -> None:
    """Of the share's half of the shear modulus, to lowest order of the strain and of the share; no modulus changes."""
    share, e = 1e-3, 0.02 * np.array([[1.0, -0.5, -0.5], [1.0, 0.0, -1.0], [0.7, 0.5, -1.2]])
    other = LAWS[law].stiffened(constants, share)
    mu = LAWS[law].shear_modulus(constants)
    assert LAWS[other[0]].shear_modulus(other[1]) == pytest.approx(mu, rel=1e-14)
    more = energy_density(*other, np.exp(e)) - energy_density(law, constants, np.exp(e))
    square = (np.exp(2.0 * e).sum(axis=1) - 3.0) ** 2
    assert more == pytest.approx(0.5 * share * mu * square, rel=0.05)
