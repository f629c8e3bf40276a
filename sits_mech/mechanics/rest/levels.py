"""How does a layer solved on a family of meshes become a pose with its error?

What a layer does for its target converges on meshes whose cells are divided into m = 1, 2, 3, ... parts as

    y_m = y + a m**-p + b m**-2p + ...

with p the order that the singular edges and the grading towards them decide (pad/). Two neighbours give

    Y_k = y_k + (y_k - y_(k-1)) / ((m_k/m_(k-1))**p - 1),

which the second term leaves off by b/(m_k m_(k-1))**p, so that two of them tell what is left in the later:

    error = |Y_k - Y_(k-1)| / ((m_k/m_(k-2))**p - 1)  +  s |Y_k - y_k|,

s what the order may be off by. The order that three levels show, from the ratio of their differences, must not lie
far below p, or the sequence is not there yet: then the error is all of the two differences, and is said. With two levels
alone the error is ``|Y - y|``. No component is called better than a share of the worst, an angle counted at the
target's end; of forces that hold the target, likewise.

The first two levels are brought to rest (path.py), the second from the first one's state. On finer ones the target's
place is corrected by Newton steps from the state of the level before, until it stays; corners need not come to rest
for that, and where a finer mesh turns inside out there, its state begins nearer to that of the first level.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; J. Xu, SIAM J. Numer. Anal. 33 (1996) 1759, Newton
steps from coarse solutions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.element.prolongation import Prolongation
from sits_mech.mechanics.element.target import bonded_displacement
from sits_mech.mechanics.rest.body import Bonded, State, rest
from sits_mech.mechanics.rest.limit import Outcome
from sits_mech.mechanics.rest.newton import Held, approached, newton
from sits_mech.mechanics.rest.path import follow
from sits_mech.mechanics.rest.verdict import Way, verdict
from sits_mech.quantities import Array

FEWEST = 3
"""Levels of an answer, if they can be had."""
_UNSURE = 0.1  # of what extrapolation adds: the order may be off
_SHOWN = 0.5  # of the order must be shown by three levels
_ENOUGH = 0.02  # of the difference of two levels: a correction that is closer is not gone on with
_LEAST_J = 0.15  # of a state that Newton's method begins with
_GIVEN_UP = 0.25  # smallest increment of a path on a level that no state is carried to
_MOST = 40  # iterations there
_BLENDS = 12  # times that cells are drawn towards a safe state, by a quarter each


@dataclass(frozen=True, eq=False)
class Levels:
    """A family of meshes of a layer.

    Attributes
    ----------
    sizes : tuple of float
        m of each level, rising; two or more.
    maker : callable
        Level -> meshed layer; remembers what it made.
    carrier : callable
        Level -> what carries states to it from the level before; None where there is none.
    order : float
        p.
    share : float
        Of the worst component's error that every component owns to.
    """

    sizes: tuple[float, ...]
    maker: Callable[[int], Bonded]
    carrier: Callable[[int], Prolongation | None]
    order: float
    share: float

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


class Limit(NamedTuple):
    """What a sequence tends to, shape (k,), its error, and the order that its last three levels show (nan: two)."""

    value: Array
    error: Array
    order: float

    def words(self, expected: float) -> tuple[str, ...]:
        """Return what is to be said of the sequence, where another order is expected."""
        if not self.order < _SHOWN * expected:
            return ()
        seen = f"the meshes are too coarse for their order: {self.order:.2g} seen, {expected:.3g} expected"
        return (f"{seen}; the error covers it",)


def extrapolated(values: list[Array], sizes: tuple[float, ...], order: float) -> Limit:
    """Return the limit of what some levels gave, two or more.

    Parameters
    ----------
    values : list of ndarray, shape (k,)
        Components that count alike: lengths, an angle as the way of the target's end.
    sizes : tuple of float
        m of each.
    order : float
        p.
    """
    m = np.array(sizes[: len(values)])
    added = [(b - a) / ((n / k) ** order - 1.0) for a, b, k, n in zip(values[:-1], values[1:], m[:-1], m[1:], strict=True)]
    ends = [y + more for y, more in zip(values[1:], added, strict=True)]
    if len(values) == 2:
        return Limit(ends[-1], np.abs(added[-1]), np.nan)
    apart, gone = ends[-1] - ends[-2], values[-1] - values[-2]
    shown = shown_order(float(np.linalg.norm(values[-2] - values[-3])), float(np.linalg.norm(gone)), m[-3:])
    if shown < _SHOWN * order:
        return Limit(ends[-1], np.abs(apart) + np.abs(added[-1]), shown)
    left = np.abs(apart) / ((m[-1] / m[-3]) ** order - 1.0)
    return Limit(ends[-1], left + _UNSURE * np.abs(added[-1]), shown)


def shown_order(first: float, second: float, sizes: Array) -> float:
    """Return the p for which two differences of three levels are as ``m_1^-p - m_2^-p`` to ``m_2^-p - m_3^-p``."""
    orders = np.linspace(0.05, 8.0, 160)
    a, b, c = sizes[:, None] ** -orders
    return float(np.interp(first / max(second, 1e-300), (a - b) / (b - c), orders))


def carried(levels: Levels, level: int, state: State, safe: Array) -> tuple[State, Array] | None:
    """Return a state on the next level, and displacements there that are safe from turning inside out.

    Parameters
    ----------
    levels : Levels
    level : int
        The next one.
    state : State
        On the level before.
    safe : ndarray
        Displacements there of the first level's state.

    Returns
    -------
    State and ndarray, or None
        None where there is no way there, or even safe displacements turn some cell inside out.
    """
    way, body = levels.carrier(level), levels.maker(level)
    if way is None:
        return None
    bonded = bonded_displacement(body.X, state.q)[:, list(body.mesh.axes)]
    u, near = (np.asarray(way.displacements(each)) for each in (state.u, safe))
    u[body.bonded] = near[body.bonded] = bonded
    d = len(body.mesh.axes)
    share = np.zeros(len(body.mesh.nodes))
    for _ in range(_BLENDS):
        blend = u + np.repeat(share, d) * (near - u)
        J = deformation(body.mesh, blend)[1].min(axis=1)
        if J.min() > _LEAST_J:
            found = State(blend, state.q, way.pressures(state.p), state.load, min_J=float(J.min()))
            return found, near
        touched = np.unique(body.mesh.cells[_LEAST_J >= J])
        share[touched] = np.minimum(share[touched] + 0.25, 1.0)
    return None


def next_at_rest(levels: Levels, state: State, way: Way) -> Outcome | None:
    """Return the second level at rest at the end of a path, from the first one's state there; None where it is not."""
    body, start = levels.fine, carried(levels, 1, state, state.u)
    if start is None:
        return None
    found = newton(body, start[0], way.end, way.held)
    said = verdict(body, way, found)
    return None if said.reason else Outcome(replace(found.state, min_J=said.min_J), 1.0)


def finer(levels: Levels, states: tuple[State, State], aim: tuple[Held, Array]) -> Iterator[State]:
    """Yield the states of the third level and the ones after it, the target where it rests, as far as they get there.

    Parameters
    ----------
    levels : Levels
    states : tuple of State
        Of the first two levels, at rest.
    aim : ndarray and ndarray
        Which places are held, and what is given.
    """
    (before, state), (held, goal) = states, aim
    way = levels.carrier(1)
    safe = before.u if way is None else np.asarray(way.displacements(before.u))
    for level in range(2, len(levels.sizes)):
        body = levels.maker(level)
        enough = _ENOUGH * body.length(state.q - before.q)
        start = None if levels.carrier(level) is None else carried(levels, level, state, safe)
        if levels.carrier(level) is None:
            found = _from_rest(body, held, goal)
        else:
            near = None if start is None else approached(body, start[0], goal, held, enough)
            found = None if near is None else near[0]
        if found is None:
            return
        before, state, safe = state, found, safe if start is None else start[1]
        yield state


def _from_rest(body: Bonded, held: Held, goal: Array) -> State | None:
    """A body under what is given, along a path from rest; None where that ends before."""
    found = follow(body, rest(body), (np.zeros_like(goal), goal), smallest=_GIVEN_UP, held=held, most=_MOST)
    return found.state if found.reached == 1.0 else None
