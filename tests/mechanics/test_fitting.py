"""The fit: exact on exact data, stable on bad data, and the maker of the catalogue's constants."""

import os
from pathlib import Path

import numpy as np
import pytest

from sits_mech.materials import silicones
from sits_mech.mechanics.fitting import TensileTest, engineering_stress, fit_law, read_tensile

STRAIN = np.linspace(0.0, 1.0, 51)
EXACT = {
    "neo-hookean": {"shear_modulus": 30e3},
    "mooney-rivlin": {"c10": 10e3, "c01": 4e3},
    "yeoh": {"c10": 12e3, "c20": 300.0, "c30": 20.0},
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
    beside = Path(__file__).parents[3] / "shared" / "tensile_tests"
    folder = Path(os.environ.get("SITS_MECH_TENSILE_TESTS", beside))
    if not folder.is_dir():
        pytest.skip(f"no tensile tests at {folder}; SITS_MECH_TENSILE_TESTS names their folder")
    return folder


def made(law: str, constants: dict[str, float], strain: np.ndarray = STRAIN) -> TensileTest:
    """Return a test that follows a law exactly."""
    return TensileTest(strain, engineering_stress(law, constants, strain), "made")


@pytest.mark.parametrize("law", EXACT)
def test_engineering_stress_closed_forms(law: str) -> None:
    """At stretch 2: I1 = 5, lambda - lambda^-2 = 1.75; and the initial slope is 3 mu."""
    expected = {
        "neo-hookean": 30e3 * 1.75,
        "mooney-rivlin": 2 * 1.75 * (10e3 + 4e3 / 2),
        "yeoh": 2 * 1.75 * (12e3 + 2 * 300.0 * 2 + 3 * 20.0 * 4),
    }
    assert engineering_stress(law, EXACT[law], np.array([1.0]))[0] == pytest.approx(expected[law], rel=1e-14)
    modulus = {"neo-hookean": 30e3, "mooney-rivlin": 28e3, "yeoh": 24e3}[law]
    slope = np.diff(engineering_stress(law, EXACT[law], np.array([-1e-6, 1e-6])))[0] / 2e-6
    assert slope == pytest.approx(3 * modulus, rel=1e-9)


@pytest.mark.parametrize("law", EXACT)
def test_fit_finds_exact_constants(law: str) -> None:
    """Least squares is exact on data of the law itself, to rounding times the condition of the fit."""
    fit = fit_law(made(law, EXACT[law]), law)
    assert fit.constants == pytest.approx(EXACT[law], rel=1e-8)
    assert fit.stable and fit.rms < 1e-6 and fit.max_strain == 1.0


def test_fit_of_noisy_data_is_close_and_says_how_close() -> None:
    """The residual is the noise that went in; the constant is off by no more than noise over stress."""
    noise = np.random.default_rng(1).normal(0.0, 200.0, STRAIN.size)
    test = made("neo-hookean", EXACT["neo-hookean"])
    fit = fit_law(TensileTest(test.strain, test.stress + noise, "noisy"), "neo-hookean")
    assert fit.rms == pytest.approx(200.0, rel=0.25)
    assert fit.constants["shear_modulus"] == pytest.approx(30e3, rel=200.0 / 30e3)


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
                       for k in ("c10", "c20")], axis=1)  # fmt: skip
    width = np.sqrt(np.diff(np.r_[0.0, 0.5 * (STRAIN[2:] + STRAIN[1:-1]), 1.0]))
    best = np.linalg.lstsq(matrix[1:] * width[:, None], test.stress[1:] * width)[0]
    assert [fit.constants["c10"], fit.constants["c20"]] == pytest.approx(best, rel=1e-5)


def _written(folder: Path, head: str, separator: str = ";", scale: float = 1e-6, break_at: int = 45) -> Path:
    """Write a tensile test: a header, the column names, a pull and a break."""
    stress = engineering_stress("neo-hookean", {"shear_modulus": 30e3}, STRAIN) * scale
    stress[break_at:] = 0.0
    rows = [separator.join(f"{x!r}" for x in map(float, pair)) for pair in zip(STRAIN, STRAIN, stress, strict=True)]
    path = folder / "test.csv"
    path.write_text(head + "\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(
    ("head", "separator", "scale"),
    [
        ("PARAMETER;INFO\nSpeed;450\n\nTime (s);Engineering Strain;Engineering Stress (MPa)", ";", 1e-6),
        ("time,engineering strain (-),ENGINEERING STRESS (kPa)", ",", 1e-3),
        ("a\tb\nc\nTime\tEngineering Strain\tEngineering Stress (Pa)", "\t", 1.0),
    ],
)
def test_reading_goes_by_content(tmp_path: Path, head: str, separator: str, scale: float) -> None:
    """Any length of header, three separators, three units; the break at the end is left out."""
    test = read_tensile(_written(tmp_path, head, separator, scale))
    assert test.strain[-1] == pytest.approx(STRAIN[44])
    assert fit_law(test, "neo-hookean").constants["shear_modulus"] == pytest.approx(30e3, rel=1e-12)


def test_files_without_a_pull_are_refused(tmp_path: Path) -> None:
    """Missing file, columns without these names or a unit, no numbers: one line each."""
    with pytest.raises(ValueError, match="must be a readable tensile test"):
        read_tensile(tmp_path / "none.csv")
    for head in ("Time;Strain;Stress", "Time;Engineering Strain;Engineering Stress (bar)"):
        with pytest.raises(ValueError, match='must have the columns "Engineering Strain"'):
            read_tensile(_written(tmp_path, head))
    with pytest.raises(ValueError, match="at least 5 rows of rising strain; got 3"):
        read_tensile(_written(tmp_path, "Time;Engineering Strain;Engineering Stress (MPa)", break_at=3))
    empty = tmp_path / "empty.csv"
    empty.write_text("Time;Engineering Strain;Engineering Stress (MPa)\n")
    with pytest.raises(ValueError, match="at least 5 rows of rising strain; got 0"):
        read_tensile(empty)


def test_impossible_requests_are_refused() -> None:
    """A law that cannot be fitted, a range without points, a push instead of a pull."""
    test = made("neo-hookean", EXACT["neo-hookean"])
    with pytest.raises(ValueError, match='law: must be one of .*; got "hooke"'):
        fit_law(test, "hooke")
    for strain in (0.01, -1.0, float("nan")):
        with pytest.raises(ValueError, match="max_strain: must leave at least 5 points"):
            fit_law(test, "yeoh", strain)
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
