"""Seconds and errors of rungs: what a request takes, and what the next ones would."""

import itertools

import pytest

from sits_mech.chain.models import MAGNETICS, MECHANICS
from sits_mech.chain.prices.costs import COSTS, REACHED, cost, magnetic_tolerance, steps


def test_every_model_has_a_price() -> None:
    """Finer rungs cost no less; what the finest reaches is below every rung that is asked for."""
    names = {("mechanics", name) for name in MECHANICS} | {("magnetics", name) for name in MAGNETICS}
    assert set(COSTS) == set(REACHED) == names
    for rungs in COSTS.values():
        assert rungs[-1][0] == 0.0
        for (at, once, each), (finer, more, longer) in itertools.pairwise(rungs):
            assert finer < at and (more >= once or longer >= each)


def test_steps_follow_the_tolerance() -> None:
    """The rung asked for, and two finer ones of each half; conductors in space take their time."""
    parts = [("mechanics", "block", 3), ("magnetics", "planar", 5)]
    asked, finer = steps(parts, 1e-2, True)
    assert [(step.half, step.tolerance) for step in asked] == [("mechanics", 1e-2), ("magnetics", 1e-3)]
    assert magnetic_tolerance("planar", 1e-2) == 1e-3 and magnetic_tolerance("sheets", 1e-2) == 1e-2
    assert [step.seconds for step in asked] == [cost(half, name, at, count) for (half, name, count), at in
                                                zip(parts, (1e-2, 1e-3), strict=True)]
    assert [step.tolerance for step in finer if step.half == "mechanics"] == [1e-3, REACHED["mechanics", "block"]]
    given, _ = steps(parts[1:], 1e-2, False)
    assert given[0].tolerance == 1e-2
    alone, among, outlines = (steps([("magnetics", "sheets", 2)], 1e-2, False, near)[0][0].seconds
                              for near in ((0, 0), (1, 0), (1, 1)))
    assert alone < among - 1.0 < outlines - 10.0


def test_nothing_finer_than_the_finest() -> None:
    """A tolerance below all rungs is not reached, and has none beyond."""
    asked, finer = steps([("magnetics", "planar", 1)], 1e-9, False)
    assert asked[0].error == REACHED["magnetics", "planar"] and finer == ()
    with pytest.raises(KeyError):
        steps([("magnetics", "none", 1)], 1e-2, False)
