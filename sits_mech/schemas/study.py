"""Describe a study file: JSON Schema of what `read_study` reads, with the arguments of each request."""

from __future__ import annotations

from typing import Any

from sits_mech.batch.requests import REQUESTS, Request
from sits_mech.batch.study import COMPONENTS, KEYS, TOP
from sits_mech.scene.bounds import quantity_schema
from sits_mech.schemas.scene import DIALECT

Schema = dict[str, Any]
_DOTTED = r"\."
_RANGE_PATTERN = r"^[^:]+(:[^:]+:\s*[0-9]+)?$"


def study_schema() -> Schema:
    """Return the schema of a study file."""
    ends = {"anyOf": [{"type": "number"}, {"type": "string"}]}
    span = {
        "type": "object", "additionalProperties": False, "required": ["from", "to", "count"],
        "properties": {"from": ends, "to": ends, "count": {"type": "integer", "minimum": 2}},
        "description": "From one end to the other, evenly.",
    }
    values = {"anyOf": [{"type": "array", "minItems": 1, "uniqueItems": True}, span]}
    said = {
        "scene": {"type": "string", "description": "A scene file in the same folder, or a name of the catalogue."},
        "request": {"enum": list(REQUESTS), "description": "The request of every case."},
        "combine": {"enum": ["product", "zip"], "default": "product", "description": "All with all, or in step."},
        "vary": {"type": "object", "minProperties": 1, "additionalProperties": values,
                 "description": "Keys of the scene in quotes, arguments of the request bare: lists or ranges."},
        "fixed": {"type": "object", "description": "What is the same in all cases."},
    }
    return {
        "$schema": DIALECT, "title": "Study of sits-mech", "type": "object", "additionalProperties": False,
        "required": ["scene", "request", "vary"], "properties": {key: said[key] for key in KEYS},
        "allOf": [_of_request(name, request) for name, request in REQUESTS.items()],
    }


def _of_request(name: str, request: Request) -> Schema:
    """Return the arguments that a request has, and those it needs."""
    fixed = {name: _argument(request, argument) for argument in request.arguments for name in _spelt(argument)}
    known = {"anyOf": [{"enum": [*fixed, *TOP]}, {"pattern": _DOTTED}]}
    tables: Schema = {"vary": {"propertyNames": known}, "fixed": {"propertyNames": known, "properties": fixed}}
    for argument in request.ranges:
        tables["vary"].setdefault("properties", {}).update(dict.fromkeys(_spelt(argument), False))
    then: Schema = {"properties": tables}
    if request.needed:
        places = [[(part, name) for part in tables for name in _spelt(key)] for key in request.needed]
        then["allOf"] = [{"anyOf": [_holds(*place) for place in each]} for each in places]
    return {"if": {"properties": {"request": {"const": name}}}, "then": then}


def _spelt(argument: str) -> list[str]:
    """Return the names that an argument may have in a study file."""
    return [argument, *(name for name, own in COMPONENTS.items() if own == argument != name)]


def _holds(table: str, key: str) -> Schema:
    """Return that a table is there and has a key."""
    return {"required": [table], "properties": {table: {"required": [key]}}}


def _argument(request: Request, name: str) -> Schema:
    """Return what an argument may be."""
    if name == "tolerance":
        return {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}
    if name in request.models:
        return {"enum": ["auto", *request.models[name]]}
    if name in request.ranges:
        span = {"type": "string", "pattern": _RANGE_PATTERN}
        return {"anyOf": [{"type": "number"}, span], "x-unit": request.units[name]}
    return quantity_schema(request.units[name])
