"""A load that comes and goes: loops of the signals, closed for an elastic silicone, known for a linear sensor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.cycle import Programme, load_cycle, triangle
from sits_mech.chain.simulate import simulate
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor
from sits_mech.silicone.history import retardation

PEAK = Wrench(0.2, 1.0)


@pytest.fixture(autouse=True)
def alone(numerics_alone: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Loops by models in section: what the ends leave out is as large as a loop's range."""
    with numerics_alone():
        yield


def sensor(history: str = "") -> Sensor:
    """The published sensor on a neo-Hookean pad with a rate or a softening."""
    law = f'elastomer.material={{law="neo-hookean", shear_modulus="30 kPa", bulk_modulus="30 MPa"{history}}}'
    return load_sensor("biorob2018", [law])


def cycled(scene: Sensor, peak: Wrench, programme: Programme, points: int = 9) -> xr.Dataset:
    """Return the cycle in section, in a tenth of the time that it takes in space."""
    return load_cycle(scene, peak, programme, points=points, mechanics="planar", magnetics="planar")


@pytest.mark.slow
def test_an_elastic_silicone_shows_the_calibration_and_no_loop() -> None:
    """Both branches are the static answer, within what the spline says it costs."""
    data = load_cycle(sensor(), PEAK, triangle(1.0, 1, samples=8), points=9)
    assert max(data.attrs["loop_L_v_percent"] + data.attrs["loop_L_h_percent"]) < 1e-9
    row, static = data.isel(time=3), simulate(sensor(), Wrench(0.15, 0.75))
    assert float(row["share"]) == 0.75
    for name in ("L_v_percent", "L_h_percent"):
        assert abs(float(row[name]) - getattr(static.signals, name)) <= float(row[f"error_{name}"])
    assert float(row["d_h"]) == pytest.approx(float(static.equilibrium.pose.d_h), rel=1e-4)
    assert float(row["d_v"]) == pytest.approx(float(static.equilibrium.pose.d_v), rel=1e-6)


@pytest.mark.slow
def test_width_of_a_viscous_loop_of_a_nearly_linear_sensor() -> None:
    """One branch, small load, first triangle: the rise lags by ``w lambda/h (1 - exp(-t/lambda))``.

    The pose and the signal are linear in the elastic share to a percent there, so that the loop is that of the share.
    """
    scene, half = sensor(', prony=[{weight=0.3, time="2 s"}]'), 1.0
    (weight,), (lag,) = retardation([(0.3, 2.0)])
    data = cycled(scene, Wrench(0.01, 0.0), triangle(2.0 * half, 1, samples=400), points=5)
    time = np.linspace(0.0, half, 2001)
    rise = weight * lag / half * (1.0 - np.exp(-time / lag))  # behind the load while it grows
    fall = rise[-1] * np.exp(-time / lag) - rise  # and while it shrinks, in the order of time
    shown = time / half - rise
    back = (1.0 - time / half - fall)[::-1]
    span = max(shown.max(), back.max()) - min(shown.min(), back.min())
    assert data.attrs["loop_L_h_percent"] == [pytest.approx(100.0 * np.max(np.abs(back - shown)) / span, rel=0.01)]


@pytest.mark.slow
def test_softening_opens_the_first_loop_alone() -> None:
    """Later cycles to the same peak run along its unloading branch."""
    data = cycled(sensor(", mullins={r=2.5}"), PEAK, triangle(1.0, 3, samples=40))
    first, *later = data.attrs["loop_L_v_percent"]
    assert 5.0 < first < 50.0 and max(later) < 1e-6
    assert 0.0 < data.attrs["error_loop_L_v_percent"][0] < first


@pytest.mark.slow
def test_slow_cycles_have_no_viscous_loop_and_sudden_loads_find_a_stiffer_pad() -> None:
    """In a cycle a thousand times slower than the branch the sensor shows its static calibration."""
    scene = sensor(', prony=[{weight=0.3, time="1 ms"}]')
    slow = cycled(scene, PEAK, triangle(10.0, 1, samples=40))
    assert slow.attrs["loop_L_v_percent"][0] < 0.1
    sudden = cycled(scene, PEAK, Programme(np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 1.0])))
    np.testing.assert_allclose(sudden["elastic_share"], [0.0, 0.7, 1.0], rtol=1e-12)
    assert sudden.attrs["loop_L_v_percent"] == []


@pytest.mark.slow
def test_a_sudden_load_meets_the_static_layer_of_the_instantaneous_constants() -> None:
    """Model against model at finite strain: all stresses 1/(1 - w) times as large, so shear and bulk modulus, too.

    A bulk modulus that does not relax makes less: of the thin layer's 4 mu S^2 (1 - 0.4 y^2), y^2 = 12 mu S^2/K, the
    instantaneous stiffness then lacks ``0.4 y^2 w/(1 - w)``, 0.8 % here; S = 2, K = 1000 mu, w = 0.3.
    """
    scene = sensor(', prony=[{weight=0.3, time="5 s"}]')
    at_once, tolerance = Programme(np.array([0.0, 0.0]), np.array([0.0, 1.0])), 2e-2  # two meshes each
    sudden = load_cycle(scene, PEAK, at_once, points=9, tolerance=tolerance).isel(time=1)
    law = 'elastomer.material={law="neo-hookean", shear_modulus=42857.142857, bulk_modulus='
    scenes = (load_sensor("biorob2018", [f"{law}{K}}}"]) for K in (42857142.857, 30e6))
    both, shape = (simulate(scene, PEAK, tolerance=tolerance) for scene in scenes)
    pose = both.equilibrium.pose
    rest = 2e-3
    assert float(sudden["d_h"]) == pytest.approx(float(pose.d_h), rel=1e-4)
    assert rest - float(sudden["d_v"]) == pytest.approx(rest - float(pose.d_v), rel=1e-4)
    assert rest - float(shape.equilibrium.pose.d_v) == pytest.approx(rest - float(pose.d_v), rel=2e-2)


@pytest.mark.parametrize(
    ("time", "share", "message"),
    [
        ([0.0, 1.0], [0.0, 1.2], "share must lie between 0 and 1"),
        ([0.0, -1.0], [0.0, 1.0], "time must not run back; got -1 s after 0 s"),
        ([0.0], [0.0, 1.0], "must be n times with n x 6 loads"),
    ],
)
def test_programmes_that_are_none(time: list[float], share: list[float], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        load_cycle(sensor(), PEAK, Programme(np.array(time), np.array(share)))


def test_triangles_that_are_none() -> None:
    with pytest.raises(SceneError, match="period must be a positive time"):
        triangle(0.0)
    with pytest.raises(SceneError, match="cycles must be 1 or more"):
        triangle(1.0, samples=5)
    assert triangle(2.0, 2, samples=4).share.tolist() == [0.0, 0.5, 1.0, 0.5, 0.0, 0.5, 1.0, 0.5, 0.0]
