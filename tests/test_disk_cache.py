"""What is kept between commands: comes back bit for bit, is made anew where it does not, and has an end."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sits_mech import disk_cache
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space import divisions
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import load_sensor


@pytest.fixture
def where(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep in a folder of the test's own."""
    monkeypatch.setenv(disk_cache.VARIABLE, str(tmp_path / "kept"))
    return tmp_path / "kept"


def numbers(asked: object, made: list[int], value: float = 1.0) -> Any:
    """Return two numbers, kept by what is asked; `made` counts how often they are made."""

    def make() -> list[float]:
        made.append(1)
        return [value, 2.0]

    pack, unpack = (lambda each: {"values": np.array(each)}), (lambda file: file["values"].tolist())
    return disk_cache.kept(asked, make, pack, unpack, __name__)


def test_an_answer_is_the_same_to_the_bit(where: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a plate in space, and the second time no modes are found."""
    sensor, pose = load_sensor("biorob2018"), Pose(0.0, 2e-3, 0.02)

    def answer() -> Any:
        divisions.prepared.cache_clear()
        return sheets(sensor, 1e-1).impedance(pose, 5e6)

    first = answer()
    assert len(disk_cache.kept_files()) == 1
    monkeypatch.setattr(divisions, "prepare_sheets", None)
    second = answer()
    for name in ("L", "R", "error_L", "error_R"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert first.report.unknowns == second.report.unknowns


def test_what_differs_in_anything_is_another(where: Path) -> None:
    made: list[int] = []
    for asked in ((1.0, "a"), (1.0, "b"), (1, "a"), (np.ones(2), "a"), (np.ones((1, 2)), "a"), ((1.0,), "a"), (None,)):
        numbers(asked, made)
        assert numbers(asked, made, value=9.0) == [1.0, 2.0]
    assert len(made) == len(disk_cache.kept_files()) == 7
    with pytest.raises(TypeError, match="a dict has no checksum"):
        numbers({}, made)


MAKERS = "magnetics.space.divisions", "magnetics.coils.resistance", "mechanics.linear", "analysis.bench.force_maps"


@pytest.mark.parametrize("maker", MAKERS)
def test_all_that_makes_arrays_is_in_their_name(maker: str) -> None:
    """Every module of ours that an import of the maker brings, but packages without code; not all that there is."""
    code = f"import sys, sits_mech.{maker}; print(*(name for name in sys.modules if name.startswith('sits_mech.')))"
    brought = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    found = disk_cache.sources(f"sits_mech.{maker}")
    places = {name: Path(disk_cache.__file__).parent.joinpath(*name.split(".")[1:]) / "__init__.py" for name in brought}
    empty = {name for name, path in places.items() if path.exists() and path.read_text().count("\n") <= 1}
    assert {*brought} - {*found} - empty == set() and not any(name.startswith("sits_mech.cli") for name in found)


def test_other_sources_and_other_libraries_make_another(where: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []
    for part, name, other in (
        (disk_cache, "ROOM", 2**40), (np, "__version__", "0"),
        (disk_cache, "sources", lambda module: {module: b"x = 1"}),
        (disk_cache, "sources", lambda module: {module: b"x = 2"}),
    ):
        monkeypatch.setattr(part, name, other)
        disk_cache._source.cache_clear()
        assert numbers("a", made) == numbers("a", made)
    disk_cache._source.cache_clear()
    assert len(made) == 4


def test_a_file_that_is_cut_short_is_made_anew(where: Path) -> None:
    made: list[int] = []
    numbers("a", made)
    (path,) = disk_cache.kept_files()
    for content in (path.read_bytes()[:40], b"", b"not an archive"):
        path.write_bytes(content)
        assert numbers("a", made) == [1.0, 2.0]
    assert len(made) == 4 and numbers("a", made) == [1.0, 2.0] and len(made) == 4


def test_a_file_in_the_place_of_another_is_made_anew(where: Path) -> None:
    made: list[int] = []
    numbers("a", made), numbers("b", made, value=5.0)
    first, second = disk_cache.kept_files()
    first.rename(where / "aside"), second.rename(first), (where / "aside").rename(second)
    assert numbers("a", made, value=1.0) == [1.0, 2.0] and numbers("b", made, value=5.0) == [5.0, 2.0]
    assert len(made) == 4


def test_the_oldest_go_where_there_is_no_room(where: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one that was read last is the youngest."""
    made: list[int] = []
    for k in range(3):
        numbers(k, made)
    for age, path in enumerate(disk_cache.kept_files()):
        os.utime(path, (1e9 + age, 1e9 + age))
    oldest = disk_cache.kept_files()[0]
    monkeypatch.setattr(disk_cache, "ROOM", 3 * oldest.stat().st_size)
    numbers(3, made)
    assert len(disk_cache.kept_files()) == 3 and not oldest.exists()
    assert disk_cache.clear() == 3 and not disk_cache.kept_files()


def test_nothing_is_kept_where_nothing_can_be(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made: list[int] = []
    file = tmp_path / "file"
    file.write_text("no folder")
    for name in (disk_cache.OFF, "", str(file)):
        monkeypatch.setenv(disk_cache.VARIABLE, name)
        assert numbers("a", made) == numbers("a", made) == [1.0, 2.0]
    assert len(made) == 6


def test_the_users_folder_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(disk_cache.VARIABLE)
    assert disk_cache.folder() is None
    disk_cache.keep_by_default()
    assert (where := disk_cache.folder()) is not None and where.name == "sits-mech"
    disk_cache.keep_nothing()
    assert disk_cache.folder() is None
    disk_cache.keep_by_default()
    assert disk_cache.folder() is None
