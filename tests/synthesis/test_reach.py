"""A resolution at the end of the data that goes with a power of a thickness: is it out of reach?"""

import numpy as np
import pytest

from sits_mech.synthesis import reach
from sits_mech.synthesis.answered import Answered, Task
from sits_mech.synthesis.figures import Judge, Table
from sits_mech.synthesis.loads import Operator, loads_between
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.reach import out_of_reach
from sits_mech.synthesis.space import Design

OPERATOR = Operator(loads_between({"F_z": (0.0, 1.0)}))


def known(x: float, strain: float) -> Prediction:
    """Return what a solved design of thickness t = 1 + x tells: dL/dF_z = t^2, a noise of 1e-3."""
    F, t, none = OPERATOR.loads.points, 1.0 + x, np.zeros((0, len(OPERATOR.loads.points), 1))
    table, plain = Table(F * t**2, none, np.array([1e-3])), {"strain": strain, "height": t}
    slopes = {"strain": np.zeros(1), "height": np.ones(1)}
    return Prediction([Answered(Design((0,), (x,)), "", table, (2.0 * t * F)[None], plain, slopes)], [])


@pytest.mark.parametrize("strain, share", [(0.5, 0.5), (2.0, 1.0)])
def test_the_least_of_a_box_is_that_of_tangents_of_the_logarithm(strain: float, share: float) -> None:
    """At t = 1.5: 1e-3/2.25 of a strain of half its data is half of that at their end; d ln r/dx = -2/1.5 to x = 1."""
    least = share * 1e-3 / 2.25 * np.exp(-2.0 / 1.5 * 0.5) * reach._AT_LEAST
    for limit, said in ((0.99 * least, True), (1.01 * least, False)):
        task = Task(Judge(OPERATOR, np.zeros(0), {}, 0.95), {"resolution.F_z": limit, "strain": 1.0}, {})
        words = out_of_reach(task, [known(0.5, strain)], 1)
        assert words.startswith("resolution.F_z some ") is said and bool(words) is said


def test_without_a_limit_of_a_resolution_nothing_is_out_of_reach() -> None:
    """Nor is anything, before a design is solved."""
    task = Task(Judge(OPERATOR, np.zeros(0), {}, 0.95), {"strain": 1.0}, {})
    assert out_of_reach(task, [known(0.5, 0.5)], 1) == "" and out_of_reach(task, [Prediction([], [])], 1) == ""
