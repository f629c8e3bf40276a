"""The three-dimensional model: coils as rings or spirals below, a plate of any outline above; absolute henry and ohm.

The plate carries its own eddy-current modes (`sheet_modes`), found once for a range of clearance (a factor of two) and
of frequency (a decade); a pose is then the coils' potential (`ring_field`) at a few Chebyshev points of the plate's
bounding box and some small products (`sheet_coupling`),

    Delta Z_cd = omega^2 sum_k a_ck a_dk / (1 + j omega tau_k),    R = Re Delta Z,   L = L0 + Im Delta Z / omega.

Thin and thick skin regimes are one model: horizontal sheets, graded to the faces below the skin depth, each with its
stream function, joined at the rim by loops that pass from sheet to sheet. Two divisions, one with every cell
of the other halved along each axis, differ by errors of second order: ``(4 Z_fine - Z_coarse) / 3`` is returned.
Its distance from Z_fine is the estimated error; a third of it in the thin regime, where nothing but the smooth flow
along the plate has to be resolved. In the thick regime uniform current in the first cell, of size h, is in doubt by
(h/delta)^2 / 12 of the resistance, which is added.

Other metal (`sheet_neighbours`): plates parallel to the coils join with their own modes. A pose then costs a tenth of
a second, or some more where such a plate is wide for its distance.

Range: non-magnetic plates. Neglected: eddies in the coils' own tracks (`losses`), displacement current.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.constants import mu_0

from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.outline import Outline, outline_plan, target_outline
from sits_mech.geometry.sheet_plan import Grading, Plan, disc_plan, graded_axis, rectangle_plan
from sits_mech.geometry.solids import overlapping, placed_plates
from sits_mech.geometry.windings import track_length
from sits_mech.magnetics.loops import coil_inductances
from sits_mech.magnetics.ring_field import spiral_inductances
from sits_mech.magnetics.sheet_coupling import reactions
from sits_mech.magnetics.sheet_loops import Complex
from sits_mech.magnetics.sheet_modes import Box, Sheeted, prepare_sheets
from sits_mech.magnetics.sheet_neighbours import Answering, coupled_reactions
from sits_mech.materials import metals
from sits_mech.quantities import Array, Impedance, Pose, SolveReport
from sits_mech.sensor import Sensor, Target


@dataclass(frozen=True)
class Rung:
    """How fine the coarser of the two divisions is.

    Attributes
    ----------
    skin : float
        First cell and sheet at the surface over the skin depth.
    growth : float
        Ratio of neighbouring cells.
    along : float
        Largest cell over the clearance.
    across : float
        Largest cell over the plate's half width.
    terms : float
        Digits (natural logarithm) the coils' field keeps.
    """

    skin: float
    growth: float
    along: float
    across: float
    terms: float


# Asked error of the change of inductance -> division of the plate; measured in studies/benchmark_sheets.py.
LADDER = (
    (1e-2, Rung(skin=2.5, growth=4.0, along=1.2, across=0.4, terms=7.0)),
    (5e-3, Rung(skin=2.0, growth=4.0, along=0.9, across=0.33, terms=8.0)),
    (2e-3, Rung(skin=1.6, growth=3.4, along=0.6, across=0.25, terms=9.0)),
    (1e-3, Rung(skin=1.5, growth=2.9, along=0.5, across=0.2, terms=10.0)),
)
_FINEST = 0.16  # smallest the largest cell may get, over the half width
_MOST = 2000  # polynomials in all; what a wide plate close to the coils misses is in its estimated error
_RESISTIVE = 0.8  # where the current fills the thickness, cells are smaller by this


@dataclass(frozen=True)
class _Doubt:
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

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L and R [H, ohm] for one pose or many at `frequency` [Hz].

        Raises
        ------
        Collision
            If a pose brings the target to the coil plane.
        ValueError
            If the frequency is not positive.
        """
        check_clearance(self.sensor, pose)
        d_h, d_v, alpha = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (pose.d_h, pose.d_v, pose.alpha)))
        c, s, o = np.cos(alpha), np.sin(alpha), np.zeros(alpha.shape)
        rotation = np.stack([c, o, s, o, o + 1.0, o, -s, o, c], axis=-1).reshape(*alpha.shape, 3, 3)
        found = self.impedance_at(rotation, np.stack([d_h, o, d_v], axis=-1), frequency)
        return found if self.windings == "rings" else _against_rings(found, self.sensor)

    def impedance_at(self, rotation: Array, offset: Array, frequency: float) -> Impedance:
        """Return L and R [H, ohm] for any rigid poses at `frequency` [Hz].

        Parameters
        ----------
        rotation : ndarray, shape (..., 3, 3)
            Takes the target's own axes to the scene's.
        offset : ndarray, shape (..., 3)
            Centre of the target's bottom face [m].
        frequency : float
        """
        began = time.perf_counter()
        if not 0.0 < frequency < np.inf:
            raise ValueError(f"frequency: must be a positive number of hertz, got {frequency}")
        shape = np.broadcast_shapes(np.shape(rotation)[:-2], np.shape(offset)[:-1])
        turns = np.broadcast_to(rotation, (*shape, 3, 3)).reshape(-1, 3, 3)
        places = np.broadcast_to(offset, (*shape, 3)).reshape(-1, 3)
        n = len(self.sensor.coils)
        fine, coarse, unknowns, doubt, notes = self._changes(turns, places, frequency)
        change = ((4 * fine - coarse) / 3).reshape(*shape, n, n)
        spread = (doubt.trust * (fine - coarse) / 3).reshape(*shape, n, n)
        omega = 2 * np.pi * frequency
        scale = _largest(change.imag / omega)
        error_L = _largest(spread.imag / omega) + doubt.unseen * scale
        error_R = _largest(spread.real) + (doubt.unseen + doubt.skin) * _largest(change.real)
        relative = float(np.max(error_L / np.where(scale > 0.0, scale, 1.0), initial=0.0))
        L0 = free_space(self.sensor, self.windings)
        R_dc = track_resistances(self.sensor)
        report = SolveReport("sheets", unknowns, 1, 0.0, relative, time.perf_counter() - began, notes=notes)
        return Impedance(frequency, L0 + change.imag / omega, change.real, L0, R_dc, error_L, error_R, "H", report)

    def _changes(
        self, turns: Array, places: Array, frequency: float
    ) -> tuple[Complex, Complex, int, _Doubt, tuple[str, ...]]:
        """Delta Z on the fine and the coarse division, unknowns, how far to trust them, and what there is to say."""
        sensor, scale = self.sensor, math.ceil(math.log10(frequency) - 1e-9)
        parts = placed_plates(sensor, self.outline, turns, places)
        if not parts or places.size == 0:
            none = np.zeros((places.shape[0], len(sensor.coils), len(sensor.coils)), dtype=complex)
            return none, none, 0, _Doubt(), ()
        rung = next((rung for error, rung in LADDER if self.tolerance >= error), LADDER[-1][1])
        answering, doubts, notes = [], [], []
        for part in parts:
            octave = math.floor(math.log2(part.gap) + 1e-9)
            reach = _reach(sensor, part.middle) + 2 * 2.0**octave
            divisions = [prepared(part.plate, part.outline, rung, (octave, scale, reach), h) for h in (1, 0)]
            answering.append(Answering(tuple(divisions), part.turns, part.places))
            depth, unseen = _skin_depth(part.plate, frequency), _unseen(divisions[0].box)
            thin = depth > part.plate.thickness
            first = rung.skin * _skin_depth(part.plate, 10.0**scale) / (1.0 + math.sqrt(rung.growth))
            doubts.append((1.0 / 3.0 if thin else 1.0, unseen, 0.0 if thin else (first / depth) ** 2 / 12))
            notes += [part.title + note for note in _notes(part.plate.thickness / depth, divisions[0].sheets, unseen)]
        unknowns = sum(plate.divisions[0].unknowns for plate in answering)
        if sensor.conductors:
            target = answering.pop(0) if sensor.target is not None else None
            fine, coarse = coupled_reactions(sensor.coils, self.windings, target, answering, frequency)
            fine, coarse = ((Z + np.swapaxes(Z, 1, 2)) / 2 for Z in (fine, coarse))
            fine, coarse = (np.broadcast_to(Z, (places.shape[0], *Z.shape[1:])) for Z in (fine, coarse))
        else:
            fine, coarse = reactions(sensor.coils, self.windings, answering[0].divisions, (turns, places), frequency)
        doubt = _Doubt(*(max(several) for several in zip(*doubts, strict=True)))
        return fine, coarse, unknowns, doubt, tuple(notes)


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
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance: must lie between 0 and 1, got {tolerance}")
    windings = sensor.coils[0].winding if windings is None else windings
    if windings not in ("rings", "spiral"):
        raise ValueError(f'windings: must be "rings" or "spiral", got {windings!r}')
    if outline is not None and sensor.target is None:
        raise ValueError("outline: needs a scene with a target, whose thickness and metal it takes")
    return Sheets(sensor, tolerance, windings, outline)


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


@lru_cache(maxsize=32)
def free_space(sensor: Sensor, windings: str = "rings") -> Array:
    """Return the coils' inductance matrix without target, shape (n, n) [H]."""
    return spiral_inductances(sensor.coils) if windings == "spiral" else coil_inductances(sensor.coils)


def track_resistances(sensor: Sensor) -> Array:
    """Direct-current resistance of each coil's copper tracks [ohm], shape (n,)."""
    sigma = metals()["copper"].conductivity
    return np.array([track_length(c) / (sigma * c.track_width * c.track_thickness) for c in sensor.coils])


def _against_rings(found: Impedance, sensor: Sensor) -> Impedance:
    """Say how far spiral windings are from rings."""
    step = float(np.max(np.abs(np.diag(found.L0) / np.diag(free_space(sensor)) - 1.0)))
    note = f"spiral windings: L0 differs from that of rings by up to {step:.2%}"
    return replace(found, report=replace(found.report, notes=(*found.report.notes, note)))


def _largest(matrices: Array) -> Array:
    """Largest entry of each matrix in size, for all its entries."""
    return np.broadcast_to(np.abs(matrices).max(axis=(-2, -1), keepdims=True), matrices.shape)


@lru_cache(maxsize=32)
def prepared(
    target: Target, outline: Outline | None, rung: Rung, scale: tuple[int, int, float], halvings: int
) -> Sheeted:
    """Return the target prepared for clearances from 2^scale[0] m on and frequencies up to 10^scale[1] Hz.

    The third of `scale` is how far from the target's middle the coils' currents call for small cells [m].
    """
    clearance, skin_depth = 2.0 ** scale[0], _skin_depth(target, 10.0 ** scale[1])
    shape = target_outline(target, outline)
    half = np.array([*np.abs(shape.rim).max(0) * (1.0 + 1e-3), target.thickness / 2])
    box = _box(half, clearance, rung.terms)
    width = min(float(half[:2].min()), scale[2])
    largest = min(rung.along * (clearance + target.thickness / 2), rung.across * width)
    largest = max(largest, _FINEST * width) * (_RESISTIVE if 2 * skin_depth > target.thickness else 1.0)
    first = min(rung.skin * skin_depth, largest)
    grading = Grading(first, rung.growth, largest, halvings, scale[2])
    levels = graded_axis(target.thickness / 2, grading, target.thickness / 2)
    plan = _plan(target, outline, grading, max(box.order[:2]))
    return prepare_sheets(plan, levels, target.metal.conductivity, box, depth=min(skin_depth, target.thickness / 2))


def _plan(target: Target, outline: Outline | None, grading: Grading, orders: int) -> Plan:
    """Division of the target's outline."""
    if outline is None and target.shape == "rectangle":
        return rectangle_plan(*target.extent, grading)
    if outline is None and target.shape == "disc":
        return disc_plan(target.extent[0], grading, orders=orders)
    return outline_plan(target_outline(target, outline), grading)


def _box(half: Array, clearance: float, terms: float) -> Box:
    """Bounding box with the polynomials that a field singular `clearance` below it needs (as `plate.series_order`)."""
    rates = [math.asinh((clearance + half[2]) / side) for side in half]
    order = [math.ceil(terms / (2 * rate)) + extra for rate, extra in zip(rates, (3, 3, 1), strict=True)]
    short, long = (0, 1) if half[0] <= half[1] else (1, 0)
    order[short] = min(order[short], math.isqrt(_MOST // order[2]))
    order[long] = min(order[long], _MOST // (order[2] * order[short]))
    return Box(half, (order[0], order[1], order[2]), (math.exp(rates[0]), math.exp(rates[1]), math.exp(rates[2])))


def _reach(sensor: Sensor, middle: tuple[float, float]) -> float:
    """Farthest winding from a plate's middle along x or y [m]."""
    return max(max(abs(c - m) for c, m in zip(coil.centre, middle, strict=True)) + coil.outer_diameter / 2
               for coil in sensor.coils)  # fmt: skip


def _skin_depth(target: Target, frequency: float) -> float:
    """Skin depth of the target's metal [m]."""
    return math.sqrt(1.0 / (math.pi * frequency * mu_0 * target.metal.conductivity))


def _unseen(box: Box) -> float:
    """Share of the coils' field energy that the box's polynomials miss: rho^-2n."""
    return float(max(rho ** (-2.0 * n) for rho, n in zip(box.decay[:2], box.order[:2], strict=True)))


def _notes(ratio: float, sheets_used: int, unseen: float) -> tuple[str, ...]:
    """Say which skin regime holds, what carries it, and whether the gap is too small for the division."""
    regime = "thin" if ratio < 1.0 else "thick" if ratio > 3.0 else "intermediate"
    used = f"{regime} skin regime: thickness is {ratio:.3g} skin depths; {sheets_used} sheets joined at the rim"
    if unseen < 1e-3:
        return (used,)
    return used, f"the gap is small for so wide a plate: {unseen:.1%} of the coils' field is not resolved"
