"""Say what a ladder of tolerances shows: a rung as it is solved, and all in one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain

from sits_mech.analysis.ladder import LadderPoint, LadderStep


def rung_line(rung: LadderStep, left: int) -> str:
    """Return a rung in a line, with how many follow."""
    came = f"error {rung.estimated:.2g}" if rung.status == "converged" else rung.status.partition(";")[0]
    return f"{power(rung.tolerance)}: {came}, {rung.seconds:.2g} s" + (f"; {left} to come" if left else "")


def ladder_sentence(ladders: Sequence[Sequence[LadderPoint]]) -> str:
    """Summarize ladders: "ask 1e-2: 0.3 s; 3e-3: 1.1 s; errors below 1e-3 cannot be reached".

    A tolerance counts where the answer's own estimate is within it; where only some of several ladders reach it, how
    many do is said. What cannot be reached is what is below the least estimate of a ladder whose finest rung misses.
    """
    parts, count, held = [], len(ladders), dict[float, list[float]]()
    for one in chain.from_iterable(ladders):
        if one.holds:
            held.setdefault(one.tolerance, []).append(one.seconds)
    for tolerance, times in sorted(held.items(), reverse=True):
        span = _span([f"{min(times):.2g}", f"{max(times):.2g}"])
        parts.append(f"{power(tolerance)}: {span} s{_share(len(times), count)}")
    reached = [min(one.estimated for one in row) for row in ladders if not _finest(row).holds]
    limits = sorted(filter(math.isfinite, reached))
    if limits:
        span = _span([power(limits[0]), power(limits[-1])])
        parts.append(f"errors below {span} cannot be reached{_share(len(reached), count)}")
    elif not reached:
        parts.append(f"errors below {power(_finest(ladders[0]).tolerance)} were not requested")
    return ("ask " if held else "") + "; ".join(parts) if parts else "no tolerance of the ladder can be reached"


def _share(some: int, count: int) -> str:
    """Say how many of several ladders it is, empty for all."""
    return f" ({some} of {count})" if some < count else ""


def power(value: float) -> str:
    """Format a tolerance as it is asked: 3e-3."""
    return f"{value:.0e}".replace("e-0", "e-")


def _span(ends: Sequence[str]) -> str:
    """Format the ends of a range, once where they are the same."""
    return ends[0] if ends[0] == ends[-1] else f"{ends[0]} to {ends[-1]}"


def _finest(row: Sequence[LadderPoint]) -> LadderPoint:
    """Return the rung of the least tolerance."""
    return min(row, key=lambda one: one.tolerance)
