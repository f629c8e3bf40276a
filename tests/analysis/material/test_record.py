"""Tests over time, as machines write them: headers, units, stretch; what is refused, in one line."""

import numpy as np
import pytest

from sits_mech.analysis.material.tensile import read_record

TIME = np.arange(10.0)
STRAIN, STRESS = 0.1 * TIME, 2e3 * TIME


def file(tmp_path, names, rows, head=""):
    path = tmp_path / "test.csv"
    lines = [head, names, *(";".join(f"{cell:.9g}" for cell in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_columns_are_known_by_name_and_unit(tmp_path):
    names = "TIME [min];true strain;Stretch (-);nominal strain (%);nominal stress [kPa]"
    columns = TIME / 60, TIME, 1.0 + TIME, 1e2 * STRAIN, 1e-3 * STRESS
    found = read_record(file(tmp_path, names, np.column_stack(columns), head="Specimen;3 mm"))
    assert found.timed and found.time == pytest.approx(TIME)
    assert found.strain == pytest.approx(STRAIN, abs=1e-8) and found.stress == pytest.approx(STRESS)


def test_a_cyclic_test_may_have_no_time(tmp_path):
    path = file(tmp_path, "Engineering Strain;Engineering Stress (Pa)", np.column_stack([STRAIN, STRESS]))
    found = read_record(path, timed=False)
    assert not found.timed and found.strain == pytest.approx(STRAIN)
    with pytest.raises(ValueError, match=r'must have the column "Time \(s\)" beside strain and stress; got Eng'):
        read_record(path)


@pytest.mark.parametrize(
    ("names", "columns", "message"),
    [
        ("time (s);engineering strain;engineering stress (mm)", (TIME, STRAIN, STRESS), 'must be a pressure; got "mm"'),
        ("time (m);engineering strain;engineering stress (Pa)", (TIME, STRAIN, STRESS), r'must have the column "Time'),
        ("time;engineering strain;engineering stress (Pa)", (-TIME, STRAIN, STRESS), "time must rise; got 0 s and"),
        ("time;engineering strain;engineering stress (Pa)", (TIME // 2, STRAIN, STRESS), "time must rise"),
        ("time;shear strain;shear stress (Pa)", (TIME, STRAIN, STRESS), "must be a uniaxial test, .*; got shear"),
        ("time;stretch;engineering stress (Pa)", (TIME, STRAIN, STRESS), "strain must be above -1; got -1"),
        ("time;engineering strain;engineering stress (Pa)", (TIME[:5], STRAIN[:5], STRESS[:5]), "8 rows.*got 5"),
    ],
)
def test_what_is_no_test_is_refused(tmp_path, names, columns, message):
    with pytest.raises(ValueError, match=message):
        read_record(file(tmp_path, names, np.column_stack(columns)))


def test_compression_is_below_zero(tmp_path):
    path = file(tmp_path, "Time;Compressive strain;Compressive stress (Pa)", np.column_stack([TIME, STRAIN, STRESS]))
    found = read_record(path)
    assert found.strain == pytest.approx(-STRAIN) and found.stress == pytest.approx(-STRESS)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ValueError, match="nowhere.csv: must be a readable test over time"):
        read_record(tmp_path / "nowhere.csv")
