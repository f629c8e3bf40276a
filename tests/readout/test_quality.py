"""Quality figures of sensors whose figures are known."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from sits_mech.readout.calibration import Calibration, calibration_of
from sits_mech.readout.quality import quality
from sits_mech.readout.signals import weights_of

A = np.array([[2e-8, -3e-9], [-2e-8, -3e-9]])  # dL/d(F_x, F_z) [H/N]
SHEAR, PRESS, NOISE = 1e-8, -4e-9, 1e-12  # slopes of a triple [H/N], noise [H]


def made(bend: float = 0.0) -> Calibration:
    """L = 2 uH + A F, with a bend of L_v along F_z."""
    x, z = np.meshgrid(np.linspace(-1, 1, 7), np.linspace(0, 4, 7), indexing="ij")
    F = np.stack([x, z], -1).reshape(-1, 2)
    L = 2e-6 + F @ A.T - bend * F[:, 1:] ** 2
    return calibration_of(F, L, forces=("F_x", "F_z"), coils=("C1", "C2"), free=("H", [2.1e-6, 2.1e-6]))


def triple(turned: float, *, forces: tuple[str, ...] = ("F_x", "F_z", "F_y")) -> tuple[Calibration, xr.Dataset]:
    """Three coils around the centre, turned by an angle: each answers the shear towards it, and all F_z alike.

    F_x and F_y reach 0.5 N both ways, F_z 2 N; what else is named moves no coil. Each load's error is 5 pH per coil.
    """
    angle = turned + 2.0 * np.pi / 3.0 * np.arange(3)
    slopes = {"F_x": SHEAR * np.cos(angle), "F_z": np.full(3, PRESS), "F_y": SHEAR * np.sin(angle)}
    ends = {"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0), "F_y": (-0.5, 0.5), "M": (-1e-3, 1e-3)}
    axes = {name: np.linspace(*ends[name], 5) for name in forces}
    loads = np.stack(np.meshgrid(*axes.values(), indexing="ij"), -1)
    L = 2e-6 + loads @ np.array([slopes.get(name, np.zeros(3)) for name in forces])
    coils = ("C1", "C2", "C3")
    coords, dims = axes | {"coil": list(coils)}, (*forces, "coil")
    table = xr.Dataset({"L": (dims, L), "error_L": (dims, np.full(L.shape, 5e-12))}, coords)
    places = 4e-3 * np.column_stack([np.cos(angle), np.sin(angle)])
    table["weights"] = (("signal", "coil"), weights_of(places, 3e-3))
    flat = loads.reshape(-1, len(forces)), L.reshape(-1, 3)
    return calibration_of(*flat, forces=forces, coils=coils, free=("H", np.full(3, 2.1e-6))), table


def test_a_linear_sensor_by_hand() -> None:
    """No crosstalk, no bend; slopes; resolution = noise / (sqrt(2) slope) by sum and difference."""
    found = quality(made(), [1e-12, 1e-12])
    np.testing.assert_allclose(found.full_scale, [[-1, 1], [0, 4]])
    np.testing.assert_allclose(found.sensitivity, A / 2.1e-6, rtol=1e-9)
    np.testing.assert_allclose(found.signal_range, (2 * 2e-8 + 4 * 3e-9) / 2.1e-6, rtol=1e-9)
    assert np.all(found.linearity < 1e-9) and np.all(found.crosstalk < 1e-9)
    expected = 1e-12 / np.sqrt(2.0) / np.array([2e-8, 3e-9])
    np.testing.assert_allclose(found.resolution, np.repeat(expected[:, None], 3, axis=1), rtol=1e-6)
    condition = (2.0 * 2e-8) / (4.0 * 3e-9)  # columns of A over full scale are at right angles
    assert found.condition == pytest.approx((condition, condition), rel=1e-6)
    assert found.valid_share == 1.0 and found.no_inverse == () and np.all(np.isnan(found.hysteresis))
    assert np.all(np.isnan(found.by_model)) and np.all(np.isnan(found.crosstalk_after))  # no table, no errors


def test_coils_that_no_asked_force_tells_apart_give_no_signal() -> None:
    """Two of three coils are images under F_x and F_z: that they differ by 0.1 pH is no readout of F_x squared."""
    _, table = triple(0.0, forces=("F_x", "F_z"))
    x = table["F_x"].to_numpy()[:, None, None]
    bent = table["L"].to_numpy() + 4e-9 * x**2 + 1e-13 * x**2 * np.array([0.0, 1.0, -1.0])
    table["L"] = (table["L"].dims, bent)
    loads = np.stack(np.meshgrid(table["F_x"], table["F_z"], indexing="ij"), -1).reshape(-1, 2)
    cal = calibration_of(
        loads, bent.reshape(-1, 3), forces=("F_x", "F_z"), coils=("C1", "C2", "C3"), free=("H", np.full(3, 2.1e-6))
    )
    assert np.all(quality(cal, np.full(3, NOISE), table=table).crosstalk_error < 0.01)


@pytest.mark.parametrize("turned", [0.0, 0.3, np.pi / 2.0])
def test_three_coils_around_the_centre_by_hand(turned: float) -> None:
    """However they are turned: cosines and sines of three even angles are at right angles, of squares 3/2 and 3."""
    cal, table = triple(turned)
    found = quality(cal, np.full(3, NOISE), table=table)
    slopes = np.array([SHEAR * np.sqrt(1.5), abs(PRESS) * np.sqrt(3.0), SHEAR * np.sqrt(1.5)])
    np.testing.assert_allclose(found.resolution, np.repeat((NOISE / slopes)[:, None], 3, axis=1), rtol=1e-6)
    full = slopes * [1.0, 2.0, 1.0]
    assert found.condition == pytest.approx((full.max() / full.min(),) * 2, rel=1e-6)
    assert np.all(found.crosstalk < 1e-9) and np.all(found.crosstalk_after < 1e-9) and np.all(found.linearity < 1e-9)
    assert found.seen.resolved == ("F_x", "F_z", "F_y") and found.seen.unseen == () and found.valid_share == 1.0
    # the inverse of three such rows: F_z by a third of each coil, whatever the angle
    np.testing.assert_allclose(found.by_model[1], 5e-12 / abs(PRESS), rtol=1e-6)
    angle = turned + 2.0 * np.pi / 3.0 * np.arange(3)
    read = np.linalg.inv(np.column_stack([SHEAR * np.cos(angle), np.full(3, PRESS), SHEAR * np.sin(angle)]))
    np.testing.assert_allclose(found.by_model[:, 0], 5e-12 * np.abs(read).sum(axis=1), rtol=1e-6)
    np.testing.assert_allclose(found.crosstalk_error, 2.0 * found.by_model[:, 2] / [1.0, 2.0, 1.0], rtol=1e-6)
    np.testing.assert_allclose(found.error_range, 2.0 * 5e-12 / 2.1e-6)
    np.testing.assert_allclose(found.error_sensitivity[:, 0], 5e-12 / 0.25 / 2.1e-6)  # a difference over two steps


def refitted(cal: Calibration, table: xr.Dataset) -> Calibration:
    """The calibration of a table that is another one by now."""
    points = np.stack(np.meshgrid(*(table[name] for name in cal.forces), indexing="ij"), -1).reshape(-1, 3)
    L = table["L"].transpose(*cal.forces, "coil").to_numpy().reshape(-1, 3)
    return calibration_of(points, L, forces=cal.forces, coils=cal.coils, free=("H", cal.L0))


def test_a_bend_along_one_force_of_three() -> None:
    """One coil bends with F_z, dL_v by a third of it; the inverse has none of it, a linear readout has."""
    cal, table = triple(0.0)
    table = table.assign(L=table["L"] - 3e-10 * table["F_z"] ** 2 * (table["coil"] == "C1"))
    found = quality(refitted(cal, table), np.full(3, NOISE), table=table)
    chord, span = 1e-10 * 4.0 / 8.0, 2.0 * abs(PRESS) + 4.0 * 1e-10
    assert chord / span <= found.linearity[1] <= 1.4 * chord / span  # by squares up to 4/3 of it
    np.testing.assert_allclose(found.linearity[[0, 2]], 0.0, atol=1e-9)
    assert found.crosstalk_after.max() < 1e-9 < found.crosstalk[1, 1]


def test_linearity_is_of_the_force_s_own_signal() -> None:
    """What bends all coils alike with F_x is not in dL_x, but in sums that leave out a coil that F_z moves more."""
    cal, table = triple(0.0)
    table = table.assign(L=table["L"] + PRESS * table["F_z"] * (table["coil"] == "C1") - 1e-9 * table["F_x"] ** 2)
    own = quality(refitted(cal, table), np.full(3, NOISE), table=table)
    without = quality(refitted(cal, table), np.full(3, NOISE), table=table.assign(weights=0.0 * table["weights"]))
    assert own.linearity[0] < 1e-9 and without.linearity[0] > 1e-3


def test_a_load_that_the_map_does_not_hold_is_crosstalk_after_the_inverse() -> None:
    """One of the loads was solved 0.1 N too high: 5 % of the full scale of F_z, whatever force leads there."""
    cal, table = triple(0.3)
    off = table["L"].copy()
    off[dict(F_x=4, F_z=2, F_y=2)] += 0.1 * PRESS
    found = quality(cal, np.full(3, NOISE), table=table.assign(L=off))
    np.testing.assert_allclose(found.crosstalk_after, [[0.0] * 3, [0.05] * 3, [0.0] * 3], atol=1e-9)


def test_a_force_that_no_coil_answers_is_named() -> None:
    """A moment that moves nothing: the others are resolved as before, there is no inverse, nothing fails."""
    cal, table = triple(0.0, forces=("F_x", "F_z", "M"))
    found = quality(cal, np.full(3, NOISE), table=table)
    assert found.seen.resolved == ("F_x", "F_z") and found.seen.unseen == ("M",)
    assert found.condition[1] > 1e6 and found.valid_share == 0.0
    np.testing.assert_allclose(found.resolution[0], NOISE / (SHEAR * np.sqrt(1.5)), rtol=1e-6)
    assert np.all(np.isinf(found.resolution[2])) and np.isnan(found.linearity[2])
    assert np.all(np.isnan(found.crosstalk[2])) and np.all(np.isnan(found.by_model))
    assert cal.no_inverse == ("M: errors of map and table are twice the range",)


def test_a_force_that_coils_answer_by_rounding_alone_is_named() -> None:
    """A moment that moves the coils by a tenth of their noise has slopes, yet no inverse: it is named."""
    cal, table = triple(0.0, forces=("F_x", "F_z", "M"))
    moved = table["L"] + 1e-10 * table["M"] * xr.DataArray([1.0, -1.0, 0.5], dims="coil")
    loads = np.stack(np.meshgrid(*(table[name] for name in cal.forces), indexing="ij"), -1).reshape(-1, 3)
    L = moved.transpose(*cal.forces, "coil").to_numpy().reshape(-1, 3)
    cal = calibration_of(loads, L, forces=cal.forces, coils=cal.coils, free=("H", cal.L0))
    cal = replace(cal, model_error=np.full(3, 5e-12))
    assert cal.domain.share > 0.0 and cal.share == 0.0
    found = quality(cal, np.full(3, NOISE), table=table.assign(L=moved), branches=(L[:1], L[:1]))
    assert found.seen.resolved == ("F_x", "F_z") and found.valid_share == 0.0
    assert found.no_inverse == ("M: errors of map and table are twice the range",)
    assert np.all(np.isnan(found.by_model)) and np.all(np.isnan(found.hysteresis))


def test_more_forces_than_coils_are_told_apart_as_far_as_they_go() -> None:
    """Three coils, four forces of which one moves nothing: condition infinite, the three others resolved."""
    cal, table = triple(0.0, forces=("F_x", "F_z", "M", "F_y"))
    found = quality(cal, np.full(3, NOISE), table=table, branches=(np.full((1, 3), 2e-6),) * 2)
    assert found.seen.resolved == ("F_x", "F_z", "F_y") and found.condition == (np.inf, np.inf)
    assert np.all(np.isnan(found.hysteresis)) and np.all(np.isnan(found.by_map))


def test_resolution_by_drawing() -> None:
    """The scatter of inverted noisy readings is what is reported."""
    cal = made(2e-10)
    F = np.tile([0.3, 2.0], (4000, 1))
    noisy = cal.forward(F) + 1e-11 * np.random.default_rng(1).standard_normal((4000, 2))
    reported = cal.force_noise([0.3, 2.0], [1e-11, 1e-11])
    np.testing.assert_allclose(cal.inverse(noisy).forces.std(axis=0), reported, rtol=0.05)


def test_errors_of_each_load_by_itself() -> None:
    """An error that differs from load to load is worth what it is worth alone."""
    cal = made(2e-10)
    F, wrong = np.array([[0.3, 2.0], [-0.5, 1.0]]), np.array([[1e-11, 2e-11], [3e-11, 1e-11]])
    both = cal.force_error(F, wrong)
    for k in range(2):
        np.testing.assert_allclose(both[k], cal.force_error(F[k], wrong[k]), rtol=1e-12)


def test_a_bend_and_its_crosstalk() -> None:
    """A parabola over 0..4 N lies an eighth of 16 b from its line; a linear readout misreads F_z, not F_x."""
    b = 2e-10
    found = quality(made(b), [1e-12, 1e-12])
    chord, least_squares = 16.0 * b / 8.0, 16.0 * b / 6.0  # best in the largest distance; by squares, at an end
    span = 4 * 3e-9 + 16 * b
    assert chord / span <= found.linearity[1] <= 1.01 * least_squares / span
    assert found.linearity[0] < 1e-9 and found.crosstalk[0, 1] < 1e-9 < found.crosstalk[1, 1]


def test_hysteresis_of_two_branches() -> None:
    """Unloading shows the inductances of 0.1 N more: 2.5 % of the full scale of F_z."""
    cal = made()
    F = np.array([[0.0, 1.0], [0.5, 2.0], [-0.5, 3.0]])
    branches = (cal.forward(F), cal.forward(F + [0.0, 0.1], beyond=True))
    found = quality(cal, [1e-12, 1e-12], branches=branches)
    np.testing.assert_allclose(found.hysteresis, [0.0, 0.025], atol=1e-9)


def test_what_has_no_figures_is_refused() -> None:
    """Noise of another shape, or none."""
    for noise in ([1e-12], [1e-12, 0.0]):
        with pytest.raises(ValueError, match=r"noise: must be 2 positive numbers \[H\]"):
            quality(made(), noise)


def test_errors_that_coils_have_in_common_are_no_shear() -> None:
    """The sum of three coils reads F_z alone: an error of all coils alike is one of F_z, and none of F_x and F_y."""
    cal, table = triple(0.3)
    plain = quality(cal, np.full(3, NOISE), table=table)
    alike = table.assign(alone_L=table["error_L"].expand_dims("cause"))
    found = quality(cal, np.full(3, NOISE), table=alike)
    np.testing.assert_allclose(found.by_model[1], plain.by_model[1], rtol=1e-6)
    np.testing.assert_allclose(found.by_model[1], 5e-12 / abs(PRESS), rtol=1e-6)
    assert np.all(found.by_model[[0, 2]] < 1e-6 * plain.by_model[[0, 2]])


def test_errors_that_loads_have_in_common_leave_ranges() -> None:
    """An offset is no error of a range or a slope, though one of each load."""
    cal, table = triple(0.0)
    offset = quality(cal, np.full(3, NOISE), table=table.assign(shared_L=table["error_L"].expand_dims("part")))
    np.testing.assert_allclose(offset.by_model[1], 5e-12 / abs(PRESS), rtol=1e-6)
    assert np.all(offset.error_range < 1e-15) and np.all(offset.crosstalk_error < 1e-12)
    assert np.all(offset.error_sensitivity < 1e-12)
