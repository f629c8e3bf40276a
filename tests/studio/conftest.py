"""A sensor by models that cost little, with slopes, and tables of it changed."""

from collections.abc import Callable
from contextlib import AbstractContextManager

import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.derivatives.gradient_grid import gradient_on_grid
from sits_mech.scene.sensor import changed, load_sensor
from sits_mech.studio.previews import SolvedScene

LOADS = {"F_x": [-0.5, 0.0, 0.5], "F_z": [0.0, 1.0, 2.0]}
MODELS = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.02}
NUMBERS = ("elastomer.thickness", "target.width")


@pytest.fixture(scope="package")
def base(numerics_alone: Callable[[], AbstractContextManager[None]]) -> SolvedScene:
    """The published sensor, as if its models left nothing out."""
    sensor = load_sensor("biorob2018-w15")
    with numerics_alone():
        return SolvedScene(
            sensor, calibrate(sensor, **LOADS, **MODELS), gradient_on_grid(sensor, NUMBERS, LOADS, **MODELS)
        )


@pytest.fixture(scope="package")
def solved(base: SolvedScene, numerics_alone: Callable[[], AbstractContextManager[None]]) -> Callable[..., SolvedScene]:
    """What makes the table of the sensor with keys changed."""
    known: dict[tuple[str, ...], SolvedScene] = {}

    def made(*keys: str) -> SolvedScene:
        """Return a changed sensor with its table."""
        if keys not in known:
            sensor = changed(base.sensor, keys)
            with numerics_alone():
                known[keys] = SolvedScene(sensor, calibrate(sensor, **LOADS, **MODELS))
        return known[keys]

    return made
