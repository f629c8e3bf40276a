"""Nodes along a line that follow a wanted size."""

import numpy as np
import pytest

from sits_mech.magnetics.section.mesh import graded_nodes


def test_graded_nodes_follow_the_wanted_size() -> None:
    nodes = graded_nodes(1.0, lambda s: np.minimum(1e-6 + 0.5 * np.minimum(s, 1 - s), 0.1), 1e-6)
    steps = np.diff(nodes)
    assert nodes[0] == 0.0 and nodes[-1] == 1.0 and np.all(steps > 0)
    assert 0.3e-6 < steps[0] < 2e-6 and steps.max() < 0.11
    assert steps == pytest.approx(steps[::-1], rel=1e-6)
