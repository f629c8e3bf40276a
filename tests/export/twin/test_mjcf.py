"""The pad as joints: springs and heights that give its compliance back, dampers of its spectrum, and MuJoCo itself."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from sits_mech.export.twin.mjcf import bottom_stiffness, joints, loss_time, mjcf
from sits_mech.quantities import POSE
from sits_mech.report.folder import read_calibration

HEIGHT = 2e-4  # of the load above the bottom face
STIFF = np.diag([800.0, 8000.0, 0.03, 900.0, 0.04, 0.01])  # about the bottom face, z upwards
STIFF[0, 2] = STIFF[2, 0] = 0.7
STIFF[3, 4] = STIFF[4, 3] = -0.9


def compliance() -> np.ndarray:
    """Pose by wrench at the load's height, F_z pressing down: of a stiffness by hand."""
    at_bottom = np.eye(6)  # F_x at a height turns by its lever, F_y the other way
    at_bottom[1, 1], at_bottom[2, 0], at_bottom[4, 3] = -1.0, HEIGHT, -HEIGHT
    return np.linalg.inv(STIFF) @ at_bottom


def numbers(**more: object) -> dict[str, object]:
    """What a twin holds of its pad."""
    rest = np.array([0.0, 2e-3, 0.0, 0.0, 0.0, 0.0])
    own = {"compliance": compliance(), "load_height": np.array(HEIGHT), "rest_pose": rest, "prony": np.zeros((0, 2))}
    return own | more


def test_stiffness_about_the_bottom_face() -> None:
    """That by hand; without what leaves the plane, the plane's own."""
    assert bottom_stiffness(compliance(), HEIGHT) == pytest.approx(STIFF, rel=1e-12)
    flat = compliance()
    flat[3:] = flat[:, 3:] = np.nan
    K = bottom_stiffness(flat, HEIGHT)
    assert K[:3, :3] == pytest.approx(STIFF[:3, :3], rel=1e-12) and np.isnan(K[3, 3])
    assert list(joints(K)) == ["d_h", "d_v", "alpha"]


def test_joints_store_the_pads_energy() -> None:
    """Slides by s, then hinges about axes at heights p: the bottom face moves by s - p alpha and s + p alpha_x."""
    found, random = joints(STIFF), np.random.default_rng(1)
    q = random.normal(size=6) * [1e-4, 1e-4, 1e-2, 1e-4, 1e-2, 1e-2]
    slide = {"d_h": q[0] + found["alpha"][1] * q[2], "d_v": q[1], "d_y": q[3] - found["alpha_x"][1] * q[4]}
    turns = {"alpha": q[2], "alpha_x": q[4], "alpha_z": q[5]}
    energy = sum(0.5 * found[name][0] * moved**2 for name, moved in (slide | turns).items())
    assert energy == pytest.approx(0.5 * q @ STIFF @ q, rel=1e-12)


def test_the_spectrum_is_the_loss_at_one_hertz() -> None:
    """Of one branch c/k = g tau/(1 + (2 pi tau)^2), g = w/(1 - w)."""
    tau, w = 0.5, 0.2
    assert loss_time(np.array([[w, tau]])) == pytest.approx(0.25 * tau / (1.0 + np.pi**2), rel=1e-12)
    assert loss_time(np.zeros((0, 2))) == 0.0


def test_the_file(calibrated: Path) -> None:
    """Well-formed, a joint for each known component, whether the relaxation is known; none without compliance."""
    sensor, _ = read_calibration(calibrated)
    text = mjcf(sensor, numbers()) or ""
    names = [joint.get("name") for joint in ElementTree.fromstring(text).iter("joint")]
    assert sorted(map(str, names)) == sorted(f"sits_{name}" for name in POSE)
    assert "Relaxation of the silicone: not known" in text
    slow = mjcf(sensor, numbers(prony=np.array([[0.2, 0.5]]))) or ""
    assert "Relaxation of the silicone: known" in slow
    for joint in ElementTree.fromstring(slow).iter("joint"):
        assert float(joint.get("damping")) / float(joint.get("stiffness")) == pytest.approx(0.0115, rel=1e-2)
    assert mjcf(sensor, numbers(compliance=np.full((6, 6), np.nan))) is None


def test_mujoco_finds_the_compliance(calibrated: Path) -> None:
    """Small loads at the load's height, at rest: the pose of the bottom face is the compliance's."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(mjcf(read_calibration(calibrated)[0], numbers()))
    model.opt.gravity[:] = 0.0
    target, data = model.body("sits_target").id, mujoco.MjData(model)
    for load in np.diag([1e-3, 1e-2, 1e-6, 1e-3, 1e-6, 1e-6]):
        mujoco.mj_resetData(model, data)
        for _ in range(400):
            face = data.site("sits_face").xpos if data.time else np.array([0.0, 0.0, 2e-3])
            force = np.array([load[0], load[3], -load[1]])
            moment = np.array([load[4], load[2], load[5]]) + np.cross(face + [0, 0, HEIGHT] - data.xipos[target], force)
            data.xfrc_applied[target] = [*force, *moment]
            mujoco.mj_step(model, data)
        place, turn = data.sensor("sits_place").data, 2.0 * data.sensor("sits_turn").data[1:]
        pose = np.array([place[0], place[2] - 2e-3, turn[1], place[1], turn[0], turn[2]])
        scale = np.array([1e-6, 1e-6, 1e-4, 1e-6, 1e-4, 1e-4])
        assert np.abs((pose - compliance() @ load) / scale).max() < 0.02
