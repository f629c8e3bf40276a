"""Several plates in three dimensions: against Dodd and Deeds' layers, against one plate, turned and exchanged."""

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change
from scipy.linalg import lu_factor

from sits_mech.geometry.collision import BoxedPart, Collision, placed_plates, separation
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space import neighbours
from sits_mech.magnetics.space.divisions import prepared, prepared_near
from sits_mech.magnetics.space.neighbours import SpacePlate, coupled_reactions
from sits_mech.magnetics.space.rungs import LADDER
from sits_mech.magnetics.space.sources import Posed, Sources
from sits_mech.quantities import Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Conductor, load_sensor

MM = 1e-3
COPPER = metals()["copper"].conductivity
REST = Pose(0.0, 2 * MM, 0.0)
LOOP = (
    'coils=[{name="C1", centre=["0 mm","0 mm"], layers=1, turns=1, inner_diameter="3.9 mm", track_width="0.1 mm", '
    'track_thickness="35 um"}]'
)
SIDES = np.array([[0.0, 0.0, 0.0], [0.0, np.pi, 0.0], [0.0, 0.0, np.pi / 2]])  # turned over; by a quarter


def plate(x, z, width, length=None, thickness=0.2, *, y=0.0, name="other", material="copper"):
    return Conductor(
        name=name, material=material, shape="rectangle", centre=(x * MM, y * MM, z * MM), width=width * MM,
        length=(length or width) * MM, thickness=thickness * MM,
    )


def scene(*parts, overrides=(), **changes):
    return load_sensor("biorob2018", overrides).model_copy(update={"conductors": parts, **changes})


def changes(sensor, pose=REST, frequency=5e6, tolerance=1e-2):
    z = sheets(sensor, tolerance).impedance(pose, frequency)
    return z.L - z.L0, z.R, z


BESIDE = plate(9.0, 2.6, 6.0, 4.0)


@pytest.mark.slow
def test_fixed_plate_without_target_is_a_target_in_its_place():
    """One sees the coils, the other polynomials of their fields, on cells of their own."""
    one, R, alone = changes(scene(), tolerance=5e-3)
    two, R2, z = changes(scene(plate(0.0, 2.1, 8.0), target=None), Pose(np.zeros(3), 2 * MM), tolerance=5e-3)
    np.testing.assert_allclose(two, two[:1].repeat(3, 0), rtol=1e-12)
    np.testing.assert_allclose(two[1], one, rtol=0, atol=(z.error_L[1] + alone.error_L).max())
    np.testing.assert_allclose(R2[1], R, rtol=0, atol=(z.error_R[1] + alone.error_R).max())
    assert z.report.notes[0].known["part"] == "conductors.other"


@pytest.mark.slow
def test_far_neighbour_changes_nothing():
    """But the division: within twice the errors of both, which are estimates and no bounds."""
    one, R, alone = changes(scene())
    two, R2, beside = changes(scene(plate(300.0, 0.0, 5.0)))
    np.testing.assert_allclose(two, one, rtol=0, atol=2 * (alone.error_L + beside.error_L).max())
    np.testing.assert_allclose(R2, R, rtol=0, atol=2 * (alone.error_R + beside.error_R).max())
    np.testing.assert_allclose(beside.L0, alone.L0, rtol=0)


@pytest.mark.slow
def test_layers_of_infinite_plates():
    """Two plates above one another, the nearer one translucent: Dodd and Deeds, less what 20 mm lack of infinity."""
    overrides = (LOOP, 'target={material="copper", shape="rectangle", width=0.02, length=0.02, thickness=1e-4}')
    sensor = scene(plate(0.0, 4.15, 20.0, thickness=0.1), overrides=overrides)
    layers = [Layer(COPPER, 0.1 * MM), Layer(0.0, 2.0 * MM), Layer(COPPER, 0.1 * MM)]
    exact = coil_change(coil_sections(sensor.coils[0]), 2 * MM, 2e4, layers)
    delta_L, R, _ = changes(sensor, frequency=2e4)
    assert delta_L[0, 0] == pytest.approx(float(exact.delta_L), rel=0.01)
    assert R[0, 0] == pytest.approx(float(exact.R), rel=0.02)


@pytest.mark.slow
def test_ground_plane_below_the_coil():
    sensor = scene(plate(0.0, -2.085, 20.0, thickness=0.1), overrides=(LOOP,), target=None)
    coil = sensor.coils[0]
    above = coil_sections(coil).mirrored()  # turned over, it fills 0 < z < height
    exact = coil_change(above, 2 * MM + coil.height, 2e4, [Layer(COPPER, 0.1 * MM)])
    delta_L, R, _ = changes(sensor, frequency=2e4)
    assert delta_L[0, 0] == pytest.approx(float(exact.delta_L), rel=0.01)
    assert R[0, 0] == pytest.approx(float(exact.R), rel=0.02)


@pytest.mark.slow
def test_plates_exchange_their_roles():
    """The target beside a fixed plate is the fixed plate beside the target."""
    overrides = ['target={material="copper", shape="rectangle", width=0.006, length=0.004, thickness="0.2 mm"}']
    one, R, z = changes(scene(BESIDE), tolerance=5e-3)
    two, R2, z2 = changes(scene(plate(0.0, 2.1, 8.0), overrides=overrides), Pose(9 * MM, 2.5 * MM), tolerance=5e-3)
    np.testing.assert_allclose(two, one, rtol=0, atol=(z.error_L + z2.error_L).max())
    np.testing.assert_allclose(R2, R, rtol=0, atol=(z.error_R + z2.error_R).max())


@pytest.mark.slow
def test_target_turned_onto_itself():
    model = sheets(scene(BESIDE), 1e-2)
    bottom = 2.1 * MM - 0.1 * MM * rotation_matrix(SIDES)[:, 2, 2]
    z = model.impedance(Pose(0.0, bottom, SIDES[:, 1], 0.0, SIDES[:, 0], SIDES[:, 2]), 5e6)
    np.testing.assert_allclose(z.L[1:], z.L[:1].repeat(2, 0), rtol=1e-5)
    np.testing.assert_allclose(z.R[1:], z.R[:1].repeat(2, 0), rtol=0, atol=1e-5 * z.R.max())


@pytest.mark.slow
def test_reciprocal_before_it_is_made_so_and_passive():
    sensor = scene(BESIDE, plate(-8.0, 3.5, 4.0, name="third"))
    tilt = np.array([[np.cos(0.1), 0.0, np.sin(0.1)], [0.0, 1.0, 0.0], [-np.sin(0.1), 0.0, np.cos(0.1)]])
    plates = placed_plates(sensor, tilt[None], np.array([[0.5 * MM, 0.0, 2.5 * MM]]))
    scale = (2.0**-10, 1e7, (9 * MM, 9 * MM), 1.5 * MM)
    target = prepared(plates[0].plate, LADDER[0][1], scale)
    fixed = [
        prepared_near(p.plate, LADDER[0][1], scale, Sources(sensor.coils, "rings", p.middle, p.windings))
        for p in plates[1:]
    ]
    ready = [SpacePlate(found[2:3], p.turns, p.places) for p, found in zip(plates[1:], fixed, strict=True)]
    seen = Posed(sensor.coils, "rings", plates[0].turns, plates[0].places)
    (Z,) = coupled_reactions(target[2:3], seen, ready, 5e6)
    np.testing.assert_allclose(Z, Z.swapaxes(1, 2), rtol=0, atol=1e-12 * np.abs(Z).max())
    assert np.linalg.eigvalsh(Z[0].real).min() > 0.0
    orders = ready, ready[::-1]
    (one, other) = (coupled_reactions((), seen, parts, 5e6)[0] for parts in orders)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(Z).max())


@pytest.mark.parametrize("strength", [0.1, 3.0, 100.0])
def test_what_comes_back_as_by_factors(strength):
    """Of one division and of another in its directions: off by the square of what is left, and symmetric."""
    rng, k, n = np.random.default_rng(65), 60, 3
    V, P = np.linalg.qr(rng.normal(size=(k, k)))[0], rng.normal(size=(k, 40)) / np.sqrt(40)
    S = np.diag(np.geomspace(1.0, 1e-4, 40)) * (1j - 0.2)
    together = neighbours._Together(np.zeros((n, n)), np.zeros((40, n)), ((slice(40), S),), lu_factor(np.eye(40)))
    h, found = rng.normal(size=(k, n)) + 1j * rng.normal(size=(k, n)), np.zeros((k, 0))
    for other in (1.0, 1.02):
        Y, B = strength * (V * np.geomspace(1.0, 1e-4, k) ** other) @ V.T * (0.3 + 1j), P @ S @ P.T
        back = B @ np.linalg.inv(np.eye(k) - Y @ B)
        found, value = neighbours._back(found, Y, P, together, h)
        off = neighbours._LEFT**2 * np.linalg.norm(h) ** 2 * np.linalg.norm(back, 2)
        np.testing.assert_allclose(value, h.T @ back @ h, rtol=0, atol=off)
        np.testing.assert_allclose(value, value.T, rtol=0, atol=1e-12 * np.abs(value).max())


def test_what_does_not_fit_is_refused_by_name():
    with pytest.raises(ValueError, match="conductors.other, C1"):
        sheets(scene(plate(-4.0, -0.1, 2.0)))
    with pytest.raises(ValueError, match="conductors.third, conductors.other"):
        sheets(scene(BESIDE, plate(9.0, 2.6, 1.0, name="third")))
    with pytest.raises(ValueError, match=r"conductors.other, C1 must .*got boxes that do"):
        sheets(scene(plate(-4.0, -0.05, 2.0, material="ferrite")))  # in the winding's plane
    with pytest.raises(Collision, match=r"target must stay clear of conductors.other"):
        sheets(scene(BESIDE), 1e-2).impedance(Pose(2.5 * MM, 2.5 * MM), 5e6)


def test_slab_between_boxes():
    c, s = np.cos(0.3), np.sin(0.3)
    box = BoxedPart("a", np.array([1.0, 2.0, 3.0]), np.eye(3)[None], np.zeros((1, 3)))
    turn = np.array([[[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]])
    turned = BoxedPart("b", np.ones(3), turn, np.array([[3.0, 0.0, 0.0]]))
    assert separation(box, turned) == pytest.approx(3.0 - 1.0 - (c + s))
    near = BoxedPart("c", np.ones(3), np.repeat(np.eye(3)[None], 2, 0), np.array([[1.5, 0.0, 0.0], [0.0, 0.0, 4.5]]))
    np.testing.assert_allclose(separation(box, near), [-0.5, 0.5])
