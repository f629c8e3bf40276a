"""What forces are read wrong by for a touch elsewhere, of coils known in closed form."""

import numpy as np
import pytest

from sits_mech.quantities import tensor_grid
from sits_mech.readout.calibration import calibration_of
from sits_mech.readout.misplaced import misplaced

F, X = np.linspace(1.0, 3.0, 7), np.linspace(-2e-3, 2e-3, 9)


def calibrated(*coils, axes=(F, X), forces=("F_z", "touch_x")):
    """Coils as functions of force and place."""
    points = tensor_grid(*axes).reshape(-1, len(axes))
    L = 2e-6 + 1e-9 * np.stack([coil(*points.T) for coil in coils], -1)
    names = [f"C{k}" for k in range(len(coils))]
    return calibration_of(points, L, forces=forces, coils=names, free=("H", np.full(len(coils), 2e-6)))


def test_one_coil_beside_the_touch_reads_the_force_by_its_lever():
    """L = -F (1 + x/a) is read as F (1 + x/a): d/a of the largest force."""
    cal = calibrated(lambda f, x: -10.0 * f * (1.0 + x / 20e-3))
    assert misplaced(cal, {"touch_x": 0.0}, 1e-3) == pytest.approx({"F_z": 3.0 / 20.0}, rel=1e-3)
    assert misplaced(cal, {"touch_x": 1e-3}, 1e-3) == pytest.approx({"F_z": 3.0 / 21.0}, rel=1e-3)


def test_two_mirrored_coils_read_it_rightly():
    """What is odd in the place cancels in the sum of weights alike."""
    cal = calibrated(*(lambda f, x, s=s: -10.0 * f * (1.0 + s * x / 20e-3) for s in (-1.0, 1.0)))
    assert misplaced(cal, {"touch_x": 0.0}, 2e-3)["F_z"] < 1e-6


def test_both_axes_of_a_place_add():
    axes = (F, X[::2], X[::2])
    names = ("F_z", "touch_x", "touch_y")
    cal = calibrated(lambda f, x, y: -10.0 * f * (1.0 + (x + y) / 20e-3), axes=axes, forces=names)
    assert misplaced(cal, {"touch_x": 0.0, "touch_y": 0.0}, 1e-3) == pytest.approx({"F_z": 0.3}, rel=1e-3)


@pytest.mark.parametrize(("forces", "within", "words"), [
    (("F_z", "F_x"), 1e-3, "within: must be asked of a table over places"),
    (("F_z", "touch_x"), 2.5e-3, "within: must be above 0 and up to 0.002 m, as touch_x goes from -0.002 to 0.002 m"),
    (("F_z", "touch_x"), 0.0, "within: must be above 0"),
])
def test_distances_and_tables_that_do_not_fit_are_refused(forces, within, words):
    cal = calibrated(lambda f, x: -10.0 * f * (1.0 + x / 20e-3), forces=forces)
    with pytest.raises(ValueError, match=words):
        misplaced(cal, {"touch_x": 0.0}, within)
