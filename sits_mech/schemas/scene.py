"""Describe a scene file: JSON Schema (draft 2020-12), made from the models that read it.

The models fill in and check what a schema cannot say (parts that overlap, sizes against each other), so a scene that
holds the schema may still be refused by `load_sensor`; one that does not hold it is refused. Quantities are numbers in
SI or texts with a unit; ``x-unit`` names the SI unit.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import Any

from sits_mech.inputs import quantity_schema
from sits_mech.scene.cells import Cell
from sits_mech.scene.materials import metals, silicones
from sits_mech.scene.parts.coils import SHAPES, Coil
from sits_mech.scene.parts.cover import Cover
from sits_mech.scene.parts.elastomer import NOT_WITH_LAYERS, Elastomer, Layer
from sits_mech.scene.parts.metal import PLATE_SIZES, Conductor, Target
from sits_mech.scene.parts.readout import Readout
from sits_mech.scene.parts.slots import Slot
from sits_mech.scene.parts.touch import Touch
from sits_mech.scene.sensor import Sensor
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.material import material_table

Schema = dict[str, Any]
_BULK = ("bulk_modulus", "K", "D1")  # keys of which a law has one
DIALECT = "https://json-schema.org/draft/2020-12/schema"
_HEAD = re.compile(r"^(\w[\w, ]*?)(?: : .*)?$")
_PLATE = {shape: sizes for shape, sizes in PLATE_SIZES.items() if shape != "outline"}
_LAYER = {"box": ("width", "length"), "cylinder": ("diameter",), "pillars": ("pitch", "diameter")}


def scene_schema() -> Schema:
    """Return the schema of a scene file."""
    schema = Sensor.model_json_schema()
    parts = {kind.__name__: kind for kind in (Coil, Conductor, Cover, Elastomer, Layer, Readout, Target, Touch)}
    found = {name: with_descriptions(schema["$defs"][name], kind) for name, kind in parts.items()}
    found["Coil"] |= {"required": ["name", "track_width", "track_thickness"], "allOf": _coil_shapes()}
    for name in ("Target", "Conductor"):
        needed = [key for key in found[name]["required"] if key != "load_height"]
        found[name] |= {"required": needed, "allOf": _shapes(_PLATE)}
        text = found[name]["properties"]["material"].get("description")
        found[name]["properties"]["material"] = {"enum": list(metals())} | ({"description": text} if text else {})
    found["Target"]["properties"] |= {
        "mesh": {"type": "string", "description": 'File of a mesh whose border is the outline; of shape "outline".'},
        "mesh_group": {"type": "string", "default": "target", "description": "Group of cells in that file."},
    }
    points, mesh = {"required": ["points"]}, {"required": ["mesh"]}
    found["Target"]["allOf"].append(_if("outline", {"anyOf": [points, mesh]}))
    found["Conductor"]["allOf"].append(_if("outline", points))
    centre = quantity_schema("m", minimum=-1e3, maximum=1e3)
    text = {"description": "x, z or x, y, z of the plate's middle [m]."}
    found["Conductor"]["properties"]["centre"] = list_schema(centre, minItems=2, maxItems=3) | text
    for name in ("Cover", "Elastomer", "Layer"):
        found[name]["properties"]["material"] = {"$ref": "#/$defs/Silicone"}
    several = {"properties": {"layers": {"minItems": 1}}, "required": ["layers"]}
    without = {"properties": dict.fromkeys(NOT_WITH_LAYERS, False)}
    layered = {"if": several, "then": without, "else": {"required": ["material", "thickness"]}}
    found["Elastomer"] |= {"required": [], "allOf": [layered, *_shapes(_LAYER)]}
    found |= {"Silicone": _silicone(), **material_table("neo-hookean").model_json_schema()["$defs"]}
    whole = with_descriptions(schema, Sensor) | {"title": "Scene of sits-mech", "$schema": DIALECT, "$defs": found}
    whole["properties"]["readout"] = {"$ref": "#/$defs/Readout"}
    found |= {kind.__name__: with_descriptions(kind.model_json_schema(), kind) for kind in (Cell, Slot)}
    places = {"description": "Where targets stand with their coils, for sits-mech cells."}
    whole["properties"]["targets"] = list_schema({"$ref": "#/$defs/Cell"}, minItems=2) | places
    whole["properties"]["slots"] = list_schema({"$ref": "#/$defs/Slot"}) | {"description": "Slots between targets."}
    return whole


def list_schema(items: Schema, **more: Any) -> Schema:
    """Return the schema of a list."""
    return {"type": "array", "items": items, **more}


def _if(shape: str, then: Schema) -> Schema:
    """Return what holds of a shape."""
    return {"if": {"properties": {"shape": {"const": shape}}, "required": ["shape"]}, "then": then}


def _shapes(needed: dict[str, tuple[str, ...]]) -> list[Schema]:
    """Return the sizes that each shape needs."""
    return [_if(shape, {"required": list(sizes)}) for shape, sizes in needed.items()]


def _coil_shapes() -> list[Schema]:
    """Return which keys belong to coils of each shape, and which those need."""
    every = dict.fromkeys(key for each in SHAPES.values() for key in each.keys)
    found = []
    for shape, own in SHAPES.items():
        others = {key: False for key in every if key not in own.keys}
        turns = ["turns", "centre"] if "turns" in own.keys else []
        found.append(_if(shape, {"required": [*own.needed, *turns], "properties": others}))
    return [*found, {"if": {"not": {"required": ["shape"]}}, "then": found[0]["then"]}]


def _silicone() -> Schema:
    """Return the schema of a silicone: a name of the catalogue, or a table of a law and its constants."""
    name = {"enum": list(silicones()), "description": "A silicone of the catalogue."}
    tables = [*(_law(name) for name in LAWS), _by_words()]
    return {"anyOf": [name, *tables], "description": "A name of the catalogue, or a table."}


def _by_words() -> Schema:
    """Return the schema of a table of neo-Hooke's law with E and nu, K and mu, or a hardness."""
    pressure, plain = quantity_schema("Pa"), quantity_schema("")
    words = dict.fromkeys(("E", "young_modulus", "mu", "G", "shear_modulus"), pressure)
    words |= dict.fromkeys(("shore_a", "shore_00"), plain)
    own = _law("neo-hookean")
    properties = own["properties"] | words | {"nu": plain, "poisson_ratio": plain}
    one = [{"required": [word]} for word in words]
    return own | {"title": "words", "required": [], "properties": properties, "anyOf": one}


def _law(name: str) -> Schema:
    """Return the schema of a table with the constants of one law."""
    own = material_table(name).model_json_schema()
    own["properties"] |= {"K": quantity_schema("Pa"), "D1": quantity_schema("1/Pa")}
    needed = [key for key in own["required"] if key != "bulk_modulus"]
    return own | {"$defs": {}, "required": needed, "anyOf": [{"required": [key]} for key in _BULK]}


def attributes(kind: type) -> dict[str, str]:
    """Return the sentence of each attribute in the NumPy docstring of a class."""
    _, _, section = (inspect.getdoc(kind) or "").partition("Attributes\n----------\n")
    found: dict[str, str] = {}
    names = []
    for line in section.splitlines():
        if line and not line.startswith(" "):
            head = _HEAD.match(line)
            names = [name.strip() for name in head[1].split(",")] if head else []
        elif line:
            found |= {name: f"{found.get(name, '')} {line.strip()}".strip() for name in names}
    return found


def with_descriptions(schema: Mapping[str, Any], kind: type) -> dict[str, Any]:
    """Return an object's schema with what the docstring of its class says of the keys, and of it."""
    text = attributes(kind)
    properties = {
        key: {name: item for name, item in entry.items() if name != "title"}
        | ({"description": text[key]} if key in text else {})
        for key, entry in schema["properties"].items()
    }
    first = (inspect.getdoc(kind) or "").partition("\n")[0]
    return dict(schema) | {"description": first, "properties": properties}
