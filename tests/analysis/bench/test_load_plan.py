"""Loads that tell most: none of many others tell more; rigs have the loads that they can make."""

import numpy as np
import pytest

from sits_mech.analysis.bench.force_maps import moduli
from sits_mech.analysis.bench.load_plan import Bench, plan_loads, softest_of
from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.prior import Prior, inverted
from sits_mech.analysis.readings.measured import Measured
from sits_mech.scene.sensor import SceneError

LOADS = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 1.2], [-0.3, 1.2], [0.0, 0.6]])


def test_planned_loads_tell_more_than_others(prior: Prior) -> None:
    """Of 200 sets of as many loads at random none brings the forces' mean square error as low."""
    plan = plan_loads(prior, 3)
    gain, start = prior.fisher(plan.read), prior.tared
    answers, by = prior.force_slopes(prior.start, plan.read)
    each = answers @ by / np.ptp(plan.read, axis=0)[:, None]
    goal = np.einsum("mdp,mdq->pq", each, each)
    index = [int(np.argmin(np.abs(plan.read - load).sum(axis=1))) for load in plan.loads]
    best = np.sum(goal * inverted(start + gain[index].sum(axis=0)))
    rng = np.random.default_rng(0)
    others = [np.sum(goal * inverted(start + gain[rng.integers(len(gain), size=3)].sum(axis=0))) for _ in range(200)]
    assert best <= min(others) * (1.0 + 1e-9)
    assert np.all(np.diff(plan.errors.mean(axis=1)) < 0.0) and np.all(plan.more <= plan.errors[-1] * (1.0 + 1e-9))


def test_rigs_make_their_own_loads(prior: Prior) -> None:
    """Weights and a press do not shear; a dial for the way down tells more than weights alone."""
    weights, press, stage = (plan_loads(prior, 3, rig) for rig in ("weights", "press", "stage"))
    assert np.all(weights.loads[:, 0] == 0.0) and np.all(press.loads[:, 0] == 0.0) and np.any(stage.loads[:, 0])
    assert stage.errors[-1].mean() < min(press.errors[-1].mean(), weights.errors[-1].mean())


@pytest.mark.parametrize(("count", "rig", "what"), [(0, "stage", "plan: must be"), (3, "robot", "rig: must be one")])
def test_what_is_no_plan_is_refused(prior: Prior, count: int, rig: str, what: str) -> None:
    """No load; a rig of another name."""
    with pytest.raises(SceneError, match=what):
        plan_loads(prior, count, rig)


def test_loads_are_those_of_the_bench(prior: Prior) -> None:
    """Weights at hand, of which what is too much is named with the table that it needs; multiples of a step."""
    plan = plan_loads(prior, 3, "weights", bench=Bench.written("20 g, 50 g, 0.7 N, 10 kg", None))
    assert {*np.round(plan.loads[:, 1], 4)} <= {0.1961, 0.4903, 0.7} and not plan.loads[:, 0].any()
    (left,) = plan.too_much
    assert left.startswith("98.1 N: above") and "calibrate to at least" in left
    whole = plan_loads(prior, 4, bench=Bench.written("", "0.1 N")).loads / 0.1
    assert np.allclose(whole, np.round(whole), atol=1e-9) and np.ptp(whole[:, 0]) > 1.0
    assert not np.signbit(plan_loads(prior, 3, bench=Bench.written("", "0.6 N")).loads).any()  # none is "0", never "-0"
    for weights, step in (("50 apples", None), ("-50 g", None), ("50 kg", None), ("", "0 N"), ("50 g", "1 N")):
        with pytest.raises(SceneError, match="--weights|--step"):
            plan_loads(prior, 2, "weights", bench=Bench.written(weights, step))


def test_a_soft_sensor_is_read_at_planned_loads(prior: Prior) -> None:
    """At two deviations of its modulus; where a fit ends, it says what the table must hold."""
    plan = plan_loads(prior, 4)
    places = prior.setup.names.index("modulus")
    soft = prior.start.copy()
    soft[places] = softest_of(prior)
    y = prior.bench(plan.loads).model(soft[None])[0]
    assert plan.least <= softest_of(prior) * (1.0 + 1e-9) and np.isfinite(y).all()
    found = adapt(prior, Measured(plan.loads, y, "bench"))
    assert found.values[places] == pytest.approx(soft[places], rel=0.05)
    (least, _), (why, _) = moduli(np.array([[0.0, 1.5]]), prior.table, prior.forces, 0.7)
    assert 0.7 < least < 0.75 and "has 1.5 N: calibrate to at least 2.7 N of F_z" in why  # 1.5/(0.8 least)
    assert "calibrate to at least 3 N of F_z" in moduli(np.array([[0.0, 1.5]]), prior.table, prior.forces, 0.5)[1][0]


def test_what_is_no_inductance_is_refused_at_once(prior: Prior) -> None:
    """Not a number, zero, below it, or microhenries without a unit: which coil and row."""
    for wrong in (np.nan, 0.0, -1e-6, 2.3):
        L = prior.bench(LOADS).model(prior.start[None])[0]
        L[2, 1] = wrong
        with pytest.raises(SceneError, match=r"bench: .*, in H where no unit is; got \S+ H of coil 2 in row 3"):
            adapt(prior, Measured(LOADS, L, "bench"))
