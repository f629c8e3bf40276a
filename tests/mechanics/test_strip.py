"""The layer by formula: within its stated error of finite elements, refused where the formulas do not hold."""

import numpy as np
import pytest

from sits_mech.chain.simulate import simulate
from sits_mech.mechanics.closed_form import strip_layer
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer, linear_pad
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
@pytest.mark.parametrize("ratio", [2.0, 20.0, 1e3, 1e5])
def test_within_its_error_of_finite_elements(shape: float, ratio: float) -> None:
    """Each component of a small combined load, of any silicone; what the formulas miss is no more than 7 %."""
    sensor, wrench = flush(shape, ratio), Wrench(1e-3, 1e-3, 1e-6)
    found, true = strip_layer(sensor).equilibrium(wrench), linear_layer(sensor, 1e-3).equilibrium(wrench)
    both = found.error.components + true.error.components
    assert np.all(np.abs(parts(found.pose) - parts(true.pose)) <= both[:3])
    assert found.report.estimated_error < 0.07


def test_a_target_wider_than_its_layer_is_as_a_flush_one() -> None:
    wide, own = flush(3.75, extra=('target.width="40 mm"',)), flush(3.75)
    assert strip_layer(wide).stiffness == strip_layer(own).stiffness


@pytest.mark.slow
def test_small_strain_is_part_of_the_error() -> None:
    """At some percent of strain the nonlinear layer is still within it."""
    sensor = flush(3.75)
    wrench = Wrench(100.0, 1000.0)
    found, true = strip_layer(sensor).equilibrium(wrench), planar_layer(sensor, 1e-2).equilibrium(wrench)
    assert np.all(np.abs(parts(found.pose) - parts(true.pose)) <= [found.error.d_h, found.error.d_v, found.error.alpha])


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        (["elastomer.width=0.02"], "must cover the layer"), (["target=1"], "target"),
        (["elastomer.thickness=0.006"], "at least twice the thickness"),
    ],
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


def test_a_load_that_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="wrench: must be finite numbers"):
        strip_layer(flush(2.0)).equilibrium(Wrench(F_z=np.nan))


def test_the_chain_takes_it_by_name() -> None:
    """A load without a solve, the error with it."""
    found = simulate(flush(2.0), Wrench(1.0, 5.0), tolerance=0.1, mechanics="closed-form")
    report = found.equilibrium.report
    assert (report.model, report.unknowns, report.iterations) == ("closed-form", 0, 0)
    assert found.signals.error_L_v_percent > 0.0


@pytest.mark.parametrize(("shape", "ratio"), [(2.0, 1e3), (8.0, 1e3), (8.0, 20.0), (30.0, 1e2), (1.0, 2.0), (4.0, 3.0)])
def test_silicone_that_has_grown_lifts_its_target(shape: float, ratio: float) -> None:
    """By Betti's theorem, against finite elements: 1e-4 in each length if nothing held it; within its error."""
    sensor = flush(shape, ratio, ("elastomer.free_stretch=1.0001",))
    found, true = (model(sensor).equilibrium(Wrench()) for model in (strip_layer, linear_layer))
    rise, expected = found.pose.d_v - 2e-3, true.pose.d_v - 2e-3
    assert abs(rise - expected) < 0.01 * expected
    assert abs(rise - expected) <= found.error.d_v + true.error.d_v


def test_a_thin_wide_layer_rises_by_its_volume() -> None:
    """Uniaxial strain: (1 + nu)/(1 - nu) e, which is 3 e of what keeps its volume; nonlinear the same at 1e-4."""
    ratio, e = 10.0, 1e-4
    nu = (3 * ratio - 2) / (6 * ratio + 2)
    sensor = flush(60.0, ratio, (f"elastomer.free_stretch={1 + e}",))
    for model in (linear_layer, planar_layer):
        rise = model(sensor).equilibrium(Wrench()).pose.d_v / 2e-3 - 1.0
        assert rise / e == pytest.approx((1 + nu) / (1 - nu), rel=3e-3)
    stiff = flush(60.0, 1e4, (f"elastomer.free_stretch={1 + e}",))
    assert (linear_layer(stiff).equilibrium(Wrench()).pose.d_v / 2e-3 - 1.0) / e == pytest.approx(3.0, rel=2e-2)


def test_a_rise_by_finite_strain_keeps_the_volume() -> None:
    """A stretch of 1.01 of what keeps its volume, held in its plane: d_v is larger by 1.01**3, less its edges."""
    sensor = flush(60.0, 1e4, ("elastomer.free_stretch=1.01",))
    assert planar_layer(sensor).equilibrium(Wrench()).pose.d_v / 2e-3 == pytest.approx(1.01**3, rel=1e-4)


@pytest.mark.slow
def test_a_slender_pillar_rises_as_if_nothing_held_it() -> None:
    """Its ends, of the size of its width, rise threefold, in space: what is left tends to the free stretch."""
    rises = []
    for thickness in ("4 mm", "8 mm"):
        sizes = [f'{part}.{side}="2 mm"' for part in ("elastomer", "target") for side in ("width", "length")]
        keys = [*sizes, f'elastomer.thickness="{thickness}"', "elastomer.free_stretch=1.0001"]
        sensor = load_sensor("biorob2018", keys)
        rises.append((linear_pad(sensor).equilibrium(Wrench()).pose.d_v / sensor.elastomer.thickness - 1.0) / 1e-4)
    assert 1.0 < rises[1] < rises[0] < 2.0
    assert 2.0 * rises[1] - rises[0] == pytest.approx(1.0, abs=0.01)
