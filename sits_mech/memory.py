"""Limit memory and time of one solution and the length of an input; what does not fit is refused by name."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

from sits_mech.units import SceneError

GIB = 2**30
"""Bytes of a GiB."""
_MIB = 2**20  # bytes of a MiB
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class ProcessLimit:
    """A limit of a process and of those it starts, in an environment variable; raises ValueError unless positive."""

    variable: str
    usual: float
    unit: str
    name: str

    def get(self) -> float:
        """Return what the environment says, or what is usual."""
        text = os.environ.get(self.variable, str(self.usual))
        with suppress(ValueError):
            if (limit := float(text)) > 0.0:
                return limit
        raise ValueError(f"{self.variable}: must be a positive number of {self.unit}; got {text!r}")

    def set(self, limit: float) -> None:
        """Set it."""
        if not limit > 0.0:
            raise ValueError(f"{self.name}: must be a positive number of {self.unit}; got {limit:g}")
        os.environ[self.variable] = repr(limit)


MEMORY = ProcessLimit("SITS_MECH_MEMORY", 4.0, "GiB", "memory")
SECONDS = ProcessLimit("SITS_MECH_SECONDS", 200.0, "seconds", "seconds")  # of processor time, a step


def beyond_memory(needed: float) -> str:
    """Say what some bytes are beside the limit, "some 3 GiB, more than ..."; nothing where they fit."""
    limit = MEMORY.get() * GIB
    return memory_words(needed, limit) if needed > limit else ""


def memory_words(needed: float, limit: float) -> str:
    """Say what some bytes are beside a limit that they exceed."""
    of = f"the limit of {limit / GIB:.3g} GiB (--memory, or {MEMORY.variable})"
    return f"some {needed / GIB:.3g} GiB, more than {of}"


def latest(most: int, owned: bool = False) -> Callable[[Callable[..., _Value]], Callable[..., _Value]]:
    """Keep what a function returned, the last used of it: at most so many, and what the limit of memory holds.

    What is `owned` is kept in the first argument, by the function's name: gone with it, and held by who holds that.
    """

    def keeping(function: Callable[..., _Value]) -> Callable[..., _Value]:
        shared, lock = dict[object, _Value](), RLock()

        @wraps(function)
        def asked(*given: Any) -> _Value:
            found = vars(given[0]).setdefault(function.__qualname__, {}) if owned else shared
            key = given[owned:]
            with lock:
                new = key not in found
                found[key] = value = function(*given) if new else found.pop(key)
                while new and (
                    len(found) > most or (not owned and len(found) > 1 and beyond_memory(array_bytes(found)))
                ):
                    del found[next(iter(found))]
            return value

        vars(asked)["cache_clear"] = shared.clear  # as that of `lru_cache`
        return asked

    return keeping


def array_bytes(value: object) -> int:
    """Return the bytes of the arrays of a value and of all that is in it, each once."""
    import numpy as np  # that help does without

    left, seen, total = [value], set[int](), 0
    while left:
        if id(part := left.pop()) in seen:
            continue
        seen.add(id(part))
        if isinstance(part, np.ndarray):
            total += 0 if isinstance(part.base, np.ndarray) else part.nbytes
            left.append(part.base)
        else:
            within = part.values() if isinstance(part, dict) else part if isinstance(part, tuple | list) else ()
            left.extend((*within, *getattr(part, "__dict__", {}).values()))
    return total


def give_back() -> None:
    """Return freed memory to the system, where the C library can: a process that stays holds on to it else."""
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


def check_seconds(needed: float, what: str) -> None:
    """Refuse a step `what` that needs longer than the limit [s of processor time] by SceneError, before it begins."""
    limit = SECONDS.get()
    if needed > limit:
        raise SceneError(
            f"{what} must take at most {limit:g} s (--seconds, or {SECONDS.variable}); it takes some {needed:.2g} s"
        )


def input_text(path: str | Path, what: str, most: int = 64) -> str:
    """Return the text of an input file in UTF-8, with or without a byte order mark, of at most `most` MiB.

    As `input_bytes`; raise UnicodeDecodeError when it is no text.
    """
    return input_bytes(path, what, most).decode("utf-8-sig")


def input_bytes(path: str | Path, what: str, most: int = 64) -> bytes:
    """Return what is in an input file of at most `most` MiB; a pipe or device is read up to the limit.

    `what` says what it must be. Raise SceneError when it cannot be read or is longer.
    """
    try:
        with Path(path).open("rb") as stream:
            content = stream.read(most * _MIB + 1)
    except (OSError, ValueError) as error:  # no such file, or a path that cannot be
        raise SceneError(f"{path}: must be {what}; got: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > most * _MIB:
        raise SceneError(f"{path}: must be {what} of at most {most} MiB; got more")
    return content


def peak_memory() -> float | None:
    """Return the most memory that this process has had [bytes]; None where the system does not say."""
    with suppress(ImportError):  # Windows
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)
    return None
