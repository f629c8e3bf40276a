"""Which slips of a unit are told, and is nothing told of what the catalogue holds?"""

from __future__ import annotations

import pytest

from sits_mech.cli.main import run
from sits_mech.quantities import Pose
from sits_mech.scene.plausible import LENGTH, bare_lengths, slips, slips_of_pose
from sits_mech.scene.sensor import catalogue, load_sensor

YEOH = 'elastomer.material={law="yeoh", c10="20 kPa", c20="-2 kPa", c30=0, bulk_modulus="20 MPa"%s}'


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_nothing_is_said_of_the_catalogue(name: str) -> None:
    assert slips(load_sensor(name)) == ()


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("elastomer.thickness=2", "elastomer.thickness = 2 m; a length of such a sensor is usually 1e-06 m to 0.2 m"),
        ('coils.0.track_gap="0.1 um"', "coils.C1.track_gap = 1e-07 m"),
        ("coils.0.centre=[-4, 0]", "coils.C1.centre = -4 m; a coordinate of such a sensor is usually up to 0.2 m"),
        ('frequency="5 mHz"', "frequency = 0.005 Hz; the frequency of such a sensor is usually 1 Hz to 1e+09 Hz"),
        ('elastomer.material={law="neo-hookean", shear_modulus="30 Pa", bulk_modulus="3 MPa"}', "modulus of 30 Pa"),
        ("coils.0.directions=[1, -1]", "coils.C1.directions = +1, -1: layers in series run against each other"),
        (YEOH % "", "yeoh with c20 = -2e+03 Pa has no fitted_range and is unstable from a stretch of"),
    ],
)
def test_slips_of_a_scene_are_told(override: str, said: str) -> None:
    (line,) = slips(load_sensor("biorob2018", [override]))
    assert line.startswith("implausible: ") and said in line


def test_law_that_falls_beyond_a_range_that_is_told_is_no_slip() -> None:
    assert slips(load_sensor("biorob2018", [YEOH % ", fitted_range=[0, 0.5]"])) == ()


def test_points_are_told_once() -> None:
    outline = 'target={shape="outline", material="copper", thickness="0.2 mm", points=[[-4,-4],[4,-4],[4,4],[-4,4]]}'
    assert len(slips(load_sensor("biorob2018", [outline, 'elastomer.width="8 m"', 'elastomer.length="8 m"']))) == 3


def test_slips_of_a_pose_are_told() -> None:
    assert slips_of_pose(Pose(1e-3, 2e-3, 0.2)) == ()
    lines = slips_of_pose(Pose(0.0, 2.0, 10.0))
    assert [line.split()[1] for line in lines] == ["d_v", "alpha"] and "in radians without a unit" in lines[1]


def test_zero_is_usual() -> None:
    assert LENGTH.slip("standoff", 0.0) == ""


def test_strict_makes_them_errors(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["inductance", "biorob2018", "--dv", "2 mm", "--set", 'frequency="5 mHz"', "--tolerance", "0.1", "--accept"]
    assert run(words) == 0
    assert "biorob2018: implausible: frequency" in capsys.readouterr().err
    assert run([*words, "--strict"]) == 2
    assert capsys.readouterr().err.startswith("error: biorob2018: implausible: frequency")
    assert run(["inductance", "biorob2018", "--dv", "2 m", "--strict"]) == 2
    assert "error: the pose: implausible: d_v = 2 m" in capsys.readouterr().err


@pytest.mark.parametrize(
    "asked",
    [("--set", "elastomer.thickness=3"), ("--set", "coils.C1.centre=[1, 2]"), ("--set", "target.width='15'"),
     ("--set", "coils.0.track_width=1e-4"), ("--dv", "2"), ("--dh", "-0.5")],
)
def test_bare_lengths_on_the_command_line_are_refused(
    asked: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line that names the option; scene files keep SI, as does --si."""
    words = ["inductance", "biorob2018", *asked, *(() if asked[0] == "--dv" else ("--dv", "2 mm"))]
    assert run(words) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {asked[0]} ") and 'must be a length with a unit, such as "2 mm"; --si takes' in said


def test_other_bare_numbers_stay(capsys: pytest.CaptureFixture[str]) -> None:
    """Turns, zero, numbers that are no lengths, lengths with --si, and texts with a unit in a shell's dress."""
    sensor, bare = load_sensor("biorob2018"), "coils.C1.turns=5 elastomer.standoff=0 target.conductivity=7e6".split()
    assert bare_lengths(sensor, [*bare, "elastomer.thickness=3 mm", 'target.width="15 mm"', "frequency=5e6"]) == ()
    assert bare_lengths(sensor, ["elastomer.thickness=3e-3", "coils.C2.centre=['1 mm', 2]"]) != ()
    words = ["inductance", "biorob2018", "--dv", "0.002", "--si", "--set", "target.width=0.015", "--model", "planar"]
    assert run([*words, "--accept"]) == 0
    capsys.readouterr()
