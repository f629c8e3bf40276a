"""The coils' field at the plates' nodes, and several plates together: what a pose costs in the planar integral model.

A coil's bars carry s_k = +-1 A per ampere of the coil and have the complex potential f with A = Re f,

    f'(p) = -(mu0 / 2 pi) sum_k s_k [1 / (p - p_k) + conj(p_k) / (R_b^2 - p conj(p_k))],    p = x + j z;

the second term is the image in a circle of radius R_b about the origin where A = 0 (absent for R_b = infinity).
Each bar is a grid of Gauss filaments, as many as its distance asks for. A plate of thickness t samples f' at its nodes
zeta = xi + j eta (`sampling`), in its own frame:

    p(zeta) = d_h + j d_v + exp(-j alpha) (zeta + j t/2),    df/dzeta = f'(p) exp(-j alpha).

The constant in A acts on a plate with a free net current alone.

Several plates: each answers to the coils and to the others' eddy currents. Plate X sees a potential with the
coefficients c_X and answers with the bar currents ``K_X c_X`` (`plate`).
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
from scipy.constants import mu_0

from sits_mech.geometry.plates import PlateSection
from sits_mech.geometry.windings import Bars
from sits_mech.magnetics.section.kernels import gauss_count, gauss_rule
from sits_mech.magnetics.section.plate import PreparedPlate
from sits_mech.memory import check_seconds
from sits_mech.quantities import Array, Complex, Pose

_PAIRS = 30_000  # pairs of points and filaments held at once, so that they stay in the cache
_PAIR = 6e-9  # s that one takes, as 9e8 did


@dataclass(frozen=True)
class Filaments:
    """All coils' currents as line currents."""

    x: Array  # (k,) [m]
    z: Array  # (k,) [m]
    current: Array  # (k, n) of each filament per ampere in each coil
    radius: float | None  # R_b of the grounded circle; None for free space [m]


def filaments(coils: tuple[Bars, ...], clearance: float, error: float, radius: float | None) -> Filaments:
    """Replace bars by Gauss filaments that are right to `error` from `clearance` above the uppermost bars' faces on."""
    x, z, columns = [], [], []
    for number, bars in enumerate(coils):
        sides = bars.width, bars.thickness
        (gx, wx), (gz, wz) = (gauss_rule(gauss_count(side, clearance, error)) for side in sides)
        x.append((bars.x[:, None, None] + bars.width / 2 * gx[:, None] + 0 * gz).ravel())
        z.append((bars.z[:, None, None] + 0 * gx[:, None] + bars.thickness / 2 * gz).ravel())
        current = np.zeros((x[-1].size, len(coils)))
        current[:, number] = (bars.sign[:, None, None] * wx[:, None] * wz).ravel()
        columns.append(current)
    return Filaments(np.concatenate(x), np.concatenate(z), np.concatenate(columns), radius)


def samples(source: Filaments, pose: Pose, thickness: float, nodes: Complex) -> Array:
    """Return what a plate sees of n coils at its m nodes in p poses, shape (p, n, 2 m) or (p, n, 2 m + 1).

    Re f' and Im f' at the nodes xi + j eta from the centre of the section [V s/m^2 per A]; with a grounded circle, A at
    the centre follows [V s/m per A].
    """
    middle, turn = _middle(pose, thickness)
    slope = _slope(source, (middle + turn * nodes).ravel()).reshape(middle.size, nodes.size, -1) * turn[..., None]
    parts = [slope.real, slope.imag]
    if source.radius is not None:
        places, points = source.x + 1j * source.z, middle.reshape(-1, 1)
        image = source.radius - points * places.conj() / source.radius
        logs = np.log(np.abs(points - places)) - np.log(np.abs(image))
        parts.append((-mu_0 / (2 * np.pi) * logs @ source.current)[:, None])
    return np.swapaxes(np.concatenate(parts, axis=1), 1, 2)


def circle_samples(pose: Pose, thickness: float, nodes: Complex, radius: float, terms: int) -> Array:
    """Return samples of Re, then Im of ``(p / R_b)^m, m = 1 ... terms``; shape (p, 2 terms, 2 nodes + 1)."""
    middle, turn = _middle(pose, thickness)
    m = np.arange(1, terms + 1)[:, None]
    points, turn = ((middle + turn * nodes) / radius)[:, None], turn[:, None]
    slope = m * points ** (m - 1) * turn / radius
    centre = (middle / radius)[:, None] ** m
    real = np.concatenate([slope.real, slope.imag, centre.real], axis=-1)
    imaginary = np.concatenate([slope.imag, -slope.real, centre.imag], axis=-1)  # Im f = Re(-j f)
    return np.concatenate([real, imaginary], axis=1)


def _middle(pose: Pose, thickness: float) -> tuple[Complex, Complex]:
    """Return centre of the section and the factor exp(-j alpha), both of shape (p, 1)."""
    turn = np.exp(-1j * np.atleast_1d(pose.alpha))[:, None]
    centre = (np.atleast_1d(pose.d_h) + 1j * np.atleast_1d(pose.d_v))[:, None]
    return centre + 0.5j * thickness * turn, turn


def _slope(source: Filaments, points: Complex) -> Complex:
    """Return f' of every coil at points, shape (points, coils)."""
    size, number = points.size, source.x.size
    check_seconds(_PAIR * size * number, f"planar: the field of {number} filaments of the coils at {size} points")
    result = np.empty((size, source.current.shape[1]), dtype=complex)
    step = max(1, _PAIRS // number)
    for start in range(0, size, step):
        part = slice(start, start + step)
        dx = points.real[part, None] - source.x
        dz = points.imag[part, None] - source.z
        inverse = 1.0 / (dx * dx + dz * dz)
        dx *= inverse
        dz *= inverse
        result[part] = dx @ source.current - 1j * (dz @ source.current)
        if source.radius is not None:
            mirror = source.x - 1j * source.z
            result[part] += (mirror / (source.radius**2 - points[part, None] * mirror)) @ source.current
    return np.asarray(-mu_0 / (2 * np.pi) * result)


@dataclass(frozen=True)
class SectionPlate:
    """A plate in its place, ready to answer."""

    place: PlateSection
    prepared: PreparedPlate


def coupled_reaction(plates: tuple[SectionPlate, ...], source: Filaments, omega: float, finest: int = 0) -> Complex:
    """Return Delta Z of the coils over several plates, shape (n, n) [ohm/m]; not yet symmetrised.

    `source` are all coils, in free space; omega [rad/s]; `finest` division in use, from 1 on for the check.
    """
    own = [_rows(plate, source) for plate in plates]
    ends = np.cumsum([0, *(rows.shape[0] for rows in own)])
    system = np.eye(ends[-1], dtype=complex)
    for k, emitter in enumerate(plates):
        places, currents = emitter.prepared.currents(omega, finest)  # a column for each of its coefficients
        p = emitter.place.placed(places + 0.5j * emitter.place.thickness)
        fields = [Filaments(p.real, p.imag, part, None) for part in (currents.real, currents.imag)]
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
