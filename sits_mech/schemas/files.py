"""Describe the files that users write beside a scene: JSON Schema of studies, requirements and rows of a bench file.

Of studies and requirements it is made of the models that read them: it holds the arguments of each request of a study;
what samples, conditions and stages need of each other is found by the reader. A bench file is a CSV whose rows
`read_measured` reads, by column headings: a name with a unit in brackets or in the row below, SI without one; what
precedes the headings or starts with # is passed over.
"""

from __future__ import annotations

from typing import Any

from sits_mech.analysis.readings.measured import HEADINGS
from sits_mech.batch.requests import REQUESTS, Request
from sits_mech.batch.studies.asked import TOP
from sits_mech.batch.studies.written import COMPONENTS, StudyTable
from sits_mech.quantities import WRENCH
from sits_mech.schemas.scene import DIALECT
from sits_mech.synthesis.required.written import Written

_UNIT = r"\s*([\[(].*[\])])?$"


def bench_schema() -> dict[str, Any]:
    """Return the schema of a row of a bench file: an object whose keys are the headings."""
    columns = {
        f"^{each.pattern}{_UNIT}": {"type": "number", "x-unit": each.unit or "1", "description": each.meaning}
        for each in HEADINGS
    }
    return {
        "$schema": DIALECT, "title": "Row of a bench file of sits-mech", "type": "object",
        "patternProperties": columns, "minProperties": 2,
    }


def requirements_schema() -> dict[str, Any]:
    """Return the schema of a requirement file."""
    found: dict[str, Any] = Written.model_json_schema() | {"$schema": DIALECT, "title": "Requirements of sits-mech"}
    found["$defs"]["loads"]["anyOf"] = [{"required": [name]} for name in WRENCH]
    return found


def study_schema() -> dict[str, Any]:
    """Return the schema of a study file."""
    found: dict[str, Any] = StudyTable.model_json_schema() | {"$schema": DIALECT, "title": "Study of sits-mech"}
    for table in (found, found["$defs"]["StageTable"]):
        table["allOf"] = [_of_request(name, request, table) for name, request in REQUESTS.items()]
    found["$defs"] |= {name: _arguments(request) for name, request in REQUESTS.items()}
    return found


def _arguments(request: Request) -> dict[str, Any]:
    """Return what may be fixed for a request: its arguments, by their names in Python too, and keys of the scene."""
    own = request.table.model_json_schema()["properties"]
    own |= {other: own[name] for other, name in COMPONENTS.items() if name in own}
    return {"type": "object", "properties": own, "propertyNames": _names(list(own))}


def _names(arguments: list[str]) -> dict[str, Any]:
    """Return what a key may be: one of some arguments, or of the scene."""
    return {"anyOf": [{"enum": [*arguments, *TOP]}, {"pattern": r"\."}]}


def _of_request(name: str, request: Request, table: dict[str, Any]) -> dict[str, Any]:
    """Return what the tables of a study, or of a stage, may have for a request."""
    own = [other for other in request.arguments if other not in request.ranges]
    names = {"propertyNames": _names([*own, *(other for other, name in COMPONENTS.items() if name in own)])}
    then: dict[str, Any] = {key: names for key in ("vary", "derive") if key in table["properties"]}
    then["fixed"] = {"$ref": f"#/$defs/{name}"}
    return {"if": {"properties": {"request": {"const": name}}, "required": ["request"]}, "then": {"properties": then}}
