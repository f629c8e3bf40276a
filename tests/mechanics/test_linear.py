"""Small strain: stiffnesses of pads against independent codes, the nonlinear model within the error, refusals."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer, linear_pad, small_strain
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import Elastomer, Target, load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
SQUARE = ['target.width="15 mm"', 'target.length="15 mm"']


def box(*more):
    """A pad of 20 x 20 x 2 mm under 15 x 15 mm; the force acts at the bonded face."""
    return load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN, *SQUARE, *more])


def cylinder():
    """A cylinder 15 mm across and 2 mm high under a disc as wide."""
    base = box()
    plate = {"shape": "disc", "material": "copper", "diameter": 15 * MM, "thickness": 0.2 * MM, "load_height": 0.0}
    layer = {"material": base.elastomer.material, "diameter": 15 * MM, "thickness": 2 * MM}
    parts = {"target": Target.model_validate(plate), "elastomer": Elastomer.model_validate(layer)}
    return base.model_copy(update=parts)


def off(pad, known):
    """By how much kx, kz, the coupling and ka are off, over the root of both stiffnesses on the diagonal; the error."""
    found, error = pad.stiffness
    np.testing.assert_allclose(found, found.T, atol=1e-7 * found[1, 1])
    kx, kz, kxa, ka = known
    away = np.array([found[0, 0] / kx - 1.0, found[1, 1] / kz - 1.0, found[2, 2] / ka - 1.0])
    return np.append(away, (found[0, 2] - kxa) / np.sqrt(kx * ka)), error


# NGSolve 6.2 (Q2/Q1 and Q3/Q2 on graded hexahedra) and FElupe 11.3: N/m, N/m, N/rad, N m/rad; to 0.1 %.
BOX = (4.482e3, 120.67e3, 6.915, 1.0695)
# The same codes, to 1e-4; kxa is -kx t/2, as the pad is its own image under a half turn.
CYLINDER = (2567.33, 60579.0, -2.56733, 0.386547)


@pytest.mark.slow
@pytest.mark.parametrize("asked", [1e-2, 1e-3])
def test_stiffness_of_a_box(asked):
    """The coupling hangs on the foot of the sides, 1.25 thicknesses away, where the mesh is not graded."""
    away, error = off(linear_pad(box(), asked), BOX)
    assert np.all(np.abs(away[:3]) < asked) and error <= asked
    assert abs(away[3]) < 1.5 * asked


@pytest.mark.slow
def test_stiffness_of_a_cylinder():
    """At 1e-3 within that; the coupling is exact on every mesh, as the cylinder's ends are alike."""
    pad = linear_pad(cylinder(), 1e-3)
    away, error = off(pad, CYLINDER)
    assert np.all(np.abs(away) < 1e-3) and error <= 1e-3
    k, _ = pad.stiffness
    assert k[0, 2] == pytest.approx(-k[0, 0] * 1 * MM, rel=1e-6)


@pytest.mark.slow
def test_stiffness_of_a_cylinder_as_exact_as_the_reference():
    away, error = off(linear_pad(cylinder(), 1e-4), CYLINDER)
    assert np.all(np.abs(away) < 1e-4) and error <= 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrench",
    [*(pytest.param(load, marks=pytest.mark.slow) for load in (Wrench(1e-3, 5e-3, 1e-6), Wrench(0.02, 0.1))),
     Wrench(0.1, 0.5, 1e-4)],
)
def test_small_loads_are_those_of_finite_strain(wrench):
    """From millinewtons to where strains are some permille: the error tells what is left out."""
    sensor = box()
    small, full = linear_pad(sensor, 1e-2).equilibrium(wrench), block_pad(sensor, 1e-2).equilibrium(wrench)
    lever = np.array([1.0, 1.0, 7.5 * MM])
    away = np.abs(small.pose.components - full.pose.components)[:3] * lever
    allowed = (small.error.components + full.error.components)[:3] * lever
    assert np.max(away) < np.max(allowed)
    assert small.report.model == "linear" and small.report.estimated_error < 0.03


@pytest.mark.parametrize("make", [small_strain, planar_layer])
@pytest.mark.parametrize("load", [Wrench(F_z=1e-12), Wrench(F_x=1e-12)])
def test_the_smallest_loads_are_answered_as_well_as_larger_ones(make, load):
    """The error is over the displacement, and rounding is not in it: 1e-12 N and 1e-6 N alike."""
    model = make(load_sensor("biorob2018"), 1e-2)
    least, more = (model.equilibrium(each) for each in (load, Wrench(1e6 * load.F_x, 1e6 * load.F_z)))
    assert least.report.estimated_error == pytest.approx(more.report.estimated_error, rel=1e-4)
    assert least.error.components == pytest.approx(1e-6 * more.error.components, rel=1e-4)


@pytest.mark.slow
def test_what_a_press_changes_of_a_tilt_is_in_its_error():
    """Pressed by 3 % the pad tilts by a third less under shear than one compliance says."""
    sensor, wrench = load_sensor("biorob2018"), Wrench(0.05, 0.5)
    small, full = linear_pad(sensor, 1e-3).equilibrium(wrench), block_pad(sensor, 1e-3).equilibrium(wrench)
    away = np.abs(small.pose.components - full.pose.components)[:3]
    assert np.all(away < small.error.components[:3] + 0.1 * full.error.components[:3])
    assert away[2] > 0.3 * abs(full.pose.alpha)


@pytest.mark.slow
def test_answers_are_proportional_and_errors_grow_with_the_load():
    pad = linear_pad(box(), 1e-2)
    one, two = (pad.equilibrium(Wrench(F, 5.0 * F)) for F in (1e-3, 0.1))
    assert two.pose.d_h == pytest.approx(100.0 * one.pose.d_h, rel=1e-9)
    assert 2 * MM - two.pose.d_v == pytest.approx(100.0 * (2 * MM - one.pose.d_v), rel=1e-9)
    assert one.report.estimated_error < two.report.estimated_error
    assert pad.equilibrium(Wrench()).pose.d_v == 2 * MM


@pytest.mark.slow
def test_loads_that_are_not_small_are_refused():
    pad = linear_pad(box(), 1e-2)
    with pytest.raises(SolveFailed, match="too large for one compliance, got Wrench") as caught:
        pad.equilibrium(Wrench(5.0, 60.0))
    assert caught.value.report.status == "strains too large"
    with pytest.raises(ValueError, match="finite"):
        pad.equilibrium(Wrench(np.nan))
    with pytest.raises(ValueError, match="F_y"):
        pad.equilibrium(Wrench(F_y=1e-3))


@pytest.mark.slow
def test_a_long_pad_is_in_plane_strain_and_a_short_one_in_space():
    long = box('elastomer.length="1 m"', 'target.length="1 m"')
    assert len(small_strain(long).levels.coarse.mesh.axes) == 2
    assert len(small_strain(box()).levels.coarse.mesh.axes) == 3


@pytest.mark.parametrize(
    ("width", "target", "known"),
    [(8, 8, 2.687388), *(pytest.param(20, *row, marks=pytest.mark.slow) for row in ((15, 2.940256), (8, 2.948483)))],
)
def test_the_rise_of_a_layer_that_would_be_larger(width, target, known):
    """NGSolve 6.2, orders 4 and 3 on triangles, two meshes within 2e-6 (studies/common/ngsolve_rise.py): to 1e-5.

    The volume of a stretch of 1e-4 is 1.0001 times three of it.
    """
    sizes = [f'elastomer.width="{width} mm"', f'target.width="{target} mm"', "elastomer.free_stretch=1.0001"]
    sensor = load_sensor("biorob2018", [NEO_HOOKEAN, *sizes])
    found = linear_layer(sensor, 1e-4).equilibrium(Wrench())
    assert (found.pose.d_v / (2 * MM) - 1.0) / 1e-4 == pytest.approx(1.0001 * known, rel=2e-5)
    assert found.pose.d_h == pytest.approx(0.0, abs=1e-12) and found.pose.alpha == pytest.approx(0.0, abs=1e-10)
