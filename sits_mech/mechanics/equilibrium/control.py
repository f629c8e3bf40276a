"""Prescribe the force or the place of the target, component by component, and scale both.

Of each pair (F_x, d_h), (F_z, sink), (M, alpha), (F_y, d_y), (M_x, alpha_x), (M_z, alpha_z) one is given, the other is
found. A layer with a largest load (it buckles, or softens) is followed past it with places given; a target held upright
is ``alpha = 0`` with M found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from sits_mech.quantities import WRENCH, Array, Equilibrium, Mask, Pose, Wrench, refuse_infinite
from sits_mech.threads import single_thread

PLACES = ("d_h", "sink", "alpha", "d_y", "alpha_x", "alpha_z")
_PAIRS = tuple(zip(WRENCH, PLACES, strict=True))


@dataclass(frozen=True)
class Control:
    """What is given of each pair, in SI as in `Wrench` and `Pose`; if neither, the force is zero."""

    F_x: float | None = None
    F_z: float | None = None
    M: float | None = None
    d_h: float | None = None
    sink: float | None = None
    alpha: float | None = None
    F_y: float | None = None
    M_x: float | None = None
    M_z: float | None = None
    d_y: float | None = None
    alpha_x: float | None = None
    alpha_z: float | None = None

    def __post_init__(self) -> None:
        """Refuse a pair with both given, and values that are no numbers."""
        for force, place in _PAIRS:
            given = [value for value in (getattr(self, force), getattr(self, place)) if value is not None]
            if len(given) > 1:
                raise ValueError(f"control: of {force} and {place} one must be given, got both")
            if given and not np.isfinite(given[0]):
                name = force if getattr(self, place) is None else place
                raise ValueError(f"control: {name} must be a finite number, got {given[0]}")

    @property
    def held(self) -> Mask:
        """Components whose places are given, shape (6,)."""
        return np.array([getattr(self, place) is not None for place in PLACES])

    @property
    def out_of_plane(self) -> tuple[str, ...]:
        """Names of what is given, not zero, that leaves the plane y = 0."""
        return tuple(name for pair in _PAIRS[3:] for name in pair if getattr(self, name))

    @property
    def in_plane(self) -> Control:
        """The control in the plane y = 0: out-of-plane places that are given are held at zero."""
        forces = dict.fromkeys(WRENCH[3:])
        places = {place: None if getattr(self, place) is None else 0.0 for place in PLACES[3:]}
        return replace(self, **forces, **places)

    @property
    def given(self) -> dict[str, float]:
        """Given values by name; out-of-plane ones only where not zero."""
        return {
            name: value for k, pair in enumerate(_PAIRS) for name in pair
            if (value := getattr(self, name)) is not None and (k < 3 or value != 0.0)
        }

    @property
    def forces(self) -> dict[str, float]:
        """Given forces by name."""
        return {name: value for name in WRENCH if (value := getattr(self, name)) is not None}

    def scaled(self, lengths: Array, loads: Array) -> Array:
        """Return the scaled control: a force, or d_h, d_z = -sink, ... where held; shape (6,).

        `lengths` and `loads` (6,) are the units of motion and load components [m, rad; N, N m].
        """
        forces = np.array([getattr(self, force) or 0.0 for force in WRENCH]) / loads
        places = np.array([getattr(self, place) or 0.0 for place in PLACES]) / lengths * _DOWN
        return np.where(self.held, places, forces)


@dataclass(frozen=True)
class Scales:
    """SI values of scaled motions and loads."""

    thickness: float  # of the layer [m]
    force: float  # unit of force [N]; moments scale with force times thickness
    standoff: float  # [m]
    share: float = 1.0  # meshed part of the pad, 0.5 or 1: the body carries that share of the target's load

    @property
    def lengths(self) -> Array:
        """Units of the components of q, shape (6,) [m, rad]."""
        t = self.thickness
        return np.array([t, t, 1.0, t, 1.0, 1.0])

    @property
    def loads(self) -> Array:
        """Units of the components of a load on the body, shape (6,) [N, N m]."""
        t = self.thickness
        return self.force / self.share * np.array([1.0, 1.0, t, 1.0, t, t])

    def load(self, wrench: Wrench) -> Array:
        """Return a load on the body, shape (6,)."""
        return wrench.components / self.loads

    def wrench(self, load: Array) -> Wrench:
        """Return the target's load in SI, from that on the body, shape (3,) or (6,)."""
        return Wrench(*(float(value) for value in load * self.loads[: len(load)]))

    def pose(self, q: Array) -> Pose:
        """Return the pose in SI of a motion, shape (3,) or (6,)."""
        found = q * self.lengths[: len(q)]
        found[1] += self.standoff + self.thickness
        return Pose.of(found)


_DOWN = np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])


class Controlled(Protocol):
    """A model that takes any control, and so any load and path of loads."""

    def controlled(
        self, control: Control, *, start: Equilibrium | None = None, via: Sequence[Control] = ()
    ) -> Equilibrium:
        """Return the equilibrium with forces or places given, reached from `start` or rest, via `via`."""
        ...

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench` [N, N m], reached from `start` or from rest.

        Raise SolveFailed if the load path ends before the wrench; its `last` is the last equilibrium on the way.
        """
        with single_thread():
            return self.controlled(under(wrench), start=start)

    def along(self, loads: Sequence[Wrench]) -> Equilibrium:
        """Return the equilibrium at the end of a path of loads from rest; see `PathModel`, raises as `equilibrium`."""
        *via, control = map(under, loads or [Wrench()])
        return self.controlled(control, via=via)


def under(wrench: Wrench) -> Control:
    """Return the control that gives all forces, or refuse some that are no numbers."""
    refuse_infinite(wrench)
    return Control(**vars(wrench))
