"""Run linear algebra of models on one thread: factorisations of sparse matrices slow down with more.

The number of threads of a BLAS library belongs to the process. So the first call of a model that begins sets it to
one, and the last that ends puts it back, whichever threads of Python these calls run in. Where it is one already, a
call costs a few microseconds, else ten.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

import scipy.linalg  # noqa: F401  (its BLAS is another than numpy's, and must be there to be found)
from threadpoolctl import ThreadpoolController

_LOCK = threading.Lock()
P = ParamSpec("P")
T = TypeVar("T")


class _Running:
    """The calls of models that run now, and the numbers of threads before the first of them."""

    calls = 0
    before: tuple[int, ...] = ()


@cache
def _libraries() -> tuple[Any, ...]:
    """Return the handles of the BLAS libraries that are loaded, found once: a search takes 10 ms."""
    return tuple(ThreadpoolController().select(user_api="blas").lib_controllers)


def _set(numbers: tuple[int, ...]) -> None:
    """Give every library its number of threads, whichever thread of Python set it last."""
    for library, number in zip(_libraries(), numbers, strict=True):
        if library.get_num_threads() != number:
            if hasattr(library, "clear_controlling_thread"):  # OpenBLAS obeys the thread that came first only
                library.clear_controlling_thread(force=True)
            library.set_num_threads(number)


@contextmanager
def single_thread() -> Iterator[None]:
    """Keep BLAS to one thread in a block, until the last of all such blocks is done."""
    with _LOCK:
        if _Running.calls == 0:
            _Running.before = tuple(library.get_num_threads() for library in _libraries())
            _set((1,) * len(_Running.before))
        _Running.calls += 1
    try:
        yield
    finally:
        with _LOCK:
            _Running.calls -= 1
            if _Running.calls == 0:
                _set(_Running.before)


def one_thread(call: Callable[P, T]) -> Callable[P, T]:
    """Return a function that runs with one BLAS thread; calls may nest and come from several threads at once.

    It is for public methods of models, and for what factors matrices.
    """

    @wraps(call)
    def limited(*args: P.args, **kwargs: P.kwargs) -> T:
        with single_thread():
            return call(*args, **kwargs)

    return limited
