"""Records: what a program reads is JSON, whatever a solve left behind."""

import json
import math

import numpy as np

from sits_mech.quantities import POSE, WRENCH, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.report.records import failure_record, json_text


def test_records_are_json() -> None:
    """What is not a number is null; a failure shows the last state, or none."""
    report = SolveReport("planar", 10, 3, 1.0, math.inf, 0.1, status="stalled", min_J=math.nan)
    found = json.loads(json_text(failure_record(SolveFailed("no", report))))
    assert found["pose"] is None and found["report"]["estimated_error"] is None
    assert found["message"] == "no" and found["error"] is None
    last = Equilibrium(Wrench(0.0, 1.0), Pose(0.0, 1e-3), Pose(0.0, 0.0), np.zeros(3), report)
    found = json.loads(json_text(failure_record(SolveFailed("no", report, last))))
    assert found["wrench"] == dict.fromkeys(WRENCH, 0.0) | {"F_z": 1.0} and found["pose"]["d_v"] == 1e-3
    assert found["error"] == dict.fromkeys(POSE, 0.0) and found["report"]["status"] == "stalled"
    for half, other in (("mechanics", "magnetics"), ("magnetics", "mechanics")):
        halves = failure_record(SolveFailed("no", report, half=half), whole=True)["report"]
        assert halves[other] is None and halves[half]["status"] == "stalled"
