"""What a sensor shows under a history: against single loads, the models that are taken, values between times."""

import numpy as np
import pytest

from sits_mech.analysis.histories.response import between, in_time, taken_layer
from sits_mech.chain.simulate import simulate
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.material import silicone_from

MODELS = {"mechanics": "planar", "magnetics": "planar", "tolerance": 3e-2}


def soft(**more):
    table = {"law": "neo-hookean", "shear_modulus": 2e4, "bulk_modulus": 2e7} | more
    base = load_sensor("biorob2018")
    layer = base.elastomer.model_copy(update={"material": silicone_from(table)})
    return base.model_copy(update={"elastomer": layer})


def loads(time, *rows):
    wrench = np.zeros((len(time), 6))
    wrench[:, :2] = rows
    return LoadHistory(np.array(time, dtype=float), wrench)


@pytest.mark.slow
def test_long_after_the_last_load_it_shows_what_slow_load_does():
    own = soft(prony=[{"weight": 0.3, "time": 0.5}])
    data = in_time(own, loads([0.0, 1.0, 40.0], (0.0, 0.0), (0.3, 1.0), (0.3, 1.0)), **MODELS)
    slow = simulate(own, Wrench(F_x=0.3, F_z=1.0), **MODELS)
    last = data.isel(time=-1)
    off = np.abs(last["L"] - slow.impedance.L)
    assert np.all(off <= last["error_L"] + slow.impedance.error_L)
    assert abs(last["L_v_percent"] - slow.signals.known["L_v_percent"]) < 0.01 * abs(
        slow.signals.known["L_v_percent"] - data["L_v_percent"][0]
    )
    assert data["given"].sum() == 3


@pytest.mark.slow
def test_no_shear_by_symmetry():
    data = in_time(soft(prony=[{"weight": 0.3, "time": 0.5}]), loads([0.0, 1.0], (0.0, 0.0), (0.0, 1.0)), **MODELS)
    assert np.all(data["d_h"] == 0.0)
    assert np.all(data["error_d_h"] == 0.0)


def test_softening_takes_a_model_that_has_it():
    """Where a small load would do with a linear model."""
    small = loads([0.0, 1.0], (0.0, 0.0), (0.0, 1e-3))
    assert taken_layer(soft(), "auto", 0.1, small)[1].name == "linear"
    assert taken_layer(soft(mullins={"r": 2.0}), "auto", 0.1, small)[1].name == "block"


def test_between_times_nothing_overshoots_and_corners_stay():
    time = np.linspace(0.0, 2.0, 17)
    share = 1.0 - np.abs(time - 1.0)
    load = np.outer(share, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    values = (share**2)[:, None]
    at = np.linspace(-1.0, 3.0, 401)
    found = between(time, load, values)(at)
    exact = np.clip(1.0 - np.abs(np.clip(at, 0.0, 2.0) - 1.0), 0.0, 1.0) ** 2
    np.testing.assert_allclose(found[:, 0], exact, atol=2e-3)  # 2 % at the corner without it
    assert 0.0 <= found.min() <= found.max() <= 1.0
    np.testing.assert_allclose(between(time, load, values)(time), values)
