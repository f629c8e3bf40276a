"""Every law in space and in plane strain: derivatives against differences, plane against space, rest, objectivity."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.silicone.energy import isochoric_energy, isochoric_stress
from sits_mech.silicone.kinematics import POINTS, in_plane, in_space
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.material import Silicone

GUARD = 2.0


def deformations(k):
    """Random deformations with J > 0; the undeformed one, and some with two equal or nearly equal stretches."""
    n = round(np.sqrt(k))
    F = np.eye(n) + 0.25 * np.random.default_rng(3).normal(size=(30, n, n))
    like = [np.diag([0.8, 1.3, 0.8 + gap][-n:]) for gap in (0.0, 1e-9, 1e-5)]
    return np.concatenate([F[np.linalg.det(F) > 0.2], [np.eye(n), 1.2 * np.eye(n)], like]).reshape(-1, k)


def in_nine(G):
    """The components in space of a deformation in plane strain."""
    F = np.tile(np.eye(3).ravel(), (len(G), 1))
    F[:, [0, 2, 6, 8]] = G
    return F


def differences(function, F):
    """Central differences of a function of F, last axis the component of F."""
    h = 1e-6 * np.eye(F.shape[-1])
    return np.stack([(function(F + step) - function(F - step)) / 2e-6 for step in h], axis=-1)


@pytest.fixture(params=[(in_space, 9), (in_plane, 4)], ids=["space", "plane"])
def case(request):
    """A place, and deformations of as many components."""
    return request.param[0], deformations(request.param[1])


@pytest.mark.parametrize("guard", [0.0, GUARD])
def test_stress_and_tangent_are_derivatives_of_the_energy(case, silicone, guard):
    at, F = case
    law, stress = isochoric_energy(silicone, guard), isochoric_stress(silicone, guard)
    w, P, A = law(at(F))
    np.testing.assert_allclose(P, differences(lambda G: law(at(G))[0], F), rtol=1e-6, atol=1e-7 * np.abs(P).max())
    np.testing.assert_allclose(A, differences(lambda G: law(at(G))[1], F), atol=1e-6 * np.abs(A).max())
    np.testing.assert_allclose(A, np.swapaxes(A, 1, 2), atol=1e-12 * np.abs(A).max())
    for one, other in zip(stress(at(F)), (w, P), strict=True):
        np.testing.assert_array_equal(one, other)


def test_plane_strain_is_space_with_no_strain_across(silicone):
    """Energy, stress and tangent by the four components of the plane, to rounding."""
    G, some = deformations(4), [0, 2, 6, 8]
    law = isochoric_energy(silicone, GUARD)
    w, P, A = law(in_plane(G))
    space = law(in_space(in_nine(G)))
    np.testing.assert_allclose(w, space[0], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(P, space[1][:, some], atol=1e-12 * np.abs(P).max())
    np.testing.assert_allclose(A, space[2][:, some][:, :, some], atol=1e-12 * np.abs(A).max())


def test_rest_is_free_of_stress_with_unit_shear_modulus(silicone):
    w, P, A = isochoric_energy(silicone, GUARD)(in_space(np.eye(3).reshape(1, 9)))
    assert w[0] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(P, 0.0, atol=1e-12)
    shear = np.array([0, 1.0, 0, 1.0, 0, 0, 0, 0, 0])
    assert shear @ A[0] @ shear == pytest.approx(4.0, rel=1e-12)  # 2 mu e:e with e_12 = 1


def test_turning_the_body_turns_the_stress(silicone):
    """Objectivity and isotropy: ``P(Q F R) = Q P(F) R``, at the same energy."""
    law, F = isochoric_energy(silicone, GUARD), deformations(9).reshape(-1, 3, 3)
    turns = [np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0] for seed in (1, 2)]
    Q, R = (turn * np.linalg.det(turn) for turn in turns)
    w, P, _ = law(in_space(F.reshape(-1, 9)))
    turned = law(in_space((Q @ F @ R).reshape(-1, 9)))
    np.testing.assert_allclose(turned[0], w, atol=1e-12)
    np.testing.assert_allclose(turned[1], (Q @ P.reshape(-1, 3, 3) @ R).reshape(-1, 9), atol=1e-11)


def test_change_of_volume_alone_stores_nothing_but_the_guard(silicone):
    """The isochoric part knows no volume; the guard is ``GUARD (J - 1 - ln J)``."""
    size = np.array([0.7, 0.9, 1.3])
    F = size[:, None] * np.eye(3).ravel()
    w, P, _ = isochoric_energy(silicone, GUARD)(in_space(F))
    np.testing.assert_allclose(w, GUARD * (size**3 - 1.0 - 3.0 * np.log(size)), rtol=1e-12)
    np.testing.assert_allclose(P[:, 0], GUARD * (1.0 - size**-3.0) * size**2, rtol=1e-12)


def test_constants_in_other_units_give_the_same_energy(silicone):
    """Energies come in shear moduli."""
    scaled = {
        name: np.multiply(value, 7.0).tolist() if LAWS[silicone.law].units[name] == "Pa" else value
        for name, value in silicone.constants.items()
    }
    scaled = {name: tuple(value) if isinstance(value, list) else value for name, value in scaled.items()}
    F = in_space(deformations(9))
    for one, other in zip(
        isochoric_energy(silicone)(F), isochoric_energy(replace(silicone, constants=scaled))(F), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-12 * np.abs(other).max())


def test_points_stand_in_any_shape_and_number(case, silicone):
    """More points than are taken at a time, in two axes: as one by one."""
    at, F = case
    law = isochoric_energy(silicone)
    found = law(at(np.tile(F, (2, 6 * POINTS // len(F), 1))))
    for one, other in zip(found, law(at(F)), strict=True):
        np.testing.assert_allclose(one.reshape(-1, *other.shape)[-1], other, rtol=1e-12, atol=1e-13)


def test_ogden_with_one_term_of_power_two_is_neo_hookean(case):
    at, F = case
    ogden = Silicone("", "ogden", {"mu": (3e4,), "alpha": (2.0,)}, 3e7)
    plain = Silicone("", "neo-hookean", {"shear_modulus": 3e4}, 3e7)
    for one, other in zip(isochoric_energy(ogden)(at(F)), isochoric_energy(plain)(at(F)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_ogden_with_powers_of_either_sign_is_mooney_rivlin(case):
    """Powers 2 and -2: ``c10 = mu_1/2``, ``c01 = mu_2/2``; two ways to the same tangent."""
    at, F = case
    ogden = Silicone("", "ogden", {"mu": (2e4, 1e4), "alpha": (2.0, -2.0)}, 3e7)
    plain = Silicone("", "mooney-rivlin", {"c10": 1e4, "c01": 5e3}, 3e7)
    for one, other in zip(isochoric_energy(ogden)(at(F)), isochoric_energy(plain)(at(F)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12 * np.abs(other).max())


def test_gent_is_infinite_from_its_locking_stretch_on():
    gent = isochoric_stress(Silicone("", "gent", {"shear_modulus": 3e4, "j_m": 20.0}, 3e7))
    shear = np.array([[1.0, gamma, 0.0, 1.0] for gamma in (np.sqrt(20.0) * (1 - 1e-9), np.sqrt(20.0), 6.0)])
    w = gent(in_plane(shear))[0]
    assert np.isfinite(w[0]) and w[0] > 100.0 and np.isinf(w[2])


def test_unknown_law_is_refused():
    with pytest.raises(ValueError, match='law: must be one of .*; got "hooke"'):
        isochoric_energy(Silicone("", "hooke", {}, 1e9))
