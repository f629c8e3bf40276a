"""A path of loads and places, and how a way along it ended: the last state, how far it is, and why not farther."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.target import between, work_of_load
from sits_mech.mechanics.equilibrium.body import Bonded, State
from sits_mech.quantities import Array, Mask


class PathEnd(StrEnum):
    """Why a load path ended."""

    NONE = ""  # it got there; of a state: it counts
    BUCKLED = "buckled"  # stability is lost
    SIDEWAYS = "sideways"  # the same, out of the plane of symmetry
    TURNED = "turned"  # the load is largest
    INVERTED = "inverted"  # J <= 0 somewhere
    LOST = "lost"  # no state at rest nearby
    SLIPPING = "slipping"  # pressures under friction did not settle
    LONG = "long"  # too many iterations
    SUNK = "sunk"  # what presses has no room below
    BEYOND = "beyond"  # far beyond the data of the silicone's law


REASONS = {
    PathEnd.BUCKLED: "beyond this load the layer buckles: its equilibrium is unstable",
    PathEnd.SIDEWAYS: "beyond this load the layer buckles out of its plane of symmetry: its equilibrium is unstable",
    PathEnd.TURNED: (
        "this is the largest load of its kind that the layer carries: there is no equilibrium nearby beyond it"
    ),
    PathEnd.INVERTED: "beyond this load the mesh turns inside out at a corner",
    PathEnd.LOST: (
        "beyond this load no equilibrium was found, though the last one is stable: a smaller load may converge"
    ),
    PathEnd.SLIPPING: "beyond this load the contact pressures under friction do not converge",
    PathEnd.LONG: "the path to this load takes longer than the limit of time (--seconds)",
    PathEnd.SUNK: "beyond this load what presses on the cover sinks in by its radius, or by the cover's thickness",
    PathEnd.BEYOND: "beyond this load the silicone is stretched further than it was tested, and no law is known there",
}
"""Messages by the reason of an `Outcome`."""


FREE = np.zeros(0, dtype=bool)
"""No component's place is given."""


@dataclass(frozen=True)
class Path:
    """The way through corners, straight from each to the next."""

    corners: tuple[Array, ...]  # (k,) each, scaled: forces F_x, F_z, M, ...; d_h, d_z, alpha, ... where held
    held: Mask = field(default_factory=lambda: FREE)  # (k,), components whose places are given
    out_of_plane: Mask | None = None  # (3,), out-of-plane components that are given; None: none

    def __post_init__(self) -> None:
        """Give every component a word."""
        if not len(self.held):
            object.__setattr__(self, "held", np.zeros(len(self.corners[0]), dtype=bool))

    @property
    def legs(self) -> int:
        """Number of ways from corner to corner."""
        return len(self.corners) - 1

    @property
    def slope(self) -> Array:
        """Derivative of what is given by the part of the last leg."""
        return self.corners[-1] - self.corners[-2]

    def at(self, part: float) -> Array:
        """Return what is given after so many legs and a part of one."""
        leg = min(int(part), self.legs - 1)
        share = part - leg
        return (1.0 - share) * self.corners[leg] + share * self.corners[leg + 1]


class Arc(NamedTuple):
    """A plane across a path, ``normal . (q - origin) = ahead``; all of shape (k,), scaled."""

    origin: Array
    normal: Array
    ahead: float
    slope: Array  # derivative of what is given by the part of the path


class StepTarget(NamedTuple):
    """Target of a step: held places with the gaps to them, and the arc with the distance left."""

    held: Mask
    gap: Array
    arc: Arc | None = None
    ahead: float = 0.0


def aim_of(here: State, end: Array, held: Mask, arc: Arc | None) -> StepTarget:
    """Return the gaps to the held places and to the plane of an arc."""
    gap = np.where(held, between(here.q, np.where(held, end, here.q)), 0.0)
    if arc is None:
        return StepTarget(held, gap)
    return StepTarget(held, gap, arc, arc.ahead - float(arc.normal @ between(arc.origin, here.q)))


def bordered(body: Bonded, q: Array, stiffness: Array, held: Mask, path: tuple[Array, Array]) -> Array:
    """Return the matrix of a step (dq, dF, dt) along a path (slope, normal); dt is given where the normal is zero."""
    k, (slope, across) = body.components, path
    matrix = np.zeros((2 * k + 1, 2 * k + 1))
    matrix[:k, :k] = stiffness
    matrix[:k, k:-1] = -np.stack([work_of_load(unit, body.height, q)[:k] for unit in np.eye(k)], axis=1)
    matrix[k:-1, :k], matrix[k:-1, k:-1] = np.diag(1.0 * held), np.diag(1.0 * ~held)
    matrix[k:-1, -1] = -slope
    matrix[-1, :k], matrix[-1, -1] = across, 1.0 * (not across.any())
    return matrix


@dataclass(frozen=True)
class Outcome:
    """The end of a way: of Newton's method, or of a path.

    At rest S (k, k) is the stiffness of the target, empty if unknown; `odd` that on motions hidden by symmetry, if any.
    """

    state: State  # of a path, the last one at rest
    reached: float = 1.0  # part of the path, or its legs that were gone; 1, or all of them, is the whole
    reason: PathEnd = PathEnd.NONE  # why not farther; against the state, if it does not count
    limit_point: tuple[float, float] | None = None  # fraction carried and its tolerance on this mesh, if any
    stiffness: float = np.nan  # smallest eigenvalue of S and `odd`; inf if all places are held, nan if unknown
    hidden: float = np.nan  # that of `odd`; inf if nothing is hidden
    S: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    odd: Array | None = field(default=None, repr=False)
    length: float = 0.0  # displacement of the target's edge in the first step [thicknesses]
    off: Array = field(default_factory=lambda: np.zeros(0))  # error of q (k,) of a target that is only nearly at rest

    def after(self, other: Outcome) -> Outcome:
        """Add the iterations of a way that was tried before."""
        spent = other.state.iterations + self.state.iterations
        return replace(self, state=replace(self.state, iterations=spent))

    def over(self, begin: float, end: float) -> Outcome:
        """Map the outcome to a longer path, of which this one was from a part to another."""
        size = end - begin
        there = None if self.limit_point is None else (begin + size * self.limit_point[0], size * self.limit_point[1])
        return replace(self, reached=begin + size * self.reached, limit_point=there)


def carried(coarse: Outcome, fine: Outcome) -> tuple[float, float] | None:
    """Return the fraction of a path that is carried, with its error, from two meshes; None without a limit.

    The error is their difference, no order assumed; if only one found a limit, the difference to where the other got;
    nan if the other was not followed to its end.
    """
    own = fine.limit_point or coarse.limit_point
    if own is None:
        return None
    other = coarse if fine.limit_point is not None else fine
    if other.reason is PathEnd.LONG:
        return own[0], np.nan
    there, located = other.limit_point or (other.reached, 0.0)
    return own[0], abs(own[0] - there) + own[1] + located
