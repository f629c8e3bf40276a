"""Solve as few cases of a grid as predict some variables of its table at the others.

Which ones is decided by `maps.grid`, as of the loads of a calibration, for each combination of values that are no
numbers alone. Each part of an array is an output of its map; variables count alike, over the largest range of their
parts that the first cases show. What is not solved has the map's values, and its error as ``error_map_NAME``, to which
the solver's own, linear from case to case, is added as ``error_NAME`` where cases have that. A flag holds between
solved cases where it holds of one beside. Other variables are NaN there. A grid with a failed case is solved whole.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sits_mech.batch.studies.asked import Study
from sits_mech.batch.studies.written import ADAPTIVE, Adaptive
from sits_mech.cases import Choose, Solve, grid_points
from sits_mech.inputs import unknown
from sits_mech.maps.grid import Axes, SolvedPart, interpolated, likely_part, solve_part
from sits_mech.quantities import Array
from sits_mech.status import ANSWERED, INTERPOLATED, OK, marked
from sits_mech.store import Row
from sits_mech.units import SceneError, millimetres, shown, si_label

if TYPE_CHECKING:
    import xarray as xr


def adaptively(study: Study) -> Choose | None:
    """Return what chooses the cases of a study for `cases.solve_cases`; None where all are to be solved."""
    asked = study.adaptive
    if asked is None:
        return None

    def choose(solve: Solve, put: Callable[[int, Row], None]) -> None:
        for axes, numbers in _grids(study.vary):
            grid = _Grid(asked, axes, numbers, solve)
            part = grid.map()
            for index, row in itertools.chain(grid.known(), () if part is None else grid.between(part)):
                put(index, row)

    return choose


def likely(study: Study) -> list[Row]:
    """Return the points of a study that a gentle function needs; all where it is not refined."""
    points = grid_points(study.vary, study.combine)
    if study.adaptive is None:
        return points
    return [points[index] for axes, numbers in _grids(study.vary) for index in _at(axes, numbers, likely_part(axes))]


def refinement_summary(data: xr.Dataset, asked: Adaptive) -> str:
    """Return in a line how many cases of a table were solved, how well the others are known, and where a limit is met.
    """
    count, whole = int(np.isfinite(data["seconds"]).sum()), data["status"].size
    met = "".join(f"; {asked.of[0]} is {asked.limit:.4g} at {text}" for text in _limit_met(data, asked))
    if count == whole:
        return f"solved: all {whole} cases, as they are few, one failed, or they bend throughout{met}"
    errors = ", ".join(f"{name} within {float(data[f'error_map_{name}'].max()):.2g}" for name in asked.of)
    return f"solved: {count} of {whole} cases; between them {errors}{met}"


def _limit_met(data: xr.Dataset, asked: Adaptive) -> list[str]:
    """Return in words where the variable of a limit has its value, of a table over one key with numbers; else none.

    Between two cases on either side it is taken as straight; what that leaves out by second differences, and its errors
    there, over its slope are those of the place.
    """
    name = asked.of[0]
    if asked.limit is None or data[name].ndim != 1 or data[data[name].dims[0]].dtype.kind not in "fiu":
        return []
    key = str(data[name].dims[0])
    data = data.sortby(key)
    x, away = data[key].to_numpy(), data[name].to_numpy() - asked.limit
    off = data[f"error_{name}" if f"error_{name}" in data else f"error_map_{name}"].to_numpy()  # it holds the map's
    found, units, slopes = [], data[key].attrs.get("units", "1").removeprefix("1"), np.diff(away) / np.diff(x)
    bent = np.pad(np.abs(np.diff(slopes) / (x[2:] - x[:-2])), 1)  # half of the second derivative, between slopes
    for k in np.flatnonzero(np.diff(np.signbit(away)) & np.isfinite(slopes)):
        missed = np.nanmax(bent[k : k + 2]) * (x[k + 1] - x[k]) ** 2 / 4.0 + off[k : k + 2].max()
        both = float(f"{x[k] - away[k] / slopes[k]:.4g}"), float(f"{missed / abs(slopes[k]):.2g}")
        place, error = (millimetres(each) if units == "m" else f"{each:g} {units}".rstrip() for each in both)
        found.append(f"{key} = {place} +- {error}")
    return found


@dataclass(frozen=True)
class _Grid:
    """A grid of numbers, its cases, and those that are solved and have an answer."""

    asked: Adaptive
    axes: Axes
    numbers: NDArray[np.int_]  # of its cases
    solve: Solve
    rows: dict[int, Row] = field(default_factory=dict)
    scale: list[Array] = field(default_factory=list)  # of the outputs, once cases are solved

    def map(self) -> SolvedPart | None:
        """Solve as few cases as predict the others and return their map; None where all are solved."""
        limit = None if self.asked.limit is None else np.array(self.asked.limit)
        found = solve_part(self._outputs, self.axes, tolerance=lambda: self.asked.within, limit=limit)
        if found is None:
            self._solved(index for index in self.numbers.ravel().tolist() if index not in self.rows)
        return found

    def known(self) -> Iterator[tuple[int, Row]]:
        """Yield the errors of the map at the cases that are solved, which are zero."""
        for index, row in self.rows.items():
            found = {name: _item(row[name]) for name in self.asked.of}
            yield index, {f"error_map_{name}": (dims, 0.0 * value) for name, (dims, value) in found.items()}

    def between(self, part: SolvedPart) -> Iterator[tuple[int, Row]]:
        """Yield a row for each case that is not solved."""
        first, columns, words = next(iter(self.rows.values())), {}, self._words()
        sizes = [_item(first[name])[1].size for name in self.asked.of]
        missed = np.split(part.error * self.scale[0], np.cumsum(sizes)[:-1])
        for name, own in zip(self.asked.of, missed, strict=True):
            columns[name] = self._interpolated(part, partial(_numbers, name))
            columns[f"error_map_{name}"] = np.broadcast_to(own, columns[name].shape)
            if (error := f"error_{name}") in first:
                columns[error] = np.add(own, self._interpolated(part, partial(_numbers, error), degree=1))
        flags = self._interpolated(part, lambda row: np.array([word in _flags(row) for word in words]), degree=1)
        shapes = {key: _item(first[key.replace("error_map_", "")]) for key in columns}
        for k, index in enumerate(self.numbers.ravel().tolist()):
            if index not in self.rows:
                held = {word for word, share in zip(words, flags[k], strict=True) if not np.isclose(share, 0.0)}
                row = {key: (dims, columns[key][k].reshape(value.shape)) for key, (dims, value) in shapes.items()}
                yield index, row | marked({INTERPOLATED, *held})

    def _outputs(self, points: Sequence[tuple[float, ...]]) -> Array:
        """Return the variables at points of the grid, scaled, shape (points, outputs); NaN where a case has none."""
        numbers = _at(self.axes, self.numbers, points)
        self._solved(numbers)
        known = [self.rows[index] for index in numbers if index in self.rows]
        rows = [np.concatenate([_numbers(name, row).ravel() for name in self.asked.of], dtype=float) for row in known]
        if len(rows) < len(numbers) or len({row.size for row in rows}) > 1:
            return np.full((len(numbers), 1), np.nan)
        if not self.scale:
            self.scale.append(self._ranges(np.array(rows)))
        return np.array(rows) / self.scale[0]

    def _ranges(self, outputs: Array) -> Array:
        """Return for each part the largest range of its variable's parts; 1 of a single variable, as of its limit."""
        sizes = [_numbers(name, next(iter(self.rows.values()))).size for name in self.asked.of]
        parts = np.split(np.ptp(outputs, axis=0), np.cumsum(sizes)[:-1])
        return np.repeat([part.max() or 1.0 if len(sizes) > 1 else 1.0 for part in parts], sizes)

    def _solved(self, numbers: Iterable[int]) -> None:
        """Solve cases and note what those with an answer have of the variables, of their errors, and as flags."""
        for index, row in self.solve(numbers):
            if row["status"] in ANSWERED:
                found = [str(name) for name, item in row.items() if _item(item)[1].dtype.kind in "fiu"]
                for name in self.asked.of:
                    if name not in found:
                        raise SceneError(f"adaptive.of: {unknown(name, found)}")
                keep = ("flags", *self.asked.of, *(f"error_{name}" for name in self.asked.of))
                self.rows[index] = {name: row[name] for name in keep if name in row}

    def _interpolated(self, part: SolvedPart, numbers: Callable[[Row], NDArray[Any]], **degree: int) -> Array:
        """Return the map through numbers of the solved cases at all, shape (cases, n); a map of lines within them."""
        order = {index: k for k, index in enumerate(self.numbers.ravel().tolist())}
        known = np.array([numbers(row).ravel() for row in self.rows.values()], dtype=float)
        values = np.zeros((self.numbers.size, known.shape[1]))
        values[[order[index] for index in self.rows]] = known
        found = interpolated(part, values.reshape(*self.numbers.shape, -1), **degree).reshape(values.shape)
        return np.clip(found, known.min(axis=0), known.max(axis=0)) if degree else found

    def _words(self) -> list[str]:
        """Return the flags that any solved case has, but that it is good."""
        return sorted({word for row in self.rows.values() for word in _flags(row)} - {OK})


def _grids(vary: Mapping[str, Sequence[Any]]) -> Iterator[tuple[Axes, NDArray[np.int_]]]:
    """Yield the ascending numbers of each key that has numbers, and the cases' own, for all values of the others."""
    values = {name: [*map(si_label, own)] for name, own in vary.items()}
    axes = axes_of(vary)
    orders = [np.argsort(np.array(own, float)) if name in axes else np.arange(len(own)) for name, own in values.items()]
    cases = np.arange(np.prod([len(own) for own in values.values()])).reshape([len(own) for own in values.values()])
    others = [k for k, name in enumerate(values) if name not in axes]
    sorted_ = np.moveaxis(cases[np.ix_(*orders)], others, range(len(others)))
    for numbers in sorted_.reshape(-1, *map(len, axes.values())):
        yield axes, numbers


def axes_of(vary: Mapping[str, Sequence[Any]]) -> dict[str, list[float]]:
    """Return the ascending values in SI of each key that has numbers; refuse a study with none, or with one twice."""
    found = {}
    for name, written in vary.items():
        own = [value for value in map(si_label, written) if isinstance(value, float)]
        if len(own) == len(written):
            found[name] = sorted(own)
        if len(set(own)) < len(own):
            raise SceneError(f"{name}: must be a list of different values; got {shown(vary[name])}")
    if not found:
        raise SceneError(f"vary: must have a key with numbers, for {ADAPTIVE}; got {', '.join(vary)}")
    return found


def _at(axes: Axes, numbers: NDArray[np.int_], points: Iterable[tuple[float, ...]]) -> list[int]:
    """Return the numbers of the cases at points of a grid."""
    places = [{value: place for place, value in enumerate(own)} for own in axes.values()]
    return [int(numbers[tuple(own[x] for own, x in zip(places, point, strict=True))]) for point in points]


def _item(item: Any) -> tuple[Any, NDArray[Any]]:
    """Return dimensions and values of an entry of a row, new or as it was kept."""
    dims, value = item if isinstance(item, tuple | list) else ((), item)
    return dims, np.asarray(value)


def _numbers(name: str, row: Row) -> NDArray[Any]:
    """Return the values of an entry of a row."""
    return _item(row[name])[1]


def _flags(row: Row) -> list[str]:
    """Return the flags of a row."""
    return str(row.get("flags", OK)).split("; ")
