"""Axisymmetric model by finite elements: one coil and coaxial discs of any permeability, absolute L and R.

Delta Z = j omega Phi, with the flux linkage Phi of the discs' reaction on the coil (equations, weak form, far boundary:
`axis.elements`; cells: `axis.lines`).

Each height of the target is solved with elements of order 3 and 4 on the same cells. The answer is that of order 3;
what order 4 adds to it is its error, in L and in R no less than its relative size in Phi, since one part may cancel:
0.6 to 1.7 times the true error of Phi in 84 divisions of 28 scenes of copper, steel, ferrite and two of them, 1e-4 to
800 skin depths thick, with mu_r up to 1000 (order 4 is 13 times closer as a rule, but nothing tells how close). While
it exceeds the tolerance (ten times it for R), all cells are made smaller; the error falls with their sixth power.

Where a disc is permeable Delta L passes through zero with the frequency; its error is asked relative to a tenth of
|Phi| then.

Range: discs on the axis of one round coil, at any height clear of it, of any conductivity and constant complex
permeability. Neglected: a spiral's pitch, eddies in the coil's own tracks, displacement current, hysteresis and
saturation.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np

from sits_mech.description import Refusal
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.answer import Kind, Reaction, answer
from sits_mech.magnetics.axis.coaxial import check_coaxial, coaxial_discs, not_coaxial
from sits_mech.magnetics.axis.elements import AxisField, flux_errors, solve_axis
from sits_mech.magnetics.axis.lines import CoaxialDisc, divide_axis
from sits_mech.magnetics.coils.resistance import coils_alone
from sits_mech.magnetics.coils.tracks import Tracks
from sits_mech.quantities import Complex, Impedance, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Sensor
from sits_mech.threads import one_thread
from sits_mech.units import SceneError, checked_tolerance

_KIND = Kind("axisymmetric-fem", "H")
_MOST_UNKNOWNS = 200_000  # of order 4: some ten seconds and a gigabyte
_COARSEST, _FIRST_POWER = 1.3, 8.0  # fineness from a tolerance of 8e-3 on; it is 1 at 1e-3
_POWER = 6.0  # of the fineness by which the error falls
_STALLED = 0.5  # of the error two divisions before: of a skin below the smallest cell no division mends it
_FINER = (0.5, 0.85)  # cells of one division to the next, at least and at most
_FINE = 1e-9  # gap [m] for the most nodes across the tracks, which cost next to nothing
_CROSSING = 0.1  # of |Phi|: least change of L that a tolerance is relative to where discs are permeable


@dataclass(frozen=True)
class SolvedAxis:
    """The field at one height and frequency."""

    field: AxisField  # of order 3
    of_order_4: AxisField  # of order 4, for the error
    omega: float  # [rad/s]
    permeable: bool  # whether a disc is
    solves: int  # linear solves it took

    @property
    def errors(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The estimated errors of L and R / omega [H], and relative to what a tolerance is relative to."""
        flux = self.field.flux
        return flux_errors(flux, self.of_order_4.flux - flux, _CROSSING * self.permeable)


@dataclass(frozen=True)
class AxisymmetricFem:
    """The finite element model of one coil and coaxial discs; made by `axisymmetric_fem`."""

    sensor: Sensor
    tolerance: float  # asked relative error of the change of L; of R ten times that

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L [H] and R [ohm] for one pose or many at `frequency` [Hz]; every height is a solve of its own.

        Raises as `check_asked`, ValueError if a pose leaves the coil's axis, SolveFailed if the tolerance is not
        reached.
        """
        return self.with_tracks(pose, frequency)[0]

    @one_thread
    def with_tracks(
        self, pose: Pose, frequency: float, tracks: Tracks | None = None
    ) -> tuple[Impedance, Complex | None]:
        """Return `impedance`, and what the discs' field does in the tracks, (2, p, 1, 1); None without either."""
        return answer(
            _KIND, self.sensor, pose, frequency,
            partial(coils_alone, self.sensor.coils), partial(self._reaction, tracks=tracks)
        )

    def _reaction(self, pose: Pose, frequency: float, tracks: Tracks | None = None) -> Reaction:
        """Return the discs' reaction on the coil, and that in the tracks."""
        check_coaxial(self.sensor, pose)
        d_v = np.asarray(pose.d_v, dtype=float) * (self.sensor.target is not None)
        heights, index = np.unique(d_v, return_inverse=True)
        found = [solved_axis(self, coaxial_discs(self.sensor, height), frequency) for height in heights.tolist()]
        uneven = None
        if tracks is not None:
            x, y, z = tracks.places(_FINE)[0].points[0].T
            each = [
                tracks.around(_FINE, one.field.reaction(np.hypot(x, y), z)[None], self._gap(height))
                for height, one in zip(heights.tolist(), found, strict=True)
            ]
            uneven = np.concatenate(each, axis=1)[:, index]
        omega = 2 * np.pi * frequency
        flux, errors = np.array([each.field.flux for each in found]), np.array([each.errors[0] for each in found])
        value, error = 1j * omega * flux[index], omega * (errors[index, 1] + 1j * errors[index, 0])
        return Reaction(
            value[:, None, None], error[:, None, None], max(each.errors[1][0] for each in found),
            max(each.of_order_4.unknowns for each in found), sum(each.solves for each in found),
            max(each.field.residual for each in found), tracks=uneven,
        )

    def _gap(self, height: float) -> float:
        """Return the distance of the nearest disc from the tracks [m]."""
        tracks = coil_sections(self.sensor.coils[0])
        return min(disc.away(tracks) for disc in coaxial_discs(self.sensor, height))


def axisymmetric_fem(sensor: Sensor, tolerance: float = 1e-3) -> AxisymmetricFem:
    """Return the finite element model of one round coil and discs on its axis; SceneError for other scenes."""
    if refusal := not_representable(sensor):
        raise SceneError(str(refusal))
    return AxisymmetricFem(sensor, checked_tolerance(tolerance))


def not_representable(sensor: Sensor) -> Refusal | None:
    """Return why this model cannot hold a scene; None if it can."""
    return not_coaxial(sensor, "axisymmetric-fem", ("disc", "ring"))


def solved_axis(model: AxisymmetricFem, discs: tuple[CoaxialDisc, ...], frequency: float) -> SolvedAxis:
    """Divide, solve at both orders and refine until the tolerance is met."""
    began, omega, coil = time.process_time(), 2 * np.pi * frequency, model.sensor.coils[0]
    tracks, permeable = coil_sections(coil), any(disc.permeability != 1.0 for disc in discs)
    fineness = min((model.tolerance / 1e-3) ** (1.0 / _FIRST_POWER), _COARSEST)
    lines, found, missed = divide_axis(discs, tracks, frequency, fineness), None, list[float]()
    while lines.unknowns(4) > _MOST_UNKNOWNS and fineness < _COARSEST:
        fineness = min(fineness / _FINER[1], _COARSEST)
        lines = divide_axis(discs, tracks, frequency, fineness)
    while lines.unknowns(4) <= _MOST_UNKNOWNS:
        coarse, fine = (solve_axis(lines, discs, coil, omega, order) for order in (3, 4))
        found = SolvedAxis(coarse, fine, omega, permeable, 2 * len(missed) + 2)
        error_L, error_R = found.errors[1]
        reached = max(error_L, 0.1 * error_R)
        if reached <= model.tolerance:
            return found
        missed.append(reached)
        if len(missed) > 2 and reached > _STALLED * missed[-3]:
            break
        fineness *= float(np.clip((model.tolerance / reached) ** (1.0 / _POWER), *_FINER))
        lines = divide_axis(discs, tracks, frequency, fineness)
    raise _not_reached(model.tolerance, found, [1.0, *missed][-1], time.process_time() - began)


def _not_reached(tolerance: float, found: SolvedAxis | None, reached: float, seconds: float) -> SolveFailed:
    """Return the error of cells that do not reach the tolerance, or are too many for any."""
    unknowns, solves = (found.of_order_4.unknowns, found.solves) if found else (0, 0)
    why = (
        f"the tolerance {tolerance:g} is not reached with {unknowns} unknowns ({_MOST_UNKNOWNS} fit), the estimated "
        f"error is {reached:.1e}; ask for a larger tolerance" if found
        else f"the target is so close for its size, or the coil's, that more than the {_MOST_UNKNOWNS} unknowns that "
        "fit are asked for at any tolerance"
    )
    report = SolveReport("axisymmetric-fem", unknowns, solves, 0.0, reached, seconds, "tolerance not reached")
    return SolveFailed(f"axisymmetric-fem: {why}", report)
