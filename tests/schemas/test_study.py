"""The schema of study files holds what `read_study` reads, and refuses what that refuses for its form."""

import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from sits_mech.batch.studies.study import read_study
from sits_mech.scene.sensor import SceneError
from sits_mech.schemas.files import study_schema

STUDY = Draft202012Validator(study_schema())
GRID = """scene = "biorob2018"
request = "inductance"
combine = "product"
[vary]
"target.width" = ["8 mm", "15 mm"]
d_v = { from = "1 mm", to = "5 mm", count = 3 }
[fixed]
frequency = "5 MHz"
model = "planar"
"""
SAMPLES = """scene = ["biorob2018", "biorob2018-w15"]
request = "inductance"
combine = "sobol"
samples = 4
where = ["dv > 2 mm"]
[vary]
dv = { from = "1 mm", to = "5 mm" }
[derive]
dh = "0.1 * dv"
"""
ADAPTIVE = GRID.replace('"product"', '"adaptive"') + '[adaptive]\nof = "relative"\nwithin = 1e-3\nlimit = 0.9\n'
STAGES = """scene = "biorob2018"
request = "calibrate"
[vary]
"target.width" = ["8 mm", "15 mm"]
[fixed]
F_x = "-1 N:1 N:3"
fz = "0 N:2 N:3"
[[then]]
where = ["failed_loads < 1"]
least = "L_v_percent"
count = 3
request = "quality"
fixed.tolerance = 1e-2
[[then]]
largest = "resolution"
export = ["c", "page"]
"""


def read(text: str, folder: Path) -> None:
    """Read a study's text."""
    (folder / "study.toml").write_text(text)
    read_study(folder / "study.toml")


@pytest.mark.parametrize("text", [GRID, SAMPLES, ADAPTIVE, STAGES])
def test_what_is_read_holds_it(text: str, tmp_path: Path) -> None:
    """Grids, samples, what is refined, stages."""
    read(text, tmp_path)
    STUDY.validate(tomllib.loads(text))


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        (GRID, "d_v = {", "F_z = {"),
        (GRID, 'model = "planar"', 'model = "block"'),
        (GRID, "count = 3", "count = 1"),
        (SAMPLES, '["dv > 2 mm"]', '"dv > 2 mm"'),
        (SAMPLES, '"0.1 * dv"', "1"),
        (SAMPLES, '["biorob2018", "biorob2018-w15"]', "[]"),
        (ADAPTIVE, '"relative"', "[]"),
        (ADAPTIVE, "within = 1e-3", "within = 0"),
        (ADAPTIVE, "limit = 0.9", "limit = [0.9]"),
        (STAGES, "count = 3", "count = 0"),
        (STAGES, '["failed_loads < 1"]', "[]"),
        (STAGES, "tolerance = 1e-2", "tolerance = 1"),
        (STAGES, '"target.width" =', "F_y ="),
        (STAGES, '"-1 N:1 N:3"', '"-1 N:1 N"'),
    ],
)
def test_what_is_refused_for_its_form_does_not(text: str, old: str, new: str, tmp_path: Path) -> None:
    """By the reader and by the schema, of what the models do not tell by themselves."""
    assert old in text
    with pytest.raises(SceneError):
        read(text.replace(old, new), tmp_path)
    assert not STUDY.is_valid(tomllib.loads(text.replace(old, new)))


def test_every_key_is_described() -> None:
    """A reader of the schema finds no key without a word."""
    schema = study_schema()
    parts = [schema, *(schema["$defs"][name] for name in ("Adaptive", "StageTable"))]
    assert [key for part in parts for key, entry in part["properties"].items() if not entry.get("description")] == []
