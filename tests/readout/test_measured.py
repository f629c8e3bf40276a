"""Reading measurements, and fits whose answers are known."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.readout.converter import CONVERTERS, code_of, tank_frequency
from sits_mech.readout.measured import Tank, fit_parameters, read_measured

NAMES = ("F_x", "F_z")
COILS = ("C1", "C2")


def written(folder: Path, text: str) -> Path:
    """A file with a text."""
    path = folder / "bench.csv"
    path.write_text(text)
    return path


def test_columns_units_and_separators(tmp_path: Path) -> None:
    """Any order, units in brackets, a heading of any length, rows that are none passed over."""
    rows = "\n".join(f"{k};{100 * k};2.3{k};2.2{k};x" for k in range(5))
    text = f"# a comment\nBench of May; run 3\nF_z [N];F_x (mN);L_C2 [uH];l1 [uH];remark\n{rows}\nend;;;;\n"
    with pytest.raises(ValueError, match="at least 4 rows of numbers; got 0"):
        read_measured(written(tmp_path, text), NAMES, COILS)
    found = read_measured(written(tmp_path, text.replace(";x", "").replace(";remark", "")), NAMES, COILS)
    np.testing.assert_allclose(found.forces, [[0.1 * k, k] for k in range(5)], rtol=1e-14)
    np.testing.assert_allclose(found.L, [[2.20e-6 + 1e-8 * k, 2.30e-6 + 1e-8 * k] for k in range(5)], rtol=1e-12)


def test_codes_become_inductances(tmp_path: Path) -> None:
    """Through the tank's frequency, to the code's own step."""
    L = np.array([[2.1e-6, 2.2e-6], [2.0e-6, 2.3e-6], [2.05e-6, 2.25e-6], [1.9e-6, 2.4e-6]])
    part = CONVERTERS["LDC1614"]
    codes = np.round(code_of(tank_frequency(L, 330e-12), part, 40e6))
    lines = [f"0,{k},{int(a)},{int(b)}" for k, (a, b) in enumerate(codes)]
    path = written(tmp_path, "F_x,F_z,code1,code2\n" + "\n".join(lines))
    found = read_measured(path, NAMES, COILS, Tank(part, 330e-12, 40e6))
    np.testing.assert_allclose(found.L, L, rtol=5e-8)
    with pytest.raises(ValueError, match="column code1 must come with a converter"):
        read_measured(path, NAMES, COILS)


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    """No file, no names, a missing coil, a wrong unit, too few rows: one line each."""
    with pytest.raises(ValueError, match="must be a readable measurement"):
        read_measured(tmp_path / "none.csv", NAMES, COILS)
    with pytest.raises(ValueError, match="must have a column F_x and one for each coil"):
        read_measured(written(tmp_path, "force,L1\n1,2\n"), NAMES, COILS)
    good = "\n".join("1,2,3,4" for _ in range(4))
    with pytest.raises(ValueError, match="must have a column L2 or code2; got f_x, f_z, l1, q"):
        read_measured(written(tmp_path, f"F_x,F_z,L1,q\n{good}"), NAMES, COILS)
    with pytest.raises(ValueError, match="must have the column F_z, which the calibration varies; got f_x, l1, l2, q"):
        read_measured(written(tmp_path, f"F_x,L1,L2,q\n{good}"), NAMES, COILS)
    with pytest.raises(
        ValueError, match="column F_y: must be 0 N, the calibration varies F_x, F_z alone; got 3 to 3 N"
    ):
        read_measured(written(tmp_path, f"F_x,F_z,F_y,L1\n{good}"), NAMES, COILS[:1])
    with pytest.raises(ValueError, match=r"column l2: must be of one of 1 coils \(C1\); leave it out"):
        read_measured(written(tmp_path, f"F_x,F_z,L1,L2\n{good}"), NAMES, COILS[:1])
    held = read_measured(written(tmp_path, f"F_x,F_z,F_y,L1\n{good}"), NAMES, COILS[:1], held={"F_y": 3.0})
    assert held.forces.tolist() == [[1.0, 2.0]] * 4
    with pytest.raises(ValueError, match='column f_z: must be a force.*got "1 kg"'):
        read_measured(written(tmp_path, f"F_x,F_z [kg],L1,L2\n{good}"), NAMES, COILS)
    with pytest.raises(ValueError, match="at least 4 rows of numbers; got 3"):
        read_measured(written(tmp_path, "F_x,F_z,L1,L2\n1,2,3,4\n1,2,3,4\n1,2,3,4"), NAMES, COILS)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """300 noisy lines: the 95 % interval of the slope holds the true one in 92 to 98 of 100 cases."""
    x = np.linspace(0.0, 1.0, 20)[:, None]
    rng = np.random.default_rng(4)
    held = 0
    for _ in range(300):
        L = 1e-6 * (2.0 + 0.3 * x + 0.02 * rng.standard_normal(x.shape))
        found = fit_parameters(
            lambda p: 1e-6 * (p[0] + p[1] * x), L, ["a", "b"],
            start=[0.0, 0.0], bounds=([-9.0, -9.0], [9.0, 9.0]), sizes=[1.0, 1.0],
        )  # fmt: skip
        held += abs(found.values[1] - 0.3) <= found.half_widths[1]
    assert 276 <= held <= 294
    assert found.residual.shape == (20, 1) and 0.03 < found.rms < 0.15 < found.rms_before


def test_what_the_data_do_not_hold() -> None:
    """A parameter without effect has no finite interval; one at its bound, or too few data, are refused."""
    x = np.linspace(0.0, 1.0, 9)[:, None]
    found = fit_parameters(
        lambda p: p[0] * x + 0.0 * p[1], 2.0 * x + 1e-3 * x**2, ["a", "b"],
        start=[1.0, 0.0], bounds=([0.0, -1.0], [9.0, 1.0]), sizes=[1.0, 1.0],
    )  # fmt: skip
    assert np.isfinite(found.half_widths[0]) and np.isinf(found.half_widths[1])
    with pytest.raises(ValueError, match="a: must fit from 0 to 1; the best value is at an end, 1"):
        fit_parameters(lambda p: p[0] * x, 2.0 * x, ["a"], start=[0.5], bounds=([0.0], [1.0]), sizes=[1.0])
    with pytest.raises(ValueError, match="must hold more than 1 inductances; got 1"):
        fit_parameters(lambda p: p[0] * x[:1], x[:1], ["a"], start=[0.5], bounds=([0.0], [1.0]), sizes=[1.0])
