"""A resolution at the end of the data that goes with a power of a thickness: is it out of reach?"""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.synthesis import reach
from sits_mech.synthesis.prediction import Prediction
from sits_mech.synthesis.reach import out_of_reach
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.solved.answered import Answered, Task
from sits_mech.synthesis.solved.figures import Judge, Table
from sits_mech.synthesis.solved.loads import Operator, loads_between

OPERATOR = Operator(loads_between({"F_z": (0.0, 1.0)}))


def known(x: float, strain: float) -> Prediction:
    """Return what a solved design of thickness t = 1 + x tells: dL/dF_z = t^2, a noise of 1e-3."""
    F, t, none = OPERATOR.loads.points, 1.0 + x, np.zeros((0, len(OPERATOR.loads.points), 1))
    table, plain = Table(F * t**2, none, np.array([1e-3])), {"strain": strain, "height": t}
    slopes = {"strain": np.zeros(1), "height": np.ones(1)}
    return Prediction([Answered(Design((0,), (x,)), "", table, (2.0 * t * F)[None], plain, slopes)], [])


@pytest.mark.parametrize("strain, share", [(0.5, 0.5), (2.0, 1.0)])
@pytest.mark.parametrize("growth, fall", [(1.0, (1.5 / 2.0) ** 2), (0.0, np.exp(-2.0 / 1.5 * 0.5))])
def test_the_least_of_a_box_is_that_of_tangents_of_the_logarithm(
    strain: float, share: float, growth: float, fall: float
) -> None:
    """At t = 1.5: 1e-3/2.25 of a strain of half its data is half of that at their end, and a power t^-2 is exact.

    Over a number that may be zero the tangent is that of an exponential, below the power.
    """
    least = share * 1e-3 / 2.25 * fall * reach._AT_LEAST
    for limit, said in ((0.99 * least, True), (1.01 * least, False)):
        task = Task(Judge(OPERATOR, np.zeros(0), {}, 0.95), {"resolution.F_z": limit, "strain": 1.0}, {})
        found = out_of_reach(task, [known(0.5, strain)], np.array([growth]))
        assert found.startswith("resolution.F_z some ") is said and bool(found) is said


def test_tangents_of_sums_of_powers_are_below_them() -> None:
    """Over logarithms of positive numbers their logarithm is convex: between any two points of the box."""
    rng, t = np.random.default_rng(0), np.linspace(0.0, 1.0, 7)
    powers, sizes = rng.uniform(-3.0, 3.0, 4), rng.uniform(0.1, 1.0, 4)

    class Sum:
        """A prediction whose resolution is the sum."""

        solved = ()

        def at(self, x: np.ndarray) -> Answered:
            """Return the sum at 1 + 4 x."""
            figures = {"resolution.F_z": float((sizes * (1.0 + 4.0 * x[0]) ** powers).sum()), "strain": 1.0}
            return Answered(Design((), (*x,)), "", None, np.zeros(0), figures, {})

    task = Task(Judge(OPERATOR, np.zeros(0), {}, 0.95), {}, {})
    for x in t:
        for end in t:
            ends = np.array([[end]])
            found = reach.tangents(task, Sum(), np.array([x]), ["resolution.F_z"], ends, np.array([4.0]))
            r, falls = found["resolution.F_z"]
            least = r * np.exp(falls.sum())
            assert least <= (1.0 + 1e-6) * Sum().at(np.array([end])).plain["resolution.F_z"]


def test_the_highest_bound_counts_and_none_of_a_design_that_hardly_reads_a_force() -> None:
    """Two designs at x = 0.2 and 0.5 of an exponential tangent: the bound of the first one is lower."""
    task, none = Task(Judge(OPERATOR, np.zeros(0), {}, 0.95), {"resolution.F_z": 1.0, "strain": 1.0}, {}), np.zeros(1)
    bounds = [2.25e-3 / (1.0 + x) ** 2 * np.exp(-2.0 / (1.0 + x) * (1.0 - x)) for x in (0.2, 0.5)]
    limit = 0.5 * sum(bounds) * reach._AT_LEAST / 2.25
    limited = Task(task.judge, {"resolution.F_z": limit, "strain": 1.0}, {})
    assert bounds[0] < bounds[1] and not out_of_reach(limited, [known(0.2, 2.0)], none)
    assert out_of_reach(limited, [known(0.2, 2.0), known(0.5, 2.0)], none)
    one = known(0.5, 2.0)
    assert one.solved[0].table is not None
    F = OPERATOR.loads.points
    bent = one.solved[0].table._replace(L=2.25 * (F - 0.45 * F**2))  # slopes from 1 to 0.1: the inverse is 0.18
    assert not out_of_reach(limited, [Prediction([replace(one.solved[0], table=bent)], [])], none)


def test_without_a_limit_of_a_resolution_nothing_is_out_of_reach() -> None:
    """Nor is anything, before a design is solved."""
    task = Task(Judge(OPERATOR, np.zeros(0), {}, 0.95), {"strain": 1.0}, {})
    assert out_of_reach(task, [known(0.5, 0.5)], np.ones(1)) == ""
    assert out_of_reach(task, [Prediction([], [])], np.ones(1)) == ""
