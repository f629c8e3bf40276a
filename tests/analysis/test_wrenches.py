"""Slopes by the components of a load, with models by hand and with the scene turned."""

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis import wrenches
from sits_mech.analysis.wrenches import COMPONENTS, components_resolved, turned, wrench_slopes
from sits_mech.quantities import Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.report.tables import quality as quality_table
from sits_mech.sensor import Coil, Sensor, load_sensor

REPORT = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def four() -> Sensor:
    """A coil on each side of the target, which is longer than wide."""
    sensor = load_sensor("biorob2018-w15")
    coil = sensor.coils[0]
    places = {"left": (-4e-3, 0.0), "right": (4e-3, 0.0), "front": (0.0, -6e-3), "back": (0.0, 6e-3)}
    coils = tuple(coil.model_copy(update={"name": name, "centre": at}) for name, at in places.items())
    return sensor.model_copy(update={"coils": coils})


@dataclass(frozen=True)
class Spring:
    """Compliance 1e-4 m/N along x, 2e-5 m/N down, 0.5 rad/(N m), all over the target's width in cm."""

    width: float

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the closed form."""
        c = 0.01 / self.width
        pose = Pose(1e-4 * c * wrench.F_x, 2e-3 - 2e-5 * c * wrench.F_z, 0.5 * c * wrench.M)
        return Equilibrium(wrench, pose, Pose(0.0, 0.0, 0.0), np.zeros(3), REPORT)


@dataclass(frozen=True)
class Near:
    """A coil at x sees the sum 1 + 50 d_v - 1e4 x d_h + x alpha."""

    coils: tuple[Coil, ...]

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        x = np.array([coil.centre[0] for coil in self.coils])
        d_h, d_v, alpha = (np.asarray(part)[..., None] for part in (pose.d_h, pose.d_v, pose.alpha))
        own = 1.0 + 50.0 * d_v - 1e4 * x * d_h + x * alpha
        L, one = own[..., None] * np.eye(len(x)), np.eye(len(x))
        return Impedance(frequency, L, 0 * L, 2.0 * one, np.zeros(len(x)), 0 * L, 0 * L, "H", REPORT)


def test_slopes_by_hand(four: Sensor) -> None:
    """dL/dF of each coil over 2 H; F_y and M_x with the width and the places of the turned scene."""
    found = wrench_slopes(four, lambda s: Spring(s.target.extent[0]), lambda s: Near(s.coils))
    x, y = (np.array([coil.centre[k] for coil in four.coils]) for k in (0, 1))
    c, turned_c = 0.01 / 15e-3, 0.01 / 8e-3
    expected = [-1e4 * x * 1e-4 * c, 0.0 * x - 50.0 * 2e-5 * c, x * 0.5 * c]
    expected += [-1e4 * y * 1e-4 * turned_c, y * 0.5 * turned_c]
    assert found.shape == (4, len(COMPONENTS))
    np.testing.assert_allclose(found, np.array(expected).T / 2.0, rtol=1e-6, atol=1e-12)


def test_four_turns_are_none(four: Sensor) -> None:
    """Turned four times the scene is itself; what cannot be turned is refused."""
    again = turned(turned(turned(turned(four))))
    np.testing.assert_allclose([c.centre for c in again.coils], [c.centre for c in four.coils], atol=1e-18)
    assert again.target == four.target and turned(four).target.width == four.target.length
    with pytest.raises(ValueError, match="must have a rectangle or disc on an elastomer"):
        turned(four.model_copy(update={"elastomer": None}))


def test_what_four_coils_tell(four: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """Coils that answer shear and moment alike, by x or y: full moments move them 1/130 as much, and stay unseen."""
    monkeypatch.setattr(wrenches, "mechanical_model", lambda scene, *_: (Spring(scene.target.extent[0]), None))
    monkeypatch.setattr(wrenches, "magnetic_model", lambda scene, *_: (Near(scene.coils), None))
    forces = {"F_x": [-1.0, 1.0], "F_z": [0.0, 4.0]}
    data = xr.Dataset(coords=forces, attrs={"request": '{"mechanics": "block", "tolerance": 0.01}'})
    found = components_resolved(four, data, np.full(4, 1e-12))
    assert found.resolved == ("F_x", "F_z", "F_y") and np.all(found.signal[3:] == pytest.approx(0.0, abs=1e-3))
    assert sorted(found.hidden) == ["M_x", "M_y"]
    seen, hidden = (row for row in quality_table._component_rows(quality_table.components_record(found)))
    assert seen[1].startswith("at rest, by the field in space: F_x to ") and hidden[1].endswith("; M_z")
    with pytest.raises(ValueError, match="table: must reach beyond zero in F_x and F_z; got 0 and 4 N"):
        components_resolved(four, data.isel(F_x=[0]).assign_coords(F_x=[0.0]), np.full(4, 1e-12))
