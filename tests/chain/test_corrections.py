"""What finer meshes change over a grid: a quadratic change is found from a few loads and images, misses are told."""

import itertools

import numpy as np

from sits_mech.cases import DONE
from sits_mech.chain.corrections import corrected, corrected_in_share
from sits_mech.mechanics.loads import ERRORS, shared_of, with_shared
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.quantities import POSE, Wrench

LEVERS, AT_REST = np.array([1.0, 1.0, 4e-3, 1.0, 4e-3, 4e-3]), np.array([0.0, 2e-3, 0.0, 0.0, 0.0, 0.0])
RECTANGLE = Symmetry("rectangle")


def rough(load):
    """A pose that goes with the load, mirrored with F_x."""
    return np.array([1e-4 * load.F_x, 2e-3 - 2e-5 * load.F_z, 1e-3 * load.F_x, 0.0, 0.0, 0.0])


def change(load, cubic=0.0):
    """Of second degree, and a little of the third."""
    return np.array(
        [1e-6 * load.F_x * (1.0 + 0.3 * load.F_z), -2e-6 * load.F_z - 1e-7 * load.F_x**2 - cubic * load.F_z**3,
         5e-6 * load.F_x * load.F_z, 0.0, 0.0, 0.0]
    )  # fmt: skip


def row(pose, error, **more):
    found = {"status": DONE, "error_mechanics": 1e-3} | dict(zip(POSE, pose.tolist(), strict=True))
    return found | {f"error_{name}": error for name in POSE} | more


def rows_of(F_x, F_z):
    loads = [Wrench(*each) for each in itertools.product(F_x, F_z)]
    solved = {"state": ("unknown", np.zeros(1))}
    return {load: row(rough(load), 1e-6, **(solved if load.F_x >= 0 else {})) for load in loads}


def asked(cubic=0.0):
    """A model with finer meshes, and the loads it was asked for."""
    seen = []

    def finer(load):
        seen.append(load)
        return row(rough(load) + change(load, cubic), 1e-8)

    return finer, seen


def poses(rows):
    return {load: np.array([found[name] for name in POSE]) for load, found in rows.items()}


def test_a_change_of_second_degree_is_found_from_few_loads():
    before, (finer, seen) = rows_of(np.linspace(-1, 1, 7), np.linspace(0, 4, 7)), asked()
    found = poses(corrected(before, finer, RECTANGLE, LEVERS, AT_REST))
    assert len(seen) <= 8 and all(load.F_x >= 0.0 for load in seen)
    for load, pose in found.items():
        np.testing.assert_allclose(pose, rough(load) + change(load), atol=1e-15)


def test_errors_are_the_finer_ones_and_what_the_map_misses():
    loads = (np.linspace(-1, 1, 7), np.linspace(0, 4, 7))
    smooth, rest = (corrected(rows_of(*loads), asked(cubic)[0], RECTANGLE, LEVERS, AT_REST) for cubic in (0.0, 2e-8))
    far = Wrench(1.0, 4.0)
    assert 1e-8 <= smooth[far]["error_d_h"] <= 4e-8  # that of the middle of the loads, over their displacements
    assert rest[far]["error_d_v"] > 2.0 * smooth[far]["error_d_v"]
    for load, found in rest.items():
        true = abs(found["d_v"] - (rough(load) + change(load, 2e-8))[1])
        assert true < 2.0 * rest[far]["error_d_v"]
    assert rest[Wrench()]["error_d_h"] == 0.0  # without load nothing moves


def test_two_values_of_a_component_tell_no_square():
    before, (finer, _) = rows_of([-1.0, 0.0, 1.0], [0.0, 4.0]), asked()
    found = poses(corrected(before, finer, RECTANGLE, LEVERS, AT_REST))
    for load in (Wrench(1.0, 4.0), Wrench(-1.0, 0.0)):
        np.testing.assert_allclose(found[load], rough(load) + change(load), atol=1e-15)


def test_finer_meshes_that_fail_change_nothing():
    before = rows_of(np.linspace(-1, 1, 5), np.linspace(0, 4, 5))
    assert corrected(before, lambda load: {"status": "failed"}, RECTANGLE, LEVERS, AT_REST) == before


def test_what_the_finer_answers_share_goes_with_the_load():
    """A part of their errors that is linear in the load is so everywhere, with its sign, and counts in full."""
    before, (finer, _) = rows_of(np.linspace(-1, 1, 7), np.linspace(0, 4, 7)), asked()

    def part(load):
        return np.array([[3e-8 * load.F_x, -1e-8 * load.F_z, 2e-7 * load.F_x, 0.0, 0.0, 0.0]])

    def told(load):
        found = with_shared(finer(load), part(load))
        errors = 1e-8 + np.abs(part(load))[0]
        return found | dict(zip(ERRORS, errors.tolist(), strict=True))

    for load, found in corrected(before, told, RECTANGLE, LEVERS, AT_REST).items():
        np.testing.assert_allclose(shared_of(found), part(load), atol=1e-20)
        assert found["error_d_v"] >= abs(part(load)[0, 1]) and found["error_d_h"] >= abs(part(load)[0, 0])
    assert corrected(before, told, RECTANGLE, LEVERS, AT_REST)[Wrench(1.0, 4.0)]["error_d_h"] < 3e-8 + 1e-7


def test_a_change_in_proportion_is_found_from_two_loads():
    """Of each component its own share of the displacement; errors are those of before, failures change nothing."""
    before, seen = rows_of(np.linspace(-1, 1, 7), np.linspace(0, 4, 7)), []
    share = np.array([0.02, -0.03, 0.1, 0.0, 0.0, 0.0])

    def finer(load):
        seen.append(load)
        return row(rough(load) + share * (rough(load) - AT_REST), 1e-8)

    found = corrected_in_share(before, finer, LEVERS, AT_REST)
    assert len(seen) == 2 and all("state" in before[load] and abs(load.F_x) < 1.0 for load in seen)
    for load, pose in poses(found).items():
        np.testing.assert_allclose(pose, rough(load) + share * (rough(load) - AT_REST), atol=1e-15)
    assert {one["error_d_h"] for one in found.values()} == {1e-6}
    assert corrected_in_share(before, lambda load: {"status": "failed"}, LEVERS, AT_REST) == before
