"""Choose the models of both halves of the chain: ask all descriptions, take the cheapest that is exact enough.

A model's error is that of its numerics and of all that it leaves out of the question (description.py). Of the models
that hold a scene the cheapest by counts is taken whose error is within the tolerance, the numerics having what the
omissions leave of it; where there is none, the one with the least error, and the answer's status says so. Fixed
conductors that a bound shows to be too far away to matter are left out first (omitted/conductors.py). A section that
was not asked for by name answers in henry: its change of inductance relative to the coils' own inductances in space.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.omitted.bending import bending, solved_bending
from sits_mech.chain.omitted.conductors import AmongFar, negligible, without_far
from sits_mech.chain.plans.goal import HALF
from sits_mech.chain.propagation import unloaded_pose
from sits_mech.description import Cost, Description, Question, Refusal, total
from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.models import MODELS as MAGNETIC
from sits_mech.mechanics.closed_form import is_film
from sits_mech.mechanics.models import MODELS as MECHANICAL
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.mechanics.touch import on_target, touched
from sits_mech.notes import Omission
from sits_mech.plugins import plugged
from sits_mech.quantities import POSE, WRENCH, MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.scene.materials import check_model
from sits_mech.scene.plausible import check_loads
from sits_mech.scene.sensor import Sensor, shape_on_cover
from sits_mech.scene.thermal import at_temperature
from sits_mech.units import SceneError, checked_tolerance


def _registered(own: Iterable[Description], half: str) -> dict[str, Description]:
    """Return descriptions by name: ours, and those of other packages, of which one that fails to load is passed by."""
    found = {model.name: model for model in own}
    for each in plugged(half):
        try:
            found.setdefault(each.name, each.load())
        except Exception as error:  # whatever a module of others raises
            warnings.warn(f"{half} {each.name}: {each.value} cannot be loaded: {error}", stacklevel=2)
    return found


MECHANICS: Mapping[str, Description] = _registered(MECHANICAL, "mechanics")
"""The mechanical models by name, each with its description; calling one makes the model of a scene to a tolerance."""
MAGNETICS: Mapping[str, Description] = _registered(MAGNETIC, "magnetics")
"""The magnetic models alike."""
_COARSE = 1e-2  # relative error of the change that conductors are compared with
_SIDEWAYS = [WRENCH.index(name) for name in ("F_x", "M", "F_y", "M_x")]  # what takes a target off its axis


class Why(StrEnum):
    """Why a model was taken."""

    NAMED = "named"  # asked for by name
    ONLY = "only"  # no other holds the scene
    WITHIN = "within"  # the cheapest within the tolerance
    LEAST = "least"  # none is within: the least error
    BENDS = "bends"  # the cheapest that bends the target: without it half of the tolerance were taken


class Candidate(NamedTuple):
    """A model with its error and cost for a question."""

    model: Description
    refusal: Refusal | None  # why it does not hold
    tolerance: float = math.nan  # asked of its numerics
    error: float = math.nan  # with all that it leaves out; NaN where something has no size
    left_out: tuple[Omission, ...] = ()
    cost: Cost | None = None

    @property
    def rank(self) -> tuple[float, float]:
        """The error, infinite without a size, and the operations."""
        error = math.inf if math.isnan(self.error) else self.error
        return error, math.inf if self.cost is None else self.cost.operations


@dataclass(frozen=True)
class Choice:
    """A model that was taken."""

    name: str  # as on the command line
    why: Why = Why.NAMED
    candidates: tuple[Candidate, ...] = ()  # all models, the cheapest first; those that do not hold the scene last
    left_out: tuple[Omission, ...] = ()  # what counts of it, far conductors among them, as estimated beforehand
    tolerance: float = math.nan  # asked of its numerics
    bent: bool = False  # whether a mechanical model bends the target (chain/omitted/bending.py)

    @property
    def by_name(self) -> bool:
        """Whether it was asked for by name."""
        return self.why == Why.NAMED

    def asked(self, tolerance: float) -> float:
        """Return what its numerics are asked: the tolerance itself where it was asked for by name."""
        return tolerance if self.by_name else self.tolerance


def candidates(
    known: Mapping[str, Description], sensor: Sensor, question: Question, *, loaded: bool = False
) -> tuple[Candidate, ...]:
    """Return all models with error and cost for a question: the cheapest first, those not holding the scene last."""
    found = []
    for model in known.values():
        if (refusal := model.refusal(sensor, question)) is not None:
            found.append(Candidate(model, refusal))
            continue
        left_out = model.omissions(sensor, question)
        missed = total(left_out)
        share = model.share if loaded else 1.0
        spared = question.tolerance - missed
        asked = share * (spared if spared >= model.least else question.tolerance)
        cost = model.cost(replace(question, tolerance=asked))
        found.append(Candidate(model, None, asked, model.reached(asked) + missed, left_out, cost))
    return tuple(sorted(found, key=lambda each: each.rank[1]))


def chosen(
    half: str, known: Mapping[str, Description], sensor: Sensor, question: Question, name: str = "auto", *,
    loaded: bool = False,
) -> Choice:
    """Return the model of a name, or with "auto" the cheapest of those that are exact enough.

    Raises SceneError where the model is unknown or does not hold the scene, with those that do.
    """
    check_model(half, name, ("auto", *known))
    every = candidates(known, sensor, question, loaded=loaded)
    held = [each for each in every if each.refusal is None]
    if name != "auto":
        return _taken(_named(half, sensor, name, every), Why.NAMED, every)
    if not held:
        reasons = "; ".join(f"{each.model.name}: {each.refusal}" for each in every)
        raise SceneError(f"{sensor.name}: {half} must have a model that holds the scene; got none: {reasons}")
    most = question.tolerance * (1.0 + 1e-9)  # sums of what is asked and what is left out round
    within = next((each for each in held if each.error <= most), None)
    best = within or min(held, key=lambda each: each.rank)
    why = Why.ONLY if len(held) == 1 else Why.LEAST if within is None else Why.WITHIN
    return _taken(best, why, every)


def _named(half: str, sensor: Sensor, name: str, every: Sequence[Candidate]) -> Candidate:
    """Return the model of a name, or refuse it with those that hold the scene."""
    own = next(each for each in every if each.model.name == name)
    if own.refusal is not None:
        held = " or ".join(each.model.name for each in every if each.refusal is None)
        raise SceneError(f"{sensor.name}: {half} {name}: {own.refusal}; {held or 'no other model'} would")
    return own


def _taken(own: Candidate, why: Why, every: tuple[Candidate, ...]) -> Choice:
    """Return the choice of a candidate."""
    counted = tuple(item for item in own.left_out if item.weighs)
    return Choice(own.model.name, why, every, counted, own.tolerance)


def choose_mechanics(
    sensor: Sensor, name: str = "auto", loads: Sequence[Wrench] = (), tolerance: float = 1e-2
) -> Choice:
    """Return the mechanical model for a scene with target and elastomer; SceneError where there is none."""
    for part in ("target", "elastomer"):
        if getattr(sensor, part) is None:
            raise SceneError(f"{sensor.name}: {part}: must be given for a force to move the target; it is missing")
    found = chosen("mechanics", MECHANICS, sensor, Question(tolerance, on_target(sensor, loads)), name)
    every = [each for each in found.candidates if each.refusal is None and name in ("auto", each.model.name)]
    able = next((each for each in every if each.model.bends), None)
    if able is None or _stays_rigid(sensor, found) or _bends_by(sensor, loads, able) < HALF * tolerance:
        return found
    return replace(found if MECHANICS[found.name].bends else _taken(able, Why.BENDS, found.candidates), bent=True)


def _stays_rigid(sensor: Sensor, found: Choice) -> bool:
    """Whether a target must be taken as rigid: under a shape on its cover, and on a film that `linear` answers.

    A mesh of such a film that bends would have a thousand cells across.
    """
    film = sensor.target is not None and sensor.elastomer is not None and is_film(sensor.target, sensor.elastomer)
    return shape_on_cover(sensor) is not None or (film and not MECHANICS[found.name].bends)


def _bends_by(sensor: Sensor, loads: Sequence[Wrench], able: Candidate) -> float:
    """Return what bending changes of how far loads move a target; 0 where no size is known."""
    return max((item.size for item in bending(sensor, loads, able.model.least) if not item.unbounded), default=0.0)


def magnetic_question(
    sensor: Sensor, tolerance: float, given: Sequence[Wrench] | Sequence[Pose] = (), *, loaded: bool = False
) -> Question:
    """Return the question to the magnetic models: given poses, or those to which loads move the target."""
    loads = on_target(sensor, [each for each in given if isinstance(each, Wrench)])
    moves = _moving(sensor, loads) if loaded else None
    poses = [pose.components.reshape(-1, len(POSE)) for pose in given if isinstance(pose, Pose)]
    return Question(tolerance, loads, Pose.of(np.concatenate(poses)) if poses else None, moves=moves)


def _moving(sensor: Sensor, loads: Sequence[Wrench]) -> tuple[str, ...]:
    """Return the components of the pose that loads may change; all in the plane where nothing is known of them."""
    leaves = any(load.out_of_plane for load in loads)
    sideways = any(load.components[_SIDEWAYS].any() for load in loads)
    if loads and not sideways and symmetry_of(sensor).mirrored:
        return ("d_v", "alpha_z") if leaves else ("d_v",)
    return POSE if leaves else POSE[:3]


def choose_magnetics(
    sensor: Sensor, name: str = "auto", given: Sequence[Wrench] | Sequence[Pose] = (), tolerance: float = 1e-3, *,
    loaded: bool = False,
) -> tuple[Sensor, Choice]:
    """Return what is solved of a scene, and by which magnetic model.

    `given` are poses, or loads where poses come of them (`loaded`). Without a name far conductors are left out.
    """
    question = magnetic_question(sensor, tolerance, given, loaded=loaded)
    ask = partial(chosen, "magnetics", MAGNETICS, question=question, name=name, loaded=loaded)
    if name != "auto" or not sensor.conductors:
        return sensor, ask(sensor)
    pose = question.pose if question.pose is not None else None if sensor.elastomer is None else unloaded_pose(sensor)
    if pose is None or sensor.target is None or sensor.substrate_radius is not None:
        return sensor, ask(sensor)
    bare = ask(sensor.model_copy(update={"conductors": ()}))
    model = MAGNETICS[bare.name]
    asked = model.share * tolerance if loaded else tolerance
    solved, far = without_far(sensor, lambda alone: model(alone, _COARSE), pose, asked, section=model.per_metre)
    choice = ask(solved)
    return solved, replace(choice, left_out=(*choice.left_out, *far))


@checked_arguments
def mechanical_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-2, loads: Sequence[Wrench] = ()
) -> tuple[MechanicalModel, Choice]:
    """Return the mechanical model of a name with the reason for it; its errors are those of its numerics.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    name : str
        "auto" or a key of `MECHANICS`.
    tolerance : float
        Requested relative error of the pose.
    loads : sequence of Wrench
        All loads to be solved, where they are known: small ones need less.

    Raises
    ------
    SceneError
        When the model is unknown or cannot hold the scene.

    Examples
    --------
    >>> model, choice = sm.mechanical_model(sm.load_sensor("biorob2018"), "linear")
    >>> result = model.equilibrium(sm.Wrench(F_z=0.1))
    >>> choice.name, round(1e6 * result.pose.d_v)  # um
    ('linear', 1988)
    """
    sensor = at_temperature(sensor)
    check_loads(sensor, {part: [getattr(load, part) for load in loads] for part in WRENCH})
    choice = choose_mechanics(sensor, name, loads, checked_tolerance(tolerance))
    return model_of(sensor, choice, tolerance), choice


def model_of(sensor: Sensor, choice: Choice, tolerance: float) -> MechanicalModel:
    """Return the model of a choice, to a tolerance where it was asked for by name."""
    model = MECHANICS[choice.name](sensor, choice.asked(tolerance))
    if choice.bent:
        model = model.bending(solved_bending(sensor))
    return touched(model, sensor)


@checked_arguments
def magnetic_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-3, poses: Sequence[Pose] = ()
) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model of a name of `MAGNETICS` or "auto" with the reason; as `mechanical_model`.

    If `poses` are known, the choice depends on whether they leave the plane or an axis, and conductors too far
    away to matter there are left out; otherwise the pose at rest is used. The errors of its answers hold what the
    model leaves out.

    Examples
    --------
    >>> model, choice = sm.magnetic_model(sm.load_sensor("biorob2018"), "planar")
    >>> result = model.impedance(sm.Pose(d_h=1e-3, d_v=2e-3), 5e6)
    >>> choice.name, (result.L / result.L0).diagonal().round(2).tolist()
    ('planar', [0.99, 0.93])
    """
    sensor = at_temperature(sensor)
    solved, choice = choose_magnetics(sensor, name, poses, checked_tolerance(tolerance))
    return _built(sensor, solved, choice, choice.asked(tolerance)), choice


def loaded_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-2, loads: Sequence[Wrench] = ()
) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model for poses under loads, with the reason; as `magnetic_model`."""
    sensor = at_temperature(sensor)
    solved, choice = choose_magnetics(sensor, name, loads, checked_tolerance(tolerance), loaded=True)
    return _built(sensor, solved, choice, choice.asked(MAGNETICS[choice.name].share * tolerance)), choice


def _built(sensor: Sensor, solved: Sensor, choice: Choice, tolerance: float) -> MagneticModel:
    """Return the model of a choice for the solved part of a scene; its errors hold what counts of its omissions."""
    description = MAGNETICS[choice.name]
    model: MagneticModel = description(solved, tolerance)
    flat = solved.substrate_radius is None and (solved.target is None or solved.target.net_current == "zero")
    if description.per_metre and not choice.by_name and flat:  # coils over isolated plates have henry
        model = replace(model, absolute=True)  # type: ignore[type-var]
    if description.even:
        model = Tracked(model, solved)
    far = tuple(part for part in sensor.conductors if part not in solved.conductors)
    if len(choice.left_out) > len(far):
        from sits_mech.magnetics.omitted.ends import Whole  # the coarse answers in space that sizes are taken from

        model = Whole(model, solved, description)
    return AmongFar(model, sensor, solved, description.per_metre, negligible(tolerance)) if far else model
