"""Planar finite elements with other parts: half-spaces by images and by quadrature, plates by name, convergence."""

import numpy as np
import pytest
from scipy.constants import mu_0

from sits_mech.geometry.plates import PlateSection
from sits_mech.geometry.tracks import coil_bars
from sits_mech.geometry.windings import Bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.section.coils import tracks
from sits_mech.magnetics.section.elements import element_errors, solve_field
from sits_mech.magnetics.section.kernels import mean_log
from sits_mech.magnetics.section.mesh import Fineness, divide_plane
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Sensor, load_sensor, sensor_from


def _scene(**changes: object) -> Sensor:
    """The published sensor without layer, with other parts."""
    scene = load_sensor("biorob2018").model_dump(exclude_none=True)
    del scene["elastomer"]
    return sensor_from({key: part for key, part in (scene | changes).items() if part is not None})


def _block(name: str, bottom: float, width: float, thickness: float, **metal: float) -> dict[str, object]:
    centre = (0.0, bottom + thickness / 2)
    sizes = {"width": width, "length": width, "thickness": thickness}
    return {"name": name, "shape": "rectangle", "centre": centre, **sizes, **metal}


def _mirrored(first: Bars, second: Bars, plane: float) -> float:
    """Mutual inductance of a coil with another's image in the plane z = `plane` [H/m]."""
    size = (np.array(first.width), np.array(first.thickness))
    logs = mean_log(second.x - first.x[:, None], 2 * plane - second.z - first.z[:, None], size, size)
    return float(-mu_0 / (2 * np.pi) * first.sign @ logs @ second.sign)


@pytest.mark.parametrize("mu_r", [2.0, pytest.param(1e3, marks=pytest.mark.slow)])
def test_permeable_half_space_by_images(mu_r: float) -> None:
    """Currents at a permeable half-space: images times (mu_r - 1) / (mu_r + 1). A block of 0.4 x 0.2 m is it."""
    block = _block("ferrite", 1e-3, 0.4, 0.2, conductivity=1e-6, relative_permeability=mu_r)
    sensor = _scene(target=None, conductors=[block])
    found = planar_fem(sensor, 1e-2).impedance(Pose(0.0, 1.0), 1e3)
    bars = [coil_bars(coil) for coil in sensor.coils]
    image = (mu_r - 1) / (mu_r + 1) * np.array([[_mirrored(a, b, 1e-3) for b in bars] for a in bars])
    assert np.abs(found.L - found.L0 - image).max() < 1e-3 * image.max()


@pytest.mark.parametrize(
    "frequency, delta_L, R",
    [(5e3, -1.1488152e-07, 0.001015553), pytest.param(5e6, -1.6194157e-07, 0.050466572, marks=pytest.mark.slow)],
)
def test_pair_over_conducting_half_space(frequency: float, delta_L: float, R: float) -> None:
    """A pair of lines 4.5 mm apart, 2 mm from copper of 59.6 MS/m; source: two quadratures of the half-space integral.

    A track of 10 um is the line, a block of 0.4 x 0.02 m the half-space.
    """
    track = 10e-6
    coil = {"name": "pair", "centre": (0.0, 0.0), "layers": 1, "turns": 1, "inner_diameter": 4.5e-3 - track}
    coil |= {"track_width": track, "track_thickness": track}
    block = _block("copper", 2e-3 - track / 2, 0.4, 0.02, conductivity=5.96e7)
    found = planar_fem(_scene(coils=[coil], target=None, conductors=[block])).impedance(Pose(0.0, 1.0), frequency)
    assert found.L[0, 0] - found.L0[0, 0] == pytest.approx(delta_L, rel=1e-3)
    assert found.R[0, 0] == pytest.approx(R, rel=2e-3)


@pytest.mark.slow
def test_a_fixed_plate_is_a_target_at_rest() -> None:
    plate = _block("plate", 2e-3, 8e-3, 0.2e-3, conductivity=load_sensor("biorob2018").target.metal.conductivity)
    fixed = planar_fem(_scene(target=None, conductors=[plate])).impedance(Pose(0.0, 1.0), 5e6)
    moved = planar_fem(_scene()).impedance(Pose(0.0, 2e-3), 5e6)
    assert np.array_equal(fixed.L, moved.L) and np.array_equal(fixed.R, moved.R)


@pytest.mark.slow
def test_a_far_plate_adds_nothing_and_a_missed_one_is_left_out() -> None:
    alone = planar_fem(_scene(), 1e-2).impedance(Pose(1e-3, 2e-3, 0.1), 5e6)
    far = _block("far", 0.3, 8e-3, 0.2e-3, conductivity=5.8e7)
    both = planar_fem(_scene(conductors=[far]), 1e-2).impedance(Pose(1e-3, 2e-3, 0.1), 5e6)
    assert np.abs(both.L - alone.L).max() < alone.error_L.max()
    beside = far | {"name": "beside", "centre": (0.0, 0.1, 1e-3)}
    missed = planar_fem(_scene(conductors=[beside]), 1e-2).impedance(Pose(1e-3, 2e-3, 0.1), 5e6)
    assert np.array_equal(missed.L, alone.L)


@pytest.mark.slow
def test_ferrite_behind_raises_and_ground_plane_lowers() -> None:
    """A backing concentrates the flux on the target, a ground plane behind takes it away; both stay passive."""
    changes = []
    for metal in ({"conductivity": 1.0, "relative_permeability": 1000.0}, {"conductivity": 5.8e7}):
        back = _block("back", -1.5e-3, 18e-3, 1e-3, **metal)
        found = planar_fem(_scene(conductors=[back]), 1e-2).impedance(Pose(0.0, 2e-3), 5e6)
        changes.append(np.diag(found.L - found.L0))
        assert np.all(np.linalg.eigvalsh(found.R) > 0) and np.all(np.linalg.eigvalsh(found.L) > 0)
    assert np.all(changes[0] > 0) and np.all(changes[1] < 0)


@pytest.mark.slow
def test_rates() -> None:
    """The flux converges twice as fast as the field: towards order 4 with elements of order 2, faster with order 3."""
    coils = tracks(load_sensor("biorob2018"))
    plate, omega = PlateSection("plate", 2e-3j, 0.0, 8e-3, 0.2e-3, 5.8e7, 1.0, True), 2 * np.pi * 5e6
    depth = np.sqrt(2 / (omega * mu_0 * plate.conductivity))
    bars = np.concatenate([coil.place for coil in coils])
    coarse = Fineness(skin=1.0, edge=0.5, growth=0.6, near=0.6, share=0.1, around=40.0)
    exact = -1.696012066246201e-05 - 1j * 21.111396592136952 / omega  # order-5 elements of an independent code
    errors = []
    for factor in (1.0, 0.5):
        division = divide_plane((plate,), bars, np.array([depth]), (coarse.times(factor),))
        second, third = (solve_field(division, (plate,), coils, omega, order) for order in (2, 3))
        errors.append([abs(solution.flux[0, 0] - exact) for solution in (second, third)])
        shares = element_errors(division, (plate,), omega, second, third)
        assert np.abs(third.flux - second.flux).max() < 2 * shares.sum()
    rates = np.log2(np.array(errors[0]) / errors[1])
    assert rates[0] > 3.0 and rates[1] > 3.5
