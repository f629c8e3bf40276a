"""Find where a map from forces to inductances is invertible: sign of its determinant, hull of its loads.

For as many directions as forces: y = S^-1 V^T w L, V and S the singular vectors and values of the weighted inductances
over the box (of more coils than forces, within the directions that the forces move them in), D(F) = det(dy/dF). D keeps
its sign on a part of the box; where it changes sign the map folds back and two forces show the same inductances; of
parts of one size, as symmetry makes them, the inverse holds on that of the larger forces. A map with D of one sign on a
box is one to one if, besides, the image of the box's edge does not cross itself: no load of it shows what a far one
shows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion, label
from scipy.spatial import ConvexHull, QhullError, cKDTree

from sits_mech.maps.surrogate import SmoothMap
from sits_mech.quantities import Array, Mask, tensor_grid

_POINTS = {1: 257, 2: 65, 3: 21, 4: 9, 5: 7}  # of the grid along each force; 5 for more
_COARSE = {2: (8, 3), 3: (4, 2)}  # steps of the grid between other starting points, and their parts along each force
_FLAT = 1e-3  # of the determinant's median size: below it the map is called flat
_ALIKE = 0.9  # of the largest part's points: parts that mirror each other differ by fewer, by rounding
_SEEN = 1e-6  # of the leading direction's size: what varies less may be rounding of the inductances
_NEAR = 64  # images that are looked at around each one
_FAR = 0.3  # between two loads, of half the range: farther than cells that touch
_CELL = 1.5  # steps of the grid: as far as slopes are followed
_OTHER = 0.05  # of a coil's range: coils beyond the forces that differ by more make two loads differ
_FOLLOWED, _SETTLED = 6, 1e-3  # steps of Newton's method, and how small the last one must be


@dataclass(frozen=True)
class Domain:
    """The domain of an inverse, in scaled forces from -1 to 1."""

    regions: tuple[str, ...]  # without inverse, by forces and reason
    share: float  # of the loads inside the hull with an inverse
    sign: float  # of the determinant where the inverse holds
    condition: Array = field(repr=False)  # of dy/dF over the grid, whitened
    labels: NDArray[np.int_] = field(repr=False)  # 1: valid; 0: outside or insensitive; > 1: others
    hull: Array = field(repr=False)  # (f, d + 1), half-spaces A x + b <= 0
    whitening: tuple[Array, Array] = field(repr=False)  # middle (n,), leading directions (n, d)
    span: Array = field(repr=False)  # (2, d), whitened, of loads inside the hull

    def whitened(self, L: Array) -> Array:
        """Return inductances (m, n) along the leading directions, of size one over the box, shape (m, d)."""
        middle, directions = self.whitening
        return times(directions.T[..., None], (L - middle).T).T

    def holds(self, x: Array, margin: float) -> Mask:
        """Whether scaled forces (m, d) lie inside the hull of the table's loads, or outside by at most `margin`."""
        return np.asarray(np.max(times(self.hull[:, :-1, None], x.T) + self.hull[:, -1:], axis=0) <= margin + 1e-9)

    def beyond(self, L: Array) -> Mask:
        """Whether inductances (m, n) lie beyond all loads' along a leading direction."""
        y = self.whitened(L)
        return np.asarray(np.any((y < self.span[0]) | (y > self.span[1]), axis=-1))

    def valid(self, x: Array) -> Mask:
        """Whether scaled forces (m, d) lie in the part that has an inverse."""
        top = np.array(self.labels.shape) - 1
        near = np.clip(np.rint(0.5 * (x + 1.0) * top), 0, top).astype(int)
        return np.asarray(self.labels[tuple(near.T)] == 1)


def domain_of(found: SmoothMap, weights: Array, hull: Array) -> tuple[Domain, tuple[Array, ...]]:
    """Return the domain of the inverse of a map of forces to inductances, and starting points of its parts.

    The valid part comes first; `weights` (n,) of the inductances, `hull` from `hull_of`.
    """
    d = hull.shape[1] - 1
    axes = [np.linspace(-1.0, 1.0, _POINTS.get(d, 5))] * d
    x = tensor_grid(*axes)
    values, slopes = found.value_and_slopes(x.reshape(-1, d))
    inside = (np.max(x @ hull[:, :-1].T + hull[:, -1], axis=-1) <= 1e-9).reshape(-1)
    middle, directions = _whitening(values[inside], slopes[inside], weights)
    image = times(directions.T[..., None], (values[inside] - middle).T).T
    span = np.stack([image.min(axis=0), image.max(axis=0)])
    if directions.shape[1] < d:  # fewer coils than forces: nothing to turn around
        ones = np.full(inside.shape, np.inf).reshape(x.shape[:-1])
        blank = Domain((), 0.0, 0.0, ones, np.zeros(ones.shape, int), hull, (middle, directions), span)
        return blank, (x.reshape(-1, d),)
    whole = np.einsum("mni,nk->mki", slopes, directions)
    det = np.linalg.det(whole).reshape(x.shape[:-1])
    labels = _parts(det, inside.reshape(det.shape))
    condition = np.linalg.cond(whole).reshape(det.shape)
    sign = float(np.sign(np.sum(det[labels == 1])))
    share = float(np.mean(labels.reshape(-1)[inside] == 1))
    parts = [x[labels == part] for part in range(1, labels.max() + 1)]
    regions = tuple(_region(found, part, "sensitivity's sign turns") for part in parts[1:])
    flat = (labels == 0) & inside.reshape(det.shape)
    if np.any(flat):
        regions += (_region(found, x[flat], "no sensitivity in one direction"),)
    seeds = parts
    if d > 1 and _folds_over(found, x, labels == 1, directions, np.ptp(values[inside], axis=0)):
        why = "the map's edge crosses itself: two loads may give the same reading"
        regions += (_region(found, x.reshape(-1, d), why),)
        step, ways = _COARSE.get(d, (2, 2))
        blocks = np.array_split(np.arange(0, len(axes[0]), step), ways)  # each of loads that are one to one
        seeds += [x[np.ix_(*block)].reshape(-1, d) for block in product(blocks, repeat=d)]
    return Domain(regions, share, sign, condition, labels, hull, (middle, directions), span), tuple(seeds)


def times(A: Array, x: Array) -> Array:
    """Return small matrices (p, q, m or 1) times columns (q, m), shape (p, m), in an order independent of m."""
    found = A[:, 0] * x[0]
    for k in range(1, len(x)):
        found += A[:, k] * x[k]
    return np.asarray(found)


def hull_of(x: Array) -> Array:
    """Return the half-spaces A x + b <= 0 of the loads' convex hull, shape (f, d + 1); the box if they are flat."""
    d = x.shape[1]
    if d > 1:
        try:
            return np.unique(np.round(ConvexHull(x).equations, 12), axis=0)
        except QhullError:
            pass
    return np.vstack([np.c_[np.eye(d), -np.ones(d)], np.c_[-np.eye(d), -np.ones(d)]])


def _whitening(values: Array, slopes: Array, weights: Array) -> tuple[Array, Array]:
    """Return middle of inductances (m, n) and directions (n, at most d) that give them size one.

    Of more coils than forces, within the directions of the slopes (m, n, d), each force's normalised.
    """
    middle, d, basis = values.mean(axis=0), slopes.shape[-1], np.eye(len(weights))
    if len(weights) > d:
        weighed = slopes * weights[:, None]
        lengths = np.sqrt(np.sum(weighed**2, axis=(0, 1)))
        weighed = weighed / np.maximum(lengths, _SEEN * lengths.max())
        basis = np.linalg.eigh(np.einsum("mid,mjd->ij", weighed, weighed))[1][:, -d:]
    _, sizes, rows = np.linalg.svd(((values - middle) * weights) @ basis, full_matrices=False)
    rows = rows @ basis.T
    keep = min(d, int(np.sum(sizes > _SEEN * sizes[0])))
    first = np.argmax(np.abs(rows) > 0.5 * np.abs(rows).max(axis=1, keepdims=True), axis=1)
    rows = rows * np.sign(np.take_along_axis(rows, first[:, None], axis=1))  # a direction's sign is free
    return middle, weights[:, None] * rows[:keep].T / (sizes[:keep] / np.sqrt(len(values)))


def _parts(det: Array, inside: Mask) -> NDArray[np.int_]:
    """Number the connected parts of one sign, the valid one first; 0 outside and where the determinant is flat."""
    flat = _FLAT * float(np.median(np.abs(det[inside])))
    pieces: list[Mask] = []
    for sign in (1.0, -1.0):
        numbered, count = label(inside & (sign * det > flat))
        pieces += [numbered == k for k in range(1, count + 1)]
    found = np.zeros(det.shape, dtype=int)
    least = _ALIKE * max((int(piece.sum()) for piece in pieces), default=0)

    def rank(piece: Mask) -> tuple[bool, float]:
        """Rank large parts before small ones, large ones by largest forces."""
        large, middle = int(piece.sum()) >= least, np.argwhere(piece).mean(axis=0)
        return not large, -float(middle @ 0.5 ** np.arange(det.ndim)) if large else -float(piece.sum())

    for number, piece in enumerate(sorted(pieces, key=rank), start=1):
        found[piece] = number
    return found


def _region(found: SmoothMap, x: Array, reason: str) -> str:
    """Name a part of the box by its forces."""
    low, high = found.unscaled(x.min(axis=0)), found.unscaled(x.max(axis=0))
    ranges = [f"{name} {a:.3g} to {b:.3g}" for name, a, b in zip(found.names, low, high, strict=True)]
    return f"{', '.join(ranges)}: {reason}"


def _folds_over(found: SmoothMap, x: Array, part: Mask, directions: Array, ranges: Array) -> bool:
    """Whether distant loads, of a part's edge or with more coils than forces of all of it, show the same."""
    edge = part & ~binary_erosion(part)
    if edge.sum() < 2 or not _alike(found, x[edge], directions, len(x)):
        return False
    return len(ranges) == x.ndim - 1 or _alike(found, x[part], directions, len(x), ranges)


def _alike(found: SmoothMap, x: Array, directions: Array, count: int, ranges: Array | None = None) -> bool:
    """Whether two distant loads (m, d) show the same along the directions, or within `ranges` in all coils.

    Near images of distant loads are followed along the slopes there; within a cell, by Newton's method.
    """
    L, slopes = found.value_and_slopes(x)
    seen, inverse = L @ directions, np.linalg.inv(np.einsum("mni,nk->mki", slopes, directions))
    pairs = []
    for near in np.array(cKDTree(seen).query(seen, k=min(_NEAR, len(x)))[1]).T[1:]:
        step = np.einsum("mdk,mk->md", inverse[near], seen - seen[near])
        close = np.max(np.abs(step), axis=1) <= _CELL * 2.0 / (count - 1)
        rows = np.flatnonzero(close & (np.max(np.abs(x[near] - x), axis=1) > _FAR))
        pairs.append(np.stack([rows, near[rows]]))
    asked, near = np.concatenate(pairs, axis=1)
    at = x[near]
    for _ in range(_FOLLOWED):
        value, slopes = found.value_and_slopes(at)
        off = seen[asked] - value @ directions
        step = np.einsum("mik,mk->mi", np.linalg.pinv(np.einsum("mni,nk->mki", slopes, directions)), off)
        at = at + np.clip(step, -_FAR, _FAR)
    same = (np.max(np.abs(step), axis=1) < _SETTLED) & (np.max(np.abs(at), axis=1) <= 1.0)
    same &= np.max(np.abs(at - x[asked]), axis=1) > _FAR
    if ranges is not None:
        same &= np.max(np.abs(L[asked] - value) / ranges, axis=1) < _OTHER
    return bool(np.any(same))
