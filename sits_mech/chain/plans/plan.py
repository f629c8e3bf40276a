"""Plan a request: its models and why they are taken, what they leave out, the error, what smaller ones would take."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from sits_mech.arguments import checked_arguments
from sits_mech.chain.interpolate import solved_likely
from sits_mech.chain.models import (
    MAGNETICS,
    MECHANICS,
    Choice,
    choose_magnetics,
    choose_mechanics,
    chosen,
    magnetic_question,
)
from sits_mech.chain.omitted.mechanical import mechanical_omissions
from sits_mech.chain.plans.aimed import aimed_mechanics
from sits_mech.chain.plans.goal import HALF, goal_of
from sits_mech.chain.plans.prices import (
    LoadForecast,
    MeshForecast,
    first_rest,
    forecast_load,
    forecast_touch,
    predicted,
    refused_or,
)
from sits_mech.chain.propagation import poses_of, unloaded_pose
from sits_mech.chain.rests import check_way
from sits_mech.description import Description, Question, sized
from sits_mech.magnetics.omitted.ends import ROUGH
from sits_mech.mechanics.models import strain_bound
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.mechanics.touch import on_target, touched
from sits_mech.notes import Note, NoteKind, Omission, OmissionKind, Relative
from sits_mech.quantities import Equilibrium, Impedance, Pose, SolveFailed, Wrench
from sits_mech.scene.sensor import Sensor, shape_on_cover, silicones_of, untested_notes
from sits_mech.scene.thermal import at_temperature
from sits_mech.silicone.material import implausible
from sits_mech.units import checked_tolerance

POSE_GIVEN = Omission(OmissionKind.POSE_GIVEN, relative_to=Relative.DISPLACEMENT)
_HELD = 0.4  # small strain's bound from which on pads gave way: in shear; compression goes to some 1.5
_LOOKED = 5.0  # seconds by counts beyond which a load's first meshes are not solved for its plan
_AMONG = 1.0  # seconds more for a load, or a pose, among conductors: 0.5 over a ground plane, more among several plates
_OUTLINE = 15.0  # seconds more for each fixed plate of any outline: no symmetry shares its cells


@dataclass(frozen=True)
class PlannedHalf:
    """A half of the chain on a rung of its model's ladder."""

    half: str  # "mechanics" or "magnetics"
    model: str
    tolerance: float  # asked, relative
    error: float  # the same, but not below what the finest rung reaches
    seconds: float  # processor time to expect
    whole: float = math.nan  # error of the request with it


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
        What smaller errors would take: each half on its next rungs, or by another model.
    left_out : tuple of Omission
        With sizes, of both halves.
    error : float
        Error to expect, over the signals' full scale: the pose's, as its first meshes show it under one load, else its
        tolerance; the magnetics' and the omissions'; of each half no less than its finest rung reaches.
    unbounded : tuple of Omission
        What is left out and in no error, because its size is not known.
    seconds : float
        Processor time to expect on the machine that the ladders were measured on; within a factor of some three.
    notes : tuple of Note
        What speaks against the request: loads that may be too large, constants that no silicone has.
    """

    mechanics: Choice | None
    magnetics: Choice
    steps: tuple[PlannedHalf, ...]
    finer: tuple[PlannedHalf, ...]
    left_out: tuple[Omission, ...]
    error: float
    unbounded: tuple[Omission, ...]
    seconds: float
    notes: tuple[Note, ...] = ()

    @property
    def rungs(self) -> tuple[str, ...]:
        """The rung of each half's ladder that the tolerance picks."""
        return tuple(f"{step.model} at {step.tolerance:.1g}" for step in self.steps)


@checked_arguments
def plan(
    sensor: Sensor, loads: Sequence[Wrench] = (), *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto",
) -> Plan:
    """Return what a request takes, what it leaves out, and what to expect of it.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    loads : sequence of Wrench
        Those asked for; none where poses are given.
    tolerance, mechanics, magnetics
        As for `simulate`.

    Raises
    ------
    SceneError
        When a model is unknown or cannot hold the scene.

    Examples
    --------
    >>> result = sm.plan(sm.load_sensor("biorob2018"), [sm.Wrench(F_z=1.0)])
    >>> result.mechanics.name, result.magnetics.name
    ('block', 'sheets')
    """
    sensor, asked = at_temperature(sensor), checked_tolerance(tolerance)
    layer = aimed_mechanics(sensor, mechanics, asked, loads, magnetics)[1] if loads else None
    solved, field = choose_magnetics(sensor, magnetics, loads, asked, loaded=bool(loads))
    forecast = _forecast(sensor, layer, (solved, field.name), loads, asked)
    pairs = list(_halves(sensor, solved, (layer, field), loads, forecast))
    steps = tuple(step for step, _ in pairs)
    left_out = (POSE_GIVEN,) if layer is None else mechanical_omissions(sensor, layer.name, loads, bent=layer.bent)
    left_out += (*magnetic_omissions(sensor, field, loads, at_rest=True), *_between(loads, layer, asked))
    error = sum(step.error for step in steps) + sized(left_out)
    notes = (*(forecast.notes if isinstance(forecast, MeshForecast) else ()), *_notes(sensor, loads, forecast))
    return Plan(
        layer, field, steps, _better((layer, field), pairs, left_out, error), left_out, error,
        tuple(item for item in left_out if item.unbounded), sum(step.seconds for step in steps), notes,
    )


def counted_cost(
    sensor: Sensor, choice: Choice | None, loads: Sequence[Wrench], *, via: bool = False
) -> LoadForecast | None:
    """Return what one load, or the last on a path `via` others, takes by counts; None of other models and tables."""
    if choice is None or not (via or len(loads) == 1):
        return None
    acting = on_target(sensor, loads)
    return forecast_touch(sensor, acting[-1], choice.name) or (
        forecast_load(sensor, acting) if choice.name == "block" else None
    )


def planned_seconds(
    sensor: Sensor, loads: Sequence[Wrench], *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str | None = "auto",
) -> tuple[list[tuple[str, float]], LoadForecast | None]:
    """Return model and seconds that each half of a load, or a path of some, is to take by counts.

    With what the counts are of a pad in space. Nothing is solved; `magnetics` None: the target's pose alone.
    """
    sensor, asked = at_temperature(sensor), checked_tolerance(tolerance)
    check_way(sensor, loads)
    layer = choose_mechanics(sensor, mechanics, loads, asked)
    ahead = counted_cost(sensor, layer, loads, via=True)
    halves = [(layer, MECHANICS)]
    if magnetics is not None:
        question = magnetic_question(sensor, asked, loads, loaded=True)
        halves.append((chosen("magnetics", MAGNETICS, sensor, question, magnetics, loaded=True), MAGNETICS))
    own = Question(asked, loads=tuple(loads[-1:]))
    seconds = [(choice.name, models[choice.name].cost(replace(own, tolerance=choice.tolerance)).seconds)
               for choice, models in halves]
    if ahead is not None:
        seconds[0] = layer.name, ahead.seconds
    return seconds, ahead


def table_seconds(
    sensor: Sensor, given: Sequence[Wrench] | Sequence[Pose], tolerance: float, *, mechanics: str = "auto",
    magnetics: str | None = "auto",
) -> tuple[list[float], float, float]:
    """Return the seconds of each load of a table that is solved, on its model's first meshes, and of the coils.

    Of the coils those of what is prepared once, and of all loads, or of poses that are `given`. Pads in space by
    counts, others by their records; nothing is solved. `magnetics` None: the target's pose alone.
    """
    loads, each = [load for load in given if isinstance(load, Wrench)], list[float]()
    if loads:
        layer = choose_mechanics(sensor, mechanics, loads, tolerance)
        ahead = [counted_cost(sensor, layer, [load]) for load in symmetry_of(sensor).without_images(_solved(loads))]
        each = [MECHANICS[layer.name].rungs[0].each if forecast is None else forecast.seconds for forecast in ahead]
    if magnetics is None:
        return each, 0.0, 0.0
    question = magnetic_question(sensor, tolerance, given, loaded=bool(loads))
    field = chosen("magnetics", MAGNETICS, sensor, question, magnetics, loaded=bool(loads))
    rung = MAGNETICS[field.name].rung(field.tolerance)
    return each, rung.once, len(given) * rung.each


def _solved(loads: Sequence[Wrench]) -> Sequence[Wrench]:
    """Return the loads of a request that are solved; the others lie between."""
    return solved_likely(loads) if loads else loads


def _halves(
    sensor: Sensor, solved: Sensor, chosen: tuple[Choice | None, Choice], loads: Sequence[Wrench],
    forecast: MeshForecast | LoadForecast | None,
) -> Iterator[tuple[PlannedHalf, list[PlannedHalf]]]:
    """Yield what is solved of each half, as its first meshes show it, and what its next two rungs would take."""
    layer, field = chosen
    if layer is not None:
        count = len(symmetry_of(sensor).without_images(_solved(loads)))
        step, finer = _rungs("mechanics", MECHANICS[layer.name], layer.tolerance, count)
        yield _as_forecast(step, forecast), finer if forecast is None else []
    plates = solved.conductors if field.name == "sheets" else ()
    count = max(len(loads), 1)
    more = bool(plates) * _AMONG * count + sum(part.shape == "outline" for part in plates) * _OUTLINE
    step, finer = _rungs("magnetics", MAGNETICS[field.name], field.tolerance, count, more)
    yield _as_forecast(step, forecast), finer


def _rungs(
    half: str, model: Description, own: float, count: int, more: float = 0.0
) -> tuple[PlannedHalf, list[PlannedHalf]]:
    """Return a half on the rung of a tolerance, and on the next two."""

    def step(at: float) -> PlannedHalf:
        question = Question(at, loads=(Wrench(),) * count)
        return PlannedHalf(half, model.name, at, model.reached(at), model.cost(question).seconds + more)

    finer = [max(rung.tolerance, model.least) for rung in model.rungs]
    return step(own), [step(at) for at in list(dict.fromkeys(at for at in finer if at < own))[:2]]


def _better(
    chosen: tuple[Choice | None, Choice], pairs: Sequence[tuple[PlannedHalf, list[PlannedHalf]]],
    left_out: Sequence[Omission], error: float,
) -> tuple[PlannedHalf, ...]:
    """Return other models and finer rungs of the ones taken by which the error would be smaller, with that error."""
    found = list[PlannedHalf]()
    for own, finer in pairs:
        choice = next(each for each in chosen if each is not None and each.name == own.model)
        rest = error - own.error - sized(item for item in left_out if item.half == own.half)
        found += (
            PlannedHalf(own.half, each.model.name, each.tolerance, each.error, each.cost.seconds, rest + each.error)
            for each in choice.candidates if each.cost is not None and each.model.name != own.model
        )
        found += (replace(step, whole=error - own.error + step.error) for step in finer)
    return tuple(step for step in found if step.whole < error)


def _between(loads: Sequence[Wrench], layer: Choice | None, tolerance: float) -> tuple[Omission, ...]:
    """Return the loads between solved ones."""
    first = _solved(loads)
    if layer is None or len(first) == len(loads):
        return ()
    numbers = (("solved", len(first)), ("all", len(loads)))
    return (Omission(OmissionKind.BETWEEN, tolerance, included=True, numbers=numbers),)


def magnetic_omissions(
    sensor: Sensor, field: Choice, loads: Sequence[Wrench] = (), answer: tuple[Pose, Impedance] | None = None, *,
    at_rest: bool = False,
) -> tuple[Omission, ...]:
    """Return all that a request leaves out of the coils, what it spares without an error as well.

    `answer` is what the coils show at a pose; without it they are solved coarsely `at_rest`, or sizes are those
    estimated beforehand.
    """
    question = magnetic_question(sensor, field.tolerance, loads, loaded=bool(loads))
    if answer is not None:
        question = replace(question, pose=answer[0], answer=answer, closely=True)
    elif at_rest:
        question = _at_rest(sensor, question, field)
    found = MAGNETICS[field.name].omissions(sensor, question)
    return (*found, *(item for item in field.left_out if item.kind == OmissionKind.FAR))


def _at_rest(sensor: Sensor, question: Question, field: Choice) -> Question:
    """Return a question with a coarse answer of the coils with the target at rest, for sizes that need one."""
    coupled = len(sensor.coils) > 1 and sensor.readout.idle_coil != "open"
    if sensor.elastomer is None or not (coupled or any(item.size != 0.0 for item in field.left_out)):
        return question
    if field.name == "sheets" and sensor.conductors:  # seconds among other metal
        return question
    try:
        rest = unloaded_pose(sensor)
        found = MAGNETICS[field.name](sensor, ROUGH).impedance(rest, sensor.frequency)
    except (SolveFailed, ValueError):
        return question
    return replace(question, answer=(rest, found))


def _forecast(
    sensor: Sensor, choice: Choice | None, coils: tuple[Sensor, str], loads: Sequence[Wrench], tolerance: float
) -> MeshForecast | LoadForecast | None:
    """Return what the first meshes show of one load at finite strain, for the signals of a coarse model.

    Its counts where these meshes are dear and the first does not refuse it, and of a shape on a cover, whose strain has
    no bound.
    """
    ahead = counted_cost(sensor, choice, loads)
    if ahead is not None and ahead.seconds > _LOOKED * (shape_on_cover(sensor) is None):
        return refused_or(ahead, sensor, *on_target(sensor, loads))
    if choice is None or len(loads) != 1 or strain_bound(sensor, loads) == math.inf:
        return None
    first = first_rest(touched(MECHANICS[choice.name](sensor, tolerance), sensor), loads[0])
    if not isinstance(first, Equilibrium):
        return first
    solved, field = coils[0], MAGNETICS[coils[1]]
    try:
        goal = goal_of(solved, field(solved, ROUGH), [first.pose])
    except (SolveFailed, ValueError):
        goal = None
    if goal is None:  # the pose's own, where no coil can be solved
        return predicted(first.report, first.report.estimated_error, tolerance)
    forecast = predicted(first.report, goal.mechanics(poses_of([first])), tolerance)
    least = goal.magnetics * min(field.share * tolerance / ROUGH, 1.0)
    return forecast._replace(magnetics=min(least, HALF * tolerance))


def _as_forecast(step: PlannedHalf, forecast: MeshForecast | LoadForecast | None) -> PlannedHalf:
    """Return a step as the load's first meshes show it, or as it is counted."""
    if forecast is None:
        return step
    if isinstance(forecast, LoadForecast):
        return replace(step, seconds=forecast.seconds) if step.half == "mechanics" else step
    if step.half == "mechanics":
        return replace(step, error=forecast.error, seconds=forecast.seconds)
    return step if forecast.magnetics is None else replace(step, error=forecast.magnetics)


def _notes(sensor: Sensor, loads: Sequence[Wrench], forecast: MeshForecast | LoadForecast | None) -> tuple[Note, ...]:
    """Return what speaks against a request, besides what was forecast of it."""
    bound = strain_bound(sensor, loads)
    found = list[Note]()
    if sensor.elastomer is not None:
        found += _overhang(sensor)
        lines = (text for silicone in silicones_of(sensor) for text in implausible(silicone))
        found += (Note.of(NoteKind.STATED, text=text) for text in (*lines, *untested_notes(sensor)))
    if not isinstance(forecast, MeshForecast) and loads and _HELD < bound < math.inf:
        found.append(Note.of(NoteKind.LARGE_LOAD, bound=bound, held=_HELD))
    return tuple(found)


def _overhang(sensor: Sensor) -> tuple[Note, ...]:
    """Return how a target is treated where it is wider than its elastomer."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        return ()
    over = 0.5 * max(own - pad for own, pad in zip(target.extent, elastomer.extent, strict=True))
    return (Note.of(NoteKind.OVERHANG, over=over),) if over > 1e-9 * elastomer.thickness else ()
