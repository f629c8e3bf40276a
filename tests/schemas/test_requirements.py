"""The schema of requirement files holds those of the studies, and refuses what their reader refuses for its form."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from sits_mech.scene.sensor import SceneError
from sits_mech.schemas.files import requirements_schema
from sits_mech.synthesis.required.requirements import requirements_of

FILES = sorted((Path(__file__).parents[2] / "studies/requirements").glob("*.toml"))
ASKED = Draft202012Validator(requirements_schema())


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_requirement_files_hold_it(path: Path) -> None:
    """Those that the studies answer."""
    ASKED.validate(tomllib.loads(path.read_text()))


@pytest.mark.parametrize(
    ("table", "change"),
    [
        ("loads", {"overload": 0.5}),
        ("loads", {"F_z": ["0 N", "2 N", "4 N"]}),
        ("require", {"footprint": "25 mm"}),
        ("goal", {"minimise": "beauty"}),
        ("vary", {"target.width": {"from": "1 mm"}}),
    ],
)
def test_what_is_refused_for_its_form_does_not(table: str, change: dict[str, Any]) -> None:
    """By the reader and by the schema, of values whose schema the models do not tell by themselves."""
    asked = tomllib.loads(next(path for path in FILES if path.stem == "fingertip").read_text())
    asked[table] = asked.get(table, {}) | change
    with pytest.raises(SceneError):
        requirements_of(asked, FILES[0].parent)
    assert not ASKED.is_valid(asked)


def test_every_key_is_described() -> None:
    """A reader of the schema finds no key without a word; components of a limit have their limit's."""
    schema = requirements_schema()
    parts = [schema, *(schema["$defs"][name] for name in ("loads", "require", "tolerance", "goal"))]
    assert [key for part in parts for key, entry in part["properties"].items() if not entry.get("description")] == []
