"""Increments with friction: Coulomb's law of a whole block, what a closed way loses, the order, what a way decides."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.equilibrium import increments
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.increments import Friction, rough
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.faces.contact import Contact
from sits_mech.mechanics.faces.surface import edge_points
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.scene.sensor import load_sensor

NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
HELD = np.ones(3, dtype=bool)
REST, PRESSED = np.zeros(3), np.array([0.0, -0.05, 0.0])
F = 0.2


def layer(*more):
    sizes = ['elastomer.width="6 mm"', 'elastomer.thickness="3 mm"', 'target.width="6 mm"', "elastomer.length=1.0"]
    return load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN, *sizes, *more])


def standing(friction=F):
    """A block that is bonded to its target, and stands on the ground."""
    body = bonded_body(layer(), SectionFineness(4, 1.5))
    x, z = body.mesh.nodes.T
    bottom = np.flatnonzero(z < 1e-9)
    free = np.flatnonzero(~np.repeat(z > 1.0 - 1e-9, 2))
    surface = edge_points(body.mesh, [bottom[np.argsort(x[bottom])]])
    ground = Contact(surface, "ground", 1e-3, body.faces.target, friction=friction)
    return replace(body, free=free, parts=(ground,), shared=None)


def went(body, places, parts):
    found = advance(body, rest(body), Path((REST, *map(np.array, places)), HELD), Friction, parts=parts)
    assert found.reached == len(places) and not found.reason
    return found


@pytest.fixture(scope="module")
def slid():
    """A block pressed by 5 % and drawn by 40 % of its height."""
    return went(standing(), [PRESSED, (0.4, -0.05, 0.0)], 8)


def test_a_block_that_slides_is_held_by_the_coefficient_times_its_normal_force(slid):
    """Coulomb's law, whatever the pressures under it."""
    F_x, F_z, _ = slid.state.load
    assert F_z > 0.5 and F_x == pytest.approx(F * F_z, rel=1e-4)


@pytest.mark.slow
def test_a_block_that_sticks_is_sheared():
    """Little sideways: less than Coulomb's force, and nearly the block that is bonded below, whose edges do not slip.

    Linear theory: between a free lower face, 0, and a bonded one. Small slips under the edges, where hardly anything
    presses, are real: with more friction they go away.
    """
    place, bonded = np.array([0.01, -0.05, 0.0]), bonded_body(layer(), SectionFineness(4, 1.5))
    stuck = advance(bonded, rest(bonded), Path((REST, place), HELD)).state.load[0]
    forces = []
    for friction in (F, 0.6):
        F_x, F_z, _ = went(standing(friction), [PRESSED, place], 4).state.load
        assert F_x < 0.5 * friction * F_z
        forces.append(F_x)
    assert 0.75 * stuck < forces[0] < forces[1] < 1.02 * stuck


@pytest.mark.slow
def test_there_and_back_again_loses_the_area_of_the_loop(monkeypatch):
    """First order in the increments: 1.2 % at 8, half of that at 16; no increment gains anything."""
    there, gaps, works, states, increment = [PRESSED, (0.3, -0.05, 0.0)], [], [], [], Friction.rest

    def noted(walk, load):
        """Note the work that an increment loses: its largest traction times how far points slide."""
        end, body = increment(walk, load), walk.body
        if not end.reason:
            states.append(end.state)
            each = zip(increments.rough(body), increments._looked_at(body, end.state), strict=True)
            slides = (part.grip.largest * np.maximum(part.grip._slipped(place)[1] - part.grip.slip, 0.0)
                      for part, (place, *_) in each)
            works.append(sum(part.surface.weight.ravel() @ own
                             for part, own in zip(increments.rough(body), slides, strict=True)))
        return end

    monkeypatch.setattr(Friction, "rest", noted)
    for parts in (8, 16):
        states.clear()
        works.clear()
        went(standing(), there, parts)
        begin = len(works)
        went(standing(), [*there, (-0.3, -0.05, 0.0), there[1]], parts)
        x, force = (np.array([getattr(state, name)[0] for state in states[2 * begin - 1 :]]) for name in ("q", "load"))
        area, lost = np.trapezoid(force, x), sum(works[2 * begin :])
        assert lost > 0.0 and force[0] == pytest.approx(force[-1], rel=1e-4)
        assert area < 1.2 * F * max(state.load[1] for state in states)  # it slides 1.2 at the most
        gaps.append(abs(area / lost - 1.0))
    assert gaps[0] < 0.02 and gaps[1] < 0.6 * gaps[0]


@pytest.mark.slow
def test_twice_as_many_increments_halve_what_is_left(monkeypatch):
    """Pressing, drawing and turning at once, pressures settled to 1e-7: of first order or better in the increments.

    Differences of 4, 8, 16 and 32 increments go down by 2.3 and 3.2; with pressures to 1e-3 all are below 2e-4.
    """
    monkeypatch.setattr(increments, "_SAME", 1e-7)
    monkeypatch.setattr(increments, "_PASSES", 30)
    forces = [went(standing(0.3), [(0.05, -0.05, 0.01)], parts).state.load for parts in (4, 8, 16)]
    first, second = (np.linalg.norm(b - a) for a, b in zip(forces[:-1], forces[1:], strict=True))
    assert second < first / 1.7 < 1e-3 * np.linalg.norm(forces[-1])


@pytest.mark.slow
def test_what_comes_first_decides():
    """Pressed, then drawn, a block is held back from the first; drawn first, nothing held it; straight lies between."""
    body, end = standing(), (0.03, -0.05, 0.0)
    ways = [[PRESSED, end], [end], [(0.03, 0.0, 0.0), end]]
    pressed, straight, drawn = (went(body, way, 8).state.load[0] for way in ways)
    assert pressed > 1.05 * straight > 1.05 * 1.05 * drawn


def test_without_a_coefficient_there_is_none_and_the_way_is_the_one_without_friction():
    body = standing(0.0)
    assert not rough(body) and rough(standing())
    straight, bent = (went(body, way, 2).state.q for way in ([PRESSED], [(0.0, -0.02, 0.0), PRESSED]))
    np.testing.assert_allclose(straight, bent)
    other = advance(body, rest(body), Path((REST, PRESSED), HELD)).state
    np.testing.assert_allclose(went(body, [PRESSED], 1).state.load, other.load, rtol=1e-8, atol=1e-9)
    assert abs(went(body, [PRESSED, (0.4, -0.05, 0.0)], 2).state.load[0]) < 1e-6


@pytest.mark.slow
def test_a_way_that_ends_says_where_and_why():
    """More than the layer's height: no rest is found there, and the last one is still one."""
    found = advance(standing(), rest(standing()), Path((REST, np.array([0.0, -1.2, 0.0])), HELD), Friction, parts=2)
    assert 0.0 <= found.reached < 1.0 and found.reason in ("lost", "inverted", "slipping")
    assert found.state.min_J > 0.0
