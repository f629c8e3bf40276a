"""State in one word what an answer is worth to a script, the same in tables, files, JSON and exit codes.

    ok               within the tolerance and the silicone's data
    interpolated     the same, by a smooth map between loads, times or cases of a sweep that were solved
    above tolerance  an answer whose estimated error is larger than what was asked for
    not bounded      an answer whose model leaves something out that has no size; `left_out` lists it
    beyond data      an answer; the layer is stretched further than the data behind its silicone's constants, or may be
    not carried      no answer: the layer could not be followed to the load
    failed           no answer, for the reason beside it

Where several hold the worst is the status, and the flags are all of them, worst first.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

WORDS = ("ok", "interpolated", "above tolerance", "not bounded", "beyond data", "not carried", "failed")
"""From best to worst."""
ANSWERED = WORDS[:5]
"""Of rows that hold an answer."""
FINER = 0.1
"""Of what the last mesh changed of the stretch, what the next one changed: at most, of 9 loads of the catalogue."""
UNFINISHED = "unfinished"
"""Of cases that a table of a run that goes on, or was stopped, has no row of yet: neither an answer nor a failure."""
OK, INTERPOLATED, ABOVE, NOT_BOUNDED, BEYOND, NOT_CARRIED, FAILED = WORDS
_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?")
EXIT_DOUBTFUL, EXIT_NO_ANSWER = 4, 3  # exit codes of the command line


def flags_of(
    error: float, tolerance: float, stretch: float | None = None, known: float = float("nan"), *,
    changed: float | None = None, interpolated: bool = False, bounded: bool = True,
) -> tuple[str, ...]:
    """Return the flags of an answer, worst first; an unknown error (NaN) is above any tolerance.

    `stretch` is the layer's, None or NaN where unknown; `FINER` of what the last mesh `changed` is added to it.
    `known` is the stretch that the silicone's data reach, NaN where unknown; `bounded` tells whether all that the
    model leaves out has a size.
    """
    beyond = stretch is not None and stretch + FINER * (changed or 0.0) > known
    holds = {BEYOND: beyond, NOT_BOUNDED: not bounded, ABOVE: not error <= tolerance, INTERPOLATED: interpolated}
    return tuple(word for word, true in holds.items() if true) or (OK,)


def marked(flags: Iterable[str]) -> dict[str, str]:
    """Return the entries of a row for its flags: the worst as its status, and all of them, worst first."""
    found = sorted(set(flags), key=WORDS.index, reverse=True)
    return {"status": found[0], "flags": "; ".join(found)}


def joined(rows: Iterable[str]) -> tuple[str, ...]:
    """Return all that holds of any of some rows, worst first, from the `flags` that they are `marked` with."""
    found = {word for row in rows for word in row.split("; ")} - {OK}
    return tuple(sorted(found, key=WORDS.index, reverse=True)) or (OK,)


def failure_kind(status: str, reason: str) -> str:
    """Return a failure in words, numbers as #, by which failures of one kind are alike."""
    return f"{status}: {_NUMBER.sub('#', reason)}"


def counted(statuses: Sequence[str]) -> str:
    """Return how many answers have each status in words, worst first; of one its word alone."""
    counts = [(statuses.count(word), word) for word in reversed(WORDS)]
    return ", ".join(f"{n} of {len(statuses)} {word}" if len(statuses) > 1 else word for n, word in counts if n)


def exit_code(statuses: Iterable[str], accept: bool = False) -> int:
    """Return the exit code of answers: by the worst; with `accept` any answer is good enough."""
    worst = max((WORDS.index(word) for word in statuses), default=0)
    if worst >= len(ANSWERED):
        return EXIT_NO_ANSWER
    return 0 if accept or worst <= WORDS.index(INTERPOLATED) else EXIT_DOUBTFUL
