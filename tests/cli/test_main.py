"""The command line's contract: answers, exit codes, one line for each refusal, nothing half-written."""

import csv
import json
import logging
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from rich.table import Table

from sits_mech.analysis.ladder import LadderStep
from sits_mech.chain import models
from sits_mech.chain.models import mechanical_model
from sits_mech.cli import options
from sits_mech.cli.console import announcing, print_table
from sits_mech.cli.main import commands, run
from sits_mech.cli.options import LoadGrid
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.mechanics.block import BlockPad
from sits_mech.quantities import POSE, WRENCH, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor
from sits_mech.status import ANSWERED
from sits_mech.store import read_table

ROOT = Path(__file__).parents[2]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
REPORT = {"model", "unknowns", "iterations", "residual", "estimated_error", "seconds", "status", "notes", "left_out",
          "left_out_error", "not_estimated"}
PLANAR = ("--mechanics", "planar")  # the quicker one, where the answer plays no part
Capture = pytest.CaptureFixture[str]


def answer(capsys: Capture, *tokens: str) -> dict[str, object]:
    """Return the one JSON object a command prints."""
    assert run([*tokens, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert isinstance(found, dict)
    return found


def test_the_exit_code_is_that_of_the_status(capsys: Capture) -> None:
    """Within the data 0, beyond them 4 and 0 where that is accepted, where the layer folds 3; JSON says the same.

    Above the tolerance where the model asked for leaves too much out.
    """
    asked = ("--tolerance", "0.1", "--json")
    for model, force, more, code, status in (
        ("linear", "0.1 N", (), 0, "ok"), ("planar", "0.5 N", (), 4, "above tolerance"),
        ("planar", "0.5 N", ("--accept",), 0, "above tolerance"), ("planar", "8 N", (), 4, "beyond data"),
        ("planar", "8 N", ("--accept",), 0, "beyond data"), ("planar", "-60 N", ("--accept",), 3, "not carried"),
    ):
        assert run(["pose", "biorob2018", "--fz", force, "--model", model, *asked, *more]) == code
        out, err = capsys.readouterr()
        assert json.loads(out)["status"] == status and ("exit code 4" in err) == (code == 4)


def test_a_relative_number_may_be_written_in_percent(capsys: Capture, tmp_path: Path) -> None:
    """A tolerance and the strain that a fit goes to; another unit is refused by the option's name."""
    plain, *others = (
        answer(capsys, "pose", "biorob2018", "--fz", "0.1 N", "--model", "linear", "--tolerance", text)
        for text in ("0.1", "10%", "10 %")
    )
    assert all(other["pose"] == plain["pose"] for other in others)
    assert '--tolerance: must be a plain number; got "1 mm"' in refused(capsys, "pose", "s1", "--tolerance", "1 mm")
    assert "between 0 and 1; got 3" in refused(capsys, "envelope", "biorob2018", "--tolerance", "300 %")
    path, strain = tmp_path / "tensile.csv", np.linspace(0.0, 1.0, 21)
    rows = "".join(f"{e},{2e4 * (1.0 + e - (1.0 + e) ** -2)}\n" for e in strain)
    path.write_text(f"Engineering Strain,Engineering Stress (Pa)\n{rows}")
    fit = answer(capsys, "fit", str(path), "--law", "neo-hookean", "--max-strain", "50 %")
    assert fit["max_strain"] == 0.5


def test_constants_given_alone_are_named(capsys: Capture, tmp_path: Path) -> None:
    """By what plans and what solves a table, for a program too; a source is one."""
    table = 'elastomer.material={{law="neo-hookean", shear_modulus="30 kPa", bulk_modulus="30 MPa"{}}}'
    asked = ("biorob2018", *PLANAR, "--magnetics", "planar", "--tolerance", "10 %", "--fz", "0 N:0.1 N:2")
    for more, named in (("", True), (', source="a test"', False)):
        scene = "--set", table.format(more)
        notes = answer(capsys, "explain", "biorob2018", *scene)["notes"]
        run(["calibrate", *asked, *scene, "--fx", "0 N", "-o", str(tmp_path / str(named)), "--json"])
        both = [notes, json.loads(capsys.readouterr().out)["notes"]]
        assert [any("given without source" in str(note) for note in each) for each in both] == [named, named]


def refused(capsys: Capture, *tokens: str) -> str:
    """Return the one line that a command with bad input leaves."""
    assert run(tokens) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and "Traceback" not in err
    return err


def test_inductance_against_independent_numbers(capsys: Capture) -> None:
    """Planar model, copper 8 x 0.2 mm at d_v = 2 mm, d_h = 2 mm, 5 kHz.

    Source: NGSolve 6.2, order 5, confirmed by GetDP 3.2 to 2e-5 (L0 and M12 in closed form).
    """
    place = ("--dv", "2 mm", "--dh", "2 mm")
    found = answer(capsys, "inductance", "biorob2018", *place, "--frequency", "5 kHz", "--model", "planar", "--accept")
    assert found["report"]["left_out_error"] > 0.1 and found["status"] == "above tolerance"
    assert sum("the tolerance 0.001 is missed" in note for note in found["report"]["notes"]) == 1
    assert set(found) >= {"pose", "frequency", "unit_L", "L", "R", "L0", "relative", "R_dc", "report"}
    assert set(found["report"]) == REPORT and found["unit_L"] == "H/m" and found["frequency"] == 5e3
    L, R, L0 = (np.array(found[name]) for name in ("L", "R", "L0"))
    largest = 5.997367846259031e-06
    np.testing.assert_allclose(np.diagonal(L - L0), [-5.232550057347849e-07, -largest], rtol=0, atol=1e-3 * largest)
    np.testing.assert_allclose(np.diagonal(R), [0.03841497492722053, 0.49201650575606987], rtol=0, atol=1e-2 * 0.492)
    self_inductance, mutual = 0.00047480313357162, -4.7405988439865e-05
    np.testing.assert_allclose(L0, [[self_inductance, mutual], [mutual, self_inductance]], rtol=1e-6)
    np.testing.assert_allclose(found["relative"], np.diagonal(L) / np.diagonal(L0), rtol=1e-15)


def test_memory_reaches_the_plates_in_space(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line with the estimate, of a plate that no other test has prepared."""
    monkeypatch.setenv("SITS_MECH_MEMORY", "4")
    words = ("inductance", "biorob2018", "--dv", "5 mm", "--model", "sheets", "--set", 'target.width="7.7 mm"')
    said = refused(capsys, *words, "--memory", "0.001")
    assert "cells of the plate of 7.7 x 8 mm take some" in said and "more than the limit of 0.001 GiB (--memory" in said


def test_inductance_over_a_range(capsys: Capture) -> None:
    """Lists along the frequency; one frequency keeps its record, without terminals where L is per metre."""
    words = ("inductance", "biorob2018", "--dv", "2 mm", "--model", "planar", "--accept", "--frequency")
    found = answer(capsys, *words, "1 kHz:10 MHz:3")
    assert set(found) >= {"pose", "unit_L", "frequency", "L", "R", "Q", "L0", "report"} and "terminals" not in found
    np.testing.assert_allclose(found["frequency"], [1e3, 1e5, 1e7], rtol=1e-12)
    assert np.shape(found["L"]) == np.shape(found["R"]) == (3, 2, 2) and np.shape(found["Q"]) == (3, 2)
    assert set(found["report"]) == REPORT and np.shape(found["L0"]) == (2, 2)
    assert sum("the tolerance 0.001 is missed" in note for note in found["report"]["notes"]) == 1
    alone = answer(capsys, *words, "10 MHz")
    np.testing.assert_array_equal(alone["L"], found["L"][2])
    assert "terminals" not in alone and any(item["what"] == "terminals" for item in alone["report"]["left_out"])


@pytest.mark.slow
def test_terminals_in_henry_and_ohm(capsys: Capture) -> None:
    """The lead adds to L and R; the record has what each coil shows. Uneven current is in R already."""
    words = ("inductance", "biorob2018", "--dv", "5 mm", "--model", "sheets", "--tolerance", "1e-2", "--frequency")
    found = answer(capsys, *words, "10 kHz", "--set", 'readout.idle_coil="open"', "--set", "readout.lead_resistance=2")
    seen = found["terminals"]
    own = {"own_capacitance", "self_resonance"}
    assert set(seen) == {"L", "R", "R_ac", "Q", "delta_L_ac", "apparent", "tank_frequency"} | own
    np.testing.assert_allclose(seen["L"], np.diagonal(found["L"]), rtol=1e-14)
    R_dc = [track_resistance(coil) for coil in load_sensor("biorob2018").coils]
    np.testing.assert_allclose(seen["R"], np.diagonal(found["R"]) + R_dc + 2.0, rtol=1e-14)
    assert np.all(np.array(seen["R_ac"]) > R_dc)


@pytest.mark.slow
def test_pose_against_independent_numbers(capsys: Capture) -> None:
    """Neo-Hookean 30 kPa, K = 30 MPa, 20/15/2 mm, 267 N/m and 4050 N/m at the target's bottom face, in plane strain.

    Source: NGSolve 6.2 (four discretisations) and FElupe 11.3; bars as given there. A length of 1 m makes newtons N/m.
    """
    overrides = (
        'elastomer.material={law="neo-hookean", shear_modulus="30 kPa", bulk_modulus="30 MPa"}',
        'elastomer.width="20 mm"', 'elastomer.length="1 m"', 'elastomer.thickness="2 mm"', 'target.width="15 mm"',
        'target.length="1 m"', 'target.load_height="0 mm"',
    )
    tokens = [word for override in overrides for word in ("--set", override)]
    words = ("pose", "biorob2018", "--fx", "267 N", "--fz", "4050 N", "--model", "planar", "--accept")
    found = answer(capsys, *words, *tokens)
    assert set(found) >= {"pose", "wrench", "report"}
    assert set(found["report"]) == REPORT | {"min_J", "stretch", "error_stretch"}
    assert found["wrench"] == {"F_x": 267.0, "F_z": 4050.0, "M": 0.0, "F_y": 0.0, "M_x": 0.0, "M_z": 0.0}
    bars = {"d_h": (0.985277906103095e-3, 4.5e-6), "d_v": (2e-3 - 0.2032309354297509e-3, 4.0e-6)}
    for name, (expected, bar) in (bars | {"alpha": (0.0020452455720867636, 5.0e-4)}).items():
        assert abs(found["pose"][name] - expected) <= bar + found["error"][name]
    (ends, bending) = found["report"]["left_out"]
    assert bending["what"] == "bending of the target"  # of 0.2 mm of copper that these newtons press
    assert found["report"]["estimated_error"] - ends["size"] - bending["size"] < 3e-2  # a crease at the target's edge


@pytest.mark.slow
def test_explain_solves_the_ladder_of_a_load(capsys: Capture) -> None:
    """One object with rungs and sentence, progress on stderr; without a load, or an answer, it is refused."""
    words = ("explain", "biorob2018", "--fz", "1 N", *PLANAR, "--magnetics", "planar", "--tolerance", "0.1", "--ladder")
    assert run([*words, "--json"]) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert [rung["tolerance"] for rung in found["ladder"]] == [1e-1, 3e-2, 1e-2] and "2 to come" in err
    assert found["ladder"][-1]["difference"] == 0.0 and found["ladder_sentence"].endswith(" cannot be reached")
    assert run(words) == 0 and "from finest" in capsys.readouterr().out
    assert run(["explain", "biorob2018", "--ladder"]) == 2 and "ladder: must have a load" in capsys.readouterr().err
    failing = LadderStep(1e-1, 1.0, math.nan, math.nan, math.nan, math.nan, "SolveFailed: not carried; and why")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sits_mech.analysis.ladder.ladder", lambda *_, **__: [failing])
        assert run(words) == 3
    assert "not carried " in capsys.readouterr().out


def test_explain_and_fit_name_what_cannot_be(capsys: Capture, tmp_path: Path) -> None:
    """A scene and a file in the wrong unit: one line each; the answer comes all the same."""
    words = ("--set", 'elastomer.material={law="neo-hookean", shear_modulus="30 GPa", bulk_modulus="30 TPa"}')
    assert run(["explain", "biorob2018", "--fz", "1 N", *PLANAR, "--magnetics", "planar", *words]) == 0
    out, err = capsys.readouterr()
    assert "implausible" in out and err.count("\n") == 2 and "implausible: a shear modulus" in err
    path, strain = tmp_path / "tensile.csv", np.linspace(0.0, 1.0, 21)
    stress = 2e10 * (1.0 + strain - (1.0 + strain) ** -2)
    rows = "".join(f"{e},{s}\n" for e, s in zip(strain, stress, strict=True))
    path.write_text(f"Engineering Strain,Engineering Stress (Pa)\n{rows}")
    assert "implausible" in answer(capsys, "fit", str(path), "--law", "neo-hookean")["notes"][-1]


def test_fit_shows_what_it_reads(capsys: Capture, tmp_path: Path) -> None:
    """Columns, rows and notes, and a picture, without a fit; sizes and slack of the specimen from the command line."""
    strain = np.linspace(0.02, 1.0, 50)
    force = 24e-6 * 2e4 * (1.0 + strain - (1.0 + strain) ** -2)
    path = tmp_path / "machine.csv"
    rows = "".join(f"{25.0 * (e + 0.1)};{f}\n" for e, f in zip(strain, force, strict=True))
    path.write_text(f"Weg;Kraft\nmm;N\n0;0\n1;0\n2.5;0\n{rows}")
    sizes = ("--length", "25 mm", "--area", "24 mm2")
    found = answer(capsys, "fit", str(path), *sizes, "--show", "-o", str(tmp_path / "read.png"))["found"]
    assert found[0][1].startswith("Weg; Kraft: 50 rows taken, 3 left out") and "slack of 10 % off" in found[0][1]
    assert (tmp_path / "read.png").stat().st_size > 1000 and "law" not in str(found)
    fit = answer(capsys, "fit", str(path), *sizes, "--slack", "10 %", "--law", "neo-hookean")
    assert fit["constants"]["shear_modulus"] == pytest.approx(2e4, rel=1e-6)
    assert run(["fit", "--show"]) == 2 and run(["fit", str(path)]) == 2
    assert '--length "25 mm", or in a line above' in capsys.readouterr().err


@pytest.mark.slow
def test_explain_names_a_load_that_is_refused(capsys: Capture) -> None:
    """In a note; the plan comes all the same."""
    found = answer(capsys, "explain", "biorob2018", "--fz", "400 N")
    assert "a large load for this pad" in found["notes"][0] and "asked_error" in found


@pytest.mark.slow
def test_loads_that_are_passed_on_the_way_are_read(capsys: Capture) -> None:
    """With friction; where nothing is touched on the way, the answer is that without."""
    rough = ("--set", "elastomer.friction=0.5", "--via", "fx=0.2 N, fz=0 N", "--via", "F_z=1 N, F_x=0.2 N")
    plain, found = (answer(capsys, "pose", "biorob2018-w15", "--fz", "1 N", *more) for more in ((), rough))
    assert found["wrench"] == plain["wrench"] and found["pose"]["d_v"] == pytest.approx(plain["pose"]["d_v"], rel=1e-4)


@pytest.mark.slow
def test_a_pose_is_solved_finer_beside_what_its_target_bends(capsys: Capture) -> None:
    """Bending, left out, is 0.7 % of the sink: it is solved, and numerics are within what it leaves of a percent."""
    law = '{law="yeoh", c10="8 kPa", c20="0.6 kPa", c30="0.05 kPa", bulk_modulus="16 MPa"}'
    found = answer(capsys, "pose", "biorob2018-w15", "--fz", "2 N", "--set", f"elastomer.material={law}")
    assert "bends by up to" in json.dumps(found) and found["report"]["estimated_error"] < 0.01
    assert all(item["what"] != "bending of the target" for item in found["report"]["left_out"])


def test_what_symmetry_forbids_is_zero(capsys: Capture) -> None:
    """A load straight down on a scene that is its own mirror image: neither shift nor tilt, without error."""
    words = ("--model", "planar", "--tolerance", "0.1", "--accept")
    found = answer(capsys, "pose", "biorob2018", "--fz", "2 N", *words)
    for part in (found["pose"], found["error"]):
        assert part["d_h"] == part["alpha"] == 0.0 < part["d_v"]


def test_simulate_joins_both(capsys: Capture) -> None:
    """Pose and impedance of one load, and their signals."""
    load = ("--fx", "-0.2 N", "--fz", "1 N")
    found = answer(capsys, "simulate", "biorob2018", *load, "--tolerance", "0.1")
    assert set(found) >= {"pose", "wrench", "L", "R", "L0", "relative", "signals", "report"}
    assert set(found["report"]) == {"mechanics", "magnetics"}
    whats = {half: [item["what"] for item in report["left_out"]] for half, report in found["report"].items()}
    assert whats["magnetics"] == ["mesh of the air", "current in the idle coil"]
    assert whats["mechanics"] == ["bending of the target"]
    assert all(report["left_out_error"] == 0.0 and not report["not_estimated"] for report in found["report"].values())
    L = np.array(found["L"])
    assert found["signals"]["L_v"] == pytest.approx(L[0, 0] + L[1, 1]) and found["pose"]["d_h"] < 0.0


@pytest.mark.parametrize("tokens", [
    ("catalog",), ("explain", "biorob2018", "--fz", "1 N"),
    pytest.param(("simulate", "biorob2018", "--fz", "1 N", *PLANAR, "--magnetics", "planar", "--accept"),
                 marks=pytest.mark.slow),
    ("inductance", "biorob2018", "--dv", "2 mm", "--model", "planar", "--accept"),
    ("inductance", "biorob2018", "--dv", "2 mm", "--model", "planar", "--frequency", "1 Hz:9 Hz:3", "--accept"),
    pytest.param(("pose", "biorob2018", "--fx", "-0.2 N"), marks=pytest.mark.slow),
])
def test_answers_for_a_reader(capsys: Capture, tokens: tuple[str, ...]) -> None:
    """Tables on stdout; on stderr what a load is to take, and what a simulation planned and took."""
    assert run(tokens) == 0
    out, err = capsys.readouterr()
    first, *others = [line for line in err.splitlines() if not line.startswith("  ")] or [""]
    assert len(out) > 100
    assert first.startswith("to solve: ") if tokens[0] in ("explain", "simulate", "pose") else first == ""
    assert [line[:9] for line in others] == ["planned: "] * (tokens[0] == "simulate")


@pytest.mark.slow
def test_doctor_knows_what_is_installed(capsys: Capture) -> None:
    """The tests run, so the core is there."""
    assert run(["doctor"]) == 0
    assert "numpy" in capsys.readouterr().out


@pytest.mark.parametrize(("tokens", "expected"), [
    (("pose", "nowhere.toml"), "nowhere.toml"),
    (("pose", "biorob2018", "--fx", "2 mm"), "--fx: must be a force"),
    (("pose", "biorob2018", "--model", "blok"), "one of auto, closed-form, linear, planar, axisymmetric, block"),
    (("pose", "biorob2018", "--tolerance", "two"), "tolerance"),
    (("pose", "biorob2018", "--set", "target.wdth=1"), "wdth"),
    (("pose", "biorob2018", "--via", "fz=4 N"), "via: must be left out without elastomer.friction"),
    (("pose", "biorob2018", "--via", "4 N"), "--via: must be a load such as"),
    (("simulate", "biorob2018", "--via", "F_z=4 mm"), "--via F_z: must be a force"),
    (("pose", "biorob2018", "--via", "fz=4 N, F_z=2 N"), "--via: must give F_z once"),
    (("pose", "biorob2018", "--weld"), "elastomer: weld must be false without a mesh; got true"),
    (("inductance", "biorob2018"), "--dv"),
    (("inductance", "biorob2018", "--dv", "2 N"), "--dv: must be a length"),
    (("inductance", "biorob2018", "--dv", "2 mm", "--frequency", "-1 Hz"), "frequency"),
    (("inductance", "biorob2018", "--dv", "2 mm", "--frequency", "0 Hz:1 MHz:5"), "--frequency: must be a positive"),
    (("inductance", "biorob2018", "--dv", "2 mm", "--frequency", "1 Hz:1 MHz"), "must be first:last:count"),
    (("inductance", "biorob2018-w15", "--dv", "2 mm", "--alpha", "20 deg"), "above the coil plane"),
    (("inductance", "biorob2018-w22", "--dv", "2 mm", "--alpha", "20 deg"), "above the coil plane"),
    (("calibrate", "biorob2018", "--fx", "0 N:1 N", "-o", "unused"), "--fx: must be first:last:count"),
    (("calibrate", "biorob2018", "--fz", "0 N:1 N:1", "-o", "unused"), "--fz: must be first:last:count"),
    (("calibrate", "biorob2018", "--fz", "", "-o", "unused"), '--fz: must be a force, such as "2 N"'),
    (("pose", "biorob2018", "--fx", "", "--fz", "1 N"), '--fx: must be a force, such as "2 N"'),
    (("inductance", "biorob2018", "--dv", ""), '--dv: must be a length, such as "2 mm"'),
    (("fit", "nowhere.csv"), "nowhere.csv"),
    (("view", "biorob2018", "--dv", "2 mm", "--fz", "1 N"), "--dv: must not be given together with a load"),
    (("view", "biorob2018", "--dv", "2 mm", "--kind", "layer"), "--kind layer: must have a load"),
    (("view", "biorob2018", "--fy", "1 N", "--kind", "field"), "F_y must be zero for the model planar-fem"),
    (("view", "triaxial-3", "--fz", "1 N", "--kind", "field"), "--kind field: must have every coil on y = 0"),
    (("view", "biorob2018", "--dv", "2 mm", "--alphaz", "1 deg"),
     "alpha_z must be zero for the model planar-fem, and --kind field, which is plane"),
    (("view", "biorob2018", "--alphaz", "1 deg"), "--dv: must be given for a pose"),
    (("view", "biorob2018", "-o", "picture.bmp"), "--output: must end in .png"),
    (("cycle", "biorob2018", "--fz", "1 N", "--picture", "loop.nc"), "--picture: must end in .png"),
    (("view", "biorob2018", "-o", "nowhere/picture.png"), "--output: must be in a folder"),
    (("view", "biorob2018", "--driven", "C9"), "--driven: must be one of C1, C2"),
    (("view", "biorob2018", "--kind", "photograph"), "photograph"),
    (("view", "biorob2018", "--kind", "scene", "--driven", "C1"), "--driven: must be left out with --kind scene"),
    (("view", "biorob2018", "--fz", "1 N", "--frequency", "5 kHz"), "--frequency: must be left out with --kind layer"),
    (("view", "biorob2018", "--dv", "2 mm", "--show", "stretch"), "--show: must be left out with --kind field"),
    (("cycle", "biorob2018", "--fz", "1 N", "-o", "nowhere/x.nc"), "--output: must be in a folder that exists"),
    (("envelope", "biorob2018", "--rays", "3", "-o", "unused"), "--rays: must be a multiple of four; got 3"),
    (("design", "nowhere.toml", "-o", "unused"), "nowhere.toml: must be a readable requirement file"),
    (("sweep", "nowhere.toml", "-o", "unused"), "nowhere.toml: must be a readable study file"),
    (("fit", "--relaxation", "nowhere.csv"), "nowhere.csv: must be a readable relaxation test"),
    (("unknown",), "unknown"),
])
def test_bad_input_is_one_line(capsys: Capture, tokens: tuple[str, ...], expected: str) -> None:
    """Which input, what it must be, what came; exit 2."""
    assert expected in refused(capsys, *tokens)
    assert not Path("unused").exists()


def test_a_closed_stdout_is_one_line() -> None:
    """An answer has to go somewhere; with stderr closed as well the exit code says it."""
    for closed, lines in ((">&-", 1), (">&- 2>&-", 0)):
        done = subprocess.run(["sh", "-c", f"{sys.executable} -m sits_mech catalog {closed}"], stderr=-1, text=True)
        assert done.returncode == 2 and done.stderr.count("\n") == lines and "Traceback" not in done.stderr


def test_long_steps_are_announced(capsys: Capture) -> None:
    """At once, before they begin; short ones only when nothing was said for a while."""
    log = logging.getLogger("sits_mech.some.model")
    with announcing():
        for seconds in (5.0, 20.0):
            log.info("about %g s", seconds, extra={"seconds": seconds})
    assert capsys.readouterr().err == "  about 20 s\n"


def test_what_is_solved_is_printed_and_written(capsys: Capture, tmp_path: Path) -> None:
    """By -v on stderr, by --log in a file with times; the answer is the same, and nothing is said without them."""
    file, own = tmp_path / "log", ("--set", "target.width=7.93 mm", "--tolerance", "0.1", "--json")
    words = ["inductance", "biorob2018", "--dv", "3.3 mm", "--model", "sheets", *own]
    assert run([*words, "-v", "--log", str(file), "--no-cache"]) == 0
    told, rows = capsys.readouterr(), file.read_text().splitlines()
    assert run(words) == 0
    alone = capsys.readouterr()
    assert json.loads(told.out)["L"] == json.loads(alone.out)["L"] and not alone.err
    assert "a plate of" in told.err and all(re.match(r"\d{4}-\d\d-\d\d .* sits_mech\.", row) for row in rows)
    assert [row.partition(": ")[2] for row in rows] == [line.strip() for line in told.err.splitlines()]
    assert run([*words, "--log"]) == 2 and "--log: must be followed by a file" in capsys.readouterr().err
    assert run(["catalog", "--log=" + str(tmp_path / "nowhere" / "l")]) == 2
    assert not logging.getLogger("sits_mech").handlers


@pytest.mark.parametrize("words", ["catalog", "--help", "schema scene"])
def test_who_reads_may_leave(words: str) -> None:
    """As `cat | head`: quiet, and no code of an answer that is no good."""
    line = f"({sys.executable} -m sits_mech {words}; echo $? >&2) | true"
    done = subprocess.run(["sh", "-c", line], env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert done.stderr.strip() == "141"


def test_a_search_of_nothing_leaves_no_folder(capsys: Capture, tmp_path: Path) -> None:
    """Neither no designs nor no processes."""
    asked = tmp_path / "asked.toml"
    asked.write_text('scene = "biorob2018"\n[loads]\nF_z = ["0 N", "0.2 N"]\n[vary]\n"elastomer.thickness" = '
                     '["2 mm", "7 mm"]\n[require]\nheight = "4 mm"\n[goal]\nminimise = "feasible"\n')
    for more, why in ((("--most", "0"), "most: must be one or more designs; got 0"),
                      (("-j", "0"), "processes must be one or more; got 0")):
        assert why in refused(capsys, "design", str(asked), "-o", str(tmp_path / "out"), *more)
        assert not (tmp_path / "out").exists()


def test_the_best_is_taken_at_each_temperature(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """As at one."""
    def simulated(*_: object, best: bool = False, **__: object) -> None:
        """Say what came."""
        raise SceneError(f"best: {best}")

    monkeypatch.setattr("sits_mech.chain.simulate.simulate", simulated)
    words = ("simulate", "biorob2018", "--fz", "1 N", "--temperature", "0 degC:40 degC:3")
    assert "best: True" in refused(capsys, *words) and "best: False" in refused(capsys, *words, "--no-best")


def test_folder_that_cannot_be_written(capsys: Capture, tmp_path: Path) -> None:
    """Said before anything is solved."""
    (tmp_path / "file").write_text("")
    assert "must be a folder" in refused(capsys, "calibrate", "biorob2018", "-o", str(tmp_path / "file" / "below"))


def test_a_solve_that_fails_is_answered_by_any_command(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """By one that does not look for it as well."""
    def failed(*_: object, **__: object) -> None:
        raise SolveFailed("lost", SolveReport("block", 1, 1, 0.0, 1.0, 0.0, "load path ended"))

    monkeypatch.setattr("sits_mech.analysis.envelope.envelope", failed)
    assert run(["envelope", "biorob2018-w15", "--json"]) == 3
    answer = capsys.readouterr()
    assert json.loads(answer.out)["message"] == "lost" and "not converged (load path ended): lost" in answer.err


@pytest.mark.slow
def test_a_load_too_large(capsys: Capture) -> None:
    """Exit 3; the last state that converged is what is printed, and it is said not to be the answer."""
    asked = ["biorob2018", "--fz", "5000 N", "--tolerance", "0.2", "--set", 'elastomer.contact="never"', "--json"]
    assert run(["pose", *asked, "--model", "planar"]) == 3
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert err.splitlines()[1].startswith("not converged") and found["report"]["status"] != "converged"
    assert 0.0 <= found["wrench"]["F_z"] < 5000.0 and 0.0 < found["pose"]["d_v"] <= 2e-3
    assert set(found["error"]) == set(found["pose"]) and found["message"] in err
    assert run(["simulate", *asked, "--mechanics", "linear", "--magnetics", "planar"]) == 3
    report = json.loads(capsys.readouterr().out)["report"]
    assert report["mechanics"]["status"] != "converged" and report["magnetics"] is None


@pytest.mark.slow
def test_all_six_components_reach_a_calibration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ranges become lists, single quantities numbers; what is zero is not passed on; the default is in the plane."""
    asked = []

    def refuses(_: object, **words: object) -> None:
        asked.append({name: values for name, values in words.items() if name in WRENCH})
        raise SceneError("seen")

    monkeypatch.setattr("sits_mech.chain.calibrate.calibrate", refuses)
    words = ["--fx", "0 N", "--fz", "1 N", "--fy", "0 N:1 N:2", "--mx", "1 N*mm", "--moment=-1 N*mm:1 N*mm:3"]
    assert run(["calibrate", "biorob2018", *words, "-o", str(tmp_path)]) == 2
    assert asked[0] == {"F_z": 1.0, "F_y": [0.0, 1.0], "M_x": 1e-3, "M": [-1e-3, 0.0, 1e-3]}
    assert run(["calibrate", "biorob2018", "-o", str(tmp_path)]) == 2
    assert {name: len(values) for name, values in asked[1].items()} == {"F_x": 9, "F_z": 9}


@pytest.mark.slow
def test_a_pose_beside_the_plane_is_answered_in_space(capsys: Capture) -> None:
    """All six keys; a plane model refuses by name, and a pose without height is none."""
    place = ("inductance", "biorob2018", "--dv", "2 mm", "--dy", "0.5 mm", "--alphax", "1 deg", "--tolerance", "0.1")
    found = answer(capsys, *place)
    assert found["pose"] == pytest.approx(dict.fromkeys(POSE, 0.0) | {"d_v": 2e-3, "d_y": 5e-4, "alpha_x": np.pi / 180})
    assert found["unit_L"] == "H" and found["report"]["model"] == "sheets"
    assert "alpha_x, d_y must be zero for planar" in refused(capsys, *place, "--model", "planar")
    assert "--dv: must be given" in refused(capsys, "inductance", "biorob2018", "--dy", "1 mm")


def test_what_a_load_in_space_reached_is_printed(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit 3: all six components of the last state, for a reader and for a program."""
    report = SolveReport("block", 10, 3, 1e-3, 0.1, 0.2, "load path ended", min_J=0.4)
    pose, load = Pose(1e-4, 2e-3, 1e-3, 2e-4, 1e-3, 2e-3), Wrench(0.1, F_y=0.2, M_z=1e-3)
    last = Equilibrium(load, pose, Pose(0.0, 0.0), np.zeros(0), report)

    def fails(*_: object, **__: object) -> None:
        raise SolveFailed("block: ended", report, last)

    monkeypatch.setattr(BlockPad, "equilibrium", fails)
    words = ["pose", "biorob2018", "--fx", "2 N", "--fy", "1 N", "--mz", "10 N*mm"]
    assert run(words) == 3
    out, err = capsys.readouterr()
    assert all(name in out for name in (*POSE, "F_y = 0.2 N", "M_z = 0.001 N m"))
    assert err.startswith("to solve: block") and err.count("\n") == 2
    assert run([*words, "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    assert list(found["pose"]) == list(found["error"]) == list(POSE) and found["pose"]["d_y"] == 2e-4
    assert list(found["wrench"]) == list(WRENCH) and found["report"]["status"] == "load path ended"


def test_an_inductance_out_of_reach(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit 3 with the report, for one frequency and for a range."""
    from sits_mech.magnetics.bars import PlanarBars

    def fails(*_: object) -> None:
        raise SolveFailed("planar: not reached", SolveReport("planar", 10, 1, 1.0, 0.5, 0.1, status="not reached"))

    monkeypatch.setattr(PlanarBars, "impedance", fails)
    for hertz in ("5 MHz", "1 kHz:1 MHz:3"):
        words = ("--model", "planar", "--frequency", hertz, "--json")
        assert run(["inductance", "biorob2018", "--dv", "2 mm", *words]) == 3
        out, err = capsys.readouterr()
        assert json.loads(out)["report"]["status"] == "not reached" and err.startswith("not converged")


def test_what_is_written_is_answered_to_a_program(capsys: Capture, tmp_path: Path) -> None:
    """JSON alone on stdout, of every command that writes; with --quiet nothing else but errors."""
    made, table = tmp_path / "made", tmp_path / "t.csv"
    words = ("--fx", "-0.2 N:0.2 N:2", "--fz", "0 N:0.5 N:2", "--mechanics", "linear", "--magnetics", "planar")
    words = (*words, "--tolerance", "0.1", "-o", str(made), "--accept", "--json", "--quiet")
    assert run(["calibrate", "biorob2018", *words]) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert err == "" and found["written"] == [str(made)] and sum(found["statuses"].values()) == 4
    assert 0.0 < found["seconds"] < 600.0 and {"error", "notes"} < {*found}
    study = tmp_path / "study.toml"
    study.write_text('scene = "biorob2018"\nrequest = "pose"\nvary.fz = ["0 N", "1 N"]\nfixed.model = "linear"\n')
    for tokens, path in (
        (["export", str(made), "--to", "csv", "-o", str(table)], table),
        (["report", str(made), "-o", str(tmp_path / "r.html")], tmp_path / "r.html"),
        (["view", "biorob2018", "-o", str(tmp_path / "v.png")], tmp_path / "v.png"),
        (["sweep", str(study), "-o", str(tmp_path / "swept"), "--accept"], tmp_path / "swept"),
    ):
        assert run([*tokens, "--json", "--quiet"]) == 0 and path.exists()
        out, err = capsys.readouterr()
        assert json.loads(out)["written"] == [str(path)] and err == ""
    assert "no-such.toml" in refused(capsys, "pose", "no-such.toml", "--quiet")
    assert run(["export", str(made), "--to", "csv", "-o", str(table)]) == 0
    assert f"written to {table}" in capsys.readouterr().err  # the next command tells again


def test_completion_is_made_for_a_shell() -> None:
    """As the command-line library makes it, with our commands."""
    script = commands().generate_completion(prog_name="sits-mech", shell="bash")
    assert "calibrate" in script and "--install-completion" in script


def test_calibrate_leaves_everything(capsys: Capture, tmp_path: Path) -> None:
    """Table, CSV, scene, pictures; a table on stdout whose every figure has an error; no torn or stray file."""
    folder = tmp_path / "out"
    loads = ("--fx", "-0.5 N:0.5 N:3", "--fz", "0 N:2 N:2")
    assert run(["calibrate", "biorob2018", *loads, *PLANAR, "--magnetics", "planar", "-o", str(folder)]) == 4
    out, err = capsys.readouterr()
    assert all(f"left out: {name}: " in out + err for name in ("ends of pad and target along y", "ends along y"))
    figures = out.count("+-") + out.count("below its error") + len(re.findall(r"│ +0 ", out[out.index("━") :]))
    assert figures >= 6 * 5 + 8 and "nan" not in out
    names = {"L_h.png", "L_v.png", "cases", "crosstalk.png", "layer.png", "result.csv", "result.nc", "scene.toml"}
    assert set(os.listdir(folder)) == names
    data = read_table(folder / "result.nc")
    sizes = {"F_x": 3, "F_z": 2, "coil": 2, "coil_2": 2}
    assert sizes.items() <= dict(data.sizes).items() and np.all(data["status"].sel(F_z=2.0) == "above tolerance")
    lines = (folder / "result.csv").read_text().splitlines()
    assert len(lines) == 7 and lines[0].startswith("F_x [N],F_z [N],status")
    assert load_sensor(folder / "scene.toml") == load_sensor("biorob2018")


@pytest.mark.slow
@pytest.mark.parametrize(
    "tokens",
    [
        ("--fz", "1 N"),
        pytest.param(("--dv", "2 mm", "--frequency", "5 kHz", "--driven", "C1"), marks=pytest.mark.slow),
    ],
)
def test_view_draws(capsys: Capture, tmp_path: Path, tokens: tuple[str, ...]) -> None:
    """The layer for a load, the field for a pose."""
    assert run(["view", "biorob2018", *tokens, "-o", str(tmp_path / "picture.png")]) == 0
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().err == f"written to {tmp_path / 'picture.png'}\n"


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_calibration_keeps_what_is_done(tmp_path: Path, ending: signal.Signals) -> None:
    """Exit 130 for Ctrl-C and a scheduler's end of a job, one line, finished loads on disk, none torn."""
    command = (sys.executable, "-m", "sits_mech", "calibrate")
    words = [*command, "biorob2018", *PLANAR, "--magnetics", "planar", "-o"]
    folder = tmp_path / "out"
    started = subprocess.Popen(
        [*words, str(folder)], env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell's background has it ignored
    )
    cases = folder / "cases"
    whole = "[!.]*.json"  # not the file that is being written, which goes when it is interrupted
    while len(list(cases.glob(whole))) < 3 and started.poll() is None:  # however long a busy machine takes
        time.sleep(0.01)
    started.send_signal(ending)
    _, err = started.communicate(timeout=300)
    kept = list(cases.glob("*.json"))
    assert not list(cases.glob(".*"))
    assert started.returncode == 130 and b"interrupted" in err and b"Traceback" not in err
    assert len(kept) >= 3 and all("status" in json.loads(path.read_text()) for path in kept)
    assert not (folder / "result.nc").exists()


@pytest.mark.parametrize("before", [signal.SIG_DFL, signal.SIG_IGN])
def test_an_ignored_end_stays_ignored(before: signal.Handlers) -> None:
    """As who starts the command has it, a shell's trap for one; else it is an interruption."""
    code = "import signal, sys; from sits_mech.cli import main\nsys.argv = ['sits-mech', '-h']\ntry: main.main()\n"
    code += "except SystemExit: print(signal.getsignal(signal.SIGTERM) is signal.default_int_handler)"
    done = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True, timeout=60,
                          preexec_fn=lambda: signal.signal(signal.SIGTERM, before))
    assert (done.stdout.split()[-1], done.stderr) == (str(before == signal.SIG_DFL), "")


_SOLVING = {"scipy", "xarray", "pandas", "skfem", "pint"}
_ALL_HEAVY = {*_SOLVING, "numpy", "pydantic", "matplotlib"}
_DRAWN = """
from sits_mech.report.pictures.drawing import scene_drawing
from sits_mech.report.pictures.style import figure_bytes
from sits_mech.scene.sensor import load_sensor
figure_bytes(scene_drawing(load_sensor("biorob2018-w15")), "svg")
"""
_TABLE = """
import sys; from sits_mech.cli.main import main
sys.argv = "sits-mech calibrate biorob2018 --mechanics linear --magnetics planar --tolerance 0.1 --accept -o".split()
sys.argv += [{!r}, "--quiet", "--fz", "0 N:1 N:2", "--fx", "0 N"]
try: main()
except SystemExit as ended: assert not ended.code
"""


@pytest.mark.parametrize(("words", "heavy"), [
    ("import sits_mech", _ALL_HEAVY), ("import sys; from sits_mech.cli.main import run; run(['-h'])", _ALL_HEAVY),
    (_DRAWN, _SOLVING), (_TABLE, {"meshio", "gmsh", "pyvista", "distributed"}),
    ("from sits_mech.cli.main import run; import os, sys; sys.stdout = sys.stderr = open(os.devnull, 'w')\n"
     "assert run('pose biorob2018 --fz 0.1N --mechanics linear --accept'.split()) == 0; sys.stderr = sys.__stderr__",
     {"xarray", "pandas"}),
    ("import sits_mech.batch.forecast, sits_mech.batch.studies.study, sits_mech.report.tables.cases",
     {"xarray", "pandas", "scipy.optimize", "scipy.interpolate"}),
])
def test_what_costs_nothing(words: str, heavy: set[str], tmp_path: Path) -> None:
    """Neither import nor help loads the heavy half, a drawing none of what solves, a table nothing of others' use,
    a pose and what plans a study no tables."""
    program = words.format(str(tmp_path / "table")) if words is _TABLE else words
    code = f"{program}\nimport sys\nassert not {heavy} & set(sys.modules), {heavy} & set(sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
def test_linear_algebra_of_a_command_keeps_to_one_thread() -> None:
    """Whatever numpy brings is imported after the environment says so, unless the environment said otherwise before."""
    code = "import sys; from sits_mech.cli import main\nsys.argv = ['sits-mech', 'pose', 'nowhere']\ntry: main.main()\n"
    code += "except SystemExit: pass\nimport numpy, threadpoolctl\n"
    code += "assert {each['num_threads'] for each in threadpoolctl.threadpool_info()} == {%s}"
    own = {name: text for name, text in ENVIRONMENT.items() if not name.endswith("_NUM_THREADS")}
    for more, threads in (({}, 1), ({"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}, 2)):
        words = [sys.executable, "-c", code % threads]
        done = subprocess.run(words, env=own | more, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr


REFUSED_AT_ONCE = (
    ("report", "nowhere"), ("invert", "{made}", "--l1", "1:2", "--l2", "92 %"), ("invert", "{made}", "--l1", "92 %"),
    ("report", "{made}", "--case", "3"), ("converter", "{made}", "--rcount", "1"),
    ("quality", "{made}", "--samples", "3"), ("pose", "biorob2018", "--fx", "1e308 N"), ("pose", "nowhere"),
    ("calibrate", "biorob2018-w15", "--fz", "-1e9 N", "-o", "unused"), ("sweep", "nowhere.toml", "-o", "unused"),
    ("simulate", "biorob2018", "--tolerance", "2"), ("simulate", "biorob2018", "--magnetics", "nothing"),
    ("cycle", "biorob2018", "--picture", "loop.nc"), ("quality", "{made}", "--period", "soon"), ("fit", "nowhere.csv"),
    ("compare", "{made}", "nowhere.csv"), ("view", "biorob2018", "-o", "picture.bmp"),
    ("view", "biorob2018", "--driven", "C9"), ("view", "biorob2018", "--frequency", "soon"),
    ("view", "biorob2018", "--fz", "1 N", "--kind", "scene"), ("export", "{made}", "--to", "c", "-o", "table.cir"),
    ("inductance", "biorob2018", "--dv", "2 mm", "--frequency", "1 kHz:0 Hz:3"),
    ("export", "{made}", "--to", "c", "--fz", "1 N"), ("export", "{made}", "--to", "spice", "-o", "nowhere/x.cir"),
    ("compare", "{made}", "{made}/result.csv", "--magnetics", "sheets"),
)


def test_a_refusal_comes_before_what_is_heavy(calibrated: Path) -> None:
    """One line each, before solvers, tables and pictures are imported; in 0.5 s of processor time and 60 MB (measured);
    a unit of another dimension takes pint besides, 0.3 s."""
    code = "import json, sys; from sits_mech.cli.main import run\nfor tokens in json.loads(sys.argv[1]):\n"
    code += "    code = run(tokens)\n    assert code == 2, (tokens, code)\n"
    code += "    heavy = {'scipy', 'xarray', 'pandas', 'skfem', 'matplotlib'} & set(sys.modules)\n"
    code += "    assert not heavy, (tokens, heavy)"
    asked = [[token.format(made=calibrated) for token in tokens] for tokens in REFUSED_AT_ONCE]
    words = [sys.executable, "-c", code, json.dumps(asked)]
    done = subprocess.run(words, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    lines = done.stderr.splitlines()
    assert done.returncode == 0 and len(lines) == len(asked), done.stderr
    assert all(line.startswith("error: ") for line in lines), done.stderr
    assert not Path("unused").exists()


def test_loads_beyond_any_sense_are_told_with_what_could_be(capsys: Capture) -> None:
    """In a line without a path that was never begun; of Python alike; a load that only fails is none of them."""
    said = refused(capsys, "pose", "biorob2018", "--moment", "1e9 N*m")
    assert "M: must be within" in said and "carries more (see sits-mech envelope); got 1e+09 N m" in said
    with pytest.raises(SceneError, match=r"F_z: must be within .* N: no pad .*; got -1e\+09 N"):
        mechanical_model(load_sensor("biorob2018"), loads=[Wrench(F_z=-1e9)])


@pytest.mark.slow
def test_a_calibration_without_any_answer_is_told(capsys: Capture, tmp_path: Path) -> None:
    """Each load with its reason, exit 3, and the table that says so; no pictures."""
    words = ["--fx", "0 N", "--fz=-60 N:-50 N:2", *PLANAR, "--magnetics", "planar", "--tolerance", "0.2"]
    assert run(["calibrate", "biorob2018", *words, "-o", str(tmp_path)]) == 3
    said = capsys.readouterr()
    assert "F_z = -60 N: " in said.err and "no pictures: no load converged" in said.err and said.out == ""
    assert not read_table(tmp_path / "result.nc")["status"].isin(ANSWERED).any()


def test_models_by_name_are_those_of_the_chain() -> None:
    """The command line refuses others before the chain is imported."""
    assert options.MECHANICS == ("auto", *models.MECHANICS) and options.MAGNETICS == ("auto", *models.MAGNETICS)


def test_a_default_grid_has_the_forces_that_the_coils_resolve() -> None:
    """One coil F_z alone, a pair along y F_y in place of F_x; what is asked for is taken."""
    pair = load_sensor("biorob2018")
    turned = [coil.model_copy(update={"centre": coil.centre[::-1]}) for coil in pair.coils]
    along_y, one = (pair.model_copy(update={"coils": tuple(coils)}) for coils in (turned, pair.coils[:1]))
    found = [list(LoadGrid().components(sensor)) for sensor in (pair, along_y, one)]
    assert found == [["F_x", "F_z"], ["F_z", "F_y"], ["F_z"]]
    assert list(LoadGrid(fx="0 N:1 N:2").components(one)) == ["F_x", "F_z"]


@pytest.mark.slow
def test_what_has_more_forces_than_coils_is_not_exported(capsys: Capture, calibrated: Path, tmp_path: Path) -> None:
    """Neither header, page nor twin: at once, before a map is fitted."""
    copied = shutil.copytree(calibrated, tmp_path / "made")
    with netCDF4.Dataset(copied / "result.nc", "a") as file:
        file.request = json.dumps(json.loads(file.request) | {"F_y": [0.0, 1.0]})
    for form in ("c", "page", "twin"):
        said = refused(capsys, "export", str(copied), "--to", form, "-o", str(tmp_path / "out"))
        assert "coils: 2 cannot resolve 3 forces (F_x, F_z, F_y)" in said


def test_a_printed_table_is_cut_nowhere(capsys: Capture) -> None:
    """Where stdout is no terminal: units in brackets count for the width of a heading, as they are printed."""
    table = Table(*(f"alpha_{k} [mrad]" for k in range(20)), show_edge=False)
    for column in table.columns:
        column.no_wrap = True
    table.add_row(*["converged"] * 20)
    print_table(table)
    text = capsys.readouterr().out
    assert text.count("[mrad]") == 20 and text.count("converged") == 20 and "\N{HORIZONTAL ELLIPSIS}" not in text


def test_the_package_is_the_command() -> None:
    """By `python -m`, with its exit codes."""
    words = [sys.executable, "-m", "sits_mech", "explain", "nothing"]
    done = subprocess.run(words, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and done.stderr.startswith("error: nothing") and done.stderr.count("\n") == 1


def test_a_command_of_another_package(calibrated: Path, tmp_path: Path) -> None:
    """The page's: found beside our own once it is installed; modules that fail, or take a name of ours, are told."""
    page = (ROOT / "docs/howto/plugin.md").read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.*?)```", page, re.S)[1]
    (tmp_path / "sits_mech_largest.py").write_text(code, encoding="utf-8")
    (tmp_path / "sits_mech_pose.py").write_text(code.replace("largest", "pose"), encoding="utf-8")
    about = tmp_path / "sits_mech_largest-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: sits-mech-largest\nVersion: 1.0\n")
    names = "largest", "pose", "gone"
    lines = ["[sits_mech.commands]", *(f"{name} = sits_mech_{name}" for name in names)]
    (about / "entry_points.txt").write_text("\n".join(lines))
    own = ENVIRONMENT | {"PYTHONPATH": f"{ROOT}{os.pathsep}{tmp_path}"}
    words = [sys.executable, "-m", "sits_mech", "largest", str(calibrated), "--json"]
    done = subprocess.run(words, env=own, capture_output=True, text=True, timeout=60)
    change = abs(read_table(calibrated / "result.nc")["L_v_percent"])
    assert done.returncode == 0 and json.loads(done.stdout)["L_v_percent"] == pytest.approx(float(change.max()))
    told = [line.partition(":")[0] for line in done.stderr.splitlines()]
    assert told == ["gone", "pose"] and done.stderr.count("must be a module with commands that can be loaded") == 2


@pytest.mark.parametrize(
    "command",
    ["catalog", "doctor", "schema", "explain", "pose", "inductance", "simulate", "envelope", "calibrate", "fit", "view",
     "new", "import", "cells"],
)
def test_every_help_has_its_example(capsys: Capture, command: str) -> None:
    """One example each."""
    assert run([command, "--help"]) == 0
    assert capsys.readouterr().out.count(f"Example: sits-mech {command}") == 1


@pytest.mark.parametrize("file", ["scene", "study", "requirements", "bench"])
def test_schemas_are_printed_and_written(capsys: Capture, tmp_path: Path, file: str) -> None:
    """The same text on stdout and in a file; another kind of file is bad input."""
    assert run(["schema", file]) == 0
    printed = capsys.readouterr().out
    assert json.loads(printed)["title"].endswith("of sits-mech")
    assert run(["schema", file, "-o", str(tmp_path / "s.json")]) == 0
    assert (tmp_path / "s.json").read_text() == printed
    assert run(["schema", "novel"]) == 2


@pytest.mark.slow
def test_a_load_that_comes_and_goes(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A viscous silicone opens a loop, narrower once it has settled; the table is kept; another silicone has none."""
    law = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7'
    words = ["cycle", "biorob2018", "--fz", "1 N", "--mechanics", "linear", "--tolerance", "0.05", "--json", "--accept",
             "--set"]
    assert run([*words, f'{law}, prony=[{{weight=0.2, time="0.5 s"}}]}}', "-o", str(tmp_path / "c.nc"),
                "--picture", str(tmp_path / "c.svg")]) == 0
    out, told = capsys.readouterr()
    assert told.splitlines() == [f"written to {tmp_path / name}" for name in ("c.nc", "c.svg")]
    assert "cycle 2" in (tmp_path / "c.svg").read_text()
    found = json.loads(out)
    loops = found["loop_L_v_percent"]
    assert found["notes"] == [] and len(loops) == 2 and loops[0] > loops[1] > 1.0 and (tmp_path / "c.nc").exists()
    assert run([*words, law + "}"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["loop_L_v_percent"] == pytest.approx([0.0, 0.0], abs=1e-9) and "neither prony" in found["notes"][0]


@pytest.mark.slow
def test_over_temperature(capsys: Capture, tmp_path: Path) -> None:
    """A range is a row each, the pad rises; calibrate --drift, quality and invert by the temperature that is measured.

    A reading of 30 degC is taken for less force by a calibration at 20 degC, and rightly by one that is told.
    """
    models = ("--mechanics", "linear", "--magnetics", "planar", "--tolerance", "0.1")
    picture = tmp_path / "drift.png"
    found = answer(capsys, "simulate", "biorob2018", "--fz", "0.5 N", *models, "--temperature", "10 degC:30 degC:3",
                   "--picture", str(picture), "--accept")
    assert {each["status"] for each in found["temperatures"]} <= {"ok", "above tolerance"}
    assert found["temperature"] == pytest.approx([283.15, 293.15, 303.15]) and picture.stat().st_size > 10_000
    heights = [each["pose"]["d_v"] for each in found["temperatures"]]
    assert np.all(np.diff(heights) > 10 * 300e-6 * 2e-3)
    folder = str(tmp_path / "calibration")
    grid = ("--fx", "-0.2 N:0.2 N:3", "--fz", "0 N:1 N:3")
    assert run(["calibrate", "biorob2018", *grid, *models, "--drift", "--accept", "-o", folder]) == 0
    capsys.readouterr()
    drift = answer(capsys, "quality", folder)["drift"]
    assert drift["F_x"]["gain"]["by_cause"]["modulus"] == pytest.approx(-1.0 / 293.15, rel=0.05)
    zero = drift["F_z"]["zero"]
    assert sum(zero["by_cause"].values()) == pytest.approx(zero["whole"]) and zero["by_cause"]["pad"] < 0.0
    warm = np.diagonal(found["temperatures"][2]["L"])
    reading = [f"--l{k + 1}={value} H/m" for k, value in enumerate(warm)]
    blind, told = (answer(capsys, "invert", folder, *reading, *more) for more in ((), ("--temperature", "30 degC")))
    left = told["error_by_temperature"]["F_z"]
    assert told["forces"]["F_z"] == pytest.approx(0.5, abs=left) and 0.0 < left < 0.005
    assert blind["forces"]["F_z"] < 0.45 and "error_by_temperature" not in blind
    assert run(["invert", folder, *reading, "--temperature", "30 degC", "--budget"]) == 0
    assert "the correction for temperature" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("200 degC", "error: temperature: must be from -40 degC to 150 degC, where what is known of elastomer"),
        ("20", "error: temperature: must be from -55 degC to 200 degC"),
        ("warm", 'error: --temperature: must be a temperature, such as "20 degC"'),
        ("0 degC:9 degC", 'such as "-10 degC:60 degC:8"'),
    ],
)
def test_temperatures_that_cannot_be_are_refused(capsys: Capture, text: str, said: str) -> None:
    assert said in refused(capsys, "simulate", "biorob2018", "--temperature", text)


SPHERE = 'touch={shape="sphere", radius="5 mm", x="1 mm", force="0.1 N"}'


def test_a_touch_presses_by_its_own_force_where_no_load_is_named(capsys: Capture) -> None:
    """And by the command's where one is; what it is about the middle of the target stands beside the load."""
    asked = ("pose", "biorob2018-w15", "--set", SPHERE, "--model", "linear", "--tolerance", "0.1")
    own, named = answer(capsys, *asked), answer(capsys, *asked, "--fz", "0.2 N")
    assert (own["wrench"]["F_z"], named["wrench"]["F_z"]) == (0.1, 0.2)  # type: ignore[index]
    assert own["acting"]["M"] == pytest.approx(0.1e-3, rel=0.02)  # type: ignore[index]
    assert own["acting"]["F_x"] < 0.0 < own["pose"]["alpha"]  # type: ignore[index]


@pytest.mark.parametrize(("places", "words"), [
    ("z=1 mm", '--touch: must be places such as "x=-2 mm:2 mm:5, y=0 mm", each once; got'),
    ("x=1 mm, x=2 mm", "--touch: must be places such as"),
    ("x=1 N", "--touch x: must be"),
    ("x=-8 mm:8 mm:3", "touch: must lie on the target, a rectangle 15 mm x 8 mm"),
])
def test_places_of_a_touch_on_the_command_line(capsys: Capture, tmp_path: Path, places: str, words: str) -> None:
    """Others are refused in one line."""
    asked = ["calibrate", "biorob2018-w15", "--set", SPHERE, "--fz", "0.1 N", "--touch", places, "-o", str(tmp_path)]
    assert run(asked) == 2
    assert words in capsys.readouterr().err


@pytest.mark.slow
def test_a_table_over_places_is_read_back(capsys: Capture, tmp_path: Path) -> None:
    """By force and place; what a touch elsewhere makes of the force, and which exports know places."""
    folder, models = str(tmp_path / "places"), ("--mechanics", "linear", "--magnetics", "sheets", "--tolerance", "0.05")
    grid = ("--fz", "0.2 N:0.8 N:4", "--touch", "x=-2 mm:2 mm:5", "-o", folder, "--accept")
    assert run(["calibrate", "biorob2018-w15", "--set", SPHERE.replace("1 mm", "0 mm"), *grid, *models]) == 0
    rows = list(csv.DictReader((tmp_path / "places" / "result.csv").read_text().splitlines()))
    row = next(r for r in rows if float(r["F_z [N]"]) > 0.59 and float(r["touch_x [m]"]) == 1e-3)
    readings = [f"--l{k}={row[f'L_terminal[C{k}] [H]']} H" for k in (1, 2)]
    capsys.readouterr()
    found = answer(capsys, "invert", folder, *readings)
    assert found["forces"] == pytest.approx({"F_z": 0.6, "touch_x": 1e-3}, rel=0.02)
    figures = answer(capsys, "quality", folder, "--within", "1 mm", "--noise", "1 pH")
    assert 0.0 <= figures["misplaced"]["error"]["F_z"] < 0.02  # type: ignore[index]
    assert run(["export", folder, "--to", "twin", "-o", str(tmp_path / "t")]) == 2
    assert "of a table over touch_x" in capsys.readouterr().err
    assert run(["export", folder, "--to", "c", "-o", str(tmp_path / "t.h")]) == 0
    assert "touch_x [nm]" in (tmp_path / "t.h").read_text()
