"""Find the limits of a pad: stretch against the silicone's data, clearance, load carried, rate, spread of its modulus.

Of a calibration's table:

    stretch       largest principal stretch, or reciprocal of one, over the loads, against 1 + the largest strain of the
                  data behind the silicone's constants
    clearance     least height of the target's lowest point above the coils; its error is that of the pose,
                  e_v + a e_alpha + b e_alpha_x, of a target of the sides 2 a and 2 b
    modulus       a pose belongs to forces that are proportional to the modulus: with sources that differ by the factor
                  s, a reading of F means F/s to F s
    hysteresis, recovery
                  of a spring with the silicone's viscosity and softening (silicone/history.py)

The capacity of a load F is the largest m with m F carried: no limit load, no buckling, no fold, target clear of coils
and fixed plates, stretch within the data, where it is asked the pose's error within a tolerance. As

    margin(m) = min((lambda_known - lambda(m))/(lambda_known - 1), room(m)/room(0))

is 1 at rest and falls almost straight, m/(1 - margin(m)) is tried next, until it stays or zero is bracketed (brentq).
A path that ended before is a limit of its own, with the error that its two meshes leave.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from sits_mech.analysis.readings.bench import table_poses
from sits_mech.cases import Progress, no_progress
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.propagation import unloaded_pose
from sits_mech.geometry.collision import clearance, room
from sits_mech.mechanics.equilibrium.outcome import PathEnd
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Equilibrium, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.readout.loads import ends_of, fixed, load_words, request_of, varied
from sits_mech.scene.sensor import Sensor, known_stretch, silicones_of
from sits_mech.silicone.history import left_share, loop_width

PERIOD = 1.0
"""Of the load that comes and goes for the hysteresis [s]."""
AFTER = 1.0
"""After a load is gone: when the share that is left of its displacement is asked for [s]."""
_WITHIN = 0.005  # of a capacity: how well it is located
_NEAR = 5.0  # times that: a straight step this short is not solved; stretch, as load^0.85, bends by less than a fifth
_LITTLE = 0.7  # of a load: a coarse mesh that carries less says what to try next
_MOST = 64.0  # multiple of a load up to which a limit is looked for
_LIMITS = (PathEnd.BUCKLED, PathEnd.SIDEWAYS, PathEnd.TURNED, PathEnd.INVERTED)
"""Ends of a load path at a limit of the pad; others may be the solver's."""


@dataclass(frozen=True)
class Capacity:
    """The largest multiple of a load that a pad carries."""

    load: Wrench  # a corner of the table [N, N m]
    multiple: float  # infinite where no limit was met up to 64 times the load
    error: float  # of the multiple; nan where not known
    reason: Note  # the limit that is met
    rest: Equilibrium | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class Limits:
    """Limits of a pad; nan where not known."""

    stretch: float  # largest over the table [-]
    known_stretch: float  # of the data behind the silicone's constants [-]
    stretch_under: str  # its load, in words
    clearance: float  # least over the table [m]
    error_clearance: float  # [m]
    clearance_under: str  # its load
    hysteresis: float  # loop width of a load cycle in `PERIOD`, of the displacement [-]
    left: float  # remaining displacement `AFTER` it, of the displacement [-]
    spread: float  # largest over smallest stress at 100 % strain of the silicone's sources [-]
    capacity: tuple[Capacity, ...] = ()  # where it was asked for


def limits_of(sensor: Sensor, data: xr.Dataset) -> Limits:
    """Return the limits of a pad from its table (`calibrate`) and its silicone."""
    made, known = silicones_of(sensor), known_stretch(sensor)
    dims, size = data["status"].dims, data["status"].size
    stretch = data["stretch"].transpose(*dims).to_numpy().ravel() if "stretch" in data else np.full(size, np.nan)
    pose, error = (table_poses(data, prefix) for prefix in ("", "error_"))
    gap = clearance(sensor, Pose.of(pose))
    half = np.zeros(2) if sensor.target is None else np.array(sensor.target.extent) / 2.0
    off = error[:, 1] + half[0] * error[:, 2] + half[1] * error[:, 4]

    def under(values: Array) -> tuple[int, str]:
        """Return number and name of the load with the largest value."""
        k = int(np.nanargmax(values)) if np.any(np.isfinite(values)) else -1
        row = data.isel(dict(zip(dims, np.unravel_index(k % size, data["status"].shape), strict=True)))
        return k, "" if k < 0 else load_words({name: float(row[name]) for name in (*varied(data), *fixed(data))})

    (i, where), (j, there) = under(stretch), under(-gap)
    loop = _largest(loop_width(each, PERIOD) for each in made)
    left = _largest(left_share(each, AFTER) for each in made)
    spread = _largest(1.0 + each.spread for each in made if each.spread is not None)
    return Limits(float(stretch[i]), known, where, float(gap[j]), float(off[j]), there, loop, left, spread)


def _largest(values: Iterable[float]) -> float:
    """Return the largest of the values that are known; nan where none is."""
    return float(np.fmax.reduce([np.nan, *values]))


def with_capacity(limits: Limits, sensor: Sensor, data: xr.Dataset, progress: Progress = no_progress) -> Limits:
    """Return limits with the largest multiples of the table's corner loads that a pad carries."""
    request = request_of(data)
    name = request["mechanics"] if request["mechanics"] in ("block", "planar", "axisymmetric") else "block"
    loads, found = corners(sensor, ends_of(data, varied(data)), fixed(data)), []
    for load in loads:
        layer, _ = mechanical_model(sensor, name, request["tolerance"], [load])
        first = layer.rough if isinstance(layer, RefinedModel) else layer
        found.append(capacity(sensor, first, load, limits.known_stretch))
        progress(len(found), len(loads))
    return replace(limits, capacity=tuple(found))


def corners(
    sensor: Sensor, ranges: Mapping[str, tuple[float, float]], held: Mapping[str, float] | None = None
) -> list[Wrench]:
    """Return loads of the ends of `ranges` and zero [N, N m], without images by symmetry and without the zero load.

    `held` are the other components.
    """
    ends = {name: sorted({0.0, *pair}) for name, pair in ranges.items()}
    ends |= {name: [value] for name, value in (held or {}).items()}
    each = (Wrench(**dict(zip(ends, values, strict=True))) for values in product(*ends.values()))
    return symmetry_of(sensor).without_images(load for load in each if load.components.any())


def capacity(
    sensor: Sensor, layer: MechanicalModel, load: Wrench, known_stretch: float, *, tolerance: float = np.inf,
    within: float = _WITHIN,
) -> Capacity:
    """Return how much of a load, tried first, a pad carries, and the limit that is met.

    `layer` is for loads as `symmetry_of` has them solved; `known_stretch` nan is no limit; `tolerance` is of the pose's
    relative error; the multiple is located to `within`.
    """
    search = _Search(sensor, layer, load, known_stretch, tolerance)
    low, high, tried = 0.0, np.inf, 1.0
    while (margin := search.margin(tried)) > 0.0 or tried not in search.failed:
        ahead = tried / max(1.0 - margin, 0.5)
        if abs(ahead - tried) <= _NEAR * within * tried:
            return search.at(ahead)
        low, high = (tried, high) if margin > 0.0 else (low, tried)
        if low >= _MOST:
            return Capacity(load, np.inf, np.nan, Note.of(NoteKind.NO_LIMIT, most=_MOST))
        if high <= 1.0 / _MOST and search.found:
            return replace(search.at(high), multiple=0.0)
        if not low < ahead < high:
            break
        tried = ahead
    failed = search.failed.get(tried)
    if failed is not None:
        last = 0.0 if failed.last is None else _share(failed.last.wrench, load)
        if failed.last is None or last <= low or search.of(failed.last) > 0.0:
            return _ended(failed, load, max(low, last))
        high = last
        search.found[high] = failed.last
    at = brentq(search.margin, low, high, xtol=2.0 * within * high, rtol=_WITHIN)
    return _ended(search.failed[at], load, low) if at in search.failed else search.at(float(at))


@dataclass
class _Search:
    """Margins of multiples of a load, each solved once."""

    sensor: Sensor
    layer: MechanicalModel
    load: Wrench
    known: float
    tolerance: float
    found: dict[float, Equilibrium] = field(default_factory=dict)
    failed: dict[float, SolveFailed] = field(default_factory=dict)

    def margin(self, multiple: float) -> float:
        """Return the margin of a multiple from its limits, 1 at rest; less than 0 where it is not carried."""
        if multiple == 0.0:
            return 1.0
        if multiple not in self.found and multiple not in self.failed:
            below = [m for m in self.found if m < multiple]
            start = self.found[max(below)] if below else None
            wrench = Wrench(*(multiple * self.load.components).tolist())
            try:
                self.found[multiple] = self.layer.equilibrium(wrench, start=start)
            except SolveFailed as error:
                if (most := _coarsely(error, self.load)) < _LITTLE * multiple:
                    return 1.0 - multiple / most  # which is tried next
                self.failed[multiple] = error
        return self.of(self.found[multiple]) if multiple in self.found else -1.0

    def of(self, there: Equilibrium) -> float:
        """Return the margin of a state."""
        return min(value for value, _ in self._margins(there))

    def at(self, multiple: float) -> Capacity:
        """Return the capacity at a multiple, from the nearest that was solved."""
        there = self.found[min(self.found, key=lambda m: abs(m - multiple))]
        return Capacity(self.load, multiple, np.nan, min(self._margins(there), key=lambda each: each[0])[1], there)

    def _margins(self, there: Equilibrium) -> list[tuple[float, Note]]:
        """Return each margin with its limit."""
        coils = float(room(self.sensor, there.pose)) / float(room(self.sensor, unloaded_pose(self.sensor)))
        found = [(coils, Note.of(NoteKind.LIMIT_COILS, plates=bool(self.sensor.conductors)))]
        if there.report.stretch is not None and np.isfinite(self.known):
            left = (self.known - there.report.stretch) / (self.known - 1.0)
            found.append((left, Note.of(NoteKind.LIMIT_DATA, stretch=self.known)))
        if there.report.estimated_error > self.tolerance:
            found.append((-1.0, Note.of(NoteKind.LIMIT_ERROR, tolerance=self.tolerance)))
        if any(note.kind is NoteKind.FACES_CROSS for note in there.report.notes):
            found.append((-1.0, Note(NoteKind.LIMIT_FOLD)))
        return found


def _ended(failed: SolveFailed, load: Wrench, reached: float) -> Capacity:
    """Return the capacity of a load path that ended: its largest load, or how far it was followed."""
    end = _end(failed)
    limit = Note.of(NoteKind.LIMIT_LOAD, end=end)
    if failed.carried is None:
        return Capacity(load, reached, np.nan, limit if end in _LIMITS else Note(NoteKind.LIMIT_LOST))
    most, off = failed.carried
    error = float(np.linalg.norm(off.components) / np.linalg.norm(load.components))
    return Capacity(load, _share(most, load), error, limit)


def _end(failed: SolveFailed) -> PathEnd:
    """Return why a load path ended."""
    return PathEnd(next((str(note.known["end"]) for note in failed.report.notes if note.kind is NoteKind.PATH_END), ""))


def _coarsely(failed: SolveFailed, load: Wrench) -> float:
    """Return the multiple of a load that lies within the data or is carried, by a coarse mesh alone; else infinite."""
    if failed.carried is None or not (_end(failed) is PathEnd.BEYOND or np.isnan(failed.carried[1].components).any()):
        return np.inf
    return _share(failed.carried[0], load)


def _share(part: Wrench, load: Wrench) -> float:
    """Return the ratio of two proportional loads."""
    whole = load.components
    return float(part.components @ whole / (whole @ whole))
