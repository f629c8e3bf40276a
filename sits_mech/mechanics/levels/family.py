"""How does a layer solved on a family of meshes become a pose with its error?

What a layer does for its target converges on meshes with cells divided into m = 1, 2, 3, ... parts as

    y_m = y + a m**-p + b m**-2p + ...

with p the order that the singular edges and the grading towards them decide (pad/). Two neighbours give

    Y_k = y_k + (y_k - y_(k-1)) / ((m_k/m_(k-1))**p - 1),

which the second term leaves off by b/(m_k m_(k-1))**p, so that two of them tell what is left in the later:

    error = 2 |Y_k - Y_(k-1)| / ((m_k/m_(k-2))**p - 1)  +  s |Y_k - y_k|,

s what the order may be off by; the 2 is measured (studies/mechanics_accuracy.py). The order that three levels show,
from the ratio of their differences, must not lie far below p, or the sequence is not there yet: then the error is all
of the two differences, and is said. Where it lies far above p, what is added is in doubt and part of the error. With
two levels alone the error is ``|Y - y|``. The smallest error counts. Three levels of a solid may agree by chance: on 31
pads drawn by studies/random_scenes.py what they tell held what 6 parts give in 10 cases, the worst off by 9.8 times
that, and four times that, with a fourth level where it is too much, in 29, the worst off by 1.1 times. No component is
called better than a share of the worst, an angle counted at the target's end; of forces that hold the target, likewise.

Where free faces press a plane or each other no order is shown: the end of contact moves by less than a cell from
level to level, now this way, now that, so that two differences may be small, or stand in the ratio of the order, by
chance. There the whole sequence tells how large the term a m**-p may be, not its last differences: with a_j what is
added at level j,

    error = 2.2 max_j |a_j| (m_j/m_k)**p,    j = 2 ... k,

and the last level counts, not the smallest error. The 2.2 is measured, in the plane alone (in space contact is taken to
show its order): on 19 flush layers, 10/10/2 to 20/20/2 mm, of three laws, at loads where contact moves the target by
more than a percent, 55 of 57 estimates of 8, 12 and 16 cells hold what 24 or 32 cells give; true errors are 0.44 of
them in the median, 1.5 at most. The smallest error of neighbouring levels held it in one case of eight.

The first two levels are brought to rest (path.py), the second from the first one's state. On finer ones the target's
place is corrected by Newton steps from the state of the level before, until it stays; corners need not come to rest
for that. Where no state is carried to a level, or none can be followed by another step, it is brought to rest from the
start, along a path whose increments are halved; where that fails, too, a step that no other can follow, as one would
turn a corner inside out, is the last: what it may be off by is in the error. What creases hide: creases.py.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; J. Xu, SIAM J. Numer. Anal. 33 (1996) 1759, Newton
steps from coarse solutions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import prod
from typing import NamedTuple

import numpy as np

from sits_mech.extrapolation import shown_order
from sits_mech.mechanics.element.memory import memory_of_box
from sits_mech.mechanics.element.prolongation import Prolongation
from sits_mech.mechanics.element.target import bonded_displacement
from sits_mech.mechanics.rest.body import Bonded, State
from sits_mech.mechanics.rest.limit import Outcome
from sits_mech.mechanics.rest.linearisation import Held, drawn
from sits_mech.mechanics.rest.newton import SETTLED, Approach, approached, unloaded
from sits_mech.mechanics.rest.path import among_faces
from sits_mech.mechanics.rest.verdict import Way, verdict
from sits_mech.memory import GIB, memory_limit
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Sensor

FEWEST = 3
"""Levels of an answer, if they can be had."""
_CHEAP = 1500  # cells
_CHANGED = 64  # layers of changed scenes that a family remembers
_SAFE = 2.0  # times what the second term leaves: against references of an independent code half of that is too little
_IN_CONTACT = 2.2  # times the largest term that a sequence in contact shows
_UNSEEN = 0.25  # of the worst component's error that every component owns to, where two levels alone tell it
_UNSURE = 0.15  # of what extrapolation adds: the order may be off
_SHOWN, _HIGH = 0.5, 1.4  # of the order must be shown by three levels, and no more than so many times of it
_ENOUGH = 0.02  # of the difference of two levels: a correction that is closer is not gone on with
_LEAST_J = 0.15  # of a state that Newton's method begins with
_CLOSE = 1e-2  # residual from which Newton's method goes on, though it took all its steps
_EASY = 6  # iterations up to which the next increment of a path on a level that no state is carried to grows
_FEW, _MOST, _WORK = 10, 80, (8e5, 2e5)  # iterations there; times unknowns, of sections and of solids


@dataclass(frozen=True, eq=False)
class Levels:
    """A family of meshes of a layer.

    Attributes
    ----------
    sizes : tuple of float
        m of each level, rising; two or more.
    cells : tuple of int
        Along each axis, for m = 1.
    maker : callable
        Level -> meshed layer; remembers what it made.
    carrier : callable
        Level -> what carries states to it from the level before; None where there is none.
    order : float
        p; infinite where there are two meshes of one fineness, the later one the better.
    share : float
        Of the worst component's error that every component owns to.
    eager : bool
        Whether a third level is solved even where two are enough.
    changed : callable
        Changed scene, level -> its layer on the same cells; None where it takes others.
    early : float
        Times what three levels alone tell, which then outvotes two: the error until there is a fourth.
    """

    sizes: tuple[float, ...]
    cells: tuple[int, ...]
    maker: Callable[[int], Bonded]
    carrier: Callable[[int], Prolongation | None]
    order: float
    share: float
    eager: bool = True
    changed: Callable[[Sensor, int], Bonded | None] = lambda sensor, level: None
    early: float = 1.0

    @cached_property
    def coarse(self) -> Bonded:
        """The first level."""
        return self.maker(0)

    @cached_property
    def fine(self) -> Bonded:
        """The second level."""
        return self.maker(1)

    @property
    def size(self) -> int:
        """Length of the packed states of the first two."""
        return self.fine.size + self.coarse.size

    def numbers(self, level: int) -> tuple[int, ...]:
        """Return the cells of a level along each axis."""
        return tuple(round(count * self.sizes[level]) for count in self.cells)

    def is_cheap(self, level: int) -> bool:
        """Say whether a level is solved though the error is small enough without it, to see the order."""
        return self.eager and level < FEWEST and prod(self.numbers(level)) <= _CHEAP

    def check_memory(self, level: int) -> str:
        """Return what is to be said of a level that takes more memory than it may; "" of one that does not.

        Raises
        ------
        ValueError
            For one of the first two levels, without which there is no answer.
        """
        needed, limit = memory_of_box(self.numbers(level)).total, memory_limit()
        if needed <= limit:
            return ""
        words = f"some {needed / GIB:.2g} GiB, more than the limit of {limit / GIB:.3g} GiB"
        if level > 1:
            return f"a finer mesh would take {words}: raise it (--memory) for a smaller error"
        cells = " x ".join(map(str, self.numbers(level)))
        raise ValueError(
            f"memory: a mesh of {cells} cells takes {words} (--memory): a thicker or smaller pad, or a mesh of "
            "your own with fewer cells, would fit"
        )


Changed = Callable[[Sensor, int], Bonded | None]


def kept(changed: Changed) -> Changed:
    """Return what makes the layers of changed scenes, those of the first two levels once: tables of loads ask again."""
    remembered = lru_cache(maxsize=_CHANGED)(changed)
    return lambda sensor, level: (remembered if level < FEWEST - 1 else changed)(sensor, level)


class Limit(NamedTuple):
    """What a sequence tends to, shape (k,), its error, and the order that its last three levels show (nan: two).

    The parts of the error, shape (2, k), have the signs of what they are taken from: what the second term leaves, and
    what the order may be off by. Neighbouring loads on the same meshes share them, up to a factor each; in contact they
    share nothing, and no order is shown (nan): there the parts are zero.
    """

    value: Array
    error: Array
    order: float
    parts: Array

    def times(self, factor: float) -> Limit:
        """Return the same with so many times the error."""
        return self._replace(error=factor * self.error, parts=factor * self.parts)

    def owned(self, share: float) -> float:
        """Return the share of the worst component's error that every component owns to, from that of a family."""
        return share if np.isfinite(self.order) else max(share, _UNSEEN)

    def words(self, expected: float) -> tuple[str, ...]:
        """Return what is to be said of the sequence, where another order is expected."""
        if not self.order < _SHOWN * expected:
            return ()
        seen = f"the meshes are too coarse for their order: {self.order:.2g} seen, {expected:.3g} expected"
        return (f"{seen}; the error covers it",)


def contact_depth(depth: float, sizes: tuple[float, ...], level: int) -> float:
    """Return the depth of contact on a level, from that on the second: it falls like the cells, squared."""
    return depth * (sizes[1] / sizes[level]) ** 2


def extrapolated(
    values: list[Array], sizes: tuple[float, ...], order: float, off: Array | float = 0.0, *, pressed: bool = False
) -> Limit:  # fmt: skip
    """Return the limit of what some levels gave, two or more, the last of which may be off.

    Parameters
    ----------
    values : list of ndarray, shape (k,)
        Components that count alike: lengths, an angle as the way of the target's end.
    sizes : tuple of float
        m of each.
    order : float
        p.
    off : float or ndarray, shape (k,)
        What the last level may be off by.
    pressed : bool
        Whether free faces press something.
    """
    if not np.isfinite(order):
        return _limit(values[-1], np.nan, values[-1] - values[-2], np.zeros_like(values[-1]))
    m = np.array(sizes[: len(values)])
    ratios = m[1:] / m[:-1]
    added = [(b - a) / (ratio**order - 1.0) for a, b, ratio in zip(values[:-1], values[1:], ratios, strict=True)]
    ends = [y + more for y, more in zip(values[1:], added, strict=True)]
    beyond = off * ratios[-1] ** order / (ratios[-1] ** order - 1.0)
    if pressed:
        shrunk = [np.abs(more) * (size / m[-1]) ** order for more, size in zip(added, m[1:], strict=True)]
        return Limit(ends[-1], _IN_CONTACT * np.max(shrunk, axis=0) + beyond, np.nan, np.zeros((2, len(ends[-1]))))
    if len(values) == 2:
        return _limit(ends[-1], np.nan, added[-1], np.zeros_like(added[-1]))
    apart, gone = ends[-1] - ends[-2], values[-1] - values[-2]
    ratio = np.linalg.norm(values[-2] - values[-3]) / max(float(np.linalg.norm(gone)), 1e-300)
    shown = float(shown_order(float(ratio), m[-3:]))
    if shown < _SHOWN * order:
        return _limit(ends[-1], shown, apart, added[-1])
    left = _SAFE * apart / ((m[-1] / m[-3]) ** order - 1.0)
    unsure = (_UNSURE + (1.0 if shown > _HIGH * order else 0.0)) * added[-1]
    return _limit(ends[-1], shown, left, unsure, beyond)


def _limit(value: Array, order: float, left: Array, unsure: Array, off: Array | float = 0.0) -> Limit:
    """A limit by the parts of its error, and what the last level may be off by besides."""
    return Limit(value, np.abs(left) + np.abs(unsure) + off, order, np.stack([left, unsure]))


def prolonged(levels: Levels, level: int, state: State, safe: Array | None = None) -> State | None:
    """Return a state on the next level, to go on from; None where there is no way there.

    Where cells turn inside out between the points that the coarser mesh looks at, their nodes are drawn towards `safe`
    displacements of the finer one, and where these do not help towards an even layer, every column of which follows the
    target above it, ``u = z (c + (R - 1) X)``.
    """
    way, body = levels.carrier(level), levels.maker(level)
    if way is None:
        return None
    axes = list(body.mesh.axes)
    places = np.zeros((len(body.mesh.nodes), 3))
    places[:, axes] = body.mesh.nodes
    even = (places[:, 2:] * bonded_displacement(places * (1.0, 1.0, 0.0), state.q))[:, axes].ravel()
    u = np.asarray(way.displacements(state.u))
    bonded = bonded_displacement(body.X, state.q)[:, axes]
    for near in (even,) if safe is None else (safe, even):
        u[body.bonded] = near[body.bonded] = bonded
        found = drawn(body, u, near, _LEAST_J)
        if found is not None:
            return State(found[0], state.q, way.pressures(state.p), state.load, min_J=found[1])
    return None


def next_at_rest(levels: Levels, state: State, way: Way) -> Outcome | None:
    """Return the second level at rest at the end of a path, from the first one's state there; None where it is not."""
    start = prolonged(levels, 1, state)
    if start is None:
        return None
    body, found = among_faces(levels.fine, start, way.end, way.held)
    if SETTLED < found.state.residual < _CLOSE:
        body, found = among_faces(body, replace(found.state, iterations=0), way.end, way.held)
    said = verdict(body, way, found)
    return None if said.reason else Outcome(replace(found.state, min_J=said.min_J), 1.0)


def finer(levels: Levels, states: tuple[State, State], aim: tuple[Held, Array]) -> Iterator[Approach]:
    """Yield where the target rests on the third level and the ones after it, as far as they get there.

    Parameters
    ----------
    levels : Levels
    states : tuple of State
        Of the first two levels, at rest.
    aim : ndarray and ndarray
        Which places are held, and what is given.
    """
    (before, state), (held, goal), way = states, aim, levels.carrier(1)
    safe = before.u if way is None else np.asarray(way.displacements(before.u))
    for level in range(2, len(levels.sizes)):
        body, way = levels.maker(level), levels.carrier(level)
        found = None
        if way is not None:
            safe = np.asarray(way.displacements(safe))
            start = prolonged(levels, level, state, safe)
            enough = _ENOUGH * body.length(state.q - before.q)
            found = None if start is None else approached(body, start, goal, held, enough)
        if found is None or found.state is None:
            found = _from_rest(body, held, goal) or found
        if found is None:
            return
        yield found
        if found.state is None:
            return
        before, state = state, found.state


def _from_rest(body: Bonded, held: Held, goal: Array) -> Approach | None:
    """A body under what is given, along a path from rest whose increments are halved; None where that ends before.

    What is asked is where the target goes: the nodes of an element at a corner may lie where J is below zero, its
    points not.
    """
    body = replace(body, mesh=replace(body.mesh, nodal=None)) if not body.guarded else body
    state, way, spent = unloaded(body), Way(np.zeros_like(goal), goal, held), 0
    most, at, increment = min(_MOST, _WORK[len(body.mesh.axes) - 2] / len(body.free)), 0.0, 1.0
    while _FEW <= most and spent < most:
        body, found = among_faces(body, replace(state, iterations=0), way.goal(at + increment), held)
        spent += found.state.iterations
        if verdict(body, way, found).reason:
            increment *= 0.5
            continue
        state, at = found.state, at + increment
        increment = min(increment * (1.5 if state.iterations <= _EASY else 1.0), 1.0 - at)
        if at == 1.0:
            return Approach(state, state.q, state.load, np.zeros(body.components), spent)
    return None
