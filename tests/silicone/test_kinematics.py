"""Derivatives of s, r and J by F against differences, and the plane as a case of space."""

import numpy as np
import pytest

from sits_mech.silicone.kinematics import POINTS, in_plane, in_space


def deformations(k):
    """Random deformations with J > 0, the undeformed one and one with equal stretches, of k components."""
    n = round(np.sqrt(k))
    F = np.eye(n) + 0.25 * np.random.default_rng(3).normal(size=(30, n, n))
    return np.concatenate([F[np.linalg.det(F) > 0.2], [np.eye(n), 1.2 * np.eye(n)]]).reshape(-1, k)


def differences(function, F):
    """Central differences of a function of F, last axis the component of F."""
    h = 1e-6 * np.eye(F.shape[-1])
    return np.stack([(function(F + step) - function(F - step)) / 2e-6 for step in h], axis=-1)


def whole(add):
    """The derivative that a method adds to tangents."""
    point = add.__self__
    A = np.zeros((*point.F.shape, point.F.shape[-1]))
    add(A, np.ones_like(point.J))
    return A


@pytest.fixture(params=[(in_space, 9), (in_plane, 4)], ids=["space", "plane"])
def case(request):
    """A place, and deformations of as many components."""
    return request.param[0], deformations(request.param[1])


def test_derivatives_are_those_of_the_numbers_themselves(case):
    at, F = case
    found, k = at(F), F.shape[-1]
    n = round(np.sqrt(k))
    np.testing.assert_allclose(found.J, np.linalg.det(F.reshape(-1, n, n)), rtol=1e-13)
    second = (("H", whole(found.add_L)), ("dr", whole(found.add_d2r)))
    for value, slope in (("J", found.H), ("s", 2.0 * F), ("r", found.dr), *second):
        difference = differences(lambda G, name=value: getattr(at(G), name), F)
        np.testing.assert_allclose(np.broadcast_to(slope, difference.shape), difference, atol=2e-8)


def test_in_place_sums_are_products_with_the_whole_arrays(case):
    """Also where there are more points than are taken at a time."""
    at, F = case
    F = np.tile(F, (2, POINTS // len(F), 1))
    found, factor = at(F), np.random.default_rng(1).normal(size=F.shape[:-1])
    A = np.ones((*F.shape, F.shape[-1]))
    found.add_L(A, factor)
    found.add_d2r(A, factor)
    both = whole(found.add_L) + whole(found.add_d2r)
    np.testing.assert_allclose(A, 1.0 + factor[..., None, None] * both, atol=1e-12)


def test_plane_strain_is_space_with_no_strain_across():
    G = deformations(4)
    plane = in_plane(G)
    F = np.tile(np.eye(3).ravel(), (len(G), 1))
    F[:, [0, 2, 6, 8]] = G
    space, some = in_space(F), [0, 2, 6, 8]
    for name in ("J", "s", "r"):
        np.testing.assert_allclose(getattr(plane, name), getattr(space, name), rtol=1e-14)
    for name in ("H", "dr"):
        np.testing.assert_allclose(getattr(plane, name), getattr(space, name)[:, some], atol=1e-14)
    for name in ("add_L", "add_d2r"):
        own, within = whole(getattr(plane, name)), whole(getattr(space, name))[:, some][:, :, some]
        np.testing.assert_allclose(own, within, atol=1e-14)


def test_principal_stretches_and_turns_give_the_deformation_back(case):
    """``F = U diag(stretch) V`` with turns U and V, in the plane beside a stretch of one across."""
    at, F = case
    stretch, U, V, within = at(F).principal()
    d = len(within)
    kept = stretch[:, list(within)]
    np.testing.assert_allclose((U * kept[:, None, :] @ V).reshape(F.shape), F, atol=1e-14)
    for turn in (U, V):
        np.testing.assert_allclose(turn @ turn.swapaxes(1, 2), np.broadcast_to(np.eye(d), turn.shape), atol=1e-14)
    np.testing.assert_allclose(stretch.prod(axis=1), at(F).J, rtol=1e-13)


def test_principal_stretches_of_points_in_any_shape() -> None:
    """Gradients in the plane, four beside five, as one after the other; and by the singular values of each."""
    F = np.eye(2).ravel() + 0.2 * np.random.default_rng(3).normal(size=(4, 5, 4))
    found, flat = in_plane(F).principal(), in_plane(F.reshape(20, 4)).principal()
    np.testing.assert_array_equal(found.stretch.reshape(20, 3), flat.stretch)
    exact = np.linalg.svd(F.reshape(20, 2, 2), compute_uv=False)
    np.testing.assert_allclose(flat.stretch[:, [0, 2]], exact, rtol=1e-12)
    np.testing.assert_array_equal(flat.stretch[:, 1], 1.0)
