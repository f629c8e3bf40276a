"""Samples, conditions, derived keys, several scenes: which cases a study has, and which of them are kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sits_mech.batch.run import run_study
from sits_mech.batch.studies.asked import Study
from sits_mech.batch.studies.samples import cube, expression, names_of, sampled
from sits_mech.batch.studies.study import read_study
from sits_mech.cases import grid_points
from sits_mech.cli.main import run
from sits_mech.units import SceneError

HEAD = 'scene = "biorob2018"\nrequest = "pose"\n'
SOBOL = HEAD + 'combine = "sobol"\nsamples = 8\n'
VARY = '[vary]\nfz = { from = "0 N", to = "1 N" }\n"elastomer.thickness" = { from = "2 mm", to = "3 mm" }\n'
COVERED = '[fixed]\nmodel = "closed-form"\n"target.width" = "20 mm"\n'  # which costs next to nothing
LINEAR = '[fixed]\nmodel = "linear"\ntolerance = 0.1\n'


def study(folder: Path, text: str) -> Study:
    """Return the study of a text."""
    (folder / "study.toml").write_text(text)
    return read_study(folder / "study.toml")


def test_samples_are_spread_and_nested() -> None:
    """A stratum of each key has a point each; Sobol' ones begin those of a larger number, Latin ones do not."""
    for combine in ("sobol", "latin"):
        strata = np.sort((16 * cube(combine, 16, 1, 3)).astype(int), axis=0)
        np.testing.assert_array_equal(strata, np.arange(16)[:, None].repeat(3, axis=1))
        same = np.array_equal(cube(combine, 16, 1, 3), cube(combine, 32, 1, 3)[:16])
        assert same == (combine == "sobol")
    np.testing.assert_array_equal(cube("sobol", 11, 0, 2), cube("sobol", 16, 0, 2)[:11])
    assert not np.array_equal(cube("sobol", 8, 0, 2), cube("sobol", 8, 1, 2))


def test_saltelli_has_a_column_of_b_for_each_key() -> None:
    a, b, first, second = np.split(cube("saltelli", 8, 0, 2), 4)
    np.testing.assert_array_equal(first, np.column_stack([b[:, 0], a[:, 1]]))
    np.testing.assert_array_equal(second, np.column_stack([a[:, 0], b[:, 1]]))


def test_ranges_keep_their_unit_and_lists_are_drawn_evenly() -> None:
    found = sampled({"a": (1.0, 3.0, "mm"), "b": ["x", "y"]}, np.array([[0.0, 0.0], [0.25, 0.99]]))
    assert found == {"a": ["1.0 mm", "1.5 mm"], "b": ["x", "y"]}


def test_more_samples_keep_those_that_were_solved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of Sobol' ones; that a Latin hypercube does not is told."""
    monkeypatch.chdir(tmp_path)
    for combine in ("sobol", "latin"):
        text = SOBOL.replace("sobol", combine) + VARY + COVERED
        few = run_study(study(tmp_path, text), tmp_path / combine)
        assert few["status"].dims == ("case",) and few["elastomer.thickness"].units == "m"
        assert few.attrs["combine"] == combine and few.attrs["samples"] == 8
        study(tmp_path, text.replace("samples = 8", "samples = 16"))
        assert run(["sweep", "study.toml", "-o", combine, "--accept"]) == 0
        told = capsys.readouterr().err
        assert ("not in this table: 8 finished" in told and "sobol keeps them" in told) == (combine == "latin")


def test_conditions_leave_cases_out_and_keys_are_derived(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the scene's keys, too; what is left out is never called, and counted."""
    text = HEAD + 'where = ["target.width <= 0.9 * elastomer.width", "fz < 2 * elastomer.thickness * 1e3"]\n'
    text += '[vary]\nfz = ["1 N", "5 N"]\n"elastomer.thickness" = ["2 mm", "3 mm"]\n'
    text += '[derive]\n"target.width" = "4 * elastomer.thickness"\nfx = "0.1 * fz"\n' + LINEAR
    found = study(tmp_path, text)
    points = grid_points(found.vary, found.combine)
    assert [(p["fz"], p["elastomer.thickness"], p["target.width"], p["fx"]) for p in points] == [
        ("1 N", "2 mm", 0.008, 0.1), ("1 N", "3 mm", 0.012, 0.1), ("5 N", "3 mm", 0.012, 0.5),
    ]
    assert found.left_out == 1
    monkeypatch.chdir(tmp_path)
    assert run(["sweep", "study.toml", "-o", "out", "--accept"]) == 0
    assert "left out: 1 of 4 cases" in capsys.readouterr().err
    assert run(["sweep", "study.toml", "--plan"]) == 0 and "left out: 1 of 4 cases" in capsys.readouterr().err


def test_scenes_are_a_dimension(tmp_path: Path) -> None:
    """The same numbers as of each scene alone, under its name."""
    text = HEAD.replace('"biorob2018"', '["biorob2018", "biorob2018-w15"]') + '[vary]\nfz = ["0 N", "1 N"]\n' + LINEAR
    both = run_study(study(tmp_path, text), tmp_path / "out")
    assert both["d_v"].dims == ("scene", "fz")
    for name in ("biorob2018", "biorob2018-w15"):
        alone = study(tmp_path, HEAD.replace("biorob2018", name) + '[vary]\nfz = ["0 N", "1 N"]\n' + LINEAR)
        np.testing.assert_array_equal(run_study(alone, tmp_path / name)["d_v"], both["d_v"].sel(scene=name))


REFUSED = {
    SOBOL.replace("= 8", "= 0") + VARY: "samples: must be a whole number from 1 .* got 0",
    HEAD + 'combine = "sobol"\n' + VARY: "samples: must be given, from 1 to 1000000, for sobol; it is missing",
    HEAD + 'combine = "sobbol"\n' + VARY: 'combine: must be one of .*did you mean "sobol"',
    HEAD + "samples = 8\n[vary]\nfz = [1]\n": "samples: must stand beside combine",
    SOBOL + "seed = -1\n" + VARY: "seed: must be a whole number",
    SOBOL + VARY.replace("to", "count = 3, to"): "fz: must be a list of values .*, or a range",
    SOBOL + '[vary]\nfz = { from = "1 N", to = "1 mm" }\n': "fz: must be a list of values .*, or a range",
    SOBOL + VARY.replace("mm", "N"): "vary: some case must leave a possible scene.*a length",
    SOBOL + VARY + '"target.material" = ["copper", "coper"]\n': '= "coper" must .*mean "copper"',
    SOBOL.replace("sobol", "saltelli").replace("= 8", "= 6") + VARY: "power of two",
    SOBOL.replace("sobol", "saltelli") + 'where = ["fz < 1"]\n' + VARY: "where: must not stand beside saltelli",
    SOBOL + "where = 1\n" + VARY: "where: must be a list; got 1",
    SOBOL + 'where = ["fz < 0 N"]\n' + VARY: "where: must leave a case at least; all 8",
    SOBOL + 'where = ["elastomer.widht < 1"]\n' + VARY: 'did you mean "elastomer.width"',
    SOBOL + VARY + '[derive]\nfz = "1"\n': "it stands under both",
    SOBOL + VARY + '[derive]\nfzz = "1"\n': "fzz",
    SOBOL + VARY + '[derive]\n"target.width" = "1 s < 2"\n': "derive.target.width: must be made of",
    SOBOL + VARY + '[derive]\n"target.width" = "-fz - 1"\n': "vary: some case must .*target.width: must be a length",
    SOBOL.replace('"biorob2018"', "[]") + VARY: "scene: must be a scene, or a list of different ones",
    SOBOL.replace('"biorob2018"', '["biorob2018", "biorob"]') + VARY: "biorob",
}


@pytest.mark.parametrize("text", REFUSED, ids=list(REFUSED.values()))
def test_what_is_no_study(text: str, tmp_path: Path) -> None:
    """One line that names the key."""
    with pytest.raises(SceneError, match=REFUSED[text]) as caught:
        study(tmp_path, text + LINEAR)
    assert "\n" not in str(caught.value)


VALUES = {"target.width": 0.008, "dv": 2e-3, "alpha": 0.1, "moment": 1e-3, "target.material": "copper", "n": 3.0}


@pytest.mark.parametrize(
    ("text", "true"),
    [
        ("target.width <= 8 mm", True),
        ("target.width<8mm", False),
        ("1 mm < dv - 0.5 * 1e-3 < 1.6 mm", True),
        ("alpha > 5 deg", True),
        ("moment >= '2 N*mm'", False),
        ('target.material == "copper"', True),
        ("target.material != 'brass'", True),
        ("-dv < +0.0", True),
        ("target.width / dv == 4", True),
    ],
)
def test_a_condition_holds_or_not(text: str, true: bool) -> None:
    """In SI, by hand."""
    assert expression("where", text, condition=True)(VALUES) is true


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true') < 1", "dv", "dv < 1 and n < 2", "dv ** 2 < 1", "[dv] < 1", "dv < (n := 3)",
        "dv.__class__() < 1", "lambda: 1 < 2", "dv[0] < 1", "f'{dv}' < 1", "dv < 1 if n else 2", "dv < True", "", 1,
        "(dv < 1) < 2", "dv <", "dv in n", "n < " + "-" * 5000 + "1", "\0",
    ],
)
def test_what_is_no_condition(text: object) -> None:
    """Refused in one line before any point is looked at."""
    with pytest.raises(SceneError, match="where: must be a comparison of names of keys") as caught:
        expression("where", text, condition=True)
    assert "\n" not in str(caught.value)


def test_bad_names_units_and_kinds() -> None:
    """The nearest name; a unit that does not exist; a word where a number must be; a division by zero."""
    with pytest.raises(SceneError, match=r'where: must name .*; got "target.widht" \(did you mean "target.width"\?\)'):
        expression("where", "target.widht < 1 mm", condition=True)(VALUES)
    with pytest.raises(SceneError, match='units that exist; got "8 mmm"'):
        expression("where", "dv < 8 mmm", condition=True)
    for text in ("target.material < 1", "dv / 0 < 1"):
        with pytest.raises(SceneError, match="where: must be of numbers"):
            expression("where", text, condition=True)(VALUES)
    with pytest.raises(SceneError, match="derive.dv: must be made of"):
        expression("derive.dv", "dv < 1")


def test_names_of_tables() -> None:
    """Dots join them, entries of lists go by their names."""
    table = {"a": 1, "target": {"width": 2}, "coils": [{"name": "C1", "turns": 3}, {"name": "C2", "turns": 4}]}
    found = names_of(table)
    assert found["target.width"] == 2 and found["coils.C2.turns"] == 4 and found["a"] == 1
    assert expression("derive.x", "coils.C1.turns + target.width")(found) == 5
