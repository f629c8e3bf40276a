"""Describe a study file: JSON Schema of what `read_study` reads, with the arguments of each request."""

from __future__ import annotations

from typing import Any

from sits_mech.batch.adaptive import ADAPTIVE
from sits_mech.batch.requests import REQUESTS, Request
from sits_mech.batch.studies.asked import COMPONENTS, TOP
from sits_mech.batch.studies.samples import LONGEST, MOST, SAMPLED
from sits_mech.batch.studies.stages import EXPORT, STAGE_KEYS
from sits_mech.batch.studies.study import COMBINE, KEYS
from sits_mech.scene.bounds import quantity_schema
from sits_mech.schemas.scene import DIALECT, NUMBER_OR_TEXT, listed

Schema = dict[str, Any]
_DOTTED = r"\."
_RANGE_PATTERN = r"^[^:]+(:[^:]+:\s*[0-9]+)?$"


def study_schema() -> Schema:
    """Return the schema of a study file."""
    ends = NUMBER_OR_TEXT
    span = {
        "type": "object", "additionalProperties": False, "required": ["from", "to"],
        "properties": {"from": ends, "to": ends, "count": {"type": "integer", "minimum": 2}},
        "description": "From one end to the other, evenly; of samples without a count.",
    }
    values = {"anyOf": [{"type": "array", "minItems": 1, "uniqueItems": True}, span]}
    one = {"type": "string", "description": "A scene file in the same folder, or a name of the catalogue."}
    text = {"type": "string", "maxLength": LONGEST}
    said = {
        "scene": {"anyOf": [one, listed(one, minItems=1, uniqueItems=True)]},
        "request": {"enum": list(REQUESTS), "description": "The request of every case."},
        "combine": {"enum": list(COMBINE), "default": "product", "description": "All, some of all, in step, samples."},
        "samples": {"type": "integer", "minimum": 1, "maximum": MOST, "description": "Number of samples."},
        "seed": {"type": "integer", "minimum": 0, "default": 0, "description": "Of the samples."},
        "where": listed(text, description="Conditions: cases that break one are left out."),
        "derive": {"type": "object", "additionalProperties": text, "description": "Keys and arguments by others."},
        "vary": {"type": "object", "minProperties": 1, "additionalProperties": values,
                 "description": "Keys of the scene in quotes, arguments of the request bare: lists or ranges."},
        "fixed": {"type": "object", "description": "What is the same in all cases."},
        "adaptive": _adaptive(),
        "then": listed(_stage(text), description="Stages on the best cases of the one before."),
    }
    return {
        "$schema": DIALECT, "title": "Study of sits-mech", "type": "object", "additionalProperties": False,
        "required": ["scene", "request", "vary"], "properties": {key: said[key] for key in KEYS},
        "allOf": [
            *(_of_request(name, request) for name, request in REQUESTS.items()), _of_samples(), _of_adaptive()
        ],
    }


def _adaptive() -> Schema:
    """Return the table that says what is refined, and how far."""
    name = {"type": "string"}
    names = {"anyOf": [name, listed(name, minItems=1, uniqueItems=True)]}
    said = {
        "of": names | {"description": "Variables of the result that cases predict where they are not solved."},
        "within": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1,
                   "description": "Error that they may have, over their range."},
        "limit": {"type": ["number", "string"],
                  "description": "Of the one variable, in SI or with a unit: errors may be larger away from it."},
    }
    alone = {"anyOf": [{"properties": {"limit": False}}, {"properties": {"of": {"anyOf": [name, {"maxItems": 1}]}}}]}
    return {"type": "object", "additionalProperties": False, "required": ["of", "within"], "properties": said} | alone


def _stage(text: Schema) -> Schema:
    """Return a stage after the first."""
    said = {
        "where": listed(text, minItems=1,
                  description="Conditions on the table of the stage before."),
        "least": text | {"description": "What is best where it is least: a variable of that table, or made of some."},
        "largest": text | {"description": "What is best where it is largest."},
        "count": {"type": "integer", "minimum": 1, "description": "How many cases go on; all without it."},
        "request": {"enum": list(REQUESTS), "description": "The request of its cases."},
        "fixed": {"type": "object", "description": "What is other than in the stage before."},
        EXPORT: listed({"type": "string"}, minItems=1,
                 description="Formats of the command export, of each case that is left."),
    }
    kinds = [{"required": ["request"], "properties": {EXPORT: False}},
             {"required": [EXPORT], "properties": {"request": False, "fixed": False}}]
    ends = {"not": {"required": ["least", "largest"]}}
    counted = {"if": {"required": ["count"]}, "then": {"anyOf": [{"required": [end]} for end in ("least", "largest")]}}
    properties = {key: said[key] for key in STAGE_KEYS}
    return {"type": "object", "additionalProperties": False, "properties": properties, "oneOf": kinds} | ends | counted


def _of_adaptive() -> Schema:
    """Return that a refined grid says up to what, and is a whole one."""
    drawn = {"required": ["combine"], "properties": {"combine": {"const": ADAPTIVE}}}
    whole = {"where": {"maxItems": 0}, "derive": {"maxProperties": 0}}
    then = {"required": ["adaptive"], "properties": whole}
    return {"if": drawn, "then": then, "else": {"properties": {"adaptive": False}}}


def _of_samples() -> Schema:
    """Return that samples have a number, no conditions on Saltelli's, and ranges without a count; others with one."""

    def spans(form: Schema) -> Schema:
        return {"additionalProperties": {"if": {"type": "object"}, "then": form}}

    drawn = {"required": ["combine"], "properties": {"combine": {"enum": list(SAMPLED)}}}
    whole = {"properties": {"combine": {"const": "saltelli"}}}
    then = {"required": ["samples"], "properties": {"vary": spans({"not": {"required": ["count"]}})},
            "if": whole, "then": {"properties": {"where": {"maxItems": 0}}}}
    plain = {"vary": spans({"required": ["count"]}), "samples": False, "seed": False}
    return {"if": drawn, "then": then, "else": {"properties": plain}}


def _of_request(name: str, request: Request) -> Schema:
    """Return the arguments that a request has, and those it needs."""
    fixed = {name: _argument(request, argument) for argument in request.arguments for name in _spelt(argument)}
    known = {"anyOf": [{"enum": [*fixed, *TOP]}, {"pattern": _DOTTED}]}
    barred = {name: False for argument in request.ranges for name in _spelt(argument)}
    own = {"vary": barred, "derive": barred, "fixed": fixed}
    then: Schema = {"properties": {table: {"propertyNames": known, "properties": own[table]} for table in own}}
    if request.needed:
        then["allOf"] = [_given(key) for key in request.needed]
    return {"if": {"properties": {"request": {"const": name}}}, "then": then}


def _spelt(argument: str) -> list[str]:
    """Return the names that an argument may have in a study file."""
    return [argument, *(name for name, own in COMPONENTS.items() if own == argument != name)]


def _given(key: str) -> Schema:
    """Return that a table is there and has an argument, by any of its names."""
    places = [(table, name) for table in ("vary", "derive", "fixed") for name in _spelt(key)]
    return {"anyOf": [{"required": [table], "properties": {table: {"required": [name]}}} for table, name in places]}


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
