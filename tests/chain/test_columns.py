"""Columns of a table: over all loads, NaN or nothing where a load has no rest or no reading."""

import numpy as np
import pytest

from sits_mech.chain.columns import of_readings, of_rests, over_grid
from sits_mech.chain.propagation import PoseReadings, signal_weights
from sits_mech.magnetics.pose_slopes import KnownImpedance
from sits_mech.quantities import POSE, Bounded, Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.readout.signals import rows_of, signal_changes, signals
from sits_mech.scene.sensor import load_sensor


def test_columns_lie_on_the_grid_where_their_loads_are():
    axes = {"F_x": [0.0, 1.0], "F_z": [0.0, 1.0, 2.0]}
    known = [True, False, True, True, False, True]
    found = over_grid(axes, known, {"d_h": ((), [1.0, 2.0, 3.0, 4.0]), "notes": ((), ["a", "b", "c", "d"]),
                                 "L": (("coil",), np.arange(8.0).reshape(4, 2))})
    assert found["d_h"][0] == ("F_x", "F_z") and found["L"][0] == ("F_x", "F_z", "coil")
    np.testing.assert_array_equal(found["d_h"][1], [[1.0, np.nan, 2.0], [3.0, np.nan, 4.0]])
    assert found["notes"][1].tolist() == [["a", "", "b"], ["c", "", "d"]]
    assert found["L"][1].shape == (2, 3, 2) and np.isnan(found["L"][1][0, 1]).all()
    assert found["L"][1][1, 2].tolist() == [6.0, 7.0]


def test_a_table_without_any_reading_keeps_its_shape():
    values = over_grid({"F_z": [0.0, 1.0]}, [False, False], {"L": (("coil",), np.zeros((0, 4)))})["L"][1]
    assert values.shape == (2, 4) and np.isnan(values).all()


def test_a_rest_has_the_components_that_any_load_moves_and_its_report():
    report = SolveReport("formula", 7, 5, 0.0, 3e-3, 0.0, min_J=0.8, stretch=1.2)
    rest = Equilibrium(Wrench(), Pose(*range(6)), Pose(*range(10, 16)), np.zeros(0), report)
    flat, whole = (of_rests([rest, rest], leaves=leaves) for leaves in (False, True))
    numbers = {"min_J": 0.8, "stretch": 1.2, "error_mechanics": 3e-3, "iterations": 5.0}
    for found, names in ((flat, POSE[:3]), (whole, POSE)):
        each = {name: float(k) for k, name in enumerate(names)}
        each |= {f"error_{name}": 10.0 + k for k, name in enumerate(names)} | numbers
        assert {name: (dims, values.tolist()) for name, (dims, values) in found.items()} == {
            name: ((), [value] * 2) for name, value in each.items()
        }
    assert of_rests([], leaves=False)["d_h"][1].shape == (0,)


def test_a_reading_has_its_signals_untilted_ones_and_the_parts_of_their_errors():
    """Three readings of two coils, a part of the pose's errors and one of the coils' own."""
    sensor, L0, rng = load_sensor("biorob2018"), np.full(2, 2.5e-6), np.random.default_rng(1)
    weights = signal_weights(sensor)
    L, level = 2.5e-6 - 1e-8 * rng.random((3, 2)), 2.5e-6 - 1e-8 * rng.random((3, 2))
    shared, below, alone, turned = (1e-12 * rng.random(size) for size in ((2, 3, 2), (2, 3, 2), (4, 3, 2), (3, 5)))
    each, full = np.eye(2) * L[..., None], np.full((3, 2, 2), 1e-10)
    report = SolveReport("any", 0, 0, 0.0, 0.0, 0.0)
    impedance = Impedance(1e6, each, 1e7 * each, 2.5e-6 * np.eye(2), np.ones(2), full, 2.0 * full, "H", report)
    shown, flat = signals(L, L0, weights, 1e-11), signals(level, L0, weights)
    poses = Bounded.of(np.zeros((3, 6)), np.ones((3, 6)), 1e-7 * rng.random((1, 3, 6)))
    reading = PoseReadings(impedance, shown, flat, shared, below, alone, turned, KnownImpedance(impedance, {}))
    found = of_readings(sensor, reading, poses)
    values = {name: own for name, (_, own) in found.items()}
    for name in ("L", "R", "error_L", "error_R"):
        assert found[name][0] == ("coil", "coil_2") and values[name] is getattr(impedance, name)
    assert all(values[name] is value for name, value in shown.known.items())
    untilted = {"dL_x_untilted": flat.dL_x, "dL_y_untilted": flat.dL_y, "L_h_untilted_percent": flat.L_h_percent}
    assert all(values[name] is value for name, value in untilted.items())
    for name, own in signal_changes(shared, L0, weights).items():
        np.testing.assert_array_equal(values[f"shared_{name}"], own.T)
    for name, key in (("dL_x", "dL_x_untilted"), ("dL_y", "dL_y_untilted"), ("L_h_percent", "L_h_untilted_percent")):
        np.testing.assert_array_equal(values[f"shared_{key}"], signal_changes(below, L0, weights)[name].T)
    for k, name in enumerate(POSE):  # the coils' own part moves no pose
        np.testing.assert_array_equal(values[f"shared_{name}"], np.stack([poses.shared[0, :, k], np.zeros(3)], axis=1))
    assert found["shared_L"][0] == ("part", "coil") and found["alone_L"][0] == ("cause", "coil")
    assert found["shared_dL_v"][0] == ("part",) and found["dL_v"][0] == ()
    np.testing.assert_array_equal(values["shared_L"], shared.swapaxes(0, 1))
    np.testing.assert_array_equal(values["alone_L"], alone.swapaxes(0, 1))
    by_turn = 100.0 * turned / L0.mean()
    assert len(rows_of(weights)) == 5 and values["error_L_h_turned"] == pytest.approx(by_turn[:, 4])
    assert values["error_dL_x_turned"] == pytest.approx(by_turn[:, 1])
    assert {name for name in found if name.endswith("turned")} == {f"error_{n}_turned" for n in ("dL_x", "dL_y", "L_h")}
