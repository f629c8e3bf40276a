"""A bench of poses by a model by hand: holder, axis, leads, tank, keys of the scene come back; others are refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from common.track_losses import track_spectrum

from sits_mech.analysis.bench.setup import Setup
from sits_mech.analysis.bench.unknowns import PriorParameter, known, parameters_of
from sits_mech.analysis.built import comparison
from sits_mech.analysis.readings.measured import Measured
from sits_mech.cli.main import run
from sits_mech.quantities import Array, Impedance, Pose, SolveReport
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import Sensor, load_sensor

MM, DEGREE = 1e-3, np.pi / 180.0
FREE = 2.5e-6


class ByHand:
    """Two coils that see the height over them of a plate, and how wide it is [H]."""

    def __init__(self, sensor: Sensor) -> None:
        assert sensor.target is not None and sensor.target.width is not None
        self.width = sensor.target.width

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        x, _, z = np.moveaxis(pose.centre / MM, -1, 0)
        alpha = pose.rotation[..., 1]
        heights = [z - np.tan(alpha) * (side - x) for side in (-4.0, 4.0)]
        near = np.stack([0.3 * (self.width / 8e-3) ** 2 * np.exp(-0.7 * each) * (1.0 + 0.2 * side * x)
                         for side, each in zip((-1.0, 1.0), heights, strict=True)], -1)
        L = FREE * (1.0 - near)[..., None] * np.eye(2)
        report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
        return Impedance(frequency, L, 0.1 + 0.0 * L, FREE * np.eye(2), np.ones(2), 0.0 * L, 0.0 * L, "H", report)


class Coupled(ByHand):
    """The same with a mutual inductance that the plate takes from, and unlike coils."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        found = super().impedance(pose, frequency)
        whole, apart = np.array([[0.0, 0.1], [0.1, 0.0]]), np.diag([1.0, 1.1])
        L = apart @ found.L + whole * np.einsum("...ii->...", found.L)[..., None, None]
        return replace(found, L=L, L0=apart @ found.L0 + 2.0 * FREE * whole)


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published one, idle coils open."""
    return load_sensor("biorob2018", ['readout.idle_coil="open"'])


@pytest.fixture(scope="module")
def poses() -> Array:
    """No target, heights, places and angles."""
    rows = [(0, np.inf, 0), (0, 1, 0), (0, 2, 0), (0, 5, 0), (0, 2, 20), (1, 2, 0), (0, 3, -15), (-1, 3, 10)]
    return np.array([[x * MM, z * MM, a * DEGREE, 0.0, 0.0, 0.0] for x, z, a in rows])


def test_texts_are_read() -> None:
    """Names alone, values with one unit or two, keys of the scene in any unit."""
    assert known(" gap ") == PriorParameter("gap")
    assert known("gap=0+-0.3mm") == PriorParameter("gap", 0.0, 3e-4) == known("gap = 0 um +- 300 um")
    angle, metal = known("alpha=-1±2 deg"), known("target.conductivity = 58 +- 2 MS/m")
    np.testing.assert_allclose([angle.value, angle.deviation], [-DEGREE, 2.0 * DEGREE], rtol=1e-14)
    assert metal == PriorParameter("target.conductivity", 5.8e7, 2e6)
    assert known("target.width=8 mm +- 0.1") == PriorParameter("target.width", 8e-3, 1e-4)
    for text, why in (
        ("colour", 'got "colour"'), ("gap=1 mm", "fit: must be modulus"), ("gap=0+-1 N", "gap: must be a length"),
        ("gap=0+-0 mm", "a deviation above 0"), ("gap=0+--1 mm", "a deviation above 0"),
        ("gap=0+-5 %", "gap: must be a length"), ("target.width=8 mm+-20 kHz", "target.width: must be a length"),
        ("elastomer.material.c10=9 kPa+-2 mm", "c10: must be a pressure"),
        ("modulus=0+-0.3", "factors above 0"),
        ("cell=-1+-0.3", "factors above 0"), ("target.width=8 mm+-thin", "must be a number"),
    ):
        with pytest.raises(ValueError, match=why):
            known(text)


@pytest.mark.parametrize(
    ("text", "value", "deviation"),
    [
        ("modulus=1.2+-5 %", 1.2, 0.06), ("modulus=100 % +- 5 %", 1.0, 0.05), ("stiffening = 0 +- 5 %", 0.0, 0.05),
        ("target.width = 8 mm +- 5 %", 8e-3, 4e-4), ("d_h = -1 mm +- 20 %", -1e-3, 2e-4),
        ("elastomer.material.c10 = 9 kPa +- 10 %", 9e3, 9e2),
    ],
)
def test_percents_are_of_the_value(text: str, value: float, deviation: float) -> None:
    """Of parameters and keys alike, but where the value is zero or in percent."""
    found = known(text)
    assert (found.value, found.deviation) == pytest.approx((value, deviation), rel=1e-12)


def test_what_no_bench_of_the_kind_has_is_refused(sensor: Sensor) -> None:
    """A modulus of poses, an axis of loads, keys without a deviation or not in the scene, one parameter twice."""
    for texts, posed, why in (
        (["modulus"], True, "modulus: must be of loads"), (["axis_z"], False, "axis_z: must be of poses"),
        (["target.width"], True, "must come with what is known"), (["gap", "gap"], True, "different parameters"),
        (["target.colour=1+-1"], True, "a number that the scene gives"), ([], True, "got none"),
    ):
        with pytest.raises(ValueError, match=why):
            parameters_of(sensor, texts, posed)


def test_stages_turn_the_target_about_their_axis(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """The material point on the axis stays where it was; what the holder adds turns the target in its own frame."""
    seen: list[Pose] = []

    class Kept(ByHand):
        def impedance(self, pose: Pose, frequency: float) -> Impedance:
            """Keep what is asked for."""
            seen.append(pose)
            return super().impedance(pose, frequency)

    bench = Setup(sensor, tuple(known(name) for name in ("axis_x", "axis_z", "alpha_x")), Kept)
    set_pose = np.array([[[0.5 * MM, 4.0 * MM, 0.3, 0.0, 0.0, 0.0]]])
    axis, tilt = np.array([0.7 * MM, 0.0, -0.9 * MM]), 0.05
    bench.readings(set_pose, np.array([[axis[0], axis[2], tilt]]))
    moved, about_y = seen[0], np.array([0.0, 0.3, 0.0])
    centre, start = moved.centre.reshape(3), np.array([0.5 * MM, 0.0, 4.0 * MM])
    np.testing.assert_allclose(centre + rotation_matrix(about_y) @ axis, start + axis, atol=1e-15)
    whole = rotation_matrix(about_y) @ rotation_matrix(np.array([tilt, 0.0, 0.0]))
    np.testing.assert_allclose(rotation_matrix(moved.rotation.reshape(3)), whole, atol=1e-14)


def test_leads_tank_and_keys_are_closed_forms(sensor: Sensor, poses: Array) -> None:
    """(L + l) (1 + c / C); a parabola of the width is met; a pose that touches the coils has no answer."""
    texts = ("lead", "capacitance", "target.width=8.1+-0.1mm", "gap")
    bench = Setup(sensor, tuple(known(text) for text in texts), ByHand)
    P = np.array([[30e-9, 66e-12, 8.27e-3, 0.0], [0.0, 0.0, 8e-3, -0.95e-3]])
    found = bench.readings(np.tile(poses, (2, 1, 1)), P)
    changed = load_sensor("biorob2018", ['readout.idle_coil="open"', "target.width=8.27e-3"])
    there = ByHand(changed).impedance(Pose.of(poses[1:]), 5e6).L
    expected = np.vstack([[FREE, FREE], np.diagonal(there, axis1=-2, axis2=-1)])
    uneven = track_spectrum(changed.coils[0], [changed.frequency]).shift[0]
    np.testing.assert_allclose(found[0], (expected + uneven + 30e-9) * 1.2, rtol=1e-10)
    assert np.all(np.isnan(found[1]))


@pytest.mark.parametrize("idle", ["open", "shorted", "live"])
def test_leads_are_those_of_a_scene_that_has_them(poses: Array, idle: str) -> None:
    """In the loops of idle coils as well, so that a corrected scene shows what was fitted; so are the derivatives."""
    plain, longer = (load_sensor("biorob2018", [f'readout.idle_coil="{idle}"', f"readout.lead_inductance={lead!r}"])
                     for lead in (10e-9, 40e-9))
    setup = Setup(plain, (known("lead"), known("gap")), Coupled)
    found, true = setup.readings(poses[None], np.array([[30e-9, 0.0]]))[0], Setup(longer, (), Coupled)
    expected = true.readings(poses[None], np.zeros((1, 0)))[0]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    added = found - setup.readings(poses[None], np.zeros((1, 2)))[0]
    assert (np.max(np.abs(added - 30e-9)) > 1e-11) == (idle == "shorted")  # equal leads turn no mode of live tanks
    P = np.array([[sign * 1e-9, 0.0] for sign in (1.0, -1.0)])
    high, low = setup.readings(np.tile(poses[1:], (2, 1, 1)), P)
    slopes = setup.slopes(poses[1:], np.zeros(2), np.zeros((2, len(poses) - 1, 6)))
    np.testing.assert_allclose(slopes.direct[..., 0], (high - low) / 2e-9, rtol=1e-6)


def test_a_bench_of_poses_comes_back(
    sensor: Sensor, poses: Array, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Gap, offset, tilt, axis and tank within their intervals of one draw of noise; so says the command, in words."""
    monkeypatch.setattr(comparison, "magnetic_model", lambda scene, *_: (ByHand(scene), None))
    texts = ["gap=0+-0.2mm", "d_h=0+-0.2mm", "alpha=0+-2deg", "axis_z=0+-1mm", "capacitance=90+-50pF"]
    bench = Setup(sensor, tuple(known(text) for text in texts), ByHand)
    true, noise = np.array([-0.15 * MM, 0.1 * MM, 1.5 * DEGREE, -0.8 * MM, 70e-12]), 2e-9
    L = bench.readings(poses[None], true[None])[0] + noise * np.random.default_rng(3).standard_normal((len(poses), 2))
    found = comparison.compare(sensor, None, Measured(np.zeros((len(poses), 0)), L, "", poses), texts, noise=noise)
    assert np.all(np.abs(found.fit.values - true) <= 1.5 * found.fit.half_widths)
    assert np.all(found.fit.half_widths < 0.5 * 1.96 * np.array([each.deviation for each in found.free]))
    rows = [",".join(f"{1e3 * p[0]},{1e3 * p[1]},{p[2] / DEGREE},{1e6 * a!r},{1e6 * b!r}".split(","))
            for p, (a, b) in zip(poses.tolist(), L.tolist(), strict=True)]
    (tmp_path / "bench.csv").write_text("d_h [mm],d_v [mm],alpha [deg],L1 [uH],L2 [uH]\n" + "\n".join(rows))
    words = ["compare", "biorob2018", str(tmp_path / "bench.csv"), "--free", ",".join(texts), "--noise", "2 nH"]
    assert run(words) == 0
    said = capsys.readouterr().out
    assert "axis_z" in said and " deg" in said and " pF" in said
    assert run(words[:-2]) == 2
    assert "noise: must be given where a parameter has a deviation" in capsys.readouterr().err
    with pytest.raises(ValueError, match="loads must come with a calibration"):
        comparison.compare(sensor, None, Measured(np.ones((4, 2)), L[:4], "bench"), ["gap"])


def test_poses_that_set_ups_share_are_solved_once(sensor: Sensor, poses: Array) -> None:
    """Leads and the tank move nothing, nor does a key of the scene: readings are those of each set-up alone."""
    asked = list[int]()

    class Counted(ByHand):
        """Counts poses."""

        def impedance(self, pose: Pose, frequency: float) -> Impedance:
            """Return the closed form."""
            asked.append(len(pose.centre))
            return super().impedance(pose, frequency)

    setup = Setup(sensor, (PriorParameter("gap"), PriorParameter("lead")), Counted)
    P = np.array([[0.0, 0.0], [0.0, 1e-8], [2e-5, 0.0]])
    found = setup.readings(np.tile(poses, (3, 1, 1)), P)
    assert asked == [2 * (len(poses) - 1)]
    for each, p in zip(found, P, strict=True):
        np.testing.assert_array_equal(each, setup.readings(poses[None], p[None])[0])
