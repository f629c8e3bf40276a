"""Descriptions of schemas are the docstrings' own."""

from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.parts.metal import Conductor
from sits_mech.schemas import schema_of
from sits_mech.schemas.scene import attributes


def test_sections_of_attributes_are_read() -> None:
    """Several names of one line, and sentences of several lines."""
    found = attributes(Coil)
    assert found["layers"] == found["turns"] and found["name"] == "One name per coil."
    assert found["corner_radius"].startswith("Of the innermost turn's centre line") and "[m]" in found["corner_radius"]
    assert attributes(Conductor)["points"] == "As of the target, from `centre` [m]."


def test_every_key_of_a_scene_is_described() -> None:
    """A reader of the schema's pages finds no key without a word."""
    parts = schema_of("scene")["$defs"]
    for part in ("Coil", "Conductor", "Elastomer", "Readout", "Target"):
        entries = parts[part]["properties"].items()
        assert [key for key, entry in entries if "description" not in entry and "$ref" not in entry] == [], part
