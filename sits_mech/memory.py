"""How much memory may one solution take? A limit of the process, so that what does not fit is refused by name."""

from __future__ import annotations

import os

VARIABLE = "SITS_MECH_MEMORY"
"""Environment variable of the limit, in GiB; processes that a study starts inherit it."""
GIB = 2**30
"""Bytes of a GiB."""
_DEFAULT = 4.0  # GiB


def memory_limit() -> float:
    """Return the limit [bytes].

    Raises
    ------
    ValueError
        Where the environment variable is no positive number.
    """
    text = os.environ.get(VARIABLE, str(_DEFAULT))
    try:
        limit = float(text)
    except ValueError:
        limit = float("nan")
    if not limit > 0.0:
        raise ValueError(f"{VARIABLE}: must be a positive number of GiB; got {text!r}")
    return limit * GIB


def limit_memory(gib: float) -> None:
    """Set the limit of this process and those it starts [GiB]; raise ValueError where it is not positive."""
    if not gib > 0.0:
        raise ValueError(f"memory: must be a positive number of GiB; got {gib:g}")
    os.environ[VARIABLE] = repr(gib)
