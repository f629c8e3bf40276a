"""Files of test machines: read by content, in any order, unit and separator; else refused in one line."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.material.fitted import fit_law
from sits_mech.analysis.material.tensile import read_tensile
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


@pytest.mark.parametrize(("separator", "quote", "mark"), [(";", "", ","), (",", '"', "."), ("\t", '"', ",")])
def test_every_row_of_a_spreadsheet_is_read(tmp_path: Path, separator: str, quote: str, mark: str) -> None:
    """Decimal commas where no comma separates, cells in quotes, a row of units below the names."""
    heads = ["Engineering Strain (%)", "Engineering Stress (kPa)"], ["(%)", "(kPa)"]
    rows = [*heads, *([f"{2.5 * k:g}".replace(".", mark), f"{1.5 * k:g}".replace(".", mark)] for k in range(30))]
    path = tmp_path / "spreadsheet.csv"
    path.write_text("\n".join(separator.join(f"{quote}{cell}{quote}" for cell in row) for row in rows))
    found = read_tensile(path)
    assert found.strain == pytest.approx(0.025 * np.arange(30)) and found.stress == pytest.approx(1.5e3 * np.arange(30))


def test_files_without_a_pull_are_refused(tmp_path: Path) -> None:
    """Missing file, columns without these names or a unit, no numbers: one line each."""
    with pytest.raises(ValueError, match="must be a readable tensile test"):
        read_tensile(tmp_path / "none.csv")
    for head in ("Time;Strain;Stress", "t;True Strain;True Stress (MPa)", "t;Planar Strain;Engineering Stress (Pa)"):
        with pytest.raises(ValueError, match='must have the columns "Engineering Strain"'):
            read_tensile(_written(tmp_path, head))
    for head, wrong in (
        ("Time;Engineering Strain;Engineering Stress (bar)", r'Stress \(bar\)" must be in Pa, .*; got "bar"'),
        ("Time;Engineering Strain;Engineering Stress", r'"Engineering Stress" must be in Pa, .*; got ""'),
        ("Time;Engineering Strain (mm);Engineering Stress (Pa)", r'must be a plain number or in %; got "mm"'),
    ):
        with pytest.raises(ValueError, match=wrong):
            read_tensile(_written(tmp_path, head))
    with pytest.raises(ValueError, match="at least 5 rows of rising strain in the uniaxial test; got 3"):
        read_tensile(_written(tmp_path, "Time;Engineering Strain;Engineering Stress (MPa)", break_at=3))
    with pytest.raises(ValueError, match="at least 5 rows of rising strain in the uniaxial test; got 4"):
        read_tensile(_written(tmp_path, "Time;Engineering Strain;Engineering Stress (MPa)", break_at=4))
    least = read_tensile(_written(tmp_path, "t;Engineering Strain;Engineering Stress (MPa)", break_at=5))
    assert len(least.strain) == 5
    empty = tmp_path / "empty.csv"
    empty.write_text("Time;Engineering Strain;Engineering Stress (MPa)\n")
    with pytest.raises(ValueError, match="at least 5 rows of rising strain in the uniaxial test; got 0"):
        read_tensile(empty)
