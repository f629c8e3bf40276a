"""Axisymmetric finite elements against another code, plates in closed form, rings, limits; their own convergence."""

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.axis.coaxial import coaxial_discs
from sits_mech.magnetics.axis.elements import solve_axis
from sits_mech.magnetics.axis.lines import divide_axis
from sits_mech.magnetics.axis_fem import AxisymmetricFem, axisymmetric_fem, solved_axis
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.quantities import Impedance, Pose, SolveFailed
from sits_mech.scene.sensor import Coil, Conductor, SceneError, Sensor, Target, load_sensor

MM = 1e-3
COPPER = 5.8e7
SMALL = Coil(
    name="C", centre=(0.0, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM, track_gap=0.1 * MM,
    track_thickness=35e-6, layer_pitch=85e-6,
)
SINGLE = Coil(  # twenty turns in one layer
    name="C", centre=(0.0, 0.0), layers=1, turns=20, inner_diameter=3 * MM, track_width=0.1 * MM, track_gap=0.1 * MM,
    track_thickness=35e-6,
)
TEN = Coil(
    name="C", centre=(0.0, 0.0), layers=1, turns=10, inner_diameter=4 * MM, track_width=0.2 * MM, track_gap=0.2 * MM,
    track_thickness=35e-6,
)


def target(radius: float, thickness: float, conductivity: float, mu_r: float = 1.0) -> Target:
    """A disc, sizes in mm."""
    return Target(
        conductivity=conductivity, relative_permeability=mu_r, shape="disc", diameter=2 * radius * MM,
        thickness=thickness * MM,
    )


def fixed(
    radius: float, middle: float, thickness: float, conductivity: float, mu_r: float = 1.0, loss: float = 0.0
) -> Conductor:
    """A fixed disc, sizes in mm."""
    return Conductor(
        name="P", conductivity=conductivity, relative_permeability=mu_r, loss_tangent=loss, shape="disc",
        diameter=2 * radius * MM, thickness=thickness * MM, centre=(0.0, 0.0, middle * MM),
    )


def scene(coil: Coil, disc: Target | None, *plates: Conductor) -> Sensor:
    """A coil, a target and what is fixed."""
    return Sensor(name="axis", frequency=1e6, coils=(coil,), target=disc, conductors=plates)


def change(found: Impedance) -> complex:
    """Return Phi = Delta L - j R / omega [H]."""
    return complex((found.L - found.L0)[0, 0], -found.R[0, 0] / (2 * np.pi * found.frequency))


# NGSolve 6.2, A_phi, quads of order 6 (steel: of order 4, and a domain of 200 mm), same source: scene, gap [mm], f,
# Delta L, R, bounds of both. The rows of radius 3.5 and 7.5 are those of test_rings.
ROWS = {
    "steel": (scene(SMALL, target(4, 0.2, 1e7, 200.0)), 1.0, 1e6, -4.700758e-08, 1.315066, 1e-4, 1e-4),
    "thin": (scene(SINGLE, target(5, 0.1, 1.4e6)), 1.0, 5e4, -2.217109e-09, 0.01424284, 2e-5, 2e-6),
    "thick": (scene(SMALL, target(5, 3.0, COPPER)), 0.5, 5e6, -1.136476378537e-06, 0.69105270, 2e-6, 2e-4),
    "ground": (scene(SMALL, target(5, 0.1, COPPER), fixed(15, -0.8175, 0.035, COPPER)), 1.2, 1e6,
               -1.07111172547e-06, 0.39566728490684644, 5e-6, 1e-5),
    "slow": (scene(SMALL, target(3.5, 0.2, COPPER)), 2.0, 5e3, -1.0940587457181e-08, 0.00126011961, 2e-5, 1e-5),
    "fast": (scene(SMALL, target(7.5, 0.2, COPPER)), 2.0, 5e6, -2.1858741804936e-07, 0.09520169201, 2e-5, 2e-4),
    "close": (scene(SMALL, target(4.5, 0.2, COPPER)), 0.05, 3e6, -2.112850291328e-06, 1.14339432391, 3e-5, 1e-4),
}


LONG = ("close", "ground", "steel", "thick")


@pytest.mark.parametrize("row", [pytest.param(each, marks=[pytest.mark.slow] * (each in LONG)) for each in ROWS])
def test_another_code_finds_the_same(row: str) -> None:
    """What is left is the other's cells and domain, and the tolerance asked."""
    sensor, gap, frequency, delta_L, R, off_L, off_R = ROWS[row]
    found = AxisymmetricFem(sensor, 1e-4).impedance(Pose(0.0, gap * MM), frequency)
    assert change(found).real == pytest.approx(delta_L, rel=off_L)
    assert found.R[0, 0] == pytest.approx(R, rel=off_R)
    assert found.error_L[0, 0] < 1e-4 * abs(delta_L) and found.error_R[0, 0] < 1e-3 * R
    assert (found.report.residual < 1e-12, found.report.notes) == (True, ())


# radius and gap [mm], frequency, layer: permeable plates of finite thickness, thin, thick and lossy
PLATES = [
    (30.0, 1.0, 3e6, Layer(5e6, 0.8 * MM, 100.0)),
    (80.0, 0.3, 1e4, Layer(2e6, 0.5 * MM, 20.0)),
    (80.0, 0.5, 1e3, Layer(1e6, 0.1 * MM, 1000.0)),
    (80.0, 1.0, 1e5, Layer(1.0, 1.0 * MM, 40.0 * (1.0 - 0.3j))),
]


@pytest.mark.parametrize(
    "radius, gap, frequency, layer",
    [PLATES[0], *(pytest.param(*row, marks=pytest.mark.slow) for row in PLATES[1:])],
)
def test_large_discs_are_plates_in_closed_form(radius: float, gap: float, frequency: float, layer: Layer) -> None:
    """Dodd and Deeds, with a permeability: steel 60 mm wide under a coil takes 23.5 % of L0, and adds 1.840 ohm."""
    mu, conductivity, thickness = complex(layer.relative_permeability), layer.conductivity, layer.thickness / MM
    loss = -mu.imag / mu.real
    if loss:
        sensor = scene(TEN, None, fixed(radius, gap + thickness / 2, thickness, conductivity, mu.real, loss))
    else:
        sensor = scene(TEN, target(radius, thickness, conductivity, mu.real))
    found = axisymmetric_fem(sensor, 1e-4).impedance(Pose(0.0, gap * MM), frequency)
    plate = coil_change(coil_sections(TEN), gap * MM, frequency, [layer])
    off = change(found) - complex(plate.delta_L, -plate.R / (2 * np.pi * frequency))
    assert abs(off) < 2e-4 * abs(change(found))
    if radius == 30.0:
        assert change(found).real / found.L0[0, 0] == pytest.approx(-0.2352, abs=1e-4)
        assert found.R[0, 0] == pytest.approx(1.840, abs=1e-3)
        assert found.report.seconds < 10.0


KINDS = {
    "steel": (scene(SMALL, target(4, 0.2, 1e7, 200.0)), 1e6),
    "skin": (scene(TEN, target(8, 2.0, 1e7, 400.0)), 1e7),
    "ferrite": (scene(TEN, target(3, 0.3, COPPER), fixed(4, -0.8, 0.5, 1.0, 1000.0, 0.02)), 5e5),
    "copper": (scene(TEN, target(8, 0.3, COPPER), fixed(9, -0.8, 0.1, COPPER)), 1e5),
}


@pytest.mark.parametrize(
    "kind, tolerances, fineness",
    [("steel", (1e-2, 1e-3), 0.8),
     *(pytest.param(kind, (1e-2, 1e-3, 1e-4), 0.45, marks=pytest.mark.slow) for kind in KINDS)],
)
@pytest.mark.slow
def test_errors_are_told_as_they_are(kind: str, tolerances: tuple[float, ...], fineness: float) -> None:
    """Against order 5 on finer cells: between half and three times the true error, at every tolerance."""
    sensor, frequency = KINDS[kind]
    discs, omega, coil = coaxial_discs(sensor, 1 * MM), 2 * np.pi * frequency, sensor.coils[0]
    fine = divide_axis(discs, coil_sections(coil), frequency, fineness)
    exact = solve_axis(fine, discs, coil, omega, 5).flux
    for tolerance in tolerances:
        found = solved_axis(AxisymmetricFem(sensor, tolerance), discs, frequency)
        told, true = np.hypot(*found.errors[0]), abs(found.field.flux - exact)
        assert 0.5 * true < told < 3.0 * true, (tolerance, told / true)
        error_L, error_R = found.errors[0]
        off = found.field.flux - exact
        assert error_L > 0.5 * abs(off.real) and error_R > 0.5 * abs(off.imag)
        assert error_L <= tolerance * max(abs(exact.real), 0.1 * abs(exact)) * 1.01


@pytest.mark.slow
def test_a_fourth_order_gains_as_it_should() -> None:
    """On smaller cells order 3 is off by a fifth at most, and order 4 is far closer."""
    sensor, frequency = KINDS["steel"]
    discs, coil = coaxial_discs(sensor, 1 * MM), sensor.coils[0]
    coarse, fine = (divide_axis(discs, coil_sections(coil), frequency, each) for each in (1.0, 0.7))
    exact, *found = (
        solve_axis(lines, discs, coil, 2 * np.pi * frequency, order).flux
        for lines, order in ((fine, 5), (coarse, 3), (fine, 3), (coarse, 4))
    )
    wide, half, fourth = (abs(each - exact) for each in found)
    assert half < wide / 5 and fourth < wide / 5


def test_rings_find_the_same_of_copper() -> None:
    """The model of non-magnetic discs, by an integral equation: two discretisations, one answer."""
    sensor = load_sensor("biorob2018")
    coil = sensor.coils[0].model_copy(update={"centre": (0.0, 0.0)})
    sensor = scene(coil, target(4, 0.2, COPPER))
    pose = Pose(0.0, np.array([1.0, 3.0]) * MM)
    rings, cells = (each.impedance(pose, 1e5) for each in (axisymmetric(sensor, 1e-4), axisymmetric_fem(sensor, 1e-4)))
    np.testing.assert_allclose((cells.L - cells.L0), (rings.L - rings.L0), rtol=1e-4)
    np.testing.assert_allclose(cells.R, rings.R, rtol=5e-4)


@pytest.mark.slow
def test_permeability_begins_at_one_without_a_step() -> None:
    """A millionth above one, finite elements find what rings find at one."""
    pose, frequency = Pose(0.0, 1 * MM), 1e5
    steel, copper = (
        model(scene(SMALL, target(4, 0.2, 1e7, mu_r)), 1e-4)
        for model, mu_r in ((axisymmetric_fem, 1.0 + 1e-6), (axisymmetric, 1.0))
    )
    found, other = (change(model.impedance(pose, frequency)) for model in (steel, copper))
    assert abs(found - other) < 2e-4 * abs(other)


@pytest.mark.slow
def test_ferrite_without_conductivity_adds_inductance_and_no_loss() -> None:
    """More with more permeability; its losses are those of its permeability, by the derivative of L."""
    def of(mu_r: float, loss: float = 0.0) -> complex:
        sensor = scene(TEN, None, fixed(6, -0.6, 0.8, 1e-6, mu_r, loss))
        return change(axisymmetric_fem(sensor, 1e-2).impedance(Pose(0.0, 1 * MM), 1e5))

    weak, strong, less, more = of(2.0), of(500.0), of(0.99 * 20.0), of(1.01 * 20.0)
    assert 0.0 < weak.real < less.real < more.real < strong.real
    assert all(abs(each.imag) < 1e-9 * each.real for each in (weak, strong))
    lossy = of(20.0, 1e-2)
    assert lossy.imag == pytest.approx(-1e-2 * (more.real - less.real) / 0.02, rel=3e-3)


@pytest.mark.slow
def test_discs_dissipate() -> None:
    """R is positive for any of them, and the change of L never more than L0."""
    rng = np.random.default_rng(3)
    for _ in range(4):
        sigma, mu_r, frequency = 10 ** rng.uniform(0, 7.5), 10 ** rng.uniform(0.1, 3), 10 ** rng.uniform(3, 7)
        sensor = scene(TEN, target(rng.uniform(2, 9), rng.uniform(0.05, 2), sigma, mu_r))
        found = axisymmetric_fem(sensor, 1e-2).impedance(Pose(0.0, rng.uniform(0.3, 3) * MM), frequency)
        assert found.R[0, 0] > 0.0 and found.L[0, 0] > 0.0 and found.report.estimated_error <= 1e-2


@pytest.mark.slow
def test_a_ground_far_below_changes_nothing_and_a_pose_nothing_of_what_is_fixed() -> None:
    alone, grounded = scene(SMALL, target(4, 0.2, COPPER)), scene(SMALL, target(4, 0.2, COPPER), fixed(4, -90, 1, 1e7))
    pose = Pose(0.0, 1 * MM)
    near, far = (change(AxisymmetricFem(each, 1e-3).impedance(pose, 1e5)) for each in (alone, grounded))
    assert abs(near - far) < 1e-3 * abs(near)
    poses = Pose(0.0, np.array([[1.0, 2.0], [2.0, 2.0]]) * MM)
    still = axisymmetric_fem(scene(SMALL, None, fixed(4, -2, 0.5, 1.0, 100.0)), 1e-2).impedance(poses, 1e5)
    assert still.L.shape == (2, 2, 1, 1) and np.ptp(still.L) == 0.0 and still.report.iterations == 2
    moved = axisymmetric_fem(grounded, 1e-2).impedance(poses, 1e5)
    assert moved.L[0, 0] < moved.L[0, 1] == moved.L[1, 0] == moved.L[1, 1]


def test_what_is_off_the_axis_is_refused() -> None:
    """Poses in one line each; scenes by the part that is off, round or alone."""
    steel = axisymmetric_fem(scene(SMALL, target(4, 0.2, 1e7, 200.0)))
    for pose in (Pose(1 * MM, 2 * MM), Pose(0.0, 2 * MM, d_y=1 * MM)):
        with pytest.raises(ValueError, match="pose: the disc must be on the axis of coil C, it is 1 mm off$"):
            steel.impedance(pose, 1e6)
    with pytest.raises(ValueError, match="pose: alpha and alpha_x must be 0 on a coil's axis, got 5.73 deg$"):
        steel.impedance(Pose(0.0, 2 * MM, 0.1), 1e6)
    ferrite = fixed(4, -2, 0.5, 1.0, 100.0, 0.01)
    aside = ferrite.model_copy(update={"centre": (1 * MM, 0.0, -2 * MM)})
    with pytest.raises(SceneError, match=r"conductors.P.centre must be on the axis of coil C for .*; got 1 mm off$"):
        axisymmetric_fem(scene(SMALL, None, aside))
    other = SMALL.model_copy(update={"name": "D", "centre": (9 * MM, 0.0)})
    two = scene(SMALL, target(4, 0.2, 1e7, 200.0)).model_copy(update={"coils": (SMALL, other)})
    with pytest.raises(SceneError, match="coils must be one over coaxial discs for axisymmetric-fem; got 2$"):
        axisymmetric_fem(two)


def test_a_tolerance_out_of_reach_is_refused_with_what_is_reached() -> None:
    steel, many = target(30, 0.2, 1e7, 200.0), SMALL.model_copy(update={"turns": 100})
    with pytest.raises(SolveFailed, match="so close for its size, or the coil's, that more than the 200000 unknowns"):
        axisymmetric_fem(scene(many, steel)).impedance(Pose(0.0, 0.002 * MM), 1e6)
    with pytest.raises(ValueError, match="tolerance"):
        axisymmetric_fem(scene(SMALL, steel), 0.0)


@pytest.mark.slow
def test_cells_become_smaller_until_the_tolerance_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    """From a start that is too coarse; where no more fit, what is reached is told."""
    model, pose = axisymmetric_fem(scene(SMALL, target(4, 0.2, 1e7, 200.0)), 1e-3), Pose(0.0, 1 * MM)
    monkeypatch.setattr("sits_mech.magnetics.axis_fem._FIRST_POWER", -8.0)
    few = axisymmetric_fem(model.sensor, 3e-4).impedance(pose, 1e6)
    assert few.report.iterations > 2 and few.report.estimated_error <= 3e-4
    monkeypatch.setattr("sits_mech.magnetics.axis_fem._MOST_UNKNOWNS", 9000)
    with pytest.raises(SolveFailed, match=r"not reached with \d+ unknowns \(9000 fit\), the estimated error is .*e-0"):
        axisymmetric_fem(model.sensor, 1e-6).impedance(pose, 1e6)


@pytest.mark.slow
def test_inductance_of_steel_passes_through_zero() -> None:
    """Magnetised at low frequencies, shielding at high ones: both sides and the middle are answered."""
    model = axisymmetric_fem(scene(SMALL, target(4, 0.2, 1e7, 200.0)), 1e-2)
    found = [model.impedance(Pose(0.0, 1 * MM), frequency) for frequency in (1e3, 7.243e5, 1e7)]
    first, middle, last = (change(each).real for each in found)
    assert first > 0.0 > last and abs(middle) < 1e-3 * abs(last)
    assert found[1].report.unknowns < 15000  # as many as others ask
    assert all(each.error_L[0, 0] < 1e-2 * abs(change(each)) for each in found)
