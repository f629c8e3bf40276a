"""Say what an answer is worth: its whole error over the signals' full scale, and its flags."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.chain.plans.goal import Goal
from sits_mech.chain.propagation import poses_of
from sits_mech.description import sized
from sits_mech.notes import Omission
from sits_mech.quantities import Array, Bounded, Equilibrium, Mask
from sits_mech.scene.sensor import Sensor, known_stretch
from sits_mech.status import flags_of, marked


def answer_error(goal: Goal | None, rest: Equilibrium, left_out: Sequence[Omission]) -> float:
    """Return the error of an answer over the signals' full scale, with all that is left out; 0 without a goal.

    `left_out` is what the magnetic model leaves out; the errors of the pose hold what the mechanics do.
    """
    return 0.0 if goal is None else goal.of(poses_of([rest])) + sized(left_out)


def flags_over(
    sensor: Sensor, goal: Goal | None, poses: Bounded, stretch: Array, tolerance: float,
    left_out: Sequence[Omission] = (), *, interpolated: Mask | bool = False,
) -> tuple[dict[str, list[str]], float]:
    """Return status and flags over time, as `marked`, from poses (p, 6), stretches (p,) and which are `interpolated`.

    With the largest error over the signals' full scale. `left_out` is what both halves leave out; errors of poses hold
    what the mechanics do.
    """
    known, count, bounded = known_stretch(sensor), len(stretch), not any(item.unbounded for item in left_out)
    more = sized(item for item in left_out if item.half == "magnetics")
    errors = [0.0 if goal is None else goal.of(poses[k]) + more for k in range(count)]
    each = [
        marked(flags_of(own, tolerance, most, known, interpolated=between, bounded=bounded))
        for own, most, between in zip(errors, stretch.tolist(), np.broadcast_to(interpolated, count), strict=True)
    ]
    return {name: [row[name] for row in each] for name in ("status", "flags")}, max(errors, default=0.0)


def rest_flags(
    sensor: Sensor, found: Equilibrium, tolerance: float, error: float | None = None,
    left_out: Sequence[Omission] = (),
) -> tuple[str, ...]:
    """Return the flags of an equilibrium by an error, by default that of its pose, and by the silicone's data.

    They are as of `flags_of`; `left_out` is what the magnetic model leaves out.
    """
    report = found.report
    error = report.estimated_error if error is None else error
    return flags_of(
        error, tolerance, report.stretch, known_stretch(sensor), changed=report.error_stretch,
        bounded=not any(item.unbounded for item in (*report.left_out, *left_out)),
    )
