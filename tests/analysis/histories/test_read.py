"""Files of loads over time: units, and one line for each fault."""

import numpy as np
import pytest

from sits_mech.analysis.histories.read import read_history
from sits_mech.scene.sensor import SceneError, load_sensor


def read(tmp_path, text):
    path = tmp_path / "history.csv"
    path.write_text(text, encoding="utf-8")
    return read_history(path, load_sensor("biorob2018"))


def test_units_and_order_of_columns(tmp_path):
    found = read(tmp_path, "# a finger\nF_z [mN];t [ms];M_x [N mm]\n0;0;0\n500;20;1\n")
    np.testing.assert_allclose(found.time, [0.0, 0.02])
    np.testing.assert_allclose(found.course[1], [0.0, 0.5, 0.0, 0.0, 1e-3, 0.0])
    found = read(tmp_path, '"t [s]";"F_z [N]"\n"0";"0"\n0,5;2,5\n')
    assert found.time.tolist() == [0.0, 0.5] and found.course[1, 1] == 2.5
    found = read(tmp_path, "t,d_v [mm],F_x [N],alpha [deg]\n0,2,0,0\n1,1.9,3,90\n")
    np.testing.assert_allclose(found.course[1], [3.0, -1e-4, np.pi / 2, 0.0, 0.0, 0.0], rtol=1e-12)
    assert found.held.tolist() == [False, True, True, False, False, False]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t [s],F_z [N]\n0,0\n1,1\n1,2\n", "time must rise; got 1 s in row 3 after 1 s: a sudden load"),
        ("t [s],F_z [N]\n0,0\n1,1\n0.5,2\n", "time must rise; got 0.5 s in row 3 after 1 s$"),
        ("F_z [N]\n0\n1\n", "must have a column t"),
        ("t [s],force\n0,0\n1,1\n", "columns must be t and some of F_x, .*, each once; got 'force'"),
        ("t [s]\n0\n1\n", "must have a column of a force, such as F_z"),
        ("t [s],F_z [N],Fq [N]\n0,0,0\n1,1,1\n", "each once; got 'fq'"),
        ("t [s],F_z [N],Fz [N]\n0,0,0\n1,1,1\n", r"must come once; got F_z \[N\] and Fz \[N\] for f_z"),
        ("t [s],time [s],F_z [N]\n0,0,0\n1,1,1\n", "each once; got t"),
        ("t [s],F_z [N]\n0,0\n1,press\n", "row 2 must hold 2 finite numbers; got '1,press'"),
        ("t [s],F_z [N]\n0,0\n1\n", "row 2 must hold 2 finite numbers; got '1'"),
        ("t [s],F_z [N]\n0,0\n1,nan\n", "row 2 must hold 2 finite numbers"),
        ("t [s],F_z [N]\n0,0\n", "must hold 2 to 20000 rows of numbers; got 1"),
        ("t [s],F_z [m]\n0,0\n1,1\n", "column f_z"),
        ("t [s],F_z [N],d_v [mm]\n0,0,2\n1,1,2\n", "the place that it works on; got both: F_z, d_v$"),
        ("t [s],d_v [N]\n0,0\n1,1\n", "column d_v"),
        ("t [s],d_v [mm]\n0,2\n1,4.1\n", "d_v must be less than 2 mm from 2 mm; got 4.1 mm"),
    ],
)
def test_a_fault_is_one_line(tmp_path, text, words):
    with pytest.raises(SceneError, match=words) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)
