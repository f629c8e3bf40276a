"""The three-dimensional model: coils as rings or spirals below, a plate of any outline above; absolute henry and ohm.

The plate's currents are condensed (`space.modes`) for a ladder of clearances and frequencies whose steps are blended
(`answer`); a pose is then the coils' potential (`coils.ring_field`) at a few Chebyshev points of the plate's bounding
box, of which it sees combinations a, and some small products (`space.coupling`),

    Delta Z_cd = a_c^T Y(omega) a_d,    R = Re Delta Z,   L = L0 + Im Delta Z / omega.

Thin and thick skin regimes are one model: horizontal sheets, graded to the faces below the skin depth, each with its
stream function, joined at the rim by loops that pass from sheet to sheet. One preparation answers all frequencies up to
25 MHz, or those of a decade where plates of any outline answer each other. Five divisions (`space.rungs`) show the
effects of finer cells along the plate and of more sheets separately: errors of second order, but for R where current
crowds at the rim. Both are extrapolated; the estimated error is how far the divisions depart from these orders.
That, and the share of the coils' field energy that the polynomials miss, change smoothly with the pose: poses share
these errors.

Small gaps under wide plates (`space.near`): the plate sees the coils' potential itself, cell by cell.

Other metal (`space.neighbours`): fixed plates join with their own modes and see the coils' field itself; their
common response is computed once, and a pose costs some tens of milliseconds.

Permeable plates (`space.permeable`), steel, ferrite or filled rubber, join with a potential on their surface.

Range: permeable plates without holes, linear. Neglected: eddies in the coils' own tracks (`coils.resistance`),
displacement current.
Source: eddy currents as unknowns of an integral equation, divergence-free by their shape functions: R. Albanese and
G. Rubinacci, Adv. Imaging Electron Phys. 102 (1998) 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from sits_mech.description import Refusal
from sits_mech.geometry.collision import PlacedPlate, overlapping, placed_plates
from sits_mech.geometry.outline import widest_angles
from sits_mech.geometry.tracks import path_notes
from sits_mech.magnetics.answer import Kind, Reaction, answer, largest, serving
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.coils.resistance import coils_alone
from sits_mech.magnetics.coils.tracks import Tracks
from sits_mech.magnetics.modes import skin_depth
from sits_mech.magnetics.space.far import FieldRequest as Field
from sits_mech.magnetics.space.lift import Lift
from sits_mech.magnetics.space.neighbours import SpacePlate, coupled_reactions, field_of_all
from sits_mech.magnetics.space.plates import (
    Divided,
    PlateRequest,
    around_holes,
    divided_plate,
    holed,
    permeable_rings,
    saturation_notes,
    target_room,
)
from sits_mech.magnetics.space.rungs import ImpedanceLimit, PlateRung, fitting
from sits_mech.magnetics.space.sources import Posed, Sources
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Complex, Impedance, Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import Sensor, metal_parts
from sits_mech.threads import one_thread
from sits_mech.units import SceneError, checked_tolerance
from sits_mech.units import millimetres as mm

_KIND = Kind("sheets", "H")
_OF_EACH = 0.1  # of two coils' errors (geometric mean), added to that of their mutual terms: benchmarks/extremes.py
_MISSED = (0.25, 0.25), (0.04, 0.02)  # of a bound, by polynomials, in R and L: 0.33 seen; of what plates radiate


@dataclass(frozen=True)
class Sheets:
    """The three-dimensional model of one sensor; made by `sheets`.

    `tolerance` is the asked relative error of the changes of L and R; R may be off by twice that where current crowds
    at the rim. `like` is a nearly equal scene, other in its coils, or in the size of a rectangle or a disc alone; its
    cells are taken, so that differences are free of meshing; `single` asks for the coarsest division alone, without
    errors, for differences from such a scene. `steady` are gaps and anchors for which all poses are prepared, in turn,
    whatever their own gaps are (`prepared_at`).
    `lift` bends the target of poses that are all alike, to first order: its points see the coils from where they are.
    """

    sensor: Sensor
    tolerance: float
    windings: str = "rings"  # "rings" or "spiral"
    like: Sensor | None = None
    single: bool = False
    steady: tuple[tuple[tuple[float, ...], float], ...] = ()
    lift: Lift | None = field(default=None, compare=False)

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L and R [H, ohm] for one pose or many at `frequency` [Hz]; raises as `check_asked`."""
        return self.with_tracks(pose, frequency)[0]

    @one_thread
    def with_tracks(
        self, pose: Pose, frequency: float, tracks: Tracks | None = None
    ) -> tuple[Impedance, Complex | None]:
        """Return `impedance`, and what the plates' field does in the tracks, (2, p, n, n); None without plates.

        Of the first division, each plate by the coils alone; None where a plate is permeable, or without tracks.
        """
        return answer(
            _KIND, self.sensor, pose, frequency,
            partial(coils_alone, self.sensor.coils, self.windings), partial(self._reaction, tracks=tracks)
        )

    def _reaction(self, pose: Pose, frequency: float, tracks: Tracks | None = None) -> Reaction:
        """Return the plates' reaction, and that in the tracks, blended over what serves each pose."""
        parts = placed_plates(self.sensor, rotation_matrix(pose.rotation), pose.centre)
        n = len(self.sensor.coils)
        if any(part.susceptibility != 0.0 for part in parts):
            tracks = None
        found, unknowns, kept = np.zeros((6, len(parts[0].gap), n, n), dtype=complex), 0, dict[Note, None]()
        gaps, least_step = self._gaps(parts)
        for (*clear, room), top, some, share in serving(gaps, frequency, least_step=least_step):
            own = [part.among(some) for part in parts]
            change, count, notes = self._change(own, clear, room, (frequency, top), tracks)
            found[:, some] += share[:, None, None] * change
            unknowns, kept = max(unknowns, count), kept | dict.fromkeys(notes)
        value, error = found[:2]
        scale = largest(value.imag)
        relative = float(np.max(error.imag / np.where(scale > 0.0, scale, 1.0), initial=0.0))
        if permeable_rings(parts):  # of the whole change, what `around_holes` leaves with what divisions do
            relative = max(relative, float(np.max(error.real / largest(value))))
        every = (*kept, *saturation_notes(self.sensor.coils, parts), *self._winding_notes())
        uneven = None if tracks is None else found[4:]
        return Reaction(value, error, relative, unknowns, 1, notes=every, shared=found[2:4], tracks=uneven)

    def _gaps(self, parts: Sequence[PlacedPlate]) -> tuple[list[tuple[Array, float]], float]:
        """Return plates' gaps with their anchors, then the target's room, and the least step of the frequencies."""
        drawn = any(part.shape == "outline" for part in self.sensor.conductors)
        found = [*((part.gap, part.anchor) for part in parts), target_room(self.like or self.sensor, parts[0])]
        if self.steady:
            found = [
                (np.resize(own, gap.shape), anchor) for (own, anchor), (gap, _) in zip(self.steady, found, strict=True)
            ]
        return found, -math.inf if drawn else 0.0

    def prepared_at(self, pose: Pose) -> Sheets:
        """Return the model to take differences with: small steps of poses, or of lengths, share these preparations.

        Without fixed plates, the model itself.
        """
        if not self.sensor.conductors:
            return self
        parts = placed_plates(self.sensor, rotation_matrix(pose.rotation), pose.centre)
        return replace(self, steady=tuple((tuple(gap.tolist()), anchor) for gap, anchor in self._gaps(parts)[0]))

    def varied(self, sensor: Sensor, *, single: bool = False) -> Sheets:
        """Return the model of a scene that differs a little, divided alike where that can be; for `like` and `single`.

        Of outlines, and of plates that answer each other, each scene has divisions of its own.
        """
        (one, other), free = (self.sensor.target, sensor.target), not self.sensor.conductors
        if one is not None and other is not None:
            free &= one.shape == other.shape and not one.loops and one.metal == other.metal
            free &= one.metal.relative_permeability == 1.0
        return replace(self, sensor=sensor, like=self.sensor if free else None, single=single and free)

    def _request(self, part: PlacedPlate) -> PlateRequest:
        """Return what a plate asks of its divisions."""
        if self.like is not None and self.like.target is not None:
            become = part.plate if part.plate != self.like.target else None
            return PlateRequest(self.like.target, part.susceptibility, None, become)
        fixed = part.windings > 0.0
        axes = tuple(map(tuple, part.turns[0].tolist()))
        seen = Sources(self.sensor.coils, self.windings, part.middle, part.windings, axes) if fixed else None
        return PlateRequest(part.plate, part.susceptibility, seen, None)

    def _winding_notes(self) -> tuple[Note, ...]:
        """Note how far spiral windings are from rings, and what free tracks are without."""
        if self.windings == "rings":
            return path_notes(self.sensor.coils)
        spiral, rings = (np.diag(free_inductances(self.sensor.coils, kind)) for kind in (self.windings, "rings"))
        step = float(np.max(np.abs(spiral / rings - 1.0)))
        return (Note.of(NoteKind.SPIRALS, share=step), *path_notes(self.sensor.coils))

    def _plates(
        self, parts: Sequence[PlacedPlate], clear: Sequence[float], room: float, frequency: tuple[float, float]
    ) -> tuple[list[Divided], PlateRung, tuple[Note, ...]]:
        """Return the plates as they are divided, for `_change`, the rung, and notes on finer ones."""
        asked = [part.plate for part in parts]

        def divided(rung: PlateRung) -> list[Divided]:
            each = zip(map(self._request, parts), clear, strict=True)
            own, beyond, like = replace(rung, single=self.single), min(clear[1:], default=0.0), self.like or self.sensor
            return [divided_plate(like, kind, own, (near, beyond, room), frequency) for kind, near in each]

        metals = [part.plate for part in parts if part.susceptibility == 0.0]
        halves = (plate.thickness / 2 / skin_depth(frequency[1], plate.metal.conductivity) for plate in metals)
        return fitting(self.tolerance, asked, max(halves, default=math.inf), divided)

    def _change(
        self, parts: Sequence[PlacedPlate], clear: Sequence[float], room: float, frequency: tuple[float, float],
        tracks: Tracks | None = None,
    ) -> tuple[Complex, int, list[Note]]:
        """Return the plates' change, each prepared for a clearance and a room, at a frequency, up to another.

        It is Delta Z, its error, real and imaginary part apart, two signed parts that poses share: extrapolation's step
        and polynomials' miss, what is in the tracks, where that is asked for, and its error, (6, p, n, n) [ohm]; with
        the unknowns, and notes.
        """
        sensor = self.sensor
        plates, rung, large = self._plates(parts, clear, room, frequency)
        notes = [*large]
        for part, each in zip(parts, plates, strict=True):
            notes += [note.with_numbers(part=part.title) if part.title else note for note in each.notes]
        seen = Posed(sensor.coils, self.windings, parts[0].turns, parts[0].places, rung.step, self.lift)
        gap = min(clear)
        asked = None if tracks is None else Field(tracks.points(gap), partial(tracks.change, gap))
        thickness, finest = max(plate.thickness for plate in plates), math.sqrt(frequency[0] / frequency[1])
        limit = ImpedanceLimit(replace(rung, single=self.single), thickness, finest, plates[0].close, _corners(parts))
        if sensor.conductors:
            forms = limit.forms(self._together(parts, plates, seen, frequency[0]))
            uneven = None if asked is None else field_of_all(parts, plates, seen, frequency[0], asked)
        else:
            alone = plates[0].divisions
            forms, uneven = alone[0].reactions(alone, seen, frequency[0], limit, asked)
        value, left = forms[0], limit.errors(forms)
        error, lost = _errors(value, left, plates, bool(sensor.conductors))
        around, unsure = around_holes(parts, seen, gap, 2 * np.pi * frequency[0])
        value, error = value + around, error + unsure
        unknowns = sum(plate.divisions[0].unknowns for plate in plates)
        in_tracks = 2 * [0.0 * value] if uneven is None else uneven
        return np.stack([value, error, left, lost * value, *in_tracks]), unknowns, notes

    def _together(
        self, parts: Sequence[PlacedPlate], plates: Sequence[Divided], seen: Posed, frequency: float
    ) -> list[Complex]:
        """Return Delta Z of several plates on all divisions; then as far off as permeable ones' estimated errors."""
        most, answering = max(len(plate.divisions) for plate in plates), []
        for part, plate in zip(parts, plates, strict=True):
            own = plate.divisions
            answering.append(SpacePlate(own + own[:1] * (most - len(own)), part.turns, part.places))
        target: tuple[Any, ...] = answering.pop(0).divisions if self.sensor.target is not None else ()
        return [(Z + np.swapaxes(Z, 1, 2)) / 2 for Z in coupled_reactions(target, seen, answering, frequency)]


def sheets(sensor: Sensor, tolerance: float = 5e-3, *, windings: str | None = None) -> Sheets:
    """Return the three-dimensional model of `sensor`, to a relative error of the change of inductance.

    `windings` are "rings" or "spiral", the scene's by default. SceneError if this model cannot represent the scene.
    """
    if refusal := not_representable(sensor):
        raise SceneError(str(refusal))
    if windings is None:
        windings = next((coil.winding for coil in sensor.coils if coil.is_round), "rings")
    if windings not in ("rings", "spiral"):
        raise ValueError(f'windings: must be "rings" or "spiral", got {windings!r}')
    return Sheets(sensor, checked_tolerance(tolerance), windings)


def not_representable(sensor: Sensor) -> Refusal | None:
    """Return why this model cannot hold this scene; None if it can."""
    if sensor.substrate_radius is not None:
        return Refusal("substrate_radius", "be left out for sheets, of flat coils", mm(sensor.substrate_radius))
    for name, part in metal_parts(sensor):
        if holed(part, sensor.frequency):
            key, what, got = ("holes", "part is permeable", len(part.holes)) if part.holes else (
                "inner_diameter", "permeable part conducts", part.inner_diameter
            )
            return Refusal(f"{name}.{key}", f"be left out for sheets where a {what}", f"{got:g}")
    return overlapping(sensor)


def _corners(parts: Sequence[PlacedPlate]) -> tuple[float, ...]:
    """Return the least orders by which errors fall at plates' corners, into the metal and out of it."""
    return tuple(np.min([2.0 * math.pi / widest_angles(part.plate) for part in parts], axis=0).tolist())


def _errors(value: Complex, left: Complex, plates: Sequence[Divided], among: bool) -> tuple[Complex, float]:
    """Return the errors of R and of the reactance, with what divisions `left`, and the share that polynomials miss.

    `among`: plates answer each other.
    """
    lost = max(plate.unseen for plate in plates) * np.array(_MISSED[among])
    R, X = _shared(left.real) + lost[0] * largest(value.real), _shared(left.imag) + lost[1] * largest(value.imag)
    return R + 1j * X, float(lost.max())


def _shared(error: Array) -> Array:
    """Return errors of matrices' entries, those of two coils with a share of both coils' own."""
    own = np.sqrt(np.diagonal(error, axis1=-2, axis2=-1))
    mutual = error + _OF_EACH * own[..., None] * own[..., None, :]
    return np.where(np.eye(error.shape[-1], dtype=bool), error, mutual)
