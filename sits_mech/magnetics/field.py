"""Planar finite element model: plates of any permeability, any number, over flat or curved coils; fields to look at.

Per metre of depth, ``exp(+j omega t)``. Unknown: the complex vector potential along y [V s/m per A], whole in the
plates and without the coils' known part in the air (equations, open boundary: `section.elements`; source:
`section.coils`). Every plate's skin is resolved by graded cells (`section.mesh`), from well above its thickness down to
1e-7 of its size; no surface impedance is needed.

Each pose is solved with elements of order 2 and 3 on one mesh. The answer is that of order 3; what it adds to order 2,
in L and in R, is the error of order 2. Where a plate is permeable its corners are singular, order 3 gains little there,
and that difference is the error estimate: 0.6 to 3 times the true error at 5 kHz, more with a thin skin. Elsewhere,
where the field's slope is continuous, the estimate is 0.3 of it: 1.1 to 25 times the true error of L on rectangles from
0.5 to 15 mm wide, 5 um to 3 mm thick, at 5 kHz and 5 MHz. While it exceeds the tolerance (ten times it for R), the
plates that carry the error, and the air next to them, are divided anew with smaller cells.

Range: rectangular sections; the target's outline must be a rectangle or a disc (cut through its middle). Neglected:
eddies in the coils' own tracks (idle coils are open), displacement current, the ends along y, hysteresis and saturation
of permeable parts. Open boundary: a circle at five times the reach of the plates, with the exact exterior series; on
the published sensor a circle four times as large changes Delta L by 3e-9.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sits_mech.description import Refusal
from sits_mech.geometry.plates import PlateSection, outline_refusal, return_radius, section_plates
from sits_mech.geometry.tracks import section_refusal
from sits_mech.magnetics.answer import Kind, Reaction, check_asked
from sits_mech.magnetics.axis.elements import flux_errors
from sits_mech.magnetics.modes import skin_depth
from sits_mech.magnetics.section.coils import CoilBars, coil_potentials, depth, section_answer, tracks
from sits_mech.magnetics.section.elements import FieldSolution, element_errors, solve_field
from sits_mech.magnetics.section.mesh import DividedPlane, Fineness, divide_plane, outline_samples
from sits_mech.quantities import Complex, Impedance, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Sensor
from sits_mech.threads import one_thread
from sits_mech.units import SceneError, checked_tolerance
from sits_mech.units import millimetres as mm

_KIND = Kind("planar-fem", "H/m", plane=True)
# Division for a tolerance of 1e-3, measured against an independent high-order FEM.
_DEFAULT = Fineness(skin=0.7, edge=0.5, growth=0.6, near=0.6, share=0.12, around=40)
_MOST_UNKNOWNS = 300_000  # of a division: with more, the tolerance is refused
_ROUNDS, _FAR = 3, 10.0  # divisions that an order is measured from, and error over tolerance that no more would mend
_FINER = 0.7  # cells of a plate from one division to the next
_GAINED = 0.3  # part of what order 3 adds that is left as its error where no plate is permeable
_SMALL_SHARE = 0.1  # of the estimated error: a plate with less keeps its cells


@dataclass(frozen=True)
class PlanarField:
    """The field at one pose and frequency."""

    plates: tuple[PlateSection, ...]  # target first, if there is one
    coils: tuple[CoilBars, ...]
    division: DividedPlane
    solution: FieldSolution  # of order 3
    coarse: FieldSolution  # of order 2, for the error
    omega: float  # [rad/s]
    ground: float | None  # radius of the circle where A = 0 [m]
    solves: int  # linear solves it took

    @property
    def flux(self) -> Complex:
        """Flux linkage of the reaction, coil by coil, shape (n, n) [H/m]."""
        return self.solution.flux

    @property
    def errors(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The estimated errors of L and R / omega [H/m], largest entry, and over the largest of Delta L and R."""
        smooth = all(plate.relative_permeability == 1.0 for plate in self.plates)
        return flux_errors(self.flux, (self.flux - self.coarse.flux) * (_GAINED if smooth else 1.0))

    def potential(self, places: Complex, currents: Complex) -> Complex:
        """Return the whole vector potential of `currents` [A] at places x + j z within the mesh, [V s/m]."""
        basis = self.solution.basis
        result = coil_potentials(self.coils, places, self.ground) @ currents
        probe = basis.probes(np.vstack([places.real, places.imag]))
        reaction = probe @ ((self.solution.u - self.solution.g) @ currents)
        return np.asarray(result + reaction)

    def current_density(self, number: int, places: Complex, currents: Complex) -> Complex:
        """Return J along y of `currents` [A] at places x + j z in plate `number`, [A/m^2]."""
        basis = self.solution.basis
        u = basis.probes(np.vstack([places.real, places.imag])) @ (self.solution.u @ currents)
        slope = -1j * self.omega * (u - self.solution.e[number] @ currents)
        return np.asarray(self.plates[number].conductivity * slope)


@dataclass(frozen=True)
class PlanarFem:
    """The planar finite element model of one sensor; made by `planar_fem`."""

    sensor: Sensor
    tolerance: float  # asked relative error of the change of L; of R ten times that
    absolute: bool = False  # whether changes are those of whole coils [H, ohm], relative to their inductances

    @one_thread
    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L and R [H/m, ohm/m] for one pose or many at `frequency` [Hz]; every pose is a mesh of its own.

        Raises as `check_asked`, ValueError if the mesh generator is missing, SolveFailed if the tolerance is not
        reached.
        """
        return section_answer(_KIND.of(self.absolute), self.sensor, pose, frequency, self._reaction)

    def _reaction(self, pose: Pose, frequency: float) -> Reaction:
        """Return the plates' reaction, every pose on a mesh of its own."""
        places, n, omega = pose.components, len(self.sensor.coils), 2 * np.pi * frequency
        flux, error = np.zeros((len(places), n, n), dtype=complex), np.zeros((len(places), 1, 1), dtype=complex)
        worst, residual, unknowns, solves = 0.0, 0.0, 0, 0
        for k, place in enumerate(places):
            found = self._field(Pose.of(place), frequency)
            if found is None:
                continue
            flux[k], ((error_L, error_R), (relative, _)) = found.flux, found.errors
            error[k] = omega * (error_R + 1j * error_L)
            worst, residual = max(worst, relative), max(residual, found.solution.residual)
            unknowns, solves = max(unknowns, found.solution.basis.N), solves + found.solves
        scale = depth(self.sensor, self.absolute)
        change = 1j * omega * scale * (flux + np.swapaxes(flux, 1, 2)) / 2
        return Reaction(change, np.asarray(error * scale), worst, unknowns, solves, residual)

    @one_thread
    def field(self, pose: Pose, frequency: float) -> PlanarField | None:
        """Return the field at one pose and `frequency` [Hz], or None without plates; raises as `impedance`."""
        check_asked(_KIND, self.sensor, pose, frequency)
        return self._field(pose, frequency)

    def _field(self, pose: Pose, frequency: float) -> PlanarField | None:
        """Solve without checks; None without plates."""
        plates = section_plates(self.sensor, pose)
        return _adapted(self, plates, 2 * np.pi * frequency) if plates else None


def planar_fem(sensor: Sensor, tolerance: float = 1e-3) -> PlanarFem:
    """Return the planar finite element model of `sensor`, to a relative error of the change of inductance.

    SceneError if this model cannot represent the scene, ValueError if the tolerance is not between 1e-7 and 1.
    """
    if refusal := not_representable(sensor):
        raise SceneError(str(refusal))
    return PlanarFem(sensor, checked_tolerance(tolerance, 1e-7))


def not_representable(sensor: Sensor) -> Refusal | None:
    """Return why planar finite elements cannot hold this scene; None if they can."""
    for part in sensor.conductors:
        if part.loss_tangent > 0.0:
            must = "be 0 for planar-fem, of permeable parts without losses"
            return Refusal(f"conductors.{part.name}.loss_tangent", must, f"{part.loss_tangent:g}")
    return section_refusal(sensor.coils) or outline_refusal(sensor)


def _adapted(model: PlanarFem, plates: tuple[PlateSection, ...], omega: float) -> PlanarField:
    """Divide, solve at both orders and refine until the tolerance is met."""
    began = time.process_time()
    coils, ground = tracks(model.sensor), return_radius(model.sensor)
    _check_coils(coils, ground)
    bars = np.concatenate([coil.place for coil in coils])
    hertz = omega / (2 * np.pi)
    depths = np.array([skin_depth(hertz, p.conductivity, p.relative_permeability) for p in plates])
    fineness = tuple(_DEFAULT.times(float(np.clip((model.tolerance / 1e-3) ** 0.25, 0.25, 1.5))) for _ in plates)
    solves, missed = 0, list[tuple[int, float]]()
    while True:
        division = divide_plane(plates, bars, depths, fineness, ground)
        coarse, fine = (solve_field(division, plates, coils, omega, order, ground) for order in (2, 3))
        solves += 2
        found = PlanarField(plates, coils, division, fine, coarse, omega, ground, solves)
        error_L, error_R = found.errors[1]
        if error_L <= model.tolerance and error_R <= 10 * model.tolerance:
            return found
        missed.append((fine.basis.N, max(error_L, 0.1 * error_R) / model.tolerance))
        if fine.basis.N > _MOST_UNKNOWNS or _hopeless(missed):
            break
        fineness = _finer(fineness, found)
    seconds = time.process_time() - began
    raise SolveFailed(
        f"planar-fem: the tolerance {model.tolerance:g} is not reached with {fine.basis.N} unknowns, the estimated "
        f"error is {error_L:.2g} of Delta L and {error_R:.2g} of R; ask for a larger tolerance",
        SolveReport("planar-fem", fine.basis.N, solves, fine.residual, error_L, seconds, "tolerance not reached"),
    )


def _hopeless(missed: list[tuple[int, float]]) -> bool:
    """Tell whether errors fall so slowly with the unknowns that the most unknowns miss the tolerance by far."""
    if len(missed) < _ROUNDS:
        return False
    (before, was), (now, error) = missed[-_ROUNDS], missed[-1]
    order = max(math.log(was / error) / math.log(now / before), 0.0)
    return bool(error * (now / _MOST_UNKNOWNS) ** order > _FAR)


def _finer(fineness: tuple[Fineness, ...], found: PlanarField) -> tuple[Fineness, ...]:
    """Return smaller cells for the plates that, with the air nearest to them, carry the estimated error."""
    errors = element_errors(found.division, found.plates, found.omega, found.coarse, found.solution)
    middle = found.division.mesh.p[:, found.division.mesh.t].mean(axis=1).T
    outlines = [outline_samples(plate) for plate in found.plates]
    distance = np.array([cKDTree(np.column_stack([o.real, o.imag])).query(middle)[0] for o in outlines])
    owner = np.where(found.division.part > 0, found.division.part - 1, np.argmin(distance, axis=0))
    carried = np.bincount(owner, weights=errors, minlength=len(found.plates))
    needed = carried >= _SMALL_SHARE * carried.max()
    return tuple(f.times(_FINER) if more else f for f, more in zip(fineness, needed, strict=True))


def _check_coils(coils: tuple[CoilBars, ...], ground: float | None) -> None:
    """Refuse coils beyond the grounded circle."""
    for coil in coils:
        corners = np.array([1 + 1j, 1 - 1j, -1 + 1j, -1 - 1j])
        half = (corners.real * coil.width + 1j * corners.imag * coil.thickness) / 2
        reach = float(np.abs(coil.place[:, None] + half * np.exp(-1j * coil.tilt)[:, None]).max())
        if ground is not None and reach >= ground:
            raise ValueError(
                f"target.planar_boundary_radius: must enclose the coils (reach {mm(reach)}), got {mm(ground)}"
            )
