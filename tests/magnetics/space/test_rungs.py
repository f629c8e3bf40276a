"""The ladder of divisions: its sheets against the closed form of a plate, its cells as levels of one family."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from sits_mech.extrapolation import added
from sits_mech.geometry.sheet_plan import Grading, graded_axis
from sits_mech.magnetics.space.rungs import LADDER, Rung, _interfaces

RATIOS = (0.05, 0.2, 0.5, 0.7)  # skin depth prepared for, over the skin depth


def sheet_impedance(heights: np.ndarray, ratio: float, parity: int) -> complex:
    """E/H at the face of a plate of sheets with uniform current, lengths over the depth prepared for.

    Each sheet holds its mean field, ``J = <E>``; ``E' = 2j ratio^2 H``, ``H' = J``. Even E: H = 0 in the middle.
    """
    n, k2 = heights.size, 2j * ratio**2
    A, E, H = np.zeros((n + 1, n + 1), complex), np.zeros(n + 1, complex), np.zeros(n + 1, complex)
    (E if parity > 0 else H)[n] = 1.0
    for i, h in enumerate(heights):
        own = np.eye(n + 1)[i]  # current of the sheet
        A[i] = E + k2 * (H * h / 2 + own * h / 6) - own / h
        E, H = E + k2 * (H * h + own * h / 2), H + own
    A[n] = H
    return complex(E @ np.linalg.solve(A, np.eye(n + 1)[n]))


@pytest.mark.parametrize("asked, rung", LADDER)
@pytest.mark.parametrize("half", [0.2, 0.7, 2.0, 4.8, 7.6, 15.0, 60.0])
def test_sheets_carry_the_skin_effect(asked: float, rung: Rung, half: float) -> None:
    """The extrapolated resistance of both faces together and against each other: coth and tanh of (1 + j) half."""
    for ratio in RATIOS:
        k = (1 + 1j) * ratio
        for parity, exact in ((1, k / np.tanh(k * half)), (-1, k * np.tanh(k * half))):
            found = [sheet_impedance(np.diff(_interfaces(half, 1.0, m)), ratio, parity) for m in rung.across]
            values = [np.array([[Z.real]]) for Z in found]
            R = float((values[-1] + added(values, rung.across, 2.0)[0])[0, 0])
            assert abs(R - exact.real) < 2.0 * asked * (k / np.tanh(k * half)).real


@pytest.mark.parametrize("length", [1e-4, 4e-3, 2e-2])
def test_axes_of_one_family_follow_one_map(length: float) -> None:
    sizes = Grading(2e-5, 1.9, 1e-3).coarser(5.5)
    axes = {m: graded_axis(length, Grading(sizes.first, sizes.growth, sizes.largest, m)) for m in (1, 2, 3, 6)}
    for axis in axes.values():
        assert axis[0] == 0.0 and axis[-1] == length and (np.diff(axis) > 0.0).all()
    for m in (2, 3, 6):
        np.testing.assert_allclose(axes[m][::m], axes[1], rtol=0.0, atol=1e-5 * length)
    cells = np.diff(axes[6])
    assert all(after <= before * (1.0 + 1e-9) for before, after in pairwise(cells))
