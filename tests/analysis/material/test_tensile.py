"""Files of test machines: read by content, in any order, unit and separator; else refused in one line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t as student

from sits_mech.analysis.material.fitted import fit_law
from sits_mech.analysis.material.tensile import Sizes, read_tensile
from sits_mech.silicone.homogeneous import engineering_stress

STRAIN = np.linspace(0.0, 1.0, 51)


def test_planar_and_biaxial_columns(tmp_path: Path) -> None:
    """Three tests beside each other, of different lengths and units; and a file that has the biaxial one alone."""
    c = {"c10": 10e3, "c01": 4e3}
    modes = {"Engineering": "uniaxial", "Pure shear engineering": "planar", "Equibiaxial nominal": "biaxial"}
    head = ";".join(f"{words} strain (%);{words} stress [kPa]" for words in modes)
    rows = [head]
    for k, strain in enumerate(STRAIN):
        cells = []
        for mode, count in zip(modes.values(), (51, 31, 21), strict=True):
            stress = float(engineering_stress("mooney-rivlin", c, np.array([strain]), mode)[0])
            cells += [repr(100 * float(strain)), repr(1e-3 * stress)] if k < count else ["", ""]
        rows.append(";".join(cells))
    path = tmp_path / "three.csv"
    path.write_text("Lab;somewhere\n" + "\n".join(rows) + "\n")
    test = read_tensile(path)
    assert [one.mode for one in (test, *test.others)] == ["uniaxial", "planar", "biaxial"]
    assert [one.strain[-1] for one in (test, *test.others)] == pytest.approx([1.0, 0.6, 0.4])
    assert fit_law(test, "mooney-rivlin").constants == pytest.approx(c, rel=1e-8)


def _written(folder: Path, head: str, separator: str = ";", scale: float = 1e-6, break_at: int = 45) -> Path:
    """Write a tensile test: a header, the column names, a pull and a break."""
    stress = engineering_stress("neo-hookean", {"shear_modulus": 30e3}, STRAIN) * scale
    stress[break_at:] = 0.0
    rows = [separator.join(f"{x!r}" for x in map(float, pair)) for pair in zip(STRAIN, STRAIN, stress, strict=True)]
    path = folder / "test.csv"
    path.write_text(head + "\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(("separator", "quote", "mark"), [(";", "", ","), (",", '"', "."), ("\t", '"', ",")])
def test_every_row_of_a_spreadsheet_is_read(tmp_path: Path, separator: str, quote: str, mark: str) -> None:
    """Decimal commas where no comma separates, cells in quotes, a row of units below the names."""
    heads = ["Engineering Strain (%)", "Engineering Stress (kPa)"], ["(%)", "(kPa)"]
    rows = [*heads, *([f"{2.5 * k:g}".replace(".", mark), f"{1.5 * k:g}".replace(".", mark)] for k in range(30))]
    path = tmp_path / "spreadsheet.csv"
    path.write_text("\n".join(separator.join(f"{quote}{cell}{quote}" for cell in row) for row in rows))
    found = read_tensile(path)
    assert found.strain == pytest.approx(0.025 * np.arange(30)) and found.stress == pytest.approx(1.5e3 * np.arange(30))


YEOH = {"c10": 8e3, "c20": 600.0, "c30": 50.0}
PULL = np.linspace(0.02, 1.2, 60)
STRESS = engineering_stress("yeoh", YEOH, PULL)
LENGTH, AREA = 25e-3, 24e-6
_BLUEHILL = """"Specimen","1"
"Length","25.0","mm"
"Width","6.0","mm"
"Thickness","4.0","mm"

"Time","Extension","Load","Tensile strain (Strain 1)","Tensile stress"
"(s)","(mm)","(N)","(%)","(MPa)"
"""


def _table(folder: Path, head: str, parts: list[tuple[np.ndarray, ...]], encoding: str = "utf-8") -> Path:
    """Write columns below a head, its separator in it, decimal commas where that is none; parts one below another."""
    separator = next(one for one in ";\t," if one in head)
    rows = [separator.join(f"{x:.9g}" for x in row) for part in parts for row in zip(*part, strict=True)]
    text = "\n".join(rows) if separator == "," else "\n".join(rows).replace(".", ",")
    path = folder / "machine.csv"
    path.write_bytes(f"{head.rstrip()}\n{text}\n".encode(encoding))
    return path


@pytest.mark.parametrize(
    ("head", "columns", "encoding"),
    [
        (_BLUEHILL, (PULL, 1e3 * LENGTH * PULL, AREA * STRESS, 1e2 * PULL, 1e-6 * STRESS), "utf-8"),
        ("Time (s),Tensile strain (Displacement) (%),Stress (MPa)", (PULL, 1e2 * PULL, 1e-6 * STRESS), "cp1252"),
        ("Prüfer;N. N.\nMesslänge;25,00;mm\n\nDehnung;Standardkraft;Spannung\n%;N;MPa",
         (1e2 * PULL, AREA * STRESS, 1e-6 * STRESS), "cp1252"),
        ("Breite: 6,0 mm\nDicke: 4 mm\nEinspannlänge: 25 mm\nWeg in mm;Kraft in N",
         (1e3 * LENGTH * PULL, AREA * STRESS), "utf-8"),
        ("Éprouvette\t1\nDéformation en traction (%)\tContrainte (N/mm²)", (1e2 * PULL, 1e-6 * STRESS), "cp1252"),
        ("Deformación (-);Esfuerzo de tracción (kgf/cm2)", (PULL, STRESS / 98066.5), "utf-16"),
        ("厚さ (mm),4\n幅 (mm),6\nつかみ間隔,25,mm\n時間,試験力,ストローク\nsec,N,mm",
         (PULL, AREA * STRESS, 1e3 * LENGTH * PULL), "cp932"),
        ("公称ひずみ（％）,公称応力（MPa）", (1e2 * PULL, 1e-6 * STRESS), "utf-8-sig"),
        ("stretch,nominal stress (psi)", (1.0 + PULL, STRESS / 6894.757293168361), "utf-8"),
        ("true strain (-),true stress (kPa)", (np.log1p(PULL), 1e-3 * STRESS * (1.0 + PULL)), "utf-8"),
    ],
)
def test_words_units_and_letters_of_machines(
    head: str, columns: tuple[np.ndarray, ...], encoding: str, tmp_path: Path
) -> None:
    """Exports of five languages, forces over the sizes above them, stretches and true stresses: one law."""
    test = read_tensile(_table(tmp_path, head, [columns], encoding))
    assert test.strain == pytest.approx(PULL, rel=1e-6) and test.stress == pytest.approx(STRESS, rel=1e-6)
    made = any(word in head for word in ("Weg", "試験力", "stretch", "true"))
    assert bool(test.notes) == made  # of other columns, and said


def test_sizes_are_asked_for_where_the_file_has_none(tmp_path: Path) -> None:
    """Given ones count before those of the file."""
    path = _table(tmp_path, "Length;20;mm\nDisplacement (mm);Force (N)", [(1e3 * LENGTH * PULL, AREA * STRESS)])
    test = read_tensile(path, Sizes(LENGTH, AREA))
    assert test.strain == pytest.approx(PULL, rel=1e-6) and test.stress == pytest.approx(STRESS, rel=1e-6)


@pytest.mark.parametrize("beside", [True, False])
def test_specimens_are_fitted_together_and_their_spread_is_said(beside: bool, tmp_path: Path) -> None:
    """Beside each other or one below the other: the mean law of specimens of 1, 1.3 and 0.7 times its stress."""
    factors, head = (1.0, 1.3, 0.7), "strain (-),stress (kPa)"
    if beside:
        row = tuple(np.concatenate([[PULL, 1e-3 * factor * STRESS] for factor in factors]))
        path = _table(tmp_path, "Specimen 1,,Specimen 2,,Specimen 3,\n" + ",".join([head] * 3), [row])
    else:
        path = _table(tmp_path, head, [(PULL, 1e-3 * factor * STRESS) for factor in factors])
    fit = fit_law(read_tensile(path), "yeoh")
    assert fit.constants == pytest.approx(YEOH, rel=1e-5) and fit.modes == ("uniaxial",)
    width = student.ppf(0.975, 2) * np.std(factors, ddof=1) / np.sqrt(3)  # of their mean
    assert fit.confidence == pytest.approx({name: width * value for name, value in YEOH.items()}, rel=1e-3)
    assert "3 uniaxial specimens" in fit.notes[0] and "0.7 to 1.3 of the mean (standard deviation 30 %)" in fit.notes[0]


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("Compressive strain (%),Compressive stress (kPa)", lambda e, p: (1e2 * e, 1e-3 * p)),
        ("Stauchung;Druckspannung\n%;kPa", lambda e, p: (1e2 * e, 1e-3 * p)),
        ("strain,stress (Pa)", lambda e, p: (-e, -p)),
        ("stretch,stress (Pa)", lambda e, p: (1.0 - e, -p)),
        ("true compressive strain,true compressive stress (Pa)", lambda e, p: (-np.log1p(-e), p * (1.0 - e))),
        ("Length,25,mm\nArea,24,mm^2\nCompression (mm),Load (N)", lambda e, p: (1e3 * LENGTH * e, AREA * p)),
    ],
)
def test_compression_is_no_pull(head: str, columns: Callable[..., tuple[np.ndarray, ...]], tmp_path: Path) -> None:
    """Of two specimens, one below the other, by words or by signs: the law of the same states; a pull is none."""
    strain = np.linspace(0.01, 0.4, 40)
    path = _table(tmp_path, head, 2 * [columns(strain, -engineering_stress("yeoh", YEOH, -strain))])
    fit = fit_law(read_tensile(path), "yeoh")
    assert fit.constants == pytest.approx(YEOH, rel=1e-3) and fit.modes == ("biaxial",)
    assert any("compression is taken as the biaxial tension" in note for note in fit.notes)


def test_unloading_is_left_out_and_offered_to_softening(tmp_path: Path) -> None:
    """A break is left out without a word."""
    back = _table(tmp_path, "strain,stress (Pa)", [(np.r_[PULL, PULL[::-1]], np.r_[STRESS, 0.6 * STRESS[::-1]])])
    test = read_tensile(back)
    assert test.stress == pytest.approx(STRESS, rel=1e-6) and test.left_out.shape == (2, 60)
    assert "60 of 120 rows are left out: strain goes back" in test.notes[0] and "--cyclic" in test.notes[0]
    broken = _table(tmp_path, "strain,stress (Pa)", [(np.r_[PULL, 1.21, 1.23], np.r_[STRESS, 10.0, 0.0])])
    assert read_tensile(broken).notes == ()


@pytest.mark.parametrize("noise", [0.0, 30.0])
def test_slack_is_found_taken_off_and_said(noise: float, tmp_path: Path) -> None:
    """Constants come back after 10 % of slack; a given slack, zero too, is kept to; a test without has none.

    A preload is said; what its note offers brings them back.
    """
    rng, flat = np.random.default_rng(2), np.arange(0.0, 0.1, 0.02)
    stress = np.r_[0.0 * flat, STRESS] + noise * rng.standard_normal(65)
    path = _table(tmp_path, "strain,stress (Pa)", [(np.r_[flat, 0.1 + PULL], stress)])
    fit = fit_law(read_tensile(path), "yeoh")
    assert fit.constants["c10"] == pytest.approx(YEOH["c10"], rel=0.005 if noise else 5e-4)
    assert "taken off as slack; --slack 0 keeps it" in fit.notes[0]
    kept = fit_law(read_tensile(path, Sizes(slack=0.0)), "yeoh")
    assert kept.constants["c10"] < 0.8 * YEOH["c10"] and "slack" not in str(kept.notes)
    assert fit_law(read_tensile(path, Sizes(slack=0.1)), "yeoh").constants["c10"] == pytest.approx(8e3, rel=5e-3)
    for starts in (PULL, PULL[10:], np.r_[0.0, PULL]):
        own = engineering_stress("yeoh", YEOH, starts)
        test = read_tensile(_table(tmp_path, "strain,stress (Pa)", [(starts, own)]))
        assert test.slack == 0.0 and test.notes == ()
    loaded = engineering_stress("yeoh", YEOH, starts + 0.04)
    path = _table(tmp_path, "strain,stress (Pa)", [(starts, loaded)])
    assert 'of a preload --slack="-4.0' in read_tensile(path).notes[0]
    assert fit_law(read_tensile(path, Sizes(slack=-0.04)), "yeoh").constants["c10"] == pytest.approx(8e3, rel=5e-4)


def test_files_without_a_pull_are_refused(tmp_path: Path) -> None:
    """Missing file, columns without these names or a unit, no numbers: one line each."""
    with pytest.raises(ValueError, match="must be a readable tensile test"):
        read_tensile(tmp_path / "none.csv")
    for head, came in (("Time;Way;Strength (MPa)", "Time, Way, St"), ("t;Planar Strain;Stress (Pa)", "t, Planar")):
        with pytest.raises(ValueError, match=f"must have columns of strain .*; got {came}"):
            read_tensile(_written(tmp_path, head))
    for head, wrong in (
        ("Time;Engineering Strain;Engineering Stress (mm)", r'Stress \(mm\)" must be a pressure; got "mm"'),
        ("Time;Engineering Strain;Engineering Stress", r'"Engineering Stress" must be a pressure; got "", no unit'),
        ("Time;Engineering Strain (mm);Engineering Stress (Pa)", r'must be a plain number or in %; got "mm"'),
        ("Time;Displacement (mm);Stress (Pa)", 'must come with the length of the specimen: --length "25 mm"'),
        ("Time;Strain;Force (N)", 'must come with the area of the specimen: --area "24 mm'),
    ):
        with pytest.raises(ValueError, match=wrong):
            read_tensile(_written(tmp_path, head))
    with pytest.raises(ValueError, match="must come with a unit, .*beyond 25; got up to 100"):
        read_tensile(_table(tmp_path, "Strain;Stress (kPa)", [(100.0 * STRAIN, STRAIN)]))
    with pytest.raises(ValueError, match="of compression below 100 %, with its unit; got up to 1000 %"):
        read_tensile(_table(tmp_path, "Compressive strain;Stress (kPa)", [(10.0 * STRAIN, STRAIN)]))
    with pytest.raises(ValueError, match="at least 5 rows of rising strain in the uniaxial test; got 4"):
        read_tensile(_written(tmp_path, "Time;Engineering Strain;Engineering Stress (MPa)", break_at=4))
    least = read_tensile(_written(tmp_path, "t;Engineering Strain;Engineering Stress (MPa)", break_at=5))
    assert len(least.strain) == 5
    with pytest.raises(ValueError, match="at least 5 rows of rising strain in the uniaxial test; got 0"):
        read_tensile(_table(tmp_path, "Time;Engineering Strain;Engineering Stress (MPa)", []))


def test_noise_is_no_slack_and_no_preload(tmp_path: Path) -> None:
    """Where stresses are known to 3 % of the largest a parabola begins anywhere: up to 0.2 of strain was taken off."""
    strain, rng = np.linspace(0.0, 1.2, 61), np.random.default_rng(0)
    for _ in range(40):
        noisy = engineering_stress("yeoh", YEOH, strain) + 1.4e3 * rng.standard_normal(61)
        assert read_tensile(_table(tmp_path, "strain,stress (Pa)", [(strain, noisy)])).notes == ()
