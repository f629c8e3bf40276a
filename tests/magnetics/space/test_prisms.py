"""The mean of 1/r between the cells of a disc against many more points, and against itself turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.geometry.sheet_plan import CellPlan, Grading, disc_plan
from sits_mech.magnetics.space.classes import kernel, stacked
from sits_mech.magnetics.space.fields import Prisms
from sits_mech.magnetics.space.prisms import FEW, MANY, prism_means
from sits_mech.quantities import Array

LEVELS = np.array([0.0, 5e-5, 9e-5, 1e-4])


@pytest.fixture(scope="module")
def plan() -> CellPlan:
    return disc_plan(6e-3, Grading(2e-5, 3.0, 1.5e-3), orders=2)


def turned(plan: CellPlan, prisms: Prisms, k: int) -> Prisms:
    return replace(prisms, corners=prisms.corners @ plan.group[k].T)


@pytest.mark.parametrize("k", [0, 1, 3, 9, 11])
def test_a_disc_is_the_same_turned_either_way(plan: CellPlan, k: int) -> None:
    """But for what Gauss points of one cell of two are off, which is not the same in both ways."""
    prisms = stacked(plan, LEVELS)
    assert len(plan.group) == 12
    direct = prism_means(prisms, turned(plan, prisms, k), points=MANY)
    np.testing.assert_allclose(kernel(plan, LEVELS, prisms)[k, 0], direct, rtol=3e-3)


def test_a_sector_whose_cells_are_no_mirror_images_of_themselves_is_taken_as_it_is(plan: CellPlan) -> None:
    """A sector turned by itself."""
    c, s = np.cos(0.1), np.sin(0.1)
    other = replace(plan, nodes=plan.nodes @ np.array([[c, s], [-s, c]]))
    np.testing.assert_allclose(
        kernel(other, LEVELS, stacked(other, LEVELS)), kernel(plan, LEVELS, stacked(plan, LEVELS)), rtol=3e-3
    )


def errors(plan: CellPlan, points: int) -> Array:
    prisms = stacked(plan, LEVELS)
    exact = prism_means(prisms, prisms, points=13)
    return np.asarray(np.abs(prism_means(prisms, prisms, points=points) / exact - 1.0))


@pytest.mark.slow
def test_many_points_take_touching_cells_ten_times_closer_than_few(plan: CellPlan) -> None:
    few, many = errors(plan, FEW), errors(plan, MANY)
    assert many.max() < 4e-3 < few.max() / 2.0
    assert many.mean() < few.mean() / 8.0


def test_tall_prisms_some_way_apart_are_not_taken_in_their_middles() -> None:
    """Two needles 1.3 lengths apart in a row and side by side, against lines: in their middles 12 and 4 % off."""
    square = 1e-4 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    h, d = 1.0, 1.3

    def needle(x: float, low: float) -> Prisms:
        return Prisms((square + (x, 0.0))[None], np.array([low]), np.array([low + h]))

    def lines(x: float, z: float) -> float:
        def F(u: float) -> float:
            return u * np.arcsinh(u / x) - np.hypot(u, x) if x else u * np.log(u) - u

        return float(F(z + h) - 2.0 * F(z) + F(z - h)) if x else float(F(d + h) - 2.0 * F(d) + F(d - h))

    row = prism_means(needle(0.0, 0.0), needle(0.0, d)).item()
    beside = prism_means(needle(0.0, 0.0), needle(d, 0.0)).item()
    assert row == pytest.approx(lines(0.0, d), rel=4e-2)
    assert beside == pytest.approx(lines(d, 0.0), rel=1.5e-2)
