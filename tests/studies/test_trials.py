"""Designs that a recommendation is held against, and sensors that are made, on a sensor in closed form."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from common import trials
from common.trials import best_of, grid_designs, made, random_designs, shares_made
from scipy.stats import norm

from sits_mech.scene.sensor import Sensor
from sits_mech.synthesis.required.requirements import requirements_of
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.solved.answered import Answered, Task
from sits_mech.synthesis.solved.figures import Table
from sits_mech.synthesis.solved.solve import Solver

ASKED = requirements_of({
    "scene": "biorob2018-w15", "loads": {"F_z": ["0 N", "1 N"]},
    "vary": {
        "elastomer.thickness": {"from": "1 mm", "to": "3 mm"}, "target.width": {"from": "8 mm", "to": "20 mm"},
        "elastomer.material": ["ecoflex-00-30", "dragon-skin-10"],
    },
    "require": {"resolution": {"F_z": "1 mN"}}, "tolerance": {"modulus": "20 %", "coil_offset": "0.1 mm"},
    "goal": {"minimise": "height"},
})


def test_a_grid_has_its_ends_and_no_more_designs_than_asked() -> None:
    """Six by six places for each of two silicones are 72 of 80."""
    found = grid_designs(ASKED.space, 80)
    assert len(set(found)) == len(found) == 72
    assert sorted({x for each in found for x in each.x}) == pytest.approx(np.linspace(0.0, 1.0, 6).tolist())
    assert {each.choice for each in found} == set(ASKED.space.choices)


def test_random_designs_fill_the_box_and_the_lists() -> None:
    """Half of Sobol's points have each silicone; the same seed, the same points."""
    found = random_designs(ASKED.space, 32, 3)
    assert sum(each.choice == (1,) for each in found) == 16 and found == random_designs(ASKED.space, 32, 3)
    assert np.ptp([each.x for each in found], axis=0) == pytest.approx(1.0, abs=0.1)


def test_the_best_of_designs_is_that_of_least_merit() -> None:
    """Height alone is minimised: the thinnest; what was not answered is counted, and never the best."""

    def answered(wanted: Design) -> Answered:
        """A design whose height is its first coordinate; the thinnest fails."""
        reason = "overload: no" if wanted.x[0] == 0.0 else ""
        return Answered(wanted, reason, None, np.zeros((2, 0, 0)), {"height": 1.0 + wanted.x[0]}, {})

    solver = Solver(ASKED, 5e-2)
    task = Task(solver.task.judge, {}, {"height": 1.0})
    designs = [Design((0,), (x, 0.5)) for x in (0.5, 0.25, 0.0)]

    class Fake:
        """A solver in closed form."""

        requirements = ASKED

        def __call__(self, wanted: Design) -> Answered:
            return answered(wanted)

    found = best_of(Fake(), task, designs)  # type: ignore[arg-type]
    assert (found.count, found.merit) == (3, 1.25) and "1.5 mm" in found.words


def test_sensors_are_made_as_they_are_drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Coils and silicone are off by what is said; of a linear sensor both shares are the normal distribution's, by the
    noise of two coils 1e-10 H over a slope of 1e-7 H/N that is smaller by the modulus; what is solved is kept.
    """
    solver, calls = Solver(ASKED, 5e-2, tmp_path), []
    sensor = ASKED.space.sensor(Design((0,), (0.5, 0.5)))
    other = made(sensor, ("modulus", "coils.*.centre.0"), np.array([0.1, 1e-4]))
    assert other.elastomer is not None and sensor.elastomer is not None
    mu = sensor.elastomer.silicone.shear_modulus
    assert other.elastomer.silicone.shear_modulus / mu == pytest.approx(1.1)
    assert other.coils[1].centre[0] == pytest.approx(4.1e-3)

    def calibrated(made_one: Sensor, **given: Any) -> xr.Dataset:
        """Inductances that fall with the load, the less the stiffer, and go with where the coils are."""
        calls.append(made_one)
        F_z = np.array(given["F_z"])
        assert made_one.elastomer is not None
        stiffer = made_one.elastomer.silicone.shear_modulus / mu - 1.0
        own = 1.0 - 0.1 * F_z * (1.0 - stiffer) + made_one.coils[0].centre[0]
        status = np.full(len(F_z), "ok", dtype=object)
        return xr.Dataset({"L": (("F_z", "coil"), 1e-6 * np.column_stack([own, own])), "status": ("F_z", status)})

    monkeypatch.setattr(trials, "calibrate", calibrated)
    monkeypatch.setattr(trials, "table_inductances", lambda _, data: data)
    L = np.column_stack([1e-6 - 1e-7 * solver.operator.loads.axes[0]] * 2)
    by = np.array([1e-7 * solver.operator.loads.axes[0][:, None] + np.zeros((1, 2)), 1e-6 + np.zeros_like(L)])
    best = Answered(Design((0,), (0.5, 0.5)), "", Table(L, by, np.full(2, 1e-10)), np.zeros((2, *L.shape)), {}, {})
    solved, told = shares_made(solver, solver.task, best, 64, 0)
    assert solved == told == pytest.approx(norm.cdf((1.0 - 0.5**0.5) / 0.2), abs=0.06) and len(calls) == 65
    assert shares_made(solver, solver.task, best, 64, 0) == (solved, told) and len(calls) == 65
