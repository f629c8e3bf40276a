"""Choose which cases of a table go on to the next stage of a study.

Those go on that fulfil its conditions, first those of which a column of the table, or what is made of columns, is least
or largest. A condition must hold of all parts of an array, and the worst of them puts a case in order; a part alone is
``resolution.F_z``. Coils that other scenes have besides are no parts of a case. Cases without an answer, or without a
number for the order, do not go on.
"""

from __future__ import annotations

import functools
import itertools
import operator
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from sits_mech.batch.studies.asked import Stage, Study
from sits_mech.batch.studies.samples import Expression
from sits_mech.cases import grid_points
from sits_mech.inputs import unknown
from sits_mech.readout.loads import answered
from sits_mech.units import SceneError

_PADDED = {"coil", "coil_2", "part", "cause"}  # of which a case may have fewer than another


def following(stage: Study, before: Study, numbers: Sequence[int]) -> Study:
    """Return a stage's study with the values of some cases of the study before."""
    points = grid_points(before.vary, before.combine)
    vary = {name: [points[number][name] for number in numbers] for name in before.vary}
    return replace(stage, vary=vary, combine="zip", asked={"combine": "zip"})


def going_on(data: xr.Dataset, stage: Stage) -> list[int]:
    """Return the numbers of the cases of a table, from 0 on, that go on to a stage, the best first."""
    dims, kept = data["status"].dims, answered(data)
    for test in stage.where:
        holds = _evaluated(test, data)
        holds = holds | ~_own(holds, data)
        kept = kept & holds.all([name for name in holds.dims if name not in dims])
    numbers = np.flatnonzero(kept.transpose(*dims)).tolist()
    if stage.order is not None:
        parts = _evaluated(stage.order, data) * (-1.0 if stage.largest else 1.0)
        parts = parts.where(_own(parts, data), -np.inf)
        worst = parts.max([name for name in parts.dims if name not in dims], skipna=False)
        values = worst.broadcast_like(kept).transpose(*dims).to_numpy().ravel()
        numbers = sorted((number for number in numbers if np.isfinite(values[number])), key=values.__getitem__)
    return numbers[: stage.count]


def _evaluated(text: Expression, data: xr.Dataset) -> xr.DataArray:
    """Return what a text gives for each case of a table, and each part of what it names."""
    columns = dict(_columns(data))
    for name in text.names:
        if name not in columns:
            whole = [name for name, (_, labels) in columns.items() if not labels]
            raise SceneError(f"{text.where}: {unknown(name, whole)}")
    used = {name: data[columns[name][0]].sel(columns[name][1], drop=True) for name in text.names}
    with np.errstate(divide="ignore", invalid="ignore"):
        found: xr.DataArray = text(used)
    return found


def _own(parts: xr.DataArray, data: xr.Dataset) -> xr.DataArray:
    """Return which parts a case has, of those that the table has room for: where a column has a number, or none has."""
    found = xr.DataArray(True)
    for dim in _PADDED & {*parts.dims}:
        each = [item.notnull() for item in data.data_vars.values() if dim in item.dims and item.dtype.kind == "f"]
        outer = {dim, *data["status"].dims}
        there = functools.reduce(operator.or_, (one.any({*one.dims} - outer) for one in each))
        found = found & (there | ~there.any(dim))
    return found


def _columns(data: xr.Dataset) -> Iterator[tuple[str, tuple[str, dict[str, str]]]]:
    """Yield the names of what a table has of each case, whole or a labelled part: its variable, and the labels."""
    dims, named = set(data["status"].dims), {name for name, item in data.coords.items() if item.dtype.kind in "UO"}
    for name in (*data["status"].coords, *data.data_vars):
        yield str(name), (str(name), {})
        inner = [str(dim) for dim in data[name].dims if dim not in dims]
        for labels in itertools.product(*(data[dim].to_numpy().tolist() for dim in inner)) if named >= {*inner} else ():
            if labels:
                yield ".".join((str(name), *labels)), (str(name), dict(zip(inner, labels, strict=True)))
