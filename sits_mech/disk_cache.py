"""Keep what took seconds to prepare for the next command: arrays in files of the user's cache folder.

A file is named by the checksum of all that its arrays depend on: what is asked, bit by bit, and the source of the rooms
that make them. Arrays come back bit for bit, so that answers do not hang on what is kept. Files hold plain arrays (npz,
nothing is run that is read) and their own name; one that cannot be read, or has another's, is made anew. The oldest go
where all take more than `ROOM`.

The command line keeps; elsewhere nothing is kept unless `SITS_MECH_CACHE` names a folder. "off" keeps nothing.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

VARIABLE = "SITS_MECH_CACHE"
"""Environment variable of the folder, or "off"; processes that a command starts inherit it."""
OFF = "off"
ROOM = 512 * 2**20
"""Bytes that all files may take: a plate's preparation takes 0.2 to 30 MB."""
FIELDS = "geometry", "magnetics"
"""Rooms whose source the arrays of plates and tracks depend on."""
_OWN = "request_checksum"
_Made = TypeVar("_Made")


def keep_by_default() -> None:
    """Keep in the user's cache folder from here on, unless the environment says otherwise."""
    if VARIABLE not in os.environ:
        from platformdirs import user_cache_dir

        os.environ[VARIABLE] = user_cache_dir("sits-mech", appauthor=False)


def keep_nothing() -> None:
    """Neither read nor write from here on."""
    os.environ[VARIABLE] = OFF


@contextmanager
def nothing_kept() -> Iterator[None]:
    """Neither read nor write within."""
    before = os.environ.get(VARIABLE)
    keep_nothing()
    try:
        yield
    finally:
        del os.environ[VARIABLE]
        os.environ |= {} if before is None else {VARIABLE: before}


def folder() -> Path | None:
    """Return where arrays are kept; None if they are not."""
    name = os.environ.get(VARIABLE, OFF)
    return None if name in (OFF, "") else Path(name)


def kept_files() -> list[Path]:
    """Return the files, the oldest in use first."""
    where = folder()
    found = [] if where is None else [(path.stat().st_mtime, path) for path in where.glob("*.npz")]
    return [path for _, path in sorted(found)]


def clear() -> int:
    """Remove all files and return how many there were."""
    files = kept_files()
    for path in files:
        path.unlink(missing_ok=True)
    return len(files)


def kept(
    asked: object, make: Callable[[], _Made], pack: Callable[[_Made], Mapping[str, Any]],
    unpack: Callable[[Mapping[str, Any]], _Made], rooms: tuple[str, ...] = FIELDS,
) -> _Made:
    """Return what was made of the same `asked` before, or make and keep it.

    `asked` is all it depends on: numbers, words, arrays, parts of scenes, dataclasses and tuples of these. `pack` and
    `unpack` turn what is made into arrays by name and back; `rooms` make it.
    """
    from zipfile import BadZipFile

    import numpy as np  # not before the command line has said on how many threads

    where = folder()
    if where is None:
        return make()
    path = where / f"{_checksum(asked, rooms)}.npz"
    broken = OSError, ValueError, KeyError, EOFError, BadZipFile
    with suppress(*broken), path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
        if str(file[_OWN]) == path.stem:  # else it was put in another's place
            found = unpack({name: file[name] for name in file.files if name != _OWN})
            os.utime(path)
            return found
    made = make()
    with suppress(OSError):  # a folder that cannot be written keeps nothing
        _write(path, {**pack(made), _OWN: path.stem})
    return made


def _write(path: Path, arrays: Mapping[str, Any]) -> None:
    """Write a file whole or not at all, and make room."""
    import tempfile

    import numpy as np

    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(suffix=".part", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            np.savez(stream, **arrays)
        os.replace(name, path)
    finally:
        Path(name).unlink(missing_ok=True)
    files = kept_files()
    size = sum(each.stat().st_size for each in files)
    for each in files:
        if size <= ROOM:
            break
        size -= each.stat().st_size
        each.unlink(missing_ok=True)


def _checksum(asked: object, rooms: tuple[str, ...] = FIELDS) -> str:
    """Return the checksum of what is asked and of the source of the rooms that answer."""
    import hashlib

    digest = hashlib.sha256(_source(rooms))
    _feed(digest, asked)
    return digest.hexdigest()


@lru_cache(maxsize=4)
def _source(rooms: tuple[str, ...]) -> bytes:
    """Return the checksum of the source of rooms."""
    import hashlib

    digest = hashlib.sha256()
    for room in rooms:
        for path in sorted((Path(__file__).parent / room).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


def _feed(digest: Any, part: Any) -> None:
    """Add one part of what is asked, with its kind."""
    from dataclasses import fields, is_dataclass

    import numpy as np

    if isinstance(part, np.ndarray):
        digest.update(f"{part.dtype}{part.shape}".encode() + np.ascontiguousarray(part).tobytes())
    elif hasattr(part, "model_dump_json"):
        digest.update(part.model_dump_json().encode())
    elif is_dataclass(part):
        _feed(digest, tuple(getattr(part, each.name) for each in fields(part)))
    elif isinstance(part, tuple):
        digest.update(f"({len(part)}".encode())
        for each in part:
            _feed(digest, each)
    elif part is None or isinstance(part, int | float | complex | str):
        digest.update(f"{part!r};".encode())
    else:
        raise TypeError(f"a {type(part).__name__} has no checksum")
