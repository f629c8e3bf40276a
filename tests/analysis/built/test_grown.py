"""A table that is calibrated further: a softer sensor is found by it, and little is solved again."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.typing import ArrayLike

from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.fit import EndReached
from sits_mech.analysis.built.grown import grown, longer
from sits_mech.analysis.built.prior import Prior, prior_of
from sits_mech.chain.calibrate import calibrate
from sits_mech.maps.grid import likely_part
from sits_mech.notes import Note, NoteKind, packed
from sits_mech.scene.sensor import SceneError, Sensor
from tests.analysis.conftest import bench_of

SOFT = 1.0 / 1.4
LOADS = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 1.9], [-0.4, 1.9], [0.0, 1.0]])


@pytest.mark.parametrize("values", [np.linspace(0.0, 2.0, 5), np.linspace(-0.5, 0.5, 9), [-0.1, 0.0, 0.2], [0.0, 2.0]])
def test_a_longer_grid_asks_for_what_was_solved(values: ArrayLike) -> None:
    """Of what usually suffices of the new values those of the old range sufficed there."""
    own, found = np.asarray(values).tolist(), longer(np.asarray(values), 1.5)
    assert {*own} < {*found} and [found[0], found[-1]] == pytest.approx([1.5 * own[0], 1.5 * own[-1]])
    both = {"F_x": np.linspace(-1.0, 1.0, 9).tolist()}
    old, new = ({point[1] for point in likely_part(both | {"F_z": each})} for each in (own, found))
    assert new & {*own} <= old


@pytest.mark.slow
def test_a_softer_sensor_is_found_on_a_longer_table(
    cheap: tuple[Sensor, xr.Dataset], numerics_alone: Callable[[], AbstractContextManager[None]], tmp_path: Path
) -> None:
    """1.4 times softer than its table: the fit ends there; on the longer one it does not, and few loads are new."""
    sensor, models = cheap[0], {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.02}
    with numerics_alone():
        axes = {"F_x": np.linspace(-0.5, 0.5, 9), "F_z": np.linspace(0.0, 2.0, 9)}
        known = calibrate(sensor, **axes, folder=tmp_path, **models)
        wide = calibrate(sensor, **{name: 1.6 * values for name, values in axes.items()}, **models)
        prior, solved = prior_of(sensor, known), {*tmp_path.iterdir()}
        readings = bench_of(prior_of(sensor, wide), LOADS, modulus=SOFT)
        with pytest.raises(EndReached, match="modulus: must fit .* calibrate to at least .* N of F_z") as end:
            adapt(prior, readings)
        data = grown(prior, LOADS, end.value, tmp_path)
        found = adapt(prior_of(sensor, data), readings)
    assert found.values[found.names.index("modulus")] == pytest.approx(SOFT, rel=0.05) and found.p_value > 0.01
    assert {*known["F_z"].values} < {*data["F_z"].values} and float(data["F_z"][-1]) >= 1.9 / SOFT
    more = {*tmp_path.iterdir()} - solved
    assert len(solved) > len(more) > 0


def test_what_is_not_the_end_of_the_table_is_refused(prior: Prior) -> None:
    """Another unknown; a modulus that is refused for what is known of it; a table that was adapted."""
    for end in (EndReached("gap: x", "gap", -1.0), EndReached("modulus: x", "modulus", 3.0)):
        with pytest.raises(EndReached, match="x"):
            grown(prior, LOADS, end)
    own = prior.data.assign_attrs(notes=packed([Note.of(NoteKind.ADAPTED, count=5, source="bench.csv")]))
    with pytest.raises(SceneError, match="grow: must be of a calibration as computed"):
        grown(prior_of(prior.sensor, own), LOADS, EndReached("modulus: x", "modulus", 0.5))
