"""A load solved to finer tolerances: what each rung says, and what it costs."""

import math
from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis import ladder as module
from sits_mech.analysis.ladder import LadderStep, forget, ladder
from sits_mech.chain.simulate import Simulation, simulate
from sits_mech.disk_cache import VARIABLE, folder
from sits_mech.magnetics.bars import planar_bars
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element import assembly
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import Equilibrium, Impedance, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.units import SceneError

SECTION = {"mechanics": "planar", "magnetics": "planar"}
_REPORT = SolveReport("any", 1, 1, 0.0, 0.0, 0.0)
SHOWN = Simulation(
    Equilibrium(Wrench(F_z=0.1), Pose(0.0, 1.9e-3), Pose(0.0, 1e-6), np.zeros(0), _REPORT),
    Impedance(
        5e6, 0.9 * np.eye(2), np.eye(2), np.eye(2), np.ones(2), 1e-3 * np.eye(2), 1e-3 * np.eye(2), "H", _REPORT
    ), None,  # type: ignore[arg-type]
)
"""An answer whose signals nobody asks for."""


@pytest.mark.slow
def test_rungs_are_the_answers_of_simulate() -> None:
    """Each is what `simulate` says, beside the finest; an estimate never rises, and holds the differences."""
    sensor, wrench, seen = load_sensor("biorob2018"), Wrench(0.2, 1.0), []
    found = ladder(sensor, wrench, tolerance=3e-2, **SECTION, progress=lambda done, of: seen.append((done, of)))
    assert [one.tolerance for one in found] == [1e-1, 3e-2, 1e-2, 3e-3] and seen[-1] == (4, 4)
    first, last = (simulate(sensor, wrench, tolerance=one.tolerance, **SECTION) for one in (found[0], found[-1]))
    change = np.max(np.abs(last.impedance.L - last.impedance.L0))
    assert found[0].estimated == pytest.approx(np.max(first.impedance.error_L) / change, rel=1e-9)
    assert found[0].difference == pytest.approx(np.max(np.abs(first.impedance.L - last.impedance.L)) / change, rel=1e-6)
    moved = last.equilibrium.pose.components - Pose(0.0, 2e-3).components
    assert found[-1].estimated_pose == pytest.approx(
        np.max(last.equilibrium.error.components * [1, 1, 4e-3, 1, 4e-3, 4e-3])
        / np.max(np.abs(moved) * [1, 1, 4e-3, 1, 4e-3, 4e-3])
    )  # the target is 8 x 8 mm
    assert found[-1].difference == found[-1].difference_pose == 0.0 < found[0].difference
    estimates = [one.estimated for one in found]
    assert estimates == sorted(estimates, reverse=True) and all(one.seconds > 0.0 for one in found)
    assert all(one.difference <= 2.0 * (one.estimated + found[-1].estimated) for one in found)


@pytest.mark.slow
def test_a_rung_without_answer_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others stand beside the finest of those that have one."""

    def sometimes(*args: object, tolerance: float, **options: object) -> object:
        if tolerance == 1e-2:
            raise SolveFailed("not carried", SolveReport("planar", 1, 1, 0.0, 1.0, 0.0))
        return simulate(*args, tolerance=tolerance, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "simulate", sometimes)
    found = ladder(load_sensor("biorob2018"), Wrench(0.0, 1.0), tolerance=1e-1, **SECTION)
    assert found[-1].status == "SolveFailed: not carried" and math.isnan(found[-1].estimated)
    assert found[-1].asked.estimated == math.inf and found[-2].difference == 0.0


def test_no_load_has_no_ladder() -> None:
    """Every rung would be the target at rest."""
    with pytest.raises(SceneError, match="ladder: must have a load, .*; none came"):
        ladder(load_sensor("biorob2018"), Wrench())


def test_forgotten_caches_are_empty() -> None:
    """What a model kept is gone: a plate that was prepared is prepared again."""
    from sits_mech.magnetics import bars

    planar_bars(load_sensor("biorob2018"), 1e-2).impedance(Pose(0.0, 2e-3), 5e6)
    kept = [item for item in vars(bars).values() if hasattr(item, "cache_info")]
    assert any(item.cache_info().currsize for item in kept)
    forget()
    assert not any(item.cache_info().currsize for item in kept)


def test_forgotten_pads_are_solved_from_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families of the last pad hold what its first meshes reached: a rung solved again took a tenth of its time."""
    factored, factor = [], assembly.factor
    monkeypatch.setattr(assembly, "factor", lambda *given: factored.append(1) or factor(*given))
    long = ["elastomer.length=0.2", "target.length=0.2"]
    for made, sensor in ((planar_layer, load_sensor("biorob2018", long)), (block_pad, load_sensor("biorob2018"))):
        counts = []
        for clear in (forget, forget, lambda: None):
            clear()
            factored.clear()
            made(sensor, 0.1).equilibrium(Wrench(0.05, 0.2))
            counts.append(len(factored))
        assert counts[0] == counts[1] > counts[2]


def test_what_the_disk_keeps_is_no_start(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Plates kept by an earlier command, or by a rung before, took half of the time away."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    seen = []

    def solved(*_: object, **more: object) -> None:
        seen.append((folder(), more["tolerance"]))
        raise MemoryError

    monkeypatch.setattr(module, "simulate", solved)
    ladder(load_sensor("biorob2018"), Wrench(0.2, 1.0), tolerance=3e-2)
    assert seen == [(None, 1e-1), (None, 3e-2), (None, 1e-2), (None, 3e-3)] and folder() == tmp_path


def test_every_rung_is_told_when_it_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """With how many follow, and before there is a finest one to differ from; no answer is none to differ from."""
    told = list[tuple[float, str, bool, int]]()

    def told_of(one: LadderStep, left: int) -> None:
        told.append((one.tolerance, one.status.partition(":")[0], math.isnan(one.estimated), left))

    def sometimes(*args: object, tolerance: float, **options: object) -> object:
        if tolerance == 3e-3:
            raise SolveFailed("not carried", SolveReport("planar", 1, 1, 0.0, 1.0, 0.0))
        return SHOWN

    monkeypatch.setattr(module, "simulate", sometimes)
    found = ladder(load_sensor("biorob2018"), Wrench(0.0, 0.1), tolerance=3e-2, each=told_of)
    assert told == [(1e-1, "converged", False, 3), (3e-2, "converged", False, 2), (1e-2, "converged", False, 1),
                    (3e-3, "SolveFailed", True, 0)]
    assert [one.difference for one in found[:3]] == [0.0] * 3 and math.isnan(found[-1].difference)
