"""The C header, compiled by the system's compiler: codes, forces and statuses of the Python calibration."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.readings.bench import code_calibration, readings
from sits_mech.cli.main import run
from sits_mech.export.calibrations import quality
from sits_mech.export.firmware import header, write_header
from sits_mech.export.fixed_point import fixed_point
from sits_mech.export.formats import export
from sits_mech.export.source import Source
from sits_mech.readout.calibration import OK, OUTSIDE, Calibration, calibration_of
from sits_mech.readout.inversion import AMBIGUOUS, NO_SOLUTION
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import changed

COMPILER = shutil.which("gcc") or shutil.which("cc") or ""
pytestmark = pytest.mark.skipif(not COMPILER, reason="no C compiler (gcc or cc)")
STATUS = np.array([OK, OUTSIDE, AMBIGUOUS, NO_SOLUTION])
FAULTS = "flags", "full scale", "zero"
PROGRAM = """
#include <inttypes.h>
#include <stdio.h>
#include "table.h"
int main(void)
{
    char what;
    while (scanf(" %c", &what) == 1) {
        uint32_t code[SITS_COILS] = {0};
        int32_t force[SITS_FORCES] = {0};
        int64_t value;
        int status;
        for (int i = 0; i < (what == 'c' ? SITS_FORCES : SITS_COILS); ++i) {
            if (scanf("%" SCNd64, &value) != 1)
                return 1;
            if (what == 'c')
                force[i] = (int32_t)value;
            else
                code[i] = (uint32_t)value;
        }
        status = what == 'c' ? sits_codes(force, code) : sits_forces(code, force);
        printf("%d", status);
        for (int i = 0; i < (what == 'c' ? SITS_COILS : SITS_FORCES); ++i)
            printf(" %" PRId64, what == 'c' ? (int64_t)code[i] : (int64_t)force[i]);
        printf("\\n");
    }
    return (int)sits_registers[0][0] * 0 + (int)sits_rest[0] * 0;
}
"""
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
TRAP = ["-O1", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]


def built(folder: Path, text: str, flags: list[str]) -> Path:
    """Return a program compiled in a folder that holds one header; warnings stop the compiler."""
    (folder / "main.c").write_text(text.replace("table.h", next(folder.glob("*.h")).name))
    done = subprocess.run(
        [COMPILER, *STRICT, *flags, "-o", "table", "main.c"], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return folder / "table"


def compiled(folder: Path) -> Path:
    """Return the program around the header in a folder; undefined behaviour stops it."""
    return built(folder, PROGRAM, TRAP)


def asked(program: Path, what: str, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return status and answers of the compiled program: forces to codes ("c"), or codes to forces ("f")."""
    lines = "\n".join(f"{what} {' '.join(map(str, row))}" for row in np.rint(rows).astype(np.int64))
    done = subprocess.run([str(program)], input=lines, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.returncode
    found = np.array([[int(word) for word in line.split()] for line in done.stdout.splitlines()])
    return np.array([*STATUS, "other", *FAULTS])[found[:, 0]], found[:, 1:]


def units(cal: Calibration) -> np.ndarray:
    """How many of the header's units are a newton or a newton metre."""
    return np.array([1e6 if name[0] == "F" else 1e9 for name in cal.forces])


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


@pytest.fixture(scope="module")
def program(source: Source, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its header, compiled."""
    folder = tmp_path_factory.mktemp("firmware")
    export(source, "c", folder / "table.h")
    built(folder, PROGRAM, ["-O2"])  # as users compile it: no warning
    return compiled(folder)


def made(forces: tuple[str, ...], count: int, noise: list[float] | None = None) -> Calibration:
    """A calibration by hand: a bent map of codes, forces from -0.5 to 0.5 N (2 mN m), F_z from 0 to 2 N."""
    d, random = len(forces), np.random.default_rng(len(forces))
    grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 7 if d < 4 else 4)] * d, indexing="ij"), -1).reshape(-1, d)
    slopes = np.linalg.qr(random.normal(size=(count, count)))[0][:, :d] * (1.0 + np.arange(d))
    bent = np.einsum("mi,nij,mj->mn", grid, random.normal(size=(count, d, d)) * 0.15, grid)
    codes = 4e7 + 3e5 * (grid @ slopes.T + bent + 0.05 * np.exp(0.7 * grid[:, :1]) * random.normal(size=count))
    half = np.array([{"F_z": 1.0, "M_x": 2e-3}.get(name, 0.5) for name in forces])
    loads = half * (grid + [float(name == "F_z") for name in forces])
    coils = [f"C{i + 1}" for i in range(count)]
    return calibration_of(loads, codes, forces=forces, coils=coils, free=("code", np.full(count, np.nan)), noise=noise)


def folded() -> Calibration:
    """code_1 = x, code_2 = (z - 0.6)^2 over [0, 1]^2, scaled: z above 0.2 has a twin, the rest one answer."""
    x, z = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9), indexing="ij")
    points = np.stack([x, z], -1).reshape(-1, 2)
    codes = 4e7 + 1e5 * np.stack([points[:, 0], (points[:, 1] - 0.6) ** 2 + 1e-3 * points[:, 0]], -1)
    return calibration_of(points, codes, forces=("F_x", "F_z"), coils=("C1", "C2"), free=("code", [np.nan, np.nan]))


def around(cal: Calibration, count: int) -> np.ndarray:
    """Random codes of each coil on its own, and of loads up to 1.3 of the range, some of them off by up to 5 %."""
    random, n = np.random.default_rng(5), len(cal.coils)
    half, middle = 0.5 * (cal.high - cal.low), 0.5 * (cal.high + cal.low)
    codes = cal.forward(middle + half * random.uniform(-1.3, 1.3, (count, len(half))), beyond=True)
    off = random.choice([0.0, 1.0, 0.01 * cal.full_scale.max(), 0.05 * cal.full_scale.max()], (count, 1))
    low, high = codes.min(axis=0), codes.max(axis=0)
    apart = random.uniform(low, high, (count // 2, n))
    wild = random.uniform(0.0, 2.0**28 - 1.0, (count // 10, n))
    return np.rint(np.concatenate([codes + off * random.normal(size=(count, n)), apart, wild]))


def agreed(cal: Calibration, program: Path, codes: np.ndarray, expected: set[str]) -> np.ndarray:
    """Return the forces of codes that have an answer: every status as in Python, forces within 5 uN (5 nN m)."""
    status, found = asked(program, "f", codes)
    exact = cal.inverse(codes)
    assert set(exact.status) == expected
    differ = np.flatnonzero(status != exact.status)
    assert len(differ) == 0, (codes[differ], status[differ], exact.status[differ])
    good = status == OK
    assert np.abs(found[good] - units(cal) * exact.forces[good]).max() < 5.0
    return found[good]


CASES = {
    "one force of two coils": (("F_z",), 2, None, 2_000, {OK, OUTSIDE, NO_SOLUTION}),
    "two forces": (("F_x", "F_z"), 2, None, 2_000, {OK, OUTSIDE}),
    "three of three coils": (("F_x", "F_z", "F_y"), 3, None, 2_000, {OK, OUTSIDE}),
    "three of four coils": (("F_x", "F_z", "F_y"), 4, [1.0, 2.0, 1.0, 0.7], 10_000, {OK, OUTSIDE, NO_SOLUTION}),
    "with a moment": (("F_x", "F_z", "F_y", "M_x"), 4, None, 500, {OK, OUTSIDE}),
    "folded": (None, 2, None, 4_000, {OK, OUTSIDE, AMBIGUOUS}),
}


LATER = ("one force of two coils", "two forces", "three of four coils", "with a moment")


@pytest.mark.parametrize("case", [pytest.param(name, marks=[pytest.mark.slow] * (name in LATER)) for name in CASES])
def test_agrees_with_python(case: str, source: Source, tmp_path: Path) -> None:
    """Random codes: no status differs, forces by less than 5 uN (5 nN m) with their own rounding."""
    forces, coils, noise, count, expected = CASES[case]
    cal = folded() if forces is None else made(forces, coils, noise)
    (tmp_path / "table.h").write_text(header(source, fixed_point(cal)))
    program = compiled(tmp_path)
    found = agreed(cal, program, around(cal, count), expected)[:2000]
    shown, back = asked(program, "c", found)
    exact_codes = cal.forward(found / units(cal), beyond=True)
    assert np.all(np.isin(shown, (OK, AMBIGUOUS))) and np.abs(back - exact_codes).max() <= 0.5 + fixed_point(cal).error


def inside(cal: Calibration, count: int, reach: float = 1.0) -> np.ndarray:
    """Forces [N] all over the table, corners and edges among them."""
    half, middle = 0.5 * (cal.high - cal.low), 0.5 * (cal.high + cal.low)
    found = np.random.default_rng(7).uniform(-reach, reach, (count, 2))
    edge = np.array([[x, z] for x in (-1, -0.5, 0, 1) for z in (-1, 0.3, 1)], dtype=float) * reach
    return middle + half * np.vstack([found, edge])


def test_a_calibration_of_a_sensor(source: Source, program: Path) -> None:
    """Its own codes: statuses, forces to codes within one, codes to forces within 5 uN, and round trips by C alone."""
    cal = code_calibration(source.sensor, source.data)
    agreed(cal, program, around(cal, 2_000), {OK, OUTSIDE})
    asked_for = np.rint(1e6 * inside(cal, 2000))
    status, codes = asked(program, "c", asked_for)
    assert np.all(status == OK) and np.abs(codes - np.rint(cal.forward(1e-6 * asked_for))).max() <= 1
    _, back = asked(program, "f", codes)
    worth = np.abs(np.linalg.inv(cal.slopes(1e-6 * asked_for))).sum(axis=2)
    assert np.all(1e-6 * np.abs(back - asked_for) <= 0.6 * worth + 1e-6)


@pytest.mark.slow
def test_three_axes_of_the_catalogue(tmp_path: Path) -> None:
    """Four coils, 5 x 5 x 5 loads at 1 %: the same over 16,000 random codes, and over 10,000 of its own loads."""
    forces = ("--fx", "-0.5 N:0.5 N:5", "--fy", "-0.5 N:0.5 N:5", "--fz", "0 N:2 N:5")
    assert run(["calibrate", "triaxial-4", *forces, "-o", str(tmp_path / "made")]) == 0
    source = Source(*read_calibration(tmp_path / "made"))
    (tmp_path / "c").mkdir()
    export(source, "c", tmp_path / "c" / "table.h")
    cal, program = code_calibration(source.sensor, source.data), compiled(tmp_path / "c")
    random = np.random.default_rng(9)
    agreed(cal, program, around(cal, 10_000), {OK, OUTSIDE, NO_SOLUTION})
    shown = cal.forward(random.uniform(cal.low, cal.high, (10_000, 3)))
    found = agreed(cal, program, np.rint(shown + random.normal(size=shown.shape)), {OK})
    assert len(found) == 10_000


def test_the_window_of_a_part_of_twelve_bits(source: Source, tmp_path: Path) -> None:
    """Gain and offsets are among the registers, codes are in their window, whose ends are faults; as Python has it."""
    narrow = Source(changed(source.sensor, ['readout.converter="LDC1314"']), source.data)
    export(narrow, "c", tmp_path / "table.h")
    cal, program = code_calibration(narrow.sensor, narrow.data), compiled(tmp_path)
    found = np.rint(cal.forward(inside(cal, 200)))
    agreed(cal, program, found, {OK, OUTSIDE, AMBIGUOUS} & set(cal.inverse(found).status))
    front = readings(narrow.sensor, narrow.data).front
    text = (tmp_path / "table.h").read_text()
    assert front is not None and front.gain == 16 and "#define SITS_FULL UINT32_C(4095)" in text
    rows = [f"{{0x{0x0C + k:02X}, 0x{int(offset):04X}}}" for k, offset in enumerate(front.offset)]
    assert all(row in text for row in (*rows, "{0x1C, 0x0600}"))
    faults = np.array([[4095, 2048], [2048, 0], [0x1800, 2048]])
    assert asked(program, "f", faults)[0].tolist() == ["full scale", "zero", "flags"]


def test_what_is_outside(source: Source, program: Path) -> None:
    """Beyond the table, no codes of a coil at all, the far ends of the integers: refused, nothing overflows."""
    cal = code_calibration(source.sensor, source.data)
    half, middle = 0.5 * (cal.high - cal.low), 0.5 * (cal.high + cal.low)
    for x, z in ((1.1, 0.0), (-1.1, 0.0), (0.0, 1.1), (0.0, -1.1), (1.2, -1.2)):
        there = middle + half * np.array([x, z])
        assert asked(program, "c", 1e6 * there[None])[0] == OUTSIDE
        codes = np.rint(cal.forward(there, beyond=True))[None]
        assert asked(program, "f", codes)[0] == cal.inverse(codes).status[0] == OUTSIDE
    wild = np.array([[1, 1], [2**28 - 2, 1], [1, 2**28 - 2], [2**28 - 2, 2**28 - 2]])
    assert np.all(asked(program, "f", wild)[0] == OUTSIDE)
    well = int(np.rint(cal.forward(middle))[0])
    faults = np.array([[well, 2**28 - 1], [0, well], [0x1B3D3D64, well], [2**32 - 1, 0]])  # full scale, zero, flags
    assert asked(program, "f", faults)[0].tolist() == ["full scale", "zero", "flags", "flags"]
    ends = np.array([[-(2**31), -(2**31)], [2**31 - 1, 2**31 - 1], [0, -(2**31)]])
    assert np.all(asked(program, "c", ends)[0] == OUTSIDE)


@pytest.mark.slow
def test_a_map_that_folds_is_refused_where_it_does(source: Source, tmp_path: Path) -> None:
    """Below the twins one answer, among them none."""
    cal = folded()
    (tmp_path / "table.h").write_text(header(source, fixed_point(cal)))
    program = compiled(tmp_path)
    below = np.column_stack([np.linspace(0.1, 0.9, 9), np.full(9, 0.08)])
    status, found = asked(program, "f", np.rint(cal.forward(below)))
    assert np.all(status == OK) and np.abs(1e-6 * found - below).max() < 1e-4
    above = np.column_stack([np.linspace(0.1, 0.9, 9), np.full(9, 0.45)])
    assert np.all(asked(program, "f", np.rint(cal.forward(above)))[0] == AMBIGUOUS)


def test_says_what_its_integers_are_worth(source: Source, tmp_path: Path) -> None:
    """code = C L^-1/2: a load's error is half its relative error of L, in codes; the header and the notes say it."""
    read = readings(source.sensor, source.data)
    off = float(np.max(0.5 * read.codes * read.error_L / read.L))
    notes = write_header(source, tmp_path / "table.h")
    assert notes[2] == f"estimated errors of the loads: up to {off:.3g} codes"
    text = (tmp_path / "table.h").read_text(encoding="utf-8")
    assert f"the estimated errors of the loads are up to {off:.3g} codes" in text.replace("\n * ", " ")
    assert "Calibrated: F_x -1 to 1 N, F_z 0 to 3 N.\n" in text
    write_header(Source(source.sensor, source.data.assign_coords(M=1e-3)), tmp_path / "table.h")
    assert "F_z 0 to 3 N; all under M = 0.001 N m.\n" in (tmp_path / "table.h").read_text(encoding="utf-8")


def test_says_the_errors_that_quality_says(source: Source) -> None:
    """Median and greatest over the loads; of a map of codes, which go as L^-1/2 and bend a little otherwise than L."""
    text = header(source, fixed_point(code_calibration(source.sensor, source.data)))
    found = re.findall(r"([\d.e+]+) mN of (F_.) \(up to ([\d.e+]+)\)", text)
    expected = quality((source.sensor, source.data)).force_error[:, 1:]
    assert [name for _, name, _ in found] == ["F_x", "F_z"]
    assert np.array([(usual, most) for usual, _, most in found], dtype=float) == pytest.approx(1e3 * expected, rel=0.05)


def test_size_and_stack(source: Source, tmp_path: Path) -> None:
    """The bytes of all tables are those that the header states, the compiler's stack is at most the stated one."""
    (tmp_path / "table.h").write_text(header(source, fixed_point(made(("F_x", "F_z", "F_y"), 4))))
    text = (tmp_path / "table.h").read_text()
    stated = {name: int(re.search(rf"{name}: (?:at most )?(\d+) bytes", text)[1]) for name in ("Tables", "Stack")}
    names = re.findall(r"^static const \w+ (\w+)\[", text, re.M)
    sizes = " + ".join(f"sizeof {name}" for name in names if name != "sits_registers")
    program = f'#include <stdio.h>\n#include "table.h"\nint main(void) {{ printf("%d", (int)({sizes})); return 0; }}\n'
    done = subprocess.run([str(built(tmp_path, program, []))], capture_output=True, text=True, timeout=60)
    assert int(done.stdout) == stated["Tables"] < 5000
    if "gcc" not in COMPILER:
        return
    for level in ("-O0", "-O2"):
        built(tmp_path, PROGRAM, [level, "-fstack-usage"])
        rows = [line.split() for line in next(tmp_path.glob("*.su")).read_text().splitlines()]
        used = {row[0].split(":")[-1].split(".")[0]: int(row[1]) for row in rows}
        leaves = max(used.pop("sits_map", 0), used.pop("sits_solve", 0) + used.pop("sits_step", 0))
        names = ("forces", "forces_to", "fault", "fit", "down_by", "scaled", "length", "times")
        deepest = sum(used.get(f"sits_{name}", 0) for name in names)
        deepest += used["main"] * ("sits_forces_to" not in used)  # where all of them are in their only caller
        assert 0.4 * stated["Stack"] < leaves + deepest < stated["Stack"]


@pytest.mark.slow
def test_failed_loads_are_outside(source: Source, tmp_path: Path) -> None:
    """Without the loads of a corner the header still stands, and refuses readings of that corner."""
    data = source.data.copy(deep=True)
    data["status"] = data["status"].astype(object)
    for x, z in ((4, 3), (4, 2), (3, 3)):
        data["status"][x, z] = "stalled"
    write_header(Source(source.sensor, data), tmp_path / "table.h")
    codes = np.rint(code_calibration(source.sensor, source.data).forward([[1.0, 3.0], [0.0, 1.0]]))
    assert list(asked(compiled(tmp_path), "f", codes)[0]) == [OUTSIDE, OK]


def test_what_has_no_header(source: Source, three_forces: Path, tmp_path: Path) -> None:
    """No converter, more forces than coils, one load: one line each."""
    alone = source.data.isel(coil=[0], coil_2=[0])
    cases: list[tuple[Source, str]] = [
        (Source(changed(source.sensor, ['readout.converter="none"']), source.data), "must have codes of a converter"),
        (Source(source.sensor.model_copy(update={"coils": source.sensor.coils[:1]}), alone), "1 cannot resolve 2 fo"),
        (Source(*read_calibration(three_forces)), "2 cannot resolve 3 forces"),
        (Source(source.sensor, source.data.isel(F_x=[2], F_z=[1])), "at least two values of a force; got one load"),
    ]
    for case, message in cases:
        assert isinstance(case.data, xr.Dataset)
        with pytest.raises(ValueError, match=message):
            export(case, "c", tmp_path / "t.h")


def test_headers_of_two_calibrations_in_one_file_are_an_error(program: Path, tmp_path: Path) -> None:
    """The second one would be left out without a word."""
    text = (program.parent / "table.h").read_text()
    own = re.search(r"define SITS_ID UINT32_C\((\w+)\)", text)
    assert own is not None
    (tmp_path / "a.h").write_text(text)
    (tmp_path / "b.h").write_text(text.replace(own[1], "0x12345678"))
    for second in ("a", "b"):
        (tmp_path / "main.c").write_text(f'#include "a.h"\n#include "{second}.h"\n')
        syntax = [COMPILER, "-std=c99", "-fsyntax-only", "main.c"]
        done = subprocess.run(syntax, cwd=tmp_path, capture_output=True, text=True)
        assert ("one header of a calibration in a file" in done.stderr) == bool(done.returncode) == (second == "b")
