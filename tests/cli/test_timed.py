"""simulate --history and cycle --full on the command line: what is written, what is refused."""

import json
from pathlib import Path

import pytest

from sits_mech.cli.main import run
from sits_mech.store import read_table

QUICK = ["--mechanics", "linear", "--magnetics", "planar", "--tolerance", "0.1"]
MATERIAL = (
    'elastomer.material={law = "neo-hookean", shear_modulus = "20 kPa", bulk_modulus = "20 MPa", '
    'prony = [{weight = 0.3, time = "0.5 s"}]}'
)
Said = pytest.CaptureFixture[str]


@pytest.fixture
def press(tmp_path: Path) -> Path:
    path = tmp_path / "press.csv"
    path.write_text("t [s],F_z [N],F_x [N]\n0,0,0\n1,1,0\n2,1,0.2\n", encoding="utf-8")
    return path


@pytest.mark.slow
def test_a_history_leaves_a_folder(press: Path, tmp_path: Path, capsys: Said) -> None:
    """Every file, and one JSON object with the history's own rows; those of bars leave out ends."""
    folder = tmp_path / "out"
    words = ["simulate", "biorob2018", "--history", str(press), "--set", MATERIAL, *QUICK, "--rcount", "20000"]
    assert run([*words, "--accept", "-o", str(folder), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["time"] == [0.0, 1.0, 2.0]
    assert found["pose"]["d_h"][2] > 0.0 == found["pose"]["d_h"][0]
    assert len(found["code"]) > 100 and len(found["code"][0]) == 2
    assert (found["status"], found["flags"]) == ("above tolerance", ["above tolerance"])
    assert (read_table(folder / "history.nc")["status"] == "above tolerance").all()
    assert ",status,flags," in (folder / "history.csv").read_text().splitlines()[0]
    names = {path.name for path in folder.iterdir()}
    assert {"history.nc", "history.csv", "codes.csv", "scene.toml"} <= names


@pytest.mark.slow
def test_a_history_beyond_the_data_says_so(tmp_path: Path, capsys: Said) -> None:
    """Of each row its own status; code 4, and 0 for who accepts it; of a cycle one."""
    path = tmp_path / "press.csv"
    path.write_text("t,F_z\n0,0\n1,9\n", encoding="utf-8")
    words = ["simulate", "biorob2018", "--history", str(path), "--mechanics", "planar", *QUICK[2:]]
    assert run([*words, "--accept", "-o", str(tmp_path)]) == 0
    rows = read_table(tmp_path / "history.nc")
    assert [str(rows["status"][k].item()) for k in (0, -1)] == ["above tolerance", "beyond data"]
    assert "beyond data" in capsys.readouterr().out
    assert run([*words, "--json"]) == 4
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert found["status"] == "beyond data" == found["flags"][0] and "--accept makes it 0" in said.err
    assert "% of the signals' full scale, 10 % asked; exit code 4" in said.err
    cycle = ["cycle", "biorob2018", "--fz", "9 N", "--cycles", "1", "--mechanics", "planar", *QUICK[2:], "--json"]
    assert run(cycle) == 4
    assert json.loads(capsys.readouterr().out)["flags"][0] == "beyond data"


def test_a_cycle_above_its_tolerance_says_by_how_much(capsys: Said) -> None:
    """Beside its status, and in JSON the same."""
    assert run(["cycle", "biorob2018", "--fz", "0.1 N", "--mechanics", "linear", *QUICK[2:], "--json"]) == 4
    said = capsys.readouterr()
    share = json.loads(said.out)["error_of_full_scale"]
    assert share > 0.1 and f"above tolerance; error {100.0 * share:.2g} % of the signals' full scale, 10 %" in said.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--fz", "1 N"], "--history: must be given without a load"),
        (["--no-best"], "--history: must be given without a load"),
        (["--rcount", "3"], "rcount: must be from 9 to 65535 for the LDC1614; got 3"),
        (["--temperature", "0 degC:40 degC:3"], "--history: must be given without a load"),
        (["--mechanics", "planar", "--temperature", "900 degC"], "temperature: must be from"),
    ],
)
def test_what_is_refused(press: Path, capsys: Said, words: list[str], said: str) -> None:
    assert run(["simulate", "biorob2018", "--history", str(press), *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_what_needs_a_history(capsys: Said) -> None:
    assert run(["simulate", "biorob2018", "--fz", "1 N", "-o", "x"]) == 2
    assert "-o: must come with --history" in capsys.readouterr().err


@pytest.mark.slow
def test_a_load_that_is_not_carried(tmp_path: Path, capsys: Said) -> None:
    path = tmp_path / "pull.csv"
    path.write_text("t,F_z\n0,0\n1,-400\n", encoding="utf-8")
    planar = ["--mechanics", "planar", *QUICK[2:]]
    assert run(["simulate", "biorob2018", "--history", str(path), *planar]) == 3
    assert "history ended" in capsys.readouterr().err


@pytest.mark.slow
def test_a_full_cycle_tells_the_difference(capsys: Said) -> None:
    """Of what moves by more than its error: of a long pad, whose plane strain and plate leave out hardly any ends.

    Its target is backed: 150 mm of bare copper bend by a tenth of what they sink. Bare ones of 100 mm under 6 N are
    `above tolerance` (0.106 of full scale), and their loop is within its error.
    """
    keys = ('elastomer.length="150 mm"', 'target.length="150 mm"', 'target.backing_thickness="5 mm"',
            'target.backing_modulus="70 GPa"')
    long = [word for key in keys for word in ("--set", key)]
    words = ["cycle", "biorob2018", *long, "--fz", "30 N", "--full", "--cycles", "1", "--set", MATERIAL, "--json"]
    assert run([*words, *QUICK]) == 2
    assert "must be auto, block, planar or axisymmetric to follow every point; got linear" in capsys.readouterr().err
    assert run([*words, "--mechanics", "planar", "--magnetics", "sheets", "--tolerance", "0.1"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "interpolated"  # few times are solved
    assert found["cheap"]["difference_percent"]["d_v"] < 2.0
    assert found["loop_L_v_percent"][0] == pytest.approx(found["cheap"]["loop_L_v_percent"][0], rel=0.05)
