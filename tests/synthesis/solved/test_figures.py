"""Figures of tables against closed forms: linear sensors, gains and offsets that are off, loads that look alike."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from sits_mech.synthesis.required.kinds import INVERSE
from sits_mech.synthesis.solved.figures import Judge, Table
from sits_mech.synthesis.solved.loads import Operator, loads_between

ENDS = {"F_x": (-1.0, 1.0), "F_z": (0.0, 4.0)}
MATRIX = np.array([[2.0, -1.0], [-2.0, -1.0], [0.5, -0.5]])  # n x d [H/N]
NOISE = np.array([0.1, 0.2, 0.4])


def grid(operator: Operator) -> np.ndarray:
    """Return the loads of an operator's grid, (g, d)."""
    return np.stack(np.meshgrid(*operator.loads.axes, indexing="ij"), -1).reshape(-1, len(operator.loads.axes))


def judge(deviations=(), limits=None) -> Judge:
    """Return a judge of two components."""
    return Judge(Operator(loads_between(ENDS)), np.array(deviations, dtype=float), limits or {}, 0.95)


def table(own: Judge, *by_tolerance: np.ndarray) -> Table:
    """Return the table of a linear sensor."""
    L = 10.0 + grid(own.operator) @ MATRIX.T
    return Table(L, np.array(by_tolerance).reshape(-1, *L.shape), NOISE)


def test_polynomials_and_their_slopes_are_exact() -> None:
    """Up to their degree, along each component, at any load."""
    operator = Operator(loads_between(ENDS))
    x, z = grid(operator).T
    points = np.array([[0.3, 1.7], [-0.9, 3.9]])
    values = x**3 * z**2 - z
    exact = points[:, 0] ** 3 * points[:, 1] ** 2 - points[:, 1]
    np.testing.assert_allclose(operator.values(points) @ values, exact, rtol=1e-12)
    by_x, by_z = operator.derivatives(points) @ values
    np.testing.assert_allclose(by_x, 3 * points[:, 0] ** 2 * points[:, 1] ** 2, rtol=1e-11)
    np.testing.assert_allclose(by_z, 2 * points[:, 0] ** 3 * points[:, 1] - 1.0, rtol=1e-11)


def test_loads_to_both_sides_are_images_to_the_last_digit() -> None:
    """Five from -5 N to 5 N: three are solved where the pad is symmetric."""
    axis = loads_between({"F_x": (-5.0, 5.0), "F_z": (0.0, 15.0)}).axes[0]
    assert len(set(np.abs(axis))) == 3 and len(axis) == 5


def test_resolution_of_a_linear_sensor_is_that_of_least_squares() -> None:
    """At every load the same: the covariance of a weighted fit; no crosstalk, one load for each reading."""
    own = judge()
    found = own.figures(table(own))
    covariance = np.linalg.inv(MATRIX.T @ np.diag(NOISE**-2) @ MATRIX)
    sigma = [found["resolution.F_x"], found["resolution.F_z"]]
    np.testing.assert_allclose(sigma, np.sqrt(np.diag(covariance)), rtol=1e-9)
    assert found["crosstalk_before_inverse"] < 1e-9 and found[INVERSE] == pytest.approx(1.0, rel=1e-9)
    assert found["error.F_x"] == found["error.F_z"] == 0.0


def test_an_offset_is_tared_and_a_gain_is_scaled_away() -> None:
    """Neither costs anything; a gain of one component alone is none of the other's business."""
    own = judge((0.1, 0.2))
    loads = grid(own.operator)
    offset, gain = np.ones((len(loads), 3)), (loads * (0.0, 1.0)) @ MATRIX.T
    found = own.figures(table(own, offset, gain))
    assert found["error.F_x"] < 1e-9 and found["error.F_z"] < 1e-9


def test_a_turned_sensor_misreads_by_the_sine() -> None:
    """F_z reads as F_x by the tolerance's angle: its quantile times the largest F_z, over the range of F_x."""
    own = judge((0.05,))
    turned = grid(own.operator)[:, 1:] * MATRIX[:, 0]
    found = own.figures(table(own, turned))
    assert found["error.F_x"] == pytest.approx(norm.ppf(0.975) * 0.05 * 4.0 / 2.0, rel=0.03)
    assert found["error.F_z"] < 1e-9


def test_yield_is_the_share_of_a_normal_distribution() -> None:
    """Sensors within one standard deviation hold a limit that is what one of them misreads: 68.3 %."""
    own = judge((0.05,), {"error.F_x": 0.05 * 4.0 / 2.0})
    turned = grid(own.operator)[:, 1:] * MATRIX[:, 0]
    excess = own.excess(table(own, turned), 4096)
    assert np.mean(excess <= 0.0) == pytest.approx(0.6827, abs=2e-3)


def test_sensors_that_are_drawn_are_judged_one_by_one() -> None:
    """Each by its own deviation: it misreads by the sine, over the limit of a sensor that is off by 0.05."""
    own = judge((0.05,), {"error.F_x": 0.05 * 4.0 / 2.0})
    turned = grid(own.operator)[:, 1:] * MATRIX[:, 0]
    found = replace(own, drawn=np.array([[0.04], [-0.06]])).excess(table(own, turned))
    np.testing.assert_allclose(found, [-0.2, 0.2], rtol=0.03)


def test_loads_that_look_alike_have_no_inverse() -> None:
    """A signal that falls and rises again along F_z shows two loads the same."""
    own = judge()
    x, z = grid(own.operator).T
    folded = Table(np.column_stack([x, (z - 2.5) ** 2]), np.zeros((0, len(x), 2)), np.ones(2))
    assert own.figures(folded)[INVERSE] < 0.0


def test_crosstalk_of_a_bent_signal() -> None:
    """Inductances with a product of both loads: what a plane through them leaves grows with the product."""
    own = judge()
    x, z = grid(own.operator).T
    sizes = []
    for size in (0.01, 0.02):
        L = np.column_stack([x + size * x * z, z])
        sizes.append(own.figures(Table(L, np.zeros((0, *L.shape)), np.ones(2)))["crosstalk_before_inverse"])
    assert sizes[0] > 0.0 and sizes[1] / sizes[0] == pytest.approx(2.0, rel=0.05)


def test_the_drift_of_zero_is_what_readings_take_it_for() -> None:
    """Readings that change as under 10 mN/K of F_z, at no load; what grows with the load is none of zero."""
    own = judge()
    loads = grid(own.operator)
    slopes = np.array([0.0, 0.01]) @ MATRIX.T + 1e-3 * loads @ MATRIX.T
    assert own.drift(table(own), slopes) == {"drift.F_x": 0.0, "drift.F_z": pytest.approx(0.01, rel=1e-9)}


def test_sizes_that_scatter_need_a_guard() -> None:
    """A height of 1.5 mm at its limit: half of those made exceed it; 1.645 deviations below it 5 % do."""
    own = replace(judge((5e-5,)), limits={"height": 1.5e-3})
    for height, share in ((1.5e-3, 0.5), (1.5e-3 - 1.645 * 5e-5, 0.95)):
        one = table(own, np.zeros((len(grid(own.operator)), 3)))._replace(sizes={"height": (height, np.ones(1))})
        assert np.mean(own.excess(one, 4096) <= 0.0) == pytest.approx(share, abs=2e-3)


def test_parts_of_a_resolution_are_its_whole() -> None:
    """By the converter and by the rest, squared: that of both; each as of a fit with the weights of both."""
    own = judge()
    converter = 0.3 * NOISE
    for name, parts in own.resolution_parts(table(own), converter).items():
        assert np.hypot(*parts) == pytest.approx(own.figures(table(own))[name], rel=1e-9)
        assert parts[0] == pytest.approx(0.3 * np.hypot(*parts), rel=1e-9)


def test_the_yield_of_few_sensors_is_that_of_many() -> None:
    """Where sensors that are off to the other side are worst at another load than the design."""
    own = judge((0.25,), {"resolution.F_z": 0.0})
    z = grid(own.operator)[:, 1:]
    near = table(own, -0.2 * (z**2 - 4.0 * z) * (1.0, 1.0, 0.5))  # weaker at rest, or at 4 N where the sign is another
    near = near._replace(L=near.L - 1e-3 * z**2 * (1.0, 1.0, 0.0))  # the design at rest
    limit = 1.1 * own.figures(near)["resolution.F_z"]
    own = replace(own, limits={"resolution.F_z": limit})
    few, many = (float(np.mean(own.excesses(near, count)["resolution.F_z"] <= 0.0)) for count in (512, 4096))
    assert 0.2 < many < 0.8 and few == pytest.approx(many, abs=0.01)


@pytest.mark.parametrize("seed", range(6))
def test_readings_that_are_off_by_a_share_change_an_error_by_it_before_it_is_scaled(seed: int) -> None:
    """The share of the misreading that scaling takes away, not of the force: some tenth of the range, not all of it."""
    own, draw = judge((0.1,)), np.random.default_rng(seed)
    x, z = grid(own.operator).T
    softer = (grid(own.operator) * (1.0 + 0.05 * z)[:, None]) @ MATRIX.T
    first = table(own, softer)
    wrong = 0.03 * np.stack([x, z, x * z / 4.0, z**2 / 8.0], -1) @ draw.uniform(-1.0, 1.0, (4, 3))
    off = first._replace(L=first.L + wrong, by_tolerance=first.by_tolerance * (1.0 + 0.03 * draw.uniform(-1.0, 1.0)))
    reads = np.linalg.pinv(MATRIX / NOISE[:, None]) / NOISE
    share = np.ptp(wrong @ reads.T, axis=0) / own.operator.loads.span
    tared, before, after = own.tared_errors(first), own.figures(first), own.figures(off)
    for k, name in enumerate(("error.F_x", "error.F_z")):
        assert abs(after[name] - before[name]) <= (share[k] + 0.03) * tared.max(), name
    assert tared.max() < 0.3 and before["error.F_z"] < 0.5 * tared[1]
