"""What finer meshes change over a grid: a share of what extrapolation adds, told by two loads; misses are in errors."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.corrections import _beyond_compared, _telling, corrected_loads
from sits_mech.mechanics.loads import Settled
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench

LEVERS, AT_REST = np.array([1.0, 1.0, 4e-3, 1.0, 4e-3, 4e-3]), np.array([0.0, 2e-3, 0.0, 0.0, 0.0, 0.0])
SHARE = np.array([0.1, 0.3, -0.2, 0.0, 0.0, 0.0])


def rough(load):
    """A pose that goes with the load, mirrored with F_x."""
    return np.array([1e-4 * load.F_x, 2e-3 - 2e-5 * load.F_z, 1e-3 * load.F_x, 0.0, 0.0, 0.0])


def added(load):
    """What extrapolation adds, which is not in proportion to the load."""
    return np.array([1e-6 * load.F_x * (1 + 0.1 * load.F_x**2), -4e-7 * load.F_z, 1e-5 * load.F_x, 0.0, 0.0, 0.0])


def at_rest(load, pose, errors, shared, state=()):
    report = SolveReport("formula", 1, 1, 0.0, 1e-3, 0.0)
    return Settled(Equilibrium(load, Pose.of(pose), Pose.of(errors), np.array(state), report, shared.reshape(-1, 6)))


def changed(one, stretch=None, **more):
    """The same with other parts."""
    rest = replace(one.rest, **more)
    return replace(one, rest=rest if stretch is None else replace(rest, report=replace(rest.report, stretch=stretch)))


def rows_of(F_x, F_z, error=2.0):
    loads = [Wrench(*each) for each in itertools.product(F_x, F_z)]
    return {
        load: at_rest(load, rough(load), error * np.abs(added(load)), added(load), [0.0] if load.F_x >= 0 else [])
        for load in loads
    }


def finer_by(change, error=1e-9, fails=()):
    """A model with finer meshes, and the loads it was asked for."""
    seen = []

    def finer(load):
        seen.append(load)
        at = rough(load) if load in fails else rough(load) + change(load)
        return at_rest(load, at, np.where(added(load) != 0.0, error, 0.0), np.zeros(6))

    return finer, seen


def poses(found):
    return {load: one.rest.pose.components for load, one in found.items()}


def errors(one):
    return one.rest.error.components


GRID = (np.linspace(-1, 1, 7), np.linspace(0, 4, 7))


def test_a_change_that_is_a_share_of_what_is_added_is_found_from_two_loads():
    """The farthest and a nearer one, and of no image; errors are the share of the first that finer answers own to."""
    before, (finer, seen) = rows_of(*GRID, error=1.0), finer_by(lambda load: SHARE * added(load))
    found = corrected_loads(before, finer, LEVERS, AT_REST)
    assert seen[0] == Wrench(1.0, 4.0) and len(seen) == 2 and 0.0 < seen[1].F_x < 1.0 and seen[1].F_z > 0.0
    left = np.array([0.9e-9, 0.7e-9, 0.9e-9])
    known = np.array([np.abs(added(load)[:3]) for load in seen])
    ends = left / known.max(axis=0), left / known.min(axis=0)
    for load, pose in poses(found).items():
        np.testing.assert_allclose(pose, rough(load) + SHARE * added(load), atol=1e-15)
        size, own = np.abs(added(load)[:3]), errors(found[load])[:3]
        beyond = np.any(size > known.min(axis=0) * (1.0 + 1e-9))  # the nearer one
        high = np.maximum(size, ends[1] * size) if beyond else ends[1] * size
        assert np.all((ends[0] * size * (1.0 - 1e-6) <= own) & (own <= high * (1.0 + 1e-6)))
    for load in seen:
        np.testing.assert_allclose(errors(found[load])[:3], left, rtol=1e-3)

@pytest.mark.parametrize("model", ["block", "planar"])
def test_in_space_loads_in_contact_or_with_creased_rims_are_not_compared(model):
    """Of the free family (state 0) alone, next ones in their place; sections are compared all the same."""
    before = rows_of(*GRID)
    for load, one in before.items():
        report = replace(one.rest.report, model=model, creased=load.F_z == 4.0)
        state = one.rest.state + (2.0 if load.F_x == 1.0 else 0.0)
        before[load] = replace(one, rest=replace(one.rest, report=report, state=state))
    finer, seen = finer_by(lambda load: SHARE * added(load))
    corrected_loads(before, finer, LEVERS, AT_REST)
    plain = [load.F_x < 1.0 and load.F_z < 4.0 for load in seen]
    assert seen and (all(plain) if model == "block" else seen[0] == Wrench(1.0, 4.0))


def test_beyond_a_compared_load_errors_grow_by_the_squares_of_displacements():
    """Of an angle by those of the farthest; more where the first meshes own to more than in proportion."""
    way = np.array([[1.0, 0.3, 0.4, 0, 0, 0], [2.0, 0.3, 0.5, 0, 0, 0], [0.5, 0.3, 0.1, 0, 0, 0]])
    grown = _beyond_compared(np.array([[1.0] * 6, [2.0, 1.0, 6.0, 2.0, 2.0, 2.0], [0.5] * 6]), way, [0])
    np.testing.assert_allclose(grown[:, 0, :3], [[1, 1, 1], [4, 1, 12], [1, 1, 1]])


def test_stretch_is_told_as_finer_meshes_show_it():
    """The larger share of what is above one, and no more than the first meshes told."""
    for shares, expected in (((0.7, 0.8), 0.8), ((1.1, 0.9), 1.0)):
        before, (finer, seen) = rows_of(*GRID), finer_by(lambda load: SHARE * added(load))
        before = {load: changed(one, 1.0 + 0.2 * abs(load.F_x)) for load, one in before.items()}

        def stretched(load, finer=finer, seen=seen, shares=shares, before=before):
            own = finer(load)  # which is seen then
            return changed(own, 1.0 + shares[len(seen) - 1] * (before[load].rest.report.stretch - 1.0))

        found = corrected_loads(before, stretched, LEVERS, AT_REST)
        for load, one in found.items():
            assert one.rest.report.stretch == pytest.approx(1.0 + expected * 0.2 * abs(load.F_x))


def test_the_share_is_weighed_by_the_errors():
    """c = sum D a/sum E^2: of a change that is known to half of what is added a quarter is made, the rest is told."""
    before, (finer, _) = rows_of(*GRID), finer_by(lambda load: added(load))
    found = corrected_loads(before, finer, LEVERS, AT_REST)
    near = next(load for load in found if 0.2 < load.F_x < 0.5 and load.F_z == 2.0)
    np.testing.assert_allclose(poses(found)[near], rough(near) + 0.25 * added(near), atol=1e-15)
    assert found[near].rest.error.d_h == pytest.approx(0.75 * abs(added(near)[0]) + 1e-9, rel=0.1)


def test_errors_hold_what_no_share_explains():
    """A change that goes with the load otherwise is in the error where it was seen; more of it makes it larger."""
    told = []
    for odd in (0.0, 2e-7):

        def change(load, odd=odd):
            return 0.1 * added(load) + np.array([odd * load.F_z, 0, 0, 0, 0, 0])

        finer, seen = finer_by(change)
        found = corrected_loads(rows_of(*GRID), finer, LEVERS, AT_REST)
        for load in seen:
            missed = np.abs(poses(found)[load] - rough(load) - change(load))
            assert np.all(missed <= errors(found[load]) + 1e-15)
        told.append(found[Wrench(1.0, 4.0)].rest.error.d_h)
    assert told[1] > told[0]
    assert found[Wrench()].rest.error.d_h == 0.0  # without load nothing moves


def test_what_is_shared_keeps_its_sign_in_a_part_for_each_component():
    before, (finer, _) = rows_of(*GRID), finer_by(lambda load: SHARE * added(load))
    found = corrected_loads(before, finer, LEVERS, AT_REST)
    for load, own in found.items():
        parts = own.rest.shared
        assert parts.shape == (6, 6) and np.count_nonzero(parts - np.diag(np.diag(parts))) == 0
        assert np.all(np.sign(np.diag(parts)) == np.sign(added(load)))
        assert np.all(np.abs(parts).sum(axis=0) <= errors(own) + 1e-18)


def test_where_the_first_meshes_own_to_more_than_was_compared_their_error_grows_back():
    before = rows_of(*GRID)
    hard = Wrench(1.0, 2.0)
    before[hard] = changed(before[hard], error=Pose.of(1e3 * errors(before[hard])))
    found = corrected_loads(before, finer_by(lambda load: SHARE * added(load))[0], LEVERS, AT_REST)
    assert found[hard].rest.error.d_h == pytest.approx(before[hard].rest.error.d_h)
    easy = Wrench(1.0, 0.0)
    assert found[easy].rest.error.d_h < before[easy].rest.error.d_h


def test_a_load_that_no_finer_mesh_gets_to_is_passed_over():
    before = rows_of(*GRID)
    finer, seen = finer_by(lambda load: SHARE * added(load))
    corrected_loads(before, finer, LEVERS, AT_REST)
    again, others = finer_by(lambda load: SHARE * added(load), fails=(seen[0],))
    found = corrected_loads(before, again, LEVERS, AT_REST)
    assert len(others) == 3 and others[:2] == seen
    assert found[Wrench(1.0, 4.0)].rest.error.d_h < before[Wrench(1.0, 4.0)].rest.error.d_h


def test_finer_meshes_that_fail_change_nothing():
    before = rows_of(np.linspace(-1, 1, 5), np.linspace(0, 4, 5))
    tried = []
    failed = Settled(None, status="failed")
    assert corrected_loads(before, lambda load: tried.append(load) or failed, LEVERS, AT_REST) == before
    assert len(tried) == 4
    assert corrected_loads({Wrench(): before[Wrench()]}, lambda load: 1 / 0, LEVERS, AT_REST) == {
        Wrench(): before[Wrench()]
    }


def test_the_load_that_moves_all_components_most_comes_first_then_a_nearer_one_in_another_proportion():
    """Each component over its own largest, however small it is; what rests does not count; of one proportion one."""
    way = np.array([[1.0, 0.05, 0.0], [0.4, 0.05, 0.0], [0.5, 0.1, 1e-5], [1.0, 0.1, 0.0], [0.7, 0.07, 0.0]])
    way = np.hstack([way, np.zeros((5, 3))])
    assert _telling(way, [0, 1, 2, 3, 4]) == ([3, 2, 4, 1], 2)
    assert _telling(way, [0, 3, 4]) == ([3, 4], 1)
    assert _telling(way, [1]) == ([1], 1) and _telling(way, []) == ([], 1)


def test_loads_that_move_otherwise_are_corrected_each_by_its_own():
    """Smoothly between: the change under one load is not that under another."""
    shares = {}

    def change(load):
        return shares.setdefault(load, (-0.1, 0.8)[len(shares)]) * added(load)

    found = corrected_loads(rows_of(*GRID, error=1.0), finer_by(change)[0], LEVERS, AT_REST)
    moved = {load: (pose - rough(load))[0] / added(load)[0] for load, pose in poses(found).items() if load.F_x}
    assert all(moved[load] == pytest.approx(share, abs=0.01) for load, share in shares.items())
    assert all(-0.11 <= each <= 0.81 for each in moved.values()) and np.ptp([*moved.values()]) > 0.85


def test_loads_without_an_error_are_not_compared():
    before = rows_of(*GRID)
    finer, seen = finer_by(lambda load: SHARE * added(load))
    corrected_loads(before, finer, LEVERS, AT_REST)
    before |= {load: changed(before[load], error=Pose.of(np.zeros(6))) for load in seen}
    again, others = finer_by(lambda load: SHARE * added(load))
    corrected_loads(before, again, LEVERS, AT_REST)
    assert len(others) == 2 and not {*others} & {*seen}


def test_errors_are_those_of_finer_meshes_where_first_ones_were_right():
    """A change as large as the first meshes' errors, all of which is made."""
    finer, seen = finer_by(added, error=1e-8)
    found = corrected_loads(rows_of(*GRID, error=1.0), finer, LEVERS, AT_REST)
    least = min(seen, key=lambda load: abs(load.F_x))
    assert found[least].rest.error.d_h == pytest.approx(0.9e-8)


def test_a_component_that_no_compared_load_has_is_told_by_the_worst_of_the_others():
    """d_y has an error under one load only, which was not compared: it falls as that which fell least."""
    before, far = rows_of(*GRID), Wrench(1.0, 2.0)
    before[far] = changed(before[far], error=Pose.of(errors(before[far]) + [0, 0, 0, 1e-9, 0, 0]))
    found = corrected_loads(before, finer_by(lambda load: SHARE * added(load))[0], LEVERS, AT_REST)
    fallen = errors(found[far])[:4] / errors(before[far])[:4]
    assert fallen[3] == pytest.approx(fallen[:3].max()) and fallen[:3].min() < 0.9 * fallen[3]
