"""Robots' programs around the exported folder: MuJoCo, Gymnasium, the layout of ROS 2's messages."""

import json
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sits_mech.export.source import Source
from sits_mech.export.twin.folder import write_twin
from sits_mech.report.folder import read_calibration


@pytest.fixture(scope="module")
def folder(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The twin of the small calibration."""
    folder = tmp_path_factory.mktemp("robot") / "made"
    write_twin(Source(*read_calibration(calibrated)), folder)
    return folder


@pytest.fixture
def program(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """What imports one of the programs beside the folder's own twin.py."""
    monkeypatch.syspath_prepend(folder)
    yield lambda name: import_module(f"robots.{name}")
    sys.modules.pop("twin", None)


@pytest.mark.slow
def test_a_finger_presses_and_shears(program: Any, folder: Path, tmp_path: Path) -> None:
    """The target feels what the motors do, once they rest; the codes tell it; both sheared sides mirror each other."""
    pytest.importorskip("mujoco")
    finger = program("mujoco_finger")
    found = finger.pressed(folder)
    held = (found["time"] > 0.7) & (found["time"] < 0.8)
    assert found["forces"][held] == pytest.approx(found["motors"][held], abs=0.02)
    assert np.abs(found["estimate"] - np.clip(found["forces"], [-1, 0], [1, 3])).max() < 1e-3
    assert found["forces"][:, 0].min() == pytest.approx(-found["forces"][:, 0].max(), rel=0.05)
    codes = found["codes"] - found["codes"][0]
    assert codes[:, 0].max() == pytest.approx(codes[:, 1].max(), rel=0.05) and np.abs(codes[-1]).max() < 100
    finger.draw(found, tmp_path / "finger.png")
    assert (tmp_path / "finger.png").stat().st_size > 10_000


@pytest.mark.slow
def test_pads_of_gymnasium(program: Any, folder: Path) -> None:
    """Spaces hold what comes; the estimate's policy ends at the goals; an episode is cut at its length."""
    pytest.importorskip("gymnasium")
    pads = program("gymnasium_pads").Pads(folder, num_envs=64)
    seen, _ = pads.reset(seed=3)
    assert pads.observation_space.contains(seen) and pads.action_space.shape == (64, 2)
    same, _ = pads.reset(seed=3)
    assert np.array_equal(seen, same)
    span, coils = pads.high - pads.low, len(pads.twin.coils)
    for _ in range(200):
        force = pads.low + seen[:, coils:] * span
        seen, reward, ended, cut, more = pads.step((force - pads.wrench[:, pads.columns]) / (0.05 * span))
    assert reward.mean() == pytest.approx(0.0, abs=1e-5) and cut.all() and not ended.any()
    assert not more["flags"].any() and seen.dtype == np.float32


@pytest.mark.slow
def test_messages_of_ros_2(program: Any, folder: Path) -> None:
    """Pressing is along -z; seconds and nanoseconds; counts one a coil; all of it is JSON."""
    made, twin_of = program("ros2_message"), sys.modules["twin"].Twin
    twin = twin_of.load(folder / "sensor.npz")
    codes = twin.read(np.array([[0.3, 1.2, 0.0, 0.0, 0.0, 0.0]])).codes[0]
    found = made.messages(twin, codes.tolist(), 1_700_000_000_123_456_789)
    wrench = found["sits/wrench"]
    assert wrench["header"] == {"stamp": {"sec": 1_700_000_000, "nanosec": 123_456_789}, "frame_id": "sits_pad"}
    assert wrench["wrench"]["force"] == pytest.approx({"x": 0.3, "y": 0.0, "z": -1.2}, abs=1e-4)
    assert made.stamped([1, 2, 3, 4, 5, 6], 0)["wrench"]["torque"] == {"x": 5.0, "y": 3.0, "z": 6.0}
    assert found["sits/counts"]["data"] == codes.tolist() and json.dumps(found)
