"""What does a function give over a grid? One labelled table; a point that fails is a row with its status and reason.

The function may be any callable; the executor may be any of `concurrent.futures` or what behaves like one. Finished
points are kept on disk, one file per point, so that a run that was stopped goes on where it was.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.quantities import SolveFailed, as_jsonable
from sits_mech.scene import write_text
from sits_mech.units import SceneError

Row = dict[str, Any]
Progress = Callable[[int, int], None]
DONE = "converged"
_LASTING = (ValueError, ArithmeticError, SolveFailed)  # a failure that another try would only repeat


def sweep(
    function: Callable[..., Mapping[str, Any]],
    grid: Mapping[str, Sequence[Any]],
    *,
    executor: Executor | None = None,
    folder: Path | None = None,
    key: str = "",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Call `function` at every point of a grid.

    Parameters
    ----------
    function : callable
        Takes the grid's names as keywords; returns numbers or strings by name, or ``(dims, array)`` pairs.
    grid : mapping of str to sequence
        The values that each name takes; their product is the grid.
    executor : Executor, optional
        Where the calls run; one after the other in this process by default.
    folder : Path, optional
        Where finished points are kept, and looked for first.
    key : str
        Stands for everything besides the point that the result depends on.
    progress : callable, optional
        Called with the number of finished points and of all.

    Returns
    -------
    Dataset
        The function's results with dimensions `grid`, and ``status``, ``reason`` and ``seconds`` of every point.
    """
    points = [dict(zip(grid, values, strict=True)) for values in itertools.product(*grid.values())]
    rows: dict[int, Row] = {}
    for index, row in _rows(function, points, executor, folder, key):
        rows[index] = row
        if progress is not None:
            progress(len(rows), len(points))
    return table(grid, [rows[index] for index in range(len(points))])


def _rows(
    function: Callable[..., Mapping[str, Any]],
    points: Sequence[Row],
    executor: Executor | None,
    folder: Path | None,
    key: str,
) -> Iterable[tuple[int, Row]]:
    """Yield number and row of each point as it is finished, those on disk first."""
    paths = [case_path(folder, key, point) for point in points]
    missing = []
    for index, path in enumerate(paths):
        row = read_case(path)
        if row is None:
            missing.append(index)
        else:
            yield index, row
    if executor is None:
        for index in missing:
            yield index, finish(paths[index], attempt(function, points[index]))
        return
    futures = {executor.submit(attempt, function, points[index]): index for index in missing}
    try:
        for future in as_completed(futures):
            yield futures[future], finish(paths[futures[future]], future.result())
    finally:
        for future in futures:
            future.cancel()


def attempt(function: Callable[..., Mapping[str, Any]], point: Mapping[str, Any]) -> Row:
    """Return the results at a point with ``status``, ``reason`` and ``seconds``; a failure is a row, not the end.

    Parameters
    ----------
    function : callable
        As for `sweep`.
    point : mapping
        Its keywords.

    Returns
    -------
    dict
        The results, or those reached, which is none; ``lasting`` says whether another try would only repeat it.
    """
    began = time.perf_counter()
    row: Row = {"status": DONE, "reason": "", "lasting": True}
    try:
        row |= function(**point)
    except Exception as error:  # whatever went wrong belongs to this point alone
        report = error.report if isinstance(error, SolveFailed) else None
        status = type(error).__name__.lower() if report is None else report.status
        row |= {"status": status, "reason": str(error), "lasting": isinstance(error, _LASTING)}
    return row | {"seconds": time.perf_counter() - began}


def case_path(folder: Path | None, key: str, point: Mapping[str, Any]) -> Path | None:
    """Return the file of a point under `folder`, named by a hash of `key` and the point; None without a folder."""
    if folder is None:
        return None
    text = json.dumps([key, as_jsonable(dict(point))], sort_keys=True, default=str)
    return folder / f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.json"


def read_case(path: Path | None) -> Row | None:
    """Return the row kept in `path`, or None when there is none that can be read."""
    if path is None or not path.exists():
        return None
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return row if isinstance(row, dict) and "status" in row else None


def finish(path: Path | None, row: Row) -> Row:
    """Keep a row in `path`, unless another try may give a better one, and return it."""
    if path is not None and row["lasting"]:
        write_text(path, json.dumps(as_jsonable(row)))
    return row


def table(grid: Mapping[str, Sequence[Any]], rows: Sequence[Row]) -> xr.Dataset:
    """Return rows in the order of the grid's product as one labelled table.

    Parameters
    ----------
    grid : mapping of str to sequence
        The dimensions and their coordinates, the last one running fastest.
    rows : sequence of dict
        As from `attempt`; where a row lacks a number the table has NaN.

    Returns
    -------
    Dataset
        One variable for each name in any row.
    """
    shape = tuple(len(values) for values in grid.values())
    names = dict.fromkeys(name for row in rows for name in row if name != "lasting")
    variables = {name: _column([row.get(name) for row in rows], tuple(grid), shape) for name in names}
    return xr.Dataset(variables, coords={name: list(values) for name, values in grid.items()})


def _column(items: list[Any], dims: tuple[str, ...], shape: tuple[int, ...]) -> tuple[tuple[str, ...], Any]:
    """Return dimensions and array of one variable."""
    found = next(item for item in items if item is not None)
    if isinstance(found, str):
        return dims, np.array([item or "" for item in items], dtype=object).reshape(shape)
    inner, value = found if isinstance(found, tuple | list) else ((), found)
    inner = (inner,) if isinstance(inner, str) else tuple(inner)
    size = np.shape(value)
    empty = np.full(size, math.nan)
    values = [empty if item is None else np.asarray(item[1] if inner else item, dtype=float) for item in items]
    return (*dims, *inner), np.array(values).reshape(*shape, *size)


def save_table(dataset: xr.Dataset, path: Path) -> None:
    """Write a table as netCDF by an atomic rename.

    Parameters
    ----------
    dataset : Dataset
        Real numbers and strings.
    path : Path
        The file; its folder must exist.

    Raises
    ------
    SceneError
        When it cannot be written.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        os.close(handle)
    except OSError as error:
        raise SceneError(f"{path}: must be writable; got: {error.strerror or error}") from None
    try:
        dataset.to_netcdf(name, engine="h5netcdf")
        os.chmod(name, 0o644)
        os.replace(name, path)
    except OSError as error:
        raise SceneError(f"{path}: must be writable; got: {error.strerror or error}") from None
    finally:
        Path(name).unlink(missing_ok=True)


def read_table(path: Path) -> xr.Dataset:
    """Return the table that `save_table` wrote; raise SceneError when there is none."""
    try:
        return xr.load_dataset(path, engine="h5netcdf")
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: must be a table of this package; got: {' '.join(str(error).split())}") from None
