"""How much work is an inverse? Evaluations of its map are counted: seconds hang on what else a machine does."""

from collections.abc import Callable

import numpy as np
import pytest

from sits_mech.readout.calibration import Calibration
from sits_mech.readout.inversion import Inverse, InverseSearch

Counted = Callable[[Calibration, np.ndarray], tuple[Inverse, float]]


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counted:
    """Return what inverts readings and tells how often the map was evaluated for one of them, on average."""
    seen, counts = InverseSearch._seen, list[int]()

    def counting(self: InverseSearch, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        counts.append(x.shape[1])
        return seen(self, x)

    def inverted(cal: Calibration, L: np.ndarray) -> tuple[Inverse, float]:
        counts.clear()
        return cal.inverse(L), sum(counts) / len(L)

    monkeypatch.setattr(InverseSearch, "_seen", counting)
    return inverted
