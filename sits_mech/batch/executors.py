"""Run the cases of a sweep in this process, in processes of this machine, or on a dask cluster.

Every worker computes on one BLAS thread, so that as many of them as there are cores do not get in each other's way.
Tasks of a cluster run one at a time in each process, however many threads it has: Python lets one of them compute, and
each would prepare the same models anew. They refuse to run in another version of the package than the client's.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import pydoc
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from functools import cache
from multiprocessing.connection import wait
from typing import TYPE_CHECKING, Any, TypeVar

from threadpoolctl import threadpool_limits

from sits_mech.disk_cache import keep_by_default
from sits_mech.units import SceneError, shown
from sits_mech.version import __version__

if TYPE_CHECKING:
    from distributed import Client

_ENDING = signal.SIGINT, signal.SIGTERM
_ANSWER_TIMEOUT = 10  # seconds a cluster may take to answer
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # what a BLAS asks for when it is loaded
_ALONE = threading.Lock()
_Found = TypeVar("_Found")


@contextmanager
def workers(processes: int = 1, where: str | Executor | Client | None = None) -> Iterator[Executor | None]:
    """Yield the executor of a study, None with one local process; close what it began, and drop what has not begun.

    `where` replaces local processes: the address of a running dask scheduler, such as "tcp://127.0.0.1:8786", a client
    of one, or an executor. Raise SceneError when there are no processes, no scheduler answers, or workers have another
    version of the package, or none.
    """
    if processes < 1:
        raise SceneError(f"processes must be one or more; got {processes}")
    if isinstance(where, str):
        with _client(where) as client:
            yield _Cluster(client)
    elif where is not None:
        yield where if isinstance(where, Executor) else _Cluster(where)
    elif processes == 1:
        with threadpool_limits(1):
            yield None
    else:
        with _pool(processes) as pool:
            yield pool


def cluster_size(address: str) -> int:
    """Return how many cases a dask cluster computes at once: its worker processes; raise SceneError for none."""
    with _client(address) as client:
        count = len(client.nthreads())
    if count == 0:
        raise SceneError(f"dask: {address} must have workers; it has none yet")
    return count


@contextmanager
def _pool(processes: int) -> Iterator[Executor]:
    """Yield processes of this machine; wait for what they compute, but end them after an error or where one was lost.

    It is shut down first, which its thread reads before that a process is gone: then it would set an error of each call
    that it holds, and cancelled ones refuse that. That thread alone reaps: of two at once one may count the dead.
    """
    executor = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), initializer=_start)
    own = executor._processes
    try:
        _launch(executor, processes)
        yield executor
        if not executor._broken:
            executor.shutdown(cancel_futures=True)
    finally:
        manager: threading.Thread | None = executor._executor_manager_thread  # type: ignore[assignment]  # stubs err
        if manager:
            try:
                executor.shutdown(wait=False, cancel_futures=True)
            finally:
                for each in own.values():
                    each.kill()  # they ignore to be terminated
            manager.join()


def _launch(executor: ProcessPoolExecutor, processes: int) -> None:
    """Start all workers of a pool with signals held back, here until they run and in each until it ignores them."""
    if not hasattr(signal, "pthread_sigmask"):
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    try:
        while len(executor._processes) < processes:  # a call starts one where none is idle
            executor.submit(int)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start() -> None:
    """Make a process a worker: one BLAS thread, gone when its parent is, which alone is interrupted."""
    for each in _ENDING:
        signal.signal(each, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
    _limit_threads()
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(sentinel: int) -> None:
    """End this process with its parent, even when that was killed."""
    wait([sentinel])
    os._exit(1)


@contextmanager
def _client(address: str) -> Iterator[Client]:
    """Give a client of a scheduler."""
    try:
        from distributed import Client
    except ImportError:
        raise SceneError("a dask cluster needs distributed: pip install '.[cluster]' in a clone") from None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # of a scheduler that is lost errors tell
    try:
        client = Client(address, timeout=_ANSWER_TIMEOUT)
    except (OSError, ValueError, TypeError) as error:
        line = " ".join(str(error).split()) or type(error).__name__
        raise SceneError(f"dask: {shown(address)} must be the address of a running scheduler; got: {line}") from None
    with client:
        yield client


class _Cluster(Executor):
    """An executor on the workers of a dask client, which have this version of the package."""

    def __init__(self, client: Client) -> None:
        _check_versions(client.run(pydoc.locate, "sits_mech.__version__", on_error="return"))
        self._executor = client.get_executor(pure=False)

    def submit(self, call: Callable[..., _Found], /, *arguments: Any, **options: Any) -> Future[_Found]:
        """Put a call on a worker."""
        future: Future[_Found] = self._executor.submit(_alone, __version__, call, *arguments, **options)
        return future


def _check_versions(found: Mapping[str, object]) -> None:
    """Raise SceneError where the versions of some workers, by their addresses, are not that of this process."""
    places = dict[str, list[str]]()
    for address, version in found.items():
        if version != __version__ and not isinstance(version, OSError):  # lost since; its tasks look again
            places.setdefault("none" if version is None else str(version), []).append(address)
    if places:
        others = {version: f" and {len(own) - 1} more" if own[1:] else "" for version, own in places.items()}
        got = "; ".join(f"{version} on {own[0]}{others[version]}" for version, own in places.items())
        raise SceneError(f"dask: workers must have sits_mech {__version__}, as this process has; got {got}")


def _alone(version: str, call: Callable[..., _Found], *arguments: Any) -> _Found:
    """Return what a call gives on a worker, where it is the only one; refuse another version of the package."""
    if version != __version__:
        here = f"{socket.gethostname()} has {__version__}"
        raise SceneError(f"dask: workers must have sits_mech {version}, as the client has; {here}")
    with _ALONE:
        _prepare()
        return call(*arguments)


@cache
def _prepare() -> None:
    """Make this process a cluster's worker: one BLAS thread, preparations in its machine's cache folder.

    Models are kept in its memory, of which a paused worker would let nothing go: it would wait for ever. So it goes on
    until it is over its limit, where its nanny starts it anew.
    """
    from distributed import get_worker

    _limit_threads()
    keep_by_default()
    get_worker().memory_manager.memory_pause_fraction = False


def _limit_threads() -> None:
    """Keep this process to one BLAS thread: of libraries that are loaded, and of those that will be."""
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    threadpool_limits(1)
