"""Find the models that other packages announce: entry points of the groups `sits_mech.mechanics` and `.magnetics`."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, distributions

_GROUPS = "sits_mech.mechanics", "sits_mech.magnetics"


@cache
def _announced() -> tuple[EntryPoint, ...]:
    """Return what installed packages announce: read once."""
    found = (entry for package in distributions() for entry in package.entry_points)
    return tuple(entry for entry in found if entry.group in _GROUPS)


def plugged(half: str) -> tuple[EntryPoint, ...]:
    """Return the models for a half of the chain, "mechanics" or "magnetics", not loaded yet."""
    return tuple(entry for entry in _announced() if entry.group == f"sits_mech.{half}")
