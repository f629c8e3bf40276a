"""A table solved as far as its signals need: what is planned and reached, what is refused, what has no reading."""

import numpy as np
import pytest

from sits_mech.chain.interpolate import LoadGrid
from sits_mech.chain.tolerance.aimed import aimed_loads, clear, status_of
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.loads import Settled
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor

SENSOR = load_sensor("biorob2018-w15")
GRID = {"F_x": [-0.3, 0.0, 0.3], "F_z": [0.5, 2.0]}
BY = symmetry_of(SENSOR)


def test_what_is_planned_is_reached() -> None:
    """Within a factor of two; of a coarse tolerance the first meshes are enough, and a finer one is better for more."""
    reached, seconds = [], []
    for tolerance in (3e-3, 1e-1):
        found = aimed_loads(LoadGrid(SENSOR, planar_layer(SENSOR, tolerance), GRID, BY, tolerance), "planar")
        assert found.planned is not None and found.planned.seconds > 0.0
        assert 0.5 < found.reached / found.planned.error < 2.0
        assert set(found.settled) >= {Wrench(F_x, F_z) for F_x in GRID["F_x"] for F_z in GRID["F_z"]}
        reached.append(found.reached)
        seconds.append(found.planned.seconds)
    assert reached[0] < reached[1] and seconds[0] > seconds[1]


@pytest.mark.slow
def test_a_tolerance_that_is_not_to_be_had_is_refused_or_answered() -> None:
    layer = planar_layer(SENSOR, 1e-7)
    with pytest.raises(SceneError, match=r"must be one that can be reached at F_x = 0.3 N, F_z = 2 N, .*--best"):
        aimed_loads(LoadGrid(SENSOR, layer, GRID, BY, 1e-7), "planar", best=False)


def test_models_of_one_mesh_plan_nothing() -> None:
    found = aimed_loads(LoadGrid(SENSOR, linear_layer(SENSOR), GRID, BY, 0.1), "planar")
    assert found.planned is None and np.isnan(found.reached) and found.asked <= 0.1


def test_a_target_among_the_coils_has_no_reading() -> None:
    def at(d_v: float) -> Settled:
        report = SolveReport("formula", 1, 1, 0.0, 0.0, 0.0)
        return Settled(Equilibrium(Wrench(), Pose(0.0, d_v), Pose(0.0, 0.0), np.zeros(0), report))

    assert status_of(SENSOR, at(-1e-3))[0] == "failed" and "coil plane" in status_of(SENSOR, at(-1e-3))[1]
    assert status_of(SENSOR, at(2e-3)) == ("ok", "") and len(clear(SENSOR, [at(-1e-3), at(2e-3)])) == 1
    assert status_of(SENSOR, Settled(None, status="failed", reason="why")) == ("failed", "why")
