"""Coils' fields over a plate: polynomials against the field, arrays against their symmetries."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from sits_mech.geometry.sheet_plan import CellPlan, Grading, disc_plan, rectangle_plan
from sits_mech.magnetics.coils.ring_field import coil_potential, winding_potential
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.magnetics.space.classes import stacked
from sits_mech.magnetics.space.fields import Box, chebyshev_values, field_means, gauss_points
from sits_mech.quantities import Impedance, Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
BOX = Box(np.array([4.0, 3.0, 0.1]) * MM, (24, 20, 3), (1.0, 1.0, 1.0))
SEVERAL = Pose(
    np.array([0.0, 0.3, -0.7]) * MM, np.array([2.05, 2.2, 2.4]) * MM, np.array([0.0, 0.02, -0.01]),
    np.array([0.0, -0.4, 0.2]) * MM, np.array([0.0, -0.02, 0.01]), np.array([0.0, 0.1, 0.5]),
)


def array(count: int, target: str = 'shape="rectangle", width="6 mm", length="6 mm"') -> Sensor:
    """Coils of the published winding on a square grid, 8 mm apart, row by row."""
    sensor = load_sensor("biorob2018", [f'target={{material="copper", thickness="0.2 mm", {target}}}'])
    places = 8 * MM * (np.arange(count) - (count - 1) / 2)
    grid = [(f"C{i}{j}", (float(x), float(y))) for i, x in enumerate(places) for j, y in enumerate(places)]
    coils = tuple(sensor.coils[0].model_copy(update={"name": name, "centre": centre}) for name, centre in grid)
    return sensor.model_copy(update={"coils": coils})


@pytest.fixture(scope="module")
def nine() -> Sensor:
    return array(3)


def solved(sensor: Sensor, pose: Pose = SEVERAL) -> Impedance:
    return Sheets(sensor, 1e-2).impedance(pose, 5e6)


def test_tabulated_potential_is_that_of_the_rings() -> None:
    """Anywhere in the region, on the axis and at its ends; at a place the same wherever else it is asked."""
    coil = load_sensor("biorob2018").coils[0].model_copy(update={"centre": (0.0, 0.0)})
    rng = np.random.default_rng(0)
    points = rng.uniform([-20 * MM, -20 * MM, 1.1 * MM], [20 * MM, 20 * MM, 3.9 * MM], (400, 3))
    points[:3] = [0.0, 0.0, 1.1 * MM], [28 * MM, 0.0, 1.1 * MM], [1e-9, 0.0, 3.9 * MM]
    exact = coil_potential(coil, points, 1.1 * MM)
    found = winding_potential(coil, "rings", (1.1 * MM, 3.9 * MM, 29 * MM), 999)(points.T[None])[0]
    np.testing.assert_allclose(found, exact[:, :2].T, rtol=0, atol=1e-6 * np.abs(exact).max())
    narrower = winding_potential(coil, "rings", (1.1 * MM, 2.5 * MM, 29 * MM), 999)(points.T[None])[0]
    some = points[:, 2] < 2.5 * MM
    np.testing.assert_allclose(narrower[:, some], found[:, some], rtol=0, atol=1e-13 * np.abs(exact).max())


@pytest.mark.parametrize("x, y", [(0.0, 0.0), (9.0, 0.0), (30.0, 5.0)])
def test_polynomials_carry_the_field(x: float, y: float) -> None:
    """Wherever the coil is, to 1e-4 of the field's largest value: 24 along 8 mm, 2 mm off."""
    coil = load_sensor("biorob2018").coils[0].model_copy(update={"centre": (x * MM, y * MM)})
    turn, place = rotation_matrix(np.array([0.03, -0.02, 0.2])), np.array([0.2, 0.1, 2.0]) * MM
    field = partial(coil_potential, coil, clearance=1.5 * MM)
    c = BOX.coefficients(np.swapaxes(field(BOX.points() @ turn.T + place) @ turn, 0, 1)).reshape(3, *BOX.order)
    inside = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3))
    T = [np.cos(np.arccos(inside[:, k, None]) * np.arange(n)) for k, n in enumerate(BOX.order)]
    exact = field((inside * BOX.half + (0.0, 0.0, BOX.half[2])) @ turn.T + place) @ turn
    assert np.abs(np.einsum("aijk,pi,pj,pk->pa", c, *T) - exact).max() < 1e-4 * np.abs(exact).max()


@pytest.mark.slow
def test_order_of_coils_and_the_batch_play_no_part(nine: Sensor) -> None:
    """Permuted coils have permuted matrices; a pose alone, and coils alone, those of the batch; to rounding."""
    whole, order = solved(nine), np.random.default_rng(2).permutation(9)
    permuted = solved(nine.model_copy(update={"coils": tuple(nine.coils[k] for k in order)}))
    size = np.abs(whole.L - whole.L0).max()
    for name, scale in (("L", size), ("R", whole.R.max()), ("error_L", size)):
        expected = getattr(whole, name)[:, order[:, None], order]
        np.testing.assert_allclose(getattr(permuted, name), expected, rtol=0, atol=1e-11 * scale)
    one = solved(nine, Pose.of(SEVERAL.components[1:2]))
    np.testing.assert_allclose(one.L[0], whole.L[1], rtol=0, atol=1e-11 * size)
    two = solved(nine.model_copy(update={"coils": nine.coils[3:5]}))
    np.testing.assert_allclose(two.L, whole.L[:, 3:5, 3:5], rtol=0, atol=1e-11 * size)


@pytest.mark.slow
def test_array_under_a_square_plate_has_the_symmetry_of_the_square(nine: Sensor) -> None:
    """Quarter turn and mirror permute the coils; beside the plate's middle the change falls off."""
    found, index = solved(nine, Pose(0.0, 2.05 * MM)), np.arange(9).reshape(3, 3)
    change = found.L - found.L0
    for image in (np.rot90(index), index.T, index[::-1]):
        turned = change[np.ix_(image.ravel(), image.ravel())]
        np.testing.assert_allclose(turned, change, rtol=0, atol=1e-9 * np.abs(change).max())
    assert np.abs(change[0, 0]) < np.abs(change[1, 1]) / 5 < np.abs(change[4, 4]) / 5


@pytest.mark.slow
def test_sixteen_coils_under_a_wide_plate_close_to_them() -> None:
    """Seen cell by cell: the square's symmetry, and four of its coils alone."""
    sensor = array(4, 'shape="rectangle", width="20 mm", length="20 mm"')
    found, index = sheets(sensor, 1e-2).impedance(Pose(0.0, 1.5 * MM), 5e6), np.arange(16).reshape(4, 4)
    change = found.L - found.L0
    turned = change[np.ix_(np.rot90(index).ravel(), np.rot90(index).ravel())]
    np.testing.assert_allclose(turned, change, rtol=0, atol=1e-6 * np.abs(change).max())


@pytest.mark.parametrize("plan", [
    disc_plan(8e-3, Grading(2e-3, 1.5, 2e-3), orders=6), rectangle_plan(8e-3, 8e-3, Grading(1e-3, 1.5, 1e-3)),
])
def test_means_over_images_are_those_of_few_but_for_signs(plan: CellPlan) -> None:
    """Against Gauss points in each image itself; a half turn changes x and y, the mirror image z."""
    box, prisms = Box(np.array([4.1e-3, 4.1e-3, 1e-4]), (5, 4, 3), (1.4, 1.4, 40.0)), stacked(plan, np.array([0, 1e-4]))
    points, weights = gauss_points(prisms, 2)
    for parity in field_means(plan, prisms, box):
        assert len(parity.means) <= len(plan.group) // 2
        i, j, k = np.unravel_index(parity.columns, box.order)
        for image, signs in zip(np.ndindex(len(plan.group), 2), parity.signs, strict=True):
            moved = np.concatenate([points[..., :2] @ plan.group[image[0]].T, points[..., 2:] * (1 - 2 * image[1])], -1)
            x, y, z = (chebyshev_values(moved[..., a] / box.half[a], box.order[a]) for a in range(3))
            own = (weights[..., None] * x[..., i] * y[..., j] * z[..., k]).sum(axis=1)
            np.testing.assert_allclose(np.tensordot(signs, parity.means[:, 0], axes=1), own, rtol=0.0, atol=1e-13)
