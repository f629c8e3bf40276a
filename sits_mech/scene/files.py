"""Read, override and write scene files: TOML in and out as plain tables; their meaning is `sensor.py`.

A key is written with dots; entries of a list of tables go by number or by their name: ``coils.0.turns``,
``coils.C1.turns``.
"""

from __future__ import annotations

import errno
import json
import os
import secrets
import shutil
import stat
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from sits_mech.memory import input_text
from sits_mech.units import SceneError, shown

Table = dict[str, Any]
Meant = TypeVar("Meant")
_LONGEST = 8  # MiB of a scene; fifty thousand corners take two
_DEEPEST = 16  # tables and lists within another; a scene has four
_DESCRIPTORS = tuple(map(Path, ("/dev", "/dev/fd", "/proc/self/fd")))
_STDOUT = ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")
_MOST_LINKS = 40  # as many as the system follows


def read_toml(path: Path) -> Table:
    """Return the tables of the TOML file `path`; raise SceneError when it cannot be read or is not TOML."""
    try:
        found = tomllib.loads(input_text(path, "a readable scene file", _LONGEST))
    except SceneError:
        raise
    except (ValueError, RecursionError) as error:  # not UTF-8, not TOML, or a path that cannot be
        raise SceneError(
            f"{shown(str(path))[1:-1]}: must be a TOML file; got: {' '.join(str(error).split())}"
        ) from None
    try:
        check_depth(found)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    return found


def check_depth(value: Any) -> None:
    """Raise SceneError where tables and lists are nested deeper than any scene's, so that all else may recurse."""
    level, depth = [value], 0
    while level and depth <= _DEEPEST:
        inner = [tuple(each.values()) if isinstance(each, Mapping) else each for each in level]
        level = [item for each in inner for item in each if isinstance(item, Mapping | list | tuple)]
        depth += 1
    if level:
        raise SceneError(f"tables must be nested at most {_DEEPEST} deep; got more")


def read_as(path: Path, meaning: Callable[[Table, Path], Meant]) -> Meant:
    """Return `meaning` of a TOML file's tables and folder.

    Raises SceneError in one line: the file, the key, what it must be, what came.
    """
    table = read_toml(path)
    try:
        return meaning(table, path.parent)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None


def overridden(table: Mapping[str, Any], overrides: Sequence[str]) -> Table:
    """Return a copy of `table` with overrides applied, such as ``'target.width="15 mm"'``.

    A value is TOML; what is not TOML is taken as a string. Raises SceneError when an override has no ``=``, or its key
    does not lead to a table.
    """
    result: Table = _copied(table)
    for override in overrides:
        key, equals, text = override.partition("=")
        steps = key.strip().split(".")
        if not equals or not all(steps):
            raise SceneError(f'--set {shown(override)}: must be key=value, such as target.width="15 mm"')
        if len(steps) > _DEEPEST:
            raise SceneError(f"--set {shown(override)}: must lead through at most {_DEEPEST} tables; got {len(steps)}")
        value = toml_value(text.strip())
        check_depth([value])
        _set(result, steps, value, key.strip())
    return result


def _copied(value: Any) -> Any:
    """Copy tables and lists, share the rest."""
    if isinstance(value, Mapping):
        return {key: _copied(item) for key, item in value.items()}
    return [_copied(item) for item in value] if isinstance(value, list | tuple) else value


def toml_value(text: str) -> Any:
    """Return `text` as a TOML value, or as the string it is."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, RecursionError):
        return text
    return parsed["value"] if set(parsed) == {"value"} else text


def _set(table: Table, steps: list[str], value: Any, key: str) -> None:
    """Put `value` at the end of `steps`; missing tables on the way are made."""
    here: Any = table
    for step in steps[:-1]:
        here = here[_position(here, step, key)] if isinstance(here, list) else here.setdefault(step, {})
        if not isinstance(here, dict | list):
            raise SceneError(f"--set {key}: {step} must be a table; got {shown(here)}")
    if isinstance(here, list):
        here[_position(here, steps[-1], key)] = value
    else:
        here[steps[-1]] = value


def _position(entries: list[Any], step: str, key: str) -> int:
    """Return the index of the entry that `step` names or counts."""
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in entries]
    if step in names:
        return names.index(step)
    if step.isdecimal() and len(step) < 9 and int(step) < len(entries):
        return int(step)
    known = ", ".join(str(name) for name in names if name) or "none"
    raise SceneError(f"--set {key}: {step} must be one of {known}, or a number below {len(entries)}")


def written(table: Mapping[str, Any]) -> str:
    """Return a scene's tables as TOML text; floats keep every digit, keys whose value is None are left out."""
    return "\n".join(_lines(table, "")) + "\n"


def _lines(table: Mapping[str, Any], path: str) -> list[str]:
    """Return the lines of one table, its plain keys first."""
    plain = {key: item for key, item in table.items() if item is not None and not _is_table(item)}
    lines = [f"{key} = {literal(item)}" for key, item in plain.items()]
    for key, item in table.items():
        if isinstance(item, Mapping):
            lines += [f"[{path}{key}]", *_lines(item, f"{path}{key}.")]
        elif _is_table(item):
            for entry in item:
                lines += [f"[[{path}{key}]]", *_lines(entry, f"{path}{key}.")]
    return lines


def _is_table(item: Any) -> bool:
    """Return whether an item needs a heading of its own: a table, or a list of tables."""
    return isinstance(item, Mapping) or (isinstance(item, list | tuple) and any(isinstance(x, Mapping) for x in item))


def literal(item: Any) -> str:
    """Return a TOML value on one line, tables too."""
    if isinstance(item, Mapping):
        return f"{{{', '.join(f'{key} = {literal(entry)}' for key, entry in item.items() if entry is not None)}}}"
    if isinstance(item, list | tuple):
        return f"[{', '.join(literal(entry) for entry in item)}]"
    if isinstance(item, bool):
        return str(item).lower()
    if isinstance(item, str):
        return json.dumps(item, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(item)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` as `write_bytes` does, in UTF-8."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write `content` to `path`, as `replaced` does."""
    with replaced(path) as other:
        other.write_bytes(content)


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield a file to fill that takes the place of `path` when complete, so that no half-written one is met.

    A regular file, or none, is replaced by an atomic rename, at the end of a link where `path` is one, and keeps its
    permissions. A device, a pipe or a descriptor such as /dev/stdout stays what it is and takes the content. Raises
    SceneError when it cannot be written.
    """
    other: Path | None = None
    try:
        place = None if is_open_end(path) else Path(os.path.realpath(path))
        if place is not None and place.is_symlink():
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        folder = Path(tempfile.gettempdir()) if place is None else place.parent
        other = folder / f".{path.name}.{secrets.token_hex(6)}{path.suffix}"  # known before it is there: see `finally`
        os.close(os.open(other, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        yield other
        if place is None:
            _pour(other, path)
        else:
            os.umask(mask := os.umask(0))  # it is read by setting it
            other.chmod(stat.S_IMODE(place.stat().st_mode) if place.exists() else 0o666 & ~mask)
            other.replace(place)
    except OSError as error:
        raise SceneError(f"{path}: must be writable; got: {error.strerror or error}") from None
    finally:
        if other is not None:
            other.unlink(missing_ok=True)


def is_open_end(path: Path) -> bool:
    """Return whether `path` leads to what takes bytes but cannot be replaced: a device, a pipe, an open descriptor."""
    step = path
    for _ in range(_MOST_LINKS):
        if step.is_absolute() and step.parent in _DESCRIPTORS:
            return True
        if not step.is_symlink():
            break
        step = step.parent / step.readlink()
    return step.exists() and not step.is_file() and not step.is_dir()


def _pour(source: Path, end: Path) -> None:
    """Write the bytes of a file into a device, a pipe or a descriptor; stdout's own where it is that."""
    sys.stdout.flush()
    opened = os.dup(1) if str(end) in _STDOUT else os.open(end, os.O_WRONLY)
    with source.open("rb") as taken, os.fdopen(opened, "wb") as given:
        shutil.copyfileobj(taken, given)
