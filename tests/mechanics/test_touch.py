"""A touch on the rigid target: its wrench by statics, the pose that follows from its own wrench, and closed forms."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.closed_form import strip_layer
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.touch import check_places, contact_point, on_target, touch_wrench, touched
from sits_mech.quantities import Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import SceneError, load_sensor

SPHERE = {"shape": '"sphere"', "radius": '"5 mm"'}
PUNCH = {"shape": '"punch"', "width": '"2 mm"', "length": '"2 mm"'}
PRESSURE = PUNCH | {"shape": '"pressure"'}
STICKING = {"friction": '"sticking"'}


def sensor(touch, scene="biorob2018-w15", more=(), **place):
    """A scene with a touch, its place in mm."""
    keys = touch | {name: f'"{value} mm"' for name, value in place.items()}
    return load_sensor(scene, [*more, f"touch={{{', '.join(f'{key}={value}' for key, value in keys.items())}}}"])


def layer_of(scene):
    """The layer in plane strain, on its first meshes."""
    return planar_layer(scene, 1e-2).rough


def flush(touch, width=24.0, **place):
    """A flush strip, 2 mm of neo-Hooke's silicone, a hundred times as long as wide."""
    silicone = '{law="neo-hookean", shear_modulus="20 kPa", bulk_modulus="20 MPa"}'
    size = f'width="{width} mm", length="{100 * width} mm"'
    more = [
        f'elastomer={{material={silicone}, {size}, thickness="2 mm", contact="never"}}',
        f'target={{material="copper", shape="rectangle", {size}, thickness="0.5 mm"}}',
    ]
    return sensor(touch, "biorob2018", more, **place)


@pytest.mark.parametrize("touch", [SPHERE, PUNCH])
def test_what_is_guided_touches_where_its_surface_is_parallel_to_the_face(touch):
    """The sphere's centre is above its place and a radius off the plane; force and moment are along its normal."""
    scene, pose = sensor(touch, x=1.0, y=0.5), Pose(1e-4, 1.9e-3, 0.03, -2e-4, -0.05, 0.01)
    found = touch_wrench(scene, Wrench(F_z=2.0), pose.components)
    R, rho = rotation_matrix(pose.rotation), scene.touch.radius or 0.0
    n, middle = R[:, 2], pose.centre + scene.target.thickness * R[:, 2]
    place, normal = contact_point(scene, Wrench(F_z=2.0), pose)
    assert normal == pytest.approx(n, rel=1e-14)
    assert (place - middle) @ n == pytest.approx(0.0, abs=1e-17)
    assert (place + rho * n)[:2] == pytest.approx([1e-3, 0.5e-3], rel=1e-12)
    force = np.array([found.F_x, found.F_y, -found.F_z])
    assert np.cross(force, n) == pytest.approx(np.zeros(3), abs=1e-15) and found.F_z == 2.0
    assert [found.M_x, found.M, found.M_z] == pytest.approx(np.cross(place - middle, force), rel=1e-12)


@pytest.mark.parametrize("touch", [PRESSURE, PUNCH | STICKING, SPHERE | STICKING])
def test_what_stays_on_the_target_turns_with_it(touch):
    """A pressure's and a punch's middle keep their place; a sphere rolls by its radius times the tilt."""
    scene, pose = sensor(touch, x=1.0, y=0.5), Pose(1e-4, 1.9e-3, 0.03, -2e-4, -0.05, 0.0)
    R = rotation_matrix(pose.rotation)
    place, _ = contact_point(scene, Wrench(F_z=2.0), pose)
    own = R.T @ (place - pose.centre) - [0.0, 0.0, scene.target.thickness]
    rolled = (scene.touch.radius or 0.0) * R[:2, 2]
    assert own == pytest.approx([1e-3 - rolled[0], 0.5e-3 - rolled[1], 0.0], abs=1e-15)
    found = touch_wrench(scene, Wrench(F_z=2.0), pose.components)
    slides = scene.touch.friction == "none"
    assert (found.F_x, found.F_y) == (pytest.approx(tuple(-2.0 * R[:2, 2] / R[2, 2])) if slides else (0.0, 0.0))


def test_a_touch_in_the_middle_is_the_wrench_bit_for_bit():
    for touch in (SPHERE, PUNCH | STICKING, PRESSURE):
        scene = sensor(touch)
        found = touched(layer_of(scene), scene).equilibrium(Wrench(F_z=2.0))
        alone = layer_of(scene).equilibrium(Wrench(F_z=2.0))
        assert np.array_equal(found.pose.components, alone.pose.components)
        assert np.array_equal(found.error.components, alone.error.components)
        assert found.acting == Wrench(F_z=2.0)


def test_the_pose_follows_from_its_own_wrench():
    """Solved from the wrench that was found, the pose is the same within what was left, and nothing is doubled."""
    for touch in (SPHERE, SPHERE | STICKING, PRESSURE):
        scene = sensor(touch, x=2.0)
        layer = layer_of(scene)
        found = touched(layer, scene).equilibrium(Wrench(F_z=3.0))
        again = layer.equilibrium(touch_wrench(scene, Wrench(F_z=3.0), found.pose.components))
        off = np.abs(again.pose.components - found.pose.components)
        assert np.all(off <= 0.25 * again.error.components)
        dead = layer.equilibrium(*on_target(scene, [Wrench(F_z=3.0)]))
        assert np.abs(dead.pose.components - found.pose.components)[2] > 5.0 * off[2]


def test_a_thin_layer_tilts_by_its_compliance_in_tilt():
    """Small loads off the middle of a flush strip: alpha = x F/k_a, sink = F/k_z, of `strip_layer`'s closed form."""
    x, F = 3e-3, 1e-3
    scene = flush(SPHERE, x=1e3 * x)
    found = touched(linear_layer(scene, 1e-3), scene).equilibrium(Wrench(F_z=F))
    k_x, k_z, k_a = strip_layer(scene).stiffness
    assert found.pose.alpha == pytest.approx(x * F / k_a, rel=0.06)
    assert found.pose.d_v == pytest.approx(2e-3 - F / k_z, abs=0.032 * F / k_z)
    exact = linear_layer(scene, 1e-3).equilibrium(Wrench(F_z=F, M=x * F)).pose
    assert found.pose.alpha == pytest.approx(exact.alpha, rel=1e-3)


def test_mirrored_touches_lead_to_mirrored_poses():
    left, right = (sensor(SPHERE, x=x) for x in (-2.0, 2.0))
    q, p = (touched(layer_of(each), each).equilibrium(Wrench(F_z=2.0)).pose for each in (left, right))
    assert (q.d_h, q.d_v, q.alpha) == pytest.approx((-p.d_h, p.d_v, -p.alpha), rel=1e-9)


@pytest.mark.slow
def test_a_quarter_turn_of_a_square_turns_the_pose():
    """On a square pad a touch at (0, y) is that at (y, 0) turned, within the errors of both meshes."""
    square = [f'{part}.{side}="8 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    poses = []
    for place in ({"x": 1.5}, {"y": 1.5}):
        scene = sensor(SPHERE, "biorob2018", square, **place)
        poses.append(touched(block_pad(scene, 5e-2).rough, scene).equilibrium(Wrench(F_z=0.5)))
    along, across = (each.pose for each in poses)
    within = poses[0].error.components + poses[1].error.components[[3, 1, 4, 0, 2, 5]]
    turned = np.array([across.d_y, across.d_v, -across.alpha_x, 0.0, 0.0, 0.0])
    assert np.all(np.abs(along.components - turned)[:3] <= within[:3])
    assert abs(across.alpha_x) > 20.0 * poses[1].error.alpha_x


def test_a_load_about_the_touched_point_with_moments_touches_elsewhere():
    at_once, shifted = sensor(SPHERE, x=2.0), sensor(SPHERE, x=0.5)
    load = Wrench(F_z=2.0)
    one = touched(layer_of(at_once), at_once).equilibrium(load)
    other = touched(layer_of(shifted), shifted).equilibrium(Wrench(F_z=2.0, M=1.5e-3 * 2.0))
    assert other.pose.components == pytest.approx(one.pose.components, rel=1e-12)


class Springs:
    """A layer of two springs: by shear [m/N], and by tilt [rad/(N m)]."""

    def __init__(self, shear, tilt):
        self.shear, self.tilt, self.solves = shear, tilt, 0

    def equilibrium(self, wrench, *, start=None):
        self.solves += 1
        pose = Pose(self.shear * wrench.F_x, 1e-3, self.tilt * wrench.M)
        return Equilibrium(wrench, pose, Pose(0.0, 0.0, 0.0), np.zeros(0), SolveReport("springs", 2, 1, 0.0, 0.0, 0.0))


def test_a_guided_touch_on_springs_is_found_to_rounding():
    """alpha = C_a M and d_h = C_x F_x with the touch's own F_x = -F tan(alpha), M = F r_x (1 + tan^2(alpha))."""
    scene, F = sensor(SPHERE, x=2.0), 2.0
    layer = Springs(2e-3, 10.0)
    found = touched(layer, scene).equilibrium(Wrench(F_z=F)).pose
    slope, h = np.tan(found.alpha), scene.target.thickness
    r_x = 2e-3 - 5e-3 * np.sin(found.alpha) - found.d_h - h * np.sin(found.alpha)
    assert found.d_h == pytest.approx(-2e-3 * F * slope, rel=1e-5)
    assert found.alpha == pytest.approx(10.0 * F * r_x * (1.0 + slope**2), rel=1e-5)
    assert layer.solves <= 6


def test_what_slides_off_the_target_is_refused_with_its_place():
    """The face turns, and the touch pushes the target away from under itself."""
    scene = sensor(SPHERE | {"radius": '"0.1 mm"'}, x=7.4)
    with pytest.raises(SolveFailed, match="touch: slides off the target, to x = 7.[5-9]"):
        touched(Springs(1e-2, 2.0), scene).equilibrium(Wrench(F_z=1.0))


def test_a_rest_that_the_touch_does_not_hold_is_refused():
    """What tilts sends the target aside, which tilts it by more: the rest at alpha = 0.5/(1 - 500) is not stable."""
    scene = sensor(PUNCH | {"width": '"0.1 mm"', "length": '"0.1 mm"'}, x=1.0)
    with pytest.raises(SolveFailed, match="touch: no stable pose"):
        touched(Springs(1.0, 500.0), scene).equilibrium(Wrench(F_z=1.0))


@pytest.mark.parametrize(("touch", "load", "words"), [
    (SPHERE, Wrench(F_x=0.1, F_z=1.0), 'touch.friction: must be "sticking" for shear'),
    (SPHERE, Wrench(F_z=-1.0), 'touch.friction: must be "sticking" for shear'),
    (SPHERE, Wrench(F_z=1.0, M=0.02), "touch: must lie on the target, a rectangle 15 mm x 8 mm, .* x = 20 mm"),
])
def test_loads_that_a_touch_does_not_have_are_refused(touch, load, words):
    scene = sensor(touch)
    with pytest.raises(SceneError, match=words):
        touched(layer_of(scene), scene).equilibrium(load)


@pytest.mark.parametrize(("shape", "taken", "refused"), [
    ('shape="sphere", radius="0.3 mm"', 0.86, 0.87),
    ('shape="cylinder", radius="0.1 mm", length="30 mm", axis="x"', 9.6, 9.7),
])
def test_what_a_cover_swallows_is_refused(shape, taken, refused):
    """By Hertz's areas as wide as the shape: 16/3 mu R^2, and pi mu R over 17 mm, from ten times as much on."""
    cover = 'cover={material={E="540.54 kPa", nu=0.4995}, thickness="1 mm", overhang="1 mm"}'
    scene = load_sensor("biorob2018-w15", [f"touch={{{shape}}}", cover])
    check_places(scene, {"F_z": [0.0, taken]})
    with pytest.raises(SceneError, match="touch.radius: must be some .* mm or more under .* N, or what presses sinks"):
        check_places(scene, {"F_z": [refused]})
