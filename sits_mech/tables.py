"""Keep a labelled table as netCDF: written whole or not at all, read with what it is if it is no table."""

from __future__ import annotations

import threading
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sits_mech.scene.files import replaced
from sits_mech.units import SceneError

if TYPE_CHECKING:
    import xarray as xr

_ONE = threading.Lock()  # netCDF's library serves one thread at a time


def save_table(dataset: xr.Dataset, path: Path) -> None:
    """Write a table of real numbers and strings as netCDF by an atomic rename; raise SceneError."""
    from xarray.backends import NetCDF4DataStore

    dataset = dataset.copy()
    for name in dataset.coords:
        dataset[name].encoding["_FillValue"] = None  # CF allows coordinates none
    with _ONE, replaced(path) as other, closing(NetCDF4DataStore.open(str(other), mode="w", lock=False)) as store:
        dataset.dump_to_store(store)  # `to_netcdf` would import dask's schedulers for this


DAMAGED = OSError, ValueError, LookupError, RuntimeError
"""What netCDF raises of files that are none, or damaged."""


def glance(path: Path) -> tuple[dict[str, Any], int]:
    """Return a table's attributes and number of cases, in a tenth of the time of `read_table`; raise as it does."""
    from netCDF4 import Dataset

    try:
        with _ONE, Dataset(path) as file:
            attributes = {name: file.getncattr(name) for name in file.ncattrs()}
            return attributes, int(file["status"].size) if "status" in file.variables else 0
    except DAMAGED as error:
        raise no_table(path, error) from None


def no_table(path: Path, error: Exception) -> SceneError:
    """Return the error for a file that is no table."""
    return SceneError(f"{path}: must be a table of this package; got: {' '.join(str(error).split())}")


def read_table(path: Path) -> xr.Dataset:
    """Return the table that `save_table` wrote; raise SceneError when there is none."""
    import xarray as xr

    try:
        with _ONE:
            return xr.load_dataset(path, engine="netcdf4")
    except DAMAGED as error:
        raise no_table(path, error) from None
