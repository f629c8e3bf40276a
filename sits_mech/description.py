"""Describe a model of one half of the chain: what it holds, what it leaves out, what it costs.

Models are described beside their physics, in `mechanics/models.py` and `magnetics/models.py`, and by other packages as
entry points of the groups `sits_mech.mechanics` and `sits_mech.magnetics`. The chain asks all descriptions alike
(chain/models.py) and takes the cheapest model whose error, its numerics and what it leaves out, is within the
tolerance.

Costs are counts, so that a choice depends on no machine: a factorisation of n unknowns takes about n^p operations, with
p = 3 for dense matrices and 2 for sparse ones (1.5 in the plane and 2 in space by nested dissection, A. George, SIAM J.
Numer. Anal. 10 (1973) 345, and the fronts of high orders on top). Seconds are for display.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any, NamedTuple

from sits_mech.notes import Omission
from sits_mech.quantities import Array, Impedance, Pose, Wrench
from sits_mech.scene.sensor import Sensor


@dataclass(frozen=True)
class Question:
    """What a half of the chain is asked about a scene.

    Attributes
    ----------
    tolerance : float
        Of the answer, relative.
    loads : tuple of Wrench
        Empty where poses are given [N, N m].
    pose : Pose or None
        One or many, where known [m, rad].
    answer : (Pose, Impedance) or None
        What the coils show somewhere, by which sizes are estimated: the answer itself, or a coarse one at rest.
    moves : tuple of str or None
        Components of the pose that loads may change; None where no loads move the target.
    closely : bool
        Whether sizes may take a solve, as those of an answer; else they are estimated by closed forms.
    """

    tolerance: float = 1e-2
    loads: tuple[Wrench, ...] = ()
    pose: Pose | None = None
    answer: tuple[Pose, Impedance] | None = None
    moves: tuple[str, ...] | None = None
    closely: bool = False

    @property
    def out_of_plane(self) -> tuple[str, ...]:
        """Names of the components of loads and poses that leave the plane y = 0."""
        given: Iterable[Wrench | Pose] = self.loads if self.pose is None else (*self.loads, self.pose)
        return tuple(sorted({name for each in given for name in each.out_of_plane}))

    @property
    def answers(self) -> int:
        """How many answers it takes."""
        return max(len(self.loads), 1 if self.pose is None else self.pose.components[..., 0].size)


class Refusal(NamedTuple):
    """Why a model does not hold a scene: which input, what it must be, what came."""

    key: str
    must: str
    got: str

    def __str__(self) -> str:
        """Return it in one line."""
        return f"{self.key} must {self.must}; got {self.got}"


class Rung(NamedTuple):
    """Counts of a model from a tolerance on, of a typical scene, and seconds of processor time for display."""

    tolerance: float
    unknowns: int
    factorisations: int
    once: float  # [s] for a scene
    each: float  # [s] for a load or a pose


class Cost(NamedTuple):
    """What an answer takes."""

    operations: float
    unknowns: int
    factorisations: int
    answers: int
    seconds: float  # [s], of processor time, where `benchmarks/solve_costs.py` ran


@dataclass(frozen=True)
class Description:
    """A model, before it is made.

    Attributes
    ----------
    name : str
        As on the command line.
    factory : str or callable
        Takes a scene and a tolerance to the model; "module:function" is imported when it is first made.
    refusal : callable
        Scene and question to the reason why the model does not hold them, or None.
    omissions : callable
        Scene and question to what the model leaves out of them.
    rungs : tuple of Rung
        From coarse to fine; the last one from tolerance zero on.
    least : float
        Relative error that its finest rung reaches.
    power : float
        Of the unknowns, in the operations of a factorisation.
    fresh : bool
        Whether each answer takes factorisations of its own.
    bends : bool
        Whether its target can bend.
    per_metre : bool
        Whether it answers per metre of depth.
    share : float
        Of the tolerance of loads, what is asked of a magnetic model: a tenth, or more where that costs much.
    even : bool
        Whether it takes the current in the coils' tracks as even; what uneven current adds is added to its answers.
    """

    name: str
    factory: str | Callable[[Sensor, float], Any]
    refusal: Callable[[Sensor, Question], Refusal | None]
    omissions: Callable[[Sensor, Question], tuple[Omission, ...]]
    rungs: tuple[Rung, ...]
    least: float
    power: float = 3.0
    fresh: bool = True
    bends: bool = False
    per_metre: bool = False
    share: float = 0.1
    even: bool = False

    def rung(self, tolerance: float) -> Rung:
        """Return the counts and seconds to a tolerance."""
        return next(rung for rung in self.rungs if rung.tolerance <= tolerance)

    def cost(self, question: Question) -> Cost:
        """Return what the answers of a question take."""
        rung, count = self.rung(question.tolerance), question.answers
        times = rung.factorisations * (count if self.fresh else 1)
        seconds = rung.once + count * rung.each
        return Cost(times * float(rung.unknowns) ** self.power, rung.unknowns, times, count, seconds)

    def reached(self, tolerance: float) -> float:
        """Return the error of the numerics to expect where a tolerance is asked for."""
        return max(tolerance, self.least)

    def __call__(self, sensor: Sensor, tolerance: float) -> Any:
        """Return the model of a scene to a tolerance."""
        return function(self.factory)(sensor, tolerance)


def function(place: str | Callable[..., Any]) -> Callable[..., Any]:
    """Return the function at "module:function", imported when it is first asked for."""
    if callable(place):
        return place
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)  # type: ignore[no-any-return]


def total(left_out: Iterable[Omission]) -> float:
    """Return the error of all that counts; NaN where something of it has no size."""
    return sum(item.size for item in left_out if item.counts)


def sized(left_out: Iterable[Omission]) -> float:
    """Return the error of all that counts and has a size."""
    return sum(item.size for item in left_out if item.counts and not math.isnan(item.size))


def added(report: Any, left_out: tuple[Omission, ...], size: float | None = None) -> Any:
    """Return a report that lists omissions, and whose error holds `size` of them, or those that its own does not."""
    size = sized(item for item in left_out if not item.included) if size is None else size
    return replace(
        report, estimated_error=report.estimated_error + size, left_out=(*report.left_out, *left_out)
    )


def by_component(item: Omission, displacement: Array) -> Array:
    """Return what an omission of the mechanics changes of a pose, by component; shape (..., 6) [m, rad]."""
    parts = item.parts or (item.size,) * displacement.shape[-1]
    return displacement * parts
