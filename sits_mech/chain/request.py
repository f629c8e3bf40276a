"""Plan a request: what it solves and leaves out, its error, and what finer tolerances would gain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from sits_mech.chain.ends import ROUGH
from sits_mech.chain.interpolate import solved_likely
from sits_mech.chain.omissions import ENDS, Answered, Omission, omissions, strain_bound
from sits_mech.chain.plan import Choice
from sits_mech.chain.prices import Look, Step, Steps, cost, steps
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.silicone.material import implausible

_SPACE = {"mechanics": "block", "magnetics": "sheets"}  # what a half takes instead of a section
_HELD = 0.4  # small strain's bound from which on pads were seen to give way: in shear; compression goes to some 1.5


@dataclass(frozen=True)
class Plan:
    """What a request takes, what it leaves out, and what to expect of it.

    Attributes
    ----------
    mechanics : Choice or None
        None where no load is asked for.
    magnetics : Choice
        The other half.
    steps : tuple of Step
        What is solved: a rung of each half's ladder, as the tolerance picks it.
    finer : tuple of Step
        What finer tolerances would take, each half on its next rungs.
    left_out : tuple of Omission
        With sizes.
    error : float
        Error to expect, over the signals' full scale: the pose's, as its first meshes show it under one load, else its
        tolerance; the magnetics' and the omissions'; of each half no less than its finest rung reaches.
    not_estimated : tuple of str
        What is left out and in no error, because its size is not known.
    seconds : float
        Processor time to expect on the machine that the ladders were measured on; within a factor of some three.
    notes : tuple of str
        Another model than the bare sensor's; what speaks against the request: loads that may be too large, constants
        that no silicone has.
    """

    mechanics: Choice | None
    magnetics: Choice
    steps: Steps
    finer: Steps
    left_out: tuple[Omission, ...]
    error: float
    not_estimated: tuple[str, ...]
    seconds: float
    notes: tuple[str, ...] = ()

    @property
    def rungs(self) -> tuple[str, ...]:
        """The rung of each half's ladder that the tolerance picks."""
        return tuple(f"{step.model} at {step.tolerance:.1g}" for step in self.steps)

    @classmethod
    def of(
        cls, sensor: Sensor, loads: Sequence[Wrench], tolerance: float, mechanics: Choice | None, magnetics: Choice,
        shown: Answered | None = None, seen: Look | None = None,
    ) -> Plan:
        """Return the plan of a request whose models are chosen; arguments as `models.plan` and `omissions`.

        What is `seen` of the load on its first meshes replaces the typical cost and error.
        """
        parts = [("magnetics", magnetics.name, max(len(loads), 1))]
        if mechanics is not None:
            first = solved_likely(loads)
            parts.insert(0, ("mechanics", mechanics.name, len(symmetry_of(sensor).without_images(first))))
        asked, finer = steps(parts, tolerance, bool(loads), _among(sensor, magnetics))
        if seen is not None:
            asked = tuple(_as_seen(step, seen) for step in asked)
            finer = tuple(step for step in finer if step.half != "mechanics")
        name = None if mechanics is None else mechanics.name
        auto = not (loads or magnetics.by_name)
        missing = omissions(sensor, loads, name, magnetics.name, shown, auto) + magnetics.left_out
        if mechanics is not None and len(first) < len(loads):
            reason = f"interpolated between about {len(first)} of {len(loads)} solved loads, within the tolerance"
            missing += (Omission("loads between solved ones", reason, tolerance, in_error=True),)
        sizes = [item.size for item in missing if item.counts and item.size > 0.0]
        error = sum(step.error for step in asked) + sum(sizes)
        finer = _gains(asked, _solid(parts, missing, (tolerance, bool(loads))) + finer, missing, error)
        unknown = tuple(item.what for item in missing if item.counts and math.isnan(item.size))
        notes = (*(() if seen is None else seen.notes), *magnetics.notes, *_notes(sensor, loads, seen))
        ends = [item for item in missing if item.what.startswith(ENDS) and item.in_error]
        seconds = sum(step.seconds for step in asked)
        seconds += len(ends) * cost("magnetics", "sheets", ROUGH, max(len(loads), 1))
        return cls(mechanics, magnetics, asked, finer, missing, error, unknown, seconds, notes)


def _as_seen(step: Step, seen: Look) -> Step:
    """Return a step as the load's first meshes show it."""
    if step.half == "mechanics":
        return replace(step, error=seen.error, seconds=seen.seconds)
    return step if seen.magnetics is None else replace(step, error=seen.magnetics)


def _solid(parts: Sequence[tuple[str, str, int]], missing: Sequence[Omission], asked: tuple[float, bool]) -> Steps:
    """Return the steps in space that halves with ends along y would take instead, for a tolerance, of loads or not."""
    ends = {item.half for item in missing if item.what.startswith(ENDS) and not math.isnan(item.size)}
    instead = [(half, _SPACE[half], count) for half, _, count in parts if half in ends]
    return steps(instead, *asked)[0]


def _gains(asked: Steps, finer: Steps, missing: Sequence[Omission], error: float) -> Steps:
    """Return the finer steps that reduce the error of the request, with that error."""
    found = []
    for step in finer:
        own = next(each for each in asked if each.half == step.half)
        ends = [item.size for item in missing if item.half == step.half and item.what.startswith(ENDS)]
        whole = error - own.error + step.error - (sum(ends) if step.model != own.model else 0.0)
        found.append(replace(step, whole=whole))
    return tuple(step for step in found if step.whole < error)


def _among(sensor: Sensor, magnetics: Choice) -> tuple[int, int]:
    """Return how many conductors are solved in space, and how many of them are outlines."""
    far = {item.what for item in magnetics.left_out}
    near = [part for part in sensor.conductors if f"conductors.{part.name}" not in far]
    if magnetics.name != "sheets":
        return 0, 0
    return len(near), sum(part.shape == "outline" for part in near)


def _notes(sensor: Sensor, loads: Sequence[Wrench], seen: Look | None) -> tuple[str, ...]:
    """Return what speaks against a request, beside what was seen of it."""
    bound = strain_bound(sensor, loads)
    found = () if sensor.elastomer is None else (*_overhang(sensor), *implausible(sensor.elastomer.silicone))
    if seen is not None or not loads or not _HELD < bound < float("inf"):
        return found
    known = f"some pads became unstable in shear from {_HELD:g}, in compression from about 1.5: only a solve can tell"
    return (*found, f"a large load for this pad: small strain would be off by {bound:.2g}; {known}")


def _overhang(sensor: Sensor) -> tuple[str, ...]:
    """Say how a target is treated where it is wider than its elastomer."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        return ()
    over = 0.5 * max(own - pad for own, pad in zip(target.extent, elastomer.extent, strict=True))
    if over <= 1e-9 * elastomer.thickness:
        return ()
    return (
        f"the target reaches {1e3 * over:.3g} mm over its elastomer: there it is rigid and bonded to nothing, silicone "
        "that bulges lies on it, the ground does not stop its rim, and the coils see all of it",
    )
