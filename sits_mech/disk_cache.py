"""Keep what took seconds to prepare for the next command: arrays in files of the user's cache folder.

A file is named by the checksum of all that its arrays depend on: what is asked, bit by bit, the source of the module
that makes them and of all of ours that it imports, materials, and the versions of numpy and scipy. Arrays come back bit
for bit, so that answers do not hang on what is kept. Files hold plain arrays (npz, nothing is run that is read) and
their own name; one that cannot be read, or has another's, is made anew. The oldest go where all take more than `ROOM`.

The command line keeps; elsewhere nothing is kept unless `SITS_MECH_CACHE` names a folder. "off" keeps nothing.
"""

from __future__ import annotations

import os
import re
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
_NAMED = re.compile(rb"sits_mech(?:\.\w+)*(?: import \w+)?")  # in a source: what it may import
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
    unpack: Callable[[Mapping[str, Any]], _Made], module: str,
) -> _Made:
    """Return what was made of the same `asked` before, or make and keep it.

    `asked` is all it depends on: numbers, words, arrays, parts of scenes, dataclasses and tuples of these. `pack` and
    `unpack` turn what is made into arrays by name and back; the `module` makes it, ``__name__`` of who asks.
    """
    from zipfile import BadZipFile

    import numpy as np  # not before the command line has set how many threads

    where = folder()
    if where is None:
        return make()
    path = where / f"{_checksum(asked, module)}.npz"
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


def _checksum(asked: object, module: str) -> str:
    """Return the checksum of what is asked and of what a module computes by."""
    import hashlib

    digest = hashlib.sha256(_source(module))
    _feed(digest, asked)
    return digest.hexdigest()


@lru_cache(maxsize=8)
def _source(module: str) -> bytes:
    """Return the checksum of the source of a module and of all of ours below it, materials, versions of libraries."""
    import hashlib

    import numpy as np
    import scipy

    digest, found = hashlib.sha256(f"{np.__version__} {scipy.__version__}".encode()), sources(module)
    materials = sorted((Path(__file__).parent / "scene" / "catalog" / "materials").iterdir())
    for text in (*(found[name] for name in sorted(found)), *(path.read_bytes() for path in materials)):
        digest.update(text)
    return digest.digest()


def sources(module: str) -> dict[str, bytes]:
    """Return the source of one of our modules and of all that its text names, by their names."""
    found, left = dict[str, bytes](), [module]
    while left:
        if (name := left.pop()) not in found:
            found[name] = text = _text(name)
            for named in set(_NAMED.findall(text)):
                whole = named.decode().replace(" import ", ".")
                left += [whole, whole.rpartition(".")[0]]  # a module, or a name in one
    return {name: text for name, text in found.items() if text}


def _text(module: str) -> bytes:
    """Return the source of one of our modules; nothing of what is none, or of the package, which only names homes."""
    parts = module.split(".")[1:]
    place = os.path.join(os.path.dirname(__file__), *parts)
    for path in (f"{place}.py", os.path.join(place, "__init__.py")) if parts else ():
        with suppress(OSError), open(path, "rb") as file:
            return file.read()
    return b""


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
