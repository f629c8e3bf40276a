"""Slips in a bench file are named: columns, signs, units; honest readings have none."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.mistakes import mistake
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.measured import Measured
from sits_mech.scene.sensor import SceneError

from .conftest import bench_of

GRAVITY = 9.80665


def _swapped(bench: Measured) -> Measured:
    """Two columns of coils."""
    return replace(bench, L=bench.L[:, ::-1])


def _signed(bench: Measured) -> Measured:
    """Shear the other way."""
    return replace(bench, forces=bench.forces * [-1.0, 1.0])


def _kilograms(bench: Measured) -> Measured:
    """Masses in place of weights."""
    return replace(bench, forces=bench.forces / GRAVITY)


@pytest.mark.parametrize(
    ("slip", "words"),
    [(_swapped, "C1 and C2 seem swapped"),
     pytest.param(_signed, "other sign|swapped", marks=pytest.mark.slow),
     pytest.param(_kilograms, "factor of 9.81: kilograms", marks=pytest.mark.slow)],
)
@pytest.mark.slow
def test_slips_are_named(prior: Prior, slip, words: str) -> None:
    """Of readings that are far likelier without."""
    bench = slip(bench_of(prior, modulus=1.0, gap=4e-5, d_h=1e-4, alpha=0.02, lead=1e-8))
    try:
        found = adapt(prior, bench)
    except SceneError:
        found = None
    assert found is None or found.p_value < 0.01
    assert np.any([word in mistake(prior, bench, found) for word in words.split("|")])
