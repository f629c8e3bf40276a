"""Nodes of a plate: as many as the modulus asks for, and what they know of a source outside."""

import numpy as np
import pytest

from sits_mech.magnetics.section.sampling import (
    CLASSES,
    all_nodes,
    field_basis,
    probe_charges,
    quadrant_images,
    sample_nodes,
    signs,
)

TERMS = 13.0
SIZES = ((8.0, 0.2), (8.0, 5.0), (1.0, 5.0), (100.0, 5.0), (20.0, 0.005), (5.0, 5.0))
GAPS = (0.1, 0.5, 2.0, 50.0)


@pytest.mark.parametrize("gap", [0.5, 0.1, 0.03])
def test_nodes_of_a_thin_strip_are_as_many_as_the_ellipse_asks_for(gap):
    """A slit and the ellipse of Bernstein through j y: ln rho = asinh y; the curve at one distance lies close to it."""
    exact = TERMS / (2 * np.arcsinh(2 * gap))
    assert all_nodes(*sample_nodes((1.0, 1e-5), gap, TERMS)).size == pytest.approx(exact, rel=0.3, abs=5)


def test_a_round_section_needs_the_digits_over_the_logarithm_of_the_radii():
    """A small square seen from afar is a circle of 0.59 of its side (its logarithmic capacity)."""
    count = all_nodes(*sample_nodes((1.0, 1.0), 100.0, 40.0)).size
    assert count == pytest.approx(40.0 / (2 * np.log(100.7 / 0.590)) + 3, abs=4)


@pytest.mark.parametrize(("size", "gap"), [(size, gap) for size in SIZES for gap in GAPS if size[0] < 300 * gap])
def test_samples_know_a_source_outside(size, gap):
    """The potential differences of a line current over the rim, from the samples alone, for gaps from 0.1 to 50."""
    (quadrant, copies), charges = sample_nodes(size, gap, TERMS), probe_charges(size, gap)
    nodes = all_nodes(quadrant, copies)
    assert np.abs(np.sort_complex(nodes) - np.sort_complex(-nodes)).max() == 0.0
    corner = complex(*size) / 2
    places = np.concatenate([np.linspace(0.01, 0.99, 20) * corner.real + 1j * corner.imag, [corner, corner.real + 0j]])
    rng = np.random.default_rng(1)
    source = rng.uniform(-1, 1, 5) * corner.real - 1j * (corner.imag + 1.02 * gap)
    seen = np.zeros((places.size, 5))
    slopes, values = _slopes(quadrant, charges), _values(places, charges)
    weight = 1.0 / np.linalg.norm(slopes[0], axis=0)
    for parities in CLASSES:
        sums = [sum(s * v for s, v in zip(signs(parities), each, strict=True)) * weight for each in (slopes, values)]
        basis, fields = field_basis(*sums, parities, copies)
        seen += fields @ basis @ _slopes(nodes, source)[0]
    acting = _values(places, source)[0]
    assert np.abs(seen - acting).max() < 3 * np.exp(-TERMS / 2) * np.ptp(acting, axis=0).max()


def _slopes(nodes, charges):
    slopes = [1.0 / (nodes[:, None] - image) for image in quadrant_images(charges)]
    return [np.concatenate([slope.real, slope.imag]) for slope in slopes]


def _values(places, charges):
    return [np.log(np.abs(places[:, None] / image - 1.0)) for image in quadrant_images(charges)]
