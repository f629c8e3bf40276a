"""Axisymmetric model: one coil as rings under a coaxial disc, absolute L and R in henry and ohm.

    (R + j omega L) i = -j omega g(d_v),    Delta Z = omega^2 g^T (R + j omega L)^-1 g,

with the disc's rings, modes and field functions of `disc`, and L0 from `coils.loops`. The disc is prepared for a
ladder of gaps and frequencies whose steps are blended (`answer`). On each it is divided finer until two successive
extrapolations in the cell size (of two divisions: the extrapolation and the finer one) agree to the tolerance, or their
steps fall so fast that what is left does, over all gaps and frequencies that it serves: not those asked for alone.

Range: non-magnetic disc, coaxial and parallel to the one coil, no other metal (with that, or magnetic: `axis_fem`); any
frequency and thickness. The coil's tracks carry uniform current. Neglected: displacement current.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np

from sits_mech.description import Refusal
from sits_mech.geometry.collision import CLEARANCE
from sits_mech.geometry.stations import stations
from sits_mech.magnetics.answer import Kind, Reaction, answer, lowest_served, magnitudes, served, serving
from sits_mech.magnetics.axis.coaxial import check_coaxial, not_coaxial
from sits_mech.magnetics.axis.disc import Disc, DiscProblem, count_rings, prepare_disc
from sits_mech.magnetics.coils.resistance import coils_alone
from sits_mech.magnetics.coils.tracks import Tracks
from sits_mech.magnetics.modes import skin_depth
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Complex, Impedance, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Sensor
from sits_mech.threads import one_thread
from sits_mech.units import SceneError, checked_tolerance

_KIND = Kind("axisymmetric", "H")  # what leaves the axis `check_coaxial` refuses
_LOG = logging.getLogger(__name__)
_MOST, _LONGEST = 4200, 30.0  # rings in half the disc: half a minute [s] and a gigabyte
_RATIO, _FIRST_RATIO = (0.15, 0.5), 0.3  # of successive steps of the limits: 1/16 for smooth, more at rims
_THROUGH = 0.05  # of the step before: a smaller one passes through zero
_ALONE = 0.5  # of what the extrapolation of two divisions adds; true errors are 0.02 to 1 of it, as a rule 0.15
_SAMPLES = 4  # gaps, and frequencies, at which a preparation must hold
_Limits = tuple[list[Complex], list[Complex]]


@dataclass(frozen=True)
class Axisymmetric:
    """The axisymmetric model of one sensor; make it with `axisymmetric`."""

    sensor: Sensor
    tolerance: float  # asked relative error of the change of L; of R ten times that

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L [H] and R [ohm] for one pose or many at `frequency` [Hz].

        The disc is divided on first use of its steps of gaps (octaves) and frequencies (decades), and kept. Raises as
        `check_asked`, ValueError if a pose leaves the coil's axis, SolveFailed if more rings are asked for than fit.
        """
        return self.with_tracks(pose, frequency)[0]

    @one_thread
    def with_tracks(
        self, pose: Pose, frequency: float, tracks: Tracks | None = None
    ) -> tuple[Impedance, Complex | None]:
        """Return `impedance`, and what the disc's field does in the tracks, (2, p, 1, 1), by its first division.

        None without a disc, or tracks.
        """
        return answer(
            _KIND, self.sensor, pose, frequency,
            partial(coils_alone, self.sensor.coils), partial(self._reaction, tracks=tracks)
        )

    def _reaction(self, pose: Pose, frequency: float, tracks: Tracks | None = None) -> Reaction:
        """Return the disc's reaction on the coil, and that in the tracks, blended over what serves each gap."""
        check_coaxial(self.sensor, pose)
        d_v, rings, levels = np.asarray(pose.d_v), 0, 0
        found = np.zeros((4, d_v.size, 1, 1), dtype=complex)  # Delta Z, its error, both in the tracks [ohm]
        for (clear,), top, some, share in serving([(d_v, CLEARANCE)], frequency):
            discs, held = _divided(_problem(self.sensor, served(clear), top), top, self.tolerance)
            limit = _limits(discs, d_v[some], frequency)
            if not (held or _holds(limit, self.tolerance)):
                raise self._too_many(discs, limit)
            error_R, error_X = _error(limit)
            found[:2, some, 0, 0] += share * np.stack([limit[-1][-1], error_R + 1j * error_X])
            if tracks is not None:
                B = discs[0].field(d_v[some], 2 * np.pi * frequency)
                found[2:, some] += share[:, None, None] * tracks.around(clear, B, clear)
            rings, levels = max(rings, discs[-1].rings), max(levels, len(discs))
        (change, error), uneven = found[:2], None if tracks is None else found[2:]
        worst = float((error.imag / np.abs(change.imag)).max())
        spiral = (Note(NoteKind.SPIRALS_AS_RINGS),) * (self.sensor.coils[0].winding == "spiral")
        notes = (Note.of(NoteKind.RINGS, rings=rings, levels=levels), *spiral)
        return Reaction(change, error, worst, rings, levels, notes=notes, tracks=uneven)

    def _too_many(self, discs: Sequence[Disc], limit: _Limits) -> SolveFailed:
        """Return the error of a division that asks for more rings than fit."""
        rings = discs[-1].rings if discs else 0
        reached = float((_error(limit) / magnitudes(limit[-1][-1])).max()) if len(discs) > 1 else 1.0
        report = SolveReport("axisymmetric", rings, len(discs), 0.0, reached, 0.0, "too many rings")
        return SolveFailed(
            f"axisymmetric: tolerance {self.tolerance:g} asks for more than the {2 * _MOST} rings that fit; reached "
            f"{reached:.1e} with {rings}; ask for a larger tolerance",
            report,
        )


def axisymmetric(sensor: Sensor, tolerance: float = 1e-3) -> Axisymmetric:
    """Return the axisymmetric model of one coil and a disc, or of round coils without target; SceneError for others."""
    if refusal := not_representable(sensor):
        raise SceneError(str(refusal))
    return Axisymmetric(sensor, checked_tolerance(tolerance))


def not_representable(sensor: Sensor) -> Refusal | None:
    """Return why rings do not stand for a scene; None where they do, or it has coils alone."""
    target = sensor.target
    if sensor.conductors:
        return Refusal("conductors", "be left out for axisymmetric", f"{len(sensor.conductors)}")
    if target is not None and target.metal.relative_permeability != 1.0:
        got = f"{target.metal.relative_permeability:g}"
        return Refusal("target.relative_permeability", "be 1 for axisymmetric", got)
    return not_coaxial(sensor, "axisymmetric")


def _problem(sensor: Sensor, gaps: tuple[float, float], top: float) -> DiscProblem:
    """Return the problem to divide the disc for: gaps [m] and frequencies up to `top` [Hz]."""
    target, coil = sensor.target, sensor.coils[0]
    if target is None:
        raise ValueError("target: the scene has none to divide")
    sigma = target.metal.conductivity
    alike = coil.model_copy(update={"name": "C", "centre": (0.0, 0.0)})
    places = tuple((float(np.hypot(x, y)), z) for x, y, z in stations(alike, gaps[0]).points[0].tolist())
    return DiscProblem(
        (target.diameter or 0.0) / 2, target.thickness, sigma, alike, gaps, skin_depth(top, sigma), places
    )


@lru_cache(maxsize=32)
def _divided(problem: DiscProblem, top: float, tolerance: float) -> tuple[tuple[Disc, ...], bool]:
    """Return discs divided finer and finer until all gaps and frequencies they serve hold; whether they do."""
    gaps, frequencies = np.geomspace(*problem.gaps, _SAMPLES), np.geomspace(lowest_served(top), top, _SAMPLES)
    discs: list[Disc] = []
    for level in range(12):
        if (rings := count_rings(problem, level)) > _MOST:
            break
        _LOG.info("a disc of %d rings", 2 * rings, extra={"seconds": _LONGEST * (rings / _MOST) ** 3})
        discs.append(prepare_disc(replace(problem, places=()) if level else problem, level))
        if level and all(_holds(_limits(discs, gaps, frequency), tolerance) for frequency in frequencies.tolist()):
            return tuple(discs), True
    return tuple(discs), False


def _limits(discs: Sequence[Disc], d_v: Array, frequency: float) -> _Limits:
    """Return Delta Z of each level, and of the extrapolation with the one before."""
    values = [disc.reaction(d_v, 2 * np.pi * frequency) for disc in discs]
    return values, [(4 * fine - coarse) / 3 for coarse, fine in pairwise(values)]


def _holds(limit: _Limits, tolerance: float) -> bool:
    """Tell whether the last limit is as good as asked, the resistance ten times less."""
    asked = np.array([[10 * tolerance], [tolerance]])
    return bool(limit[1]) and bool(np.all(_error(limit) <= asked * magnitudes(limit[1][-1])))


def _error(levels: _Limits) -> Array:
    """Return the error of the last limit: what a geometric series leaves after its last step, shape (2, p).

    Its ratio is that of the last two steps, `_FIRST_RATIO` of two limits; steps that pass through zero count by the one
    before. With one limit alone it is half of what the extrapolation adds.
    """
    values, limit = levels
    steps = [magnitudes(limit[0] - values[1]), *(magnitudes(fine - coarse) for coarse, fine in pairwise(limit))]
    if len(steps) == 1:
        return _ALONE * steps[0]
    before, last = steps[-2:]
    measured = np.clip(last / np.where(before > 0.0, before, 1.0), *_RATIO)
    ratio = measured if len(steps) > 2 else np.array(_FIRST_RATIO)
    return np.asarray(np.maximum(last, _THROUGH * before) * ratio / (1.0 - ratio))
