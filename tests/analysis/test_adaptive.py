"""The adaptive calibration of the published sensor against loads it has not seen."""

import numpy as np
import pytest

from sits_mech.analysis.adaptive import calibrate_adaptively
from sits_mech.analysis.bench import free_inductances
from sits_mech.chain.simulate import simulate
from sits_mech.quantities import Wrench
from sits_mech.sensor import load_sensor


def test_few_loads_do() -> None:
    """At most 15 solves, a third of the 45 that a symmetric 9 by 9 table takes, to 1e-3 of full scale; round trip."""
    sensor = load_sensor("biorob2018-w15")
    done: list[int] = []
    found = calibrate_adaptively(
        sensor, F_x=(-1.0, 1.0), F_z=(0.0, 4.0), models=("planar", "auto"), progress=lambda n, _: done.append(n)
    )
    assert found.sampling.reached and found.sampling.solves == done[-1] <= 15 and found.reasons == ()
    cal = found.calibration
    L0 = free_inductances(sensor)
    for F in ([-0.63, 2.9], [0.87, 0.4]):
        shown = simulate(sensor, Wrench(*F), mechanics="planar").impedance
        L = np.diagonal(shown.L) / np.diagonal(shown.L0) * L0
        assert np.max(np.abs(cal.forward(*F) - L) / cal.full_scale) < 1e-3
        back = cal.inverse(L)
        assert back.status == "ok" and np.max(np.abs(back.forces - F) / (cal.high - cal.low)) < 2e-3
    np.testing.assert_allclose(cal.forward(-0.4, 1.0)[::-1], cal.forward(0.4, 1.0), rtol=1e-9)


def test_an_empty_range_is_refused() -> None:
    """One line."""
    with pytest.raises(ValueError, match=r"F_z: must be a range from low to high \[N\]; got 4.0 to 4.0"):
        calibrate_adaptively(load_sensor("biorob2018"), F_x=(-1.0, 1.0), F_z=(4.0, 4.0))
