"""Schemas of files: what the readers take holds them, what they refuse for its form does not."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from sits_mech.scene.sensor import SceneError, load_sensor, scene_table, sensor_from
from sits_mech.schemas import SCHEMAS, schema_of

ROOT = Path(__file__).parents[2]
SCENES = sorted([*(ROOT / "sits_mech/scene/catalog").glob("*.toml"), *(ROOT / "studies").rglob("scenes/*.toml")])
SCENE = Draft202012Validator(schema_of("scene"))


def scene(**changes: Any) -> dict[str, Any]:
    """Return the tables of a catalogued scene with keys changed, such as target__width; None takes one out."""
    table = tomllib.loads((ROOT / "sits_mech/scene/catalog/biorob2018.toml").read_text())
    for name, value in changes.items():
        *steps, last = name.split("__")
        here: Any = table
        for step in steps:
            here = here[int(step)] if step.isdecimal() else here.setdefault(step, {})
        if value is None:
            del here[last]
        else:
            here[last] = value
    return table


@pytest.mark.parametrize("kind", SCHEMAS)
def test_each_is_a_schema(kind: str) -> None:
    """By the dialect's own schema, and as JSON."""
    found = schema_of(kind)
    Draft202012Validator.check_schema(found)
    assert json.loads(json.dumps(found)) == found


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scenes_hold_it(path: Path) -> None:
    """As they are written, and as the package writes them again."""
    SCENE.validate(tomllib.loads(path.read_text()))
    SCENE.validate(json.loads(json.dumps(scene_table(load_sensor(path)))))


@pytest.mark.parametrize(
    "changes",
    [
        {"target__width": 8e-3},
        {"coils__0__turns": 1, "coils__0__track_gap": None},
        {"coils__0__layer_pitch": None, "coils__0__layer_z": ["-20 um", "-100 um"]},
        {"elastomer__material": {"law": "ogden", "mu": ["10 kPa"], "alpha": [2.0], "bulk_modulus": "30 MPa"}},
        {"elastomer__material": {"law": "neo-hookean", "shear_modulus": "30 kPa", "bulk_modulus": 3e7,
                                 "mullins": {"r": 2, "m": "1 kPa", "beta": 0.1}}},
        {"conductors": [{"name": "nut", "material": "brass", "shape": "disc", "diameter": "5 mm", "thickness": "2 mm",
                         "centre": ["0 mm", "-9 mm"]}]},
        {"elastomer": {"material": "ecoflex-00-30", "shape": "pillars", "pitch": "2 mm", "diameter": "1 mm",
                       "thickness": "2 mm"}},
        {"elastomer": {"width": "20 mm", "length": "20 mm", "layers": [
            {"material": "rtv615", "thickness": "1 mm"}, {"material": "ecoflex-00-30", "thickness": 1e-3}]}},
    ],
)
def test_what_is_read_holds_it(changes: dict[str, Any]) -> None:
    """Numbers for quantities, what is filled in, tables of silicones, plates in two coordinates, fields of pillars."""
    sensor_from(scene(**changes))
    SCENE.validate(scene(**changes))


@pytest.mark.parametrize(
    "changes",
    [
        {"name": None},
        {"target__colour": "red"},
        {"target__width": True},
        {"target__width": "8 mm wide!"},
        {"target__width": None},
        {"target__width": -1.0},
        {"target__shape": "star"},
        {"target__material": "unobtainium"},
        {"coils__0__turns": 2.5},
        {"coils__0__inner_diameter": None},
        {"coils__0__inner_width": "2 mm"},
        {"coils__0__shape": "rectangle"},
        {"elastomer__material": "ecoflex"},
        {"elastomer__layers": [{"material": "rtv615", "thickness": "1 mm"}]},
        {"elastomer": {"width": "20 mm", "length": "20 mm", "layers": [{"material": "rtv615"}]}},
        {"elastomer": {"width": "20 mm", "length": "20 mm"}},
        {"elastomer__material": {"law": "ogden", "mu": 1.0, "bulk_modulus": 1e6}},
        {"readout__idle_coil": "floating"},
    ],
)
def test_what_is_refused_for_its_form_does_not(changes: dict[str, Any]) -> None:
    """By the reader and by the schema."""
    with pytest.raises(SceneError):
        sensor_from(scene(**changes))
    assert not SCENE.is_valid(scene(**changes))
