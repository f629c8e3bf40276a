"""Models that other packages announce: found by their half, from installed metadata, and by the command line."""

import os
import subprocess
import sys
from pathlib import Path

from sits_mech.plugins import plugged

PACKAGE = """
[sits_mech.magnetics]
image = sits_mech_image:IMAGE
[sits_mech.exports]
other = sits_mech_image:OTHER
"""


def test_nothing_is_announced_by_this_package() -> None:
    """Its own models stand in tables."""
    assert plugged("mechanics") == ()


def test_a_package_beside_is_found(tmp_path: Path) -> None:
    """By the half that it announces a model of, its name and its place; other groups are not models."""
    about = tmp_path / "sits_mech_image-1.0.dist-info"
    about.mkdir()
    (about / "entry_points.txt").write_text(PACKAGE)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: sits-mech-image\nVersion: 1.0\n")
    script = "from sits_mech.plugins import plugged; print([(e.name, e.value) for e in plugged('magnetics')])"
    here = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])}
    done = subprocess.run([sys.executable, "-c", script], env=here, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[('image', 'sits_mech_image:IMAGE')]"
