"""Constants of a unit: exact where they can be, small remainders of a gap and a tilt, nothing for the sensor itself."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.constants import BEYOND, as_computed, constants_of, inverse
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.readings.bench import code_calibration
from sits_mech.analysis.readings.codes import unit_codes
from sits_mech.scene.sensor import SceneError, changed
from tests.analysis.conftest import bench_of, unknowns


@pytest.fixture(scope="module")
def found(prior: Prior) -> Adaptation:
    """A unit that was built otherwise."""
    return adapt(prior, bench_of(prior))


def with_values(found: Adaptation, **values: float) -> Adaptation:
    """Return the unit as if it had been found to have these unknowns alone."""
    return replace(found, values=unknowns(found.prior, **values))


def test_a_modulus_and_a_lead_are_exact(found: Adaptation) -> None:
    """A factor of the forces alone; the line of a lead on codes to its curvature; nothing of nothing."""
    softer = constants_of(with_values(found, modulus=0.8))
    assert softer.factor == pytest.approx(0.8 * np.eye(2), abs=1e-4)
    assert softer.gain == pytest.approx(0.0, abs=1e-4) and softer.left == pytest.approx(0.0, abs=1e-5)
    lead = constants_of(with_values(found, lead=1e-8))
    assert np.all(lead.left < 2e-4) and lead.factor == pytest.approx(np.eye(2), abs=0.02)
    none = constants_of(with_values(found))
    assert none.left == pytest.approx(0.0, abs=1e-5) and none.offset == pytest.approx(0.0, abs=1e-4 * none.rest.max())


def test_a_unit_reads_its_forces(found: Adaptation) -> None:
    """By its codes of the model and its constants, within what they say; far better than by a tare."""
    prior, cal = found.prior, code_calibration(found.prior.sensor, found.prior.data)
    constants = constants_of(found, cal)
    forces = np.random.default_rng(0).uniform(0.8 * cal.low, 0.8 * cal.high, (40, 2))
    p = prior.used(found.values)
    loads = np.concatenate([forces, [[0.0, 0.0]]]) * p[prior.setup.names.index("modulus")]
    own = unit_codes(prior.sensor, prior.data, prior.bench(loads).model(p[None])[0])
    there = np.concatenate([forces, [[0.0, 0.0]]])
    f = inverse(cal, constants.codes(own), there)[0]
    errors = np.abs(constants.forces(f) - loads)[:-1] / (cal.high - cal.low)
    assert np.quantile(errors, 0.9) < 2.0 * constants.left.max() < 0.02
    assert np.all(f > cal.low - 1.1 * BEYOND * (cal.high - cal.low))
    tared = inverse(cal, own + as_computed(cal).rest - own[-1], there)[0]
    assert np.quantile(np.abs(tared - loads)[:-1] / (cal.high - cal.low), 0.9) > 5.0 * np.quantile(errors, 0.9)
    assert constants.codes(own[-1]) == pytest.approx(constants.rest, abs=0.02 * cal.full_scale.max())


def test_without_a_converter_there_are_none(found: Adaptation) -> None:
    """One line."""
    bare = changed(found.prior.sensor, ['readout.converter="none"'])
    with pytest.raises(SceneError):
        constants_of(replace(found, prior=replace(found.prior, sensor=bare)))
