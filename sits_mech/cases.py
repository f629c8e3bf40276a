"""Call a function over a grid: one labelled table, in which a case that fails is a row with status and reason.

The grid is the product of its names' values, or takes them side by side. The function may be any callable; the executor
may be any of `concurrent.futures` or what behaves like one. Finished points are kept on disk, one file per point, so
that a run that was stopped goes on where it was.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sits_mech.quantities import SolveFailed, as_jsonable
from sits_mech.scene.files import replaced, write_text
from sits_mech.status import FAILED, OK, WORDS
from sits_mech.units import SceneError

if TYPE_CHECKING:
    import xarray as xr

Row = dict[str, Any]
Progress = Callable[[int, int], None]
Combine = Literal["product", "zip"]
_CHECKSUM = "sha256"
_LASTING = (ValueError, ArithmeticError, SolveFailed)  # a failure that another try would only repeat


def sweep(
    function: Callable[..., Mapping[str, Any]],
    grid: Mapping[str, Sequence[Any]],
    *,
    combine: Combine = "product",
    executor: Executor | None = None,
    chunk: int = 1,
    folder: Path | None = None,
    key: str | Callable[[Row], str] = "",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Call `function` at every point of a grid.

    Parameters
    ----------
    function : callable
        Takes the grid's names as keywords; returns numbers or strings by name, or ``(dims, array)`` pairs.
    grid : mapping of str to sequence
        The values that each name takes.
    combine : {"product", "zip"}
        Whether the grid is their product, or the first values of all, the second ones, and so on.
    executor : Executor, optional
        Where the calls run; one after the other in this process by default.
    chunk : int
        Points that go to the executor at once: many where a call is short.
    folder : Path, optional
        Where finished points are kept, and looked for first.
    key : str, or callable
        Stands for everything besides the point that the result depends on, or gives for a point what stands for all.
    progress : callable, optional
        Called with the number of finished points and of all.

    Returns
    -------
    Dataset
        The function's results, and ``status`` (a word of status.py), ``reason`` and ``seconds`` of every point. The
        dimensions are those of `grid`; of a zipped one it is ``case``, with the grid's names along it.

    Raises
    ------
    ValueError
        When zipped values are not equally many.

    Examples
    --------
    >>> table = sm.sweep(lambda width, height: {"area": width * height}, {"width": [1.0, 2.0], "height": [3.0, 4.0]})
    >>> table["area"].values.tolist()
    [[3.0, 4.0], [6.0, 8.0]]
    """
    points = grid_points(grid, combine)
    names = [(key, point) if isinstance(key, str) else (key(point), {}) for point in points]
    paths = [case_path(folder, *name) for name in names]
    rows: dict[int, Row] = {}
    for index, row in _rows(function, points, paths, executor, chunk):
        rows[index] = row
        if progress is not None:
            progress(len(rows), len(points))
    return table(grid, [rows[index] for index in range(len(points))], combine)


def grid_points(grid: Mapping[str, Sequence[Any]], combine: Combine = "product") -> list[Row]:
    """Return the points of a grid, the last name running fastest; arguments and errors as of `sweep`."""
    if combine == "zip":
        counts = {name: len(values) for name, values in grid.items()}
        if len(set(counts.values())) > 1:
            shown = ", ".join(f"{name} has {count}" for name, count in counts.items())
            raise SceneError(f"zipped values must be equally many; got: {shown}")
        return [dict(zip(grid, values, strict=True)) for values in zip(*grid.values(), strict=True)]
    return [dict(zip(grid, values, strict=True)) for values in itertools.product(*grid.values())]


def _rows(
    function: Callable[..., Mapping[str, Any]],
    points: Sequence[Row],
    paths: Sequence[Path | None],
    executor: Executor | None,
    chunk: int,
) -> Iterable[tuple[int, Row]]:
    """Yield number and row of each point as it is finished, those on disk first."""
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
    parts = [missing[first : first + chunk] for first in range(0, len(missing), chunk)]
    futures = {executor.submit(_attempts, function, [points[i] for i in part]): part for part in parts}
    try:
        for future in as_completed(futures):
            for index, row in zip(futures[future], future.result(), strict=True):
                yield index, finish(paths[index], row)
    finally:
        for future in futures:
            future.cancel()


def _attempts(function: Callable[..., Mapping[str, Any]], points: Sequence[Row]) -> list[Row]:
    """Return the rows of a few points; runs where the executor puts it."""
    return [attempt(function, point) for point in points]


def attempt(function: Callable[..., Mapping[str, Any]], point: Mapping[str, Any]) -> Row:
    """Return the results at a point with ``status``, ``reason`` and ``seconds``; a failure is a row, not the end.

    ``lasting`` says whether another try would only repeat it.
    """
    began = time.perf_counter()
    row: Row = {"status": OK, "reason": "", "lasting": True}
    try:
        row |= function(**point)
    except Exception as error:  # whatever went wrong belongs to this point alone
        status = error.status if isinstance(error, SolveFailed) else FAILED
        said = str(error) if isinstance(error, ValueError | SolveFailed) else f"{type(error).__name__}: {error}"
        row |= {"status": status, "reason": said, "lasting": isinstance(error, _LASTING)}
    return row | {"seconds": time.perf_counter() - began}


def case_path(folder: Path | None, key: str, point: Mapping[str, Any]) -> Path | None:
    """Return the file of a point under `folder`, named by a hash of `key` and the point; None without a folder."""
    if folder is None:
        return None
    text = json.dumps([key, as_jsonable(dict(point))], sort_keys=True, default=str)
    return folder / f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.json"


def read_case(path: Path | None) -> Row | None:
    """Return the row kept in `path`, or None when there is none as it was written: one that was edited is none."""
    if path is None or not path.exists():
        return None
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(row, dict) or row.pop(_CHECKSUM, None) != _checksum(row):
        return None
    return row if row.get("status") in WORDS else None


def _checksum(row: Row) -> str:
    """Return a hash of a row; numbers keep every digit in the text that it is of."""
    return hashlib.sha256(json.dumps(row, sort_keys=True).encode()).hexdigest()


def finish(path: Path | None, row: Row) -> Row:
    """Keep a row in `path`, unless another try may give a better one, and return it."""
    if path is not None and row["lasting"]:
        kept = as_jsonable(row)
        write_text(path, json.dumps(kept | {_CHECKSUM: _checksum(kept)}))
    return row


def table(grid: Mapping[str, Sequence[Any]], rows: Sequence[Row], combine: Combine = "product") -> xr.Dataset:
    """Return rows in the order of `grid_points` as one labelled table, a variable for each name in any row.

    NaN fills what a row lacks, and arrays that are shorter than another row's.
    """
    import xarray as xr

    zipped = combine == "zip"
    dims = ("case",) if zipped else tuple(grid)
    shape = (len(rows),) if zipped else tuple(len(values) for values in grid.values())
    names = dict.fromkeys(name for row in rows for name in row if name != "lasting")
    variables = {name: _column([row.get(name) for row in rows], dims, shape) for name in names}
    return xr.Dataset(variables, {name: (dims if zipped else (name,), list(values)) for name, values in grid.items()})


def _column(items: list[Any], dims: tuple[str, ...], shape: tuple[int, ...]) -> tuple[tuple[str, ...], Any]:
    """Return dimensions and array of one variable: a number or a text a row, or an array with its own dimensions."""
    found = next(item for item in items if item is not None)
    inner, value = found if isinstance(found, tuple | list) else ((), found)
    inner = (inner,) if isinstance(inner, str) else tuple(inner)
    shapes = [np.shape(item[1]) for item in items if item is not None] if inner else [np.shape(value)]
    size, text = tuple(max(each) for each in zip(*shapes, strict=True)), np.asarray(value).dtype.kind in "UO"
    values = np.full((len(items), *size), "" if text else math.nan, dtype=object if text else float)
    for index, item in enumerate(items):
        if item is not None:
            own = item[1] if inner else item
            place: Any = (index, *map(slice, np.shape(own)))
            values[place] = own
    return (*dims, *inner), values.reshape(*shape, *size)


def save_table(dataset: xr.Dataset, path: Path) -> None:
    """Write a table of real numbers and strings as netCDF by an atomic rename; raise SceneError."""
    from xarray.backends import H5NetCDFStore

    dataset = dataset.copy()
    for name in dataset.coords:
        dataset[name].encoding["_FillValue"] = None  # CF allows coordinates none
    with replaced(path) as other, closing(H5NetCDFStore.open(str(other), mode="w", lock=False)) as store:
        dataset.dump_to_store(store)  # `to_netcdf` would import dask's schedulers for this


_DAMAGED = OSError, ValueError, LookupError, RuntimeError
"""What HDF5 raises of files that are none, or damaged."""


def glance(path: Path) -> tuple[dict[str, Any], int]:
    """Return a table's attributes and number of cases, in a tenth of the time of `read_table`; raise as it does."""
    import h5py

    try:
        with h5py.File(path) as file:
            return dict(file.attrs), int(file["status"].size) if "status" in file else 0
    except _DAMAGED as error:
        raise _no_table(path, error) from None


def _no_table(path: Path, error: Exception) -> SceneError:
    """Return the error for a file that is no table."""
    return SceneError(f"{path}: must be a table of this package; got: {' '.join(str(error).split())}")


def read_table(path: Path) -> xr.Dataset:
    """Return the table that `save_table` wrote; raise SceneError when there is none."""
    import xarray as xr

    try:
        return xr.load_dataset(path, engine="h5netcdf")
    except _DAMAGED as error:
        raise _no_table(path, error) from None
