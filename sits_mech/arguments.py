"""Refuse arguments of public functions that are of another kind than their signature says, in one line.

Of each annotation that is known here; numbers are checked where they are used, with their range.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from sits_mech.units import SceneError, shown

if TYPE_CHECKING:
    from sits_mech.quantities import Array

Idle = str
_P = ParamSpec("_P")
_R = TypeVar("_R")


def _of(name: str) -> Callable[[object], bool]:
    """Return whether a value is of a class, or of one below it, by the class's name: nothing is imported for it."""
    return lambda value: any(each.__name__ == name for each in type(value).__mro__)


def _several(one: Callable[[object], bool]) -> Callable[[object], bool]:
    """Return whether a value is of several of one kind; a text is none of texts, what can be read once is not read."""

    def holds(value: object) -> bool:
        """Look at each."""
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable) or getattr(value, "ndim", 1) < 1:
            return False
        return isinstance(value, Iterator) or all(map(one, value))

    return holds


def _text(value: object) -> bool:
    """Return whether a value is a text."""
    return isinstance(value, str)


def _path(value: object) -> bool:
    """Return whether a value names a file."""
    return isinstance(value, str | Path)


def _calibrated(value: object) -> bool:
    """Return whether a value names a calibration, or is one."""
    if isinstance(value, tuple):
        return [_of(kind)(part) for kind, part in zip(("Sensor", "Dataset"), value, strict=False)] == [True, True]
    return _path(value)


_KINDS: Mapping[str, tuple[str, Callable[[object], bool]]] = {
    "Sensor": ("a Sensor, as from load_sensor", _of("Sensor")),
    "Wrench": ("a Wrench, such as Wrench(F_z=1.0)", _of("Wrench")),
    "Pose": ("a Pose, such as Pose(0.0, 2e-3, 0.0)", _of("Pose")),
    "xr.Dataset": ("a Dataset, as from calibrate", _of("Dataset")),
    "MagneticModel": ("a model, as from magnetic_model", lambda value: hasattr(value, "impedance")),
    "str": ("a text", _text),
    "Path": ("a Path", lambda value: isinstance(value, Path)),
    "Idle": ('"open", "shorted" or "live"', lambda value: str(value) in ("open", "shorted", "live")),
    "str | Path": ("a path", _path),
    "str | Path | Measured": ("a path or readings", lambda value: _path(value) or _of("Measured")(value)),
    "Calibrated": ("the folder of a calibration, or its Sensor and Dataset", _calibrated),
    "Sequence[str]": ("a list of texts", _several(_text)),
    "Sequence[Wrench]": ("a list of Wrenches", _several(_of("Wrench"))),
    "Sequence[Pose]": ("a list of Poses", _several(_of("Pose"))),
    "Progress": ("a function of two numbers", callable),
}
"""Annotations, what an argument must be in words, and whether it is."""


def checked_arguments(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Return a function that refuses arguments of another kind than its annotations say with a SceneError."""
    signature = inspect.signature(function)
    annotated = {name: str(each.annotation) for name, each in signature.parameters.items()}
    kinds = {
        name: (*_KINDS[kind], kind != text) for name, text in annotated.items()
        if (kind := text.replace(" | None", "")) in _KINDS
    }

    @wraps(function)
    def checked(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        """Check and call."""
        given = dict(zip(signature.parameters, args, strict=False)) | kwargs
        for name, (words, holds, absent) in kinds.items():
            if name in given and not (holds(given[name]) or (absent and given[name] is None)):
                raise SceneError(f"{name}: must be {words}{', or None' if absent else ''}; got {shown(given[name])}")
        return function(*args, **kwargs)

    return checked


def real_numbers(name: str, value: object) -> Array:
    """Return an argument as an array of real numbers; SceneError for what holds others."""
    import numpy as np

    try:
        found = np.asarray(value)
        if found.dtype.kind not in "SUc":
            return np.asarray(found, dtype=float)
    except (TypeError, ValueError):  # rows of unlike lengths, or what is no number
        pass
    raise SceneError(f"{name}: must be real numbers; got {shown(value)}")
