"""The schema of bench files holds rows that `read_measured` reads."""

from pathlib import Path

import numpy as np
from jsonschema import Draft202012Validator

from sits_mech.analysis.readings.measured import read_measured
from sits_mech.schemas.files import bench_schema

ROW = Draft202012Validator(bench_schema())


def test_rows_of_loads_and_of_poses(tmp_path: Path) -> None:
    """Headings with and without units; a text where a number belongs is refused."""
    headings = ["F_x [N]", "F_z", "L1 [uH]", "L_C2 [uH]"]
    rows = [[0.0, 0.0, 2.3, 2.3], [0.1, 1.0, 2.2, 2.3], [0.2, 1.0, 2.1, 2.2], [0.0, 2.0, 2.0, 2.2]]
    path = tmp_path / "bench.csv"
    path.write_text("\n".join(",".join(map(str, row)) for row in [headings, *rows]))
    found = read_measured(path, ("F_x", "F_z"), ("C1", "C2"))
    assert np.allclose(found.L[:, 0], 1e-6 * np.array([2.3, 2.2, 2.1, 2.0]), rtol=1e-12)
    for row in rows:
        ROW.validate(dict(zip(headings, row, strict=True)))
    assert ROW.is_valid({"d_v [mm]": 2.0, "alpha [deg]": 1.0, "code1": 38900874})
    assert ROW.is_valid({"F_z [N]": float("nan"), "depth [mm]": 0.1, "L1": 2e-6})
    assert not ROW.is_valid({"F_z [N]": "1 N", "L1": 2e-6}) and not ROW.is_valid({"depth [mm]": "1 mm", "L1": 2e-6})
    assert not ROW.is_valid({"F_z": 1.0})


def test_every_heading_is_known(tmp_path: Path) -> None:
    """To one pattern each."""
    patterns = ROW.schema["patternProperties"]
    assert len(patterns) == 15 and all("description" in entry for entry in patterns.values())
