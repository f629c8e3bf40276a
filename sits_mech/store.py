"""Keep finished cases on disk: those of a sweep in one SQLite file, others in a file each; tables as netCDF.

A row is kept by a hash of all that it depends on, with a checksum of its text: one that was edited or damaged is none,
and is computed again. A sweep's file belongs to one process at a time, by a lock that ends with the process; a
transaction is whole on disk, or not at all, when the process is killed. (After a loss of power the last ones may lack.)
Loads and designs, of which there are some hundred, are written by several processes at once and read while they are.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sits_mech.quantities import as_jsonable
from sits_mech.scene.files import replaced, write_text
from sits_mech.status import WORDS
from sits_mech.units import SceneError

if TYPE_CHECKING:
    import xarray as xr

Row = dict[str, Any]
STORE = "cases.sqlite"
_CHECKSUM = "sha256"
_ONE = threading.Lock()  # netCDF's library serves one thread at a time
_DIGITS = 24  # of the hash: 96 bits, of which two of a million names are the same with a chance of 1e-17
_BEGIN = (
    "PRAGMA locking_mode = EXCLUSIVE",
    "PRAGMA journal_mode = WAL",
    "PRAGMA synchronous = NORMAL",
    "CREATE TABLE IF NOT EXISTS cases (name TEXT PRIMARY KEY, row TEXT, sha256 TEXT)",
)


@dataclass(frozen=True)
class Cases:
    """The finished cases of a sweep, by names of `case_name`; made by `opened`."""

    path: Path
    file: sqlite3.Connection

    def get(self, name: str) -> Row | None:
        """Return the row of a case, or None when there is none as it was written."""
        with _refused(self.path):
            found = self.file.execute("SELECT row, sha256 FROM cases WHERE name = ?", (name,)).fetchone()
        if found is None or not isinstance(found[0], str) or found[1] != _hash(found[0]):
            return None
        return dict(json.loads(found[0]))

    def put(self, rows: Iterable[tuple[str, Row]]) -> None:
        """Keep rows by their names, all or none of them, but those that another try may give better."""
        if not self.path.exists():
            raise SceneError(f"{self.path.parent}: must stay while the run goes on; it was removed")
        texts = ((name, json.dumps(as_jsonable(row))) for name, row in rows if row["lasting"])
        with _refused(self.path), self.file:
            kept = ((name, text, _hash(text)) for name, text in texts)
            self.file.executemany("INSERT OR REPLACE INTO cases VALUES (?, ?, ?)", kept)

    @property
    def names(self) -> set[str]:
        """The names of all cases."""
        with _refused(self.path):
            return {name for (name,) in self.file.execute("SELECT name FROM cases")}


@contextmanager
def opened(folder: Path) -> Iterator[Cases]:
    """Yield the cases of a sweep's folder, which is made.

    Raise SceneError in one line where another run has it, where it cannot be written to, or what is there is no store.
    """
    path = folder / STORE
    with _refused(path):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise sqlite3.OperationalError(error.strerror or str(error)) from None
        file = sqlite3.connect(path, timeout=0.0)
    with closing(file):
        with _refused(path), file:
            for step in _BEGIN:
                file.execute(step)
        yield Cases(path, file)


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Have a folder for this process alone, by a lock that ends with it; raise SceneError where another one has it."""
    path = folder / "running"
    with _refused(path):
        file = sqlite3.connect(path, timeout=0.0, isolation_level=None)
    with closing(file):
        with _refused(path):
            file.execute("BEGIN EXCLUSIVE")
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


@contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Raise what SQLite says of a file as SceneError."""
    try:
        yield
    except sqlite3.Error as error:
        if "locked" in str(error):
            what = "must be the folder of one run at a time; another one has it: wait for its end, or take a folder"
            raise SceneError(f"{path.parent}: {what} of its own") from None
        raise SceneError(f"{path}: must be a file of cases that can be written; got: {error}") from None


def case_name(key: str, point: Mapping[str, Any]) -> str:
    """Return the name of a point: a hash of it, and of a key of all that its row depends on besides."""
    return _hash(json.dumps([key, as_jsonable(dict(point))], sort_keys=True, default=str))[:_DIGITS]


def case_path(folder: Path | None, key: str, point: Mapping[str, Any]) -> Path | None:
    """Return the file of a point under `folder`; None without a folder."""
    return None if folder is None else folder / f"{case_name(key, point)}.json"


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


def finish(path: Path | None, row: Row) -> Row:
    """Keep a row in `path`, unless another try may give a better one, and return it."""
    if path is not None and row["lasting"]:
        kept = as_jsonable(row)
        write_text(path, json.dumps(kept | {_CHECKSUM: _checksum(kept)}))
    return row


def _checksum(row: Row) -> str:
    """Return a hash of a row; numbers keep every digit in the text that it is of."""
    return _hash(json.dumps(row, sort_keys=True))


def _hash(text: str) -> str:
    """Return the SHA-256 of a text, in hexadecimal digits."""
    return hashlib.sha256(text.encode()).hexdigest()


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
