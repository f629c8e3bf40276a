"""The evaluator in C99, compiled by the system's compiler in both precisions: the numbers of the one in Python."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sits_mech.export.source import Source
from sits_mech.export.twin.folder import c_tables, write_twin
from sits_mech.export.twin.twin import Twin
from sits_mech.report.folder import read_calibration
from sits_mech.silicone.history import retardation

COMPILER = shutil.which("cc") or shutil.which("gcc") or ""
pytestmark = pytest.mark.skipif(not COMPILER, reason="no C compiler (cc or gcc)")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-O1", "-fsanitize=undefined"]
PRONY = ((0.1, 0.5), (0.2, 8.0))
PROGRAM = """
#include <stdio.h>
#include "twin.h"
int main(void)
{
    char what;
    SITS_REAL state[SITS_STATE], given[6], L[SITS_COILS], wrench[6], dt = (SITS_REAL)0.05;
    int32_t codes[SITS_COILS] = {0};
    sits_start(state);
    while (scanf(" %c", &what) == 1) {
        int flags = 0, count = what == 'l' || what == 'k' || what == 'b' ? SITS_COILS : 6;
        for (int i = 0; i < count; ++i) {
            double value;
            if (scanf("%lf", &value) != 1)
                return 1;
            given[i] = (SITS_REAL)value;
            if (what == 'k')
                codes[i] = (int32_t)value;
        }
        switch (what) {
        case 'w': flags = sits_read(given, L, codes); break;
        case 'p': flags = sits_read_pose(given, L, codes); break;
        case 't': flags = sits_step(state, given, dt, L, codes); break;
        case 'b': flags = sits_recover(state, given, dt, wrench); break;
        case 'l': flags = sits_estimate(given, wrench); break;
        case 'k': flags = sits_estimate_codes(codes, wrench); break;
        }
        printf("%d", flags);
        for (int i = 0; count == 6 && i < SITS_COILS; ++i)
            printf(" %.17g %ld", (double)L[i], (long)codes[i]);
        for (int i = 0; count != 6 && i < 6; ++i)
            printf(" %.17g", (double)wrench[i]);
        printf("\\n");
    }
    return 0;
}
"""
Ask = Callable[[str, str, np.ndarray], tuple[np.ndarray, np.ndarray]]


@pytest.fixture(scope="module")
def folder(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The twin of the small calibration, of a silicone that creeps."""
    folder = tmp_path_factory.mktemp("twin") / "made"
    write_twin(Source(*read_calibration(calibrated)), folder)
    numbers = dict(Twin.load(folder / "sensor.npz").numbers)
    weights, times = retardation(PRONY)
    shares, taus = np.array(PRONY).T
    numbers |= {"creep_weights": weights, "creep_times": times, "relaxation_times": taus}
    numbers |= {"relaxation_weights": shares / (1.0 - shares.sum())}
    np.savez(folder / "sensor.npz", **numbers)
    (folder / "sensor.h").write_text(c_tables(numbers, "a comment that */ ends"))
    return folder


@pytest.fixture(scope="module")
def ask(folder: Path) -> Ask:
    """Return flags and numbers that the compiled program gives: the type, what is asked, rows of input."""
    programs = {}

    def asked(real: str, what: str, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if real not in programs:
            programs[real] = built(folder, PROGRAM, real, STRICT)
        lines = "\n".join(f"{what} {' '.join(f'{value:.17g}' for value in row)}" for row in rows.tolist())
        done = subprocess.run([str(programs[real])], input=lines, capture_output=True, text=True, timeout=60)
        assert (done.returncode, done.stderr) == (0, "")
        found = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
        return found[:, 0].astype(int), found[:, 1:]

    return asked


def built(folder: Path, text: str, real: str, flags: list[str]) -> Path:
    """Return a program compiled beside the header; warnings stop the compiler."""
    (folder / "main.c").write_text(text)
    words = [COMPILER, *flags, f"-DSITS_REAL={real}", "-o", f"main_{real}", "main.c", "-lm"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return folder / f"main_{real}"


@pytest.fixture(scope="module")
def twin(folder: Path) -> Twin:
    """The same in Python."""
    return Twin.load(folder / "sensor.npz")


def wrenches(reach: float, count: int = 500) -> np.ndarray:
    """Around the table's box, other components on some of them."""
    random = np.random.default_rng(4)
    found = np.zeros((count, 6))
    found[:, :2] = random.uniform([-1.0, 0.0], [1.0, 3.0], (count, 2)) * reach
    found[::9, 3] = 0.1
    return found


@pytest.mark.parametrize("real, off", [("double", 1e-12), ("float", 1e-5)])
def test_readings_are_those_of_python(real: str, off: float, ask: Ask, twin: Twin) -> None:
    """Wrenches and poses, inside and out: inductances, codes, flags; single within 1e-5 of full scale."""
    scale = twin.numbers["scale_L"], twin.numbers["scale_codes"]
    poses = np.tile(0.5 * (twin.numbers["pose_low"] + twin.numbers["pose_high"]), (200, 1))
    poses = poses + np.random.default_rng(2).uniform(-0.7, 0.7, poses.shape) * np.ptp(
        [twin.numbers["pose_low"], twin.numbers["pose_high"]], axis=0
    )
    given = {"w": wrenches(1.2), "p": np.pad(poses, ((0, 0), (0, 3)))}
    for what, rows in given.items():
        flags, found = ask(real, what, rows)
        own = twin.read(rows) if what == "w" else twin.read_pose(rows)
        assert np.array_equal(flags, own.flags) and len(set(flags.tolist())) > 1
        assert np.abs((found[:, 0::2] - own.L) / scale[0]).max() < off
        assert np.abs((found[:, 1::2] - own.codes) / scale[1]).max() < off + (0.0 if real == "double" else 1e-5)


@pytest.mark.parametrize("real", ["double", "float"])
def test_faults_of_codes_are_those_of_python(real: str, ask: Ask, twin: Twin) -> None:
    """Flags above the code's bits, full scale and zero, of either coil: no wrench, the same flags."""
    well = twin.read(wrenches(0.5, 1)).codes[0].astype(float)
    bad = np.array([2**28 - 1, 0, 0x1B3D3D64, -1, -(2**31) + 0x0B3D3D64], dtype=float)
    rows = np.array([well, *([code, well[1]] for code in bad), *([well[0], code] for code in bad)])
    flags, found = ask(real, "k", rows)
    own = twin.estimate_codes(rows.astype(np.int64))
    assert np.array_equal(flags, own.flags) and set(flags.tolist()) == {0, 12, 20, 36}
    assert np.array_equal(np.isnan(found), np.isnan(own.wrench))


@pytest.mark.parametrize("real, off", [("double", 1e-12), ("float", 1e-5)])
def test_what_is_no_number_is_told_as_in_python(real: str, off: float, ask: Ask, twin: Twin) -> None:
    """Loads, poses, readings and steps of NaN: the same flags, inductances and codes, all of them numbers."""
    rows = np.zeros((5, 6))
    rows[:, :2] = [[0.1, 1.0], [np.nan, 1.0], [0.1, np.nan], [np.nan, np.nan], [0.1, 1.0]]
    rows[4, 5] = np.nan
    pose = np.tile(np.pad(0.5 * (twin.numbers["pose_low"] + twin.numbers["pose_high"]), (0, 3)), (3, 1))
    pose[1, 0] = pose[2] = np.nan
    state, steps = twin.start(1), []
    for row in rows:
        state, reading = twin.step(state, row[None], 0.05)
        steps.append(reading)
    stepped = [np.concatenate(each) for each in zip(*steps, strict=True)]
    for what, given, own in (("w", rows, twin.read(rows)), ("p", pose, twin.read_pose(pose)), ("t", rows, stepped)):
        flags, found = ask(real, what, given)
        assert np.array_equal(flags, own[2]) and set(flags.tolist()) > {0, 1} and np.all(np.isfinite(found))
        assert np.abs((found[:, 0::2] - own[0]) / twin.numbers["scale_L"]).max() < off
        assert np.abs((found[:, 1::2] - own[1]) / twin.numbers["scale_codes"]).max() < 2e-5
    flags, found = ask(real, "l", np.array([[np.nan, 1e-6], [np.nan, np.nan]]))
    assert flags.tolist() == [4, 4] and np.all(np.isnan(found))


@pytest.mark.parametrize("real, off", [("double", 1e-11), ("float", 1e-3)])
def test_estimates_are_those_of_python(real: str, off: float, ask: Ask, twin: Twin) -> None:
    """Of inductances and codes of the box, and of none: the same flags and wrenches."""
    shown = twin.read(wrenches(1.0) * (np.arange(6) < 2))
    for what, readings in (("l", shown.L), ("k", shown.codes)):
        flags, found = ask(real, what, readings)
        own = twin.estimate(shown.L) if what == "l" else twin.estimate_codes(shown.codes)
        assert np.array_equal(flags, own.flags) and np.abs(found - own.wrench).max() < off
    flags, found = ask(real, "l", np.array([[1e-6, 2e-6], [3e-6, 3e-6]]))
    assert np.all(flags & 4) and np.all(np.isnan(found))


def test_time_is_that_of_python(ask: Ask, twin: Twin) -> None:
    """A path in steps, and back."""
    rows, state, back = wrenches(0.9, 60), twin.start(1), twin.start(1)
    flags, found = ask("double", "t", rows)
    shown = []
    for row in rows:
        state, reading = twin.step(state, row[None], 0.05)
        shown.append(reading.L[0])
    assert np.abs((found[:, 0::2] - shown) / twin.numbers["scale_L"]).max() < 1e-12
    _, loads = ask("double", "b", np.array(shown))
    for load, L in zip(loads, shown, strict=True):
        back, estimate = twin.recover(back, L[None], 0.05)
        assert load == pytest.approx(estimate.wrench[0], abs=1e-10)


@pytest.mark.slow
def test_what_is_missing_is_left_out(twin: Twin, folder: Path, tmp_path: Path) -> None:
    """No converter, no map of poses, no inverse, no branches, a domain with a hole: it compiles, by what is there."""
    numbers = {name: value for name, value in twin.numbers.items() if not name.startswith(("pose", "guess"))}
    for name in ("wrench_base", "wrench_coefficients"):
        numbers[name] = numbers[name][:2]
    numbers |= {name: numbers[name][:0] for name in numbers if name.startswith(("creep", "relaxation"))}
    bare = c_tables({**numbers, "codes": np.array(0)}, "bare")
    valid = np.ones((5, 5), dtype=np.uint8)
    valid[4, 4] = 0
    holed = c_tables({**twin.numbers, "valid": valid}, "holed")
    shutil.copy(folder / "twin.h", tmp_path)
    text = '#include "twin.h"\nint main(void)\n{\n    SITS_REAL x[6] = {0}, L[2];\n'
    for tables, call in ((bare, "sits_read(x, L, 0)"), (holed, "(sits_read(y, L, k), sits_estimate(L, x)) - 4")):
        (tmp_path / "sensor.h").write_text(tables)
        extra = "    const SITS_REAL y[6] = {(SITS_REAL)0.99, (SITS_REAL)2.99, 0, 0, 0, 0};\n    int32_t k[2];\n"
        body = f"{text}{extra if 'y' in call else ''}    return {call};\n}}\n"
        for real in ("double", "float"):
            assert subprocess.run([str(built(tmp_path, body, real, STRICT))], timeout=10).returncode == 0
