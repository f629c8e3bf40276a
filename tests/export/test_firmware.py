"""The C header, compiled by the system's compiler: it gives the codes and the forces of the Python map, to one code."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.codes import readings
from sits_mech.export.firmware import code_calibration, code_table, header, write_header
from sits_mech.export.formats import export
from sits_mech.export.source import Source
from sits_mech.readout.calibration import AMBIGUOUS, OK, OUTSIDE, Calibration, calibration_of
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import changed

COMPILER = shutil.which("cc") or shutil.which("gcc") or ""
pytestmark = pytest.mark.skipif(not COMPILER, reason="no C compiler (cc or gcc)")
STATUS = {OK: 0, OUTSIDE: 1, AMBIGUOUS: 2}
PROGRAM = """
#include <inttypes.h>
#include <stdio.h>
#include "table.h"
int main(void)
{
    char what;
    int64_t a, b;
    while (scanf(" %c %" SCNd64 " %" SCNd64, &what, &a, &b) == 3) {
        uint32_t code[SITS_COILS] = {(uint32_t)a, (uint32_t)b};
        int32_t fx = 0, fz = 0;
        int status = what == 'c' ? sits_codes((int32_t)a, (int32_t)b, code) : sits_forces(code, &fx, &fz);
        if (what == 'c')
            printf("%d %" PRIu32 " %" PRIu32 "\\n", status, code[0], code[1]);
        else
            printf("%d %" PRId32 " %" PRId32 "\\n", status, fx, fz);
    }
    return (int)sits_registers[0][0] * 0 + (int)sits_rest[0] * 0;
}
"""


def compiled(folder: Path) -> Path:
    """Return the program around ``table.h`` in a folder; undefined behaviour stops it, warnings stop the compiler."""
    (folder / "main.c").write_text(PROGRAM.replace("table.h", (next(folder.glob("*.h"))).name))
    strict = ["-std=c99", "-O2", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsanitize=undefined"]
    trap = ["-fsanitize-undefined-trap-on-error"]
    done = subprocess.run(
        [COMPILER, *strict, *trap, "-o", "table", "main.c"], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return folder / "table"


def asked(program: Path, what: str, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return status and answers of the compiled program: forces [uN] to codes ("c"), or codes to forces ("f")."""
    lines = "\n".join(f"{what} {a} {b}" for a, b in np.rint(pairs).astype(np.int64))
    done = subprocess.run([str(program)], input=lines, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.returncode
    found = np.array([[int(word) for word in line.split()] for line in done.stdout.splitlines()])
    return found[:, 0], found[:, 1:]


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


@pytest.fixture(scope="module")
def program(source: Source, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its header, compiled."""
    folder = tmp_path_factory.mktemp("firmware")
    export(source, "c", folder / "table.h")
    return compiled(folder)


def forces(cal: Calibration, count: int, reach: float = 1.0) -> np.ndarray:
    """Return forces [N] all over the table, corners and edges among them."""
    half, middle = 0.5 * (cal.high - cal.low), 0.5 * (cal.high + cal.low)
    inside = np.random.default_rng(7).uniform(-reach, reach, (count, 2))
    edge = np.array([[x, z] for x in (-1, -0.5, 0, 1) for z in (-1, 0.3, 1)], dtype=float) * reach
    return middle + half * np.vstack([inside, edge])


def test_codes_agree_to_one(source: Source, program: Path) -> None:
    """Forward: forces in micronewtons to codes, against the map through the same loads."""
    cal = code_calibration(source)
    asked_for = np.rint(1e6 * forces(cal, 2000))
    status, codes = asked(program, "c", asked_for)
    expected = cal.forward(*(1e-6 * asked_for).T)
    assert np.all(status == 0) and np.abs(codes - expected).max() <= 1.0
    assert np.abs(codes - np.rint(expected)).max() <= 1


def test_inverse_agrees_to_one_code(source: Source, program: Path) -> None:
    """Backward: the forces differ from those of the Python inverse by what one code is worth, wherever that answers."""
    cal = code_calibration(source)
    codes = np.rint(cal.forward(*forces(cal, 2000, 0.99).T))
    status, found = asked(program, "f", codes)
    exact = cal.inverse(codes)
    assert np.all(exact.status == OK) and np.all(status == 0)
    apart = cal.slopes(*exact.forces.T) @ (1e-6 * found - exact.forces)[:, :, None]
    assert np.abs(apart).max() <= 1.0
    assert np.abs(cal.forward(*(1e-6 * found).T) - codes).max() <= 1.0


def test_round_trip_on_the_device(program: Path, source: Source) -> None:
    """Forces to codes to forces by the compiled code alone: back within what half a code of each coil is worth."""
    cal = code_calibration(source)
    asked_for = np.rint(1e6 * forces(cal, 500))
    _, codes = asked(program, "c", asked_for)
    status, found = asked(program, "f", codes)
    inverse = np.abs(np.linalg.inv(cal.slopes(*(1e-6 * asked_for).T)))
    assert np.all(status == 0) and np.all(1e-6 * np.abs(found - asked_for) <= 0.6 * inverse.sum(axis=2) + 1e-6)


def test_what_is_outside(source: Source, program: Path) -> None:
    """Beyond the table, no codes of a coil at all, the far ends of the integers: refused, nothing overflows."""
    cal = code_calibration(source)
    half, middle = 0.5 * (cal.high - cal.low), 0.5 * (cal.high + cal.low)
    for x, z in ((1.1, 0.0), (-1.1, 0.0), (0.0, 1.1), (0.0, -1.1), (1.2, -1.2)):
        there = middle + half * np.array([x, z])
        assert asked(program, "c", 1e6 * there[None])[0] == STATUS[OUTSIDE]
        codes = np.rint(cal.forward(*there))[None]
        assert asked(program, "f", codes)[0] == STATUS[str(cal.inverse(codes).status[0])] == STATUS[OUTSIDE]
    wild = np.array([[0, 0], [2**28 - 1, 0], [0, 2**28 - 1], [2**28 - 1, 2**28 - 1], [2**32 - 1, 2**32 - 1]])
    assert np.all(asked(program, "f", wild)[0] != 0)
    ends = np.array([[-(2**31), -(2**31)], [2**31 - 1, 2**31 - 1], [0, -(2**31)]])
    assert np.all(asked(program, "c", ends)[0] == STATUS[OUTSIDE])


def test_a_map_that_folds_is_refused_where_it_does(source: Source, tmp_path: Path) -> None:
    """code_1 = x, code_2 = (z - 0.6)^2 over [0, 1]^2, scaled: z above 0.2 has a twin, the rest one answer."""
    x, z = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9), indexing="ij")
    points = np.stack([x, z], -1).reshape(-1, 2)
    codes = 4e7 + 1e5 * np.stack([points[:, 0], (points[:, 1] - 0.6) ** 2 + 1e-3 * points[:, 0]], -1)
    cal = calibration_of(points, codes, forces=("F_x", "F_z"), coils=("C1", "C2"), free=("code", [np.nan, np.nan]))
    (tmp_path / "table.h").write_text(header(source, code_table(cal)))
    program = compiled(tmp_path)
    below = np.column_stack([np.linspace(0.1, 0.9, 9), np.full(9, 0.08)])
    status, found = asked(program, "f", np.rint(cal.forward(*below.T)))
    assert np.all(status == 0) and np.abs(1e-6 * found - below).max() < 1e-4
    above = np.column_stack([np.linspace(0.1, 0.9, 9), np.full(9, 0.45)])
    codes = np.rint(cal.forward(*above.T))
    assert np.all(cal.inverse(codes).status == AMBIGUOUS)
    assert np.all(asked(program, "f", codes)[0] == STATUS[AMBIGUOUS])


def test_table_is_fine_enough(source: Source) -> None:
    """The table is refined until it follows the map to a quarter of a code; a coarser one does not."""
    found = code_table(code_calibration(source))
    assert found.error <= 0.25 and np.all(found.cells == 0) and found.table.shape[1] > 9
    assert np.abs(found.table).max() < 2**22


def test_says_what_its_table_is_worth(source: Source, tmp_path: Path) -> None:
    """code = C L^-1/2: a load's error is half its relative error of L, in codes; the header and the notes say it."""
    read = readings(source.sensor, source.data)
    off = float(np.max(0.5 * read.codes * read.error_L / read.L))
    notes = write_header(source, tmp_path / "table.h")
    assert notes[2].startswith(f"the loads' own estimated errors are up to {off:.3g} codes: ")
    assert f"own estimated errors are up to {off:.3g} codes" in (tmp_path / "table.h").read_text(encoding="utf-8")


def test_failed_loads_are_outside(source: Source, tmp_path: Path) -> None:
    """Without the loads of a corner the header still stands, and refuses readings of that corner."""
    data = source.data.copy(deep=True)
    data["status"] = data["status"].astype(object)
    for x, z in ((4, 3), (4, 2), (3, 3)):
        data["status"][x, z] = "stalled"
    assert write_header(Source(source.sensor, data), tmp_path / "table.h")[-1].endswith("no results")
    cal = code_calibration(source)
    codes = np.rint(cal.forward([1.0, 0.0], [3.0, 1.0]))
    assert list(asked(compiled(tmp_path), "f", codes)[0]) == [STATUS[OUTSIDE], 0]


def test_what_has_no_header(source: Source, tmp_path: Path) -> None:
    """No converter, one coil, one force: one line each."""
    alone = source.data.isel(coil=[0], coil_2=[0])
    cases: list[tuple[Source, str]] = [
        (Source(changed(source.sensor, ['readout.converter="none"']), source.data), "must have codes of a converter"),
        (Source(source.sensor.model_copy(update={"coils": source.sensor.coils[:1]}), alone), "two coils.*got 1 coils"),
        (Source(source.sensor, source.data.isel(F_x=[2])), "several values of both forces; got 2 coils and 1 x 4"),
    ]
    for case, message in cases:
        assert isinstance(case.data, xr.Dataset)
        with pytest.raises(ValueError, match=message):
            export(case, "c", tmp_path / "t.h")
