"""Far conductors: the bound lies above what the models say that they do, and not far above where nothing else is."""

import numpy as np
import pytest

from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.coils.far_field import body_around
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.omitted.remote import _kappa, _solved, remote_bounds
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Conductor, Sensor, load_sensor

MM = 1e-3
REST = Pose(0.0, 2 * MM)
BARE = load_sensor("biorob2018").model_copy(update={"elastomer": None})
COILS = BARE.model_copy(update={"target": None})


def nut(x, z, *, y=0.0, size=(2.0, 2.0, 0.5), name="nut", material="copper"):
    """A plate, in millimetres."""
    width, length, thickness = (MM * side for side in size)
    return Conductor(
        name=name, material=material, shape="rectangle", centre=(x * MM, y * MM, z * MM), width=width, length=length,
        thickness=thickness,
    )


def with_parts(sensor: Sensor, *parts: Conductor) -> Sensor:
    return sensor.model_copy(update={"conductors": parts})


def effect(model, sensor, parts, pose=REST, frequency=5e6):
    """What parts change of L at most, over the largest self-inductance, by a model.

    Sheets divide a target among other plates more coarsely than one alone, within their errors, which exceed what a
    nut does: there, parts are compared with the same ones 0.2 m aside.
    """
    aside = [part.model_copy(update={"centre": (part.centre[0] + 0.2, *part.centre[1:])}) for part in parts]
    less = model(with_parts(sensor, *aside) if model is sheets else sensor, 1e-2).impedance(pose, frequency)
    more = model(with_parts(sensor, *parts), 1e-2).impedance(pose, frequency)
    return float(np.abs(more.L - less.L).max() / less.L0.max())


def bound(sensor, parts, pose=REST, **asked):
    return float(remote_bounds(sensor, parts, pose, **asked).sum())


FAR_NUTS = ((14.0, -1.0), (20.0, 0.3), (0.0, -15.0), (60.0, 40.0))


@pytest.mark.slow
@pytest.mark.parametrize(("x", "z"), [(0.0, -5.0), *FAR_NUTS])
def test_bound_on_a_nut_beside_coils(x, z):
    """2.5 to 10 times what sheets say: it is a box in an ellipsoid, a perfect conductor, and near ones in a ball."""
    true = effect(sheets, COILS, [nut(x, z)])
    assert 2.5 * true < bound(COILS, [nut(x, z)]) < 10.0 * true


PLACES = np.random.default_rng(7).uniform(-1.0, 1.0, (12, 6))


def anywhere(some, material):
    """A plate of 3 to 20 mm below, beside or above the coils, 1.6 to 3.5 of its radii away."""
    size = (11.5 + 8.5 * some[0], 11.5 + 8.5 * some[1], float(np.exp(0.2 + 1.4 * some[2])))
    away = (2.55 + 0.95 * some[3]) * np.hypot(*size[:2]) / 2
    if abs(some[5]) < 0.3:
        angle = np.pi * some[4]
        x, y, z = (away + 8.0) * np.cos(angle), (away + 8.0) * np.sin(angle), 10.0 * some[5]
    else:
        x, y, z = 8.0 * some[4], 6.0 * some[3], away + 6.0 if some[5] > 0.0 else -away - 2.0
    return nut(x, z, y=y, size=size, material=material)


@pytest.mark.slow
@pytest.mark.parametrize("material", ["ferrite", "copper"])
@pytest.mark.parametrize("place", [2, 3, 7])  # above, below, beside
def test_bounds_anywhere(place, material):
    """With a target and without, none below the truth; of ferrite within 3 of it."""
    part = anywhere(PLACES[place], material)
    for sensor in (COILS, BARE):
        true, most = effect(sheets, sensor, [part]), bound(sensor, [part])
        assert (0.33 if material == "ferrite" else 0.03) * most < true < most


@pytest.mark.slow
@pytest.mark.parametrize(("x", "z"), [(14.0, -1.0), (14.0, 5.0), (30.0, 0.3), (0.0, -15.0)])
def test_bound_on_a_nut_beside_coils_and_target(x, z):
    """The target answers too, and is bounded by less than it is: up to 60 times what sheets say."""
    true = effect(sheets, BARE, [nut(x, z)])
    assert 2.0 * true < bound(BARE, [nut(x, z)]) < 60.0 * true


@pytest.mark.slow
def test_bound_on_nuts_together():
    """Two beside each other, a third elsewhere, under a tilted target; touching balls have no bound."""
    parts = [nut(20.0, -3.0), nut(26.0, -3.0, name="second"), nut(-18.0, 4.0, name="third")]
    pose = Pose(1 * MM, 2 * MM, 0.1)
    assert bound(BARE, parts, pose) > effect(sheets, BARE, parts, pose)
    assert bound(BARE, parts, pose) > sum(bound(BARE, [part], pose) for part in parts)
    assert bound(BARE, [parts[0], nut(22.5, -3.0, name="second")], pose) == np.inf


@pytest.mark.slow
def test_bound_beside_what_is_solved():
    """A plate below takes part in what the nut sees; further away other fields of the plate change L by 2e-7."""
    ground, far = nut(0.0, -2.5, size=(6.0, 6.0, 0.2), name="ground"), nut(12.0, -5.0)
    sensor = with_parts(BARE, ground)
    less, more = (sheets(each, 1e-2).impedance(REST, 5e6) for each in (sensor, with_parts(BARE, ground, far)))
    true = float(np.abs(more.L - less.L).max() / less.L0.max())
    assert true < bound(sensor, [far]) < 10.0 * true
    assert bound(sensor, [nut(6.0, -5.0)]) == np.inf


@pytest.mark.parametrize("x", [20.0, 60.0])
def test_bound_in_section(x):
    """Endless along y: of copper by bars, and without a target not far above."""
    part = nut(x, -4.0)
    alone, among = effect(planar_bars, COILS, [part]), effect(planar_bars, BARE, [part])
    # sharp corners and a flat plate are less than the circle around them
    assert alone < bound(COILS, [part], section=True) < 4.0 * alone
    assert among < bound(BARE, [part], section=True)
    assert bound(BARE, [part], section=True) > bound(BARE, [part])


def test_bound_on_ferrite_in_section():
    """What adds to L; out of the section it is bounded in space alone."""
    part = nut(12.0, -6.0, size=(3.0, 3.0, 3.0), material="ferrite")
    true = effect(planar_fem, COILS, [part])
    assert true < bound(COILS, [part], section=True) < 4.0 * true
    aside = nut(12.0, -6.0, y=40.0, material="ferrite")
    assert bound(COILS, [aside], section=True) == bound(COILS, [aside])


def test_near_ones_have_no_bound():
    """In a coil's reach, and in the target's ball; many poses at once, the nearest has none."""
    assert bound(COILS, [nut(8.0, -0.6)]) == np.inf
    assert bound(BARE, [nut(4.5, 4.0)]) == np.inf
    poses = Pose(np.array([0.0, 15.0]) * MM, np.full(2, 2 * MM))
    found = remote_bounds(BARE, [nut(20.0, 3.0)], poses)
    assert bound(BARE, [nut(30.0, 0.3)]) == pytest.approx(bound(COILS, [nut(30.0, 0.3)]), rel=1e-2)  # metal opposes
    assert found.shape == (2, 1) and found[0, 0] < np.inf and found[1, 0] == np.inf


def test_bodies_by_hand() -> None:
    """A thin disc across the field has 8/3 a^3 and no less, a ball of a plate never less than the plate."""
    disc = Conductor(
        name="d", material="copper", shape="disc", centre=(0.0, 0.0, -0.1), diameter=2e-2, thickness=1e-7
    )
    across = body_around(disc).alpha[:, 2].min()
    assert 8.0 / 3.0 * 1e-6 < across < 1.1 * 8.0 / 3.0 * 1e-6
    cube = body_around(nut(0.0, -9.0, size=(2.0, 2.0, 2.0)))
    ball = 2.0 * np.pi * cube.radius**3  # 3/2 of its volume
    assert cube.alpha.max(axis=1).min() == pytest.approx(ball, rel=0.1)
    core = body_around(nut(0.0, -9.0, size=(2.0, 2.0, 2.0), material="ferrite"))
    assert core.alpha.max(axis=1).min() == pytest.approx(2.0 * ball, rel=0.1)  # 3 of its volume


@pytest.mark.parametrize("parts", [
    [nut(200.0, -30.0)], [nut(0.0, 150.0, material="ferrite"), nut(-90.0, 0.0, y=200.0, name="second")],
])
@pytest.mark.parametrize("section", [False, True])
def test_closed_forms_alone_lie_above_what_is_integrated(parts, section):
    """By up to 100 times, for many poses at once; where they do not do, the better bound comes as ever."""
    poses = Pose(np.array([0.0, 3.0]) * MM, np.array([2.0, 5.0]) * MM)
    full = remote_bounds(BARE, parts, poses, section=section)
    quick = remote_bounds(BARE, parts, poses, section=section, enough=1.0)
    assert np.all(full <= quick) and np.all(quick < 100.0 * full) and (section or np.all(full < quick))
    np.testing.assert_array_equal(remote_bounds(BARE, parts, poses, section=section, enough=1e-30), full)


@pytest.mark.slow
@pytest.mark.parametrize(("pose", "most"), [(Pose(0.0, 15 * MM), 120.0), (Pose(0.0, 60 * MM, 0.3), 30.0)])
def test_what_the_target_and_a_ring_feel_of_each_other(pose, most):
    """A ring of 2 mm is one current that a plate of 2 mm can carry: Delta L/L of it is below kappa squared."""
    ring = (
        'coils=[{name="R", centre=["0 mm", "0 mm"], layers=1, turns=1, inner_diameter="1.4 mm", track_width="0.3 mm", '
        'track_thickness="0.4 mm"}]'
    )
    sensor = load_sensor("biorob2018", [ring]).model_copy(update={"elastomer": None})
    found = sheets(sensor, 1e-2).impedance(pose, 5e6)
    true = float((found.L0 - found.L)[0, 0] / found.L0[0, 0])
    part = nut(0.0, -0.2, size=(2.0, 2.0, 0.4))
    square = float(_kappa(body_around(part), np.array(part.centre), _solved(sensor, pose))[0]) ** 2
    assert true < square < most * true
