"""Forecast what a study takes, by a few of its cases, which are solved in this process.

    seconds = P s + C p + D q + R r + N c

for P processes, C sets of coils with their plates, D pads with their meshes and R loads that bring a pad to rest, each
counted in every process that meets it, and N cases. Coils are prepared anew for each step of the ladder of clearances
(magnetics/answer.py) that poses come to, given ones or by linear theory. A case prepares what none before it has: those
that are tried take c and some of s, p, q and r, which are zero or more and follow by least squares; where no two cases
share a rest, r is part of c. Tried are, at both ends of the run's order, a case, the next one, the first two with the
next rest, whose second may prepare nothing, and the first with the next pad; then in the middle, if those are less than
half of the forecast, and at places between, as long as all are less than a fiftieth. What the disk holds of earlier
preparations is not used. Neglected: what a case costs beside its solve (0.4 ms), and how cases differ between those
that are tried.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, islice, repeat
from pathlib import Path
from shutil import disk_usage
from typing import NamedTuple

import numpy as np
from scipy.constants import day
from threadpoolctl import threadpool_limits

from sits_mech.batch.adaptive import likely
from sits_mech.batch.run import Case, keys
from sits_mech.batch.studies.asked import Shared, Study
from sits_mech.cases import attempt, grouped
from sits_mech.chain.interpolate import loads_of
from sits_mech.chain.plans.plan import table_seconds
from sits_mech.disk_cache import nothing_kept
from sits_mech.geometry.collision import CLEARANCE
from sits_mech.magnetics.answer import clearances
from sits_mech.mechanics.closed_form import plain_pad
from sits_mech.mechanics.models import strains_of
from sits_mech.memory import GIB, input_text, peak_memory
from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS, Pose, Wrench
from sits_mech.scene.files import write_text
from sits_mech.store import Cases, Row, case_name, opened
from sits_mech.units import SceneError, si_value

_NOTE = "plan.json"
_ON_DISK = 1.4  # of the cases' file, that and the table: 1405 and 432 bytes of 100,000 cases


class StepCounts(NamedTuple):
    """Of each step of a study a number: how often it is made, or the processor seconds that it takes."""

    process: float = 0.0
    coils: float = 0.0
    pad: float = 0.0
    rest: float = 0.0
    case: float = 0.0


@dataclass(frozen=True)
class Forecast:
    """What the cases take that a study has not yet kept."""

    left: tuple[tuple[int, ...], ...]  # cases of each set of coils and clearance, of each pad, of each rest
    chunk: int  # cases that go to a process at once
    steps: StepCounts = StepCounts()  # processor seconds of each
    kept: int = 0
    tried: tuple[int, float] = (0, 0.0)  # cases, and their processor seconds
    memory: float | None = None  # of a process [bytes]

    @property
    def cases(self) -> int:
        """Cases that are left."""
        return sum(self.left[1])

    def counts(self, processes: int = 1) -> StepCounts:
        """Return how often each step is made by so many processes, of which each prepares what it meets."""
        coils, pads, rests = (sum(min(processes, -(-own // self.chunk)) for own in counts) for counts in self.left)
        return StepCounts(processes + (processes > 1) if self.cases else 0, coils, pads, rests, self.cases)

    def seconds(self, processes: int = 1) -> float:
        """Return the processor seconds of all that is left, on so many processes."""
        return float(np.dot(self.steps, self.counts(processes)))

    def wall(self, processes: int, cores: int | None = None) -> float:
        """Return the seconds until the end, if each process has a core, as far as there are some: by default here.

        The process that starts the others does so before them.
        """
        whole, first = self.seconds(processes), self.steps.process * (processes > 1 and self.cases > 0)
        return first + (whole - first) / min(processes, cores or os.cpu_count() or 1)

    @property
    def saved(self) -> StepCounts:
        """The seconds that cases do not take because they share a process, coils, a pad or its rest."""
        return StepCounts(*((self.cases - count) * each for count, each in zip(self.counts(), self.steps, strict=True)))


def forecast(
    study: Study, cases: Cases | None = None, *, extra: Callable[[], float] = float,
    report: Callable[[Forecast], None] = lambda plan: None,
) -> Forecast:
    """Try some cases of a study, keep them in `cases`, and forecast the others.

    `extra` returns the seconds that a process takes beside its cases and what the first one imports; `report` gets the
    counts, these with what the models' records say before a case is tried, and what all takes that was missing after
    the first case, and whenever twice as much was tried.
    """
    points, chunk = likely(study), study.request.chunk
    missing = _missing(study, points, cases)
    shared = _prepared(study, {index: points[index] for index in missing})
    rows, whole = dict[int, Row](), _counted(shared.values(), chunk)
    trial = _Trial(Case(study), len(whole.left[-1]) < whole.cases)
    order = list(chain.from_iterable(grouped({index: study.shared(points[index]).order for index in missing})))
    shares = chain((math.inf, math.inf, 0.5), repeat(0.02))  # of the forecast, that may have been tried before a place
    spent, kept = 0.0, len(points) - whole.cases
    report(replace(whole, kept=kept))
    recorded = _recorded(study, points[order[len(order) // 2]]) if order else whole.steps
    if any(recorded):
        report(replace(whole, steps=recorded, kept=kept))
    for near, share in zip(_places(order, shared), shares, strict=False):
        if rows and trial.spent > share * replace(whole, steps=trial.steps).seconds():
            break
        for index in near:
            if index not in rows:
                rows[index] = trial.solved(points[index], shared[index])
                if cases is not None:
                    cases.put([(missing[index], rows[index])])
                if trial.spent > 2.0 * spent:
                    spent = trial.spent
                    report(replace(whole, steps=trial.steps, kept=kept, tried=(len(rows), spent)))
    done = {index for index, row in rows.items() if row["lasting"]}  # another try may better the others
    left = whole if cases is None else _counted([own for index, own in shared.items() if index not in done], chunk)
    steps = trial.steps
    return replace(
        left, steps=steps._replace(process=steps.process + extra()), kept=len(points) - left.cases,
        tried=(len(rows), trial.spent), memory=peak_memory(),
    )


def _recorded(study: Study, point: Row) -> StepCounts:
    """Return the processor seconds of a case's steps by its models' records; zeros of a case that is none."""
    units = study.request.units
    try:
        variant, asked = study.case(point)
        values = study.request.in_si(asked)
        loads = {
            name: np.atleast_1d(values.get(key, 0.0)).tolist() for key, name in LOAD_ARGUMENTS.items() if key in units
        }
        poses = {name: values.get(key, 0.0) for key, name in POSE_ARGUMENTS.items() if key in units}
        if not loads and not poses:  # of cells no record is there
            return StepCounts()
        given: Sequence[Wrench] | Sequence[Pose] = loads_of(loads) if loads else [Pose(**poses)]
        layer, field = (str(values.get(part, values.get("model", "auto"))) for part in ("mechanics", "magnetics"))
        tolerance = values.get("tolerance", 1e-2 if study.request.layer else 1e-3)
        each, coils, answers = table_seconds(
            variant.sensor, given, tolerance, mechanics=layer, magnetics=None if study.name == "pose" else field
        )
    except ValueError:
        return StepCounts()
    return StepCounts(coils=coils, rest=sum(each), case=answers)


def _missing(study: Study, points: Sequence[Row], cases: Cases | None) -> dict[int, str]:
    """Return the numbers of the points that are not kept, the first of equal ones, with the names to keep them by."""
    if cases is None:
        return dict.fromkeys(range(len(points)), "")
    key, known, first = keys(study), cases.names, dict[str, int]()
    for index, point in enumerate(points):
        first.setdefault(case_name(key(point), {}), index)
    return {index: name for name, index in first.items() if name not in known}


def _prepared(study: Study, points: Mapping[int, Row]) -> dict[int, Shared]:
    """Return what each of some cases prepares, its coils for one clearance or two."""
    found = {}
    for index, point in points.items():
        own, steps = study.shared(point), list[int]()
        with suppress(ValueError):  # of a scene or a load that is none: a case of its own says so
            if (height := _height(study, point)) > 0.0:
                steps = [step.item() for step, share in clearances(np.array([height]), CLEARANCE) if share > 0.0]
        found[index] = own._replace(coils=tuple((own.coils, step) for step in steps) or (own.coils,))
    return found


def _height(study: Study, point: Row) -> float:
    """Return about how high a case has its target [m]: as given, or t/(1 + sink) by linear theory; 0 if unknown."""
    units, given = study.request.units, study.fixed | point
    if "dv" in units or not study.request.layer:
        return si_value(given.get("dv", 0.0), "m")
    plain = plain_pad(study.case(point)[0].sensor)
    if plain is None:
        return 0.0
    forces = {name: si_value(given.get(key, 0.0), units[key]) for key, name in LOAD_ARGUMENTS.items() if key in units}
    sink, *_ = strains_of(*plain, Wrench(**forces))
    return plain[1].standoff + plain[1].thickness / (1.0 + sink)


def note(plan: Forecast, cases: Cases) -> None:
    """Write beside the cases what is planned, for `noted`."""
    kept = len(cases.names)
    each = _ON_DISK * cases.path.stat().st_size / max(kept, 1)
    record = {"seconds": plan.seconds(), "bytes": each * plan.cases, "kept": kept}
    write_text(cases.path.parent / _NOTE, json.dumps(record))


def noted(folder: Path, processes: int = 1, *, yes: bool = False) -> float | None:
    """Return the processor seconds that were planned for what a folder lacks; None where it holds other cases now.

    Raise SceneError for more than a day's work of so many processes, or more than the disk has room for, unless `yes`.
    """
    path = folder / _NOTE
    if not path.exists():
        return None
    try:
        record = json.loads(input_text(path, "a plan of a sweep"))
        seconds, needs, kept = (float(record[key]) for key in ("seconds", "bytes", "kept"))
    except (ValueError, LookupError, TypeError):
        raise SceneError(f"{path}: must be as --plan wrote it; remove it, or plan again") from None
    with opened(folder) as cases:
        if kept != len(cases.names):
            return None
    free = disk_usage(folder).free
    if not yes and seconds > processes * day:
        raise SceneError(f"{folder}: must be planned for a day at most; {seconds / processes / day:.2g} days (--yes)")
    if not yes and needs > free:
        needed = f"some {needs / GIB:.2g} GiB of {free / GIB:.2g}"
        raise SceneError(f"{folder}: must be on a disk with room for what is planned; it needs {needed} (--yes)")
    return seconds


def _counted(shared: Collection[Shared], chunk: int) -> Forecast:
    """Return what is left to do, without its seconds."""
    coils = [each for own in shared for each in own.coils]
    kinds = (coils, [own.pad for own in shared], [(own.pad, own.load) for own in shared])
    return Forecast(tuple(tuple(Counter(each).values()) for each in kinds), chunk)


def _places(order: Sequence[int], shared: Mapping[int, Shared]) -> Iterator[list[int]]:
    """Yield cases to try of the order of a run: at its ends, in the middle, in the middles between; some at each."""
    halves = (k / 2**level for level in range(1, 5) for k in range(1, 2**level, 2))
    for part in (0.0, 1.0, *halves) if order else ():
        at = round(part * max(len(order) - 2, 0))
        here, later = shared[order[at]], order[at + 1 :]
        rests = (index for index in later if shared[index][1:] != here[1:])
        pads = (index for index in later if shared[index].pad != here.pad)
        yield [*order[at : at + 2], *islice(rests, 2), *islice(pads, 1)]


class _Trial:
    """Cases that are solved here one after the other, with their processor seconds."""

    def __init__(self, case: Case, rests: bool) -> None:
        self._case, self._met, self._rests = case, set[Hashable](), rests  # whether some cases share one
        self._rows: list[list[float]] = []
        self._seconds: list[float] = []

    def solved(self, point: Row, shared: Shared) -> Row:
        """Return the row of a case."""
        made: list[set[Hashable]] = [{"process"}, {*shared.coils}, {("pad", shared.pad)}]
        made.append({("rest", shared[1:])} if self._rests else set())
        new = [len(each - self._met) for each in made]
        self._met.update(*made)
        began = time.process_time()
        with nothing_kept(), threadpool_limits(1):
            row = attempt(self._case, point)
        self._seconds.append(time.process_time() - began)
        self._rows.append([*map(float, new), 1.0])
        return row

    @property
    def spent(self) -> float:
        """The processor seconds of all."""
        return sum(self._seconds)

    @property
    def steps(self) -> StepCounts:
        """The processor seconds of each step."""
        from scipy.optimize import nnls

        if not self._rows:
            return StepCounts()
        return StepCounts(*nnls(np.array(self._rows), np.array(self._seconds))[0].tolist())
