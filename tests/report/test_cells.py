"""Crosstalk between cells as it is shown: a record, tables, a picture; and the command."""

import json

import numpy as np
import pytest

from sits_mech.batch import requests
from sits_mech.chain.cells import crosstalk as chain
from sits_mech.cli.main import run
from sits_mech.report.cells import cells_tables
from sits_mech.scene.cells import load_cells
from sits_mech.status import flags_of
from sits_mech.units import SceneError

SCENE = """
name = "two cells"
frequency = "5 MHz"
[[coils]]
name = "C"
centre = [0, 0]
turns = 5
layers = 2
inner_diameter = "1 mm"
track_width = "0.1 mm"
track_gap = "0.1 mm"
track_thickness = "35 um"
layer_pitch = "85 um"
[target]
material = "copper"
shape = "rectangle"
width = "8 mm"
length = "8 mm"
thickness = "0.2 mm"
[elastomer]
material = "ecoflex-00-30"
width = "30 mm"
length = "20 mm"
thickness = "2 mm"
[[targets]]
name = "left"
centre = ["-5 mm", 0]
[[targets]]
name = "right"
centre = ["5 mm", 0]
"""


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene of two cells, and crosstalk that takes no time."""
    path = tmp_path / "cells.toml"
    path.write_text(SCENE)

    def known(cells, tolerance, load=1.0):
        strain, n = 0.083 if load < 5.0 else np.inf, len(cells.targets)
        mechanical = np.zeros((n, 1, n, 3))
        mechanical[..., 0] = -0.0501
        mechanical[0, 0, 1, 0], mechanical[range(n), 0, range(n), 0] = -0.0801, 1.0
        magnetic = np.where(mechanical == 1.0, 0.0, 1e-4)
        parts = mechanical, magnetic, np.full_like(magnetic, 0.002)
        flags = flags_of(0.002, tolerance, bounded=np.isfinite(strain))
        return chain.CellCrosstalk(cells, ("F_z",), *parts, load, strain, 1.0, flags)

    monkeypatch.setattr(chain, "cell_crosstalk", known)
    return path


def test_the_command_answers_in_tables_json_and_a_picture(scene, tmp_path, capsys):
    drawn = tmp_path / "cells.png"
    assert run(["cells", str(scene), "--load", "2 N", "--picture", str(drawn)]) == 0
    told = capsys.readouterr()
    assert "│ 8.00 +- 0.20 │" in told.out and "-8.00 +- 0.20" in told.out and "-5.00 +- 0.20" in told.out
    assert "0.01 % at most" in told.out and "8.3 % of each figure where a cell is pressed by 2 N" in told.out
    assert drawn.stat().st_size > 10_000 and f"written to {drawn}" in told.err
    assert run(["cells", str(scene), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["cells"] == ["left", "right"] and record["forces"] == ["F_z", "F_x", "F_y"]
    assert record["total"][0][0][1][0] == pytest.approx(-0.08) and record["load"] == 1.0


def test_a_touch_answers_in_tables_json_and_a_picture(tmp_path, capsys):
    """On a cover between two cells: both alike, mirror images."""
    path, drawn = tmp_path / "touched.toml", tmp_path / "touched.png"
    path.write_text(f"""{SCENE}
[cover]
material = "ecoflex-00-30"
thickness = "1 mm"
overhang = "1 mm"
[touch]
shape = "pressure"
width = "6 mm"
length = "6 mm"
""")
    assert run(["cells", str(path)]) == 2
    assert "touch.force must be a press above 0 N; got none" in capsys.readouterr().err
    assert run(["cells", str(path), "--load", "0.1 N", "--tolerance", "0.1", "--picture", str(drawn)]) == 0
    told = capsys.readouterr()
    assert "pressure 6 mm x 6 mm, 0.1 N" in told.out and "F_z [mN]" in told.out and drawn.stat().st_size > 10_000
    assert run(["cells", str(path), "--load", "0.1 N", "--tolerance", "0.1", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["cells"] == ["left", "right"] and record["coils"] == ["C"] and record["force"] == 0.1
    left, right = np.array(record["moved"])
    assert left == pytest.approx(right * [-1.0, 1.0, -1.0, 1.0, 1.0, -1.0], abs=1e-9)
    assert record["L"][0] == pytest.approx(record["L"][1], rel=1e-9) and record["components"][1] == "d_v"


def test_a_press_that_small_strain_does_not_hold_is_said(scene):
    found = chain.cell_crosstalk(load_cells(scene), 1e-2, 10.0)
    *_, last = cells_tables(found)
    assert "finite strain: not bounded where a cell is pressed by 10 N" in list(last.columns[1].cells)


def test_a_status_says_whether_the_figures_hold(scene, capsys):
    assert [run(["cells", str(scene), *more]) for more in (["--tolerance", "0.001"], ["--load", "10 N"])] == [4, 4]
    told = capsys.readouterr().out
    assert "status         │ above tolerance" in told and "status         │ not bounded" in told
    assert run(["cells", str(scene), "--tolerance", "0.001", "--accept", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "above tolerance"


def test_a_study_asks_for_the_largest_reading_over_the_pitch(scene):
    """Of two cells by `pitch_x`, of four by both; what does not fit on the pad is a line of its own."""
    variant, request = requests.Variant(SCENE.partition("[[targets]]")[0]), requests.REQUESTS["cells"]
    for asked in ({"pitch_x": "10 mm"}, {"pitch_x": "10 mm", "pitch_y": "10 mm", "tolerance": 0.1}):
        row = request.answer(variant, request.in_si(asked))
        assert row["F_z_by_F_z"] == pytest.approx(0.08) and row["error_F_z_by_F_z"] == 0.002 and row["status"] == "ok"
        assert row["F_z_by_F_x"] == pytest.approx(1e-4) and row["finite_strain"] == 0.083
    with pytest.raises(SceneError, match="overlap: their centres must be at least 8.002 mm apart"):
        request.answer(variant, request.in_si({"pitch_x": "5 mm"}))
    with pytest.raises(SceneError, match="must lie on the pad"):
        request.answer(variant, request.in_si({"pitch_x": "24 mm"}))


def test_what_is_refused_takes_one_line(scene, capsys, monkeypatch):
    assert run(["pose", str(scene), "--fz", "1 N"]) == 2
    assert "targets must be left out here: `sits-mech cells` solves scenes of several" in capsys.readouterr().err
    monkeypatch.undo()
    assert run(["cells", str(scene), "--load", "0 N"]) == 2
    assert "load: must be a press above 0 N; got 0 N" in capsys.readouterr().err
    assert run(["cells", "biorob2018"]) == 2
    assert "targets must be given, [[targets]] with name and centre of each" in capsys.readouterr().err
