"""Answer a pose in the three-dimensional model by the coils' potential at some points of the plate, and products.

A coil's potential over the plate is a polynomial (`fields`), of few terms for a coil away from it; a class of modes
sees few combinations of its coefficients c (`modes`). For each coil, with A in the plate's own axes,

    a_c = fields^T c,    Delta Z_cd = sum over classes a_c^T Y(omega) a_d.

Coils of a low level drive the first combinations alone. Equal coils have equal fields in their own axes, which are
evaluated together.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np

from sits_mech.geometry.windings import kinds_of
from sits_mech.magnetics.coils.ring_field import winding_potential
from sits_mech.magnetics.coils.straight import CACHED, Potential
from sits_mech.magnetics.modes import Modes
from sits_mech.magnetics.space.far import Answered, Asked, Far, answers_to, biot_savart, few_points, radiated
from sits_mech.magnetics.space.fields import HELD, Basis, Blocks, Box, Nodes, side_by_side
from sits_mech.magnetics.space.sources import Posed
from sits_mech.memory import kept_by_first
from sits_mech.quantities import Array, Complex, Integers

_LEVELS = 100  # more than there are
_BLOCK = 8  # coils of about one level, answered together
_POINT = 1e-2  # of the strongest, of points that make the plate's field: 0.8 % of what it does in tracks from 2e-2
_FEW = 24  # coils in poses, at one frequency, that are answered mode by mode
_Order = tuple[Nodes, list[tuple[int, Integers, Array]]]


@dataclass(frozen=True, eq=False)
class Sheeted:
    """A plate prepared for any pose."""

    box: Box  # of its fields
    bases: tuple[Basis, ...]  # combinations of fields, one a symmetry class
    classes: tuple[Modes, ...]  # one a symmetry class, seen through its combinations
    unknowns: int  # of the discrete problem
    sheets: int  # of the discrete problem
    asked: Counter[float] = field(default_factory=Counter)  # coils in poses, by frequency: Y costs what some of them do

    @cached_property
    def columns(self) -> list[slice]:
        """Where each class's combinations are among all."""
        return side_by_side(basis.size for basis in self.bases)

    def admittance(self, omega: float) -> Blocks:
        """Return Y of all classes' combinations; omega [rad/s]."""
        parts = zip(self.columns, self.classes, strict=True)
        return Blocks(self.columns[-1].stop, tuple((np.r_[own], part.admittance(omega)) for own, part in parts))

    def reactions(
        self, divisions: Sequence[Sheeted], seen: Posed, frequency: float, asked: Asked | None = None
    ) -> tuple[list[Complex], Complex | None]:
        """Return Delta Z of a plate for n coils, one symmetric array (p, n, n) [ohm] a division; it is the first.

        With it what is asked of B of the first one's currents. All are as prepared together; frequency [Hz].
        """
        n, p, omega = len(seen.coils), len(seen.places), 2 * np.pi * frequency
        results, field = np.empty((len(divisions), p, n, n), dtype=complex), list[Complex]()
        self.asked[frequency] += n * p
        for some, drive, rank, levels in _drives(self, seen):
            pairs = np.arange(len(rank))[:, None, None], rank[:, :, None], rank[:, None, :]
            if self.asked[frequency] <= _FEW:
                found = np.stack([_by_modes(plate, drive, omega) for plate in divisions])
            else:
                found = _reaction(tuple(divisions), drive, levels, omega)
            results[:, some] = found[:, *pairs]
            if asked is not None:
                own = np.take_along_axis(drive, rank[..., None], axis=1)
                fields = _fields(self, own, (seen.turns[some], seen.places[some]), omega, asked.points)
                field += map(asked.of, fields)
        return list(results), np.concatenate(field, axis=1) if field else None

    def field(self, seen: Posed, frequency: float, points: Array) -> Complex:
        """Return B of the plate's currents by each coil at points (k, 3) below, (p, k, 3, n) [T/A]."""
        found = list[Complex]()
        for some, drive, rank, _ in _drives(self, seen):
            own, poses = np.take_along_axis(drive, rank[..., None], axis=1), (seen.turns[some], seen.places[some])
            found += _fields(self, own, poses, 2 * np.pi * frequency, points)
        return np.concatenate(found)

    def answered(self, divisions: Sequence[Sheeted], seen: Posed, frequency: float, far: Far) -> list[Answered]:
        """Return what a plate does to the coils' impedance, and to others' far combinations U; as `reactions`."""
        own = np.concatenate([np.take_along_axis(drive, rank[..., None], axis=1)
                              for _, drive, rank, _ in _drives(self, seen)])
        found, omega = [], 2 * np.pi * frequency
        for plate in divisions:
            YU, Y = answers_to(plate, far, omega)
            answer = (plate.admittance(omega) @ own.reshape(-1, own.shape[2]).T).T.reshape(own.shape)
            found.append((answer @ np.swapaxes(own, 1, 2), YU.T @ np.swapaxes(own, 1, 2), Y))
        return found


def _drives(plate: Sheeted, seen: Posed) -> Iterator[tuple[slice, Array, Integers, Integers]]:
    """Yield, for some poses after others, what a plate sees of each coil's potential; any division sees the same.

    Which poses; a_c of all classes side by side (poses, n, sum of r), coils of high level first; the place of each coil
    in that order (poses, n); the highest level at each place (n,).
    """
    (kinds, which), box = kinds_of(seen.coils), plate.box
    width = plate.columns[-1].stop
    centres = np.array([(*coil.centre, 0.0) for coil in seen.coils])
    region, points = _region(box, seen, centres), math.prod(box.order)
    fields = [winding_potential(kind, seen.windings, region, points, seen.step) for kind in kinds]
    step = max(1, HELD // (len(which) * width))
    for start in range(0, len(seen.places), step):
        some = slice(start, start + step)
        turns, places = seen.turns[some], seen.places[some]
        needed = box.needed(seen.coils, turns, places)
        levels = needed.max(axis=-1)
        rank = np.argsort(np.argsort(-levels, axis=1, kind="stable"), axis=1)
        drive = np.zeros((*levels.shape, width))
        alike = needed @ (1, _LEVELS, _LEVELS**2) + _LEVELS**3 * np.array(which)
        for one in np.unique(alike).tolist():
            pose, coil = np.nonzero(alike == one)
            order = tuple(needed[pose[0], coil[0]].tolist())
            moved = turns[pose], places[pose] - centres[coil]
            _drive(drive, (pose, rank[pose, coil]), fields[which[coil[0]]], _of_order(plate, order), moved)
        yield some, drive, rank, -np.sort(-levels, axis=1).min(axis=0)


def _region(box: Box, seen: Posed, centres: Array) -> tuple[float, float, float]:
    """Return where a plate is from coils of some centres, in all poses; as of `winding_potential`."""
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * box.half + (0.0, 0.0, box.half[2])
    corners = corners @ np.swapaxes(seen.turns, 1, 2) + seen.places[:, None]
    reach = np.abs(corners.reshape(-1, 3).max(0) - centres), np.abs(corners.reshape(-1, 3).min(0) - centres)
    aside = np.linalg.norm(np.maximum(*reach)[:, :2], axis=1)
    return box.clearance, float(corners[..., 2].max()), float(aside.max())


def _drive(
    drive: Array, index: tuple[Integers, Integers], field: Potential, order: _Order, poses: tuple[Array, Array]
) -> None:
    """Fill in a_c of all classes by one winding about z in some poses, with polynomials of one order."""
    (pose, place), (turns, places), (values, parts) = index, poses, order
    step = max(1, CACHED // len(values.points))
    for first in range(0, len(places), step):
        some = slice(first, first + step)
        found = values.coefficients(field, turns[some], places[some])
        for start, rows, combined in parts:
            drive[pose[some], place[some], start : start + combined.shape[1]] = found[:, rows] @ combined


@kept_by_first(64)
def _of_order(plate: Sheeted, needed: tuple[int, ...]) -> _Order:
    """Return the nodes of polynomials of an order; where a class's combinations start, its coefficients, and these."""
    box, found = plate.box, []
    order = [size[k] for size, k in zip(box.sizes, needed, strict=True)]
    for basis, own in zip(plate.bases, plate.columns, strict=True):
        places = np.unravel_index(basis.rows, (3, *box.order))
        some = np.all([place < n for place, n in zip(places[1:], order, strict=True)], axis=0)
        rows = np.ravel_multi_index([place[some] for place in places], (3, *order))
        fields = basis.fields if some.all() else basis.fields[some, : basis.widths[max(needed)]]
        found.append((own.start, rows, fields))
    return box.nodes(order), found


def _fields(
    plate: Sheeted, drive: Array, poses: tuple[Array, Array], omega: float, points: Array
) -> Iterator[Complex]:
    """Yield B of what drives (p, n, r) cause, some poses after others, (p, k, 3, n) [T/A]."""
    at, moments = _moments(plate, omega)
    turned = np.swapaxes(poses[0], 1, 2)
    answer: Complex = (drive.reshape(-1, drive.shape[2]) @ moments).view(complex)
    each, places = answer.reshape(*drive.shape[:2], -1, 3) @ turned[:, None], at @ turned + poses[1][:, None]
    step = max(1, CACHED // (len(points) * len(at)))
    for k in range(0, len(places), step):
        yield biot_savart(places[k : k + step], each[k : k + step], points)


@kept_by_first(4)
def _moments(plate: Sheeted, omega: float) -> tuple[Array, Array]:
    """Return points of a plate (q, 3) whose moments make its field below, and these by drives, (r, 6 q), complex."""
    few, carried = few_points(plate, plate.box.clearance, _POINT)
    each = np.tensordot(carried, radiated(plate, np.eye(plate.columns[-1].stop)), axes=1)
    moments = plate.admittance(omega) @ each.reshape(-1, each.shape[2]).T / (1j * omega)
    return plate.box.points()[few], np.ascontiguousarray(moments).view(float)


@kept_by_first(8)
def _responses(plate: Sheeted, others: tuple[Sheeted, ...], omega: float) -> tuple[Array, ...]:
    """Return the real and imaginary part of each class's Y on all d divisions, shape (r, 2, d, r)."""
    answers = zip(*([part.admittance(omega) for part in each.classes] for each in (plate, *others)), strict=True)
    return tuple(np.stack([np.stack([Y.real, Y.imag], axis=1) for Y in each], axis=2) for each in answers)


def _by_modes(plate: Sheeted, drive: Array, omega: float) -> Complex:
    """Return the sum of the classes' reactions for drives (p, n, all classes' r), without Y."""
    parts = zip(plate.columns, plate.classes, strict=True)
    return np.asarray(sum(part.reaction(drive[..., own] @ part.coupling, omega) for own, part in parts))


def _reaction(plates: tuple[Sheeted, ...], drive: Array, levels: Integers, omega: float) -> Complex:
    """Return `_by_modes` on all d divisions in one product, (d, p, n, n), coils of high levels first."""
    (p, n, _), d, (plate, *others) = drive.shape, len(plates), plates
    total = np.zeros((p, n, 2, d, n))
    firsts = _blocks(levels)
    for first, end in zip(firsts, (*firsts[1:], n), strict=True):
        found = np.zeros((p, 2 * d * (end - first), n - first))
        for basis, own, Y in zip(plate.bases, plate.columns, _responses(plate, tuple(others), omega), strict=True):
            r = basis.widths[levels[first]]
            if r > 0:
                part = drive[:, first:, own.start : own.start + r]
                answer = part[:, : end - first].reshape(-1, r) @ Y[:r, ..., :r].reshape(r, -1)
                found += answer.reshape(p, -1, r) @ np.swapaxes(part, 1, 2)
        total[:, first:end, ..., first:] = found.reshape(p, end - first, 2, d, n - first)
    block = np.searchsorted(firsts, np.arange(n), "right")
    Z = np.moveaxis(total[:, :, 0] + 1j * total[:, :, 1], 2, 0) * (np.sign(block - block[:, None]) / 2 + 0.5)
    return np.asarray(Z + np.swapaxes(Z, 2, 3))


def _blocks(levels: Integers) -> list[int]:
    """Return where blocks of coils of like level begin, levels descending; small ones cost more than they save."""
    found = [0]
    for k in np.flatnonzero(np.diff(levels)) + 1:
        if min(k - found[-1], len(levels) - k) >= _BLOCK:
            found.append(int(k))
    return found
