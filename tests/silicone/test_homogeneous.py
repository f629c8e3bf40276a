"""Uniform tests of the incompressible laws: derivatives of the energy, and a layer's stress in plane strain."""

import numpy as np
import pytest

from sits_mech.silicone.energy import isochoric_stress
from sits_mech.silicone.homogeneous import (
    MODES,
    energy_density,
    engineering_stress,
    principal_stretches,
    shear_band_stiffness,
    shear_secant,
    tangent,
)
from sits_mech.silicone.kinematics import in_plane
from sits_mech.silicone.material import Silicone

LAWS = {
    "neo-hookean": {"shear_modulus": 30e3},
    "mooney-rivlin": {"c10": 10e3, "c01": 4e3},
    "yeoh": {"c10": 12e3, "c20": -300.0, "c30": 20.0},
    "ogden": {"mu": (20e3, 3e3), "alpha": (1.7, -4.2)},
    "gent": {"shear_modulus": 30e3, "j_m": 12.0},
}


def energy(law: str, c: dict, stretches: np.ndarray) -> np.ndarray:
    """The energies as the laws' files state them, written out again."""
    first, second = (stretches**2).sum(-1) - 3.0, (stretches**-2.0).sum(-1) - 3.0
    if law == "ogden":
        pairs = zip(c["mu"], c["alpha"], strict=True)
        return sum(2 * mu / a**2 * ((stretches**a).sum(-1) - 3.0) for mu, a in pairs)
    return {
        "neo-hookean": lambda: c["shear_modulus"] / 2 * first,
        "mooney-rivlin": lambda: c["c10"] * first + c["c01"] * second,
        "yeoh": lambda: c["c10"] * first + c["c20"] * first**2 + c["c30"] * first**3,
        "gent": lambda: -c["shear_modulus"] * c["j_m"] / 2 * np.log(1 - first / c["j_m"]),
    }[law]()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("law", LAWS)
def test_stress_is_the_slope_of_the_energy(law: str, mode: str) -> None:
    """P = dW/d(lambda), half of it in the biaxial test, where two faces are pulled; by central differences."""
    stretch, step = np.linspace(0.6, 1.9, 14), 1e-5
    up, down = (energy(law, LAWS[law], principal_stretches(mode, stretch + way * step)) for way in (1, -1))
    slope = (up - down) / (2 * step) / (2 if mode == "biaxial" else 1)
    found = engineering_stress(law, LAWS[law], stretch - 1.0, mode)
    assert found == pytest.approx(slope, rel=1e-7, abs=1e-4 * 30e3 * step)


@pytest.mark.parametrize("law", LAWS)
def test_energy_density_is_the_law_s(law: str) -> None:
    """As its file states it; zero without strain."""
    stretches = principal_stretches("planar", np.linspace(0.6, 1.9, 14))
    assert energy_density(law, LAWS[law], stretches) == pytest.approx(energy(law, LAWS[law], stretches), abs=1e-10)
    assert energy_density(law, LAWS[law], np.ones((1, 3))) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_tangent_is_the_curvature_of_the_energy(law: str) -> None:
    """Second differences in logarithmic strain along increments that keep the volume; and 2 mu at rest."""
    strains, step = np.array([[0.0, 0.0, 0.0], [0.5, -0.1, -0.4], [-0.5, 0.25, 0.25]]), 1e-3
    basis = np.array([[2.0, -1.0, -1.0], [0.0, 1.0, -1.0]]) / np.sqrt([[6.0], [2.0]])
    found = tangent(law, LAWS[law], np.exp(strains))
    for turn in np.linspace(0.0, np.pi, 5):
        way = np.array([np.cos(turn), np.sin(turn)])
        three = [energy(law, LAWS[law], np.exp(strains + k * step * (way @ basis))) for k in (-1, 0, 1)]
        curvature = (three[0] - 2 * three[1] + three[2]) / step**2
        assert way @ found @ way == pytest.approx(curvature, rel=2e-4)
    modulus = Silicone("", law, LAWS[law], 1e9).shear_modulus
    assert found[0] == pytest.approx(2 * modulus * np.eye(2), rel=1e-12, abs=1e-9 * modulus)


@pytest.mark.parametrize("law", LAWS)
def test_planar_stress_is_that_of_the_layers_law(law: str) -> None:
    """The stress that the layer solves with, at F = diag(lambda, 1/lambda), with a pressure for P_zz = 0."""
    silicone, stretch = Silicone("", law, LAWS[law], 1e9), np.linspace(0.6, 1.8, 9)
    F = np.stack([stretch, 0.0 * stretch, 0.0 * stretch, 1.0 / stretch], axis=-1)
    P = silicone.shear_modulus * isochoric_stress(silicone)(in_plane(F))[1]
    found = engineering_stress(law, LAWS[law], stretch - 1.0, "planar")
    assert found == pytest.approx(P[:, 0] - P[:, 3] / stretch**2, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_shear_stress_is_the_slope_of_the_energy_by_the_strain(law: str) -> None:
    """In simple shear, over the strain; of the laws linear in both invariants the modulus at any strain."""
    modulus = {"neo-hookean": 30e3, "mooney-rivlin": 2.0 * (10e3 + 4e3)}.get(law)
    for strain in (0.05, 0.7, 1.6):
        stretch = (np.array([-1e-5, 1e-5]) + strain) / 2
        stretch = stretch + np.hypot(stretch, 1.0)
        low, high = energy(law, LAWS[law], np.stack([stretch, np.ones(2), 1.0 / stretch], axis=1))
        found = shear_secant(law, LAWS[law], strain)
        assert found == pytest.approx((high - low) / 2e-5 / strain, rel=1e-6)
        assert modulus is None or found == pytest.approx(modulus, rel=1e-12)


def test_unknown_names_are_refused() -> None:
    """A law or a test that does not exist."""
    with pytest.raises(ValueError, match='law: must be one of .*; got "hooke"'):
        engineering_stress("hooke", {}, np.ones(1))
    with pytest.raises(ValueError, match='mode: must be one of uniaxial, planar, biaxial; got "torsion"'):
        engineering_stress("yeoh", LAWS["yeoh"], np.ones(1), "torsion")


@pytest.mark.parametrize("law", LAWS)
def test_shear_bands_at_equal_stretches(law: str) -> None:
    """At rest the shear modulus; where two stretches are equal the limit of those that nearly are."""
    modulus = Silicone("", law, LAWS[law], 1e9).shear_modulus
    assert shear_band_stiffness(law, LAWS[law], np.ones((1, 3)))[0] == pytest.approx(modulus, rel=1e-12)
    stretch = np.array([0.7, 1.3])
    for apart in (0.0, 1e-8, 1e-5):
        near = np.stack([stretch, (1.0 + apart) / np.sqrt(stretch), 1.0 / np.sqrt(stretch) / (1.0 + apart)], axis=-1)
        far = np.stack([stretch, 1.001 / np.sqrt(stretch), 1.0 / np.sqrt(stretch) / 1.001], axis=-1)
        found, beside = (shear_band_stiffness(law, LAWS[law], at) for at in (near, far))
        np.testing.assert_allclose(found, beside, rtol=1e-2)
