"""The C header of cells, compiled by the system's compiler: forces of Python to rounding, no overflow, what it says."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from sits_mech.cli.main import run
from sits_mech.export.cells import cells_header, inverse_integers
from sits_mech.units import SceneError
from tests.chain.cells.test_forces import made, mixed
from tests.export.test_firmware import COMPILER, STRICT, TRAP

pytestmark = pytest.mark.skipif(not COMPILER, reason="no C compiler (gcc or cc)")
PROGRAM = """
#include <inttypes.h>
#include <stdio.h>
#include "cells.h"
int main(void)
{
    int32_t read[SITS_CELLS][SITS_CELL_FORCES], force[SITS_CELLS][SITS_CELL_FORCES] = {{0}};
    int32_t *each = &read[0][0];
    for (int i = 0;; i = 0) {
        for (; i < SITS_CELLS * SITS_CELL_FORCES; ++i)
            if (scanf("%" SCNd32, &each[i]) != 1)
                return 0;
        int status = sits_cell_forces(read, force);
        printf("%d", status);
        for (i = 0; i < SITS_CELLS * SITS_CELL_FORCES; ++i)
            printf(" %" PRId32, force[i / SITS_CELL_FORCES][i % SITS_CELL_FORCES]);
        printf(" %d\\n", sits_cell_forces(read, read) != status || (status == 0 && read[1][0] != force[1][0]));
    }
}
"""
ORDER = [1, 0]  # F_x before F_z, as in firmware


def asked(folder: Path, header: str, rows: np.ndarray) -> np.ndarray:
    """Return status, forces and whether it differs in place, of readings (k, 4) of the compiled header."""
    (folder / "cells.h").write_text(header)
    (folder / "main.c").write_text(PROGRAM)
    flags = [*STRICT, "-Wcast-qual", "-Wsign-conversion", *TRAP, "-o", "cells", "main.c"]
    done = subprocess.run([COMPILER, *flags], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    lines = "\n".join(" ".join(map(str, row)) for row in rows)
    done = subprocess.run([folder / "cells"], input=lines, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.returncode  # undefined behaviour stops it
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=np.int64)


@pytest.mark.parametrize("scale", [1.0, 40.0])
def test_forces_are_those_of_python_to_rounding(tmp_path: Path, scale: float) -> None:
    """Of a mixing near one, and one whose inverse is as large that it has fewer bits."""
    found = made(mixed() / scale, 0.0, 1.0)
    header, random = cells_header(found, "*/ two cells /*"), np.random.default_rng(3)
    read = random.integers(-(10**6), 10**6, size=(40, 2, 2)) * 1e-6
    answer = asked(tmp_path, header, np.rint(1e6 * read[..., ORDER]).astype(int).reshape(-1, 4))
    force = np.nan_to_num(1e6 * found.forces(read)[0][..., ORDER].reshape(-1, 4))
    stated = float(re.search(r"Integers are off by up to (\S+) uN", header)[1])
    assert not np.any(answer[:, 0]) and not np.any(answer[:, 5])
    off = np.abs(answer[:, 1:5] - force).max()
    assert off < 1.01 * stated < 2.0 and not np.any(answer[:, 1])  # A reads no F_x


def test_no_reading_overflows(tmp_path: Path) -> None:
    """The largest integers either fit or are refused, and leave forces as they are."""
    ends = np.array(np.meshgrid(*[[-(2**31), 0, 2**31 - 1]] * 4)).reshape(4, -1).T
    found = made(mixed(), 0.0)
    answer = asked(tmp_path, cells_header(found, "two"), ends)
    force = np.nan_to_num(found.forces(ends.reshape(-1, 2, 2)[..., ORDER])[0][..., ORDER].reshape(-1, 4))
    fits = np.all(np.abs(force) < 2.0**31 - 0.5, axis=1)
    assert np.array_equal(answer[:, 0] == 0, fits) and 0 < fits.sum() < len(fits) and not np.any(answer[:, 5])


def test_rows_are_as_long_as_sums_of_products_allow() -> None:
    """Half of the room at least is used, but beyond 30 bits; an inverse without any is refused."""
    for size in (0.1, 1.0, 3.0, 1e3, 1e6):
        M = size * np.random.default_rng(0).normal(size=(6, 6))
        N, bits = inverse_integers(M)
        most = np.abs(N).sum(axis=1).max()
        assert most < 2**31 and (bits == 30 or most > 2**29) and np.abs(N - M * 2.0**bits).max() <= 0.5
    with pytest.raises(SceneError, match="rows below"):
        inverse_integers(np.full((2, 2), 1e12))


def test_it_says_what_cells_read_and_by_how_much_forces_are_off() -> None:
    found = made(mixed(), 0.01, 0.5)
    text = cells_header(found, "two cells")
    own = 0.5e3 * max(found.by_mixing[i, :, i].max() for i in range(2))
    others = 0.5e3 * max(found.by_mixing[0, :, 1].max(), found.by_mixing[1, :, 0].max())
    assert f"{own:.3g} mN and {others:.3g} mN by the errors of A" in text
    assert "F_x of A" in text and "one for each of\n * A; B: each in a file of C of its own" in text
    assert all(f"by {name}, which" in text for name in ("F_x", "F_y")) and "by F_z, which" not in text
    assert max(map(len, text.splitlines())) <= 122
    found.finite_strain[:] = np.inf
    assert "not bounded by finite strain" in cells_header(found, "two cells")


def test_a_touch_and_a_folder_that_is_not_there_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text("")
    assert run(["cells", str(scene), "--header", str(tmp_path / "none" / "cells.h")]) == 2
    assert "--header: must be in a folder that exists" in capsys.readouterr().err
