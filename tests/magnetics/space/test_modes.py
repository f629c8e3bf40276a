"""The modes of a plate: single precision against double, both divisions on one set of fields."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.magnetics.sheets import _divided, sheets
from sits_mech.magnetics.space import modes
from sits_mech.magnetics.space.rungs import LADDER, prepared
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import load_sensor


@pytest.mark.slow
def test_single_precision_changes_less_than_promised(monkeypatch: pytest.MonkeyPatch) -> None:
    """At both ends of the decade that is prepared; promised below 1e-3."""
    poses = Pose(np.array([0.0, 1e-3]), np.array([2e-3, 2.5e-3]), np.array([0.0, 0.1]))
    found = []
    for large in (10**9, 10):
        prepared.cache_clear()
        _divided.cache_clear()
        monkeypatch.setattr(modes, "_LARGE", large)
        model = sheets(load_sensor("biorob2018"), 2e-2)
        found.append([model.impedance(poses, f) for f in (1.1e6, 1e7)])
    prepared.cache_clear()
    _divided.cache_clear()
    for double, single in zip(*found, strict=True):
        assert np.abs(single.L - double.L).max() < 1e-4 * np.abs(double.L - double.L0).max()
        assert np.abs(single.R - double.R).max() < 1e-3 * np.abs(double.R).max()
        assert np.abs(single.L - double.L).max() > 0.0


def test_divisions_share_their_fields() -> None:
    target = load_sensor("biorob2018").target
    assert target is not None
    fine, coarse = prepared(target, None, LADDER[0][1], (2.0**-9, 1e6, 12e-3, 2e-3))
    assert fine.bases == coarse.bases and fine.unknowns > 2 * coarse.unknowns
    assert [part.coupling.shape[0] for part in fine.classes] == [part.coupling.shape[0] for part in coarse.classes]
