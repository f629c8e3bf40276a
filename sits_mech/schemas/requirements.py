"""Describe a requirement file: JSON Schema of what `read_requirements` reads."""

from __future__ import annotations

from typing import Any

from sits_mech.quantities import UNITS, WRENCH
from sits_mech.scene.bounds import quantity_schema
from sits_mech.schemas.scene import DIALECT, NUMBER_OR_TEXT, listed
from sits_mech.synthesis.requirements import BY_FORCE, LEAST, PLAIN, SPECIAL, figure_names, unit_of

Schema = dict[str, Any]


def requirements_schema() -> Schema:
    """Return the schema of a requirement file."""
    parts = {
        "scene": {"type": "string", "description": "A scene file in the same folder, or a name of the catalogue."},
        "loads": _loads(), "vary": _vary(), "require": _require(), "tolerance": _tolerance(), "goal": _goal(),
    }
    return {
        "$schema": DIALECT, "title": "Requirements of sits-mech", "type": "object", "additionalProperties": False,
        "required": ["scene", "loads", "vary"], "properties": parts,
    }


def _object(properties: Schema, description: str, **more: Any) -> Schema:
    """Return a table with known keys."""
    return {
        "type": "object", "additionalProperties": False, "properties": properties, "description": description, **more,
    }


def _loads() -> Schema:
    """Return ranges of components of the load, and the overload."""
    pair = {name: _pair(UNITS[name]) for name in WRENCH}
    overload = {"overload": quantity_schema("", minimum=1.0) | {"description": "Times the loads; 1 by default."}}
    needed = {"anyOf": [{"required": [name]} for name in WRENCH]}
    return _object(pair | overload, "Least and greatest of each component that varies.") | needed


def _pair(unit: str) -> Schema:
    """Return two quantities."""
    return listed(quantity_schema(unit), minItems=2, maxItems=2) | {"x-unit": unit}


def _vary() -> Schema:
    """Return what may vary: bounds or lists."""
    end = NUMBER_OR_TEXT
    bounds = _object({"from": end, "to": end}, "Bounds of a number.", required=["from", "to"])
    values = {"anyOf": [{"type": "array", "minItems": 1, "uniqueItems": True}, bounds]}
    what = "Keys of the scene in quotes, a star for every coil: bounds or lists."
    return {"type": "object", "minProperties": 1, "additionalProperties": values, "description": what}


def _require() -> Schema:
    """Return the limits of the figures."""
    by_force = {
        kind: _object(
            {name: quantity_schema(unit_of(kind, name)) for name in WRENCH},
            f"At most, the {kind} of each component.",
        )
        for kind in BY_FORCE
    }
    plain = {
        name: quantity_schema(unit) | {"description": "At least." if name in LEAST else "At most."}
        for name, unit in PLAIN.items()
    }
    footprint = {"footprint": _pair("m") | {"description": "At most, along x and y."}}
    return _object(by_force | plain | footprint, "Limits of figures, all optional.")


def _tolerance() -> Schema:
    """Return the standard deviations of what is made."""
    special = {name: quantity_schema(unit) for name, unit in SPECIAL.items()}
    rest = NUMBER_OR_TEXT
    what = "One standard deviation: of keys of the scene in quotes, and of these."
    return {"type": "object", "properties": special, "additionalProperties": rest, "description": what}


def _goal() -> Schema:
    """Return what is minimised, and the yield."""
    figures = [*figure_names(WRENCH), "footprint"]
    weights = {"type": "object", "minProperties": 1, "propertyNames": {"enum": figures}}
    minimise = {"anyOf": [{"enum": [*figures, "feasible"]}, weights], "default": "feasible"}
    share = quantity_schema("") | {"default": "95 %", "description": "Share of the sensors made that hold every limit."}
    return _object({"minimise": minimise, "yield": share}, "What is best.")
