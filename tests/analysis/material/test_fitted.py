"""Three tests of one silicone: constants of slow load together, and what the command line prints of them."""

import json
import tomllib

import numpy as np
import pytest

from sits_mech.analysis.material.fitted import fit_tests
from sits_mech.analysis.material.fitting import fit_law
from sits_mech.analysis.material.tensile import read_tensile
from sits_mech.cli.main import run
from sits_mech.silicone.material import silicone_from


def write(path, record, timed=True):
    rows = np.column_stack([record.time, 1e2 * record.strain, 1e-3 * record.stress])[:, not timed :]
    text = "\n".join(";".join(f"{cell:.12g}" for cell in row) for row in rows)
    path.write_text(f"{'Time (s);' * timed}Engineering Strain (%);Engineering Stress (kPa)\n{text}\n")
    return path


@pytest.fixture
def files(tmp_path, rubber, prony, measured, cycles):
    silicone = rubber(prony=prony, mullins={"r": 2.5, "m": 800.0, "beta": 0.2})
    time = np.r_[np.linspace(0.0, 0.5, 20), 0.5 + np.geomspace(0.02, 600.0, 200)]
    pull = np.linspace(0.0, 1e-3, 101)  # sudden: 1/(1 - sum w) times the law
    return {
        "tensile": write(tmp_path / "tensile.csv", measured(silicone, pull, 1e3 * pull), timed=False),
        "relaxation": write(tmp_path / "hold.csv", measured(silicone, time, 0.5 * np.minimum(time / 0.5, 1.0))),
        "cyclic": write(tmp_path / "cycles.csv", measured(silicone, *cycles((0.3, 0.6, 1.0), count=25))),
    }


@pytest.mark.slow
def test_a_sudden_pull_comes_down_to_the_constants_of_slow_load(files, rubber, prony):
    """Each test shows its own part; together they give the silicone that was tested."""
    found = fit_tests(files["tensile"], files["relaxation"], files["cyclic"])
    assert found.relaxation is not None and found.relaxation.factor == pytest.approx(0.76, rel=1e-3)
    table = silicone_from(found.table | {"bulk_modulus": 3e7})
    exact = rubber(prony=prony, mullins={"r": 2.5, "m": 800.0, "beta": 0.2})
    assert table.constants == pytest.approx(exact.constants, rel=2e-3)
    assert np.array(table.prony) == pytest.approx(np.array(exact.prony), rel=2e-3)
    assert vars(table.mullins) == pytest.approx(vars(exact.mullins), rel=1e-2)


@pytest.mark.slow
def test_what_relaxes_during_a_pull_does_not_bend_the_law(files, tmp_path, rubber, prony, measured):
    """A pull of 8 s, as slow as a branch: the constants of slow load come out, from it or from the cycles' envelope."""
    time = np.linspace(0.0, 8.0, 201)
    files["tensile"] = write(tmp_path / "slow.csv", measured(rubber(prony=prony), time, time / 8.0))
    exact = np.array(list(rubber().constants.values()))
    for pull in (files["tensile"], None):
        found = fit_tests(pull, files["relaxation"], files["cyclic"])
        table = silicone_from(found.table | {"bulk_modulus": 3e7})
        assert np.array(list(table.constants.values())) == pytest.approx(exact, rel=2e-2)
        assert table.shear_modulus == pytest.approx(3e4, rel=2e-3)
        assert table.mullins.r == pytest.approx(2.5, rel=5e-3)
    without = fit_law(read_tensile(files["tensile"]), "yeoh").constants
    assert abs(without["c20"] / -300.0 - 1.0) > 0.5  # the pull alone, at its own rate


def test_each_test_alone(files):
    """Rate without a law; softening on the envelope's; a pull as it was before."""
    alone = fit_tests(None, files["relaxation"], None)
    assert alone.fit is None and set(alone.table) == {"prony"}
    assert set(alone.record) == {"prony", "relaxation", "material"}
    cyclic = fit_tests(None, None, files["cyclic"])
    assert cyclic.fit is not None and cyclic.fit.source == "cycles.csv" and "mullins" in cyclic.table
    assert set(fit_tests(files["tensile"], None, None).record) & {"prony", "mullins", "material"} == set()
    with pytest.raises(ValueError, match="must be given a tensile test, --relaxation or --cyclic"):
        fit_tests(None, None, None)


@pytest.mark.slow
def test_the_command_line_prints_lines_for_a_scene(files, capsys):
    """They are TOML that a material is made of; --json has the same numbers."""
    words = ["fit", str(files["tensile"]), "--relaxation", str(files["relaxation"]), "--cyclic", str(files["cyclic"])]
    assert run(words) == 0
    out = capsys.readouterr().out
    table = tomllib.loads(out[out.index("[elastomer.material]") :])["elastomer"]["material"]
    assert run([*words, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["material"] == table and record["mullins"]["r"] == pytest.approx(table["mullins"]["r"], rel=1e-4)
    assert silicone_from(table | {"bulk_modulus": 3e7}).prony
    assert run(["fit", "--relaxation", str(files["cyclic"])]) == 2
    assert capsys.readouterr().err.count("\n") == 1
