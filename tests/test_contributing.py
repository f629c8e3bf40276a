"""What CONTRIBUTING shows as a diff does what it says: applied to a copy of the package, the new part works."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DIFFS = re.findall(r"```diff\n(.*?)```", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), flags=re.DOTALL)
WORKS = {  # by a word of the diff: what then holds, and how many files it touches at most
    "EXAMPLE": (1, """
from sits_mech.readout.converter import converter
from sits_mech.schemas.scene import scene_schema
sensor = sm.load_sensor("biorob2018", ['readout.converter="EXAMPLE"'])
assert converter(sensor.readout.converter).channels == 1
assert "EXAMPLE" in str(scene_schema())
"""),
    "QUADRATIC": (2, """
from sits_mech.mechanics.linear import linear_layer
table = 'elastomer.material={law="quadratic", c10="10 kPa", c20="1 kPa", bulk_modulus="20 MPa"}'
sensor = sm.load_sensor("biorob2018", [table])
assert sensor.elastomer.silicone.shear_modulus == 2e4
one = linear_layer(sensor, 0.1).equilibrium(sm.Wrench(F_z=0.1)).pose.d_v
same = sm.load_sensor("biorob2018", [table.replace("quadratic", "yeoh").replace("bulk", "c30=0.0, bulk")])
assert one == linear_layer(same, 0.1).equilibrium(sm.Wrench(F_z=0.1)).pose.d_v
"""),
}


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
@pytest.mark.parametrize(
    "word", [pytest.param(each, marks=[pytest.mark.slow] * (each == "EXAMPLE")) for each in WORKS]
)
def test_a_part_is_added_as_shown(word: str, tmp_path: Path) -> None:
    (diff,) = (each for each in DIFFS if word in each)
    most, code = WORKS[word]
    assert diff.count("\n+++ ") + diff.startswith("+++ ") <= most
    shutil.copytree(ROOT / "sits_mech", tmp_path / "sits_mech", ignore=shutil.ignore_patterns("__pycache__"))
    subprocess.run(["git", "apply", "-"], input=diff, text=True, cwd=tmp_path, check=True, timeout=60)
    here = os.environ | {"PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-c", f"import sits_mech as sm\n{code}"]
    done = subprocess.run(command, cwd=tmp_path, env=here, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


def test_every_diff_is_tried() -> None:
    assert len(DIFFS) == len(WORKS)
