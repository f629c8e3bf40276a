"""Spread the lines of a structured mesh so that singular corners cost little.

Cells shrink towards each end of a segment by a power law: the i-th of m lines of a half segment of length l lies

    d_i = l (i/m)**beta

from the end. A quantity whose error goes as ``h**(2 k)`` on uniform cells, k the exponent of the corner singularity,
then converges as ``m**(-2 k beta)`` until the order of the element takes over. Doubling m splits every cell in two.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.quantities import Array


def graded_segment(start: float, end: float, cells: int, beta: float) -> Array:
    """Return ``cells + 1`` mesh lines, rising and symmetric, graded towards both ends; ValueError for odd `cells`."""
    if cells < 2 or cells % 2 or not end > start or not beta >= 1.0:
        raise ValueError(f"segment: needs even cells, start < end, beta >= 1, not {cells}, {start}..{end}, {beta}")
    half = 0.5 * np.linspace(0.0, 1.0, cells // 2 + 1) ** beta
    unit = np.concatenate([half, 1.0 - half[-2::-1]])
    return start + (end - start) * unit


def graded_lines(breaks: Sequence[float], cells: Sequence[int], beta: float) -> Array:
    """Return mesh lines through all `breaks`, graded towards each; an even number of cells for each segment."""
    pieces = [
        graded_segment(a, b, n, beta) for a, b, n in zip(breaks[:-1], breaks[1:], cells, strict=True)
    ]
    return np.concatenate([pieces[0]] + [piece[1:] for piece in pieces[1:]])


def matched_cells(length: float, reference: float, cells: int, beta: float) -> int:
    """Return the even number of cells that gives a segment the same smallest cell as a reference segment has."""
    return 2 * max(1, int(np.ceil(0.5 * cells * (length / reference) ** (1.0 / beta) - 1e-9)))
