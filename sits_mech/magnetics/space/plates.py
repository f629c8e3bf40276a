"""Prepare a plate of a scene for the three-dimensional model: how finely, by what it sees, near its coils or away."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.constants import mu_0

from sits_mech.geometry.collision import PlacedPlate, placed_plates
from sits_mech.geometry.windings import kinds_of
from sits_mech.magnetics.answer import clearance_of
from sits_mech.magnetics.coils.far_field import coil_field
from sits_mech.magnetics.modes import skin_depth
from sits_mech.magnetics.permeable.plates import prepared_permeable
from sits_mech.magnetics.space.divisions import (
    field_length,
    is_near,
    lone_frequency,
    prepared,
    prepared_near,
    unseen,
)
from sits_mech.magnetics.space.rungs import DIVISIONS, PlateRung
from sits_mech.magnetics.space.sources import Posed, Sources, farthest_winding
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, Array, Pose, tensor_grid
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import Coil, Conductor, SceneError, Sensor, Target

_GRID, _STEP = 17, 1e-4  # places along a side: 1.3 % from 0.2 mm on, 20 mm wide; steps of A, over the narrower side
_AROUND = 0.5, 0.1  # thickness of a permeable ring over its skin depth, and the field of current around it, at most
_RADII, _ANGLES, _UNSURE = 4, 24, 0.5  # of points by which that is known; of its losses, error
_PLATES = 1.5  # length on which another plate's field changes, over the distance


@dataclass(frozen=True)
class PlateRequest:
    """A plate to be divided: its susceptibility, the coils if it stands still, what is divided like it."""

    plate: Target
    susceptibility: complex
    sources: Sources | None
    become: Target | None

    def lengths(self, sensor: Sensor, clear: tuple[float, ...], near: bool) -> tuple[tuple[float, float], float]:
        """Return how far currents of coils call for small cells and for some, and how long their fields are [m]."""
        clearance, deep = clear[0], 0.0 if near and not self.sources else self.plate.thickness / 2
        if self.sources is not None:
            clearance = self.sources.distance
        length = min(field_length(coil, clearance + deep) for coil in kinds_of(sensor.coils)[0])
        others = _PLATES * (clear[0] + self.plate.thickness / 2) if sensor.conductors else length
        wide, deep = farthest_winding(sensor.coils, self.sources), 2 * clearance
        return (wide + deep, 2.0 * wide / (1.0 if self.sources else clear[2]) + deep), min(length, others)


def target_room(sensor: Sensor, part: PlacedPlate) -> tuple[Array, float]:
    """Return a target's room for its travel (p,), and its anchor, as of `answer.clearances`.

    Cells grow from 2 w / room on, w the farthest winding from the middle: a room of 1 serves a travel up to w.
    """
    wide, plate, steady = farthest_winding(sensor.coils, None), sensor.target, 1.0 / clearance_of(0, 1.0)
    large = plate is not None and max(plate.extent) > 4.0 * wide
    aside = large * np.linalg.norm(part.places[:, :2], axis=1) + 0.0 * part.gap
    return steady / (1.0 + np.maximum(0.0, aside - wide) / (2.0 * wide)), steady


@dataclass(frozen=True)
class Divided:
    """A plate's divisions, its skin depths, the field that they miss, what to say."""

    divisions: tuple[Any, ...]  # `Moving`; of a permeable plate all as found, and more that are off by its errors
    thickness: float
    unseen: float
    close: bool  # whether it moves so close to the coils that it sees them cell by cell
    notes: tuple[Note, ...]


def holed(plate: Target | Conductor, frequency: float) -> bool:
    """Whether a permeable plate has holes that `shells` do not hold: in an outline, or where much current goes around.

    In a field along its axis that of a ring of radius a, t thick, has t a / (2 mu_r delta^2) of the field itself, and
    less; where t is small to delta, `around_holes` holds it. Of its losses 0.6 to 0.9 times as much are left out of
    omega L (beside `axis_fem`, mu_r 2 to 20), at a tenth; beyond it is refused.
    """
    metal = plate.metal
    if metal.susceptibility == 0.0 or plate.shape != "ring":
        return metal.susceptibility != 0.0 and bool(plate.holes)
    depth, t = skin_depth(frequency, metal.conductivity, metal.relative_permeability), plate.thickness
    own = t * max(plate.extent) / (4.0 * metal.relative_permeability * depth**2)
    return t > _AROUND[0] * depth or own > _AROUND[1]


def permeable_rings(parts: Sequence[PlacedPlate]) -> list[PlacedPlate]:
    """Return those of the plates whose current goes around a hole as `around_holes` has it."""
    return [part for part in parts if part.susceptibility != 0.0 and part.plate.shape == "ring"]


def around_holes(parts: Sequence[PlacedPlate], coils: Posed, clearance: float, omega: float) -> tuple[Array, Array]:
    """Return what current around the holes of permeable rings adds to R of coils, and its error, (p, n, n) [ohm].

    By the coils' own A, whose mean A_phi along circles drives it: R_cd = omega^2 sigma int A_c A_d dV. Beside
    `axis_fem`, five rings of mu_r 5 to 1000 have 0.71 to 1.04 of it.
    """
    found = np.zeros((1, 1, 1))
    for part in permeable_rings(parts):
        seen, (points, along, area) = replace(coils, turns=part.turns, places=part.places, lift=None), _circles(part)
        means = [
            np.einsum("parx,ax->pr", seen.turned_back(A).reshape(-1, 3, _RADII, _ANGLES), along) / _ANGLES
            for A in seen.potentials(points, clearance)
        ]
        A_phi, losses = np.stack(means, axis=1), part.plate.thickness * omega**2 * part.plate.metal.conductivity
        found = found + (A_phi * (area * losses)) @ np.swapaxes(A_phi, 1, 2)
    return found, _UNSURE * np.abs(found)


def around_share(sensor: Sensor, part: Target | Conductor, pose: Pose) -> float:
    """Return what the error of `around_holes` is of Delta Z at most, of a ring in any of some poses, by itself.

    Energy in the field of given currents is stationary, and with the coils' own B for the whole field no more than it
    is: Delta L >= (1 - 1/mu_r)/mu0 int B^2 dV. Of nine rings of mu_r 5 to 1000, Delta L was 1.8 to 5.6 times that.
    """
    fixed = isinstance(part, Conductor)
    alone = sensor.model_copy(update={"target": None if fixed else part, "conductors": (part,) * fixed})
    place, omega = Pose.of(pose.components.reshape(-1, len(POSE))[: 1 if fixed else None]), 2 * np.pi * sensor.frequency
    (placed,) = placed_plates(alone, rotation_matrix(place.rotation), place.centre)
    seen = Posed(sensor.coils, "rings", placed.turns, placed.places)
    points, _, area = _circles(placed)
    world = (points @ np.swapaxes(placed.turns, 1, 2) + placed.places[:, None]).reshape(-1, 3)
    fields = (coil_field(coil, world, _STEP * min(part.extent)) for coil in sensor.coils)
    square = np.max([(H**2).sum(axis=1).reshape(-1, _RADII, _ANGLES).mean(axis=2) @ area for H in fields], axis=0)
    unsure = around_holes([placed], seen, float(placed.gap.min()), omega)[1].max(axis=(1, 2))
    taken = abs(placed.susceptibility / (1.0 + placed.susceptibility)) * part.thickness * square
    return float(np.max(unsure / (omega * mu_0 * taken)))


def _circles(part: PlacedPlate) -> tuple[Array, Array, Array]:
    """Return points of circles in a ring, one after the other (q, 3) [m], their directions (3, a), areas (r,)."""
    (x, w), angle = np.polynomial.legendre.leggauss(_RADII), 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    way, wide = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle]), (part.plate.extent[0] - part.plate.hole) / 4
    r = part.plate.hole / 2 + wide * (1.0 + x)
    points = r[:, None, None] * way.T + (0.0, 0.0, part.plate.thickness / 2)
    return points.reshape(-1, 3), np.stack([-way[1], way[0], way[2]]), 2 * np.pi * r * w * wide


def saturation_notes(coils: Sequence[Coil], parts: Sequence[PlacedPlate]) -> Iterator[Note]:
    """Note the largest field on permeable parts, for whoever knows where they saturate."""
    for part in parts:
        if part.susceptibility != 0.0:
            lowest = int(np.argmin(part.places[:, 2]))
            turn, place = part.turns[lowest].tolist(), part.places[lowest].tolist()
            field = _field_on(tuple(coils), part.plate, tuple(map(tuple, turn)), tuple(place))
            note = Note.of(NoteKind.FIELD_ON, field=field)
            yield note.with_numbers(part=part.title) if part.title else note


@lru_cache(maxsize=64)
def _field_on(
    coils: tuple[Coil, ...], plate: Target, turn: tuple[tuple[float, ...], ...], place: tuple[float, ...]
) -> float:
    """Return the largest H of any coil with 1 A on a grid of a plate's faces, in one of its places [1/m]."""
    x, y = (size / 2 * np.linspace(-1.0, 1.0, _GRID) for size in plate.extent)
    flat = tensor_grid(x, y).reshape(-1, 2)
    flat = flat[np.hypot(*flat.T) <= plate.extent[0] / 2] if plate.is_round else flat
    faces = [np.column_stack([flat, np.full(len(flat), height)]) for height in (0.0, plate.thickness)]
    points = np.vstack(faces) @ np.transpose(turn) + place
    step = _STEP * min(plate.extent)
    return max(float(np.linalg.norm(coil_field(coil, points, step), axis=1).max()) for coil in coils)


def divided_plate(
    sensor: Sensor, part: PlateRequest, rung: PlateRung, clear: tuple[float, ...], frequency: tuple[float, float]
) -> Divided:
    """Prepare a plate for clearances from coils and from fixed plates on, a target's room, and up to a frequency."""
    plate, sources, metal = part.plate, part.sources, part.plate.metal
    if holed(plate, frequency[0]):
        must = "sheets: the frequency must be so low that little current goes around the hole of a permeable part"
        raise SceneError(f"{must}; got {frequency[0]:g} Hz")
    if part.susceptibility != 0.0:
        others, distance = clear[1::-1] if sources is None else (clear[0], sources.distance)
        reached, own = (distance, *part.lengths(sensor, clear, True)), replace(rung, few=False, step=0.0)
        found, *off = prepared_permeable(plate, part.susceptibility, own, reached, (others, sources))
        depths = plate.thickness / skin_depth(frequency[0], metal.conductivity, metal.relative_permeability)
        note = Note.of(NoteKind.PERMEABLE, permeability=metal.relative_permeability, depths=float(depths))
        return Divided((found,) * DIVISIONS + tuple(off), 0.0, 0.0, False, (note,))
    near = sources is not None or is_near(plate, clear[0], rung)
    scale = clear[0], frequency[1], *part.lengths(sensor, clear, near)
    asked = plate, replace(rung, few=False, step=0.0), scale  # neither divides
    if near:
        kind = sources or clear[1], part.become
        lone = lone_frequency(*asked, kind, frequency[0] * (frequency[0] == sensor.frequency))  # else one of many
        divisions: tuple[Any, ...] = prepared_near(*asked, *kind, lone)
    else:
        divisions = prepared(*asked, part.become)
    thickness = (part.become or plate).thickness / skin_depth(frequency[0], metal.conductivity)
    close = near and sources is None
    lost = 0.0 if close else unseen(divisions[0].box)
    notes = [Note.of(NoteKind.SKIN, depths=float(thickness), sheets=int(divisions[-1].sheets))]
    notes += [Note.of(NoteKind.GAP_SMALL, share=float(lost))] * (lost >= 1e-3)
    return Divided(divisions, thickness, lost, close, tuple(notes))

