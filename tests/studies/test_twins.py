"""Twins: two layers of a linear pad are as soft as the whole one; yields and errors of units that are told of."""

from typing import Any

import numpy as np
import pytest
from benchmarks.adapted_twins import LAYERS, layered
from benchmarks.produced_lots import Read, averaged, summary
from common.twins import Truth, loads

from sits_mech.quantities import Array


class Straight:
    """A map of poses, by a power of the forces, and readings that are the poses."""

    names = ("gap",)

    def __init__(self, power: float) -> None:
        self.power = power

    def at(self, forces: Array) -> tuple[Array, Array]:
        """Return nothing shown, and poses."""
        return forces, forces**self.power

    def readings(self, poses: Array, P: Array) -> Array:
        """Return poses, moved by the gap."""
        return poses + P[:, None]


def pad(power: float) -> Truth:
    """Return a twin of which nothing is solved."""
    stand_in: Any = Straight(power)
    return Truth(stand_in, stand_in)


def test_two_layers_of_a_linear_pad_are_as_soft_as_one() -> None:
    """A stiffening one is not: the soft layer takes more of the way."""
    forces = np.array([[0.3, 0.5], [0.1, 2.0]])
    assert 1.0 / np.array(LAYERS) == pytest.approx([1.6, 0.4])
    for power, less in ((1.0, 1.0), (0.5, 0.5 * (1.6**0.5 + 0.4**0.5))):
        found = layered(pad(power), 0.8, {"gap": 0.01}, forces)
        assert found == pytest.approx(less * (forces / 0.8) ** power + 0.01)
    assert pad(1.0).readings(0.8, {"gap": 0.01}, forces) == pytest.approx(forces / 0.8 + 0.01)


def test_loads_shear_to_both_sides() -> None:
    """And press to one."""
    assert loads({"F_x": 1.0, "F_z": 2.0}, 3) == {"F_x": [-1.0, 0.0, 1.0], "F_z": [0.0, 1.0, 2.0]}


def test_a_row_of_a_lot() -> None:
    """Errors of 90 % of loads on 90 % of units that were read; a refused one is not within the limit, and doubted."""
    sizes = np.array([0.01, 0.01, 0.03])
    units = [Read(size * np.array([[1.0, -0.5]] * 5), 0.9, np.zeros((5, 2)), size > 0.02) for size in sizes]
    row = summary([*units, None], ("F_x", "F_z"))
    assert row["yield [%]"] == 50.0 and row["yield by constants [%]"] == 75.0
    assert row["F_x [%]"] == pytest.approx(100.0 * np.quantile(sizes, 0.9)) and row["F_z by constants [%]"] == 0.0
    assert row["F_z [%]"] == pytest.approx(0.5 * row["F_x [%]"])
    assert row["held [%]"] == pytest.approx(90.0) and row["doubted [%]"] == 50.0
    step: dict[str, Any] = {"lot": 1, "law": "", "known": "lot", "read": "tared"}
    some = [{**step, "yield [%]": share} for share in (20.0, 80.0)]
    assert averaged(some) == [{**step, "lot": "mean", "yield [%]": 50.0}]
