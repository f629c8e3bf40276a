"""Grids: solved at the loads that a smooth map and the symmetry of the pad need, whole where that does not do."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from sits_mech.cases import no_progress
from sits_mech.chain.interpolate import LayerGrid, checked_values, loads_of, poses_on_grid, solved_likely, worst
from sits_mech.chain.plans.goal import Goal
from sits_mech.chain.propagation import levers
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.loads import Settled, settle
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor

GRID = {"F_x": np.linspace(-1.0, 1.0, 9).tolist(), "F_z": np.linspace(0.0, 4.0, 9).tolist()}
SHEAR = np.linspace(-0.5, 0.5, 5).tolist()
SPACE = {"F_x": SHEAR, "F_z": np.linspace(0.0, 2.0, 5).tolist(), "F_y": SHEAR}
TWIST = SPACE | {"M_z": np.linspace(-1e-3, 1e-3, 5).tolist()}
NONE, MIRRORS, SQUARE, DISC = (Symmetry(kind) for kind in ("none", "rectangle", "square", "disc"))


@dataclass
class Spring:
    """A round pad by formula that counts its solves; past `limit` it fails, and `wave` [m] scatters."""

    kink: float = 0.0
    wave: float = 0.0
    limit: float = np.inf
    solved: list[Wrench] = field(default_factory=list)

    def pose(self, wrench: Wrench) -> Pose:
        """Smooth in every component, but for a kink at 0.3 of the shear; the same for all directions of the shear."""
        x, y, z, turn = wrench.F_x, wrench.F_y, wrench.F_z, 20.0 * wrench.M_z
        size = float(np.hypot(x, y))
        bend = self.kink * max(size - 0.3, 0.0) / max(size, 1e-9)
        soft = 1e-3 * (1.0 + 0.1 * z + 0.2 * size**2 + bend) + self.wave * np.cos(2.0 * np.pi * size) / max(size, 1e-9)
        d_v = 2e-3 - 5e-5 * z / (1.0 + 0.1 * z) - 2e-5 * size**2
        return Pose(soft * x - 2e-4 * turn * y, d_v, 1e-2 * x * z, soft * y + 2e-4 * turn * x, -1e-2 * y * z, turn)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the formula's pose."""
        self.solved.append(wrench)
        report = SolveReport("spring", 1, 1, 0.0, 1e-3, 0.0, min_J=0.9, stretch=1.1)
        if wrench.F_z > self.limit:
            raise SolveFailed("too much", replace(report, status="stalled"))
        return Equilibrium(wrench, self.pose(wrench), Pose(1e-7, 1e-7, 1e-6, 1e-7, 1e-6, 1e-6), np.zeros(1), report)


def between(found: dict[Wrench, Equilibrium]) -> list[Wrench]:
    """The loads that were not solved."""
    return [load for load, one in found.items() if Note(NoteKind.INTERPOLATED) in one.report.notes]


def rests(found: dict[Wrench, Settled]) -> dict[Wrench, Equilibrium]:
    """Where the target rests under each load that is carried."""
    return {load: one.rest for load, one in found.items() if one.rest}


@pytest.mark.parametrize(
    ("grid", "symmetry", "most"),
    [
        (GRID, NONE, 21), (GRID, MIRRORS, 14), (SPACE, NONE, 60), (SPACE, MIRRORS, 22), (SPACE, SQUARE, 14),
        (SPACE, DISC, 13), (TWIST, MIRRORS, 60), (TWIST, DISC, 30),
    ],
)
def test_a_smooth_pad_is_solved_at_some_loads(grid: dict[str, list[float]], symmetry: Symmetry, most: int) -> None:
    """All poses stand within their stated errors; those between say that they are, with the map's error added."""
    layer = Spring()
    rows = rests(poses_on_grid(LayerGrid(load_sensor("triaxial-3"), layer, grid, symmetry, 1e-2)))
    assert list(rows) == loads_of(grid) and len(layer.solved) <= most and len(set(layer.solved)) == len(layer.solved)
    assert len(between(rows)) > 0.6 * len(rows)
    shear = 2.0 * max(row.pose.d_h for row in rows.values())
    for load, row in rows.items():
        true = layer.pose(load)
        for name in POSE:
            assert abs(getattr(row.pose, name) - getattr(true, name)) <= getattr(row.error, name) + 1e-15
        assert row.error.d_h < 1e-2 * shear + 1.1e-7 and row.error.d_v < 1e-3 * shear + 1.1e-7
        assert row.report.min_J == pytest.approx(0.9)


def test_a_round_pad_takes_shear_in_any_direction_as_a_load_in_the_plane() -> None:
    """No load leaves it; a square pad swaps F_x and F_y, and what is solved is what a table over them shares."""
    for symmetry, beside in ((DISC, 0), (SQUARE, 2)):
        layer = Spring()
        poses_on_grid(LayerGrid(load_sensor("triaxial-3"), layer, SPACE, symmetry, 1e-2))
        leaving = {(load.F_x, load.F_y) for load in layer.solved if load.out_of_plane}
        assert len(leaving) <= beside and all(x >= y > 0.0 for x, y in leaving)


def test_scatter_of_the_errors_plays_no_part_in_the_map() -> None:
    """Errors go up and down from load to load: those between lie between them, and have what the poses' map adds."""

    class Scattered(Spring):
        def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
            found = super().equilibrium(wrench, start=start)
            own = 1e-7 * (2.0 + np.sin(1e3 * wrench.F_x * (1.0 + wrench.F_z)))
            return replace(found, error=Pose(own, own, own))

    rows, plain = (
        rests(poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, GRID, NONE, 1e-2)))
        for layer in (Scattered(), Spring())
    )
    assert between(rows) == between(plain) and len(between(rows)) > 50
    for load in between(plain):
        assert rows[load].pose.d_h == plain[load].pose.d_h
        assert 1e-7 <= rows[load].error.d_h - (plain[load].error.d_h - 1e-7) <= 3e-7 + 1e-18
    assert max(plain[load].error.d_v for load in between(plain)) > 1.1e-7


def test_a_kink_is_solved_through() -> None:
    """Where the map does not predict its own loads, more are solved: all values of the shear."""
    layer = Spring(kink=2.0)
    rows = rests(poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, GRID, MIRRORS, 1e-2)))
    assert {abs(load.F_x) for load in layer.solved} == {abs(value) for value in GRID["F_x"]}
    for load, row in rows.items():
        assert abs(row.pose.d_h - layer.pose(load).d_h) <= row.error.d_h + 1e-15


def test_nothing_is_put_beside_a_failed_load() -> None:
    """The grid is solved whole, and every load beyond the limit says so itself, or whose image it is."""
    layer = Spring(limit=3.2)
    found = poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, GRID, MIRRORS, 1e-2))
    failed = {load: one for load, one in found.items() if one.status != "ok"}
    assert len(failed) == 9 * 2 and not between(rests(found)) and all(one.rest is None for one in failed.values())
    assert failed[Wrench(0.5, 4.0)].reason == "too much"
    assert failed[Wrench(-0.5, 4.0)].reason == "F_x = 0.5 N, F_z = 4 N, M = 0 N m: too much"
    assert len(layer.solved) == 45


def test_small_grids_are_solved_whole() -> None:
    """Thirty loads are too few to leave any out."""
    layer, grid = Spring(), {"F_x": GRID["F_x"][:6], "F_z": GRID["F_z"][:5]}
    assert len(poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, grid, NONE, 1e-2))) == 30
    assert len(layer.solved) == 30


@dataclass
class Meshes(Spring):
    """The round pad on meshes: two of them own to `off` times what the load moves, finer ones to what is asked."""

    off: float = 0.05
    finest: bool = False
    asked: list[float] = field(default_factory=list)
    depths: list[int] = field(default_factory=list)
    started: dict[Wrench, Wrench] = field(default_factory=dict)

    @property
    def rough(self) -> "Meshes":
        """The same, and what it remembers."""
        return replace(self)

    def towards(self, goal: Array, tolerance: float, deepest: int = 99) -> "Meshes":
        """The same with smaller errors, of which d_h's alone is of the goal; remembers the tolerance."""
        self.asked.append(tolerance)
        self.depths.append(deepest)
        return replace(self, off=tolerance / goal[0, 0], finest=True)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the formula's pose, a tenth off on the first meshes."""
        if start is not None and not self.finest:
            self.started[wrench] = start.wrench
        found = super().equilibrium(wrench)
        way = np.abs(found.pose.components - [0.0, 2e-3, 0.0, 0.0, 0.0, 0.0])
        size = 1.0 if self.finest else way[0]
        place = found.pose.components + (0.0 if self.finest else 0.2 * self.off * way)
        error = np.where(way > 0.0, self.off * size * way / max(way[0], 1e-9), 0.0)
        return replace(found, pose=Pose.of(place), error=Pose.of(error), shared=error[None])


def goal(weight: float) -> Goal:
    """One signal that goes by d_h alone [1/m]."""
    return Goal(np.array([[weight, 0, 0, 0, 0, 0]]), 0.0)


def test_few_loads_are_solved_as_far_as_the_goal_takes_each() -> None:
    """Three of them, one at rest; images come from what was solved."""
    layer, grid = Meshes(), {"F_x": [-0.4, 0.0, 0.4], "F_z": [1.0]}
    rows = rests(poses_on_grid(
        LayerGrid(load_sensor("biorob2018"), layer, grid, MIRRORS, 1e-2), after=lambda _: goal(1e3)
    ))
    assert layer.asked == [1e-2, 1e-2] and layer.depths == [99, 99]
    assert [load.F_x for load in layer.solved] == 2 * [0.0, 0.4]  # first, then finer
    assert rows[Wrench(0.4, 1.0)].error.d_h == pytest.approx(1e-5)
    assert rows[Wrench(-0.4, 1.0)].pose.d_h == -rows[Wrench(0.4, 1.0)].pose.d_h == -layer.pose(Wrench(0.4, 1.0)).d_h


def test_of_many_loads_two_are_solved_until_the_worst_is_good_enough() -> None:
    """Each to the share of its own error that is asked of the worst."""
    sensor, layer, weight = load_sensor("biorob2018"), Meshes(), 1e3
    found = poses_on_grid(LayerGrid(sensor, layer, GRID, MIRRORS, 1e-2), after=lambda _: goal(weight))
    first = Meshes().equilibrium(Wrench(1.0, 4.0)).error.d_h * weight
    assert len(layer.asked) == 2 and layer.asked[1] < 0.8e-2
    assert layer.asked[0] == pytest.approx(1e-2)  # of the worst load itself
    assert layer.asked[1] / 1e-2 == pytest.approx(0.05 * weight * layer.pose(Wrench(0.5, 4.0)).d_h / first, rel=0.3)
    assert worst(found.values(), goal(weight)) < 0.5 * first


@pytest.mark.parametrize(("tolerance", "deepest"), [(3e-3, 3), (2.9e-3, 99)])
def test_of_many_loads_finer_meshes_than_three_are_asked_for_small_tolerances(tolerance: float, deepest: int) -> None:
    layer = Meshes()
    poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, GRID, MIRRORS, tolerance), after=lambda _: goal(1e3))
    assert layer.depths == [deepest, deepest]


@pytest.mark.parametrize(("left", "depths"), [(0.4, [3, 3]), (0.6, [3, 3, 4, 4]), (1.3, [3, 3])])
def test_a_fourth_mesh_is_taken_where_it_promises_the_tolerance(left: float, depths: list[int]) -> None:
    """Neither where three do, nor where a fourth would not."""

    class Third(Meshes):
        def towards(self, goal: Array, tolerance: float, deepest: int = 99) -> Meshes:
            return super().towards(goal, tolerance * (left if deepest == 3 else 0.1), deepest)

    layer = Third()
    poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, GRID, MIRRORS, 1e-2), after=lambda _: goal(1e3))
    assert layer.depths == depths


@dataclass
class Jumping(Meshes):
    """Under the largest shear, where rims crease, poses jump by three percent, of five that they own to."""

    creased: bool = True

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found = super().equilibrium(wrench, start=start)
        far, jump = abs(wrench.F_x) > 0.6, 1.0 + 0.03 * bool(np.sin(7.0 * wrench.F_z) > 0.0)
        stretch = 1.05 if self.finest else 1.1
        report = replace(found.report, model="block", creased=far and self.creased, stretch=stretch)
        pose = replace(found.pose, d_h=found.pose.d_h * (jump if far else 1.0))
        return replace(found, pose=pose, report=report, state=np.zeros(2))


def test_no_map_goes_through_what_loads_are_off_by_that_are_not_compared() -> None:
    """Fewer are solved; none that is compared reaches as far, so that a quarter of the load tells the stretch alone."""
    asked = list[int]()
    for creased in (True, False):
        layer = Jumping(creased=creased)
        grid, far = LayerGrid(load_sensor("biorob2018"), layer, GRID, MIRRORS, 1e-2), Wrench(1.0, 4.0)
        begun = settle(layer, [far], symmetry=MIRRORS)
        rows = rests(poses_on_grid(grid, after=lambda _: goal(1e3), begun=begun))
        asked.append(len(set(layer.solved)))
        assert layer.depths == ([3] if creased else [3, 3])
        if creased:
            assert [row.report.stretch for row in rows.values()] == pytest.approx([1.05] * len(rows))
            for load, row in rows.items():
                assert abs(row.pose.d_h - layer.pose(load).d_h) <= row.error.d_h + 1e-12
    assert asked[0] < 20 < 30 < asked[1]


def test_few_loads_without_a_goal_are_solved_on_all_meshes_at_once() -> None:
    """Three with their images; of four the first meshes come first, and some are solved once more."""
    sensor, layers, shears = load_sensor("biorob2018"), (Meshes(), Meshes()), ([-0.4, 0.0, 0.4], [0.2, 0.4, 0.6, 0.8])
    for layer, shear in zip(layers, shears, strict=True):
        grid = LayerGrid(sensor, layer, {"F_x": shear, "F_z": [1.0]}, MIRRORS, 1e-2)
        assert grid.few == (layer is layers[0])
        poses_on_grid(grid)
    assert [load.F_x for load in layers[0].solved] == [0.0, 0.4]
    assert len(layers[1].solved) > len(set(layers[1].solved)) == 4


def test_what_is_good_enough_for_the_goal_is_not_solved_again() -> None:
    layer = Meshes()
    poses_on_grid(LayerGrid(load_sensor("biorob2018"), layer, GRID, MIRRORS, 1e-2), after=lambda _: goal(10.0))
    assert layer.asked == [] and len(layer.solved) == len(set(layer.solved))


def test_a_load_that_was_looked_at_before_is_not_solved_again_and_no_other_starts_from_it_early() -> None:
    sensor, looked, plain = load_sensor("biorob2018"), Meshes(), Meshes()
    far = Wrench(1.0, 4.0)
    begun = settle(looked, [far], symmetry=MIRRORS)
    with_look, without = (
        poses_on_grid(LayerGrid(sensor, layer, GRID, MIRRORS, 1e-2), after=lambda _: None, begun=known)
        for layer, known in ((looked, begun), (plain, None))
    )
    assert looked.solved.count(far) == plain.solved.count(far) == 2 and set(looked.solved) == set(plain.solved)
    assert {**looked.started, far: far} == {**plain.started, far: far}
    assert [row.pose.d_h for row in rests(with_look).values()] == [row.pose.d_h for row in rests(without).values()]


def test_the_worst_of_a_table_is_of_loads_that_rest() -> None:
    found = settle(Meshes(limit=3.0), [Wrench(0.5, 1.0), Wrench(1.0, 4.0)], symmetry=NONE).values()
    one = worst(found, goal(1e3))
    assert 0.0 < one == pytest.approx(max(1e3 * rest.rest.error.d_h for rest in found if rest.rest))
    assert np.isinf(worst(found, None)) and worst([], goal(1.0)) == 0.0


def test_the_linear_layer_needs_the_fewest() -> None:
    """A real layer whose answer the map holds to rounding."""
    sensor = load_sensor("biorob2018", ['elastomer.length="200 mm"'])
    rows = rests(poses_on_grid(LayerGrid(sensor, linear_layer(sensor, 3e-2), GRID, MIRRORS, 1e-2)))
    assert len(between(rows)) > 66


@dataclass
class Stretched(Spring):
    """Of a stretch that grows with the load and turns sharply at none; not known under some."""

    known: float = np.inf

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found, size = super().equilibrium(wrench), 1.0 + abs(wrench.F_x) + 0.1 * wrench.F_z
        return replace(found, report=replace(found.report, stretch=size if abs(wrench.F_x) < self.known else None))


def test_a_stretch_goes_straight_from_load_to_load() -> None:
    """Within what neighbours were solved with, whatever the poses' map does; of one not known none is between."""
    sensor = load_sensor("triaxial-3")
    rows = rests(poses_on_grid(LayerGrid(sensor, Stretched(), GRID, NONE, 1e-2)))
    assert between(rows)
    for load, row in rows.items():
        assert row.report.stretch == pytest.approx(1.0 + abs(load.F_x) + 0.1 * load.F_z, abs=0.02)
    rows = rests(poses_on_grid(LayerGrid(sensor, Stretched(known=0.4), GRID, NONE, 1e-2)))
    assert np.isnan([rows[load].report.stretch for load in between(rows)]).all()
    assert rows[Wrench()].report.stretch == 1.0


def test_the_map_goes_through_the_solved_loads() -> None:
    """Solved loads with scatter: those between follow them, without a step; without shear all is straight."""
    layer, sensor = Spring(wave=2e-6), load_sensor("biorob2018")
    rows = rests(poses_on_grid(LayerGrid(sensor, layer, GRID, MIRRORS, 1e-2)))
    near = [load for load in between(rows) if load.F_x > 0.0 and Wrench(load.F_x, load.F_z - 0.5) in layer.solved]
    assert near
    for load in near:
        one = rows[Wrench(load.F_x, load.F_z - 0.5)].pose.d_h
        slope = 1e-3 * load.F_x * 0.1 * 0.5
        assert abs(rows[load].pose.d_h - one - slope) < 4e-7  # a map that misses the scatter is off by its 2 um
    assert all(rows[Wrench(0.0, z)].pose.d_h == rows[Wrench(0.0, z)].error.alpha == 0.0 for z in GRID["F_z"])


def test_what_the_solved_loads_cannot_show_has_an_error_between_them() -> None:
    """On diagonals and axes a square pad does not turn about z; between them it may: no error of nothing there."""
    rows = rests(poses_on_grid(LayerGrid(load_sensor("triaxial-4"), Spring(), SPACE, SQUARE, 1e-2)))
    assert rows[Wrench(0.5, 2.0, F_y=0.25)].error.alpha_z > 0.0
    assert rows[Wrench(0.5, 1.5, F_y=0.5)].error.alpha_z == rows[Wrench(0.0, 1.5, F_y=0.5)].error.d_h == 0.0


def test_a_stopped_run_goes_on(tmp_path: Path) -> None:
    """A run that is stopped keeps its loads; the next solves the others, and gives what one run gives; a third none."""

    class Stopped(Spring):
        def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
            if len(self.solved) == 5:
                raise KeyboardInterrupt
            return super().equilibrium(wrench, start=start)

    first, second, third = Stopped(), Spring(), Spring()
    sensor, keep = load_sensor("triaxial-3"), (tmp_path, "key")
    with pytest.raises(KeyboardInterrupt):
        poses_on_grid(LayerGrid(sensor, first, SPACE, DISC, 1e-2, keep))
    seen: list[tuple[int, int]] = []
    rows, again, plain = (
        rests(poses_on_grid(LayerGrid(sensor, layer, SPACE, DISC, 1e-2, place, tell)))
        for layer, place, tell in (
            (second, keep, lambda done, of: seen.append((done, of))),
            (third, keep, no_progress),
            (Spring(), (None, ""), no_progress),
        )
    )
    assert not set(first.solved) & set(second.solved) and third.solved == []
    kept = [[(row.pose, row.error, row.report) for row in each.values()] for each in (rows, again, plain)]
    assert kept[0] == kept[1] == kept[2]
    assert seen[-1] == (125, 125) and all(done <= of <= 125 for done, of in seen)


@dataclass
class Told(Spring):
    """Errors and what they share go with F_z, derivatives with the pose; of pushes along +x there is one part more."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found, size, more = super().equilibrium(wrench), 1e-7 * (1.0 + wrench.F_z), 1 + (wrench.F_x > 0.0)
        report = replace(found.report, estimated_error=1e-3 * (1.0 + wrench.F_z))
        return replace(
            found, error=Pose.of(np.full(6, size)), report=report, shared=np.full((more, 6), 0.5 * size),
            slopes=np.tile(found.pose.components, (more, 1)),
        )


def test_between_solved_loads_errors_go_straight_and_derivatives_as_poses_do() -> None:
    """What the map adds is the same along a line, and nothing out of the plane where no load leaves it."""
    rows = rests(poses_on_grid(LayerGrid(load_sensor("biorob2018"), Told(), GRID, NONE, 1e-2)))
    here = between(rows)
    added = np.array([rows[load].error.components - 1e-7 * (1.0 + load.F_z) for load in here])
    inside = np.array([(abs(load.F_x), load.F_z % 1.0) == (0.75, 0.5) for load in here])
    np.testing.assert_allclose(added[inside, :3], np.tile(added[inside][0, :3], (inside.sum(), 1)), atol=1e-18)
    most = added[inside][0, :3]
    assert inside.sum() > 4 and np.all(np.abs(added[:, :3] - most / 2.0) <= most / 2.0 + 1e-18)
    assert added[inside][0, :3].min() > 0.0 and all(not any(rows[load].error.components[3:]) for load in here)
    for load in here:
        row = rows[load]
        np.testing.assert_allclose(row.slopes, row.pose.components[None], rtol=1e-12)
        np.testing.assert_allclose(row.shared, np.full((1, 6), 0.5e-7 * (1.0 + load.F_z)), rtol=1e-12)
        assert row.report == SolveReport(
            "interpolated", 0, 0, 0.0, 5e-3, 0.0, min_J=row.report.min_J, stretch=row.report.stretch,
            notes=(Note(NoteKind.INTERPOLATED),),
        )


def test_a_component_that_no_load_moves_has_a_tenth_of_the_largest_error_between_them() -> None:
    """As displacements of the target's edge; what moves has its own."""
    sensor = load_sensor("triaxial-3")
    rows = rests(poses_on_grid(LayerGrid(sensor, Spring(), SPACE, NONE, 1e-2)))
    load = next(load for load in between(rows) if load.F_y)
    own = np.array([1e-7, 1e-7, 1e-6, 1e-7, 1e-6, 1e-6])
    edges = (rows[load].error.components - own) * levers(sensor)
    assert edges[5] == pytest.approx(0.1 * edges.max(), rel=1e-9) and edges[5] == pytest.approx(edges.min(), rel=1e-9)


def test_values_of_a_component_stand_in_order_and_none_twice() -> None:
    assert checked_values("F_x", 2.0) == [2.0] and checked_values("F_x", [1.0, -0.5, 0.0]) == [-0.5, 0.0, 1.0]
    for near in ([1e-10, 2e-10], [1.0, 1.0 + 2e-9]):
        assert checked_values("F_x", near) == near
    for bad in ([], [[1.0, 2.0]], [0.0, np.nan], [np.inf], "much", [1.0, 1.0, 2.0], [0.0, 1e-9, 1.0]):
        with pytest.raises(SceneError, match=r"F_z must be one or more different finite forces \[N\]; got"):
            checked_values("F_z", bad)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=r"M_z must be one or more different finite moments \[N m\]; got"):
        checked_values("M_z", [])


def test_values_that_are_images_but_for_rounding_become_images() -> None:
    """One of two images is solved; others keep every digit."""
    third = 0.1 * 3
    assert checked_values("F_x", [third, -0.3]) == [-0.3, 0.3] and checked_values("F_x", [third, -0.2]) == [-0.2, third]
    assert checked_values("F_x", [-1.0 / 3.0, 1.0 / 3.0]) == [-1.0 / 3.0, 1.0 / 3.0]


def test_of_a_grid_a_part_is_likely_solved_and_of_other_loads_each() -> None:
    loads = loads_of(GRID)
    some = solved_likely(loads)
    assert 9 < len(some) < 30 and {*some} < {*loads} and Wrench(-1.0, 4.0) in some
    assert solved_likely(loads[1:]) == loads[1:]
