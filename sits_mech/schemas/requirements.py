"""Describe a requirement file: JSON Schema of what `read_requirements` reads, made of the models that read it."""

from __future__ import annotations

from typing import Any

from sits_mech.quantities import WRENCH
from sits_mech.schemas.scene import DIALECT
from sits_mech.synthesis.required.written import Written


def requirements_schema() -> dict[str, Any]:
    """Return the schema of a requirement file."""
    found: dict[str, Any] = Written.model_json_schema() | {"$schema": DIALECT, "title": "Requirements of sits-mech"}
    found["$defs"]["loads"]["anyOf"] = [{"required": [name]} for name in WRENCH]
    return found
