"""Tables on the disk: what is written comes back, what is none is refused."""

import os
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.store import glance, read_table, save_table
from sits_mech.units import SceneError

TABLE = xr.Dataset(
    {"root": (("a", "b"), [[1.0, np.nan, 2.0], [0.5, 1.5, -1.0]]), "status": (("a", "b"), [["ok", "failed", "ok"]] * 2),
     "reason": (("a", "b"), [["", "must be positive; got -1 µm", ""]] * 2)},
    {"a": [1.0, 2.0], "b": ["x", "y", "z"]}, {"name": "two by three"},
)


def test_tables_survive_the_disk(tmp_path: Path) -> None:
    """Numbers, texts and missing values; nothing but the file is left behind."""
    path = tmp_path / "result.nc"
    save_table(TABLE, path)
    assert read_table(path).identical(TABLE) and os.listdir(tmp_path) == ["result.nc"]
    with pytest.raises(SceneError, match="must be writable"):
        save_table(TABLE, tmp_path / "nowhere" / "result.nc")
    with pytest.raises(SceneError, match="must be a table"):
        read_table(tmp_path / "absent.nc")


def test_damaged_tables_are_refused(tmp_path: Path) -> None:
    """Whatever netCDF raises where a byte is another one; numbers have no checksum."""
    path, refused = tmp_path / "result.nc", 0
    save_table(TABLE, path)
    sound = path.read_bytes()
    for place in range(100, len(sound), len(sound) // 30):
        path.write_bytes(sound[:place] + bytes([sound[place] ^ 255]) + sound[place + 1 :])
        try:
            glance(path)
            read_table(path)
        except SceneError as error:
            assert "must be a table of this package; got: " in str(error)
            refused += 1
    assert refused > 0


def test_a_glance_tells_attributes_and_cases(tmp_path: Path) -> None:
    """Without the numbers; a table without status has no cases."""
    save_table(TABLE, tmp_path / "result.nc")
    assert glance(tmp_path / "result.nc") == ({"name": "two by three"}, 6)
    save_table(TABLE.drop_vars("status"), tmp_path / "result.nc")
    assert glance(tmp_path / "result.nc")[1] == 0
