"""Kriging with slopes against what it must meet: constants, what is known, smooth functions."""

import numpy as np
import pytest

from sits_mech.synthesis.prediction import Kriging


@pytest.mark.parametrize(
    "points",
    [
        [[0.5, 0.5]], [[0.5, 0.5], [0.2, 0.9]], [[0.1, 0.1], [0.5, 0.5], [0.9, 0.9]],
        [[0.1, 0.2], [0.5, 0.9], [0.8, 0.3]],
    ],
)
@pytest.mark.parametrize("slopes", [False, True])
def test_what_is_the_same_at_all_points_is_so_everywhere(points: list[list[float]], slopes: bool) -> None:
    """Values alone of one point, of two, or of some in a line do not tell slopes: none are made up."""
    kriging = Kriging(np.array(points), slopes)
    for x in ([0.5, 0.5], [0.0, 1.0], [1.0, 0.3]):
        assert kriging.weights(np.array(x))[0].sum() == pytest.approx(1.0, abs=1e-6)


def test_what_is_known_is_met_and_smooth_functions_are_foretold() -> None:
    """Values with slopes at five points: there to 1e-5, between to 2 % of the range; one point is its tangent."""
    points = np.array([[0.2, 0.2], [0.8, 0.2], [0.2, 0.8], [0.8, 0.8], [0.5, 0.5]])
    y = np.exp(points[:, 0]) * (1.0 + points[:, 1] ** 2)
    by = np.column_stack([y, 2.0 * points[:, 1] * np.exp(points[:, 0])])
    kriging = Kriging(points, True)

    def foretold(x: np.ndarray) -> float:
        """Return what is foretold of a point."""
        values, slopes = kriging.weights(x)
        return float(values @ y + np.sum(slopes * by))

    for x, known in zip(points, y, strict=True):
        assert foretold(x) == pytest.approx(known, rel=1e-5)
    for x in np.random.default_rng(1).random((20, 2)):
        assert foretold(x) == pytest.approx(np.exp(x[0]) * (1.0 + x[1] ** 2), abs=0.02 * np.ptp(y))
    values, slopes = Kriging(points[:1], True).weights(np.array([0.3, 0.4]))
    assert values[0] * y[0] + slopes[0] @ by[0] == pytest.approx(y[0] + by[0] @ [0.1, 0.2])
