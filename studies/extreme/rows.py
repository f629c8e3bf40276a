"""What is a row of the table of extremes, and when does it hold?"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.geometry.collision import Collision
from sits_mech.quantities import SolveFailed
from sits_mech.report.notes import sentences
from sits_mech.scene.sensor import SceneError

DONE = "converged"
REFUSALS = ("load path ended", "too many bars", "too many rings", "not resolved", "collision", "bad input",
            "strains too large", "tolerance not reached", "not smooth")
"""The names that a refusal may have."""


@dataclass(frozen=True)
class Row:
    """One case: how it ended, and its worst violation of what must hold beside what is allowed."""

    physics: str
    case: str
    status: str = DONE
    min_J: float = np.nan
    violation: float = np.nan
    allowed: float = np.nan
    estimated: float = np.nan
    seconds: float = 0.0
    remark: str = ""
    must: bool = False  # a case that no refusal will do for
    compared: bool = True  # whether a violation in sums of stated errors, of which one is allowed, had a reference

    @property
    def against(self) -> bool:
        """Whether the violation is in errors that were stated, against a richer or another model."""
        return self.compared and self.allowed == 1.0

    @property
    def part(self) -> str:
        """The study's part that it belongs to."""
        return "scenes" if self.physics == "any scene" else self.physics or "chain"

    @property
    def holds(self) -> bool:
        """Whether the case is consistent, or refused by a name and consistent as far as it went."""
        if self.min_J <= 0.0 or self.violation > self.allowed:
            return False
        if self.status == DONE:
            return bool(np.isfinite(self.violation))
        return self.status in REFUSALS and not self.must


def measured(physics: str, case: str, ask: Callable[[], Row], must: bool = False) -> Row:
    """Return the row of a case with its time; a refusal becomes its name, any other end its type."""
    began = time.process_time()
    try:
        row = ask()
    except SolveFailed as failed:
        report = failed.report
        min_J = np.nan if report.min_J is None else report.min_J
        remark = "; ".join((*sentences(report.notes), str(failed)))
        row = Row("", "", report.status, min_J, estimated=report.estimated_error, remark=remark)
    except Collision as error:
        row = Row("", "", "collision", remark=str(error))
    except ValueError as error:
        status = "bad input" if isinstance(error, SceneError) or ": must " in str(error) else "ValueError"
        row = Row("", "", status, remark=str(error))
    except Exception as error:  # a row that does not hold
        row = Row("", "", type(error).__name__, remark=str(error))
    return replace(row, physics=physics, case=case, must=must, seconds=time.process_time() - began)
