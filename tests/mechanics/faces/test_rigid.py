"""Contact of a rigid shape with a cover: depths, a sphere beside another code and closed forms, pressures, places."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.faces.rigid import Rigid
from sits_mech.mechanics.layer import axisymmetric_pad
from sits_mech.mechanics.touch import touched
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor

SHAPES = {
    "sphere": Rigid((0.0,), 2.0, (0.1, -0.2, 0.3)),
    "cylinder": Rigid((0.0, 1e9), 1.5),
    "punch": Rigid((1.0, 0.7), 0.2),
    "round punch": Rigid((1.0,), 0.2),
}
# NGSolve, studies/common/ngsolve_cover_touch.py, "wide sphere", penalties extrapolated: depth, force, sink [mm, N, mm]
REFERENCE = [(0.1, 0.17952, 0.012538), (0.2, 0.66569, 0.045440), (0.33, 1.62009, 0.106191)]


def covered(mu, sizes, touch):
    """Return a disc on a cylinder under a cover: pad, thick, target, rim, over, hang [mm], moduli (2,) [kPa]."""
    wide, thick, target, rim, over, hang = sizes
    law = 'material={{law="neo-hookean", shear_modulus="{} kPa", bulk_modulus="{} MPa"}}'
    return load_sensor("biorob2018", [
        f'target={{material="copper", shape="disc", diameter="{2 * target} mm", thickness="{rim} mm"}}',
        f'elastomer={{diameter="{2 * wide} mm", thickness="{thick} mm", {law.format(mu[0], mu[0])}}}',
        f'cover={{thickness="{over} mm", overhang="{hang} mm", {law.format(mu[1], mu[1])}}}',
        f"touch={{{touch}}}",
    ])


WIDE = (6, 2, 4, 0.2, 1, 1.5)
SPHERE = 'shape="sphere", radius="10 mm"'


def pressed(sensor, F, model=axisymmetric_pad, tolerance=1e-2, **more):
    return touched(model(sensor, tolerance), sensor).equilibrium(Wrench(F_z=F, **more))


@pytest.mark.parametrize("name", SHAPES)
def test_depths_have_the_slopes_that_differences_show(name):
    """Outside of the core, at random places around the surface; a unit slope everywhere."""
    shape, places = SHAPES[name], np.random.default_rng(0).uniform(-1.5, 1.5, (40, 3))
    places = places[np.abs(shape(places)[0] - shape.radius) > 1e-3]
    _, slope, curvature = shape(places)
    assert np.allclose(np.linalg.norm(slope, axis=1), 1.0)
    for k, step in enumerate(1e-6 * np.eye(3)):
        (d, s, _), (e, t, _) = shape(places + step), shape(places - step)
        assert np.allclose((d - e) / 2e-6, slope[:, k], atol=1e-6)
        assert np.allclose((s - t) / 2e-6, curvature[:, k], atol=1e-4)


def test_a_sphere_on_a_covered_disc_is_that_of_another_code():
    """Depth and sink at a fifth of the cover; two percent are wanted."""
    sensor = covered((30, 90), WIDE, SPHERE)
    for depth, F, sink in REFERENCE[1:2]:
        found = pressed(sensor, F)
        assert found.sunk[0] == pytest.approx(1e-3 * depth, rel=6e-3)
        assert 2e-3 - found.pose.d_v == pytest.approx(1e-3 * sink, rel=2e-3)
        assert abs(2e-3 - found.pose.d_v - 1e-3 * sink) < found.error.d_v


@pytest.mark.slow
@pytest.mark.parametrize("depth, F, sink", REFERENCE)
def test_a_sphere_at_all_depths_and_in_space(depth, F, sink):
    """About the axis as above; by half the pad the pose within 1.5 percent, and its error covers it."""
    sensor = covered((30, 90), WIDE, SPHERE)
    for model, off in ((axisymmetric_pad, 6e-3), (block_pad, 2e-2)):
        found = pressed(sensor, F, model, 3e-2)
        assert found.sunk[0] == pytest.approx(1e-3 * depth, rel=off)
        assert 2e-3 - found.pose.d_v == pytest.approx(1e-3 * sink, rel=1.5e-2)


@pytest.mark.slow
def test_a_thick_soft_cover_is_the_half_space_of_hertz():
    """A small sphere, a contact radius of 1/14 of its own and 1/140 of the cover: F = 4/3 E* R^(1/2) d^(3/2)."""
    sensor = covered((30, 30), (20, 20, 2, 0.4, 20, 18), 'shape="sphere", radius="2 mm"')
    mu, K = 30e3, 30e6
    E, d = 4 * mu * (3 * K + mu) / (3 * K + 4 * mu), 2e-5
    found = pressed(sensor, 4 / 3 * E * np.sqrt(2e-3) * d**1.5)
    assert found.sunk[0] - (2e-2 - found.pose.d_v) == pytest.approx(d, rel=0.05)
    assert abs(found.sunk[0] - (2e-2 - found.pose.d_v) - d) < found.sunk[1]


@pytest.mark.slow
def test_a_thin_cover_is_the_bonded_layer():
    """Johnson, section 5.8, about an axis: F = 2 pi mu R^2 d^3/h^3 of an incompressible layer, but for h/a = 1/15."""
    sensor = covered((3000, 30), (6, 2, 5, 0.5, 0.2, 0.5), 'shape="sphere", radius="200 mm"')
    R, h, a, mu = 0.2, 2e-4, 3e-3, 30e3
    d = a**2 / (4 * R)
    found = pressed(sensor, 2 * np.pi * mu * R**2 * (d / h) ** 3)
    assert found.sunk[0] - (2e-3 - found.pose.d_v) == pytest.approx(d, rel=h / a)


@pytest.mark.slow
def test_what_presses_elsewhere_tilts_the_target_as_its_mirror_image_does():
    """A pressure on half the pad: at the image of a place it tilts the other way."""
    sensor = covered((30, 90), WIDE, 'shape="pressure", diameter="2 mm"')
    model = touched(block_pad(sensor, 0.1).rough, sensor)
    right, left, middle = (model.equilibrium(Wrench(F_z=1e-3, M=x * 1e-6)) for x in (1.0, -1.0, 0.0))
    assert right.pose.alpha == pytest.approx(-left.pose.alpha, rel=1e-6) and right.pose.alpha > 0.0
    assert right.pose.d_v == pytest.approx(left.pose.d_v, abs=1e-12)
    assert middle.pose.alpha == pytest.approx(0.0, abs=1e-9)
    assert right.sunk is None


def test_a_pressure_is_what_reciprocity_says_of_a_small_load():
    """It moves the target by its work on the field of a unit force on the target: 0.1 mN over 3 mm, on one mesh."""
    sensor = covered((30, 90), WIDE, 'shape="pressure", diameter="3 mm"')
    body, load = axisymmetric_pad(sensor, 1e-2).line[0].fine, np.array([0.0, 1e-5, 0.0])
    bare = replace(body, press=None, shared=None)
    ended = [advance(each, rest(each), Path((0.0 * load, load))) for each in (body, bare)]
    found, own = (each.state for each in ended)
    forces = body.press(0.0 * own.u, load, np.nan).forces[: own.u.size]
    assert forces[1::2].sum() == pytest.approx(1e-5) and not any(each.reason for each in ended)
    assert -found.q[1] == pytest.approx(-float(forces @ own.u) / 1e-5, rel=1e-4)
