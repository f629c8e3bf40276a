"""What do finer meshes change over a grid of loads? A few loads tell, and a smooth map carries it to the others.

All loads of a grid are answered on the same two meshes, and so err alike: what finer meshes change of a pose is a small
and smooth function of the load, unlike what is left of each load by itself. With x the loads' components over their
largest values, and D the change of a component of the pose,

    D(x) = sum_(1 <= |k| <= 2) c_k x^k,

by least squares, weighted with the finer answers' errors, through loads whose monomials span the space best (QR with
pivoting), some more than there are coefficients, and all their images by symmetry: where they suffice of loads that
move the target less than three quarters of the farthest, whose finer answers are better and cheaper. Signed parts of
the finer answers' errors, which neighbouring loads share, go with the load by such a map as well. The rest of the error
goes with the displacement, of each component, of which a tenth of the largest counts at least: the median of the finer
answers', and what the map misses at loads that it was made without, beyond these loads times the cube of the
displacement over theirs.

Where designs are only compared, D is a share of the displacement, one of each component, by two loads: figures of
sensors were seen to differ by 1 to 3 %, one by 8 %, from those by the map (`corrected_in_share`).

Source: multi-fidelity correction, A. I. J. Forrester, A. Keane, Prog. Aerosp. Sci. 45 (2009) 50, section 2.3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
from scipy.linalg import qr

from sits_mech.cases import DONE, Row
from sits_mech.mechanics.loads import ERRORS, shared_of, with_shared
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.quantities import POSE, Array, Wrench

_DEGREE = 2
_SAME = 1e-9  # of the largest, what is left of a monomial that others make
_NEAR = 0.75  # of the largest displacement: beyond, finer meshes are dear and settle least
_LITTLE = 0.1  # of the largest displacement, what every component counts for at least
_TWO, _STILL = 2, 1e-3  # loads for shares; of the farthest, a displacement that has one
_MORE = 1  # loads more than coefficients, so that misses can be seen


class _Map(NamedTuple):
    """Coefficients of the change, shape (c, 6), and what they miss at loads that they were made without, shape (6,)."""

    weights: Array
    missed: Array


def corrected(
    rows: Mapping[Wrench, Row], finer: Callable[[Wrench], Row], symmetry: Symmetry, levers: Array, at_rest: Array, *,
    unloaded: bool = False,
) -> dict[Wrench, Row]:  # fmt: skip
    """Return the rows of loads with what finer meshes change of their poses.

    Parameters
    ----------
    rows : mapping
        By load, as of `settle`; those with a state were solved.
    finer : callable
        The row of a solved load on finer meshes.
    symmetry : Symmetry
    levers : ndarray, shape (6,)
        What turns the components of a pose into displacements [1, m].
    at_rest : ndarray, shape (6,)
        The undeformed pose.
    unloaded : bool
        Whether finer meshes change the pose without load, too: where the pad would be larger if nothing held it.

    Returns
    -------
    dict
        Rows that failed, and all of them where too few loads were solved for a map, come back as they are.
    """
    good = [load for load, row in rows.items() if row["status"] == DONE]
    standard = [symmetry.standard(load) for load in good]
    x = np.array([load.components for load in good]).reshape(-1, len(POSE))
    basis = _monomials(x / np.maximum(np.max(np.abs(x), axis=0, initial=0.0), 1e-300))
    basis = _independent(np.column_stack([np.ones(len(x)), basis]) if unloaded else basis)
    solved = {load for load in good if "state" in rows[load]}
    open_to = [k for k, (own, _) in enumerate(standard) if own in solved]
    moved = np.abs(np.array([_pose(rows[load]) for load in good]).reshape(-1, len(POSE)) - at_rest)
    size = np.max(moved * levers, axis=1)
    near = [k for k in open_to if size[k] <= _NEAR * size.max()]
    open_to = near if np.linalg.matrix_rank(basis[near]) == basis.shape[1] else open_to
    found: dict[Wrench, Row] = {}
    for load in _spanning(basis, open_to, [own for own, _ in standard]):
        row = finer(load)
        if row["status"] == DONE:
            found[load] = row
    known = [k for k in open_to if standard[k][0] in found]
    change = np.array([standard[k][1] @ (_pose(found[standard[k][0]]) - _pose(rows[standard[k][0]])) for k in known])
    if not known or np.linalg.matrix_rank(basis[known]) < basis.shape[1]:
        return dict(rows)
    own_errors = [np.max(np.array([found[standard[k][0]][name] for name in ERRORS]) * levers) for k in known]
    weight = np.median(own_errors) / np.maximum(own_errors, 0.1 * np.median(own_errors) + 1e-300)
    fitted = _fitted(basis[known], change, [standard[k][0] for k in known], weight)
    scales = dict(zip(good, np.maximum(moved, _LITTLE * size[:, None] / levers), strict=True))
    shares = np.array([_alone(row) / scales[load] for load, row in found.items() if np.any(scales[load])])
    share, missed = np.median(shares, axis=0), fitted.missed / np.max([scales[load] for load in found], axis=0)
    beyond = np.maximum(1.0, size / max(float(size[known].max()), 1e-300)) ** (_DEGREE + 1)
    count = min(len(shared_of(row)) for row in found.values())
    parts = np.array([(shared_of(found[standard[k][0]])[:count] @ standard[k][1].T).ravel() for k in known])
    shared = (basis @ np.linalg.lstsq(basis[known], parts, rcond=None)[0]).reshape(len(good), count, len(POSE))
    return dict(rows) | {
        load: _moved(rows[load], symmetry.projection(load), step, common, (share + missed * more) * scales[load])
        for load, step, common, more in zip(good, basis @ fitted.weights, shared, beyond, strict=True)
    }


def corrected_in_share(
    rows: Mapping[Wrench, Row], finer: Callable[[Wrench], Row], levers: Array, at_rest: Array
) -> dict[Wrench, Row]:
    """Return the rows of loads with each component of their displacements larger by one share, as finer meshes tell.

    The shares are by least squares of two loads that were solved, those that move the target farthest along the first
    two components which move, of what is less than three quarters of the farthest. Errors are not told: they stay.

    Parameters
    ----------
    rows, finer, levers, at_rest
        As of `corrected`; images of loads are mirror ones.
    """
    good = [load for load, row in rows.items() if row["status"] == DONE]
    ways = {load: (_pose(rows[load]) - at_rest) * levers for load in good}
    farthest = max((float(np.abs(way).max()) for way in ways.values()), default=0.0)
    solved = [load for load in good if "state" in rows[load]]
    near = [load for load in solved if np.abs(ways[load]).max() <= _NEAR * farthest] or solved
    chosen: list[Wrench] = []
    for k in range(len(POSE)):
        best = max(near, key=lambda load: float(abs(ways[load][k])), default=None)
        if best is not None and best not in chosen and len(chosen) < _TWO and abs(ways[best][k]) > _STILL * farthest:
            chosen.append(best)
    again = {load: row for load in chosen if (row := finer(load))["status"] == DONE}
    if not again:
        return dict(rows)
    moved = np.array([_pose(rows[load]) - at_rest for load in again])
    change = np.array([_pose(row) - _pose(rows[load]) for load, row in again.items()])
    size = np.sum(moved**2, axis=0)
    seen = np.abs(moved * levers).max(axis=0) > _STILL * farthest
    share = np.where(seen, np.sum(moved * change, axis=0) / np.where(seen, size, 1.0), 0.0)
    poses = {load: _pose(rows[load]) + share * (_pose(rows[load]) - at_rest) for load in good}
    return dict(rows) | {load: rows[load] | dict(zip(POSE, poses[load].tolist(), strict=True)) for load in good}


def _alone(row: Row) -> Array:
    """Errors of the components of the pose of a row, less what it shares with its neighbours."""
    own = np.array([float(row[name]) for name in ERRORS]) - np.abs(shared_of(row)).sum(axis=0)
    return np.asarray(np.maximum(own, 0.0))


def _pose(row: Row) -> Array:
    """Components of the pose of a row."""
    return np.array([float(row[name]) for name in POSE])


def _moved(row: Row, own: Array, step: Array, shared: Array, alone: Array) -> Row:
    """A row whose pose is corrected by a step, of which `own` leaves what its load may cause, by its errors' parts."""
    kept = shared @ own.T
    pose, errors = _pose(row) + own @ step, np.abs(kept).sum(axis=0) + np.abs(own) @ alone
    return with_shared(row, kept) | dict(zip((*POSE, *ERRORS), (*pose.tolist(), *errors.tolist()), strict=True))


def _monomials(x: Array) -> Array:
    """Products of one or two of the components that are there, shape (n, c): without load nothing changes."""
    own = [k for k in range(x.shape[1]) if np.any(x[:, k])]
    terms = [list(each) for n in range(1, _DEGREE + 1) for each in combinations_with_replacement(own, n)]
    return np.stack([np.prod(x[:, each], axis=1) for each in terms], axis=1) if terms else np.zeros((len(x), 0))


def _independent(basis: Array) -> Array:
    """The monomials that the loads tell apart: with two values of a component its square is no other."""
    if not basis.size:
        return basis
    _, triangle, order = qr(basis, mode="economic", pivoting=True)
    size = np.abs(np.diag(triangle))
    return np.asarray(basis[:, np.sort(order[: np.count_nonzero(size > _SAME * size[0])])])


def _spanning(basis: Array, open_to: Sequence[int], standard: Sequence[Wrench]) -> list[Wrench]:
    """The loads to be solved: those, and some more, whose monomials and their images' span the space best."""
    left, chosen = list(open_to), list[Wrench]()
    for count in (basis.shape[1], _MORE):
        if not left or not basis.shape[1]:
            break
        _, _, order = qr(basis[left].T, mode="economic", pivoting=True)
        new = dict.fromkeys(standard[left[k]] for k in order[:count])
        chosen += list(new)
        left = [k for k in left if standard[k] not in new]
    return chosen


def _fitted(basis: Array, change: Array, standard: Sequence[Wrench], weight: Array) -> _Map:
    """The map through what is known, by weights, and the root mean square of what it misses without one load."""
    left, right = basis * weight[:, None], change * weight[:, None]
    weights = np.linalg.lstsq(left, right, rcond=None)[0]
    missed = []
    for load in dict.fromkeys(standard):
        out = np.array([own == load for own in standard])
        if np.linalg.matrix_rank(basis[~out]) == basis.shape[1]:
            others = np.linalg.lstsq(left[~out], right[~out], rcond=None)[0]
            missed.append(np.max(np.abs(left[out] @ others - right[out]), axis=0))
    worst = np.max(np.abs(left @ weights - right), axis=0)
    within = np.sqrt(np.mean(np.square(missed), axis=0)) if missed else worst
    return _Map(np.asarray(weights, dtype=float), np.asarray(within, dtype=float))
