"""One design through the whole chain: sizes, overload, table, kept on disk; what is not asked is not solved."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.scene.sensor import SceneError
from sits_mech.synthesis.required.kinds import STRAIN
from sits_mech.synthesis.required.requirements import requirements_of
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.run import design
from sits_mech.synthesis.solved.loads import Operator
from sits_mech.synthesis.solved.solve import COARSE, FINE, Solver

ASKED: dict[str, Any] = {
    "scene": "biorob2018", "loads": {"F_z": ["0 N", "0.4 N"]},
    "vary": {"elastomer.thickness": {"from": "1.5 mm", "to": "3 mm"}},
    "require": {"resolution": {"F_z": "1 mN"}}, "tolerance": {"modulus": "10 %"},
    "goal": {"minimise": "resolution.F_z"},
}
SOLVER = Solver(requirements_of(ASKED), 5e-2)


@pytest.mark.slow
def test_a_table_is_that_of_a_calibration_and_its_slopes_are_differences(tmp_path: Path) -> None:
    """L at the loads within the chain's tolerance; the slope by another thickness; what is kept is read again."""
    solver = Solver(SOLVER.requirements, 5e-2, tmp_path)
    found, more = solver(Design((), (0.3,))), SOLVER(Design((), (0.34,)))
    sensor = solver.requirements.space.sensor(found.design)
    data = calibrate(sensor, F_z=solver.operator.loads.axes[0].tolist(), tolerance=5e-2)
    L = np.diagonal(data["L"].to_numpy()[0], axis1=-2, axis2=-1)
    assert found.carried and found.table is not None and more.table is not None
    np.testing.assert_allclose(found.table.L - found.table.L[0], L - L[0], atol=0.03 * np.ptp(L))
    middle = found.by_x[0] + 0.0
    np.testing.assert_allclose((more.table.L - found.table.L) / 0.04, middle, rtol=0.06)
    again = solver(found.design)
    np.testing.assert_array_equal(again.table.L, found.table.L)
    assert again.plain == found.plain and 0.0 < found.plain[STRAIN] < 1.0


@pytest.mark.slow
def test_what_is_not_asked_is_not_solved() -> None:
    """Height alone: no table; the overload is carried in any case."""
    table = ASKED | {"require": {"height": "4 mm"}, "tolerance": {}, "goal": {}}
    found = Solver(requirements_of(table), 5e-2)(Design((), (0.5,)))
    assert 0.0 < found.error[STRAIN] < 0.5 * found.plain[STRAIN]
    assert found.carried and found.table is None and found.plain["height"] == pytest.approx(2.25e-3 + 0.2e-3 + 0.12e-3)


@pytest.mark.slow
def test_a_design_that_cannot_carry_its_load_says_so() -> None:
    """With its reason, and a strain beyond what is allowed."""
    table = ASKED | {"loads": {"F_z": ["-9 N", "0.4 N"]}}
    found = Solver(requirements_of(table), 5e-2)(Design((), (1.0,)))
    assert not found.carried and found.reason.startswith("overload: ") and found.plain[STRAIN] > 1.0


def silicone(**more: Any) -> dict[str, Any]:
    """Return a silicone of the scene's own."""
    return {"law": "neo-hookean", "shear_modulus": "30 kPa", "bulk_modulus": "30 MPa", **more}


def loop_of_one_branch(weight: float, tau: float) -> float:
    """Return the width of the loop of a standard linear solid whose load rises and falls in 1 s, the second time.

    With F the load over its peak, ``u = F + v,  theta dv/dt = c F - v``, c = w / (1 - w), theta = tau / (1 - w); over
    1 + c, where it comes to rest under the peak.
    """
    t, v, c, theta = np.linspace(0.0, 2.0, 40_001), 0.0, weight / (1.0 - weight), tau / (1.0 - weight)
    F, u = 1.0 - np.abs(2.0 * (t % 1.0) - 1.0), [0.0]
    decay = np.exp(-(t[1] - t[0]) / theta)
    for before, after in zip(F[:-1], F[1:], strict=True):
        v = c * 0.5 * (before + after) * (1.0 - decay) + v * decay
        u.append(after + v)
    came = np.array(u)
    up, down = came[20_000:30_001], came[:29_999:-1]
    return float(np.max(np.abs(down - up)) / (1.0 + c))


@pytest.mark.slow
def test_hysteresis_is_required_of_silicones_whose_constants_are_given() -> None:
    """Of two in a list the one that holds is taken, the other says what it has; by a standard linear solid, 1 %."""
    lazy, quick = silicone(prony=[{"weight": 0.3, "time": "0.2 s"}]), silicone(prony=[{"weight": 0.1, "time": "0.2 s"}])
    table = ASKED | {"vary": {"elastomer.material": [lazy, quick]}, "tolerance": {}, "goal": {}}
    found = design(requirements_of(table | {"require": {"hysteresis": "6 %"}}))
    assert found.feasible and found.best.design.choice == (1,) and found.best.table is None
    assert found.best.plain["hysteresis"] == pytest.approx(loop_of_one_branch(0.1, 0.2), rel=0.01)
    other = next(each for each in found.known if each.design.choice == (0,))
    assert other.plain["hysteresis"] == pytest.approx(loop_of_one_branch(0.3, 0.2), rel=0.01)
    assert next(each.why for each in found.lost).startswith("hysteresis ")
    vary = {"elastomer.material": [quick, silicone()]}
    with pytest.raises(SceneError, match="require: hysteresis needs prony or mullins of every silicone"):
        requirements_of(table | {"vary": vary, "require": {"hysteresis": "6 %"}})


def test_designs_of_a_choice_have_one_model() -> None:
    """Under 0.2 N small strain would do for 1.5 mm and not for 3 mm: all are of finite strain."""
    few, many = ({"loads": {"F_z": ["0 N", load]}, "tolerance": {}} for load in ("1 mN", "0.2 N"))
    for loads, name in ((few, "auto"), (many, "block")):
        solver = Solver(requirements_of(ASKED | loads), 5e-2)
        thin = solver.requirements.space.sensor(Design((), (0.0,)))
        assert solver._mechanics((), thin) == name


def test_a_search_solves_three_loads_of_each_component_for_the_same_table() -> None:
    """A parabola between them is itself on the table's grid; an answer solves the grid."""
    asked = requirements_of({
        "scene": "biorob2018", "loads": {"F_x": ["-1 N", "1 N"], "F_z": ["0 N", "2 N"]},
        "vary": {"elastomer.thickness": ["2 mm", "3 mm"]}, "require": {"resolution": {"F_z": "1 mN"}},
        "goal": {"minimise": "feasible"},
    })
    coarse, fine = Solver(asked, COARSE), Solver(asked, FINE)
    assert [len(axis) for axis in coarse.solved.axes] == [3, 3] and [len(axis) for axis in fine.solved.axes] == [5, 4]
    some, every = coarse.solved.points, fine.solved.points

    def parabola(F: np.ndarray) -> np.ndarray:
        return 1.0 + F[:, 0] * (2.0 - F[:, 1]) + 0.3 * F[:, 1] ** 2

    np.testing.assert_allclose(Operator(coarse.solved).values(every) @ parabola(some), parabola(every), rtol=1e-12)
