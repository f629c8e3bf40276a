"""Depths of a touch: the force that leads to one, beside another code, a closed form and itself, and its errors."""

import numpy as np
import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.pressing import touch_load
from sits_mech.chain.simulate import simulate
from sits_mech.mechanics.depth import depth_of
from sits_mech.mechanics.touch import bare
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import SceneError, load_sensor
from tests.mechanics.faces.test_rigid import REFERENCE, SPHERE, WIDE, covered
from tests.mechanics.test_touch import SPHERE as BALL
from tests.mechanics.test_touch import sensor


def test_what_sticks_beside_the_middle_presses_as_statics_and_the_stiffnesses_say():
    """d = F (1/k_z + x^2/k_a) at the touched point, alpha = x F/k_a, at small loads; errors are smaller."""
    x, D = 3e-3, 1e-7
    scene = sensor(BALL | {"depth": '"0.1 um"', "friction": '"sticking"'}, x=1e3 * x)
    found = touch_load(scene, mechanics="linear", tolerance=0.2)
    model = mechanical_model(scene, "linear", 0.2)[0]
    under = model.equilibrium(found.wrench)
    unit = [bare(model).equilibrium(Wrench(F_z=1e-3, M=M)).pose for M in (0.0, 1e-3)]
    k_z, k_a = 1e-3 / (2e-3 - unit[0].d_v), 1e-3 / unit[1].alpha
    assert found.wrench.F_z == pytest.approx(D / (1.0 / k_z + x**2 / k_a), rel=1e-4)
    assert under.pose.alpha == pytest.approx(x * found.wrench.F_z / k_a, rel=1e-4)
    assert depth_of(scene, under, 2e-3)[0] == pytest.approx(D, rel=1e-4)
    assert found.found.error_F_z > 0.0
    assert found.found.error.d_v < under.error.d_v


@pytest.mark.slow
@pytest.mark.parametrize("depth, F, sink", REFERENCE)
def test_a_sphere_to_a_depth_is_that_of_another_code(depth, F, sink):
    """Force and sink at a depth, each within two percent and its own error."""
    found = touch_load(covered((30, 90), WIDE, f'{SPHERE}, depth="{depth} mm"'), tolerance=3e-2)
    off, moved = found.wrench.F_z - F, 2e-3 - found.found.pose.d_v - 1e-3 * sink
    assert abs(off) < min(0.02 * F, found.found.error_F_z)
    assert abs(moved) < min(2e-5 * sink, found.found.error.d_v)


@pytest.mark.slow
def test_what_coils_show_at_a_depth_holds_what_the_force_may_be_off_by():
    scene = covered((30, 90), WIDE, f'{SPHERE}, depth="0.2 mm"')
    load = touch_load(scene, tolerance=3e-2)
    deep, under = (simulate(scene, each, tolerance=3e-2) for each in (load, load.wrench))
    assert np.array_equal(deep.impedance.L, under.impedance.L)
    assert deep.equilibrium.error.d_v == pytest.approx(
        under.equilibrium.error.d_v + abs(load.depth.per_depth[1]) * load.depth.off, rel=1e-9
    )


def test_a_touch_that_has_no_force_to_find_is_refused_and_a_given_one_taken():
    plain = 'touch={shape="sphere", radius="5 mm"}'
    with pytest.raises(SceneError, match="touch: must be given with a force or a depth; got none"):
        touch_load(load_sensor("biorob2018-w15", [plain]))
    deep = plain.replace("}", ', depth="0.1 mm"}')
    with pytest.raises(SceneError, match="touch.depth: must be a force on silicone that is warm .* stretch of 1.0"):
        touch_load(load_sensor("biorob2018-w15", [deep, 'temperature="40 degC"']))
    with pytest.raises(SceneError, match="touch.depth: must be left out for a table over forces; got 0.1 mm"):
        calibrate(load_sensor("biorob2018-w15", [deep]), F_z=[1.0, 2.0])
    forced = load_sensor("biorob2018-w15", [plain.replace("}", ', force="2 N"}')])
    assert touch_load(forced) == (Wrench(F_z=2.0), None, None)
