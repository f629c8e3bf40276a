"""Measurements that are read: loads, poses, codes; what cannot be read is refused."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sits_mech.analysis.readings.measured import Tank, read_measured, read_units
from sits_mech.readout.converter import CONVERTERS, code_of, tank_frequency

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
    found = read_measured(written(tmp_path, text), NAMES, COILS)
    np.testing.assert_allclose(found.forces, [[0.1 * k, k] for k in range(5)], rtol=1e-14)
    np.testing.assert_allclose(found.L, [[2.20e-6 + 1e-8 * k, 2.30e-6 + 1e-8 * k] for k in range(5)], rtol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "F_x,F_z,L1,L2,\n0,0,1,1.5,\n0,1,1.5,1,\n", '"F_x","F_z","L1","L2"\n"0","0","1","1.5"\n"0","1","1.5","1"\n',
        "F_x;F_z;L1;L2;note\n1;2\n0;0;1;1,5;2\n0;1;1,5;1;ok\n;2;;1;\n",
        "F_x\tF_z\tL2\tL1\n0\t0\t1,5\t1\n0\t1\t1\t1,5\n",
    ],
)
def test_files_as_spreadsheets_write_them(text: str, tmp_path: Path) -> None:
    """A separator at each end, quotes, remarks, rows that are cut off, a comma as the decimal point."""
    found = read_measured(written(tmp_path, text), NAMES, COILS, unseen=True)
    assert found.forces.tolist() == [[0.0, 0.0], [0.0, 1.0]] and found.L.tolist() == [[1.0, 1.5], [1.5, 1.0]]


@pytest.mark.parametrize(
    "text",
    [
        "F_x,F_z,L1,L2\nN,N,uH,uH\n{rows}", "Fx (N),Fz (N),L1 (uH),L2 (uH)\n{rows}",
        "Log\nFx,Fz,L1,L2\n[N],[N],[µH],[µH]\n{rows}",
        "Fx [N],Fz [N],L1 [\u00b5H],L2 [µH]\n{rows}\nFx [N],Fz [N],L1 [µH],L2 [µH]\n2,3,2.5,2.6",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "utf-16"])
def test_units_and_letters_as_loggers_write_them(text: str, encoding: str, tmp_path: Path) -> None:
    """A row of units below the names, Fx for F_x, Windows' letters, names that come again when a logger restarts."""
    path = tmp_path / "bench.csv"
    path.write_bytes(text.format(rows="0,1,2.3,2.4\n1,2,2.4,2.5").encode(encoding))
    found = read_measured(path, NAMES, COILS, unseen=True)
    assert found.forces[:2].tolist() == [[0.0, 1.0], [1.0, 2.0]]
    np.testing.assert_allclose(found.L[:2], [[2.3e-6, 2.4e-6], [2.4e-6, 2.5e-6]], rtol=1e-14)
    assert len(found.L) == 2 + (text.count("Fx") == 2)


def test_masses_on_the_target_press_with_their_weight(tmp_path: Path) -> None:
    """Grams and kilograms of a force are those of a weight, by standard gravity."""
    found = read_measured(written(tmp_path, "Fx (g),Fz [kg],L1,L2\n0,1,1,1\n100,2,1,1"), NAMES, COILS, unseen=True)
    np.testing.assert_allclose(found.forces, [[0.0, 9.80665], [0.980665, 19.6133]], rtol=1e-14)


def test_doubled_columns_are_refused(tmp_path: Path) -> None:
    """Of loads, coils, by whatever name; not of remarks. Names that come again in another order are refused as well."""
    for head, match in (
        ("F_x,F_z,L1,L1", "must come once; got L1 and L1 for l1"), ("F_x,F_z,Fx,L1", "got F_x and Fx for f_x"),
        ("F_x,F_z,L1,L_C1", "a coil must have one column; got l1 and l_c1"),
        ("F_x,F_z,L1,x\n1,2,3,4\nF_z,F_x,L1,x", "must be those above; got others"),
    ):
        with pytest.raises(ValueError, match=match):
            read_measured(written(tmp_path, f"{head}\n1,2,3,4"), NAMES, COILS[:1], unseen=True)
    twice = written(tmp_path, "F_x,F_z,note,L1,note\n1,2,3,4,5")
    assert read_measured(twice, NAMES, COILS[:1], unseen=True).L.tolist() == [[4.0]]


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


@pytest.mark.parametrize(
    ("name", "window", "step"),
    [("LDC1614", {}, 5e-8), ("LDC1314", {"gain": 16, "offset": np.array([7000, 6900])}, 3e-4)],
)
@pytest.mark.parametrize("second", ["code2", "L2"])
def test_codes_of_lossy_coils(name: str, window: dict[str, Any], step: float, second: str, tmp_path: Path) -> None:
    """R follows the inductances of all coils, whether given or by codes; to the code's own step, 8e-4 off without."""
    slopes, constant = np.array([[2e5, -1e5], [1e5, 3e5]]), np.array([2.5, 1.5])
    L = np.array([[2.1e-6, 2.2e-6], [2.0e-6, 2.3e-6], [2.05e-6, 2.25e-6], [1.9e-6, 2.4e-6]])
    f = tank_frequency(L, 330e-12, L @ slopes + constant)
    codes = np.round(code_of(f, CONVERTERS[name], 40e6, **window))
    columns = codes[:, 0].tolist(), (codes if second == "code2" else L)[:, 1].tolist()
    path = written(tmp_path, f"F_x,F_z,code1,{second}\n" + "\n".join(f"0,{k},{a},{b}" for k, (a, b) in
                                                                     enumerate(zip(*columns, strict=True))))
    tank = Tank(CONVERTERS[name], 330e-12, 40e6, **window, resistance=lambda L: L @ slopes + constant)
    np.testing.assert_allclose(read_measured(path, NAMES, COILS, tank).L, L, rtol=step)
    lossless = read_measured(path, NAMES, COILS, replace(tank, resistance=None))
    assert np.all(lossless.L[:, 0] / L[:, 0] > 1.0007)


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    """No file, no names, a missing coil, a wrong unit, too few rows: one line each."""
    with pytest.raises(ValueError, match="must be a readable measurement"):
        read_measured(tmp_path / "none.csv", NAMES, COILS)
    with pytest.raises(ValueError, match=r"must have a column F_x, or d_v .*; got force, L1$"):
        read_measured(written(tmp_path, "force,L1\n1,2\n3,4\n"), NAMES, COILS)
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
    with pytest.raises(ValueError, match='column f_z: must be a force.*got "1 bar"'):
        read_measured(written(tmp_path, f"F_x,F_z [bar],L1,L2\n{good}"), NAMES, COILS)
    with pytest.raises(ValueError, match="at least 4 rows of numbers; got 3"):
        read_measured(written(tmp_path, "F_x,F_z,L1,L2\n1,2,3,4\n1,2,3,4\n1,2,3,4"), NAMES, COILS)


def test_poses_that_stages_set(tmp_path: Path) -> None:
    """In millimetres and degrees, what has no column is zero, inf is no target; loads come first where both stand."""
    rows = "inf,0,3.21,3.19\n1,0,2.9,2.95\n2,-20,3.1,3.0"
    found = read_measured(written(tmp_path, f"d_v [mm],alpha [deg],L1 [uH],L2 [uH]\n{rows}"), NAMES, COILS)
    assert found.poses is not None and found.forces.shape == (3, 0)
    expected = [[0, np.inf, 0, 0, 0, 0], [0, 1e-3, 0, 0, 0, 0], [0, 2e-3, -np.pi / 9.0, 0, 0, 0]]
    np.testing.assert_allclose(found.poses, expected, rtol=1e-14)
    loads = "\n".join("1,2,3,4,5" for _ in range(4))
    both = read_measured(written(tmp_path, f"F_x,F_z,d_v [mm],L1,L2\n{loads}"), NAMES, COILS)
    assert both.poses is None and both.forces.shape == (4, 2)
    with pytest.raises(ValueError, match="d_v must be above zero, or inf where there is no target; got -0.001"):
        read_measured(written(tmp_path, "d_v [mm],L1,L2\n-1,2,3"), (), COILS)
    with pytest.raises(ValueError, match="of d_v alone inf for no target; got inf in another column"):
        read_measured(written(tmp_path, "d_v [mm],L1,L2\n1,inf,3"), (), COILS)
    with pytest.raises(ValueError, match="must have a column d_v, of a pose, and one for each coil"):
        read_measured(written(tmp_path, "F_x,L1,L2\n1,2,3"), (), COILS)


def test_columns_of_moments_and_of_nothing(tmp_path: Path) -> None:
    """A moment has a unit, a column m without one may be anything; one beyond the numbers of the rows is missing."""
    good = "\n".join("1,2,3,4" for _ in range(4))
    with pytest.raises(ValueError, match="column M: must be 0 N m.*got 0.003 to 0.003 N m"):
        read_measured(written(tmp_path, f"F_x,F_z,M [N mm],L1\n{good}"), NAMES, COILS[:1])
    assert read_measured(written(tmp_path, f"F_x,F_z,m,L1\n{good}"), NAMES, COILS[:1]).L.tolist() == [[4.0]] * 4
    short = "\n".join("1,2,3" for _ in range(4))
    with pytest.raises(ValueError, match="at least 4 rows of numbers; got 0"):
        read_measured(written(tmp_path, f"F_x,L1,L2,F_z\n{short}"), NAMES, COILS)


def test_loads_that_were_not_measured(tmp_path: Path) -> None:
    """Kept as nan where that is asked for, with the way down; passed over otherwise, as rows without a reading are."""
    path = tmp_path / "press.csv"
    rows = "0, 0, 2.3\nnan, 0.1, 2.2\n1, 0.2, nan\n2, 0.3, 2.0\n3, 0.4, 1.9\n4, 0.5, 1.8\n"
    path.write_text(f"F_z [N], depth [mm], L1 [uH]\n{rows}")
    found = read_measured(path, ("F_z",), ("C1",), unseen=True)
    assert np.isnan(found.forces[1, 0]) and len(found.L) == 5
    assert found.depth == pytest.approx([0.0, 1e-4, 3e-4, 4e-4, 5e-4])
    assert read_measured(path, ("F_z",), ("C1",)).forces.ravel() == pytest.approx([0.0, 2.0, 3.0, 4.0])


def test_units_are_told_apart_by_their_column(tmp_path: Path) -> None:
    """In the order of the file, names as they are written; without the column or a name one line."""
    text = 'F_x, unit, F_z, L1, L2\n1, A 7, 2, 3, 4\n1, "B", nan, 3, 4\n2, A 7, 2, 3, 4\n'
    found = read_units(written(tmp_path, text), NAMES, COILS)
    assert list(found) == ["A 7", "B"] and found["A 7"].forces.tolist() == [[1.0, 2.0], [2.0, 2.0]]
    assert np.isnan(found["B"].forces[0, 1]) and found["B"].source.endswith(": B")
    with pytest.raises(ValueError, match="must have columns unit and F_x; got f_x, f_z, l1, l2"):
        read_units(written(tmp_path, "F_x, F_z, L1, L2\n1, 2, 3, 4\n"), NAMES, COILS)
    with pytest.raises(ValueError, match=": A: must hold at least 1 row of numbers; got 0"):
        read_units(written(tmp_path, "F_x, unit, F_z, L1, L2\n1, A, 2, x, 4\n"), NAMES, COILS)
    with pytest.raises(ValueError, match="a row with the name of its unit"):
        read_units(written(tmp_path, "F_x, unit, F_z, L1, L2\n"), NAMES, COILS)
