"""The three-dimensional model against closed forms, an independent volume FEM, and its own invariants."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import mu_0

from sits_mech.geometry.collision import Collision
from sits_mech.magnetics.axis_fem import axisymmetric_fem
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Sensor, changed, load_sensor

# Volume FEM (NGSolve 6.2, two kinds of mesh, error 2e-4 of Delta L, 1e-3 of R): 8 x 8 x 0.2 mm copper plate,
# two coils as rings; f [Hz], d_v [m], Delta L1 [nH], Delta M12 [nH], R1 [ohm].
PLATE = (
    (5e6, 2e-3, -59.01338, 4.761622, 0.07347140),
    (5e6, 5e-3, -5.684821, -2.184032, 0.005169888),
    (5e3, 2e-3, -2.171675, -0.1770742, 2.962316e-4),
    (5e3, 5e-3, -0.3517857, -0.2383162, 3.786894e-5),
)
# Axisymmetric FEM (NGSolve 6.2 p = 6, error 1e-6): coaxial copper disc, 0.2 mm thick, gap 2 mm; radius, f, Delta L, R.
DISC = (
    (3.5e-3, 5e3, -1.09405875e-8, 1.26011961e-3),
    (3.5e-3, 5e6, -1.72208696e-7, 0.115273800),
    (7.5e-3, 5e3, -4.65903043e-8, 2.61817465e-3),
    (7.5e-3, 5e6, -2.18587417e-7, 0.0952016920),
)


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def model(sensor: Sensor) -> Sheets:
    return sheets(sensor)


def one_loop(target: str, *overrides: str) -> Sensor:
    """One turn of 20 mm radius and nothing else, over a target: nearly uniform field."""
    coil = (
        'coils=[{name="C1", centre=["0 mm","0 mm"], layers=1, turns=1, inner_diameter="39.9 mm", '
        'track_width="0.1 mm", track_thickness="35 um"}]'
    )
    return load_sensor("biorob2018", [coil, f"target={{{target}}}", *overrides])


def axial_field(sensor: Sensor, z: float) -> float:
    """Flux density on the axis per ampere [T/A]."""
    a = sensor.coils[0].inner_diameter / 2 + sensor.coils[0].track_width / 2
    return float(mu_0 * a**2 / 2 / (a**2 + (z + sensor.coils[0].track_thickness / 2) ** 2) ** 1.5)


@pytest.mark.parametrize("f, d_v, delta_L, delta_M, R", [
    *PLATE[::2], *(pytest.param(*row, marks=pytest.mark.slow) for row in PLATE[1::2]),
])
def test_plate_as_volume_fem(model: Sheets, f: float, d_v: float, delta_L: float, delta_M: float, R: float) -> None:
    z = model.impedance(Pose(0.0, d_v), f)
    change = (z.L - z.L0) * 1e9
    assert change[0, 0] == pytest.approx(delta_L, rel=5e-3)
    assert change[0, 1] == pytest.approx(delta_M, abs=2e-3 * abs(delta_L))
    assert z.R[0, 0] == pytest.approx(R, rel=5e-3)
    assert abs(change[0, 0] - delta_L) < z.error_L[0, 0] * 1e9 + 5e-4 * abs(delta_L)
    assert abs(z.R[0, 0] - R) < z.error_R[0, 0] + 1e-3 * R


@pytest.mark.parametrize("f, d_v, delta_L", [row[:3] for row in PLATE[:2]])
def test_a_square_owns_to_its_corners(sensor: Sensor, f: float, d_v: float, delta_L: float) -> None:
    """At 3e-3: 8e-4 and 5e-4 left, of which 6e-4 and 3e-4 were stated."""
    z = sheets(changed(sensor, ["target.conductivity=58 MS/m"]), 3e-3).impedance(Pose(0.0, d_v), f)
    assert 0.2 < abs((z.L - z.L0)[0, 0] * 1e9 - delta_L) / (z.error_L[0, 0] * 1e9) < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("radius, f, delta_L, R", DISC[:2])
def test_coaxial_disc_as_axisymmetric_fem(radius: float, f: float, delta_L: float, R: float) -> None:
    disc = f'target={{material="copper", shape="disc", diameter={2 * radius}, thickness="0.2 mm"}}'
    sensor = load_sensor("biorob2018", [disc, 'coils.C1.centre=["0 mm","0 mm"]', 'coils.C2.centre=["20 mm","0 mm"]'])
    z = sheets(sensor).impedance(Pose(0.0, 2e-3), f)
    assert (z.L - z.L0)[0, 0] == pytest.approx(delta_L, rel=2e-3, abs=0.0)
    assert z.R[0, 0] == pytest.approx(R, rel=5e-3)


def under_disc(diameter: float, thickness: float) -> Sensor:
    """The published winding about the axis of a copper disc [m]."""
    disc = f'target={{material="copper", shape="disc", diameter={diameter}, thickness={thickness}}}'
    coil = load_sensor("biorob2018").coils[0].model_copy(update={"centre": (0.0, 0.0)})
    return load_sensor("biorob2018", [disc]).model_copy(update={"coils": (coil,), "elastomer": None})


@pytest.mark.slow
def test_the_error_of_a_disc_thirty_skin_depths_thick() -> None:
    """At 100 MHz Delta L is off by 1e-3 from that about the axis, which is right to 6e-6; 7e-4 was told of it."""
    scene = under_disc(8e-3, 2e-4)
    models = sheets(scene, 1e-2), axisymmetric(scene, 1e-3)
    z, true = (model.impedance(Pose(0.0, 2e-3), 1e8) for model in models)
    assert 5e-4 * abs(true.L - true.L0) < abs(z.L - true.L) < z.error_L


@pytest.mark.slow
@pytest.mark.parametrize("diameter, thickness, gap, frequency", [
    (3e-3, 18e-6, 0.1e-3, 25e6), (6.5e-3, 112e-6, 1.6e-3, 167e3),
])
def test_stated_errors_are_those_of_finer_answers(
    diameter: float, thickness: float, gap: float, frequency: float
) -> None:
    """Against finite elements about the axis, right to 1e-6: errors of L and R from 0.1 to 1 of those stated.

    None is larger when ten times less is asked; of the foil they once were 4.3e-5, 3.7e-4 of L, 3.7e-4, 1.8e-3 of R.
    """
    scene = under_disc(diameter, thickness)
    true, before = axisymmetric_fem(scene, 1e-5).impedance(Pose(0.0, gap), frequency), np.inf
    for asked in (1e-2, 1e-3):
        z = sheets(scene, asked).impedance(Pose(0.0, gap), frequency)
        off = np.array([z.L - true.L, z.R - true.R]).ravel()
        stated = np.array([z.error_L, z.error_R]).ravel()
        assert np.all(0.1 * stated < np.abs(off)) and np.all(np.abs(off) < stated)
        assert np.all(np.abs(off) < before)
        assert z.report.estimated_error < asked
        before = np.abs(off)


@pytest.mark.slow
@pytest.mark.parametrize("diameter, thickness, gap, frequencies, asked", [
    (20e-3, 200e-6, 0.5e-3, (1e6, 1e5), 1e-3), (60e-3, 500e-6, 0.5e-3, (1e5, 1e6), 1e-3),
])
def test_errors_close_to_coils_hold(
    diameter: float, thickness: float, gap: float, frequencies: tuple[float, ...], asked: float
) -> None:
    """Against finite elements about the axis; R was 2.5 and 1.3 times as far off as stated, L 1.3 and 1.2 times."""
    scene = under_disc(diameter, thickness)
    for frequency in frequencies:
        true, z = (model.impedance(Pose(0.0, gap), frequency) for model in
                   (axisymmetric_fem(scene, 1e-5), sheets(scene, asked)))
        assert abs(z.L - true.L) < z.error_L < 3e-3 * abs(true.L - true.L0)
        assert abs(z.R - true.R) < z.error_R < 1e-2 * true.R


def test_free_space_as_rings(model: Sheets) -> None:
    z = model.impedance(Pose(0.0, 2e-3), 5e6)
    assert z.L0[0, 0] == pytest.approx(2.507569757e-6, rel=1e-7, abs=0)  # axisymmetric FEM
    assert z.L0[0, 1] == pytest.approx(-47.4298e-9, rel=1e-5, abs=0)  # volume FEM
    shorted = z.L0[0, 1] ** 2 / z.L0[1, 1]
    assert shorted == pytest.approx(0.8971e-9, rel=1e-3, abs=0)


def test_perfect_disc_in_axial_field() -> None:
    """A thin perfectly conducting disc of radius a has the moment -8 a^3 H / 3 (Bethe's small hole, by duality).

    Thin: a rim of thickness t widens it by (t / 2 pi)(1 + ln(8 pi a / t)), like that of a strip: 1 um is worth 1 %.
    """
    a, t, d = 0.5e-3, 1e-8, 10e-3
    sensor = one_loop(f'conductivity=1e12, relative_permeability=1, shape="disc", diameter={2 * a}, thickness={t}')
    z = sheets(sensor).impedance(Pose(0.0, d), 1e8)
    B = axial_field(sensor, d + t / 2)
    assert (z.L - z.L0)[0, 0] == pytest.approx(-8 * a**3 / 3 * B**2 / mu_0, rel=2e-3, abs=0.0)


@pytest.mark.parametrize("shape, torsion", [("disc", np.pi / 32), ("rectangle", 0.1405770)])
def test_resistive_plate_in_axial_field(shape: str, torsion: float) -> None:
    """At low frequency R = omega^2 B^2 sigma t J / 4, J the torsion constant (Timoshenko and Goodier, art. 109)."""
    side, t, sigma, f, d = 1e-3, 0.2e-3, 1e6, 1e3, 10e-3
    size = f'diameter={side}' if shape == "disc" else f'width={side}, length={side}'
    sensor = one_loop(f'conductivity={sigma}, relative_permeability=1, shape="{shape}", {size}, thickness={t}')
    z = sheets(sensor).impedance(Pose(0.0, d), f)
    B = axial_field(sensor, d + t / 2)
    exact = (2 * np.pi * f * B) ** 2 * sigma * t * torsion * side**4 / 4
    assert z.R[0, 0] == pytest.approx(exact, rel=2e-3, abs=0.0)


def test_invariants_over_frequency(model: Sheets) -> None:
    frequencies = [1.0, 10.0, 1e3, 1e4, 1e5, 1e6, 1e7]
    poses = Pose(np.array([0.0, 1e-3]), np.array([2e-3, 2.5e-3]), np.array([0.0, 0.1]))
    results = [model.impedance(poses, f) for f in frequencies]
    for z in results:
        assert np.abs(z.L - np.swapaxes(z.L, 1, 2)).max() <= 1e-10 * np.abs(z.L).max()
        assert np.abs(z.R - np.swapaxes(z.R, 1, 2)).max() <= 1e-10 * np.abs(z.R).max()
        assert np.linalg.eigvalsh(z.R).min() >= -1e-12 * np.abs(z.R).max()
        change = np.linalg.eigvalsh(z.L - z.L0)
        assert change.max() <= 0.0 and change.min() >= -z.L0[0, 0]
    L = np.array([z.L[:, 0, 0] for z in results])
    R = np.array([z.R[:, 0, 0] for z in results])
    assert (np.diff(L, axis=0) < 0).all() and (np.diff(R, axis=0) > 0).all()
    assert R[1] / R[0] == pytest.approx(100.0, rel=1e-4)  # resistive: f^2


def test_mirror_and_turns(model: Sheets) -> None:
    left, right = (model.impedance(Pose(x, 2.2e-3, a), 5e6) for x, a in ((-1e-3, -0.05), (1e-3, 0.05)))
    assert left.L[0, 0] == pytest.approx(right.L[1, 1], rel=1e-9, abs=0.0)
    place = Pose(0.7e-3, 2e-3, d_y=0.3e-3)
    straight, turned = (model.impedance(replace(place, alpha_z=angle), 5e6) for angle in (0.0, np.pi / 2))
    assert (turned.L - turned.L0) == pytest.approx(straight.L - straight.L0, rel=1e-6, abs=0.0)  # the plate is square


@pytest.mark.slow
def test_extreme_skin_ratios_follow_the_skin_depth(sensor: Sensor) -> None:
    """Delta L tends to that of a perfect conductor (FEM as above, -61.41 nH), R / sqrt(f / sigma) to one value.

    889 skin depths at 1e12 S/m: within three times the stated errors, of R below 10 %, of L 0.8 % with its corners.
    """
    plate = 'relative_permeability=1, shape="rectangle", width="8 mm", length="8 mm", thickness="0.2 mm"'
    found = [sheets(load_sensor("biorob2018", [f"target={{conductivity={sigma}, {plate}}}"])).impedance(
        Pose(0.0, 2e-3), 5e6) for sigma in (1e10, 1e12)]
    change, error = ((values * 1e9)[0, 0] for values in (found[1].L - found[1].L0, found[1].error_L))
    assert abs(change + 61.41) < 3.0 * error + 0.02 < 1.6
    (R, off), (other, _) = ((z.R[0, 0] * s, z.error_R[0, 0] * s) for z, s in zip(found, (1e5, 1e6), strict=True))
    assert abs(R - other) < 3.0 * off < 0.3 * R


def test_array_of_four_and_many_poses() -> None:
    coils = [f"coils.C{k}.centre=[{x}, {y}]" for k, x, y in ((1, -4e-3, -4e-3), (2, 4e-3, -4e-3))]
    sensor = load_sensor("biorob2018", coils)
    above = [c.model_copy(update={"name": f"D{c.name}", "centre": (c.centre[0], 4e-3)}) for c in sensor.coils]
    four = sensor.model_copy(update={"coils": (*sensor.coils, *above)})
    model = sheets(four, 2e-2)
    z = model.impedance(Pose(np.zeros((2, 3)), np.full((2, 3), 2e-3), 0.0), 5e6)
    assert z.L.shape == (2, 3, 4, 4)
    diagonal = np.diagonal(z.L - z.L0, axis1=-2, axis2=-1)
    assert diagonal == pytest.approx(diagonal[0, 0, 0], rel=1e-9, abs=0.0)


def test_table_of_the_field_as_the_field(model: Sheets) -> None:
    poses = Pose(np.linspace(-1e-3, 1e-3, 301), np.linspace(2.3e-3, 2.7e-3, 301), np.linspace(-0.05, 0.05, 301))
    many = model.impedance(poses, 5e6)
    one = model.impedance(Pose(float(poses.d_h[7]), float(poses.d_v[7]), float(poses.alpha[7])), 5e6)
    assert many.L[7] - many.L0 == pytest.approx(one.L - one.L0, rel=1e-6, abs=0.0)


def test_refusals(sensor: Sensor, model: Sheets) -> None:
    with pytest.raises(Collision, match="above the coil plane"):
        model.impedance(Pose(0.0, -1e-3), 5e6)
    with pytest.raises(ValueError, match="frequency"):
        model.impedance(Pose(0.0, 2e-3), 0.0)
    with pytest.raises(ValueError, match="windings"):
        sheets(sensor, windings="wire")
    with pytest.raises(ValueError, match="tolerance"):
        sheets(sensor, 0.0)


@pytest.mark.slow
def test_many_poses_without_a_target() -> None:
    """Fixed metal alone answers alike at every pose, errors and their shared parts too."""
    part = 'conductors=[{name="nut", material="brass", shape="rectangle", centre=["0 mm", "-3 mm"], width="6 mm", ' \
        'length="6 mm", thickness="1 mm"}]'
    bare = load_sensor("biorob2018", [part]).model_copy(update={"target": None, "elastomer": None})
    z = sheets(bare, 1e-2).impedance(Pose(np.zeros(3), 2e-3), 5e6)
    assert z.L.shape == (3, 2, 2) and np.ptp(z.L, axis=0).max() == 0.0 < (z.L0 - z.L[0])[0, 0]
    assert z.shared_L is not None and z.shared_L.shape[1:] == (3, 2, 2)
