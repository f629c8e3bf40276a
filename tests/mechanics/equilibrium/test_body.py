"""Rests that are asked for again: found once, the same to the last digit, the oldest dropped, whatever else changes."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.simulate import Simulation, simulate
from sits_mech.mechanics.block import BlockPad, block_pad
from sits_mech.mechanics.element.assembly import Pattern
from sits_mech.mechanics.equilibrium import body as bodies
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance, unloaded
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor

LOAD = Wrench(F_x=0.1, F_z=0.5)
COARSE = {"tolerance": 0.1, "mechanics": "block", "magnetics": "planar"}


@pytest.fixture
def factors(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """The sizes of the stiffnesses that are factored from here on."""
    sizes, whole = list[int](), Pattern.factored

    def factored(self: Pattern, values: object) -> object:
        sizes.append(len(self.free))
        return whole(self, values)

    monkeypatch.setattr(Pattern, "factored", factored)
    other_pad()
    sizes.clear()
    yield sizes


def other_pad() -> None:
    """Let the pad before be forgotten."""
    _ = block_pad(load_sensor("biorob2018", ['elastomer.thickness="4 mm"'])).half[0]


def simulated(*changes: str, tolerance: float = 0.1) -> Simulation:
    """Return an answer of a changed scene."""
    return simulate(load_sensor("biorob2018", list(changes)), LOAD, **COARSE | {"tolerance": tolerance})


def shown(found: Simulation) -> list[object]:
    """Return all that an answer says but for its seconds."""
    rest, each = found.equilibrium, []
    for part in (rest.pose, rest.error, rest.wrench):
        each.append(part.components.tolist())
    each += [rest.state.tolist(), rest.shared.tolist(), replace(rest.report, seconds=0.0)]
    return [*each, found.impedance.L.tolist(), found.signals.known, found.flags]


@pytest.mark.parametrize("change", [
    'coils.C1.turns=8', pytest.param('frequency="2 MHz"', marks=pytest.mark.slow),
    pytest.param('readout.converter="none"', marks=pytest.mark.slow),
])
def test_another_scene_of_the_same_pad_takes_its_rests(change: str, factors: list[int]) -> None:
    """No stiffness is factored again; the answer is that of a scene solved alone."""
    alone = shown(simulated(change))
    other_pad()
    simulated()
    factors.clear()
    assert shown(simulated(change)) == alone and not factors


@pytest.mark.slow
def test_a_finer_answer_goes_on_from_the_meshes_before(factors: list[int]) -> None:
    """What a smaller tolerance adds are finer meshes, with rims of their own; the answer is that of a scene alone."""
    coarse = simulated()
    before = max(factors)
    factors.clear()
    fine = simulated(tolerance=5e-3)
    rims = block_pad(load_sensor("biorob2018")).half[0].maker(2).patch
    assert rims is not None and len(rims.inner) in factors
    assert min(set(factors) - {len(rims.inner)}) > before
    other_pad()
    assert shown(simulated(tolerance=5e-3)) == shown(fine) != shown(coarse)


@pytest.mark.parametrize("change", [
    'elastomer.material="ecoflex-00-50"', pytest.param('target.width="12 mm"', marks=pytest.mark.slow),
])
def test_another_pad_is_solved(change: str, factors: list[int]) -> None:
    simulated()
    factors.clear()
    simulated(change)
    assert factors


def test_the_oldest_rests_go(factors: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    """As many stay as there is room for; a path that fails is remembered as well."""
    pad: BlockPad = block_pad(load_sensor("biorob2018"))
    body = pad.half[0].coarse
    monkeypatch.setattr(bodies, "ROOM", 2 * 8 * body.size)
    loads = [np.array([0.0, -force, 0.0]) for force in (0.1, 0.2, 0.3)]
    ends = [advance(body, unloaded(body), Path((0.0 * load, load))) for load in loads]
    assert len(body.rests) == 2 and all(end.reached == 1.0 for end in ends)
    factors.clear()
    again = advance(body, unloaded(body), Path((0.0 * loads[2], loads[2])))
    np.testing.assert_array_equal(again.state.u, ends[2].state.u)
    assert not factors and again.state.known is None
    advance(body, unloaded(body), Path((0.0 * loads[0], loads[0])))
    assert factors
