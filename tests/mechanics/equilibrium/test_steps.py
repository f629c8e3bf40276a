"""A step of time of a layer: sudden loads, long ones, what is kept, what fails."""

import numpy as np
import pytest

from sits_mech.mechanics.equilibrium import increments
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.increments import begun, later
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.material import silicone_from

PRONY = [{"weight": 0.3, "time": 0.5}]
LOAD, FREE = np.array([0.1, 0.5, 0.0]), np.zeros(3, dtype=bool)


def body(**more):
    table = {"law": "neo-hookean", "shear_modulus": 2e4, "bulk_modulus": 2e7} | more
    sensor = load_sensor("biorob2018")
    layer = sensor.elastomer.model_copy(update={"material": silicone_from(table)})
    return bonded_body(sensor.model_copy(update={"elastomer": layer}), SectionFineness(4, 2.0))


@pytest.fixture(scope="module")
def elastic():
    own = body()
    return advance(own, rest(own), Path((np.zeros(3), LOAD))).state


def test_long_time_ends_at_the_elastic_rest(elastic):
    own = body(prony=PRONY)
    now = later(own, begun(own), 0.0, LOAD, FREE)
    for _ in range(4):
        now = later(own, now, 1000.0, LOAD, FREE)
    np.testing.assert_allclose(now.state.q, elastic.q, rtol=1e-8, atol=1e-12)


def test_a_sudden_load_meets_the_instantaneous_layer():
    """A law 1/(1 - w) times as stiff in shear, of the same bulk modulus."""
    soft, stiff = body(prony=PRONY), body(shear_modulus=2e4 / 0.7)
    now = later(soft, begun(soft), 0.0, LOAD, FREE)
    there = advance(stiff, rest(stiff), Path((np.zeros(3), 0.7 * LOAD))).state  # loads are in shear moduli
    np.testing.assert_allclose(now.state.q, there.q, rtol=1e-7, atol=1e-12)


def test_a_held_place_relaxes_and_is_gone_on_from(monkeypatch):
    """A small shear is held by 1/(1 - w) times the force of long after; the next step begins at the place."""
    own, held, place, paths = body(prony=PRONY), np.arange(3) == 0, np.array([1e-6, 0.0, 0.0]), []
    monkeypatch.setattr(increments, "advance", lambda *given, **rule: paths.append(given[2]) or advance(*given, **rule))
    now = later(own, begun(own), 0.0, place, held)
    last = later(own, now, 1000.0, 2.0 * place, held)
    assert now.state.load[0] / last.state.load[0] == pytest.approx(0.5 / 0.7, rel=1e-3)
    assert paths[1].corners[0].tolist() == place.tolist()


def test_what_is_kept_is_of_its_own_time():
    """An unloaded layer creeps back, and a moment can be gone on from twice."""
    own = body(prony=PRONY)
    now = later(own, begun(own), 1.0, LOAD, FREE)
    off = later(own, now, 0.01, np.zeros(3), FREE)
    again = later(own, now, 0.01, np.zeros(3), FREE)
    np.testing.assert_array_equal(off.state.q, again.state.q)
    back = later(own, off, 5.0, np.zeros(3), FREE)
    assert abs(off.state.q[1]) > 10 * abs(back.state.q[1]) > 0.0


def test_a_load_that_is_not_carried_gives_its_reason():
    own = body(prony=PRONY)
    found = later(own, begun(own), 1.0, np.array([0.0, -400.0, 0.0]), FREE)
    assert found in ("lost", "inverted", "turned", "buckled", "long")
