"""How far laws that fit one pull as well are from each other, and from the truth, where a pad is strained.

Truths are laws that others fitted to tests of several modes of vulcanised rubber, by energy [MPa]: R. W. Ogden, Proc.
R. Soc. A 326 (1972) 565; D. F. Jones, L. R. G. Treloar, J. Phys. D 8 (1975) 1285, by Ogden's terms; M. M. Carroll, J.
Elasticity 103 (2011) 173; R. W. Ogden, G. Saccomandi, I. Sgura, Comput. Mech. 34 (2004) 484 (2.4195, 77.931, 1.0233
kgf/cm^2). And the pull of Dragon Skin 10, which stiffens, with the share of I2 that Carroll's law has.
"""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.material.alike import REACH, LawWithConstants, as_good, central_law, largest_factor
from sits_mech.analysis.material.fitted import _points, fit_law, fit_tests
from sits_mech.analysis.material.tensile import Sizes, TensileTest
from sits_mech.silicone.homogeneous import energy_density, engineering_stress, principal_stretches, shear_secant
from sits_mech.silicone.laws import LAWS

STATES = np.vstack([
    principal_stretches("uniaxial", np.linspace(0.54, 0.97, 30)),
    principal_stretches("planar", np.linspace(1.03, 1.618, 30)),
])


def _ogden(mu, alpha):
    return lambda I1, I2, x: sum(m / n * ((x**n).sum(axis=1) - 3.0) for m, n in zip(mu, alpha, strict=True))


def _carroll(I1, I2, x):
    return 0.15 * (I1 - 3.0) + 3.1e-7 * (I1**4 - 81.0) + 0.095 * (np.sqrt(I2) - np.sqrt(3.0))


def _gent(I1, I2, x):
    return 0.0980665 * (1.0233 * np.log(I2 / 3.0) - 0.5 * 2.4195 * 77.931 * np.log(1.0 - (I1 - 3.0) / 77.931))


def _stiff(I1, I2, x):
    return 1e-3 * (21.8 * (I1 - 3.0) + 2.8 * (I1 - 3.0) ** 2 + 0.18 * 21.8 * (I2 - 3.0))


TRUTHS = {
    "ogden": _ogden((0.63, 0.0012, -0.01), (1.3, 5.0, -2.0)),
    "jones": _ogden((0.69, 0.01, -0.0122), (1.3, 4.0, -2.0)),
    "carroll": _carroll, "gent-gent": _gent, "stiff": _stiff,
}
TRELOAR = {  # L. R. G. Treloar, Trans. Faraday Soc. 40 (1944) 59: stretch, engineering stress [kgf/cm^2]
    "uniaxial": [(1.02, 0.26), (1.125, 1.37), (1.24, 2.30), (1.39, 3.23), (1.58, 4.16), (1.90, 5.10)],
    "biaxial": [
        (1.03, 0.95), (1.07, 1.60), (1.12, 2.42), (1.14, 2.62), (1.20, 3.32), (1.31, 4.43), (1.42, 5.18), (1.68, 6.60),
        (1.94, 7.78),
    ],
}


def energy(name: str, stretches: np.ndarray) -> np.ndarray:
    """Energy density of a truth [Pa] at stretches (n, 3)."""
    return 1e6 * TRUTHS[name]((stretches**2).sum(axis=1), (stretches**-2).sum(axis=1), stretches)


def pull(name: str, most: float, noise: float, rng: np.random.Generator) -> TensileTest:
    """A pull of 40 points up to a strain, with noise of a share of its largest stress."""
    strain = np.linspace(0.02, most, 40)
    ends = (energy(name, principal_stretches("uniaxial", 1.0 + strain + way * 1e-5)) for way in (1.0, -1.0))
    stress = np.subtract(*ends) / 2e-5
    return TensileTest(strain, stress + noise * stress.max() * rng.standard_normal(40), name)


def off(name: str, law: LawWithConstants) -> float:
    """Largest factor between the energies of a law and the truth."""
    return float(np.exp(np.abs(np.log(energy(name, STATES) / energy_density(*law[:2], STATES))).max()))


def treloar(folder: Path) -> dict[str, Path]:
    """Files of Treloar's tests."""
    for mode, rows in TRELOAR.items():
        lines = (f"{stretch},{stress}" for stretch, stress in rows)
        (folder / f"{mode}.csv").write_text("\n".join(["stretch,engineering stress (kgf/cm2)", *lines]))
    return {mode: folder / f"{mode}.csv" for mode in TRELOAR}


def test_factor_closed_forms() -> None:
    """Moduli of one to two: 2, either way; Mooney-Rivlin's w = c01 (I2 - 3) over neo-Hooke's: I2 - 3 over I1 - 3."""
    one, two = (LawWithConstants("neo-hookean", {"shear_modulus": mu}) for mu in (1.0, 2.0))
    assert largest_factor(one, [two]) == pytest.approx(2.0, rel=1e-12) == largest_factor(two, [one, two])
    assert largest_factor(one, [one]) == 1.0 and central_law([one, two])[1] == pytest.approx(2.0)
    stretch = 0.5392
    I1, I2 = stretch**2 + 2.0 / stretch, stretch**-2 + 2.0 * stretch
    assert I1 - 3.0 == pytest.approx(REACH, abs=2e-4)
    second = LawWithConstants("mooney-rivlin", {"c10": 0.0, "c01": 0.5})
    assert largest_factor(one, [second]) == pytest.approx((I2 - 3.0) / (I1 - 3.0), rel=1e-6)
    assert largest_factor(one, [LawWithConstants("gent", {"shear_modulus": 1.0, "j_m": 0.9})]) == np.inf  # locks before


@pytest.mark.slow
@pytest.mark.parametrize("noises", [(0.005,), (0.0, 0.005, 0.015)])
@pytest.mark.parametrize("most", [1.0, 0.6, 2.0])
def test_spread_holds_the_truth(most: float, noises: tuple[float, ...]) -> None:
    """By a pull alone, any law: in nine cases of ten; and it is no more than three times too wide on the mean."""
    rng, found = np.random.default_rng(0), []
    for name in TRUTHS:
        for noise in noises:
            test = pull(name, most, noise, rng)
            good = as_good(_points([test]))
            laws = [LawWithConstants(law, fit_law(test, law, most).constants) for law in LAWS]
            found += [(off(name, law) - 1.0, largest_factor(law, good) - 1.0) for law in laws]
    true, told = np.array(found).T
    assert np.mean(true <= told) >= 0.9
    assert told.mean() < 3.0 * true.mean()


def test_treloar_by_tension_alone(tmp_path: Path) -> None:
    """Three terms of Ogden: no exponent below one; equibiaxial stress, and Ogden's constants, within the spread."""
    files = treloar(tmp_path)
    fit = fit_tests(files["uniaxial"], None, None, law="ogden", terms=3).fit
    stretch, measured = np.array(TRELOAR["biaxial"])[3:7].T
    stress = engineering_stress("ogden", fit.constants, stretch - 1.0, "biaxial")
    np.testing.assert_allclose(stress, 98066.5 * measured, rtol=fit.mode_spread)
    assert min(fit.constants["alpha"]) >= 1.0 and 0.1 < fit.mode_spread < 0.3
    assert off("ogden", LawWithConstants("ogden", fit.constants)) < 1.0 + fit.mode_spread
    yeoh = fit_tests(files["uniaxial"], None, None).fit
    assert yeoh.notes[-1] == "ogden of 1 term is preferred: within 18 % of all of them"
    held = fit_tests(files["uniaxial"], None, None, law="mooney-rivlin").fit
    assert held.constants["c01"] == pytest.approx(0.5 * held.constants["c10"], rel=1e-6)
    assert "the constants are held by what other modes than tension allow" in held.notes


def test_a_test_of_another_mode_narrows_it(tmp_path: Path) -> None:
    """Treloar's equibiaxial test beside his pull, in a file of its own: a third of the spread, 4 % of its stresses."""
    files = treloar(tmp_path)
    also = Sizes(also=(("biaxial", str(files["biaxial"])),))
    fits = [fit_tests(files["uniaxial"], None, None, law="ogden", given=given).fit for given in (None, also)]
    assert fits[1].modes == ("uniaxial", "biaxial") and fits[1].mode_spread < 0.34 * fits[0].mode_spread
    stretch, measured = np.array(TRELOAR["biaxial"])[3:].T
    stress = engineering_stress("ogden", fits[1].constants, stretch - 1.0, "biaxial")
    np.testing.assert_allclose(stress, 98066.5 * measured, rtol=0.04)


def test_simple_shear_is_planar_tension(tmp_path: Path) -> None:
    """Shear of a Mooney-Rivlin law, exact, in a file of its own: its constants come out together with its pull's."""
    exact = {"c10": 10e3, "c01": 9e3}
    strain = np.linspace(0.05, 1.0, 20)
    for name, stress in (
        ("pull", engineering_stress("mooney-rivlin", exact, strain)),
        ("shear", [g * shear_secant("mooney-rivlin", exact, g) for g in strain]),
    ):
        rows = (f"{e:.12g},{s:.12g}" for e, s in zip(strain, stress, strict=True))
        (tmp_path / name).write_text("\n".join(["strain,stress (Pa)", *rows]))
    found = fit_tests(tmp_path / "pull", None, None, law="mooney-rivlin",
                      given=Sizes(also=(("shear", str(tmp_path / "shear")),)))
    assert found.fit.constants == pytest.approx(exact, rel=1e-6) and found.fit.modes == ("uniaxial", "planar")
    assert found.table["mode_spread"] == found.fit.mode_spread
