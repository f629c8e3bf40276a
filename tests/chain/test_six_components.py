"""All six components through the whole chain and on the command line: turned scenes, the plane chain, refusals."""

import json

import numpy as np
import pytest

from sits_mech.chain.models import loaded_model
from sits_mech.chain.simulate import simulate
from sits_mech.cli.main import run
from sits_mech.geometry.collision import Collision
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor


@pytest.fixture(scope="module")
def sensor():
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def sheared(sensor):
    return simulate(sensor, Wrench(0.3, 1.0, 1e-4, F_y=1e-9))


@pytest.mark.slow
def test_a_load_in_the_plane_is_that_of_the_plane_chain(sensor, sheared):
    there, _ = loaded_model(sensor, "sheets", 1e-2, (sheared.equilibrium.wrench,))
    np.testing.assert_allclose(
        sheared.impedance.L, there.impedance(sheared.equilibrium.pose, sensor.frequency).L, rtol=1e-7
    )
    plane = simulate(sensor, Wrench(0.3, 1.0, 1e-4), magnetics="sheets")
    for name in ("L", "R"):
        one, two = getattr(plane.impedance, name), getattr(sheared.impedance, name)
        both = getattr(plane.impedance, f"error_{name}") + getattr(sheared.impedance, f"error_{name}")
        assert np.all(np.abs(one - two) < both)
    assert abs(plane.signals.L_h - sheared.signals.L_h) < plane.signals.error_L_h + sheared.signals.error_L_h


@pytest.mark.slow
def test_shear_along_y_over_turned_coils_is_shear_along_x(sensor, sheared):
    """Pad, target and mesh are their own image under a quarter turn, and so are the coils' rings.

    Where their tracks see the metal's field does not turn with them, by a small part of the error.
    """
    turned = load_sensor("biorob2018", ["coils.C1.centre=[0, -0.004]", "coils.C2.centre=[0, 0.004]"])
    found = simulate(turned, Wrench(F_y=0.3, F_z=1.0, M_x=-1e-4))
    one, other = (
        sheets(scene, 1e-2).impedance(each.equilibrium.pose, sensor.frequency)
        for scene, each in ((sensor, sheared), (turned, found))
    )
    np.testing.assert_allclose(other.L, one.L, rtol=1e-6)
    assert np.all(np.abs(found.impedance.L - sheared.impedance.L) < 0.1 * sheared.impedance.error_L)
    np.testing.assert_allclose(found.impedance.R, sheared.impedance.R, rtol=0, atol=1e-3 * sheared.impedance.R.max())


@pytest.mark.slow
def test_command_line(capsys):
    """The keys of a load in the plane, and those of the others; the coils do not tell +y from -y."""
    words = ["simulate", "biorob2018", "--fx", "0.3 N", "--fz", "1 N", "--json", "--fy"]
    both = []
    for force in ("0.2 N", "-0.2 N"):
        assert run([*words, force]) == 0
        both.append(json.loads(capsys.readouterr().out))
    assert list(both[0]["pose"]) == list(both[0]["error"]) == ["d_h", "d_v", "alpha", "d_y", "alpha_x", "alpha_z"]
    assert both[0]["wrench"] == {"F_x": 0.3, "F_z": 1.0, "M": 0.0, "F_y": 0.2, "M_x": 0.0, "M_z": 0.0}
    assert set(both[0]) >= {"L", "R", "L0", "signals", "unit_L", "frequency"}
    assert set(both[0]["report"]) == {"mechanics", "magnetics"} and both[0]["unit_L"] == "H"
    assert both[0]["pose"]["d_y"] == pytest.approx(-both[1]["pose"]["d_y"], rel=1e-6)
    np.testing.assert_allclose(both[0]["L"], both[1]["L"], rtol=1e-8)
    assert run([*words[:-2], "--fy", "0.2 N"]) == 0
    out = capsys.readouterr().out
    assert all(name in out for name in ("d_y", "alpha_x", "alpha_z", "L_h", "F_y = 0.2 N"))


def test_zero_leaves_the_plane_contract_as_it_is(capsys):
    """--fy "0 N" is no load out of the plane."""
    words = ["--fz", "0.1 N", "--fy", "0 N", "--model", "linear", "--tolerance", "0.1"]
    assert run(["pose", "biorob2018", *words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["report"]["model"] == "linear" and found["wrench"]["F_y"] == found["pose"]["d_y"] == 0.0


PLANE = "planar: F_y must be zero for planar, which is plane; got other values"


@pytest.mark.parametrize(
    "words, line",
    [
        (["pose", "biorob2018", "--fy", "1 N", "--model", "planar"], f"mechanics {PLANE}; block would"),
        (["simulate", "biorob2018", "--fy", "1 N", "--magnetics", "planar"], f"magnetics {PLANE}; sheets would"),
        (["pose", "biorob2018", "--mz", "1 N"], "--mz: must be a moment"),
        (["pose", "biorob2018", "--fy", "nan N"], "--fy: must be"),
        (["pose", "biorob2018", "--fy", "1 N", "--tolerance", "2"], "tolerance must lie between 0 and 1"),
    ],
)
def test_refusals_are_one_line(capsys, words, line):
    assert run(words) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and line in err


@pytest.mark.slow
def test_too_much_is_not_converged(capsys):
    square = [f'{part}.{side}="4 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    scene = [word for change in (*square, 'elastomer.thickness="4 mm"') for word in ("--set", change)]
    assert run(["pose", "biorob2018", *scene, "--mz", "0.9 N*m", "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    assert found["report"]["status"] == "load path ended" and list(found["pose"]) == list(found["error"])
    assert set(found["wrench"]) == {"F_x", "F_z", "M", "F_y", "M_x", "M_z"} and 0.0 <= found["wrench"]["M_z"] < 0.9


def test_refusals_of_the_chain(sensor, monkeypatch):
    with pytest.raises(SceneError, match="F_y must be zero for planar-fem, .*; got other values; sheets would$"):
        simulate(sensor, Wrench(F_y=0.1), magnetics="planar-fem")
    pose = Pose(0.0, 1.9e-3, alpha_x=0.6)  # 4 mm sin 0.6 > 1.9 mm
    deep = Equilibrium(Wrench(F_y=0.1), pose, Pose(0.0, 0.0), np.zeros(0), SolveReport("block", 1, 1, 0.0, 0.0, 0.0))
    monkeypatch.setattr("sits_mech.mechanics.block.BlockPad.equilibrium", lambda *_, **__: deep)
    with pytest.raises(Collision, match="coil plane"):
        simulate(sensor, Wrench(F_y=0.1))
