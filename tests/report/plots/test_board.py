"""The list and the picture of what looks like a coil."""

from pathlib import Path

import pytest

from sits_mech.boards.kicad import read_board
from sits_mech.boards.windings import windings
from sits_mech.cli.main import run
from sits_mech.report.plots.board import board_figure, listed
from tests.boards.test_windings import drawn_board, expected


def test_a_board_without_a_question_is_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """How it is taken, its inductance, its pads; the picture shows the same, by number."""
    board = tmp_path / "board.kicad_pcb"
    board.write_text(drawn_board(8, "drawn", 2), encoding="utf-8")
    assert run(["import", str(board), "-o", str(tmp_path / "coils.png")]) == 0
    out, err = capsys.readouterr()
    assert "--net=A" in out and "L1.1 to L1.2" in out and err == f"written to {tmp_path / 'coils.png'}\n"
    assert (tmp_path / "coils.png").read_bytes().startswith(b"\x89PNG")
    read = read_board(board)
    (one,) = listed(read, windings(read))
    assert one.inductance == pytest.approx(expected(2), rel=1e-2)
    figure = board_figure(read, (one,))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [f"1: --net=A, {one.shown} uH"]
    assert f" {one.shown} " in out


def test_what_is_no_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scene without a coil named, and a board without coils: one line, exit code 2."""
    board = tmp_path / "board.kicad_pcb"
    board.write_text(drawn_board(10, "net 0", 1), encoding="utf-8")
    assert run(["import", str(board), "-o", str(tmp_path / "probe.toml")]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and "what looks like a coil: --at=-3.2,0,F.Cu (47.08 mm" in err
    assert run(["import", str(board), "-o", str(tmp_path / "probe.xyz")]) == 2
