"""JSON Schema of each kind of file that users write, by its name."""

from __future__ import annotations

from typing import Any

from sits_mech.schemas.files import bench_schema, requirements_schema, study_schema
from sits_mech.schemas.scene import scene_schema

SCHEMAS = {
    "scene": scene_schema, "study": study_schema, "requirements": requirements_schema, "bench": bench_schema
}
"""What makes the schema of each kind of file."""


def schema_of(file: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of file, a key of `SCHEMAS`."""
    return SCHEMAS[file]()
