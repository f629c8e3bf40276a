"""The schema of study files holds what `read_study` reads, and no more arguments than requests have."""

import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from sits_mech.batch.studies.study import read_study
from sits_mech.scene.sensor import SceneError
from sits_mech.schemas.study import study_schema

STUDY = Draft202012Validator(study_schema())
GOOD = """scene = "biorob2018"
request = "inductance"
combine = "product"
[vary]
"target.width" = ["8 mm", "15 mm"]
dv = { from = "1 mm", to = "5 mm", count = 3 }
[fixed]
frequency = "5 MHz"
model = "planar"
"""


def agree(text: str, good: bool, folder: Path) -> None:
    """Check that schema and reader both take a study's text, or both refuse it."""
    assert STUDY.is_valid(tomllib.loads(text)) == good
    (folder / "study.toml").write_text(text)
    if good:
        read_study(folder / "study.toml")
    else:
        with pytest.raises(SceneError):
            read_study(folder / "study.toml")


@pytest.mark.parametrize(
    ("old", "new", "good"),
    [
        ("", "", True),
        ('"inductance"', '"resistance"', False),
        ("count = 3", "count = 1", False),
        ('dv = { from = "1 mm", to = "5 mm", count = 3 }', "", False),
        ('dv = { from = "1 mm", to = "5 mm", count = 3 }', 'fz = ["1 N"]', False),
        ("dv = {", "d_v = {", True),
        ("dv = {", "F_z = {", False),
        ('model = "planar"', 'model = "block"', False),
        ('model = "planar"', "tolerance = 1e-3", True),
        ('combine = "product"', 'combine = "all"', False),
        ('combine = "product"', 'mode = "all"', False),
    ],
)
def test_the_reader_and_the_schema_agree(old: str, new: str, good: bool, tmp_path: Path) -> None:
    """On a study of poses and on what may be wrong in it."""
    agree(GOOD.replace(old, new), good, tmp_path)


def test_ranges_stand_under_fixed() -> None:
    """Of a calibration, whose loads are ranges."""
    table = {"scene": "biorob2018", "request": "calibrate", "vary": {"target.width": ["8 mm"]}}
    assert STUDY.is_valid(table | {"fixed": {"fx": "-1 N:1 N:3", "fz": "0 N:2 N:3"}})
    assert not STUDY.is_valid(table | {"fixed": {"fx": "-1 N:1 N:3"}})
    assert STUDY.is_valid(table | {"fixed": {"F_x": "-1 N:1 N:3", "fz": "0 N:2 N:3"}})
    assert not STUDY.is_valid(table | {"vary": {"F_x": ["1 N"]}, "fixed": {"fx": "0 N:1 N:3", "fz": "0 N:2 N:3"}})
    assert not STUDY.is_valid(table | {"vary": {"fx": ["1 N"]}, "fixed": {"fz": "0 N:2 N:3"}})


SAMPLES = GOOD.replace('"product"', '"sobol"\nsamples = 4').replace(", count = 3", "")


@pytest.mark.parametrize(
    ("old", "new", "good"),
    [
        ("", "", True),
        ("samples = 4", "", False),
        ("samples = 4", "samples = 4\nseed = 1", True),
        ("samples = 4", "samples = 0", False),
        ('"sobol"', '"product"', False),
        ('to = "5 mm"', 'to = "5 mm", count = 3', False),
        ("samples = 4", 'samples = 4\nwhere = ["dv > 2 mm"]', True),
        ("samples = 4", 'samples = 4\nwhere = "dv > 2 mm"', False),
        ('"sobol"', '"saltelli"\nwhere = ["dv > 2 mm"]', False),
        ('"biorob2018"', '["biorob2018", "biorob2018-w15"]', True),
        ('"biorob2018"', "[]", False),
        ("[fixed]", '[derive]\ndh = "0.1 * dv"\n[fixed]', True),
        ("[fixed]", "[derive]\ndh = 1\n[fixed]", False),
        ("[fixed]", '[derive]\nfz = "dv"\n[fixed]', False),
        ('dv = { from = "1 mm", to = "5 mm" }', '[derive]\ndv = "0.2 * target.width"', True),
    ],
)
def test_they_agree_on_samples_too(old: str, new: str, good: bool, tmp_path: Path) -> None:
    """And on conditions, derived keys, several scenes."""
    agree(SAMPLES.replace(old, new), good, tmp_path)


ADAPTIVE = GOOD.replace('"product"', '"adaptive"') + '[adaptive]\nof = "relative"\nwithin = 1e-3\n'


@pytest.mark.parametrize(
    ("old", "new", "good"),
    [
        ("", "", True),
        ("within = 1e-3", "within = 0", False),
        ("within = 1e-3", 'within = "1 %"', False),
        ("within = 1e-3", "", False),
        ("within = 1e-3", "within = 1e-3\nlimit = 0.9", True),
        ("within = 1e-3", 'within = 1e-3\nlimit = "0.4 uH"', True),
        ("within = 1e-3", "within = 1e-3\nlimit = [0.9]", False),
        ("within = 1e-3", "within = 1e-3\nmost = 9", False),
        ('"relative"', '["relative", "L"]', True),
        ('"relative"', "[]", False),
        ('"relative"\nwithin = 1e-3', '["relative", "L"]\nwithin = 1e-3\nlimit = 1', False),
        ('"adaptive"', '"zip"', False),
        ('combine = "adaptive"', "", False),
        ('combine = "adaptive"', 'combine = "adaptive"\nwhere = ["dv > 2 mm"]', False),
        ("[fixed]", '[derive]\ndh = "0.1 * dv"\n[fixed]', False),
        ('[adaptive]\nof = "relative"\nwithin = 1e-3\n', "", False),
        ("[adaptive]", "[adaptively]", False),
    ],
)
def test_they_agree_on_what_is_refined(old: str, new: str, good: bool, tmp_path: Path) -> None:
    """And up to what."""
    agree(ADAPTIVE.replace(old, new), good, tmp_path)


STAGES = """scene = "biorob2018"
request = "calibrate"
[vary]
"target.width" = ["8 mm", "15 mm"]
[fixed]
fx = "-1 N:1 N:3"
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


@pytest.mark.parametrize(
    ("old", "new", "good"),
    [
        ("", "", True),
        ("count = 3", "count = 0", False),
        ("count = 3", "", True),
        ('least = "L_v_percent"', "", False),
        ('least = "L_v_percent"\ncount = 3', "", True),
        ('largest = "resolution"', 'largest = "resolution"\nleast = "resolution"', False),
        ('["failed_loads < 1"]', '"failed_loads < 1"', False),
        ('["failed_loads < 1"]', "[]", False),
        ('request = "quality"\nfixed', 'request = "qality"\nfixed', False),
        ('request = "quality"\nfixed', "fixed", False),
        ('export = ["c", "page"]', 'export = "c"', False),
        ('export = ["c", "page"]', 'export = ["c"]\nrequest = "quality"', False),
        ('export = ["c", "page"]', 'export = ["c"]\nfixed.tolerance = 0.1', False),
        ('export = ["c", "page"]', "", False),
        ("count = 3", "most = 3", False),
        ("[[then]]\nwhere", "[then]\nwhere", False),
    ],
)
def test_they_agree_on_stages(old: str, new: str, good: bool, tmp_path: Path) -> None:
    """And on what they may ask."""
    text = STAGES.replace(old, new)
    agree(text if "[then]" not in text.replace("[[then]]", "") else text.partition("[[then]]")[0], good, tmp_path)
