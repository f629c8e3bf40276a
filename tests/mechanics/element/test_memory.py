"""Memory that is told beforehand, against what a solution has allocated at its peak."""

import tracemalloc

import numpy as np
import pytest
from common.elimination import memory_of

from sits_mech.mechanics.element.memory import memory_of_box
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.newton import newton
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.scene.sensor import Elastomer, load_sensor


def block(cells):
    """Half a box of bricks."""
    return bonded_block(load_sensor("biorob2018-w15"), cells, 2.5, 0.0).body


def ring(cells):
    """Half a cylinder."""
    sensor = load_sensor("biorob2018-w15")
    layer = {"diameter": 20e-3, "thickness": 2e-3, "material": sensor.elastomer.material}
    return bonded_block(
        sensor.model_copy(update={"elastomer": Elastomer.model_validate(layer)}), cells, 2.5, 0.0
    ).body


def section(cells):
    """A section."""
    return bonded_body(load_sensor("biorob2018"), SectionFineness(cells, 1.5))


def layers(mesh):
    """Numbers of cells of a tensor mesh along its axes."""
    return tuple(len(np.unique(x.round(6))) for x in mesh.nodes[mesh.cells].mean(axis=1).T)


@pytest.mark.parametrize(("made", "cells"), [
    pytest.param(block, 2, marks=pytest.mark.slow), pytest.param(block, 3, marks=pytest.mark.slow), (section, 12),
])
def test_what_is_told_beforehand_is_what_is_allocated(made, cells):
    tracemalloc.start()
    try:
        body = made(cells)
        known = sum(memory_of(body.pattern))
        tracemalloc.reset_peak()
        found = newton(body, rest(body), np.array([0.05, 0.4, 0.0]))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.state.iterations > 1
    assert known == pytest.approx(peak, rel=0.25)
    assert 1 / 1.5 < sum(memory_of_box(layers(body.mesh))) / peak < 1.5


@pytest.mark.parametrize("cells", [2, 3])
def test_a_mesh_in_rings_takes_what_a_box_of_as_many_bricks_takes(cells):
    body, around = ring(cells), 4 * (2, 3)[cells > 2]
    outwards = len(body.mesh.cells) // (around * cells)
    known, box = sum(memory_of(body.pattern)), sum(memory_of_box((around, outwards, cells)))
    assert 1 / 1.5 < box / known < 1.5


def test_a_factor_grows_as_nested_dissection_lets_it():
    """Of a slab of n x n cells n**2 log n numbers, of a cube of n**3 cells n**4: George 1973."""
    slabs = [memory_of_box((n, n, 2)).factor / (n**2 * np.log2(n)) for n in (256, 512, 1024)]
    cubes = [memory_of_box((n, n, n)).factor / n**4 for n in (64, 128, 256)]
    for ratios in (slabs, cubes):
        assert np.ptp(ratios) < 0.15 * ratios[-1]
