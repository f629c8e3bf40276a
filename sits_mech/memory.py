"""Limit memory and time of one solution and the length of an input; what does not fit is refused by name."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

from sits_mech.units import SceneError

VARIABLE = "SITS_MECH_MEMORY"
"""Environment variable of the limit, in GiB; processes that a study starts inherit it."""
GIB = 2**30
"""Bytes of a GiB."""
TIME = "SITS_MECH_SECONDS"
"""Environment variable of the limit of time, in seconds of processor time; as that of memory."""
_DEFAULT = 4.0  # GiB
_PATIENCE = 200.0  # s
_MIB = 2**20  # bytes of a MiB
_Value = TypeVar("_Value")


def memory_limit() -> float:
    """Return the limit [bytes]; raise ValueError where the environment variable is no positive number."""
    return _limit(VARIABLE, _DEFAULT, "GiB") * GIB


def beyond_memory(needed: float) -> str:
    """Say what some bytes are beside the limit, "some 3 GiB, more than ..."; nothing where they fit."""
    limit = memory_limit()
    said = f"some {needed / GIB:.3g} GiB, more than the limit of {limit / GIB:.3g} GiB (--memory, or {VARIABLE})"
    return said if needed > limit else ""


def _limit(variable: str, usual: float, unit: str) -> float:
    """Return what an environment variable says, or what is usual."""
    text = os.environ.get(variable, str(usual))
    try:
        limit = float(text)
    except ValueError:
        limit = float("nan")
    if not limit > 0.0:
        raise ValueError(f"{variable}: must be a positive number of {unit}; got {text!r}")
    return limit


def limit_memory(gib: float) -> None:
    """Set the limit of this process and those it starts [GiB]; raise ValueError where it is not positive."""
    _set_limit(VARIABLE, gib, "memory", "GiB")


def latest(size: Callable[[Any], float]) -> Callable[[Callable[..., _Value]], Callable[..., _Value]]:
    """Keep what a function returned, the last used of it that the limit of memory holds by its `size` [bytes]."""

    def keeping(function: Callable[..., _Value]) -> Callable[..., _Value]:
        found, lock = dict[object, _Value](), RLock()

        @wraps(function)
        def asked(*given: Any) -> _Value:
            with lock:
                found[given] = value = found.pop(given) if given in found else function(*given)
                while len(found) > 1 and sum(map(size, found.values())) > memory_limit():
                    del found[next(iter(found))]
            return value

        vars(asked)["cache_clear"] = found.clear  # as that of `lru_cache`
        return asked

    return keeping


def kept_by_first(most: int) -> Callable[[Callable[..., _Value]], Callable[..., _Value]]:
    """Keep in a function's first argument, by the function's name, what it returned of it, `most` at a time."""

    def keeping(function: Callable[..., _Value]) -> Callable[..., _Value]:
        @wraps(function)
        def asked(owner: Any, *more: Any) -> _Value:
            found: dict[object, _Value] = vars(owner).setdefault(function.__qualname__, {})  # gone with the owner
            if (value := found.get(more)) is None:
                if len(found) >= most:
                    found.clear()
                found[more] = value = function(owner, *more)
            return value

        return asked

    return keeping


def give_back() -> None:
    """Return freed memory to the system, where the C library can: a process that stays holds on to it else."""
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


def limit_seconds(seconds: float) -> None:
    """Set the limit of time of this process and those it starts [s]; raise ValueError where it is not positive."""
    _set_limit(TIME, seconds, "seconds", "seconds")


def _set_limit(variable: str, limit: float, what: str, unit: str) -> None:
    """Put a limit into its environment variable, or refuse it."""
    if not limit > 0.0:
        raise ValueError(f"{what}: must be a positive number of {unit}; got {limit:g}")
    os.environ[variable] = repr(limit)


def seconds_limit() -> float:
    """Return the limit [s of processor time]; raise ValueError where the environment variable is no such number."""
    return _limit(TIME, _PATIENCE, "seconds")


def check_seconds(needed: float, what: str) -> None:
    """Refuse a step `what` that needs longer than the limit [s of processor time] by SceneError, before it begins."""
    limit = seconds_limit()
    if needed > limit:
        raise SceneError(f"{what} must take at most {limit:g} s (--seconds, or {TIME}); it takes some {needed:.2g} s")


def input_text(path: str | Path, what: str, most: int = 64, errors: str = "strict") -> str:
    """Return the text of an input file in UTF-8, with or without a byte order mark, of at most `most` MiB.

    `what` says what it must be, `errors` is that of `bytes.decode`. A pipe or device is read up to the limit. Raise
    SceneError when it cannot be read or is longer, UnicodeDecodeError when it is no text and `errors` is "strict".
    """
    try:
        with Path(path).open("rb") as stream:
            content = stream.read(most * _MIB + 1)
    except (OSError, ValueError) as error:  # no such file, or a path that cannot be
        raise SceneError(f"{path}: must be {what}; got: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > most * _MIB:
        raise SceneError(f"{path}: must be {what} of at most {most} MiB; got more")
    return content.decode("utf-8-sig", errors)


def peak_memory() -> float | None:
    """Return the most memory that this process has had [bytes]; None where the system does not say."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)
