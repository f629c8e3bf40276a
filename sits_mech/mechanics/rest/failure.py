"""Describe a load path that ended before its goal.

Where it stands, how much of the load is carried if a limit was found, what ended it, and where the silicone's law loses
its stability or leaves its data: one message for layers of all kinds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sits_mech.mechanics.levels.answer import Solved, load_words
from sits_mech.mechanics.levels.settle import Line
from sits_mech.mechanics.rest.control import Control
from sits_mech.mechanics.rest.verdict import reason_words
from sits_mech.quantities import WRENCH, SolveFailed, Wrench


def ended(line: Line, control: Control, solved: Solved, body: str) -> SolveFailed:
    """Return the message where and why a load path of a `body`, "pad" or "layer", ended."""
    last, there = solved.found, {name: solved.seen * value for name, value in control.given.items()}
    laws = tuple(f"{note}, under {_given_words(there)} on a coarse mesh" for note in solved.laws)
    limit = () if solved.carried is None or solved.limit is None else (carried_words(solved.carried, solved.limit),)
    if not limit and solved.seen < 1.0:
        limit = (f"no largest load was found: a coarse mesh could be followed to {_given_words(there)}",)
    why = (*limit, reason_words(solved.reason))
    others = (note for note in last.report.notes if note not in solved.laws)
    notes = (*others, *laws, *why, f"reached {solved.part:.1%} of the path")
    report = replace(last.report, status="load path ended", notes=notes)
    message = (
        f"wrench: the {body} could be followed to {load_words(vars(last.wrench))} ({solved.part:.1%} of the path), "
        f"not to {_given_words(control.given)}; smallest volume ratio there {report.min_J:.3g}; "
        f"{'; '.join((*laws, *why))}"
    )
    return SolveFailed(message, report, replace(last, report=report), carried=solved.carried)


def carried_words(carried: tuple[Wrench, Wrench], limit: tuple[float, float]) -> str:
    """Format a largest load and its error: the non-zero components, and the share of what was asked."""
    load, error = (vars(each) for each in carried)
    known = bool(np.isfinite(limit[1]))
    parts = [
        f"{name} = {value:.4g}{f' +- {error[name]:.2g}' * known} N{' m' * name.startswith('M')}"
        for name, value in load.items() if value != 0.0
    ]
    share = f"{limit[0]:.2%} +- {limit[1]:.2%} of the path" if known else "on a coarse mesh, its error is not known"
    return f"carried up to {', '.join(parts)} ({share})"


def _given_words(given: Mapping[str, float]) -> str:
    """Format forces and places."""
    forces = load_words({name: value for name, value in given.items() if name in WRENCH})
    units = {name: "rad" if name.startswith("alpha") else "m" for name in given if name not in WRENCH}
    return ", ".join([*([forces] * bool(forces)), *(f"{name} = {given[name]:.6g} {units[name]}" for name in units)])
