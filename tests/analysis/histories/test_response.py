"""What a sensor shows under a history: against single loads, the models that are taken, values between times."""

import json

import numpy as np
import pytest

from sits_mech.analysis.cycle import load_cycle, triangle
from sits_mech.analysis.histories.interpolant import Interpolant
from sits_mech.analysis.histories.response import in_time, taken_layer
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.plans.plan import plan
from sits_mech.chain.simulate import simulate
from sits_mech.mechanics.histories import LoadHistory, motion_of
from sits_mech.notes import OmissionKind, unpacked_omissions
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor
from sits_mech.silicone.material import silicone_from

MODELS = {"mechanics": "planar", "magnetics": "planar", "tolerance": 3e-2}
PRESSED = np.arange(6) == 1  # d_v is given


def soft(**more):
    table = {"law": "neo-hookean", "shear_modulus": 2e4, "bulk_modulus": 2e7} | more
    base = load_sensor("biorob2018")
    layer = base.elastomer.model_copy(update={"material": silicone_from(table)})
    return base.model_copy(update={"elastomer": layer})


def loads(time, *rows):
    wrench = np.zeros((len(time), 6))
    wrench[:, :2] = rows
    return LoadHistory(np.array(time, dtype=float), wrench)


@pytest.mark.slow
def test_long_after_the_last_load_it_shows_what_slow_load_does():
    own = soft(prony=[{"weight": 0.3, "time": 0.5}])
    data = in_time(own, loads([0.0, 1.0, 40.0], (0.0, 0.0), (0.3, 1.0), (0.3, 1.0)), **MODELS)
    slow = simulate(own, Wrench(F_x=0.3, F_z=1.0), **MODELS)
    last = data.isel(time=-1)
    off = np.abs(last["L"] - slow.impedance.L)
    assert np.all(off <= last["error_L"] + slow.impedance.error_L)
    assert abs(last["L_v_percent"] - slow.signals.known["L_v_percent"]) < 0.01 * abs(
        slow.signals.known["L_v_percent"] - data["L_v_percent"][0]
    )
    assert data["given"].sum() == 3


@pytest.mark.slow
def test_a_held_press_relaxes():
    """With an error of the force and none of the place; at last by the force of slow load, ends of the pad left out."""
    own = soft(prony=[{"weight": 0.3, "time": 0.5}])
    course = np.outer([0.0, -5e-5, -5e-5, -5e-5], [0, 1, 0, 0, 0, 0])
    press = LoadHistory(np.array([0.0, 1.0, 1.5, 30.0]), course, held=PRESSED)
    data = in_time(own, press, **MODELS)
    force, error = (data[name].to_numpy()[data["given"].to_numpy()] for name in ("F_z", "error_F_z"))
    G = 1.0 + 0.3 / 0.7 * 0.5 * (1.0 - np.exp(-2.0)) * np.array([1.0, np.exp(-1.0), 0.0])
    np.testing.assert_allclose(force[1:] / force[-1], G, rtol=1e-2)  # K does not relax: silicone/history.py
    slow = simulate(own, Wrench(F_z=float(force[-1])), **MODELS).equilibrium.pose
    assert slow.d_v - 2e-3 == pytest.approx(-5e-5, rel=3e-2)
    ends = next(item.size for item in unpacked_omissions(data.attrs["left_out"]) if item.kind is OmissionKind.PAD_ENDS)
    assert np.all(error[1:] >= ends / (1.0 + ends) * force[1:]) and np.all(error < force + 1e-12)
    assert not data["F_x"].to_numpy().any() and "error_F_x" not in data and not data["error_d_v"].to_numpy().any()


def test_places_take_a_model_with_memory_at_every_point():
    with pytest.raises(SceneError, match="to follow every point; got linear"):
        in_time(soft(), LoadHistory([0.0], np.zeros((1, 6)), held=PRESSED), **MODELS | {"mechanics": "linear"})


def test_what_remembers_nothing_rests_where_a_walk_in_time_ends():
    """Within the errors of both, at each row, and a load that is not carried ends both at the same time."""
    own, press = soft(), loads(np.linspace(0.0, 1.0, 5), *((0.1 * k * (k - 2), 0.3 * k) for k in range(5)))
    data = in_time(own, press, **MODELS)
    layer = taken_layer(own, ("planar", "auto"), 3e-2, [Wrench(F_z=1.2)])[0]
    walked = motion_of(own, layer, press)
    rows = np.searchsorted(walked.time, press.time)
    for name in ("d_h", "d_v", "alpha"):
        value, error = (getattr(part, name)[rows] for part in (walked.pose, walked.error))
        given = data["given"].to_numpy()
        assert np.all(np.abs(data[name].to_numpy()[given] - value) <= data[f"error_{name}"].to_numpy()[given] + error)
    assert data["d_h"].to_numpy()[-1] > 0.0 > data["d_h"].to_numpy()[1]
    with pytest.raises(SolveFailed, match=r"at \S+ s of 1 s"):
        in_time(own, loads([0.0, 1.0], (0.0, 0.0), (0.0, 500.0)), **MODELS)


@pytest.mark.slow
def test_no_shear_by_symmetry():
    data = in_time(soft(prony=[{"weight": 0.3, "time": 0.5}]), loads([0.0, 1.0], (0.0, 0.0), (0.0, 1.0)), **MODELS)
    assert np.all(data["d_h"] == 0.0)
    assert np.all(data["error_d_h"] == 0.0)


def test_softening_takes_a_model_that_has_it():
    """Where a small load would do with a linear model."""
    small = [Wrench(), Wrench(F_z=1e-3)]
    assert taken_layer(soft(), ("auto", "planar"), 0.1, small)[1].name == "linear"
    assert taken_layer(soft(mullins={"r": 2.0}), ("auto", "planar"), 0.1, small)[1].name == "block"


def interpolant(time, share, values):
    load = np.outer(share, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    return Interpolant(time, LoadHistory(time, load).corners, values)


def test_between_times_nothing_overshoots_and_corners_stay():
    time = np.linspace(0.0, 2.0, 17)
    share = 1.0 - np.abs(time - 1.0)
    values = (share**2)[:, None]
    at = np.linspace(-1.0, 3.0, 401)
    found, error = interpolant(time, share, values).at(at)
    exact = np.clip(1.0 - np.abs(np.clip(at, 0.0, 2.0) - 1.0), 0.0, 1.0) ** 2
    np.testing.assert_allclose(found[:, 0], exact, atol=2e-3)  # 2 % at the corner without it
    assert np.all(np.abs(found[:, 0] - exact) <= error[:, 0] + 1e-15) and error.max() < 1e-2
    assert 0.0 <= found.min() <= found.max() <= 1.0
    own, none = interpolant(time, share, values).at(time)
    np.testing.assert_allclose(own, values)
    assert np.all(none == 0.0)


@pytest.mark.parametrize(
    "law",
    [
        lambda t: 1.0 - 0.3 * np.exp(-t / 0.2),  # creep
        lambda t: np.sin(1.5 * t) ** 2,
        lambda t: np.tanh(2.0 * t) + 0.1 * t,  # a pad that stiffens
        lambda t: 3.0 * t + 1.0,
    ],
)
@pytest.mark.parametrize("time", [np.linspace(0.0, 1.0, 9), np.array([0.0, 0.05, 0.15, 0.35, 0.6, 0.9, 1.0])])
def test_errors_of_interpolation_hold(law, time):
    """At 401 times of laws whose values between solved ones are known; two differences on each side or one."""
    at = np.linspace(0.0, 1.0, 401)
    found, error = interpolant(time, time, law(time)).at(at)
    off = np.abs(found - law(at))
    assert np.all(off <= error + 1e-12)
    assert error.max() <= 20.0 * off.max() + 1e-12


def test_a_kink_between_solved_times_is_seen():
    """Where softening goes on in the midst of a leg: half of what the cubic is off there at least."""
    time, at = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 401)
    for kink in np.linspace(0.2, 0.8, 13):
        found, error = interpolant(time, time, np.minimum(time, kink + 0.7 * (time - kink))).at(at)
        assert error.max() >= 0.5 * np.abs(found - np.minimum(at, kink + 0.7 * (at - kink))).max()


def test_after_a_sudden_load_values_are_those_after_it():
    time, share = np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 0.0, 1.0, 1.0])
    found, error = interpolant(time, share, share).at(np.array([0.5, 1.0, 1.5]))
    assert found.tolist() == [0.0, 1.0, 1.0] and not error.any()


def smooth(rows):
    time = np.linspace(0.0, 1.0, rows)
    return loads(time, *np.outer(np.sin(np.pi * time) ** 2, [0.0, 2.0]))


@pytest.fixture
def alone(numerics_alone):
    """Errors of the section are larger than any of interpolation."""
    with numerics_alone():
        yield


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanics", "more"),
    [("linear", {}), ("linear", {"prony": [{"weight": 0.3, "time": 0.1}]}), ("planar", {"mullins": {"r": 2.0}})],
)
def test_rows_between_solved_ones_are_as_if_solved(mechanics, more, alone, monkeypatch):
    """Within their estimated errors, of a press with every row solved; ten times the rows cost no more solves."""
    own, asked, models = soft(**more), smooth(61), MODELS | {"mechanics": mechanics}
    found, dense = (in_time(own, each, **models) for each in (asked, smooth(601)))
    monkeypatch.setattr(LoadHistory, "divided", lambda self, *_: (self, np.ones(self.time.size, dtype=bool)))
    every = in_time(own, asked, **models)
    few, every = (each.isel(time=np.flatnonzero(each["given"].to_numpy())) for each in (found, every))
    for name in ("d_v", "L_v_percent", "L"):
        off = np.abs(few[name].to_numpy() - every[name].to_numpy())
        over, span = off - few[f"error_{name}"].to_numpy(), np.ptp(every[name].to_numpy())
        assert np.mean(over > 0.0) <= 0.02 and over.max() < 1e-4 * span and off.max() < 4e-3 * span
    kept = [each["flags"].to_numpy()[each["given"].to_numpy()] for each in (found, dense)]
    solved = [sum("interpolated" not in row for row in rows) for rows in kept]
    assert solved[0] < 50 and solved[1] < solved[0] + 12
    words, before = ({*each["status"].to_numpy()} - {"interpolated"} for each in (few, every))
    assert words <= before


def test_only_rows_that_a_straight_line_misses_are_solved():
    """All rows of a history that turns at each; ends and one time at least of a straight one."""
    jagged, straight = (loads(range(9), *((0.0, law(k)) for k in range(9))) for law in (lambda k: k % 2, float))
    assert jagged.divided(1)[0].solved.all()
    assert np.flatnonzero(straight.divided(1)[0].solved).tolist() == [0, 4, 8]
    assert np.flatnonzero(straight.divided(4)[0].solved).tolist() == [0, 2, 4, 6, 8]


@pytest.mark.slow
def test_a_model_of_one_mesh_is_chosen_again_for_cycles_histories_and_plans():
    """As for one load: rubber that `linear` would answer, beside the coils' error, above the tolerance."""
    rubber = load_sensor("biorob2018", ['elastomer.material={E="3 MPa", nu=0.499}'])
    load, course = Wrench(F_z=1.3), loads([0.0, 1.0], (0.0, 0.0), (0.0, 1.3))
    for data in (load_cycle(rubber, load, triangle(1.0, 1, samples=4), points=5), in_time(rubber, course)):
        assert json.loads(data.attrs["request"])["mechanics"] == "block" and data.attrs["error"] < 1e-2
    assert mechanical_model(rubber, loads=[load])[1].name == "linear" and plan(rubber, [load]).mechanics.name == "block"
