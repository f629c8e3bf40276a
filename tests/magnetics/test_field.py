"""Planar finite elements: reference numbers, invariants, limits, the integral model, bad input."""

import threading

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision
from sits_mech.geometry.meshing.unstructured import MesherMissing
from sits_mech.magnetics import field
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.quantities import Impedance, Pose, SolveFailed
from sits_mech.scene.sensor import Sensor, changed, load_sensor, sensor_from

# Zero net current, copper 58 MS/m, 8 x 0.2 mm: d_h, d_v [mm], f [Hz], Delta L1, L2, M12 [H/m], R1, R2 [ohm/m].
# Source: NGSolve 6.2, order 5, confirmed by GetDP 3.2 to 2e-5.
ISOLATED = (
    (0, 1, 5e3, -1.2689598921607269e-06, -1.2689598921607269e-06, 6.392315755497909e-07, 0.1878462298, 0.1878462298),
    (0, 1, 5e6, -3.994483152940223e-05, -3.994483152940223e-05, 1.3991454285199589e-05, 51.8362219128, 51.8362219128),
    (0, 5, 5e6, -3.5703584183263714e-06, -3.5703584183263714e-06, -9.270677255568654e-07, 3.0513129890, 3.0513129890),
    (2, 2, 5e3, -5.232550057347849e-07, -5.997367846259031e-06, 1.6667088439393363e-06, 0.0384149749, 0.4920165058),
    (2, 2, 5e6, -4.559785394394114e-06, -5.531686111106578e-05, 1.2581211484302178e-05, 6.71666190812, 33.2517189329),
)
# The same with free net current at (0, 2), 5 MHz: radius where A = 0 [mm], Delta L1, M12, R1.
FREE = (
    (25.0, -3.0211498005433372e-05, 2.207033815487948e-05, 16.818854984),
    (1000.0, -2.2516436114938202e-05, 1.320032193911121e-05, 19.197114098),
)


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return changed(load_sensor("biorob2018"), ['target.conductivity="58 MS/m"'])


def _shares(found: Impedance, delta_L: np.ndarray, R: np.ndarray) -> tuple[float, float, float]:
    """Errors of Delta L and R, and the estimated error of L, over their largest entries."""
    error = np.abs(found.L - found.L0 - delta_L).max()
    largest = np.abs(delta_L).max()
    return error / largest, np.abs(np.diag(found.R) / R - 1).max(), found.error_L.max() / largest


@pytest.mark.parametrize("row", [*ISOLATED[:2], *(pytest.param(row, marks=pytest.mark.slow) for row in ISOLATED[2:])])
def test_isolated_plate_reference(sensor: Sensor, row: tuple[float, ...]) -> None:
    d_h, d_v, frequency, L1, L2, M, R1, R2 = row
    found = planar_fem(sensor).impedance(Pose(d_h * 1e-3, d_v * 1e-3), frequency)
    error, error_R, estimate = _shares(found, np.array([[L1, M], [M, L2]]), np.array([R1, R2]))
    assert error < 1e-4  # ten times better than asked: the answer is of order 3
    assert error_R < 1e-3
    assert error <= estimate <= 1e-3


@pytest.mark.parametrize("radius, L1, M, R1", [FREE[0], pytest.param(*FREE[1], marks=pytest.mark.slow)])
def test_free_net_current_reference(sensor: Sensor, radius: float, L1: float, M: float, R1: float) -> None:
    free = changed(sensor, ['target.net_current="free"', f'target.planar_boundary_radius="{radius} mm"'])
    found = planar_fem(free).impedance(Pose(0.0, 2e-3), 5e6)
    error, error_R, estimate = _shares(found, np.array([[L1, M], [M, L1]]), np.array([R1, R1]))
    assert error < 1e-4
    assert error_R < 1e-3
    assert error <= estimate <= 1e-3


@pytest.mark.slow
def test_refined_to_the_reference(sensor: Sensor) -> None:
    d_h, d_v, frequency, L1, L2, M, R1, R2 = ISOLATED[1]
    found = planar_fem(sensor, 1e-4).impedance(Pose(d_h * 1e-3, d_v * 1e-3), frequency)
    error, error_R, _ = _shares(found, np.array([[L1, M], [M, L2]]), np.array([R1, R2]))
    assert error < 1e-5
    assert error_R < 1e-4


def test_free_space_inductance(sensor: Sensor) -> None:
    """Closed form of the double mean: same source as the reference rows."""
    alone = sensor.model_copy(update={"target": None})
    found = planar_fem(alone).impedance(Pose(0.0, 2e-3), 5e6)
    assert found.L0[0, 0] == pytest.approx(0.00047480313357162, rel=1e-6)
    assert found.L0[0, 1] == pytest.approx(-4.7405988439865e-05, rel=1e-6)
    assert np.array_equal(found.L, found.L0) and not found.R.any()
    assert np.array_equal(found.L0, planar_bars(alone).impedance(Pose(0.0, 2e-3), 5e6).L0)


@pytest.mark.slow
def test_equals_the_integral_model(sensor: Sensor) -> None:
    """Two models that share no discretisation, at tilted poses: each promises 1e-3 of Delta L, 1e-2 of R."""
    poses = Pose(np.array([1e-3, -3e-3]), np.array([1.5e-3, 3e-3]), np.array([0.2, -0.35]))
    for frequency in (5e3, 5e6):
        fem, bars = (make(sensor, 1e-3).impedance(poses, frequency) for make in (planar_fem, planar_bars))
        assert np.abs(fem.L - bars.L).max() < 2e-3 * np.abs(bars.L - bars.L0).max()
        assert np.abs(fem.R - bars.R).max() < 2e-2 * np.abs(bars.R).max()
        assert np.allclose(fem.R_dc, bars.R_dc, rtol=1e-12)


@pytest.mark.slow
def test_mirror_swaps_the_coils(sensor: Sensor) -> None:
    found = planar_fem(sensor).impedance(Pose(np.array([1e-3, -1e-3]), 2e-3, np.array([0.1, -0.1])), 5e6)
    change = found.L - found.L0
    assert np.abs(change[0] - change[1][::-1, ::-1]).max() < found.error_L.max()
    assert np.abs(found.R[0] - found.R[1][::-1, ::-1]).max() < found.error_R.max()


@pytest.mark.slow
def test_monotone_in_frequency_between_both_limits(sensor: Sensor) -> None:
    """R grows like f^2 where resistance rules; Delta L falls towards the perfect conductor; no sign is wrong."""
    model, pose = planar_fem(sensor, 1e-2), Pose(1e-3, 2e-3, 0.1)
    found = [model.impedance(pose, f) for f in (1.0, 10.0, 5e3, 1e5, 5e6, 1e8)]
    change = np.array([np.diag(z.L - z.L0) for z in found])
    loss = np.array([np.diag(z.R) for z in found])
    assert np.all(np.diff(change, axis=0) < 0) and np.all(change[-1] > -np.diag(found[0].L0)) and np.all(change < 0)
    assert np.all(np.diff(loss, axis=0) > 0) and np.all(loss > 0)
    assert loss[1] == pytest.approx(100 * loss[0], rel=1e-5)  # (omega tau)^2 is 1e-7 here


@pytest.mark.slow
def test_reciprocity_to_rounding(sensor: Sensor) -> None:
    """Before symmetrising: the flux of coil 1 in coil 2 is that of coil 2 in coil 1, in every regime."""
    for overrides in ([], ["target.relative_permeability=200"], ['target.thickness="5 um"']):
        for frequency in (5e3, 5e6):
            found = planar_fem(changed(sensor, overrides), 1e-2).field(Pose(1e-3, 2e-3, 0.1), frequency)
            assert found is not None
            assert np.abs(found.flux - found.flux.T).max() < 1e-10 * np.abs(found.flux).max()


@pytest.mark.parametrize(
    "overrides, d_v, frequency",
    [
        (['target.thickness="5 um"'], 2e-3, 1.0),
        pytest.param(['target.thickness="5 um"'], 2e-3, 1e8, marks=pytest.mark.slow),
        (['target.thickness="5 mm"'], 2e-3, 1e8),
        ([], 5e-5, 5e6),
        ([], 5e-2, 1e8),
        pytest.param(['target.width="0.5 mm"'], 2e-3, 5e6, marks=pytest.mark.slow),
        pytest.param(['elastomer.width="0.2 m"', 'target.width="100 mm"'], 2e-3, 1e8, marks=pytest.mark.slow),
        pytest.param(['target.conductivity="1e3 S/m"'], 2e-3, 1e8, marks=pytest.mark.slow),
        pytest.param(['target.conductivity="1e9 S/m"'], 2e-3, 1e8, marks=pytest.mark.slow),
        (["target.relative_permeability=1e4"], 2e-3, 1.0),
        pytest.param(["target.relative_permeability=1e4"], 2e-3, 5e6, marks=pytest.mark.slow),
    ],
)
def test_extreme_regimes(sensor: Sensor, overrides: list[str], d_v: float, frequency: float) -> None:
    found = planar_fem(changed(sensor, overrides), 1e-2).impedance(Pose(1e-3, d_v, 0.0), frequency)
    change = np.diag(found.L - found.L0)
    assert np.all(np.isfinite(found.L)) and np.all(np.diag(found.R) > 0) and np.all(change > -np.diag(found.L0))
    assert found.report.estimated_error <= 1e-2 and found.report.residual < 1e-10
    if "permeability" not in "".join(overrides):
        assert np.all(change < 0)


@pytest.mark.slow
def test_curved_substrate(sensor: Sensor) -> None:
    """A very round substrate is flat; turning coil and target together about its axis changes nothing."""
    pose = Pose(1e-3, 2e-3, 0.1)
    flat = planar_fem(sensor).impedance(pose, 5e6)
    large = planar_fem(changed(sensor, ['substrate_radius="500 m"'])).impedance(pose, 5e6)
    assert np.abs(large.L - flat.L).max() < 1e-4 * np.abs(flat.L - flat.L0).max()
    radius, scene = 20e-3, sensor.model_dump(exclude_none=True)
    scene["substrate_radius"] = radius
    scene["coils"] = [scene["coils"][0] | {"centre": (0.0, 0.0)}]
    top = planar_fem(sensor_from(scene)).impedance(Pose(0.5e-3, 3e-3, 0.05), 5e6)
    scene["coils"] = [scene["coils"][0] | {"centre": (5e-3, 0.0)}]
    turn = np.exp(-1j * 5e-3 / radius)
    place = (0.5e-3 + 1j * (3e-3 + radius)) * turn - 1j * radius
    side = planar_fem(sensor_from(scene)).impedance(Pose(place.real, place.imag, 0.05 + 5e-3 / radius), 5e6)
    assert side.L0 == pytest.approx(top.L0, rel=1e-12)
    assert side.L - side.L0 == pytest.approx(top.L - top.L0, rel=1e-4)


def test_arrays_of_poses_keep_their_shape(sensor: Sensor) -> None:
    found = planar_fem(sensor, 1e-2).impedance(Pose(0.0, np.array([[2e-3], [3e-3]])), 5e6)
    assert found.L.shape == found.R.shape == found.error_L.shape == (2, 1, 2, 2)
    assert found.report.iterations == 4


def test_refusals(sensor: Sensor) -> None:
    model = planar_fem(sensor)
    with pytest.raises(Collision):
        model.impedance(Pose(0.0, 1e-3, 0.5), 5e6)
    with pytest.raises(ValueError, match="frequency: must be a positive number"):
        model.impedance(Pose(0.0, 2e-3), -5.0)
    with pytest.raises(ValueError, match="tolerance must lie between 1e-07 and 1"):
        planar_fem(sensor, 0.0)
    plate = {"name": "lid", "material": "copper", "shape": "rectangle", "centre": (0.0, 2e-3), "thickness": 1e-3}
    scene = sensor.model_dump(exclude_none=True) | {"conductors": [plate | {"width": 5e-3, "length": 5e-3}]}
    del scene["elastomer"]  # with it the scene is refused
    with pytest.raises(Collision, match=r"target must stay clear of conductors.lid"):
        planar_fem(sensor_from(scene)).impedance(Pose(0.0, 2e-3), 5e6)
    small = changed(sensor, ['target.net_current="free"', 'target.planar_boundary_radius="5 mm"'])
    with pytest.raises(ValueError, match="planar_boundary_radius: must enclose"):
        planar_fem(small).impedance(Pose(0.0, 2e-3), 5e6)
    off_axis = sensor.model_dump(exclude_none=True)
    off_axis["coils"] = [off_axis["coils"][0] | {"centre": (0.0, 1e-3)}]
    with pytest.raises(ValueError, match="coils.*centre must be on y = 0 for a section; got"):
        planar_fem(sensor_from(off_axis))


@pytest.mark.slow
def test_unreached_tolerance_is_an_error(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sits_mech.magnetics.field._MOST_UNKNOWNS", 10)
    with pytest.raises(SolveFailed, match="estimated error") as failed:
        planar_fem(changed(sensor, ["target.relative_permeability=1e4"])).impedance(Pose(0.0, 2e-3), 5e6)
    assert failed.value.report.status == "tolerance not reached"


def test_off_the_main_thread_is_refused(sensor: Sensor) -> None:
    caught: list[Exception] = []

    def work() -> None:
        try:
            planar_fem(sensor).impedance(Pose(0.0, 2e-3), 5e6)
        except MesherMissing as error:
            caught.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert "main thread" in str(caught[0])


def test_errors_that_fall_too_slowly_are_given_up_early():
    """Order 2 from 10 times the tolerance at 10,000 unknowns gets there; a fourth root from 100 times does not."""
    assert not field._hopeless([(10_000, 10.0), (20_000, 2.5)])
    assert not field._hopeless([(10_000, 10.0), (20_000, 2.5), (40_000, 0.7)])
    assert field._hopeless([(10_000, 100.0), (20_000, 84.0), (40_000, 71.0)])
    assert field._hopeless([(10_000, 100.0), (20_000, 150.0), (40_000, 120.0)])
