"""Slopes by the six components of a load, with models by hand and with the pad and the field in space."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis import wrenches
from sits_mech.analysis.wrenches import resolved_components, wrench_slopes
from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.quantities import WRENCH, Array, Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.report.tables.quality import components_record
from sits_mech.scene.sensor import Coil, Sensor, load_sensor

REPORT = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
DATA = xr.Dataset(coords={"F_x": [-1.0, 1.0], "F_z": [0.0, 4.0]}, attrs={"request": '{"tolerance": 0.01}'})


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
    """Compliances 1e-4 m/N along x and y, 2e-5 m/N down, and about x, y and z; under shear it sinks by squares."""

    turns: tuple[float, float, float] = (10.0, 5.0, 20.0)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the closed form."""
        turned = np.array([wrench.M_x, wrench.M, wrench.M_z]) * self.turns
        d_v = 2e-3 - 2e-5 * wrench.F_z - 1e-3 * (wrench.F_x**2 + wrench.F_y**2)
        pose = Pose(1e-4 * wrench.F_x, d_v, turned[1], 1e-4 * wrench.F_y, turned[0], turned[2])
        return Equilibrium(wrench, pose, Pose(0.0, 0.0, 0.0), np.zeros(3), REPORT)


@dataclass(frozen=True)
class Near:
    """A coil at (x, y) sees 1 + 50 d_v - 1e4 (x d_h + y d_y) + x alpha - y alpha_x + 1e3 x y alpha_z."""

    coils: tuple[Coil, ...]

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        x, y = np.array([coil.centre for coil in self.coils]).T
        d_h, d_v, alpha, d_y, alpha_x, alpha_z = np.moveaxis(pose.components, -1, 0)[..., None]
        own = 1.0 + 50.0 * d_v - 1e4 * (x * d_h + y * d_y) + x * alpha - y * alpha_x + 1e3 * x * y * alpha_z
        L, one = own[..., None] * np.eye(len(x)), np.eye(len(x))
        return Impedance(frequency, L, 0 * L, 2.0 * one, np.zeros(len(x)), 0 * L, 0 * L, "H", REPORT)


def in_space(pad: str, *overrides: str) -> Array:
    """Slopes by the field in space, moments as of a force 4 mm off, over the largest."""
    sensor = load_sensor("biorob2018", overrides)
    layer = Spring() if pad == "spring" else mechanical_model(sensor, pad, 5e-2)[0]
    found = wrench_slopes(sensor, layer, magnetic_model(sensor, "sheets", 5e-2)[0])
    found = found * np.where([name.startswith("F") for name in WRENCH], 1.0, 4e-3)
    return found / np.abs(found).max()


def test_slopes_by_hand(four: Sensor) -> None:
    """dL/dF of each coil over 2 H; what goes with the square of a load is not in the slope."""
    corner = four.coils[0].model_copy(update={"centre": (3e-3, 2e-3)})
    sensor = four.model_copy(update={"coils": (*four.coils, corner)})
    found = wrench_slopes(sensor, Spring(), Near(sensor.coils))
    x, y = np.array([coil.centre for coil in sensor.coils]).T
    expected = [-x, 0.0 * x - 50.0 * 2e-5, 5.0 * x, -y, -10.0 * y, 2e4 * x * y]
    assert found.shape == (5, len(WRENCH))
    np.testing.assert_allclose(found, np.array(expected).T / 2.0, rtol=1e-6, atol=1e-12)


@pytest.mark.slow
@pytest.mark.slow
@pytest.mark.parametrize("pad", ["spring", "block"])
def test_mirror_symmetry_hides_what_leaves_the_plane(pad: str) -> None:
    """Pad, target and two coils on x are their own image in y = 0: F_y, M_x and M_z turn their sign there, L does not.

    In x = 0 the coils change places: F_z moves both alike, F_x and M against each other.
    """
    found = in_space(pad)
    np.testing.assert_allclose(found[:, 3:], 0.0, atol=1e-6)
    np.testing.assert_allclose(found[1], found[0] * [-1.0, 1.0, -1.0, 1.0, 1.0, 1.0], atol=1e-6)
    assert np.abs(found[0, :3]).min() > 1e-3


@pytest.mark.parametrize("pad", ["spring", pytest.param("block", marks=pytest.mark.slow)])
def test_coils_off_the_axis_see_a_twist(pad: str) -> None:
    """Two coils opposite each other by the middle: half a turn changes their places, so M_z moves both alike."""
    found = in_space(pad, 'coils.C1.centre=["-4 mm", "3 mm"]', 'coils.C2.centre=["4 mm", "-3 mm"]')
    np.testing.assert_allclose(found[1], found[0] * [-1.0, 1.0, -1.0, -1.0, -1.0, 1.0], atol=1e-6)
    assert abs(found[0, 5]) > 0.01


def test_what_four_coils_resolve(four: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """Coils that answer shear and moment alike, by x or y: full moments move them 1/80 as much, and stay unseen."""
    monkeypatch.setattr(wrenches, "mechanical_model", lambda *_: (Spring((1e-3, 1e-3, 1e-3)), None))
    monkeypatch.setattr(wrenches, "magnetic_model", lambda scene, *_: (Near(scene.coils), None))
    found = resolved_components(four, DATA, np.full(4, 1e-12))
    assert found.resolved == ("F_x", "F_z", "F_y") and np.all(found.signal[3:] == pytest.approx(0.0, abs=1e-3))
    assert sorted(found.unseen) == ["M", "M_x", "M_z"]
    record = components_record(found)
    assert json.loads(json.dumps(record))["resolved"] == ["F_x", "F_z", "F_y"] and record["alone"]["M_z"] < 1.0
    normal = DATA.isel(F_x=[0]).assign_coords(F_x=[0.0])
    alone = resolved_components(four, normal, np.full(4, 1e-12)).alone
    np.testing.assert_allclose(alone[[0, 3]], 4.0 * found.alone[[0, 3]], rtol=1e-9)  # shear as large as F_z
    with pytest.raises(ValueError, match="table: must reach beyond zero in a force; got none"):
        resolved_components(four, normal.isel(F_z=[0]), np.full(4, 1e-12))
