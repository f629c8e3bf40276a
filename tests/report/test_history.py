"""What is shown of a history: table, record, CSV, picture, folder."""

import io

import numpy as np
import pandas as pd
import pytest

from sits_mech.analysis.histories.response import in_time
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.report import history
from sits_mech.report.history import history_csv, history_curves, history_record, history_table, moving, write_history
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def sensor():
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def data(sensor):
    wrench = np.zeros((3, 6))
    wrench[1:, 1], wrench[2, 0] = 0.5, 0.1
    loads = LoadHistory(np.array([0.0, 1.0, 2.0]), wrench)
    return in_time(sensor, loads, mechanics="linear", magnetics="planar", tolerance=0.1)


@pytest.mark.slow
def test_record_has_the_historys_own_times(data):
    found = history_record(data)
    assert found["time"].tolist() == [0.0, 1.0, 2.0]
    assert found["wrench"]["F_z"].tolist() == [0.0, 0.5, 0.5]
    assert np.shape(found["L"]) == (3, 2)
    assert moving(data) == ("F_x", "F_z")


def test_csv_has_every_solved_time(data):
    table = pd.read_csv(io.StringIO(history_csv(data)))
    assert len(table) == data.sizes["time"]
    assert table["given"].sum() == 3
    np.testing.assert_array_equal(table["L[C1]"], data["L"][:, 0, 0])


@pytest.mark.slow
def test_a_force_that_is_found_has_an_error(sensor):
    """In table, record and picture; what moves a given place is no error of it."""
    course = np.outer([0.0, -2e-5, -2e-5], [0, 1, 0, 0, 0, 0])
    press = LoadHistory(np.array([0.0, 1.0, 2.0]), course, held=np.arange(6) == 1)
    data = in_time(sensor, press, mechanics="planar", magnetics="planar", tolerance=0.1)
    table, record = history_table(data), history_record(data)
    assert [column.header for column in table.columns][:2] == ["t [s]", "F_z [N]"]
    assert "+-" in [*table.columns[1].cells][1] and record["error_F_z"][-1] > 0.0 and "error_F_x" not in record
    assert history_curves(data).axes[0].get_legend_handles_labels()[1] == ["$F_z$ [N]"]
    assert "error_F_z" in history_csv(data).split("\n")[0]


def test_table_and_picture(data, collisions, monkeypatch):
    assert history_table(data).row_count == 3
    monkeypatch.setattr(history, "_MOST", 2)
    thinned = history_table(data)
    assert thinned.row_count == 2 and thinned.caption.startswith("one row of 2, 3 in all")
    figure = history_curves(data)
    assert not collisions(figure)
    names = [axes.get_ylabel() for axes in figure.axes]
    still = data.assign(L_h_percent=1e-14 * np.sin(1e3 * data["time"]))  # what symmetry cancels
    left = [axes.get_ylabel() for axes in history_curves(still).axes]
    assert [name for name in names if name not in left] == ["$L_h$ [% of $L_0$]"]


@pytest.mark.slow
def test_folder(sensor, data, tmp_path):
    write_history(sensor, data, tmp_path)
    assert {"history.nc", "history.csv", "scene.toml"} <= {path.name for path in tmp_path.iterdir()}
