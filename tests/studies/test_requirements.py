"""Requirements of kinds that the search was not made by: a fingertip, a sole, a skin patch. Do its answers hold?"""

from pathlib import Path

import pytest
from common.stories import REQUIREMENTS

from sits_mech.cli.main import run
from sits_mech.report.folder import cases_folder
from sits_mech.synthesis.required.kinds import STRAIN
from sits_mech.synthesis.required.requirements import read_requirements
from sits_mech.synthesis.run import design
from sits_mech.synthesis.solved.solve import FINE, Solver


@pytest.mark.slow
@pytest.mark.parametrize("name", ("fingertip", "foot_sole", "skin_patch"))
def test_a_recommendation_holds_when_it_is_solved_again(name: str, tmp_path: Path) -> None:
    """The command ends well, and a tenth of the tolerance moves no figure by more than both errors, none over a limit
    by more than its own.
    """
    path = REQUIREMENTS / f"{name}.toml"
    assert run(["design", str(path), "-o", str(tmp_path)]) == 0
    asked = read_requirements(path)
    found = design(asked, folder=cases_folder(tmp_path))
    again = Solver(asked, 0.1 * FINE)(found.best.design)
    assert found.feasible and again.carried
    task, before = found.task, found.best
    first, finer = task.figures(before), task.figures(again)
    for key in {*asked.limits, *asked.minimised, STRAIN}:
        left = before.error.get(key, 0.0) + again.error.get(key, 0.0)
        assert abs(finer[key] - first[key]) <= left + 1e-9 * abs(first[key]), key
    excess, off = task.excess(finer, again.table), task.errors(again)
    assert all(value <= off.get(key, 0.0) for key, value in excess.items()), excess
