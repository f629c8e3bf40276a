"""What does a question end with, asked in a process of its own whose processor time and memory have a limit?

A forked child answers; one that is killed, or that runs out of memory, is told of as any other end. What it raises
besides is raised here: a study that asks for what is not there ends.
"""

from __future__ import annotations

import os
import pickle
import resource
import signal
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

GIB = 2**30
_RAISED = 3  # exit code of a child whose question raised
_PATIENCE = 15.0
"""Seconds by the clock over those of the processor: what waits for something uses none, a busy machine has fewer."""


@dataclass(frozen=True)
class Ended:
    """How a question ended: what it returned or None, seconds of processor time, peak memory, and why it was killed."""

    value: Any
    seconds: float
    peak: float
    killed: str = ""


def asked_apart(question: Callable[[], Any], *, seconds: float, gib: float) -> Ended:
    """Return what a question returns in a child that has so many seconds of processor time and GiB more of memory."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        _answer(question, write, seconds, gib)
    os.close(write)
    with os.fdopen(read, "rb") as stream:
        text = stream.read()
    _, status, used = os.wait4(child, 0)
    spent, peak = used.ru_utime + used.ru_stime, 1024.0 * used.ru_maxrss
    if os.WIFSIGNALED(status):
        number = signal.Signals(os.WTERMSIG(status))
        limits = {signal.SIGXCPU: seconds, signal.SIGKILL: seconds, signal.SIGALRM: _PATIENCE * seconds}
        why = f"more than {limits[number]:g} s" if number in limits else number.name
        return Ended(None, spent, peak, why)
    if os.WEXITSTATUS(status) == _RAISED:
        raise RuntimeError(text.decode())
    return Ended(pickle.loads(text), spent, peak) if text else Ended(None, spent, peak, "no answer")


def _answer(question: Callable[[], Any], write: int, seconds: float, gib: float) -> None:
    """Answer in the child, which ends here."""
    began = time.process_time()
    resource.setrlimit(resource.RLIMIT_CPU, (int(began + seconds) + 1, int(began + seconds) + 2))
    own = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()  # what it was born with
    resource.setrlimit(resource.RLIMIT_AS, (own + int(gib * GIB), own + int(gib * GIB)))
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.alarm(int(_PATIENCE * seconds) + 1)
    code, text = 0, b""
    try:
        text = pickle.dumps(question())
    except MemoryError:
        code = 1
    except Exception:
        code, text = _RAISED, traceback.format_exc().encode()
    finally:
        with os.fdopen(write, "wb") as stream:
            stream.write(text)
        os._exit(code)
