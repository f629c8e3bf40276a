"""Codes of a history: at rest the converter's own, while it moves those of the middle of each window; or why none."""

import numpy as np
import pytest

from sits_mech.analysis.histories.codes import checked_count, with_codes
from sits_mech.analysis.histories.response import in_time
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.scene.sensor import SceneError, load_sensor


@pytest.fixture(scope="module")
def sensor():
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def data(sensor):
    """A second at rest, one of pressing, one under the load."""
    wrench = np.zeros((4, 6))
    wrench[2:, 1] = 1.0
    loads = LoadHistory(np.array([0.0, 1.0, 2.0, 3.0]), wrench)
    return in_time(sensor, loads, mechanics="linear", magnetics="planar", tolerance=0.1)


@pytest.mark.slow
def test_codes_follow_the_load(sensor, data):
    found = with_codes(sensor, data, seed=None)
    code, at = found["code"].to_numpy(), found["code_time"].to_numpy()
    still = np.all(at < 0.9, axis=1)
    assert np.ptp(code[still], axis=0).max() == 0
    assert code[-1].min() > code[0].max()  # a nearer target lowers L
    moving = (at[:, 0] > 1.05) & (at[:, 0] < 1.95)
    middle = np.interp(at[moving, 0], data["time"], data["L"][:, 0, 0])
    read = found["code_L"].to_numpy()[moving, 0]
    slope = np.polyfit(middle, read, 1)
    assert np.abs(read - np.polyval(slope, middle)).max() < 2e-3 * np.ptp(read)


def test_coils_are_read_one_after_the_other(sensor, data):
    found = with_codes(sensor, data, rcount=4096)
    at = found["code_time"].to_numpy()
    assert np.all(np.diff(at.ravel()) > 0.0)
    assert np.diff(at[:, 0]) == pytest.approx(found.attrs["period"])
    assert found.sizes["scan"] == int(3.0 / found.attrs["period"])


def test_noise_is_the_same_for_one_seed(sensor, data):
    one, other, none = (with_codes(sensor, data, seed=seed)["code"] for seed in (1, 1, None))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, none)


def test_without_a_converter_the_reason_is_told(sensor, data):
    off = sensor.model_copy(update={"readout": sensor.readout.model_copy(update={"converter": "none"})})
    found = with_codes(off, data)
    assert "code" not in found
    assert "no codes: the scene has no converter" in found.attrs["notes"]
    short = data.isel(time=slice(0, 2))
    assert "no codes" in with_codes(sensor, short.assign_coords(time=[0.0, 1e-3])).attrs["notes"]


def test_reference_counts_of_the_part(sensor):
    assert checked_count(sensor, None) == 0xFFFF
    assert checked_count(sensor, 4096) == 4096
    with pytest.raises(SceneError, match="rcount: must be from 9 to 65535 for the LDC1614; got 3"):
        checked_count(sensor, 3)
