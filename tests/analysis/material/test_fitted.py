"""Three tests of one silicone: constants of slow load together, and what the command line prints of them."""

from __future__ import annotations

import json
import os
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.material.fitted import fit_law, fit_tests
from sits_mech.analysis.material.tensile import TensileTest, read_tensile
from sits_mech.cli.main import run
from sits_mech.scene.materials import silicones
from sits_mech.silicone.homogeneous import engineering_stress
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
    pull = fit_tests(files["tensile"], None, None)
    assert set(pull.record) & {"prony", "mullins", "relaxation", "cyclic"} == set()
    assert silicone_from(pull.record["material"] | {"bulk_modulus": 3e7}).known_stretch == pytest.approx(2.0)
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


STRAIN = np.linspace(0.0, 1.0, 51)
EXACT = {
    "neo-hookean": {"shear_modulus": 30e3},
    "mooney-rivlin": {"c10": 10e3, "c01": 4e3},
    "yeoh": {"c10": 12e3, "c20": 300.0, "c30": 20.0},
    "ogden": {"mu": (20e3, 1e3), "alpha": (1.6, 6.3)},
    "gent": {"shear_modulus": 30e3, "j_m": 9.0},
}
FILES = {
    "ecoflex-00-10": "Ecoflex 00-10.csv",
    "ecoflex-00-30": "Ecoflex 00-30.csv",
    "ecoflex-00-50": "Ecoflex 00-50.csv",
    "dragon-skin-10": "Dragon Skin 10 MEDIUM.csv",
    "dragon-skin-30": "Dragon Skin 30.csv",
    "rtv615": "RTV615.csv",
}


def tensile_folder() -> Path:
    """Return the folder of raw tensile tests, or skip and say so: the project does not carry them."""
    beside = Path(__file__).parents[4] / "shared" / "tensile_tests"
    folder = Path(os.environ.get("SITS_MECH_TENSILE_TESTS", beside))
    if not folder.is_dir():
        pytest.skip(f"no tensile tests at {folder}; SITS_MECH_TENSILE_TESTS names their folder")
    return folder


def made(law: str, constants: dict, strain: np.ndarray = STRAIN, mode: str = "uniaxial") -> TensileTest:
    """Return a test that follows a law exactly."""
    return TensileTest(strain, engineering_stress(law, constants, strain, mode), "made", mode)


@pytest.mark.parametrize("law", EXACT)
def test_engineering_stress_closed_forms(law: str) -> None:
    """At stretch 2: I1 = 5, lambda - lambda^-2 = 1.75; and the initial slope is 3 mu."""
    expected = {
        "neo-hookean": 30e3 * 1.75,
        "mooney-rivlin": 2 * 1.75 * (10e3 + 4e3 / 2),
        "yeoh": 2 * 1.75 * (12e3 + 2 * 300.0 * 2 + 3 * 20.0 * 4),
        "ogden": sum(2 * m / a * (2 ** (a - 1) - 2 ** (-a / 2 - 1)) for m, a in ((20e3, 1.6), (1e3, 6.3))),
        "gent": 30e3 * 1.75 / (1 - 2 / 9.0),
    }
    assert engineering_stress(law, EXACT[law], np.array([1.0]))[0] == pytest.approx(expected[law], rel=1e-14)
    modulus = {"neo-hookean": 30e3, "mooney-rivlin": 28e3, "yeoh": 24e3, "ogden": 21e3, "gent": 30e3}[law]
    slope = np.diff(engineering_stress(law, EXACT[law], np.array([-1e-6, 1e-6])))[0] / 2e-6
    assert slope == pytest.approx(3 * modulus, rel=1e-9)


@pytest.mark.parametrize("law", EXACT)
def test_fit_finds_exact_constants(law: str) -> None:
    """Least squares is exact on data of the law itself, to rounding times the condition of the fit (Ogden's is 1e5)."""
    fit = fit_law(made(law, EXACT[law]), law)
    for name, value in EXACT[law].items():
        assert fit.constants[name] == pytest.approx(value, rel=1e-6 if law == "ogden" else 1e-8)
    assert fit.stable and fit.rms < 1e-4 and fit.max_strain == 1.0 and fit.notes == ()


@pytest.mark.parametrize("alpha", [(-4.5, 2.2), pytest.param((2.1, 5.2, 12.0), marks=pytest.mark.slow)])
def test_ogden_of_either_sign_and_three_terms(alpha: tuple[float, ...]) -> None:
    """The search starts near every choice of exponents; with three tests of the silicone all constants come out."""
    constants = {"mu": (8e3, 20e3, 40.0)[: len(alpha)], "alpha": alpha}
    others = tuple(made("ogden", constants, mode=mode) for mode in ("planar", "biaxial"))
    fit = fit_law(replace(made("ogden", constants), others=others), "ogden", terms=len(alpha))
    assert fit.modes == ("uniaxial", "planar", "biaxial")
    for name, value in constants.items():
        assert fit.constants[name] == pytest.approx(value, rel=1e-4)


@pytest.mark.slow
def test_laws_do_not_ask_for_more_than_the_data_hold() -> None:
    """Neo-Hookean data: one Ogden term with alpha = 2, and no locking; both say so."""
    test = made("neo-hookean", EXACT["neo-hookean"])
    fit = fit_law(test, "ogden")
    assert fit.constants["mu"] == pytest.approx((30e3,), rel=1e-6)
    assert fit.constants["alpha"] == pytest.approx((2.0,), rel=1e-6)
    assert fit.notes == ("the data determine no 2 terms",)
    fit = fit_law(test, "gent")
    assert fit.constants["shear_modulus"] == pytest.approx(30e3, rel=1e-4)
    assert fit.constants["j_m"] > 1e3 and fit.confidence["j_m"] is None
    assert "no locking" in fit.notes[0]


def test_falling_data_give_stable_ogden_and_gent() -> None:
    """Data that ask for a falling law: moduli and exponents stay within what is stable at every strain."""
    test = made("yeoh", {"c10": 12e3, "c20": -1.2e3, "c30": 0.0})
    fit = fit_law(test, "ogden")
    assert fit.stable and min(fit.constants["mu"]) > 0.0
    assert all(a >= 1.0 or a <= -2.0 for a in fit.constants["alpha"])
    assert any("held at the end" in note for note in fit.notes)
    assert fit_law(test, "gent").stable


@pytest.mark.slow
@pytest.mark.parametrize(("law", "runs"), [("neo-hookean", 200), ("mooney-rivlin", 200), ("gent", 100), ("ogden", 30)])
def test_intervals_hold_the_truth(law: str, runs: int) -> None:
    """White noise: the 95 % intervals hold every constant in 95 of 100 pulls, less three deviations of the count."""
    rng, strain = np.random.default_rng(3), np.linspace(0.0, 1.0, 101)
    exact = {"mu": (30e3,), "alpha": (3.0,)} if law == "ogden" else EXACT[law]
    stress, terms = engineering_stress(law, exact, strain), 1
    hits = dict.fromkeys(exact, 0)
    for _ in range(runs):
        fit = fit_law(TensileTest(strain, stress + rng.normal(0.0, 100.0, 101), "noisy"), law, terms=terms)
        for name, truth in exact.items():
            hits[name] += bool((np.abs(np.subtract(fit.constants[name], truth)) <= fit.confidence[name]).all())
    assert min(hits.values()) >= 0.95 * runs - 3 * np.sqrt(0.95 * 0.05 * runs)


@pytest.mark.slow
def test_intervals_hold_the_truth_when_the_noise_is_slow() -> None:
    """Noise that stays for eight points at a time, 20 independent values: nine in ten, less three deviations."""
    rng, strain, hits = np.random.default_rng(4), np.linspace(0.0, 1.0, 161), 0
    stress = engineering_stress("neo-hookean", EXACT["neo-hookean"], strain)
    for _ in range(600):
        noise = np.r_[0.0, np.repeat(rng.normal(0.0, 100.0, 20), 8)]
        fit = fit_law(TensileTest(strain, stress + noise, "slow"), "neo-hookean")
        hits += abs(fit.constants["shear_modulus"] - 30e3) <= fit.confidence["shear_modulus"]
    assert hits >= 0.9 * 600 - 3 * np.sqrt(0.9 * 0.1 * 600)


def test_intervals_count_misfit_by_its_runs() -> None:
    """A misfit that wavers five times is no better known for being sampled ten times more densely."""
    widths = []
    for count in (101, 1001):
        strain = np.linspace(0.0, 1.0, count)
        stress = engineering_stress("neo-hookean", EXACT["neo-hookean"], strain) + 500.0 * np.sin(6 * np.pi * strain)
        widths.append(fit_law(TensileTest(strain, stress, "wavy"), "neo-hookean").confidence["shear_modulus"])
    assert widths[1] == pytest.approx(widths[0], rel=0.05)


def test_sampling_rate_plays_no_part() -> None:
    """The same curve sampled ten times more densely in one half gives the same constants."""
    dense = np.union1d(STRAIN, np.linspace(0.0, 0.5, 251))
    curve = {"c10": 12e3, "c20": 300.0, "c30": 20.0}
    coarse, fine = (fit_law(made("yeoh", curve, strain), "neo-hookean") for strain in (STRAIN, dense))
    assert fine.constants["shear_modulus"] == pytest.approx(coarse.constants["shear_modulus"], rel=1e-3)


@pytest.mark.parametrize("law", ["yeoh", "mooney-rivlin"])
@pytest.mark.parametrize("bad", [{"c10": 12e3, "c20": -2e3, "c30": -50.0}, {"c10": 12e3, "c20": 900.0, "c30": -200.0}])
def test_unstable_data_give_stable_constants(law: str, bad: dict[str, float]) -> None:
    """Softening data ask for a falling law; what comes rises all over the range, in tension and in compression."""
    fit = fit_law(made("yeoh", bad), law)
    assert fit.stable
    assert fit.constants.get("c30", 0.0) >= -1e-9
    excess = (1 + fit.max_strain) ** 2 + 2 / (1 + fit.max_strain) - 3
    stretch = np.linspace(0.05, 1 + fit.max_strain, 2000)
    stretch = stretch[stretch**2 + 2 / stretch - 3 <= excess]
    assert stretch[0] < 0.6
    assert (np.diff(engineering_stress(law, fit.constants, stretch - 1.0)) > 0.0).all()


def test_constrained_fit_is_the_best_of_the_stable_ones() -> None:
    """No admissible neighbour leaves a smaller residual (the fit is a convex programme)."""
    test = made("yeoh", {"c10": 12e3, "c20": 900.0, "c30": -200.0})
    fit = fit_law(test, "yeoh")
    assert fit.constants["c30"] == pytest.approx(0.0, abs=1e-6)
    matrix = np.stack([engineering_stress("yeoh", {"c10": 0.0, "c20": 0.0, "c30": 0.0} | {k: 1.0}, STRAIN)
                       for k in ("c10", "c20")], axis=1)
    width = np.sqrt(np.diff(np.r_[0.0, 0.5 * (STRAIN[2:] + STRAIN[1:-1]), 1.0]))
    best = np.linalg.lstsq(matrix[1:] * width[:, None], test.stress[1:] * width)[0]
    assert [fit.constants["c10"], fit.constants["c20"]] == pytest.approx(best, rel=1e-5)


def test_impossible_requests_are_refused() -> None:
    """A law that cannot be fitted, a range without points, a push instead of a pull."""
    test = made("neo-hookean", EXACT["neo-hookean"])
    with pytest.raises(ValueError, match='law: must be one of .*; got "hooke"'):
        fit_law(test, "hooke")
    for strain in (0.01, -1.0, float("nan")):
        with pytest.raises(ValueError, match="max_strain: must leave at least 5 points"):
            fit_law(test, "yeoh", strain)
    with pytest.raises(ValueError, match="terms: must be 1, 2, 3 or 4; got 5"):
        fit_law(test, "ogden", terms=5)
    with pytest.raises(ValueError, match="must be a pull"):
        fit_law(TensileTest(test.strain, -test.stress, "pushed"), "yeoh")


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("ending", ["", "-neo-hookean"])
def test_catalogue_is_what_the_fit_makes(name: str, ending: str) -> None:
    """Constants to the five digits, range to the three and residual to the pascal that the catalogue shows."""
    known = silicones()[name + ending]
    test = read_tensile(tensile_folder() / FILES[name])
    fit = fit_law(test, known.law, 1.0)
    assert fit.stable
    assert fit.constants == pytest.approx(dict(known.constants), rel=1e-4, abs=1e-3)
    assert known.rms == pytest.approx(fit.rms, abs=1.0)
    assert known.fitted_range == pytest.approx((test.strain[test.strain > 0.0][0], fit.max_strain), abs=1e-3)
