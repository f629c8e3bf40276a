"""References of loaded pads: the stored file, the measure, what is counted, the closed forms that it holds to."""

from dataclasses import replace

import numpy as np
import pytest
from common.ngsolve_mesh import graded, outer_edges, product_plan, ring_mesh, section_mesh, side
from common.ngsolve_pad import complete_polynomials
from common.ngsolve_solve import LADDERS, family_limit, limit, measured_order
from common.reference_cases import CASES, Case
from common.references import Judged, Reference, counts, dearer, stored_references
from scipy.special import ive

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench

STORED = {one.name: one for one in stored_references()}


def reference(error=1e-4):
    """A pad of 20 x 20 x 2 mm under 8 x 8 mm whose target goes 1 mm aside and 0.1 mm down."""
    return Reference("one", "block", (), Wrench(F_x=1.0), np.array([1e-3, -1e-4, 0.0, 0.0, 0.0, 0.0]), error, "")


def judged(true, estimated, tolerance=1e-2, error=1e-4):
    return Judged(reference(error), tolerance, true, estimated, 1.0, 100, "converged")


def test_stored_rows_are_those_of_the_cases():
    """Scene and load of each row are what the case says now: a case that changes asks for its reference again."""
    cases = {case.name: case for case in CASES}
    assert len(cases) == len(CASES) and set(STORED) <= set(cases)
    for name, one in STORED.items():
        case = cases[name]
        assert list(one.changes) == case.changes
        load = [one.wrench.F_x + one.wrench.F_y, one.wrench.F_z, one.wrench.M - one.wrench.M_x, one.wrench.M_z]
        assert load == pytest.approx([*case.load[:2], 1e-3 * case.load[2], 1e-3 * case.twist], rel=1e-7)
        assert 0.0 <= one.error < 0.02 and one.source


def test_the_error_is_the_largest_component_over_the_displacement():
    """An angle counts at the target's end, 4 mm away; what should be zero and is not counts, too."""
    report = SolveReport("block", 1, 1, 0.0, 0.0, 0.0)
    away = Pose(1e-3 + 2e-6, 2e-3 - 1e-4, alpha=1e-3)
    found = Equilibrium(Wrench(), away, Pose(0.0, 0.0), np.zeros(1), report)
    assert reference().true_error(found) == pytest.approx(4e-3)
    found = Equilibrium(Wrench(), Pose(1e-3, 1.9e-3, d_y=3e-6), Pose(0.0, 0.0), np.zeros(1), report)
    assert reference().true_error(found) == pytest.approx(3e-3)


def test_what_a_reference_may_judge():
    """Five times its own error, no less; a failed solve misses its tolerance and has no ratio."""
    assert judged(1e-3, 1e-3).sees_ratio and not judged(4e-4, 4e-4).sees_ratio
    assert judged(1e-3, 1e-3).sees_tolerance and not judged(1e-3, 1e-3, 4e-4).sees_tolerance
    assert judged(4e-3, 1e-3).too_small and not judged(3.05e-3, 1e-3).too_small
    failed = judged(np.nan, np.nan)
    assert not failed.sees_ratio and not failed.too_small and failed.sees_tolerance
    said = counts([judged(1e-3, 1e-3), judged(2e-2, 1e-2), judged(1e-3, 1e-2), failed])
    assert said[0].startswith("asked 0.01: met by 2 of 4") and said[1].split(": ")[1].startswith("1 of 3")
    assert said[2].split(": ")[1].startswith("1, ") and said[2].endswith("0 of 4")


def test_finer_answers_that_cost_more_are_counted():
    """Seconds in the median and at most; over four times as many, and more without a smaller estimate."""
    coarse = [replace(judged(1e-3, 5e-3), reference=replace(reference(), name=name)) for name in "abc"]
    finer = [replace(one, tolerance=3e-3, seconds=s, estimated=e)
             for one, s, e in zip(coarse, (1.2, 3.0, 5.0), (5e-3, 5e-3, 2e-3), strict=True)]
    said = dearer([*coarse, *finer])
    assert said[:2] == ["asked 0.01: 1 s in the median, 1 s at most", "asked 0.003: 3 s in the median, 5 s at most"]
    assert said[2] == "0.003 takes over four times the time of 1, more without gain of 1 of 3"


def test_a_disc_on_a_box_is_round():
    """A half and a quarter of the pad in rings, deformed to the disc: volumes and what is bonded, by NGSolve."""
    ng = pytest.importorskip("ngsolve")
    for whole, share in ((True, 0.5), (False, 0.25)):
        mesh = ring_mesh(8.0, PlateOutline(6.0, 5.0, False), 2.0, 2, whole=whole)
        assert ng.Integrate(ng.CF(1.0), mesh, order=8) == pytest.approx(share * 12.0 * 10.0 * 2.0, rel=1e-5)
        bonded = ng.Integrate(ng.CF(1.0), mesh.Boundaries("target"), order=8)
        assert bonded == pytest.approx(share * 16.0 * np.pi, rel=1e-5)


def test_the_limit_of_three_meshes():
    """Differences that shrink by a half: the sum of the series is added, and is the error."""
    case, ladder = Case("", "plane", (2.0, 1.0), (2.0, 1.0), 1.0, (0.0, 1.0, 0.0)), LADDERS["plane", False]
    row = [np.array([0.0, 1.0 + 0.01 * 0.5**k, 0.0]) for k in range(3)]
    found = limit(case, row, np.array([0.0, 1e-4, 0.0]), ladder)
    assert found.pose == pytest.approx([0.0, 1.0, 0.0]) and found.error == pytest.approx(2.5e-3)
    coarser = limit(case, row, np.array([0.0, 0.04, 0.0]), ladder, further=2)  # shrinks like the meshes' differences
    assert coarser.error == pytest.approx(0.01)
    grows = limit(case, [row[2], row[1], row[0]], np.zeros(3), ladder)  # no limit: the last difference is the error
    assert grows.pose[1] == row[0][1] and grows.error == pytest.approx(5e-3 / 1.01)


def test_the_limit_of_a_family_by_the_order_it_shows():
    """Errors as ``m**-2.3`` and ``m**-2``: one limit; the error is what order 2 and the others say."""
    case = Case("", "box", (2.0, 1.0), (2.0, 1.0), 1.0, (0.0, 1.0, 0.0))

    def row(sizes, p, end=1.0):
        return list(sizes), [np.array([0.0, end - 0.1 * m**-p, 0.0]) for m in sizes]

    sizes = (2, 3, 4)
    assert measured_order(sizes, row(sizes, 2.3)[1]) == pytest.approx(2.3)
    found = family_limit(case, row(sizes, 2.3), row(sizes, 2.0, 1.0002))
    assert found.pose == pytest.approx([0.0, 1.0, 0.0])
    by_two = row(sizes, 2.3)[1][2] + np.diff([q[1] for q in row(sizes, 2.3)[1]])[1] / ((4 / 3) ** 2 - 1)
    assert found.error == pytest.approx(max(2e-4, by_two[1] - 1.0))
    with pytest.raises(ArithmeticError, match="show no order"):
        measured_order(sizes, [np.array([x]) for x in (0.0, 1.0, 3.0)])
    with pytest.raises(ArithmeticError, match="2 meshes of 4"):
        family_limit(case, row(sizes[:2], 2.0), row(sizes, 2.0))
    two = replace(case, meshes={2: (2, 3), 3: (1, 2)})  # of two meshes 2.38 stands for the order, 2 beside it
    found = family_limit(two, row((2, 3), 2.38), row((1, 2), 2.38))
    assert found.pose == pytest.approx([0.0, 1.0, 0.0]) and 0.0 < found.error < 5e-3


def test_pressures_are_complete_polynomials():
    """Of order 1 a constant and a slope along each axis: three on a quadrilateral, exact for planes, not for x z."""
    ngsolve = pytest.importorskip("ngsolve")
    mesh = section_mesh(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0]), 1.0)
    space = complete_polynomials(mesh, 1)
    assert space.ndof == 2 * 3
    for function, exact in ((1.0 + ngsolve.x - 2.0 * ngsolve.y, True), (ngsolve.x * ngsolve.y, False)):
        found = ngsolve.GridFunction(space)
        found.Set(function)
        assert (ngsolve.Integrate((found - function) ** 2, mesh) < 1e-20) == exact


def test_lines_shrink_towards_an_edge():
    """Layers by a constant ratio at one end, no cell longer than the size, ends and target's edge on lines."""
    lines = graded(0.0, 6.0, (0, 3), 1.0, 0.2)
    steps = np.diff(lines)[::-1]
    assert lines[[0, -1]].tolist() == [0.0, 6.0] and steps.max() <= 1.0 + 1e-12
    assert steps[:3] == pytest.approx([0.7 * 0.2**3, 0.7 * 0.2**2 - 0.7 * 0.2**3, 0.7 * 0.2 - 0.7 * 0.2**2])
    both = side(15.0, 20.0, 2, 2.0, 0.2, whole=True)
    assert both == pytest.approx(-both[::-1]) and np.isin(7.5, np.round(both, 9)) and both[-1] == 10.0

def test_a_plan_is_cells_in_one_sense():
    """Areas above zero that fill the box, an edge for each cell of its border, the target's cells under the target."""
    x, y = side(15.0, 20.0, 2, 2.0, 0.2, whole=True), side(8.0, 20.0, 2, 2.0, 0.2, whole=False)
    plan = product_plan(x, y, (7.5, 4.0))
    a, b, c = (plan.points[plan.quads[:, k]] for k in range(3))
    (p, q), (r, s) = (b - a).T, (c - b).T
    area = p * s - q * r
    assert area.min() > 0.0 and area.sum() == pytest.approx(20.0 * 10.0)
    assert area[plan.under].sum() == pytest.approx(15.0 * 4.0)
    assert len(outer_edges(plan.quads)) == 2 * (len(x) - 1 + len(y) - 1)


@pytest.mark.parametrize("thickness", [0.1, 0.02])
def test_films_hold_to_their_thin_limit(thickness):
    """A disc on a thin layer: ``p'' + p'/r - 12 mu p/(K t^2) = const`` with p = 0 at the rim, in Bessel functions.

    Neglected: mu beside K, 0.13 %, and the rim, some thicknesses of the radius's 100 or 500.
    """
    one = STORED[f"flush disc 20 x {thickness} film".replace(" film", ", film")]
    mu, K, a, t = 3e4, 3e7, 10e-3, 1e-3 * thickness
    y = a / t * np.sqrt(12.0 * mu / K)
    modulus = K * (1.0 - 2.0 * ive(1, y) / (y * ive(0, y)))
    sink = one.wrench.F_z * t / (modulus * np.pi * a**2)
    assert -one.moved[1] == pytest.approx(sink, rel=1.3e-3 + 3.0 * t / a)


def test_round_pads_hold_to_another_code():
    """15 mm wide, 2 mm thick, flush, K = 1000 mu: kx 2.56733 N/mm, ka 386.547 N mm/rad to 1e-4 (NGSolve, P3/P2).

    kxa = -kx: the force at the face is carried by shear and a turn about a point 1 mm lower.
    """
    k = 1e3 * np.array([[2.56733, -2.56733e-3], [-2.56733e-3, 386.547e-6]])  # N, m, rad
    for name in ("flush disc 15 x 2, small shear", "flush disc 15 x 2, small moment"):
        one = STORED[name]
        expected = np.linalg.solve(k, [one.wrench.F_x, one.wrench.M])
        assert one.moved[[0, 2]] == pytest.approx(expected, rel=2e-4)
