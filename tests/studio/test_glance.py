"""Figures by a table that is there, against those of a design that is solved at the same loads."""

import numpy as np
import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.scene.sensor import load_sensor
from sits_mech.studio.asked import at_a_glance
from sits_mech.synthesis.required.requirements import requirements_of
from sits_mech.synthesis.solved.loads import loads_between


@pytest.mark.slow
def test_the_same_figures_as_a_design_at_its_loads() -> None:
    """Resolution, crosstalk, size and rate; a load without a result is refused."""
    sensor = load_sensor("biorob2018-w15")
    asked = requirements_of({
        "loads": {"F_x": ["-0.5 N", "0.5 N"], "F_z": ["0 N", "1 N"]},
        "vary": {"elastomer.thickness": ["2 mm", "3 mm"]},
        "require": {"resolution": {"F_x": "1 mN"}, "crosstalk_before_inverse": "90 %", "height": "4 mm"},
    }, sensor=sensor)
    loads = loads_between(asked.loads)
    axes = {name: axis.tolist() for name, axis in zip(loads.names, loads.axes, strict=True)}
    data = calibrate(sensor, **axes, mechanics="linear", magnetics="planar", tolerance=0.02)
    task, found = at_a_glance(asked, sensor, data)
    figures = task.figures(found)
    assert figures["height"] == pytest.approx(2.32e-3, abs=2e-5) and figures["rate"] > 0.0
    assert found.table is not None
    resolution, error = task.judge.over_loads(found.table, task.judge.operator.points)
    most = [figures["resolution.F_x"], figures["resolution.F_z"]]
    np.testing.assert_allclose(resolution.max(axis=0), most, rtol=1e-12)
    assert not error.any() and 0.0 < figures["crosstalk_before_inverse"] < 0.9
    assert set(found.error) >= {"resolution.F_x", "crosstalk_before_inverse"}
    data["status"][0, 0] = "not carried"
    with pytest.raises(ValueError, match="loads: every one must have a result"):
        at_a_glance(asked, sensor, data)
