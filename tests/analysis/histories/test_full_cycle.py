"""The full cycle beside the cheap one: alike where the pad answers like a spring, told where not."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import numpy as np
import pytest

from sits_mech.analysis.cycle import Programme, load_cycle, triangle
from sits_mech.analysis.histories.full_cycle import difference, full_cycle
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.material import silicone_from

MODELS = {"mechanics": "planar", "magnetics": "planar", "tolerance": 3e-2}


class Noted(Exception):
    """What is asked for is known."""


RATE, SOFT = {"prony": [{"weight": 0.3, "time": 0.5}]}, {"mullins": {"r": 2.0}}


@pytest.fixture(autouse=True)
def alone(numerics_alone: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Loops by models in section: what the ends leave out is as large as a loop's range."""
    with numerics_alone():
        yield


@pytest.mark.parametrize(
    ("programme", "corners"),
    [
        (triangle(0.3, cycles=2), [0.0, 0.15, 0.3, 0.45, 0.6]),
        (Programme(np.array([0.0, 1.0, 9.0, 10.0]), np.array([0.0, 0.9, 1.0, 0.0])), [0.0, 1.0, 9.0, 10.0]),
        (Programme(np.array([0.0, 1.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.0, 1.0, 1.0, 1.0])), [0.0, 1.0, 1.0, 3.0]),
    ],
)
def test_the_load_that_is_solved_is_the_programmes(
    programme: Programme, corners: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Changes of rate, holds and steps are solved as they are, the load between them is the programme's."""
    asked = []

    def noted(sensor, history, **more):
        asked.append(history)
        raise Noted

    monkeypatch.setattr("sits_mech.analysis.histories.full_cycle.in_time", noted)
    with pytest.raises(Noted):
        full_cycle(load_sensor("biorob2018"), Wrench(F_z=2.0), programme)
    assert asked[0].time[asked[0].corners] == pytest.approx(corners)
    np.testing.assert_array_equal(asked[0].course[:, 1], 2.0 * programme.share)


@pytest.mark.slow
@pytest.mark.parametrize(("more", "most"), [(RATE, 0.2), (SOFT, 0.3)])
def test_small_shear_agrees_with_the_pad_as_a_whole(more, most):
    """Rate: exactly but for steps; softening: points differ in their energies, the whole pad has one."""
    table = {"law": "neo-hookean", "shear_modulus": 2e4, "bulk_modulus": 2e7} | more
    base = load_sensor("biorob2018")
    own = base.model_copy(
        update={"elastomer": base.elastomer.model_copy(update={"material": silicone_from(table)})}
    )
    way, peak = triangle(2.0, cycles=1), Wrench(F_x=0.05)
    cheap, full = load_cycle(own, peak, way, **MODELS), full_cycle(own, peak, way, **MODELS)
    off = difference(cheap, full)
    assert off["d_h"] < most
    np.testing.assert_allclose(cheap.attrs["loop_L_h_percent"], full.attrs["loop_L_h_percent"], atol=most)
