"""One header for all units: constants of a built sensor at run time, a tare, a known force, those of another header."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.built.constants import Constants, as_computed
from sits_mech.analysis.readings.bench import code_calibration
from sits_mech.export.firmware import unit_header, write_header
from sits_mech.export.source import Source
from sits_mech.readout.calibration import OK
from sits_mech.report.folder import read_calibration
from tests.export.test_firmware import COMPILER, STATUS, STRICT, TRAP, inside

pytestmark = pytest.mark.skipif(not COMPILER, reason="no C compiler (gcc or cc)")
PROGRAM = """
#include <inttypes.h>
#include <stdio.h>
#include "table.h"
#include "unit.h"
int main(void)
{
    sits_unit unit = SITS_UNIT, other = SITS_NOMINAL;
    int64_t what, a, b;
    other.id ^= 1;
    while (scanf("%" SCNd64 " %" SCNd64 " %" SCNd64, &what, &a, &b) == 3) {
        uint32_t code[SITS_COILS] = {(uint32_t)a, (uint32_t)b};
        int32_t force[SITS_FORCES] = {0}, known[SITS_FORCES] = {(int32_t)a, (int32_t)b};
        int status = SITS_OK;
        if (what == 0)
            status = sits_unit_forces(&unit, code, force);
        if (what == 1)
            sits_unit_tare(&unit, code);
        if (what == 2) {
            int32_t read[SITS_FORCES] = {known[0] - known[0] / 5, known[1] - known[1] / 5};
            status = sits_unit_span(&unit, read, known);
        }
        if (what == 3)
            status = sits_unit_forces(&other, code, force);
        printf("%d %" PRId32 " %" PRId32 "\\n", status, force[0], force[1]);
    }
    return (int)sits_registers[0][0] * 0 + (int)sits_rest[0] * 0;
}
"""


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


@pytest.fixture(scope="module")
def unit(source: Source) -> Constants:
    """A unit with everything off."""
    cal = code_calibration(source.sensor, source.data)
    factor, shift = np.array([[1.2, 0.01], [-0.3, 1.1]]), np.array([0.05, -0.2])
    rest = cal.forward(np.linalg.solve(factor, -shift), beyond=True)
    offset, gain = np.array([2.5e4, -4.1e4]), np.array([0.13, -0.21])
    return Constants(as_computed(cal).base, offset, gain, rest, shift, factor, np.zeros(2))


@pytest.fixture(scope="module")
def program(source: Source, unit: Constants, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Header and constants, compiled."""
    folder = tmp_path_factory.mktemp("units")
    write_header(source, folder / "table.h")
    (folder / "unit.h").write_text(unit_header("a unit /* with a name", source, unit))
    (folder / "main.c").write_text(PROGRAM)
    command = [COMPILER, *STRICT, *TRAP, "-o", "table", "main.c"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return folder / "table"


def asked(program: Path, rows: list[tuple[int, float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Return status and forces [N] of rows of what is asked and its two numbers."""
    lines = "\n".join(f"{what} {round(a)} {round(b)}" for what, a, b in rows)
    done = subprocess.run([str(program)], input=lines, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.returncode
    found = np.array([[int(word) for word in line.split()] for line in done.stdout.splitlines()])
    return found[:, 0], 1e-6 * found[:, 1:]


def codes_of(source: Source, unit: Constants, f: np.ndarray) -> np.ndarray:
    """Return the codes that the unit shows where the calibrated sensor bears f."""
    x = code_calibration(source.sensor, source.data).forward(f)
    return np.asarray((x - unit.offset + unit.gain * unit.base) / (1.0 + unit.gain))


def test_constants_make_a_unit_of_the_calibrated_sensor(source: Source, unit: Constants, program: Path) -> None:
    """Forces by its constants, to what a rounded code is worth; refused by those of another header."""
    cal = code_calibration(source.sensor, source.data)
    f = inside(cal, 300, 0.9)
    codes = codes_of(source, unit, f)
    status, forces = asked(program, [(0, *row) for row in codes])
    assert np.all(STATUS[status] == OK)
    worth = np.abs(unit.factor) @ np.abs(np.linalg.inv(cal.slopes(f))).sum(axis=2)[..., None]
    assert np.all(np.abs(forces - unit.forces(f)) <= 1.2 * worth[..., 0] + 5e-6)
    assert asked(program, [(3, *codes[0])])[0][0] == 4


def test_a_tare_and_a_known_force(source: Source, unit: Constants, program: Path) -> None:
    """Drifted codes read as before after a tare; a known force of 1.25 makes all forces as much larger, not of five."""
    f = np.linalg.solve(unit.factor, -unit.shift)[None]
    rest, there = codes_of(source, unit, np.concatenate([f, f + [0.2, 0.6]]))
    drift = np.array([900.0, -400.0])
    status, forces = asked(program, [
        (0, *rest), (0, *there), (1, *(rest + drift)), (0, *(rest + drift)), (0, *(there + drift)), (2, 5e4, 5e5),
        (0, *(there + drift)), (2, 0, 10),
    ])
    assert forces[0] == pytest.approx(0.0, abs=2e-4) and np.all(status[:-1] == 0) and status[-1] == 3
    assert forces[3:5] == pytest.approx(forces[:2], abs=2e-4)
    assert forces[6] == pytest.approx(1.25 * forces[4], abs=5e-6)
