"""Choose the points of a grid to solve: as few as a smooth map needs to predict the others.

Each variable has nested levels of its values: the least of them, the ends, the middle of the gap, of the gaps then, and
so on. A block nu = (nu_1 .. nu_d) of a grid has the first nu_k levels of each variable; with U_nu the tensor product of
polynomials through its points (of more than six splines of degree five without free ends), the map is

    f = sum over the solved blocks nu of D_nu,     D_nu = sum_{e in {0, 1}^d} (-1)^|e| U_{nu - e}      (Smolyak 1963)

which goes through every solved point. Blocks are chosen by their sizes S_nu = max |D_nu| over their points, that is
by how far the map before missed them (Gerstner & Griebel 2003). A block that is not solved, but a neighbour below it
is, is expected to have a quarter of the largest of theirs, for each output; the error of the map is the root of the sum
of the squares of all those, and the largest, with all below it, is solved next until the error is small enough. It need
not have all below it solved to count: what is odd in one variable shows how it bends in another beside zero alone. As
D_nu is zero where the values of one variable are of a lower level than nu, the error at a point is of the blocks that
are no higher than its own levels: on a line that is solved, of what is left along it.

Where only the side of a limit is asked for, a point is known once the limit is outside its value and error. Blocks are
global, crossings are not: as soon as the points that are not known are no more than the next block would take, they are
solved themselves, and the error of the map is at least what it missed them by. Such a map ends before its sizes are
seen to fall: a block that is not solved is then taken to be as large as its neighbours below, not a quarter of them.
Numbers only.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import lt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sits_mech.quantities import Array, Mask

Axes = Mapping[str, Sequence[float]]
"""The values of each variable, ascending."""
Block = tuple[int, ...]
Levels = tuple[tuple[NDArray[np.int_], ...], ...]
_DEGREE = 5  # of the splines
_WHOLE = 32  # points up to which a grid is solved whole
_FIRST = 2  # sum of the levels of the blocks that are solved at first
_DECAY = 0.25  # of the size of a block's neighbours below, what it is expected to have
_ALONE = 3.3  # times its expected size, what a block had at most on five pads' tables solved whole; 95 % had up to 2
_TIE = 1.001  # of sizes: those that symmetry makes alike differ by less, by rounding
_LEAST = 0.25  # of the largest range of an output, what every output is taken to have: solvers own to as much error


@dataclass(frozen=True)
class SolvedPart:
    """A grid solved at some of its points, which predict the others."""

    axes: Axes  # of the whole grid
    blocks: tuple[Block, ...]  # solved, each with those below it
    values: Array  # (*sizes, n), outputs; nan if not solved; with a limit also of points outside the blocks
    error: Array  # (n,), of the map between solved points, the largest
    expected: Mapping[Block, Array]  # (n,) each, sizes of the next blocks

    @property
    def error_at(self) -> Array:
        """The error of the map at each point, shape (*sizes, n); 0 where it is solved."""
        levels, square = _levels_of(self.axes), np.zeros(self.values.shape)
        for block, size in self.expected.items():
            square[np.ix_(*(np.concatenate(own[first:]) for own, first in zip(levels, block, strict=True)))] += size**2
        return np.minimum(_ALONE * np.sqrt(square), self.error)


def solve_part(
    solve: Callable[[list[tuple[float, ...]]], ArrayLike], axes: Axes, *, tolerance: Callable[[], float],
    weights: ArrayLike = 1.0, goal: Array | None = None, limit: ArrayLike | None = None,
) -> SolvedPart | None:
    """Return a grid solved at as few points as predict the rest, or None where all are to be solved.

    That is so for small grids, and where a point fails. `solve` maps points to outputs (m, n), nan where it fails;
    `tolerance` is relative to each output's range, at least a quarter of the largest; it is called again after points
    are solved, which may be off themselves. `weights` (n,) make outputs comparable. A `goal` (s, n) makes relative
    figures of outputs, whose errors are within the tolerance as well. With a `limit` of outputs, in place of a goal,
    errors may be larger, as long as no point has it within value and error.
    """
    levels = _levels_of(axes)
    if _count(axes) <= _WHOLE:
        return None
    sizes: dict[Block, Array] = {}
    new = _blocks(levels, _FIRST)
    found = _filled(solve, axes, None, _unsolved(axes, levels, None, new))
    while found is not None:
        sizes |= {block: _size(found, axes, levels, block) for block in new}
        known = found[~np.isnan(found[..., 0])]
        weight = np.broadcast_to(np.asarray(weights, dtype=float), known.shape[-1:])
        ranges, asked = np.ptp(known, axis=0), tolerance()
        wanted = asked * np.maximum(ranges, _LEAST * np.max(ranges * weight) / np.maximum(weight, 1e-300))
        expected = {block: _expected(sizes, block) for block in _next_blocks(sizes, levels)}
        alike = np.sqrt(np.finfo(float).eps) * np.max(np.abs(known), axis=0)  # half its digits: a constant, rounded
        wanted = np.maximum(wanted, asked * alike + 1e-300)
        error = np.sqrt(np.sum(np.square([np.zeros_like(wanted), *expected.values()]), axis=0))
        if _share(error, wanted, goal, asked) <= 1.0:
            return SolvedPart(axes, tuple(sizes), found, error, expected)
        new = _largest_block(sizes, {block: _share(size, wanted, goal, asked) for block, size in expected.items()})
        if limit is not None:
            part = SolvedPart(axes, tuple(sizes), found, error / _DECAY, expected)
            open_ = _undecided(part, interpolated(part, found), limit, wanted)
            if np.count_nonzero(open_) <= np.count_nonzero(_unsolved(axes, levels, found, new)):
                return _decided(solve, part, limit, wanted)
        found = _filled(solve, axes, found, _unsolved(axes, levels, found, new))
    return None


def _largest_block(solved: Mapping[Block, Array], shares: Mapping[Block, float]) -> list[Block]:
    """Return the block with the largest share and those below it, of which none is solved."""
    worst = next(block for block, share in shares.items() if share >= max(shares.values()) / _TIE)
    return [block for block in itertools.product(*(range(level + 1) for level in worst)) if block not in solved]


def _undecided(part: SolvedPart, whole: Array, limit: ArrayLike, wanted: Array) -> Mask:
    """Return the unsolved points of which an output, by its map and error, may be on either side of a limit."""
    either = ~(np.abs(whole - np.asarray(limit, dtype=float)) > part.error)
    return np.asarray(np.isnan(part.values[..., 0]) & np.any(either & (part.error > wanted), axis=-1))


def _decided(
    solve: Callable[[list[tuple[float, ...]]], ArrayLike], part: SolvedPart, limit: ArrayLike, wanted: Array
) -> SolvedPart | None:
    """Return a part with its undecided points solved, and as much error as the map missed them by; None as above."""
    whole = interpolated(part, part.values)
    while np.any(open_ := _undecided(part, whole, limit, wanted)):
        found = _filled(solve, part.axes, part.values, open_)
        if found is None:
            return None
        missed = np.abs(found - whole)[open_].max(axis=0)
        part = replace(part, values=found, error=np.maximum(part.error, missed))
    return part


def _share(error: Array, wanted: Array, goal: Array | None, tolerance: float) -> float:
    """Return errors of outputs (n,) over those that are wanted, or of figures over the tolerance: the largest."""
    figures = np.zeros(1) if goal is None else np.abs(goal) @ error / tolerance
    return float(max(np.max(error / wanted), np.max(figures)))


def likely_part(axes: Axes) -> list[tuple[float, ...]]:
    """Return the points of a grid that usually suffice: one level more than the first."""
    levels = _levels_of(axes)
    if _count(axes) <= _WHOLE:
        return list(itertools.product(*axes.values()))
    return _points(axes, _unsolved(axes, levels, None, _blocks(levels, _FIRST + 1)))


def interpolated(part: SolvedPart, values: ArrayLike, *, degree: int = _DEGREE) -> Array:
    """Return the map through values (*sizes, m) at the solved points, on the whole grid; degree 1 is linear."""
    levels, solved = _levels_of(part.axes), set(part.blocks)
    whole = [np.arange(len(own)) for own in part.axes.values()]
    found = np.zeros(np.shape(values))
    for block in part.blocks:
        above = (tuple(map(sum, zip(block, step, strict=True))) for step in _steps(len(block)))
        share = sum((-1) ** sum(step) for step, other in zip(_steps(len(block)), above, strict=True) if other in solved)
        if share:
            found += share * _tensor(np.asarray(values), part.axes, _places(levels, block), whole, degree)
    return found


def _unsolved(axes: Axes, levels: Levels, found: Array | None, blocks: Sequence[Block]) -> Mask:
    """Return which points of a grid some blocks have that are not solved."""
    missing = np.zeros(tuple(len(values) for values in axes.values()), dtype=bool)
    for block in blocks:
        missing[np.ix_(*_places(levels, block))] = True
    return missing if found is None else missing & np.isnan(found[..., 0])


def _filled(
    solve: Callable[[list[tuple[float, ...]]], ArrayLike], axes: Axes, found: Array | None, missing: Mask
) -> Array | None:
    """Return the outputs (*sizes, n) with missing points solved; None where one fails."""
    new = np.asarray(solve(_points(axes, missing)), dtype=float)
    if not np.all(np.isfinite(new)):
        return None
    filled = np.full((*missing.shape, new.shape[-1]), np.nan) if found is None else found.copy()
    filled[missing] = new
    return filled


def _points(axes: Axes, chosen: Mask) -> list[tuple[float, ...]]:
    """Return the chosen points of a grid, the last variable running fastest."""
    values = list(axes.values())
    return [tuple(own[i] for own, i in zip(values, index, strict=True)) for index in np.argwhere(chosen).tolist()]


def _size(found: Array, axes: Axes, levels: Levels, block: Block) -> Array:
    """Return S_nu of each output, shape (n,)."""
    own = _places(levels, block)
    total = np.zeros((*(len(places) for places in own), found.shape[-1]))
    for step in _steps(len(block)):
        below = tuple(level - down for level, down in zip(block, step, strict=True))
        if min(below) >= 0:
            total += (-1) ** sum(step) * _tensor(found, axes, _places(levels, below), own, _DEGREE)
    return np.asarray(np.abs(total).reshape(-1, total.shape[-1]).max(axis=0))


def _tensor(
    values: Array, axes: Axes, known: Sequence[NDArray[np.int_]], asked: Sequence[NDArray[np.int_]], degree: int
) -> Array:
    """Return U: splines through values at known places of each variable, at others."""
    from scipy.interpolate import make_interp_spline

    found = values[np.ix_(*known)]
    for k, own in enumerate(axes.values()):
        if len(known[k]) == 1:
            found = np.repeat(found, len(asked[k]), axis=k)
        elif len(known[k]) < len(asked[k]) or not np.all(np.isin(asked[k], known[k])):
            at = np.asarray(own, dtype=float)
            spline = make_interp_spline(at[known[k]], found, k=min(degree, len(known[k]) - 1), axis=k)
            found = spline(at[asked[k]])
        elif len(asked[k]) < len(known[k]):
            found = np.take(found, np.searchsorted(known[k], asked[k]), axis=k)
    return found


def _expected(sizes: Mapping[Block, Array], block: Block) -> Array:
    """Return the expected size of an unsolved block for each output, shape (n,)."""
    below = (block[:k] + (level - 1,) + block[k + 1 :] for k, level in enumerate(block) if level > 0)
    return np.asarray(_DECAY * np.max([sizes[each] for each in below if each in sizes], axis=0))


def _next_blocks(solved: Mapping[Block, Array], levels: Levels) -> list[Block]:
    """Return the unsolved blocks with a solved neighbour below, in one order."""
    above = {block[:k] + (level + 1,) + block[k + 1 :] for block in solved for k, level in enumerate(block)}
    return sorted(block for block in above - set(solved) if all(map(lt, block, map(len, levels))))


def _blocks(levels: Levels, most: int) -> list[Block]:
    """Return the blocks whose levels add up to no more than some number."""
    each = (range(min(most + 1, len(own))) for own in levels)
    return [block for block in itertools.product(*each) if sum(block) <= most]


def _steps(count: int) -> list[Block]:
    """Return all of {0, 1}^count."""
    return list(itertools.product((0, 1), repeat=count))


def _places(levels: Levels, block: Block) -> list[NDArray[np.int_]]:
    """Return which values of each variable a block has, ascending."""
    return [np.sort(np.concatenate(own[: level + 1])) for own, level in zip(levels, block, strict=True)]


def _count(axes: Axes) -> int:
    """Return the number of points of a grid."""
    return int(np.prod([len(values) for values in axes.values()]))


def _levels_of(axes: Axes) -> Levels:
    """Return the levels of every variable."""
    return tuple(tuple(np.array(level) for level in _levels(values)) for values in axes.values())


def _levels(values: Sequence[float]) -> Iterator[list[int]]:
    """Yield places of values: the least, the ends, middles of gaps; mirrored where the list is."""
    last, sizes = len(values) - 1, np.abs(np.asarray(values, dtype=float))
    new = np.flatnonzero(sizes <= sizes.min() + 1e-9 * np.ptp(values)).tolist()
    known = set[int]()
    while new:
        yield new
        known.update(new)
        gaps = itertools.pairwise(sorted(known))
        ends = sorted({0, last} - known)
        new = ends or sorted({i for a, b in gaps if b - a > 1 for i in _middle(a + b, last)})


def _middle(both: int, last: int) -> set[int]:
    """Return the place half way between two, of two such the one nearer to the middle of all, or both."""
    lower = both // 2
    if both % 2 == 0:
        return {lower}
    return {lower, lower + 1} if both == last else {lower + (both < last)}
