"""Loads that tell most: none of many others tell more; rigs have the loads that they can make."""

import numpy as np
import pytest

from sits_mech.analysis.built.load_plan import plan_loads
from sits_mech.analysis.built.prior import Prior, inverted
from sits_mech.scene.sensor import SceneError


def test_planned_loads_tell_more_than_others(prior: Prior) -> None:
    """Of 200 sets of as many loads at random none brings the forces' mean square error as low."""
    plan = plan_loads(prior, 3)
    told, start = prior.told(plan.read), prior.tared
    answers, by = prior.force_slopes(prior.start, plan.read)
    each = answers @ by / np.ptp(plan.read, axis=0)[:, None]
    goal = np.einsum("mdp,mdq->pq", each, each)
    index = [int(np.argmin(np.abs(plan.read - load).sum(axis=1))) for load in plan.loads]
    best = np.sum(goal * inverted(start + told[index].sum(axis=0)))
    rng = np.random.default_rng(0)
    others = [np.sum(goal * inverted(start + told[rng.integers(len(told), size=3)].sum(axis=0))) for _ in range(200)]
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
