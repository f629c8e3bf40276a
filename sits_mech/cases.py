"""Call a function over a grid: one labelled table, in which a case that fails is a row with status and reason.

The grid is the product of its names' values, or takes them side by side. The function may be any callable; the executor
may be any of `concurrent.futures` or what behaves like one. Finished points are kept on disk (store.py), so that a run
that was stopped goes on where it was. The table is filled as points are finished: no row stays in memory.
"""

from __future__ import annotations

import itertools
import math
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sits_mech.quantities import Array, SolveFailed
from sits_mech.status import FAILED, OK, UNFINISHED
from sits_mech.store import Cases, Row, case_name, opened
from sits_mech.units import SceneError

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[int, int], None]
"""Progress callback: parts done, parts in all."""
Combine = Literal["product", "zip"]
Group = Callable[[Row], tuple[Hashable, ...]]
Solve = Callable[[Iterable[int]], Iterator[tuple[int, Row]]]
Choose = Callable[[Solve, Callable[[int, Row], None]], None]
_LASTING = (ValueError, ArithmeticError, SolveFailed)  # a failure that another try would only repeat
_FIRST, _APART = 10.0, 50.0  # seconds to the first snapshot; then as many times what it took, so that all take 2 %


def no_progress(done: int, total: int) -> None:
    """Ignore progress."""


def solve_cases(
    function: Callable[..., Mapping[str, Any]],
    grid: Mapping[str, Sequence[Any]],
    *,
    combine: Combine = "product",
    executor: Executor | None = None,
    chunk: int = 1,
    folder: Path | None = None,
    key: str | Callable[[Row], str] = "",
    group: Group | None = None,
    progress: Progress = no_progress,
    snapshot: Callable[[xr.Dataset], None] | None = None,
    choose: Choose | None = None,
) -> xr.Dataset:
    """Call a function at every point of a grid; arguments, table and errors as of `batch.sweep`, which is public.

    `choose` chooses the points, which else are all: it gets a function that calls points of some numbers and yields
    number and row of each as it is finished, and one that puts a row of its own in the place of a number.
    """
    points, columns = grid_points(grid, combine), Columns(grid, combine)
    seldom = None if snapshot is None else _seldom(lambda: snapshot(columns.table()))
    with nullcontext() if folder is None else opened(folder) as cases:
        work, done = _Work(function, points, key, cases), itertools.count(1)

        def solve(numbers: Iterable[int]) -> Iterator[tuple[int, Row]]:
            for index, row in work.rows(numbers, executor, chunk, group):
                try:
                    columns.put(index, row)
                except (TypeError, ValueError) as error:  # a number where others have a text, or an array
                    columns.put(index, {"status": FAILED, "reason": f"results must be of one kind and shape: {error}"})
                progress(next(done), len(points))
                if seldom is not None:
                    seldom()
                yield index, row

        if choose is not None:
            choose(solve, columns.put)
            progress(len(points), len(points))
        else:
            deque(solve(range(len(points))), maxlen=0)
    return columns.table()


def grid_points(grid: Mapping[str, Sequence[Any]], combine: Combine = "product") -> list[Row]:
    """Return the points of a grid, the last name running fastest; arguments and errors as of `solve_cases`."""
    if combine == "zip" and len({*map(len, grid.values())}) > 1:
        counts = ", ".join(f"{name} has {len(values)}" for name, values in grid.items())
        raise SceneError(f"zipped values must be equally many; got: {counts}")
    joined = zip(*grid.values(), strict=True) if combine == "zip" else itertools.product(*grid.values())
    return [dict(zip(grid, values, strict=True)) for values in joined]


@dataclass(frozen=True)
class _Work:
    """Points to call a function at, and where their rows are kept."""

    function: Callable[..., Mapping[str, Any]]
    points: Sequence[Row]
    key: str | Callable[[Row], str]
    cases: Cases | None
    names: dict[int, str] = field(default_factory=dict)  # of the points that are called, to keep their rows by
    equal: dict[str, list[int]] = field(default_factory=dict)  # numbers of those that are not kept, by name

    def rows(
        self, numbers: Iterable[int], executor: Executor | None, chunk: int, group: Group | None
    ) -> Iterable[tuple[int, Row]]:
        """Yield number and row of each point as it is finished, those that are kept first; of equal ones one is."""
        self.equal.clear()
        for index in numbers:
            name = self.names[index] = self._name(index)
            row = self.cases.get(name) if self.cases is not None else None
            if row is None:
                self.equal.setdefault(name, []).append(index)
            else:
                yield index, row
        firsts = [each[0] for each in self.equal.values()]
        groups = grouped({index: () if group is None else group(self.points[index]) for index in firsts})
        if executor is not None:
            yield from self._spread(executor, chunk, groups)
            return
        for index in itertools.chain.from_iterable(groups):
            yield from self._kept([index], [attempt(self.function, self.points[index])])

    def _name(self, index: int) -> str:
        """Return the name that a point's row is kept under; where nothing is kept, one of its own."""
        if self.cases is None:
            return str(index)
        point = self.points[index]
        with np.printoptions(threshold=sys.maxsize, floatmode="unique"):  # every number of a point's arrays
            return case_name(self.key, point) if isinstance(self.key, str) else case_name(self.key(point), {})

    def _spread(self, executor: Executor, chunk: int, groups: Sequence[list[int]]) -> Iterable[tuple[int, Row]]:
        """Yield number and row of each point of the groups as an executor finishes it.

        Points that are lost together are tried again one by one, for a single one may be what ends their workers.
        """
        parts, lost = [own[first : first + chunk] for own in groups for first in range(0, len(own), chunk)], []
        for part, found in self._finished(executor, parts):
            if not isinstance(found, Exception):
                yield from self._kept(part, found)
            elif len(part) > 1:
                lost.append(part)
            else:
                words = f"{type(found).__name__}: {found}"
                if hasattr(found, "last_worker"):  # dask names a task of its own
                    words = "each worker that it ran on was lost, as often as the scheduler tries"
                row = {"status": FAILED, "reason": words, "lasting": False, "seconds": math.nan}  # to be tried again
                yield from self._kept(part, [row])
        if lost:
            yield from self._spread(executor, 1, lost)

    def _finished(
        self, executor: Executor, parts: Sequence[list[int]]
    ) -> Iterable[tuple[list[int], list[Row] | Exception]]:
        """Yield parts with their rows, or why they have none, as they end; raise SceneError where the executor does."""
        futures, ended = dict[Future[list[Row]], list[int]](), list[Exception]()
        try:
            try:
                for part in parts:
                    futures[executor.submit(_attempts, self.function, [self.points[i] for i in part])] = part
            except BrokenExecutor as error:  # what it has finished comes first
                ended.append(error)
            for future in as_completed(futures):
                part = futures.pop(future)
                try:
                    yield part, future.result()
                except (BrokenExecutor, CancelledError) as error:
                    ended.append(error)
                except Exception as error:  # of what carries the calls: it belongs to these points alone
                    yield part, error
        finally:
            for future in futures:
                future.cancel()
        if ended:
            what = "must live until the last case; those that are kept stay, and the same run goes on from them"
            words = " ".join(f"{type(ended[0]).__name__}: {ended[0]}".split()).rstrip(":")
            raise SceneError(f"executor: {what}; got {words}")

    def _kept(self, part: Sequence[int], rows: Sequence[Row]) -> Iterable[tuple[int, Row]]:
        """Keep rows, and yield them with their points' numbers."""
        found = list(zip(part, rows, strict=True))
        if self.cases is None:
            return found
        self.cases.put([(self.names[index], row) for index, row in found])
        return [(other, row) for index, row in found for other in self.equal[self.names[index]]]


def grouped(shared: Mapping[int, tuple[Hashable, ...]]) -> list[list[int]]:
    """Return the numbers of points by what they share, in the order of the calls."""
    parts, sizes, ranks = dict[tuple[Hashable, ...], list[int]](), Counter[Hashable](), dict[Hashable, int]()
    for index, key in shared.items():
        parts.setdefault(key, []).append(index)
        for first in itertools.accumulate((item,) for item in key):
            sizes[first] += 1
            ranks.setdefault(first, len(ranks))

    def place(key: tuple[Hashable, ...]) -> list[tuple[int, int]]:
        """Return the place of a part: at each of its levels the largest first, then the first."""
        return [(-sizes[first], ranks[first]) for first in itertools.accumulate((item,) for item in key)]

    return [parts[key] for key in sorted(parts, key=place)]


def _seldom(act: Callable[[], None]) -> Callable[[], None]:
    """Return a function that acts when first called after `_FIRST`, then once in `_APART` times what that took."""
    due = time.monotonic() + _FIRST

    def acted() -> None:
        nonlocal due
        began = time.monotonic()
        if began >= due:
            act()
            due = time.monotonic() + _APART * (time.monotonic() - began)

    return acted


def _attempts(function: Callable[..., Mapping[str, Any]], points: Sequence[Row]) -> list[Row]:
    """Return the rows of a few points; runs where the executor puts it."""
    return [attempt(function, point) for point in points]


def attempt(function: Callable[..., Mapping[str, Any]], point: Mapping[str, Any]) -> Row:
    """Return the results at a point with ``status``, ``reason`` and ``seconds``; a failure is a row, not the end.

    ``lasting`` says whether another try would only repeat it.
    """
    began = time.process_time()
    row: Row = {"status": OK, "reason": "", "lasting": True}
    try:
        row |= function(**point)
    except Exception as error:  # whatever went wrong belongs to this point alone
        status = error.status if isinstance(error, SolveFailed) else FAILED
        words = str(error) if isinstance(error, ValueError | SolveFailed) else f"{type(error).__name__}: {error}"
        row |= {"status": status, "reason": words, "lasting": isinstance(error, _LASTING)}
    return row | {"seconds": time.process_time() - began}


class Columns:
    """A table that is filled row by row: a variable for each name in any row.

    NaN fills what a row lacks, and arrays that are shorter than another row's.
    """

    def __init__(self, grid: Mapping[str, Sequence[Any]], combine: Combine = "product") -> None:
        self._grid, self._zipped = grid, combine == "zip"
        sizes = [len(values) for values in grid.values()]
        self._shape = tuple(sizes[:1] if self._zipped else sizes)
        self._count = math.prod(self._shape)
        self._inner: dict[str, tuple[str, ...]] = {}  # each variable's own dimensions
        self._values: dict[str, Array] = {}  # (points, *own sizes)
        self._place: dict[str, tuple[int, int]] = {}  # in the first row that has it: the variables' order

    def put(self, index: int, row: Mapping[str, Any]) -> None:
        """Put a row in the place of its point."""
        for place, (name, item) in enumerate(row.items()):
            if item is None or name == "lasting":
                continue
            inner, value = item if isinstance(item, tuple | list) else ((), item)
            if name not in self._values:
                self._begin(name, inner, value)
            self._place[name] = min(self._place[name], (index, place))
            values = self._values[name]
            if values.ndim == 1:
                values[index] = sys.intern(value) if isinstance(value, str) else value
                continue
            own = np.shape(value)
            if any(size > here for size, here in zip(own, values.shape[1:], strict=True)):
                values = self._wider(name, own)
            values[index][tuple(map(slice, own))] = value

    def _begin(self, name: str, inner: str | Sequence[str], value: Any) -> None:
        """Make an empty column for values such as one, with its dimensions."""
        text = np.asarray(value).dtype.kind in "UO"
        fill = (UNFINISHED if name == "status" else "") if text else math.nan
        size = np.shape(value) if inner else ()
        self._values[name] = np.full((self._count, *size), fill, dtype=object if text else float)
        self._inner[name] = (inner,) if isinstance(inner, str) else tuple(inner)
        self._place[name] = self._count, 0

    def _wider(self, name: str, own: tuple[int, ...]) -> Array:
        """Return a column, made wide enough for a value of a shape."""
        old = self._values[name]
        size = tuple(map(max, own, old.shape[1:]))
        new = np.full((len(old), *size), "" if old.dtype == object else math.nan, dtype=old.dtype)
        new[tuple(map(slice, old.shape))] = old
        self._values[name] = new
        return new

    def table(self) -> xr.Dataset:
        """Return what was put so far, in the order of `grid_points`; it shares its numbers with the columns."""
        import xarray as xr

        dims = ("case",) if self._zipped else tuple(self._grid)
        names = sorted(self._values, key=self._place.__getitem__)
        variables = {
            name: ((*dims, *self._inner[name]), self._values[name].reshape(self._shape + self._values[name].shape[1:]))
            for name in names
        }
        grid = {name: item if isinstance(item, np.ndarray) else list(item) for name, item in self._grid.items()}
        along = {name: (dims if self._zipped else (name,), values) for name, values in grid.items()}
        return xr.Dataset(variables, along)
