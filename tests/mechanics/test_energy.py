"""Hyperelastic laws: derivatives against differences, objectivity, known special cases."""

import numpy as np
import pytest

from sits_mech.mechanics.energy import plane_energy
from sits_mech.silicone.material import silicone_from

K = {"bulk_modulus": 3e7}
LAWS = {
    "neo-hookean": {"law": "neo-hookean", "shear_modulus": 3e4, **K},
    "mooney-rivlin": {"law": "mooney-rivlin", "c10": 1e4, "c01": 5e3, **K},
    "yeoh": {"law": "yeoh", "c10": 1.5e4, "c20": -300.0, "c30": 40.0, **K},
    "ogden": {"law": "ogden", "mu": [2e4, 1e4], "alpha": [1.7, -2.6], **K},
    "gent": {"law": "gent", "shear_modulus": 3e4, "j_m": 20.0, **K},
}


@pytest.fixture(params=list(LAWS))
def law(request):
    return plane_energy(silicone_from(LAWS[request.param]))


def states():
    """Random plane deformations with J > 0, an undeformed one and one with equal stretches among them."""
    rng = np.random.default_rng(3)
    F = np.eye(2) + 0.35 * rng.normal(size=(40, 2, 2))
    F = np.concatenate([F[np.linalg.det(F) > 0.2], [np.eye(2), 1.2 * np.eye(2)]])
    return F, (F**2).sum(axis=(1, 2)), np.linalg.det(F)


def test_derivatives_are_exact(law):
    _, s, J = states()
    d, h = law(s, J), 1e-5
    for step_s, step_J in ((h, 0.0), (0.0, h)):
        up, down = law(s + step_s + 0.1, J + step_J), law(s - step_s + 0.1, J - step_J)
        mid = law(s + 0.1, J)
        if step_s:
            pairs = ((up.w - down.w, mid.w_s), (up.w_s - down.w_s, mid.w_ss), (up.w_J - down.w_J, mid.w_sJ))
        else:
            pairs = ((up.w - down.w, mid.w_J), (up.w_s - down.w_s, mid.w_sJ), (up.w_J - down.w_J, mid.w_JJ))
        for difference, exact in pairs:
            np.testing.assert_allclose(difference / (2 * h), exact, rtol=2e-6, atol=2e-6 * np.abs(exact).max())
    assert np.all(np.isfinite(np.array(d)))


def test_energy_is_zero_stress_free_and_of_unit_shear_modulus_at_rest(law):
    rest = law(np.array([2.0]), np.array([1.0]))
    assert rest.w[0] == pytest.approx(0.0, abs=1e-12)
    assert 2 * rest.w_s[0] + rest.w_J[0] == pytest.approx(0.0, abs=1e-12)
    gamma = 1e-3  # simple shear: s = 2 + gamma^2, J = 1, w = gamma^2 / 2
    assert law(np.array([2.0 + gamma**2]), np.array([1.0])).w[0] == pytest.approx(gamma**2 / 2, rel=1e-4)


def test_turning_the_body_costs_nothing(law):
    F, s, J = states()
    c, q = np.cos(1.1), np.sin(1.1)
    turned = np.array([[c, -q], [q, c]]) @ F
    w = law((turned**2).sum(axis=(1, 2)), np.linalg.det(turned)).w
    np.testing.assert_allclose(w, law(s, J).w, rtol=1e-9, atol=1e-12)


def test_ogden_with_one_term_of_power_two_is_neo_hookean():
    ogden = plane_energy(silicone_from({"law": "ogden", "mu": [3e4], "alpha": [2.0], **K}))
    _, s, J = states()
    for one, other in zip(ogden(s, J), plane_energy(silicone_from(LAWS["neo-hookean"]))(s, J), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


def test_gent_is_infinite_from_its_locking_stretch_on():
    gent = plane_energy(silicone_from(LAWS["gent"]))
    assert np.isinf(gent(np.array([30.0]), np.array([1.0])).w[0])
