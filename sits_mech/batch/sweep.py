"""Sweep a function over a grid, or run a study file: one public name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np
import xarray as xr

from sits_mech import cases
from sits_mech.arguments import checked_arguments
from sits_mech.batch.executors import workers
from sits_mech.batch.run import run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.store import Row
from sits_mech.units import SceneError, shown

if TYPE_CHECKING:
    from distributed import Client

_OWN = {"status", "reason", "seconds"}  # columns of every table


@dataclass(frozen=True)
class _Checked:
    """A function that fails where a table cannot hold what it returns: such a point is a row that says so."""

    function: Callable[..., Mapping[str, Any]]

    def __call__(self, **point: Any) -> Mapping[str, Any]:
        """Return the results at a point."""
        found = self.function(**point)
        for name, item in found.items():
            dims, value = item if isinstance(item, tuple | list) and len(item) == 2 else ((), item)
            dims, array = np.atleast_1d(np.array(dims, dtype=object)).tolist(), np.asarray(value)
            known = array.dtype.kind in "fiubmM" or {*map(type, array.ravel().tolist())} <= {str, type(None)}
            if not known or array.ndim != len(dims) or not {*map(type, dims)} <= {str}:
                raise ValueError(f"{name}: must be a number, a text, or (dims, array) of such; got {shown(item)}")
            if same := point.keys() & {name, *dims}:
                raise ValueError(f"{name}: must have another name than the grid, and its dims; got {', '.join(same)}")
        return found


def _labels(grid: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """Return a grid whose tuples are labels, no second dimension; refuse names of columns that every table has."""
    if own := _OWN & grid.keys():
        raise SceneError(f"grid: must have other names than the table's {', '.join(sorted(_OWN))}; got {own.pop()}")
    for name, values in grid.items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise SceneError(f"grid: {name}: must be a list of values; got {shown(values)}")
    tuples = [name for name, values in grid.items() if any(isinstance(each, tuple | list) for each in values)]
    return {**grid, **{name: np.fromiter(grid[name], object) for name in tuples}}


class _Options(TypedDict, total=False):
    """What a study file says itself."""

    combine: cases.Combine
    chunk: int
    key: str | Callable[[Row], str]
    group: cases.Group | None
    snapshot: Callable[[xr.Dataset], None] | None


@checked_arguments
def sweep(
    function: Callable[..., Mapping[str, Any]] | str | Path, grid: Mapping[str, Sequence[Any]] | None = None, *,
    executor: Executor | Client | None = None, folder: str | Path | None = None,
    progress: cases.Progress = cases.no_progress, **options: Unpack[_Options],
) -> xr.Dataset:
    """Call a function at every point of a grid, or run the cases of a study file.

    Parameters
    ----------
    function : callable, or str or Path
        Takes the grid's names as keywords; returns numbers or strings by name, or ``(dims, array)`` pairs. Or the path
        of a study file, which is run as `sits-mech sweep` does.
    grid : mapping of str to sequence
        The values that each name takes; a study has its own.
    executor : Executor or distributed.Client, optional
        Where the calls run: an executor of `concurrent.futures`, or a client of a dask cluster, whose workers must have
        this version of the package. One after the other in this process by default.
    folder : str or Path
        Where finished points are kept, in ``cases.sqlite``, and looked for first; one run at a time has it. A study
        needs one, and writes its table there as well; without one a function's points are not kept.
    progress : callable, optional
        Called with the number of finished points and of all.
    combine : {"product", "zip"}
        Whether the grid is the product of its values, or the first values of all, the second ones, and so on. This and
        what follows are for functions: a study says them itself.
    chunk : int
        Points that go to the executor at once: many where a call is short.
    key : str, or callable
        Stands for everything besides the point that the result depends on, or gives for a point what stands for all.
    group : callable, optional
        Gives what a point's call prepares, from what the most share. Points with the same are called one after the
        other, of each the largest group first, and points that share all of it go to the executor together.
    snapshot : callable, optional
        Called now and then, for at most some 2 % of the time, with the table so far; "unfinished" is the ``status`` of
        the points that are still to come.

    Returns
    -------
    Dataset
        The results, and ``status`` (a word of status.py), ``reason`` and ``seconds`` of every point. A point whose call
        fails is a row, too, and so is one that the executor loses with its worker: the same sweep tries it again. The
        dimensions are those of `grid`; of a zipped one it is ``case``, with the grid's names along it.

    Raises
    ------
    SceneError
        When zipped values are not equally many; the folder cannot be written, or is another run's; the study is none;
        workers have another version; or the executor ends before the last point, of which those before are kept.

    Examples
    --------
    >>> table = sm.sweep(lambda width, height: {"area": width * height}, {"width": [1.0, 2.0], "height": [3.0, 4.0]})
    >>> table["area"].values.tolist()
    [[3.0, 4.0], [6.0, 8.0]]

    A study, by two threads:

    >>> import tempfile
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> from pathlib import Path
    >>> lines = 'scene = "biorob2018"', 'request = "pose"', 'vary.fz = ["0 N", "1 N"]', 'fixed.model = "linear"'
    >>> with tempfile.TemporaryDirectory() as out, ThreadPoolExecutor(2) as threads:
    ...     path = Path(out) / "study.toml"
    ...     _ = path.write_text("\\n".join(lines))
    ...     sm.sweep(path, folder=Path(out) / "out", executor=threads)["d_v"].dims
    ('fz',)
    """
    place = None if folder is None else Path(folder)
    if not isinstance(function, str | Path):
        if grid is None:
            raise SceneError("grid: must be given for a function: values by the names of its arguments; it is missing")
        checked, grid = _Checked(function), _labels(grid)
        with nullcontext() if executor is None else workers(1, executor) as where:
            return cases.solve_cases(checked, grid, executor=where, folder=place, progress=progress, **options)
    given = [*([] if grid is None else ["grid"]), *options]
    if given:
        raise SceneError(f"{', '.join(given)}: must be said by the study file; got both")
    if place is None:
        raise SceneError("folder: must be given for a study: where its table and finished cases go; it is missing")
    study = read_study(Path(function))
    with workers(1, executor) as where:
        return run_study(study, place, executor=where, progress=progress)
