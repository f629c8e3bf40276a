"""Grids of loads in any components: the walk, mirror images, kept loads; by a layer whose answers are known by hand."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from sits_mech.mechanics.loads import kept_rest, outward, settle, without_images
from sits_mech.quantities import POSE, Equilibrium, Pose, SolveFailed, SolveReport, Wrench

GRID = {"F_x": [-0.2, 0.0, 0.2], "F_z": [0.0, 1.0], "F_y": [-0.1, 0.0, 0.1], "M_z": [-1e-3, 0.0, 1e-3]}
REPORT = SolveReport("spring", 1, 1, 0.0, 1e-3, 0.0, min_J=0.9)


@dataclass
class Spring:
    """Components that mix as the mirrors allow, with as much again that they forbid (`skew`), and scatter at rest."""

    skew: float = 0.0
    solved: list[Wrench] = field(default_factory=list)
    starts: list[Wrench | None] = field(default_factory=list)

    def pose(self, wrench: Wrench) -> Pose:
        """Each product of loads in the component whose signs it has."""
        x, z, m, y, mx, mz = wrench.components
        d_h, d_y = 1e-3 * x + 1e-4 * y * mz, 1e-3 * y + 1e-4 * x * mz + 1e-5 * self.skew * z
        return Pose(d_h, 2e-3 - 1e-4 * z, 0.1 * m + x * z, d_y, mx - y * z, mz + 0.1 * x * y)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the formula's pose; too much where all act together."""
        self.solved.append(wrench)
        self.starts.append(None if start is None else start.wrench)
        if np.all(wrench.components[[0, 1, 3]]) and wrench.M_z == 0.0:
            raise SolveFailed("too much", SolveReport("spring", 1, 9, 1.0, 1.0, 0.0, "stalled"))
        state = np.zeros(0 if wrench.beside else 3)
        return Equilibrium(wrench, self.pose(wrench), Pose(*[1e-6] * 6), state, REPORT)


def test_a_quarter_of_the_loads_is_solved() -> None:
    """Mirrored in x and in y: each load's row is what solving it gives, failures too; 54 loads, 18 solves."""
    layer = Spring()
    rows, whole = settle(layer, GRID, symmetric=True), settle(Spring(), GRID, symmetric=False)
    assert len(rows) == len(whole) == 54 and len(layer.solved) == len(without_images(outward(GRID))) == 18
    for load, row in whole.items():
        assert rows[load]["status"] == row["status"]
        for name in POSE if row["status"] == "converged" else ():
            assert rows[load][name] == pytest.approx(row[name], abs=1e-18)


def test_of_a_load_that_is_its_own_image_what_would_turn_is_zero() -> None:
    """A solver's scatter in what symmetry forbids is taken out, with its error, and only there."""
    rows = settle(Spring(skew=1.0), GRID, symmetric=True)
    row = rows[Wrench(0.2, 1.0)]
    assert row["d_y"] == row["error_d_y"] == row["alpha_x"] == row["alpha_z"] == 0.0 and row["error_d_h"] == 1e-6
    row = rows[Wrench(0.0, 1.0, F_y=0.1)]
    assert row["d_h"] == row["alpha"] == row["error_alpha_z"] == 0.0 and row["d_y"] == pytest.approx(1.1e-4)
    assert settle(Spring(skew=1.0), GRID, symmetric=False)[Wrench(0.2, 1.0)]["d_y"] == pytest.approx(1e-5)


def test_the_walk_begins_in_the_plane_and_each_load_at_a_neighbour() -> None:
    """From the smallest outwards; of loads beside the plane, which have no state here, none is a start."""
    layer = Spring()
    settle(layer, GRID, symmetric=True)
    assert layer.solved[:4] == [Wrench(), Wrench(0.0, 1.0), Wrench(0.2, 0.0), Wrench(0.2, 1.0)]
    assert layer.starts[0] is None and all(start is not None and not start.beside for start in layer.starts[1:])
    plane = outward({"F_x": [-1.0, 0.0, 1.0], "F_z": [2.0, 0.0]})
    assert plane == [Wrench(x, z) for x in (0.0, 1.0, -1.0) for z in (0.0, 2.0)]


def test_finished_loads_are_found_again(tmp_path: Path) -> None:
    """By all six components: a load beside the plane is another than that in it."""
    keep, grid = (tmp_path, "layer"), GRID | {"M_z": [0.0]}
    first = settle(Spring(), grid, symmetric=True, keep=keep)
    again = Spring()
    assert settle(again, grid, symmetric=True, keep=keep).keys() == first.keys() and again.solved == []
    kept = kept_rest(keep, Wrench(0.0, 1.0, F_y=0.1))
    assert kept is not None and kept.pose == Spring().pose(Wrench(0.0, 1.0, F_y=0.1))
    assert kept_rest(keep, Wrench(0.0, 1.0, F_y=0.05)) is None
