"""Does what is written reach its place, and leave what stands there whole: links, devices, pipes, permissions?"""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from sits_mech.scene.files import replaced, write_bytes, write_text
from sits_mech.units import SceneError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="links, devices and pipes as POSIX has them")


def test_file_at_the_end_of_links_is_replaced_and_the_links_stay(tmp_path: Path) -> None:
    """A link to a link to a file elsewhere, relative and absolute."""
    (tmp_path / "there").mkdir()
    kept = tmp_path / "there" / "kept.csv"
    kept.write_text("old")
    (tmp_path / "near.csv").symlink_to(Path("there") / "kept.csv")
    (tmp_path / "link.csv").symlink_to(tmp_path / "near.csv")
    write_text(tmp_path / "link.csv", "new")
    assert (tmp_path / "link.csv").is_symlink() and (tmp_path / "near.csv").is_symlink()
    assert kept.read_text() == "new"


def test_link_to_nothing_makes_the_file_that_it_names(tmp_path: Path) -> None:
    (tmp_path / "link.csv").symlink_to("coming.csv")
    write_text(tmp_path / "link.csv", "new")
    assert (tmp_path / "coming.csv").read_text() == "new" and (tmp_path / "link.csv").is_symlink()


def test_circle_of_links_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").symlink_to("b.csv")
    (tmp_path / "b.csv").symlink_to("a.csv")
    with pytest.raises(SceneError, match=r"a\.csv: must be writable; got: "):
        write_text(tmp_path / "a.csv", "new")
    assert (tmp_path / "a.csv").is_symlink()


def test_device_takes_the_bytes_and_stays_a_device() -> None:
    write_bytes(Path(os.devnull), b"bytes")
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
def test_full_device_is_an_error_and_stays_a_device() -> None:
    with pytest.raises(SceneError, match=r"/dev/full: must be writable; got: No space left"):
        write_bytes(Path("/dev/full"), b"bytes")
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)


def test_pipe_takes_the_bytes_and_stays_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    came: list[bytes] = []
    reader = threading.Thread(target=lambda: came.append(pipe.read_bytes()))
    reader.start()
    write_bytes(pipe, b"bytes")
    reader.join(timeout=10)
    assert came == [b"bytes"] and pipe.is_fifo()


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout on this system")
def test_stdout_goes_on_where_it_was(tmp_path: Path) -> None:
    """What was printed before stays before, in a pipe and in a file."""
    code = "from pathlib import Path; from sits_mech.scene.files import write_text; print('head'); "
    command = [sys.executable, "-c", code + "write_text(Path('/dev/stdout'), 'body\\n'); print('tail')"]
    piped = subprocess.run(command, capture_output=True, text=True, check=True)
    assert piped.stdout == "head\nbody\ntail\n"
    with (tmp_path / "out").open("w") as stream:
        subprocess.run(command, stdout=stream, check=True)
    assert (tmp_path / "out").read_text() == "head\nbody\ntail\n"


def test_permissions_stay_and_new_files_get_the_usual_ones(tmp_path: Path) -> None:
    private, new = tmp_path / "private.csv", tmp_path / "new.csv"
    private.write_text("old")
    private.chmod(0o600)
    write_text(private, "new")
    write_text(new, "new")
    (tmp_path / "usual").touch()
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("private.csv", "new.csv", "usual")]
    assert modes[0] == 0o600 and modes[1] == modes[2]


def test_file_stays_whole_where_the_writing_fails(tmp_path: Path) -> None:
    path = tmp_path / "kept.csv"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), replaced(path) as other:
        other.write_text("half")
        raise ZeroDivisionError
    assert path.read_text() == "old" and sorted(tmp_path.iterdir()) == [path]
