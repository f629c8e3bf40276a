"""The table of extremes: its checks see what is wrong, and its quick rows hold."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sits_mech.chain import MAGNETICS
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import Pose, Wrench

sys.path.append(str(Path(__file__).parents[2] / "studies"))  # the studies are scripts beside the package

from extreme import layers, plates  # noqa: E402
from extreme.rows import DONE, Row, measured  # noqa: E402


def test_a_row_holds_only_if_converged_and_consistent_or_refused_by_name() -> None:
    good = Row("", "", DONE, 0.5, 1e-9, 1e-6)
    assert good.holds and replace(good, status="load path ended").holds
    assert not replace(good, violation=1e-3).holds
    assert not replace(good, min_J=-0.1).holds and not replace(good, violation=np.nan).holds
    assert not replace(good, status="load path ended", must=True).holds
    assert not measured("", "", lambda: 1 / 0).holds  # type: ignore[arg-type, return-value]


def test_work_that_is_not_the_stored_energy_is_seen() -> None:
    """Poses of which one is wrong by a hundredth, and a state that is another load's."""
    layer, peak = planar_layer(layers.pad(20, 15, 2), 2e-2), Wrench(50.0, 500.0)
    shares = np.linspace(0.0, 1.0, 5).tolist()
    path = [layer.equilibrium(layers.REST)]
    for share in shares[1:]:
        path.append(layer.equilibrium(layers.scaled(peak, share), start=path[-1]))
    assert layers.energy_row(layer, peak, shares, path).holds
    broken = replace(path[-1], state=path[-2].state)
    assert not layers.energy_row(layer, peak, shares, [*path[:-1], broken]).holds


def test_a_plate_that_is_not_passive_is_seen() -> None:
    sensor = plates.scene("planar", 8, 0.2, 5.8e7)
    before, z = (MAGNETICS["planar"](sensor, 1e-2).impedance(Pose(3e-4, 2e-3), f) for f in (1e4, 1e6))
    assert plates.worst(z, before, False) <= plates.ROUNDING
    lopsided = z.L + np.array([[0.0, 1e-6 * z.L[0, 0]], [0.0, 0.0]])
    for wrong in (replace(z, R=-z.R), replace(z, L=z.L0 * 1.001), replace(z, L=lopsided), replace(z, R=z.R * np.nan)):
        assert plates.worst(wrong, None, False) > plates.ROUNDING
    assert plates.worst(before, z, False) > plates.ROUNDING  # shrinks with frequency


@pytest.mark.parametrize("name", ["no load", "load to and fro", "moment identity, sheared by half"])
def test_quick_rows_hold(name: str) -> None:
    thin = planar_layer(layers.pad(20, 15, 2))
    row = {
        "no load": lambda: layers.nothing(thin, 2e-3),
        "load to and fro": lambda: layers.to_and_fro(thin, Wrench(100.0, 1000.0), 7.5e-3),
        "moment identity, sheared by half": lambda: layers.identity(layers.pad(15, 15, 3), Wrench(F_x=200.0)),
    }[name]()
    assert row.holds and row.status == DONE
