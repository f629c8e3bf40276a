"""Find the loads of a table: components of a wrench that vary, those that are the same throughout, slices of both.

A component that varies is a dimension of the table; one that is the same for all loads, and not zero, is a coordinate
without dimension; what is neither is zero. Where a touch has several places, these are components like others,
"touch_x" and "touch_y" [m].
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.quantities import TOUCH, WRENCH, Wrench, load_at, shown_unit
from sits_mech.status import ANSWERED

if TYPE_CHECKING:
    import xarray as xr


LOADS = (*WRENCH, *TOUCH)
"""Names of what a table's loads may vary in."""


def request_of(data: xr.Dataset) -> dict[str, Any]:
    """Return what a table was asked for: models, tolerance, loads."""
    return dict(json.loads(data.attrs["request"]))


def varied(data: xr.Dataset) -> tuple[str, ...]:
    """Return the components that a table varies, in the order of `LOADS`."""
    return tuple(name for name in LOADS if name in data.dims)


def several(data: xr.Dataset) -> tuple[str, ...]:
    """Return the components that a table has more than one value of, in the order of `LOADS`."""
    return tuple(name for name in varied(data) if data.sizes[name] > 1)


def fixed(data: xr.Dataset) -> dict[str, float]:
    """Return the components that a table names as the same for all its loads [N, N m]; the others of them are zero."""
    return {name: float(data[name]) for name in LOADS if name in data.coords and name not in data.dims}


def ends_of(data: xr.Dataset, names: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Return the least and the largest value of some variables of a table."""
    return {name: (float(data[name].min()), float(data[name].max())) for name in names}


def over_loads(data: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the variables that each load of a table has; parts of errors that loads share are none."""
    loads = set(data["status"].dims)
    own = {str(name): set(item.dims) for name, item in data.data_vars.items() if name != "L0"}
    return tuple(name for name, dims in own.items() if loads <= dims and not dims & {"part", "cause"})


def answered(data: xr.Dataset) -> xr.DataArray:
    """Return which points of a table have an answer."""
    return data["status"].isin(ANSWERED)


def each_of(data: xr.Dataset, name: str = "status") -> list[Any]:
    """Return a variable of each point of a table, the last dimension running fastest."""
    return list(data[name].to_numpy().ravel().tolist())


def points(data: xr.Dataset) -> Iterator[xr.Dataset]:
    """Give the points of a table one by one, the last dimension running fastest."""
    return (point(data, number) for number in range(data["status"].size))


def point(data: xr.Dataset, number: int) -> xr.Dataset:
    """Return a point of a table by its number, from 0 on."""
    index = np.unravel_index(number, data["status"].shape)
    return data.isel(dict(zip(data["status"].dims, map(int, index), strict=True)))


def wrench_of(row: xr.Dataset) -> Wrench:
    """Return the load of a point of a table, about the touched point of its scene."""
    values = {name: float(row[name]) for name in LOADS if name in row.coords}
    return load_at(values, row.attrs.get("touch", (0.0, 0.0)))


def check_enough(coils: Sequence[object], forces: Sequence[str]) -> None:
    """Refuse to resolve more forces than there are coils."""
    if len(coils) < len(forces):
        raise ValueError(f"coils: {len(coils)} cannot resolve {len(forces)} forces ({', '.join(forces)})")


def middle(data: xr.Dataset, keep: Sequence[str] = ()) -> dict[str, int]:
    """Return the index of the middle value of each component that a table varies, but for those to keep."""
    return {name: data.sizes[name] // 2 for name in varied(data) if name not in keep}


def at_middle(data: xr.Dataset, keep: Sequence[str]) -> tuple[xr.Dataset, str]:
    """Return a table over `keep` alone at the middle of its other components, and in words what those are."""
    found = data.isel(middle(data, keep))
    return found, load_words(fixed(found))


def load_words(components: Mapping[str, float]) -> str:
    """Return components of a load for a reader: ``F_x = 0.5 N, M = 0.001 N m``."""
    return ", ".join(f"{name} = {value:.4g} {shown_unit(name)}" for name, value in components.items())
