"""How are the lines of a structured mesh spread so that singular corners cost little?

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
    """Return mesh lines from `start` to `end`, graded towards both ends.

    Parameters
    ----------
    start, end : float
        Ends of the segment, any unit of length.
    cells : int
        Number of cells, even.
    beta : float
        Strength of the grading; 1 is uniform.

    Returns
    -------
    ndarray, shape (cells + 1,)
        Lines in rising order, symmetric about the middle.

    Raises
    ------
    ValueError
        For an odd number of cells, or ends in the wrong order.
    """
    if cells < 2 or cells % 2 or not end > start or not beta >= 1.0:
        raise ValueError(f"segment: needs even cells, start < end, beta >= 1, not {cells}, {start}..{end}, {beta}")
    half = 0.5 * np.linspace(0.0, 1.0, cells // 2 + 1) ** beta
    unit = np.concatenate([half, 1.0 - half[-2::-1]])
    return start + (end - start) * unit


def graded_lines(breaks: Sequence[float], cells: Sequence[int], beta: float) -> Array:
    """Return mesh lines through all `breaks`, graded towards each of them.

    Parameters
    ----------
    breaks : sequence of float, length n + 1
        Ends of the n segments, rising.
    cells : sequence of int, length n
        Even numbers of cells, one per segment.
    beta : float
        Strength of the grading.

    Returns
    -------
    ndarray, shape (sum(cells) + 1,)
    """
    pieces = [
        graded_segment(a, b, n, beta) for a, b, n in zip(breaks[:-1], breaks[1:], cells, strict=True)
    ]
    return np.concatenate([pieces[0]] + [piece[1:] for piece in pieces[1:]])


def matched_cells(length: float, reference: float, cells: int, beta: float) -> int:
    """Return the even number of cells that gives a segment the same smallest cell as a reference segment has.

    Parameters
    ----------
    length, reference : float
        Lengths of the segment and of the reference segment, one unit.
    cells : int
        Number of cells of the reference segment.
    beta : float
        Strength of the grading.
    """
    return 2 * max(1, int(np.ceil(0.5 * cells * (length / reference) ** (1.0 / beta) - 1e-9)))


def split_lines(lines: Array, factor: int) -> Array:
    """Return mesh lines with each cell between them split evenly into `factor` cells."""
    parts = np.arange(factor) / factor
    return np.append((lines[:-1, None] + np.diff(lines)[:, None] * parts).ravel(), lines[-1])
