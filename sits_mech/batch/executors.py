"""Run the cases of a sweep in this process, in processes of this machine, or on a dask cluster.

Every worker computes on one BLAS thread, so that as many of them as there are cores do not get in each other's way.
"""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait

from threadpoolctl import threadpool_limits

from sits_mech.units import SceneError, shown

_ANSWER_TIMEOUT = 10  # seconds a cluster may take to answer
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # what a BLAS asks for when it is loaded


@contextmanager
def workers(processes: int = 1, address: str | None = None) -> Iterator[Executor | None]:
    """Yield the executor of a sweep, None with one local process; close it in the end and drop what has not begun.

    `address` of a running dask scheduler, such as "tcp://127.0.0.1:8786", replaces local processes. Raise SceneError
    when there are no processes, or no scheduler answers.
    """
    if processes < 1:
        raise SceneError(f"processes must be one or more; got {processes}")
    if address is not None:
        with _cluster(address) as executor:
            yield executor
        return
    if processes == 1:
        with threadpool_limits(1):
            yield None
        return
    executor = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), initializer=_start)
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)


def _start() -> None:
    """Make a process a worker: one BLAS thread, gone when its parent is."""
    _limit_threads()
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(sentinel: int) -> None:
    """End this process with its parent, even when that was killed."""
    wait([sentinel])
    os._exit(1)


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    """Give an executor on the cluster of a scheduler."""
    try:
        from distributed import Client
    except ImportError:
        raise SceneError("a dask cluster needs distributed: pip install 'sits-mech[cluster]'") from None
    try:
        client = Client(address, timeout=_ANSWER_TIMEOUT)
    except (OSError, ValueError, TypeError) as error:
        line = " ".join(str(error).split()) or type(error).__name__
        raise SceneError(f"dask: {shown(address)} must be the address of a running scheduler; got: {line}") from None
    with client:
        client.register_worker_callbacks(_limit_threads)
        yield client.get_executor(pure=False)


def _limit_threads() -> None:
    """Keep this process to one BLAS thread: of libraries that are loaded, and of those that will be."""
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    threadpool_limits(1)
