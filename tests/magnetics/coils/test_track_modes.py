"""One division for many frequencies: equal to the direct solution, direct current below, skin depth above."""

import numpy as np
import pytest
from common.track_losses import coil_losses

from sits_mech.magnetics.coils.alone import track_resistance
from sits_mech.magnetics.coils.track_modes import track_spectrum
from sits_mech.scene.sensor import Coil

COIL = Coil(
    name="C", centre=(0.0, 0.0), layers=1, turns=4, inner_diameter=2.2e-3, track_width=0.1e-3, track_gap=0.1e-3,
    track_thickness=35e-6, layer_pitch=85e-6,
)  # fmt: skip


def test_equals_the_direct_solution() -> None:
    """At the frequency the division is made for, to rounding; at a lower one within both errors."""
    found, high, low = track_spectrum(COIL, [1e6, 5e6]), coil_losses(COIL, 5e6), coil_losses(COIL, 1e6)
    assert found.R[1] == pytest.approx(high.R, rel=1e-10)
    assert abs(found.R[0] - low.R) < found.error_R[0] + low.error_R


def test_limits() -> None:
    """Direct current: R of uniform current within that of rings (J as 1/r), no shift; both vary as f^2 from there."""
    found = track_spectrum(COIL, [1.0, 1e4, 2e4, 1e7])
    assert found.R[0] == pytest.approx(track_resistance(COIL), rel=1e-3)
    assert abs(found.shift[0]) < 1e-15
    assert (found.R[2] - found.R[0]) / (found.R[1] - found.R[0]) == pytest.approx(4.0, rel=1e-2)
    assert found.shift[2] / found.shift[1] == pytest.approx(4.0, rel=1e-2)
    inner = coil_losses(COIL, 1e7).L - coil_losses(COIL, 1.0).L
    assert found.shift[3] == pytest.approx(inner, rel=3e-2)


@pytest.mark.parametrize("wrong", [[], [0.0], [np.inf], [1e12]])
def test_refused(wrong: list[float]) -> None:
    """One line each."""
    with pytest.raises(ValueError, match="frequency: "):
        track_spectrum(COIL, wrong)
