"""Grids: solved at every second value where a smooth map predicts the rest, whole where it does not."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from sits_mech.chain.interpolate import INTERPOLATED, poses_on_grid
from sits_mech.mechanics.layer import linear_layer
from sits_mech.quantities import Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import load_sensor

GRID = {"F_x": np.linspace(-1.0, 1.0, 9).tolist(), "F_z": np.linspace(0.0, 4.0, 9).tolist()}


@dataclass
class Spring:
    """A layer by formula that counts its solves; past `limit` it fails, and `wave` [m] scatters."""

    kink: float = 0.0
    wave: float = 0.0
    limit: float = np.inf
    solved: list[Wrench] = field(default_factory=list)

    def pose(self, wrench: Wrench) -> Pose:
        """Smooth in both forces, but for a kink at 0.3 of the shear."""
        x, z = wrench.F_x, wrench.F_z
        bend = self.kink * np.sign(x) * max(abs(x) - 0.3, 0.0)
        scatter = self.wave * np.sign(x) * np.cos(2.0 * np.pi * x)
        return Pose(1e-3 * (x * (1 + 0.1 * z) + bend) + scatter, 2e-3 - 5e-5 * z / (1 + 0.1 * z), 1e-2 * x * z)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the formula's pose."""
        self.solved.append(wrench)
        report = SolveReport("spring", 1, 1, 0.0, 1e-3, 0.0, min_J=0.9)
        if wrench.F_z > self.limit:
            raise SolveFailed("too much", replace(report, status="stalled"))
        return Equilibrium(wrench, self.pose(wrench), Pose(1e-7, 1e-7, 1e-6), np.zeros(1), report)


@pytest.mark.parametrize(("symmetric", "solves"), [(True, 15), (False, 25)])
def test_a_smooth_layer_is_solved_at_every_second_load(symmetric: bool, solves: int) -> None:
    """All poses stand within their stated errors; those between say that they are, with the map's error added."""
    layer, sensor = Spring(), load_sensor("biorob2018")
    rows = poses_on_grid(sensor, layer, GRID, symmetric=symmetric, tolerance=1e-2)
    assert len(rows) == 81 and len(layer.solved) == solves
    for load, row in rows.items():
        true = layer.pose(load)
        for name in ("d_h", "d_v", "alpha"):
            assert abs(row[name] - getattr(true, name)) <= row[f"error_{name}"] + 1e-15
        assert row["status"] == "converged" and row["min_J"] == pytest.approx(0.9)
    assert sum(row["notes"] == INTERPOLATED for row in rows.values()) == 56


def test_scatter_of_the_errors_plays_no_part_in_the_map() -> None:
    """Errors go up and down from load to load: those between have the mean of theirs and what the poses' map adds."""

    class Scattered(Spring):
        def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
            found = super().equilibrium(wrench, start=start)
            own = 1e-7 * (2.0 + np.sin(1e3 * wrench.F_x * (1.0 + wrench.F_z)))
            return replace(found, error=Pose(own, own, own))

    rows, plain = (
        poses_on_grid(load_sensor("biorob2018"), layer, GRID, symmetric=False, tolerance=1e-2)
        for layer in (Scattered(), Spring())
    )
    between = [load for load, row in plain.items() if row["notes"] == INTERPOLATED]
    assert len(between) == 56
    for load in between:
        assert rows[load]["d_h"] == plain[load]["d_h"]
        assert rows[load]["error_d_h"] - plain[load]["error_d_h"] <= 2e-7 + 1e-18
    mean = 0.5 * (rows[Wrench(0.5, 0.0)]["error_d_v"] + rows[Wrench(0.5, 1.0)]["error_d_v"])
    map_error = plain[Wrench(0.5, 0.5)]["error_d_v"] - 1e-7
    assert map_error > 1e-8
    assert rows[Wrench(0.5, 0.5)]["error_d_v"] == pytest.approx(mean + map_error, rel=1e-9)


def test_a_kink_is_solved_through() -> None:
    """Where the map does not predict its own loads, every load is solved."""
    layer = Spring(kink=2.0)
    rows = poses_on_grid(load_sensor("biorob2018"), layer, GRID, symmetric=True, tolerance=1e-2)
    assert len(rows) == 81 and len(layer.solved) == 45 and not any(row["notes"] for row in rows.values())


def test_nothing_is_put_beside_a_failed_load() -> None:
    """The grid is solved whole, and every load beyond the limit says so itself."""
    layer = Spring(limit=3.2)
    rows = poses_on_grid(load_sensor("biorob2018"), layer, GRID, symmetric=True, tolerance=1e-2)
    assert sum(row["status"] != "converged" for row in rows.values()) == 9 * 2
    assert not any(row.get("notes") for row in rows.values())


def test_small_grids_are_solved_whole() -> None:
    """Six values are too few to leave any out."""
    layer, grid = Spring(), {"F_x": GRID["F_x"][:6], "F_z": GRID["F_z"]}
    assert len(poses_on_grid(load_sensor("biorob2018"), layer, grid, symmetric=False, tolerance=1e-2)) == 54
    assert len(layer.solved) == 54


def test_the_linear_layer_needs_the_fewest() -> None:
    """A real layer whose answer the map holds to rounding."""
    sensor = load_sensor("biorob2018", ['elastomer.length="200 mm"'])
    rows = poses_on_grid(sensor, linear_layer(sensor, 3e-2), GRID, symmetric=True, tolerance=1e-2)
    assert sum(row["notes"].endswith(INTERPOLATED) for row in rows.values()) == 56


def test_the_table_has_no_steps_between_solved_loads_and_others() -> None:
    """Solved loads with scatter: those between follow them, not a map that passes by; without shear all is straight."""
    layer, sensor = Spring(wave=2e-6), load_sensor("biorob2018")
    rows = poses_on_grid(sensor, layer, GRID, symmetric=True, tolerance=1e-2)
    assert sum(row["notes"] == INTERPOLATED for row in rows.values()) == 56
    for x, z, before, after in ((0.5, 0.5, 0.0, 1.0), (-1.0, 2.5, 2.0, 3.0)):
        mean = 0.5 * (rows[Wrench(x, before)]["d_h"] + rows[Wrench(x, after)]["d_h"])
        assert abs(rows[Wrench(x, z)]["d_h"] - mean) < 4e-7  # a map that misses the scatter is off by its 2 um
    assert all(rows[Wrench(0.0, z)]["d_h"] == rows[Wrench(0.0, z)]["error_alpha"] == 0.0 for z in GRID["F_z"])
