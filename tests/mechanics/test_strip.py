"""The layer by formula: within its stated error of finite elements, refused where the formulas do not hold."""

import numpy as np
import pytest

from sits_mech.chain.simulate import simulate
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.strip import strip_layer
from sits_mech.quantities import Pose, SolveFailed, Wrench
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor


def flush(shape: float, ratio: float = 1e4, extra: tuple[str, ...] = ()) -> Sensor:
    """Return a flush layer 2 mm thick of a shape factor and a ratio of moduli, a metre long."""
    law = f'elastomer.material={{law="neo-hookean", shear_modulus=3e4, bulk_modulus={3e4 * ratio}}}'
    width = 4e-3 * shape
    sizes = [f"elastomer.width={width}", f"target.width={width}", "elastomer.length=1.0"]
    return load_sensor("biorob2018", [*sizes, law, *extra])


def parts(pose: Pose) -> np.ndarray:
    """Return shear, sink and tilt."""
    return np.array([pose.d_h, 2e-3 - pose.d_v, pose.alpha])


@pytest.mark.parametrize("shape", [1.0, 2.0, 3.75, 8.0])
@pytest.mark.parametrize("ratio", [1e3, 1e5])
def test_within_its_error_of_finite_elements(shape: float, ratio: float) -> None:
    """Each component of a small combined load; the error says what the formulas miss, no more than 7 %."""
    sensor, wrench = flush(shape, ratio), Wrench(1e-3, 1e-3, 1e-6)
    found, true = strip_layer(sensor).equilibrium(wrench), linear_layer(sensor, 1e-3).equilibrium(wrench)
    both = found.error.components + true.error.components
    assert np.all(np.abs(parts(found.pose) - parts(true.pose)) <= both[:3])
    assert found.report.estimated_error < 0.07


def test_a_target_wider_than_its_layer_is_as_a_flush_one() -> None:
    wide, own = flush(3.75, extra=('target.width="40 mm"',)), flush(3.75)
    assert strip_layer(wide).stiffness == strip_layer(own).stiffness


def test_small_strain_is_part_of_the_error() -> None:
    """At some percent of strain the nonlinear layer is still within it."""
    sensor = flush(3.75)
    wrench = Wrench(100.0, 1000.0)
    found, true = strip_layer(sensor).equilibrium(wrench), planar_layer(sensor, 1e-2).equilibrium(wrench)
    assert np.all(np.abs(parts(found.pose) - parts(true.pose)) <= [found.error.d_h, found.error.d_v, found.error.alpha])


@pytest.mark.parametrize(
    ("keys", "why"),
    [(["elastomer.width=0.02"], "covers the"), (["elastomer.thickness=0.006"], "twice as"), (["target=1"], "target")],
)
def test_refused_where_the_formulas_do_not_hold(keys: list[str], why: str) -> None:
    """One line that says what must be."""
    with pytest.raises(SceneError, match=why):
        strip_layer(flush(2.0, extra=tuple(keys)))


def test_no_pose_where_the_error_is_as_large() -> None:
    """A load that would press the target through the coils."""
    with pytest.raises(SolveFailed, match="too large for a formula") as caught:
        strip_layer(flush(2.0)).equilibrium(Wrench(0.0, 4e4))
    assert caught.value.report.status == "strains too large"


def test_the_chain_takes_it_by_name() -> None:
    """A load in microseconds, the error with it."""
    found = simulate(flush(2.0), Wrench(1.0, 5.0), tolerance=0.1, mechanics="closed-form")
    assert found.equilibrium.report.model == "closed-form" and found.equilibrium.report.seconds < 0.1
    assert found.signals.error_L_v_percent > 0.0
