"""A table solved as far as its signals need: what is planned and reached, what is refused, what has no reading."""

import numpy as np
import pytest

from sits_mech.chain.aimed import aimed_rows, status_of
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import SceneError, load_sensor

SENSOR = load_sensor("biorob2018-w15")
GRID = {"F_x": [-0.3, 0.0, 0.3], "F_z": [0.5, 2.0]}
BY = {"symmetry": symmetry_of(SENSOR)}


def test_what_is_planned_is_reached() -> None:
    """Within a factor of two; of a coarse tolerance the first meshes are enough, and a finer one is better for more."""
    reached, seconds = [], []
    for tolerance in (3e-3, 1e-1):
        found = aimed_rows(SENSOR, planar_layer(SENSOR, tolerance), GRID, ("planar", "planar"), tolerance, **BY)
        assert found.planned is not None and found.planned.seconds > 0.0
        assert 0.5 < found.reached / found.planned.error < 2.0
        assert set(found.rows) >= {Wrench(F_x, F_z) for F_x in GRID["F_x"] for F_z in GRID["F_z"]}
        reached.append(found.reached)
        seconds.append(found.planned.seconds)
    assert reached[0] < reached[1] and seconds[0] > seconds[1]


@pytest.mark.slow
def test_a_tolerance_that_is_not_to_be_had_is_refused_or_answered() -> None:
    layer = planar_layer(SENSOR, 1e-7)
    with pytest.raises(SceneError, match=r"must be one that can be reached at F_x = 0.3 N, F_z = 2 N, .*--best"):
        aimed_rows(SENSOR, layer, GRID, ("planar", "planar"), 1e-7, **BY, best=False)


def test_models_of_one_mesh_plan_nothing() -> None:
    found = aimed_rows(SENSOR, linear_layer(SENSOR), GRID, ("linear", "planar"), 0.1, **BY)
    assert found.planned is None and np.isnan(found.reached) and found.asked <= 0.1


def test_a_target_among_the_coils_has_no_reading() -> None:
    row = {"status": "ok", "reason": "", "d_h": 0.0, "d_v": -1e-3, "alpha": 0.0, "d_y": 0.0, "alpha_x": 0.0,
           "alpha_z": 0.0}
    assert status_of(SENSOR, row)[0] == "failed" and "coil plane" in status_of(SENSOR, row)[1]
    assert status_of(SENSOR, row | {"d_v": 2e-3}) == ("ok", "")
    assert status_of(SENSOR, row | {"status": "failed", "reason": "why"}) == ("failed", "why")
