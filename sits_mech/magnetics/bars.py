"""Planar integral model: the coils' bars below, a plate's eddy-current modes above; a pose couples the two.

Per metre of depth along y, ``exp(+j omega t)``, one ampere in one coil at a time. The coils' potential over the
plate has few real coefficients c (`section.coupling`, `section.sampling`), the plate answers with a condensed
admittance Y (`section.plate`):

    Delta Z_cd = c_c^T Y(omega) c_d,    R = Re Delta Z,    L = L0 + Im Delta Z / omega,

The plate is prepared for a ladder of clearances and frequencies whose steps are blended (`answer`); then a pose is a
field at a dozen points and one small product. Two divisions of the plate give the answer,
extrapolated in the size of the bars, and with a third one its estimated error (`section.plate`).

Free net current: the plate's current returns at the circle |p| = R_b, where A = 0. Its Green function
``ln|p - p'| - ln|R_b - p conj(p')/R_b|`` adds, by ``ln|1 - q| = -sum_m Re(q^m) / m``, a correction of low rank
U^T D U to the plate's inductance, with the rows U the coefficients of Re and Im (p/R_b)^m, ``D_m = -mu0 / (2 pi m)``;
by Woodbury

    Delta Z = c^T Y c - (j/omega) c^T Y U^T (D^-1 + (j/omega) U Y U^T)^-1 U Y c.

Range: one non-magnetic plate of rectangular section, coils on y = 0. Neglected: eddies in the coils' own tracks,
displacement current, the ends along y.
Source: the division of conductors into bars with uniform current and logarithmic partial inductances is A. E. Ruehli's,
IBM J. Res. Dev. 16 (1972) 470; W. T. Weeks et al., ibid. 23 (1979) 652 have it with skin effect. The condensation onto
few coefficients is this project's own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0

from sits_mech.description import Refusal
from sits_mech.geometry.collision import CLEARANCE, smooth_height
from sits_mech.geometry.plates import PlateSection, distance, outline_refusal, return_radius, section_plates
from sits_mech.geometry.tracks import coil_bars, section_refusal
from sits_mech.magnetics.answer import Kind, Reaction, largest, magnitudes, serving
from sits_mech.magnetics.modes import skin_depth
from sits_mech.magnetics.section.coils import bars_of_coils, coil_box, depth, free_space_inductance, section_answer
from sits_mech.magnetics.section.coupling import (
    Filaments,
    SectionPlate,
    circle_samples,
    coupled_reaction,
    filaments,
    samples,
)
from sits_mech.magnetics.section.plate import Lengths, PreparedPlate, Resolution, prepare_plate
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Complex, Impedance, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Coil, Sensor, metal_parts
from sits_mech.threads import one_thread
from sits_mech.units import SceneError, checked_tolerance
from sits_mech.units import millimetres as mm

# Asked error of the change of inductance -> division of the plate. Largest errors against an independent high-order FEM
# (8 x 0.2 mm, 1 to 5 mm, 5 kHz and 5 MHz): L 1.8e-3, 6.3e-4, 5.5e-5, 7e-6; R 5e-4, 3e-4, 7e-5, 2e-5.
LADDER = (
    (1e-2, Resolution(skin=0.20, growth=1.50, along=0.30, near=0.8, terms=8.0)),
    (1e-3, Resolution(skin=0.12, growth=1.32, along=0.20, near=0.4, terms=10.0)),
    (1e-4, Resolution(skin=0.08, growth=1.22, along=0.09, near=0.22, terms=13.0)),
    (1e-5, Resolution(skin=0.06, growth=1.18, along=0.045, near=0.12, terms=16.0)),
)
_KIND = Kind("planar", "H/m", plane=True)
_RIPPLE = 4.0  # cells that resolve the ripple of single tracks, over those that resolve the gap
_SAFETY = np.array([0.3, 0.15])  # estimated errors of R, L over the difference of the check with cells twice as large


@dataclass(frozen=True)
class PlanarBars:
    """The planar integral model of one sensor; made by `planar_bars`."""

    sensor: Sensor
    tolerance: float  # asked relative error of the change of L; of R ten times that
    absolute: bool = False  # whether changes are those of whole coils [H, ohm], relative to their inductances

    @one_thread
    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L and R [H/m, ohm/m] for one pose or many at `frequency` [Hz]; raises as `check_asked`."""
        return section_answer(_KIND.of(self.absolute), self.sensor, pose, frequency, self._reaction)

    def _reaction(self, pose: Pose, frequency: float) -> Reaction:
        """Return the plates' reaction, blended over the preparations that serve each pose."""
        resolution = next((rung for error, rung in LADDER if self.tolerance >= error), LADDER[-1][1])
        react, gaps = _among_others if self.sensor.conductors else _alone, _gaps(self.sensor, pose)
        both, cells = np.zeros((2, len(gaps[0][0]), *(2 * [len(self.sensor.coils)])), dtype=complex), 0
        finest_first = sorted(serving(gaps, frequency), key=lambda stage: (min(stage[0]), -stage[1]))
        for clear, top, some, share in finest_first:  # what is too fine is refused first
            *found, bars = react(self.sensor, resolution, Pose.of(pose.components[some]), (clear, frequency, top))
            both[:, some] += share[:, None, None] * np.stack(found)
            cells = max(cells, bars)
        change, check = both
        _check_bounds(change.imag / (2 * np.pi * frequency), change.real, free_space_inductance(self.sensor), cells)
        errors = np.max(magnitudes(change - check), axis=(-2, -1)) / np.max(magnitudes(change), axis=(-2, -1))
        errors = _SAFETY[:, None] * errors + math.exp(-resolution.terms)
        error = errors[0][:, None, None] * largest(change.real) + 1j * (errors[1][:, None, None] * largest(change.imag))
        missed = errors[1].max() > self.tolerance
        off = {"error": float(errors[1].max()), "tolerance": self.tolerance}
        notes = (Note.of(NoteKind.TOLERANCE_MISSED, **off),) if missed else ()
        scale = depth(self.sensor, self.absolute)
        return Reaction(scale * change, error * scale, float(errors[1].max()), cells, 1, notes=notes)


def planar_bars(sensor: Sensor, tolerance: float = 1e-3) -> PlanarBars:
    """Return the planar integral model of a sensor, to a relative error of the change of L; SceneError if none."""
    if refusal := not_representable(sensor):
        raise SceneError(str(refusal))
    return PlanarBars(sensor, checked_tolerance(tolerance))


def not_representable(sensor: Sensor) -> Refusal | None:
    """Return why the planar integral model cannot hold this scene; None if it can."""
    if refusal := section_refusal(sensor.coils):
        return refusal
    if sensor.substrate_radius is not None:
        return Refusal("substrate_radius", "be left out for planar, of flat coils", mm(sensor.substrate_radius))
    if sensor.conductors and return_radius(sensor) is not None:
        return Refusal("conductors", "be left out for planar where net_current is free", f"{len(sensor.conductors)}")
    for name, part in metal_parts(sensor):
        if part.metal.relative_permeability != 1.0:
            mu = part.metal.relative_permeability
            return Refusal(f"{name}.relative_permeability", "be 1 for planar", f"{mu:g}")
    return outline_refusal(sensor)


def _check_bounds(delta_L: Array, R: Array, L0: Array, bars: int) -> None:
    """Refuse an answer that no passive plate gives: rounding in the bars' inductances, for a skin too thin for them."""
    own, losses, free = (np.diagonal(m, axis1=-2, axis2=-1) for m in (delta_L, R, L0))
    slack = 1e-9 * free
    if np.all(own <= slack) and np.all(own >= -free - slack) and np.all(losses >= -1e-9 * np.abs(R).max(initial=0.0)):
        return
    raise SolveFailed(
        "planar: the skin is too thin for the plate's size to be resolved, the answer is not that of a passive plate; "
        "ask for a larger tolerance",
        SolveReport("planar", bars, 1, 0.0, 1.0, 0.0, "not resolved"),
    )


def _gaps(sensor: Sensor, pose: Pose) -> list[tuple[Array, float]]:
    """Return the distance of each plate from all else, one a pose, and one independent of it (`answer`) [m]."""
    if sensor.conductors:
        return _gaps_among(sensor, pose)
    extent = (0.0, 0.0) if sensor.target is None else (sensor.target.extent[0], sensor.target.thickness)
    sides, up = np.sin(pose.alpha)[:, None] * extent[0] / 2, np.cos(pose.alpha)
    return [(smooth_height(pose.d_v + np.minimum(up * extent[1], 0.0), sides), CLEARANCE)]


def _gaps_among(sensor: Sensor, pose: Pose) -> list[tuple[Array, float]]:
    """Return `_gaps` of plates beside others; independent of the pose are fixed plates without the target."""
    boxes, moving = [coil_box(bars) for bars in bars_of_coils(sensor)], int(sensor.target is not None)
    found = []
    for plates in _placed(sensor, pose):
        to_coils = np.array([min(distance(plate.corners, other) for other in boxes) for plate in plates])
        apart = np.array([[np.inf if a is b else distance(a.corners, b.corners) for b in plates] for a in plates])
        anchors = np.minimum(to_coils, apart[:, moving:].min(axis=1, initial=np.inf))
        found.append(np.minimum(anchors, np.where(np.arange(len(plates)) < moving, np.inf, apart.min(axis=1))))
    return [
        (gap, CLEARANCE if k < moving else anchor)
        for k, (gap, anchor) in enumerate(zip(np.array(found).T, anchors.tolist(), strict=True))
    ]


def _placed(sensor: Sensor, pose: Pose) -> Iterator[tuple[PlateSection, ...]]:
    """Yield all plates of the section, pose by pose."""
    for d_h, d_v, alpha in zip(pose.d_h, pose.d_v, pose.alpha, strict=True):  # type: ignore[arg-type]
        yield section_plates(sensor, Pose(float(d_h), float(d_v), float(alpha)))


def _alone(
    sensor: Sensor, resolution: Resolution, pose: Pose, scale: tuple[Sequence[float], float, float]
) -> tuple[Complex, Complex, int]:
    """Return Delta Z of poses with nothing but the target, its check, and the number of bars.

    `scale` has the clearance it is prepared for [m], the frequency, and that up to which it is prepared [Hz].
    """
    (clear,), frequency, top = scale
    plate = prepared_plate(sensor, resolution, clear, top)
    source = filaments(bars_of_coils(sensor), clear, math.exp(-resolution.terms), return_radius(sensor))
    change, check = _coupled(plate, source, pose, frequency)
    return change, check, plate.bars


def _among_others(
    sensor: Sensor, resolution: Resolution, pose: Pose, scale: tuple[Sequence[float], float, float]
) -> tuple[Complex, Complex, int]:
    """Return Delta Z with other plates in the section, pose by pose, each prepared for its clearance."""
    clear, frequency, top = scale
    source = filaments(bars_of_coils(sensor), min(clear), math.exp(-resolution.terms), None)
    changes, bars = [], 0
    for plates in _placed(sensor, pose):
        answering = _answering(plates, resolution, clear, top)
        changes.append([coupled_reaction(answering, source, 2 * np.pi * frequency, finest) for finest in (0, 1)])
        bars = sum(plate.prepared.bars for plate in answering)
    found = np.array(changes)
    found = (found + np.swapaxes(found, -1, -2)) / 2
    return found[:, 0], found[:, 1], bars


def _answering(
    plates: Sequence[PlateSection], resolution: Resolution, clear: Sequence[float], top: float
) -> tuple[SectionPlate, ...]:
    """Return plates, each prepared for its clearance from all else, up to a frequency."""
    found = []
    for plate, own in zip(plates, clear, strict=True):
        size, lengths = (plate.width, plate.thickness), _lengths(own, 0.0, plate.conductivity, top)
        found.append(SectionPlate(plate, prepare_plate(size, plate.conductivity, resolution, lengths)))
    return tuple(found)


def prepared_plate(sensor: Sensor, resolution: Resolution, gap: float, frequency: float) -> PreparedPlate:
    """Return the sensor's target prepared for clearances from `gap` on [m] and up to `frequency` [Hz]."""
    target = sensor.target
    if target is None:
        raise ValueError("target: the scene has none to prepare")
    size, conductivity = (target.extent[0], target.thickness), target.metal.conductivity
    winding = min(_winding_width(coil) for coil in sensor.coils)
    lengths = _lengths(gap, winding, conductivity, frequency)
    return prepare_plate(size, conductivity, resolution, lengths, return_radius(sensor))


def _winding_width(coil: Coil) -> float:
    """Return the width of a coil's turns side by side, with a gap [m]."""
    if coil.shape != "path":
        return coil.turns * (coil.track_width + coil.track_gap)
    bars = coil_bars(coil)
    return float(np.ptp(bars.x[bars.sign > 0.0])) + 2.0 * bars.width


def _lengths(closest: float, winding: float, conductivity: float, highest: float) -> Lengths:
    """Return lengths to resolve, from the smallest clearance [m] and the highest frequency [Hz].

    Below a winding much wider than the gap the field is smooth on its width, but for the tracks' ripple on the gap.
    """
    grain = min(_RIPPLE * closest, max(closest, winding / 6))
    return Lengths(closest, grain, skin_depth(highest, conductivity))


def _coupled(plate: PreparedPlate, source: Filaments, pose: Pose, frequency: float) -> tuple[Complex, Complex]:
    """Return Delta Z and its check, shape (p, n, n) [ohm/m]."""
    omega, radius = 2 * np.pi * frequency, source.radius
    c = plate.coefficients(samples(source, pose, plate.thickness, plate.nodes))
    U = None if radius is None else plate.coefficients(_circle_rows(pose, plate, radius))
    found = []
    for finest in (0, 1):
        Y = plate.admittance(omega, finest)
        Yc = c @ Y
        change = Yc @ c.transpose(0, 2, 1)
        if U is not None:
            UY, gU = U @ Y, Yc @ U.transpose(0, 2, 1)  # D = -mu0 / 2 pi
            core = UY @ U.transpose(0, 2, 1) - 1j * omega * (-2 * np.pi / mu_0) * np.eye(U.shape[1])
            change = change - gU @ np.linalg.solve(core, gU.transpose(0, 2, 1))
        found.append((change + change.transpose(0, 2, 1)) / 2)
    return found[0], found[1]


def _circle_rows(pose: Pose, plate: PreparedPlate, radius: float) -> Array:
    """Return samples of Re and Im (p / R_b)^m over sqrt(m), so that D is one number; shape (p, 2 terms, samples)."""
    reach = float(np.max(np.hypot(pose.d_h, pose.d_v)) + plate.thickness + plate.cells[0].x.max())
    if reach >= radius:
        raise ValueError(
            "target.planar_boundary_radius: must enclose the target in every pose, which reaches "
            f"{mm(reach)}; got {mm(radius)}"
        )
    terms = math.ceil(math.log(1e-9) / (2 * math.log(reach / radius)))
    scale = 1.0 / np.sqrt(np.tile(np.arange(1, terms + 1), 2))[:, None]
    return circle_samples(pose, plate.thickness, plate.nodes, radius, terms) * scale
