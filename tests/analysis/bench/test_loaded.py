"""What a bench of loads shows: derivatives by everything that is unknown."""

import numpy as np
import pytest

from sits_mech.analysis.built.prior import Prior
from tests.analysis.conftest import LOADS, OTHERWISE, unknowns


def test_slopes_are_those_of_the_model(prior: Prior) -> None:
    """By every unknown of sensor, bench and table, and by what each load was misread by, the way down as well.

    To 5e-3: by loads the model follows the table's map, the slopes the magnetic model at the map's pose.
    """
    bench = prior.bench(LOADS, loose=True, depth=True)
    p = np.concatenate([unknowns(prior, **OTHERWISE, frame=0.02, stiffening=0.02), np.full(LOADS.size, 1e-3)])
    sizes = np.concatenate([np.sqrt(np.diagonal(prior.covariance)), np.full(LOADS.size, 0.02)])
    slopes, step = bench.slopes(p), 1e-2 * sizes
    sides = [bench.model(p + sign * np.diag(step)) for sign in (1.0, -1.0)]
    expected = np.moveaxis((sides[0] - sides[1]) / (2.0 * step[:, None, None]), 0, -1)
    for k, size in enumerate(sizes):
        most = np.abs(expected[..., k]).max(axis=0) * size
        assert np.all(np.abs(slopes - expected)[..., k] * size <= 5e-3 * most + [1e-13, 1e-13, 1e-10]), k


def test_a_softer_silicone_rests_as_under_a_larger_load(prior: Prior) -> None:
    """F of a sensor of half the modulus is 2 F of the table's; a load cell that shows half alike."""
    soft = prior.bench(0.4 * LOADS).model(unknowns(prior, modulus=0.5)[None])
    cell = prior.bench(0.4 * LOADS).model(unknowns(prior, cell=2.0)[None])
    plain = prior.bench(0.8 * LOADS).model(unknowns(prior)[None])
    assert soft == pytest.approx(plain, rel=1e-12) and cell == pytest.approx(plain, rel=1e-12)


def test_a_turned_load_cell_mixes_its_forces(prior: Prior) -> None:
    """About y by a small angle: a pull along x where only weight was read."""
    angle, down = 0.01, np.array([[0.0, 1.0]])
    turned = prior.bench(down).model(unknowns(prior, frame=angle)[None])
    tilted = np.array([[-np.sin(angle), np.cos(angle)]])
    assert turned == pytest.approx(prior.bench(tilted).model(unknowns(prior)[None]), rel=1e-12)
