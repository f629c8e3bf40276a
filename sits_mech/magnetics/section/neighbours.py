"""Several plates in the planar integral model: each answers to the coils and to the others' eddy currents.

Plate X sees a potential with the coefficients c_X (`coupling`) and answers with the bar currents ``K_X c_X`` (`plate`).
Those currents are line currents to every other plate, which sees their potential with coefficients
G_XY K_Y c_Y; so, with c0 the coils' own coefficients,

    c_X = c0_X + sum over Y != X of G_XY K_Y c_Y,        Delta Z = sum over X of c0_X^T Y_X c_X.

Only the few coefficients are unknown, whatever the plates' division; no air is meshed. The coefficients are real for a
source without phase: phasors enter through K alone.

Range: isolated non-magnetic plates of rectangular section that do not touch. Bars stand as filaments at their centres,
so that plates closer than a few of their bars' lengths need the finer rungs; the divisions know the distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.plates import Plate
from sits_mech.magnetics.section.coupling import Filaments, samples
from sits_mech.magnetics.section.plate import PreparedPlate
from sits_mech.quantities import Array, Complex, Pose


@dataclass(frozen=True)
class SectionPlate:
    """A plate in its place, ready to answer."""

    place: Plate
    prepared: PreparedPlate


def coupled_reaction(
    plates: tuple[SectionPlate, ...], source: Filaments, omega: float, finest: int = 0
) -> Complex:
    """Return Delta Z of the coils over several plates, shape (n, n) [ohm/m]; not yet symmetrised.

    `source` are all coils, in free space; omega [rad/s]; `finest` division in use, from 1 on for the check.
    """
    own = [_rows(plate, source) for plate in plates]
    ends = np.cumsum([0, *(rows.shape[0] for rows in own)])
    system = np.eye(ends[-1], dtype=complex)
    for k, emitter in enumerate(plates):
        fields = _emitted(emitter, omega, finest)
        for i, receiver in enumerate(plates):
            if i != k:
                real, imaginary = (_rows(receiver, part) for part in fields)
                system[ends[i] : ends[i + 1], ends[k] : ends[k + 1]] = -(real + 1j * imaginary)
    total = np.linalg.solve(system, np.concatenate(own))
    change = np.zeros((source.current.shape[1],) * 2, dtype=complex)
    for k, plate in enumerate(plates):
        Y = plate.prepared.admittance(omega, finest)
        change += own[k].T @ Y @ total[ends[k] : ends[k + 1]]
    return change


def _rows(plate: SectionPlate, source: Filaments) -> Array:
    """Return coefficients of a source's potential on a plate, shape (k, columns of the source)."""
    place = plate.place
    pose = Pose(np.array([place.bottom.real]), np.array([place.bottom.imag]), np.array([place.alpha]))
    return plate.prepared.coefficients(samples(source, pose, place.thickness, plate.prepared.nodes)[0]).T


def _emitted(plate: SectionPlate, omega: float, finest: int) -> tuple[Filaments, Filaments]:
    """Return a plate's bars as line currents, real and imaginary phasors, one column for each of its coefficients."""
    places, currents = plate.prepared.currents(omega, finest)
    p = plate.place.placed(places + 0.5j * plate.place.thickness)
    return Filaments(p.real, p.imag, currents.real, None), Filaments(p.real, p.imag, currents.imag, None)
