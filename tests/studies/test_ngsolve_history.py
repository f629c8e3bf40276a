"""The independent code that follows pads with a memory: elastic limits, creep in closed form, softening once."""

import numpy as np
import pytest
from common.reference_cases import Case
from scipy.special import erf

pytestmark = pytest.mark.slow
TIMES = np.linspace(0.0, 1.0, 5)


def followed(times, shares, load=0.5, **memory):
    """Sink [mm] of a small layer under shares of a load [N/mm over MPa]."""
    from common.ngsolve_history import PadHistory
    from common.ngsolve_solve import discrete

    case = Case("", "plane", (8.0, 1e3), (5.0, 1e3), 4.0, (0.0, 1.0, 0.0), **memory)
    pad = PadHistory(discrete(case, 3, 1, True), case.prony, case.mullins)
    loads = np.outer(shares, [0.0, load, 0.0])
    return -pad.follow(np.asarray(times), loads)[:, 1]


@pytest.fixture(autouse=True)
def installed():
    """Without NGSolve there is nothing to follow."""
    pytest.importorskip("ngsolve")


def test_without_a_memory_it_is_the_elastic_pad():
    """The stress form and the energy of the elastic pads have one equilibrium."""
    from common.ngsolve_solve import discrete

    case = Case("", "plane", (8.0, 1e3), (5.0, 1e3), 4.0, (0.0, 1.0, 0.0))
    elastic = -discrete(case, 3, 1, True).solve(np.array([0.0, 0.5, 0.0]), 2)[1]
    assert followed(TIMES, TIMES)[-1] == pytest.approx(elastic, rel=1e-3)


def test_small_loads_creep_in_closed_form():
    """One branch of weight w, a load that rises evenly: ``C(t) = 1 - w exp(-(1 - w) t/tau)``, K next to infinite."""
    w, tau, times = 0.25, 0.5, np.linspace(0.0, 1.0, 41)
    memory = {"prony": ((w, tau),), "bulk": 1e5}
    found = followed(times, times, load=1e-4, **memory) / followed([0.0, 1.0], [0.0, 1.0], load=1e-4, bulk=1e5)[-1]
    slow = tau / (1.0 - w)
    assert found == pytest.approx(times + w * slow * np.expm1(-times / slow), abs=1e-3)


def test_a_small_load_let_go_is_softened():
    """Virgin up to the peak; back between the virgin layer and the softest one; home at none."""
    times, small = np.linspace(0.0, 2.0, 21), {"load": 1e-4, "bulk": 1e5}
    path = 1.0 - np.abs(times - 1.0)
    virgin, found = followed(times, path, **small), followed(times, path, mullins={"r": 2.5}, **small)
    assert found[:11] == pytest.approx(virgin[:11], rel=1e-5)
    softest = 1.0 - erf(1.0) / 2.5  # eta of a point without energy
    assert np.all((found[11:20] > virgin[11:20]) & (found[11:20] < virgin[11:20] / softest))
    assert abs(found[-1]) < 1e-6 * found[10]
