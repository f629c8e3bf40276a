"""How much memory may one solution take, how long may one input be? What does not fit is refused by name."""

from __future__ import annotations

import os
from pathlib import Path

from sits_mech.units import SceneError

VARIABLE = "SITS_MECH_MEMORY"
"""Environment variable of the limit, in GiB; processes that a study starts inherit it."""
GIB = 2**30
"""Bytes of a GiB."""
_DEFAULT = 4.0  # GiB
_MIB = 2**20


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


def input_text(path: str | Path, what: str, most: int = 64, errors: str = "strict") -> str:
    """Return the text of an input file in UTF-8, with or without a byte order mark.

    Parameters
    ----------
    path : str or Path
        A file, a pipe or a device: no more is read than may come.
    what : str
        What it must be, such as "a readable scene file".
    most : int
        How long it may be [MiB].
    errors : str
        What becomes of bytes that are no text, as of `bytes.decode`.

    Raises
    ------
    SceneError
        When it cannot be read or is longer.
    UnicodeDecodeError
        When it is no text and `errors` is "strict".
    """
    try:
        with Path(path).open("rb") as stream:
            content = stream.read(most * _MIB + 1)
    except OSError as error:
        raise SceneError(f"{path}: must be {what}; got: {error.strerror or error}") from None
    if len(content) > most * _MIB:
        raise SceneError(f"{path}: must be {what} of at most {most} MiB; got more")
    return content.decode("utf-8-sig", errors)
