"""The three-dimensional model: coils as rings or spirals below, a plate of any outline above; absolute henry and ohm.

The plate carries its own eddy-current modes (`space.modes`), found once for a range of clearance (a factor of two) and
of frequency (a decade); a pose is then the coils' potential (`coils.ring_field`) at a few Chebyshev points of the
plate's bounding box and some small products (`space.coupling`),

    Delta Z_cd = omega^2 sum_k a_ck a_dk / (1 + j omega tau_k),    R = Re Delta Z,   L = L0 + Im Delta Z / omega.

Thin and thick skin regimes are one model: horizontal sheets, graded to the faces below the skin depth, each with its
stream function, joined at the rim by loops that pass from sheet to sheet. Two divisions, one with every cell
of the other halved along each axis, differ by errors of second order: ``(4 Z_fine - Z_coarse) / 3`` is returned.
Its distance from Z_fine is the estimated error; a third of it in the thin regime, where nothing but the smooth flow
along the plate has to be resolved. In the thick regime uniform current in the first cell, of size h, has an error of
(h/delta)^2 / 12 of the resistance, which is added.

Small gaps under wide plates (`space.near`): the plate is lifted to where its division carries the coils' field, and
its answer carried down along the infinite plate; the estimated error holds what that leaves uncertain.

Other metal (`space.neighbours`): plates parallel to the coils join with their own modes. A pose then costs some tenths
of a second, or a second where such a plate is wide for its distance.

Range: non-magnetic plates. Neglected: eddies in the coils' own tracks (`coils.track_modes`), displacement current.
Source: eddy currents as unknowns of an integral equation, divergence-free by their shape functions: R. Albanese and
G. Rubinacci, Adv. Imaging Electron Phys. 102 (1998) 1.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np

from sits_mech.geometry.outline import Outline
from sits_mech.geometry.solids import PlacedPlate, lowest_points, overlapping, placed_plates
from sits_mech.magnetics.answer import Kind, Reaction, answer, largest
from sits_mech.magnetics.coils.alone import free_inductances, track_resistances
from sits_mech.magnetics.skin import skin_depth
from sits_mech.magnetics.space.coupling import reactions
from sits_mech.magnetics.space.modes import Sheeted
from sits_mech.magnetics.space.near import FACTORS, averaged, carried_down, infinite_plate, under_plate
from sits_mech.magnetics.space.neighbours import SpacePlate, coupled_reactions
from sits_mech.magnetics.space.rungs import LADDER, Rung, carried, field_length, prepared, unseen
from sits_mech.quantities import Array, Complex, Impedance, Pose
from sits_mech.scene.sensor import Sensor
from sits_mech.threads import one_thread
from sits_mech.turns import rotation_matrix
from sits_mech.units import checked_tolerance

_KIND = Kind("sheets", "H")
_PLATES = 1.5  # length on which another plate's field changes, over the distance


@dataclass(frozen=True)
class Uncertainty:
    """How far to trust a result.

    Attributes
    ----------
    trust : float
        Estimated error over the extrapolation's step.
    unseen : float
        Share of the coils' field that the polynomials miss.
    skin : float
        Relative error of the resistance from the first cell.
    """

    trust: float = 1.0
    unseen: float = 0.0
    skin: float = 0.0


@dataclass(frozen=True)
class _Divided:
    """A plate's divisions, the smallest clearance they carry [m], how far to trust them, and what there is to say."""

    divisions: tuple[Sheeted, Sheeted]
    lowest: float
    uncertainty: Uncertainty
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Changes:
    """Delta Z on the fine and the coarse division, error of small gaps, unknowns, trust in each plate, notes."""

    fine: Complex
    coarse: Complex
    near: Complex
    unknowns: int
    uncertainties: tuple[Uncertainty, ...]
    notes: tuple[str, ...]

    def worst(self) -> Uncertainty:
        """The worst of all plates."""
        each = zip(*(astuple(uncertainty) for uncertainty in self.uncertainties), strict=True)
        return Uncertainty(*(max(several) for several in each))


@dataclass(frozen=True)
class Sheets:
    """The three-dimensional model of one sensor; made by `sheets`.

    Attributes
    ----------
    sensor : Sensor
    tolerance : float
        Asked relative error of the change of inductance; the resistance is good to some ten times that.
    windings : str
        "rings" or "spiral".
    outline : Outline or None
        The target's outline, where it is not the scene's.
    """

    sensor: Sensor
    tolerance: float
    windings: str = "rings"
    outline: Outline | None = None

    @one_thread
    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L and R [H, ohm] for one pose or many at `frequency` [Hz].

        Raises
        ------
        Collision, ValueError
            As `check_asked`.
        """
        def alone() -> tuple[Array, Array]:
            return free_inductances(self.sensor.coils, self.windings), track_resistances(self.sensor.coils)

        return answer(_KIND, self.sensor, pose, frequency, alone, self._reaction)

    def _reaction(self, pose: Pose, frequency: float) -> Reaction:
        """What the plates do to the coils: extrapolated, with what that leaves uncertain."""
        found = self._changes(rotation_matrix(pose.rotation), pose.centre, frequency)
        worst = found.worst()
        change, step = (4 * found.fine - found.coarse) / 3, worst.trust * (found.fine - found.coarse) / 3
        scale = largest(change.imag)
        error_X = largest(step.imag) + largest(found.near.imag) + worst.unseen * scale
        error_R = largest(step.real) + largest(found.near.real) + (worst.unseen + worst.skin) * largest(change.real)
        relative = float(np.max(error_X / np.where(scale > 0.0, scale, 1.0), initial=0.0))
        notes = (*found.notes, *self._winding_notes())
        return Reaction(change, error_R + 1j * error_X, relative, found.unknowns, 1, notes=notes)

    def _winding_notes(self) -> tuple[str, ...]:
        """Say how far spiral windings are from rings."""
        if self.windings == "rings":
            return ()
        spiral, rings = (np.diag(free_inductances(self.sensor.coils, kind)) for kind in (self.windings, "rings"))
        step = float(np.max(np.abs(spiral / rings - 1.0)))
        return (f"spiral windings: L0 differs from that of rings by up to {step:.2%}",)

    def _changes(self, turns: Array, places: Array, frequency: float) -> _Changes:
        """What the plates do to the coils."""
        sensor = self.sensor
        parts = placed_plates(sensor, self.outline, turns, places)
        rung = next((rung for error, rung in LADDER if self.tolerance >= error), LADDER[-1][1])
        plates = [_divided(sensor, part, rung, frequency, alone=not sensor.conductors) for part in parts]
        notes = tuple(part.title + note for part, plate in zip(parts, plates, strict=True) for note in plate.notes)
        if sensor.conductors:
            both = zip(parts, plates, strict=True)
            answering = [SpacePlate(plate.divisions, part.turns, part.places) for part, plate in both]
            target = answering.pop(0) if sensor.target is not None else None
            fine, coarse = coupled_reactions(sensor.coils, self.windings, target, answering, frequency)
            fine, coarse = ((Z + np.swapaxes(Z, 1, 2)) / 2 for Z in (fine, coarse))
            fine, coarse = (np.broadcast_to(Z, (places.shape[0], *Z.shape[1:])) for Z in (fine, coarse))
            near = np.zeros(fine.shape, dtype=complex)
        else:
            fine, coarse, near = _alone(sensor, self.windings, parts[0], plates[0], frequency)
            if near.any():
                low = plates[0].lowest * 1e3
                notes = (*notes, f"gaps below {low:.3g} mm: carried down from there along the infinite plate")
        unknowns = sum(plate.divisions[0].unknowns for plate in plates)
        return _Changes(fine, coarse, near, unknowns, tuple(plate.uncertainty for plate in plates), notes)


def sheets(
    sensor: Sensor, tolerance: float = 5e-3, *, windings: str | None = None, outline: Outline | None = None
) -> Sheets:
    """Return the three-dimensional model of `sensor`.

    Parameters
    ----------
    sensor : Sensor
    tolerance : float
        Asked relative error of the change of inductance.
    windings : str, optional
        "rings" (concentric) or "spiral" (the tracks' true path); the scene's by default.
    outline : Outline, optional
        The target's outline instead of the scene's: with holes, or from a mesh file (`read_outline`).

    Raises
    ------
    ValueError
        If the scene is not one this model can represent.
    """
    refusal = not_representable(sensor)
    if refusal:
        raise ValueError(refusal)
    if windings is None:
        windings = next((coil.winding for coil in sensor.coils if coil.shape == "circle"), "rings")
    if windings not in ("rings", "spiral"):
        raise ValueError(f'windings: must be "rings" or "spiral", got {windings!r}')
    if outline is not None and sensor.target is None:
        raise ValueError("outline: needs a scene with a target, whose thickness and metal it takes")
    return Sheets(sensor, checked_tolerance(tolerance), windings, outline)


def not_representable(sensor: Sensor) -> str | None:
    """Say in one line why this model cannot hold this scene; None if it can."""
    if sensor.substrate_radius is not None:
        return "substrate_radius: model 'sheets' takes flat coils only; model 'planar-fem' takes curved ones"
    for part in sensor.conductors:
        if part.metal.relative_permeability != 1.0:
            return (
                f"conductors.{part.name}.relative_permeability: model 'sheets' needs 1; model 'planar-fem' takes "
                "permeable parts"
            )
    if sensor.target is not None and sensor.target.metal.relative_permeability != 1.0:
        return "target.relative_permeability: model 'sheets' needs 1; model 'planar-fem' takes permeable parts"
    return overlapping(sensor)


def _divided(sensor: Sensor, part: PlacedPlate, rung: Rung, frequency: float, *, alone: bool) -> _Divided:
    """Prepare a plate for its clearance; alone, not for smaller ones than its polynomials carry."""
    scale = math.ceil(math.log10(frequency) - 1e-9)
    octave = math.floor(math.log2(part.gap) + 1e-9)
    if alone:
        octave = carried(part.plate, part.outline, octave, rung)
    reach, middle = _reach(sensor, part.middle) + 2 * 2.0**octave, 2.0**octave + part.plate.thickness / 2
    length = min(field_length(coil, middle) for coil in sensor.coils)
    if not alone:
        length = min(length, _PLATES * middle)
    fine, coarse = prepared(part.plate, part.outline, rung, (octave, scale, reach, length))
    depth, missed = skin_depth(frequency, part.plate.metal.conductivity), unseen(fine.box)
    thin = depth > part.plate.thickness
    first = rung.skin * skin_depth(10.0**scale, part.plate.metal.conductivity) / (1.0 + math.sqrt(rung.growth))
    trust = Uncertainty(1.0 / 3.0 if thin else 1.0, missed, 0.0 if thin else (first / depth) ** 2 / 12)
    return _Divided((fine, coarse), 2.0**octave, trust, _notes(part.plate.thickness / depth, fine.sheets, missed))


def _alone(
    sensor: Sensor, windings: str, part: PlacedPlate, plate: _Divided, frequency: float
) -> tuple[Complex, Complex, Complex]:
    """Delta Z of a plate without others on the fine and the coarse division, and its error where the gap is small."""
    gap = lowest_points(part.plate, part.outline, part.turns, part.places)
    near, up = gap < plate.lowest * (1.0 - 1e-9), FACTORS * plate.lowest
    lift = (up - gap[near, None])[..., None] * (0.0, 0.0, 1.0)
    lifted = (part.places[near, None] + lift).reshape(-1, 3)
    turns = np.vstack([part.turns[~near], np.repeat(part.turns[near], up.size, axis=0)])
    poses = turns, np.vstack([part.places[~near], lifted])
    found = reactions(sensor.coils, windings, plate.divisions, poses, frequency)
    results = [np.empty((gap.size, *Z.shape[1:]), dtype=complex) for Z in found]
    error = np.zeros(results[0].shape, dtype=complex)
    for result, Z in zip(results, found, strict=True):
        result[~near] = Z[: gap.size - lifted.shape[0] // up.size]
    if near.any():
        heights = under_plate(sensor.coils, part.plate, part.outline, (part.turns[near], part.places[near]), gap[near])
        reach = float(heights[0].max()) + up[-1]
        plane = infinite_plate(sensor.coils, part.plate, (float(gap.min()), reach), frequency)
        below = averaged(plane, heights, 0.0 * gap[near])
        above = np.stack([averaged(plane, heights, height - gap[near]) for height in up], axis=1)
        for result, Z in zip(results, found, strict=True):
            nodes = Z[gap.size - lifted.shape[0] // up.size :].reshape(above.shape)
            result[near], error[near] = carried_down(nodes, (above, below), gap[near], plate.lowest)
    return results[0], results[1], error


def _reach(sensor: Sensor, middle: tuple[float, float]) -> float:
    """Farthest winding from a plate's middle along x or y [m]."""
    return max(max(abs(c - m) for c, m in zip(coil.centre, middle, strict=True)) + coil.outer_diameter / 2
               for coil in sensor.coils)  # fmt: skip


def _notes(ratio: float, sheets_used: int, unseen: float) -> tuple[str, ...]:
    """Say which skin regime holds, what carries it, and whether the gap is too small for the division."""
    regime = "thin" if ratio < 1.0 else "thick" if ratio > 3.0 else "intermediate"
    used = f"{regime} skin regime: thickness is {ratio:.3g} skin depths; {sheets_used} sheets joined at the rim"
    if unseen < 1e-3:
        return (used,)
    return used, f"the gap is small for so wide a plate: {unseen:.1%} of the coils' field is not resolved"
