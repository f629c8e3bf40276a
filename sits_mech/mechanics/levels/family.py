"""Extrapolate the pose of a layer from a family of meshes, with its error.

The target's motion, a quantity of the energy, converges with powers of the cells' sizes: at the singular edges a known
one, 2 k with the exponent k of the displacements there, and away from them an observed one (pad/families.py),

    y_l = y + sum_j a_j phi_lj,

phi_lj the size of those cells on level l to those powers (pad/). As many of the last levels as there are unknowns give
y = Y and what each term adds. That is a corrected value: the step to the last level is Newton's on a richer space, so
that its change of q is the residual of the level before weighted by the dual solutions of q, and the terms carry it on.

Error. Of two levels, what the first term adds, twice along z and of flush pads, where terms of either sign cancel
(a_2/a_1 from -0.8 to 0.7 of pads in space), once sideways of a target within a face (from -0.02 to 0.05). Two levels of
a pad in space that agree by chance own to an edge's term of 0.03 of the displacement (flush pads show 0.0005 to 0.025),
times what the target's edge adds more than its middle by c below, where it tilts.
Of more,

    error = theta |Y_n - Y_(n-1)| + sum_j s_j |a_j phi_nj|,        theta = max_j phi_nj/phi_(n-1)j < 1,

the error that the levels before would have had, reduced as the terms are, and s for the uncertainty of the powers. They
and s = 1/2 are measured on pads of five laws (benchmarks/mechanics_accuracy.py). A level divided at the edge alone, or
away from it alone, moves the limit by what was wrong there, so that the ratio of the term that stays is not in theta.
Of three levels the second is separated by one of them, and counts whole: s_2 = 1. (On 16 pads true errors are 0.08 to
1.05 of those, of four levels of 14 pads 0.01 to 0.9.) No component's error is less than a share of the worst, an angle
counted at the target's end; likewise for forces that hold the target.

Under a press the angle between plate and free face opens, and the edge's term shrinks less from level to level than
its power says, which is that of small strain: a layer of cells more at the edge leaves rho of it, 0.25 without load,
0.30, 0.37 and 0.57 at sinks of 0.08, 0.13 and 0.14 thicknesses (two discs and a square, levels of two parts with none,
one and two further layers). What it adds in all goes as rho/(1 - rho), so that by rho = 1/4 + 8 (sink/t)**2
it is 1 + c (sink/t)**2 as much, and as rho grows from layer to layer, too, as much again is its error:

    y = Y + sum_j a_j phi_nj + c (sink/t)**2 a_1 phi_n1,   s_1 = 1/2 + c (edge/t)**2,   c = 8 * 16/3, some 50, in space.

A target that tilts presses one of its edges deeper, by its own half width times the tilt: on that depth the error is
taken. (Of three discs off centre rho is 0.36 to 0.53, by the middle's depth 0.28 to 0.30, by the edge's 0.34 to 0.39.)

So does the share of the worst component's error that all own to, twice: by the term and by its error, up to the whole.
(Of the tilt of `biorob2018` under three loads 0.26, 0.30, 0.45; it is 0.26, 0.29, 0.44 of it off.) By c = 0 true errors
are up to 3.7 times the estimated ones on ten of those pads, by 50 0.1 to 0.85 on five discs.

At a corner of a flush pad displacements go as ``r f(theta)`` under load, strains of their own in every direction, which
bricks do not follow (element/mesh.py): first their edge's term falls more slowly, then they fold, J to 0.1 and less,
into rests beyond the true one that are not unique. By x = (ln J_2)**2/-ln J_1, what -ln J would be on a third level
(it grows 1.9 to 2.6 times; where a pull leaves J_1 near 1, x is 2.6 of -ln J_2),
the term goes as h**1.19 of the cell to x = 0.25, as without load, and as h**0.75 from 0.5 on; a third level is solved
to 1.2. (What two levels of seven sheared squares leave of d_h is 0.46 to 0.7 of their difference: 0.55 by 0.75, 0.24 by
1.19; of z of pressed discs 0.13 to 0.23, 0.27 to 0.44 in between, 0.41 to 0.56, beside meshes of triangles or prisms
that meet in the corners.) Sideways two levels then own to as much as without load, all components as the worst.

Where free faces press a plane or each other no order is observed: the end of contact moves by less than a cell from
level to level, in either direction, so that two differences may be small, or in the ratio of the order, by chance.
There the whole sequence bounds the first term, not its last differences: with a_j what that term adds at level j,

    error = 2.2 max_j |a_j| phi_n1/phi_j1,    j = 2 ... n.

The 2.2 is measured, in the plane alone (in space contact is taken to show its order): on 19 flush layers of three laws,
where contact moves the target by more than a percent, 55 of 57 estimates of 8, 12 and 16 cells hold what 24 or 32 give;
true errors are 0.44 of them in the median, 1.5 at most.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; R. Becker, R. Rannacher, Acta Numerica 10 (2001) 1,
dual weighted residuals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial, wraps
from typing import Concatenate, NamedTuple, ParamSpec

import numpy as np

from sits_mech.mechanics.element.memory import memory_of_box
from sits_mech.mechanics.element.prolongation import Prolongation
from sits_mech.mechanics.equilibrium.body import Bonded, State
from sits_mech.mechanics.equilibrium.control import Scales
from sits_mech.memory import GIB, MEMORY, beyond_memory
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Mask
from sits_mech.scene.sensor import Sensor, shape_on_cover

PAIR = 2
"""Number of families of one kind: free, guarded."""
WALKED = 3  # levels of a path at most
PARTS = 3
"""Number of parts of an error that meshes have: two terms, and how far the limit moved."""
EARLY = 2.0  # times what extrapolation adds, by two levels: the powers may be off, or parts cancel

_CHANGED = 64  # layers of changed scenes that a family remembers
_IN_CONTACT = 2.2  # times the largest term that a sequence in contact shows
_UNSURE = 0.5  # of what extrapolation adds, by more levels than two: the powers may be off
_CREASED = 0.2  # J foreseen on a third level, from which on it pays: at 0.24 it rested, not at 0.17, late at 0.16
_FOLDS = 1.2  # -ln J foreseen there at the corners of a flush pad: from 1.3 on J came to 0.06 to 0.19, to 0.26 at 1.0
_GREW = 2.6  # times -ln J at most from level to level where corners fold; up to any where a pull nearly undoes a fold
_SLOWS = (0.25, 0.5)  # the same, between which the edge's order falls,
_SLOWED = 0.63  # by so much: 0.75/1.19


@dataclass(frozen=True, eq=False)
class Levels:
    """A family of meshes of a layer; `changed` makes the layer of a changed scene on the same cells, or None."""

    terms: Array  # (levels, j), phi; nan for two meshes of one fineness, the later one better
    cells: Callable[[int], tuple[int, ...]]  # of a level along each axis
    maker: Callable[[int], Bonded]  # meshed layer of a level, cached
    carrier: Callable[[int], Prolongation | None]  # from the level before; None if there is none
    share: float  # floor of component errors, as a share of the worst
    changed: Callable[[Sensor, int], Bonded | None] = lambda sensor, level: None
    rested: int = 6  # levels brought to rest at most; small strain uses all
    opens: float = 0.0  # c, by which edges that a press opens add more, and are less sure
    sideways: float = EARLY  # times what the first term adds: the error of two levels but along z, of a target at rest
    least: float = 0.0  # of the value: the least first term of two levels
    flush: bool = False  # whether bonded corners, which bricks fold, are its rims

    def __post_init__(self) -> None:
        """Cache the layers."""
        object.__setattr__(self, "maker", cache(partial(self._made, self.maker)))

    def __len__(self) -> int:
        return len(self.terms)

    @cached_property
    def coarse(self) -> Bonded:
        """First level."""
        return self.maker(0)

    @cached_property
    def fine(self) -> Bonded:
        """Second level."""
        return self.maker(1)

    @property
    def size(self) -> int:
        """Length of the packed states of the first two levels."""
        return self.fine.size + self.coarse.size

    @cached_property
    def without_first(self) -> Levels:
        """The family from its second level on, of the same layers."""
        return replace(
            self, terms=self.terms[1:], cells=lambda level: self.cells(level + 1),
            maker=lambda level: self.maker(level + 1), carrier=lambda level: self.carrier(level + 1),
            changed=lambda sensor, level: self.changed(sensor, level + 1), rested=self.rested - 1,
        )

    @property
    def edges_alone(self) -> bool:
        """Whether the first two levels differ in the cells at the edges alone, and show one term of two."""
        return bool(np.any(self.terms[1, 1:] == self.terms[0, 1:]))

    def _made(self, make: Callable[[int], Bonded], level: int) -> Bonded:
        """Return the layer of a level, which knows what parts of coarser cells lie at its rims, if those are cut."""
        body = make(level)
        cuts = level > 0 and body.cut is None and self.terms[level, 0] != self.terms[level - 1, 0]
        return replace(body, cut=partial(self._cut, level)) if cuts else body

    def _cut(self, level: int) -> Mask | None:
        """Whether a cell is a part of one at a rim of the level before, (c,); None where that is unknown."""
        way, before = self.carrier(level), self.maker(level - 1).patch
        return None if way is None or before is None else np.asarray(before.cells[way.parents].any(axis=0))

    def check_memory(self, level: int) -> Note | None:
        """Return a note on a level beyond memory, else None; raise ValueError for one of the first two."""
        needed = float(sum(memory_of_box(self.cells(level))))
        if not (beyond := beyond_memory(needed)):
            return None
        if level > 1:
            return Note.of(NoteKind.MESH_TOO_LARGE, needed=needed, limit=MEMORY.get() * GIB)
        takes = f"memory: a mesh of {' x '.join(map(str, self.cells(level)))} cells takes {beyond}"
        raise ValueError(f"{takes}: a thicker or smaller pad, or a mesh of your own with fewer cells, would fit")

    def limit(
        self, values: Sequence[Array], off: Array | float = 0.0, *, pressed: bool = False,
        sunk: Sequence[float] = (0.0, 0.0),
    ) -> Limit:
        """Return the limit of values on the first levels, as `extrapolated`; `sunk` as of `Bonded.sunk`."""
        return extrapolated(values, self.terms[: len(values)], off, pressed=pressed, opened=self._opened(sunk))

    def _opened(self, sunk: Sequence[float]) -> Array:
        """Return c (sink/t)**2."""
        return self.opens * np.maximum(sunk, 0.0) ** 2

    def least_share(self, sink: float) -> float:
        """Return of the worst component's error what each has at least, of a target that sinks [thicknesses]."""
        return min(1.0, self.share * (1.0 + self.opens * max(sink, 0.0) ** 2) ** 2)

    def early(self, values: Sequence[Array], along: Mask, *, pressed: bool, sunk: Sequence[float] = (0, 0)) -> Limit:
        """Return the limit of a loaded target's values on two levels; `along`: where terms may cancel."""
        found = extrapolated(values, self.terms[:2], pressed=pressed, early=np.where(along, EARLY, self.sideways))
        if self.edges_alone:  # what they do not show counts as much as what they do
            found.parts[1] = values[1] - values[0]
            found = found._replace(error=found.error + np.abs(found.parts[1]))
        if pressed or self.least == 0.0:
            return found
        middle, edge = 1.0 + self._opened(sunk)
        slow = np.where(along | (not self.flush), 1.0, self.sideways / EARLY)
        least = self.least * slow * self.terms[1, 0] * edge / middle * np.abs(found.value)
        return found._replace(error=np.maximum(found.error, least))

    def creased(self, states: tuple[State, State]) -> bool:
        """Whether rims of a third level in space crease: J falls by one factor, ln J of flush corners grows by one."""
        first, second = (state.min_J for state in states)
        return len(self.fine.mesh.axes) == 3 and (self.corner(states) > _FOLDS or second**2 < _CREASED * first)

    def corner(self, states: tuple[State, State]) -> float:
        """Return x, -ln J foreseen on a third level at the corners of a flush pad that touches nothing; else 0."""
        first, second = (max(0.0, -float(np.log(state.min_J))) for state in states)
        least = max(first, second / _GREW, 1e-300)
        return second * second / least if self.flush and not self.fine.parts else 0.0

    def folding(self, states: tuple[State, State]) -> Levels:
        """Return the family, of the same layers, by the order that its corners show under a load."""
        folds = float(np.interp(self.corner(states), _SLOWS, (0.0, 1.0)))
        if folds == 0.0:
            return self
        terms = self.terms ** [1.0 - folds * (1.0 - _SLOWED), 1.0]
        was, now = (each[1, 0] / (each[0, 0] - each[1, 0]) for each in (self.terms, terms))
        opens, share, sideways = (1.0 - folds) * self.opens, max(self.share, folds), self.sideways * was / now
        return replace(self, terms=terms, opens=opens, share=share, sideways=sideways)

    def foreseen(self, limit: Limit, level: int, last: int | None = None) -> Limit:
        """Return the limit of the levels before one as that one, or a later `last`, leaves it: parts as the terms are.

        From three levels on the limit moves by half of what is taken off the parts. A third level that is the first to
        show both terms leaves them less unsure, too.
        """
        ratios, parts = self.terms[last or level] / self.terms[level - 1], np.zeros_like(limit.parts)
        terms = slice(len(ratios))
        parts[terms] = limit.parts[terms] * ratios[:, None]
        if level == 2 and self.edges_alone:
            parts *= _UNSURE / EARLY
        if level > 2:
            parts[-1] = _UNSURE * _reduced(ratios) * np.abs(limit.parts[terms] - parts[terms]).sum(axis=0)
        return Limit(limit.value, np.abs(parts).sum(axis=0), parts)


@dataclass(frozen=True, eq=False)
class Line:
    """Families of meshes of a layer, each made on demand; numbers beyond theirs are those without first levels."""

    sensor: Sensor
    scales: Scales
    makers: Sequence[Callable[[], Levels]]  # free, guarded; in "auto" both again with contact
    asked: float  # estimated error at which refinement stops
    deepest: int = 99  # most levels
    goal: Array | None = None  # (s, 6), derivatives of what is asked by the pose; default: the pose

    def __post_init__(self) -> None:
        """Cache the families."""
        object.__setattr__(self, "makers", tuple(cache(maker) for maker in self.makers))

    def __getitem__(self, number: int) -> Levels:
        count = len(self.makers)
        return self.makers[number]() if number < count else self.makers[number - count]().without_first

    def without_first(self, number: int) -> int | None:
        """Return the number of a family without its first level; None where less than two levels would be left."""
        levels = self[number]
        left = number < len(self.makers) and len(levels) > PAIR and levels.check_memory(2) is None
        return number + len(self.makers) if left else None

    def in_contact(self, number: int) -> bool:
        """Whether a family has contact that another one does without."""
        return number % len(self.makers) >= PAIR

    @property
    def auto(self) -> bool:
        """Whether contact is chosen automatically."""
        return len(self.makers) > PAIR

    @property
    def last(self) -> range:
        """Numbers of the families used where faces touch."""
        return range(len(self.makers) - PAIR, len(self.makers))


_Asked = ParamSpec("_Asked")


def of_one_pad(make: Callable[Concatenate[Sensor, _Asked], Levels]) -> Callable[Concatenate[Sensor, _Asked], Levels]:
    """Keep the families of the last pad, with what its bodies remember: scenes with other coils ask for them again."""

    @wraps(make)
    def made(sensor: Sensor, /, *asked: _Asked.args, **more: _Asked.kwargs) -> Levels:
        families = _families(sensor.target, sensor.elastomer, sensor.cover, shape_on_cover(sensor))
        name = (make, *asked, *more.items())
        if name not in families:
            families[name] = make(sensor, *asked, **more)
        return families[name]

    return made


@lru_cache(maxsize=1)
def _families(*pad: object) -> dict[object, Levels]:
    """Return the families of a pad by what was asked of whom: empty, where it is not the last one."""
    return {}


Changed = Callable[[Sensor, int], Bonded | None]


def cache_changes(changed: Changed) -> Changed:
    """Cache the first two levels of changed scenes: tables of loads ask again."""
    remembered = lru_cache(maxsize=_CHANGED)(changed)
    return lambda sensor, level: (remembered if level < 2 else changed)(sensor, level)


class Limit(NamedTuple):
    """Limit of a sequence with its error.

    Parts: the addition of each term, and the change of the limit with the last level (zero if there are fewer).
    Neighbouring loads on the same meshes share them up to a factor each; in contact they are zero.
    """

    value: Array  # (k,)
    error: Array  # (k,)
    parts: Array  # signed, (3, k)


def contact_depth(depth: float, sizes: Sequence[float], level: int) -> float:
    """Return the contact depth on a level from that on the second; it falls as cell size squared."""
    return depth * (sizes[1] / sizes[level]) ** 2


def extrapolated(
    values: Sequence[Array], terms: Array, off: Array | float = 0.0, *, pressed: bool = False,
    opened: Sequence[float] | Array = (0.0, 0.0), early: Array | float = EARLY,
) -> Limit:
    """Return the limit of two or more levels, each (k,), by their `terms`; the last may be off by `off`.

    Components count alike: lengths, an angle as the displacement of the target's end. `pressed`: free faces press
    something. `opened`: by what the first term adds more than its power says, and is less sure than the others.
    `early`: times what two levels add.
    """
    if np.isnan(terms).any():
        return _limit(values[-1], (values[-1] - values[-2])[None])
    if pressed:
        rising = [n for n in range(1, len(values)) if terms[n, 0] < terms[n - 1, 0]]
        added = [_ahead(values[: n + 1], terms[: n + 1, :1])[0][0] for n in rising]
        shrunk = [np.abs(more) * terms[-1, 0] / terms[n, 0] for more, n in zip(added, rising, strict=True)]
        _, gain = _ahead([values[n] for n in (rising[-1] - 1, rising[-1])], terms[rising[-1] - 1 : rising[-1] + 1, :1])
        error = _IN_CONTACT * np.max(shrunk, axis=0) + gain * off
        return Limit(values[-1] + added[-1], error, np.zeros((PARTS, *np.shape(error))))
    more, gain = _ahead(values, terms)
    if len(values) == 2:
        return _limit(values[-1] + more.sum(axis=0), early * more, gain * off)
    wide = np.ones(len(more))
    wide[0] += opened[0]
    before, _ = _ahead(values[:-1], terms[:-1])
    value = values[-1] + np.tensordot(wide, more, axes=1)
    ratios, moved = terms[-1] / terms[-2], value - values[-2] - np.tensordot(wide[: len(before)], before, axes=1)
    parts = np.concatenate([_UNSURE * more, _reduced(ratios) * moved[None]])
    parts[0] += opened[1] * more[0]
    parts[1] *= 1.0 + (len(values) == 3 and ratios.max() == 1.0)
    return _limit(value, parts, gain * off)


def _reduced(ratios: Array) -> float:
    """Return theta: the largest ratio of the terms on a level and the one before, of those that are smaller on it."""
    return float(np.max(ratios, where=ratios < 1.0, initial=np.min(ratios)))


def _ahead(values: Sequence[Array], terms: Array) -> tuple[Array, float]:
    """Return what each term adds to the last value, (j, k), and how much that amplifies its error."""
    count = min(len(values) - 1, terms.shape[1])
    own = terms[-count - 1 :, :count]
    weights = np.linalg.inv(np.column_stack([np.ones(count + 1), own]))
    each = np.tensordot(weights[1:], np.asarray(values[-count - 1 :]), axes=1)
    return np.asarray(-own[-1].reshape(-1, *[1] * (each.ndim - 1)) * each), float(np.abs(weights[0, -1]))


def _limit(value: Array, parts: Array, off: Array | float = 0.0) -> Limit:
    """Build a limit from the parts of its error and the error of the last level."""
    every = np.zeros((PARTS, *np.shape(value)))
    every[: len(parts)] = parts
    return Limit(value, np.abs(parts).sum(axis=0) + off, every)
