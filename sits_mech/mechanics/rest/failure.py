"""What is said of a load path that ended before its goal?

Where it stands, how much of the load is carried if a limit was found, what ended it, and where the silicone's law loses
its stability or leaves its data: one message for layers of all kinds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sits_mech.mechanics.rest.control import Control
from sits_mech.mechanics.rest.pairs import Solved, law_notes, load_words
from sits_mech.mechanics.rest.retry import Line
from sits_mech.mechanics.rest.verdict import reason_words
from sits_mech.quantities import WRENCH, SolveFailed, Wrench


def ended(line: Line, control: Control, solved: Solved, body: str) -> SolveFailed:
    """Return what says where a load path of a `body`, "pad" or "layer", ended, and why."""
    last, mesh = solved.found, line[int(solved.found.state[0])].fine
    laws = law_notes(line.sensor, mesh, last.state[1 : 1 + mesh.mesh.nodes.size])
    limit = () if solved.carried is None or solved.limit is None else (carried_words(solved.carried, solved.limit),)
    why = (*limit, reason_words(solved.reason, line.smallest[0]))
    notes = (*last.report.notes, *why, f"reached {solved.part:.1%} of the path")
    report = replace(last.report, status="load path ended", notes=notes)
    message = (
        f"wrench: the {body} could be followed to {load_words(vars(last.wrench))} ({solved.part:.1%} of the path), "
        f"not to {_given_words(control.given)}; smallest volume ratio there {report.min_J:.3g}; "
        f"{'; '.join((*laws, *why))}"
    )
    return SolveFailed(message, report, replace(last, report=report), carried=solved.carried)


def carried_words(carried: tuple[Wrench, Wrench], limit: tuple[float, float]) -> str:
    """Return a largest load and its error in words: what of it is not zero, and its share of what was asked."""
    load, error = (vars(each) for each in carried)
    parts = [
        f"{name} = {value:.4g} +- {error[name]:.2g} N{' m' * name.startswith('M')}"
        for name, value in load.items() if value != 0.0
    ]  # fmt: skip
    return f"carried up to {', '.join(parts)} ({limit[0]:.3%} +- {limit[1]:.2%} of the path)"


def _given_words(given: Mapping[str, float]) -> str:
    """Return forces and places in words."""
    forces = load_words({name: value for name, value in given.items() if name in WRENCH})
    units = {name: "rad" if name.startswith("alpha") else "m" for name in given if name not in WRENCH}
    return ", ".join([*([forces] * bool(forces)), *(f"{name} = {given[name]:.6g} {units[name]}" for name in units)])
