"""Describe a requirement file: JSON Schema of what `read_requirements` reads."""

from __future__ import annotations

from typing import Any

from sits_mech.quantities import UNITS, WRENCH
from sits_mech.scene.bounds import quantity_schema
from sits_mech.schemas.scene import DIALECT, NUMBER_OR_TEXT, listed
from sits_mech.synthesis.kinds import ASKED, KINDS, Kind, figure_names, unit_of
from sits_mech.synthesis.requirements import SPECIAL

Schema = dict[str, Any]


def requirements_schema() -> Schema:
    """Return the schema of a requirement file."""
    parts = {
        "scene": {"type": "string", "description": "A scene file in the same folder, or a name of the catalogue."},
        "loads": _loads(), "vary": _vary(),
        "require": _object({key: _limit(key, KINDS[key]) for key in ASKED}, "Limits of figures, all optional."),
        "tolerance": _tolerance(), "goal": _goal(),
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


def _limit(key: str, kind: Kind) -> Schema:
    """Return the limit of a kind of figure."""
    if kind.of == "load":
        each = {name: quantity_schema(unit_of(f"{key}.{name}")) for name in WRENCH}
        return _object(each, f"At most, the {key} of each component.")
    own = _pair(kind.unit) if kind.of else quantity_schema(kind.unit)
    return own | {"description": f"At {'least' if kind.least else 'most'}{', along x and y' if kind.of else ''}."}


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
