"""Describe the keys of schemas by the sections of attributes in the docstrings of the models."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import Any

_HEAD = re.compile(r"^(\w[\w, ]*?)(?: : .*)?$")


def attributes(kind: type) -> dict[str, str]:
    """Return the sentence of each attribute in the NumPy docstring of a class."""
    _, _, section = (inspect.getdoc(kind) or "").partition("Attributes\n----------\n")
    found: dict[str, str] = {}
    names: list[str] = []
    for line in section.splitlines():
        if line and not line.startswith(" "):
            head = _HEAD.match(line)
            names = [name.strip() for name in head[1].split(",")] if head else []
        elif line:
            found |= {name: f"{found.get(name, '')} {line.strip()}".strip() for name in names}
    return found


def with_descriptions(schema: Mapping[str, Any], kind: type) -> dict[str, Any]:
    """Return an object's schema with what the docstring of its class says of the keys, and of it."""
    said = attributes(kind)
    properties = {
        key: {name: item for name, item in entry.items() if name != "title"}
        | ({"description": said[key]} if key in said else {})
        for key, entry in schema["properties"].items()
    }
    first = (inspect.getdoc(kind) or "").partition("\n")[0]
    return dict(schema) | {"description": first, "properties": properties}
