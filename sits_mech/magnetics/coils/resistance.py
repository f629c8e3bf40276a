"""Uneven current in the coils' tracks, skin and proximity effect, at many frequencies from one division.

Every turn is a ring, divided into filaments f of height h_f from radius a_f to b_f that share the turn's voltage v_t:

    (R_f + j omega L_fg) i_g = v_t(f) - j omega e_f,    R_f = 2 pi / (sigma h_f ln(b_f / a_f)),    L_fg by `loops`,

with e_f the flux of what is not the coil, linear across a track: of B up and outwards, b,

    e = E b,    E_f = 2 pi r_f (r_f - r_t),    -2 pi r_f (z_f - z_t).

Filaments are graded to the surfaces; those for the highest frequency serve every lower one. Their eigenproblem
``L v = tau R v`` gives Z^-1 of all filaments seen by turns (P: filaments to turns) and by E,

    A(omega) = C diag(1 / (1 + j omega tau)) C^T,    C = (P, E)^T v.

With the current 1 in every turn, i = Z^-1 P (P^T Z^-1 P)^-1 1, and i_0 even over each section,

    Z = 1^T (P^T Z^-1 P)^-1 1 + 2 m . b + b . Q b,    m = j omega E^T (i - i_0),
    Q = omega^2 E^T [Z^-1 - Z^-1 P (P^T Z^-1 P)^-1 P^T Z^-1] E,

less 2 e^T i_0, which is what a model of even current gives. L of that current is ``i_0^T L i_0``.

Coils that are not round are taken as rings of their turns, length and pitch (`geometry.tracks.standing_rings`): an
estimate, of uneven current along their straight tracks too.

Twice as many filaments along both sides and ``(4 fine - coarse) / 3`` give the answer, its step from `fine` the error.

Range: non-magnetic tracks; a turn closes on itself (no pitch, no vias). Neglected: displacement current, so that
no statement is made near a coil's own resonance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from sits_mech.disk_cache import kept
from sits_mech.geometry.tracks import ring_squares, standing_rings, track_squares
from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.coils.loops import free_inductances, ring_inductance
from sits_mech.magnetics.modes import Modes, eddy_modes, skin_depth
from sits_mech.memory import check_seconds
from sits_mech.quantities import Array, Complex
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Coil

_ABOVE = 1.1  # of the frequency that filaments are made for, up to which they serve
_LEAST = 6e-3  # error of R, over what uneven current adds: four layers of tracks three skin depths wide show as much
_LEFT, _WHOLE = 0.5, 3.0  # error of what two divisions extrapolate to, over what that adds: 0.06 to 0.54 seen; of few
_MOST = 4000  # filaments: an eigenproblem of ten seconds
_PAIR, _MODE = 1.1e-6, 1.9e-10  # s that a pair of filaments takes, and the modes of n over n^3: 16 s of 3264


def track_conductivity(coil: Coil) -> float:
    """Return the conductivity of a coil's tracks, copper's unless the scene gives another [S/m]."""
    return coil.conductivity or metals()["copper"].conductivity


def track_resistance(coil: Coil) -> float:
    """Return the direct-current resistance of a coil's tracks [ohm]."""
    return track_squares(coil) / (track_conductivity(coil) * coil.track_thickness)


def coils_alone(coils: Sequence[Coil], windings: str = "rings") -> tuple[Array, Array]:
    """Return inductances of even current and direct-current resistances without metal, (n, n) [H] and (n,) [ohm]."""
    return free_inductances(coils, windings), np.array([*map(track_resistance, coils)])


@dataclass(frozen=True, eq=False)
class TrackResponse:
    """What current in a coil's tracks does at one frequency, alone and in the field b of metal, turn by turn."""

    alone: complex  # series impedance less that of even current by its direct-current resistance [ohm]
    error: complex  # its real and its imaginary part's
    linear: Complex  # (2 t,) m [ohm A/T], b up before b outwards
    quadratic: Complex  # (2 t, 2 t) Q [ohm A^2/T^2]


def track_response(coil: Coil, frequency: float, highest: float) -> TrackResponse:
    """Return what a coil's tracks do at a frequency [Hz], by filaments for a highest one, or for its own if above.

    All is that of copper at sigma f over copper's sigma, times copper's sigma over the tracks'.
    """
    copper, sigma = metals()["copper"].conductivity, track_conductivity(coil)
    made = highest if frequency <= _ABOVE * highest else 2.0 ** math.ceil(math.log2(frequency))
    found = _of_copper(coil.model_copy(update={"conductivity": None}), frequency * sigma / copper, made)
    scale = copper / sigma
    return TrackResponse(
        scale * found.alone, scale * found.error, scale * found.linear, scale * found.quadratic
    )


@lru_cache(maxsize=128)
def rough_alone(coil: Coil, frequency: float) -> complex:
    """Return about what uneven current by other turns' field adds to a coil's impedance [ohm].

    By two filaments along each side, which are alike in a track's own field.
    """
    return _series(*_rough(coil), frequency)[0]


@lru_cache(maxsize=32)
def _rough(coil: Coil) -> tuple[Sections, Modes]:
    """Return rings and their modes by two filaments along each side; every scene of a batch asks for its coils'."""
    rings = standing_rings(coil)
    return rings, _modes(rings, (2, 2))


@lru_cache(maxsize=128)
def _of_copper(coil: Coil, frequency: float, highest: float) -> TrackResponse:
    """Return the response of tracks of copper."""
    rings, (both, few) = standing_rings(coil), _filaments(coil, highest)
    each = [_series(rings, modes, frequency) for modes in both]
    alone, linear, quadratic = ((4.0 * fine - coarse) / 3.0 for coarse, fine in zip(*each, strict=True))
    off = (_WHOLE if few else _LEFT) * (alone - each[1][0])
    off = complex(max(abs(off.real), _LEAST * alone.real), abs(off.imag))
    more = 1.0 if coil.is_round else track_squares(coil) / ring_squares(rings.radius, rings.width).sum()
    return TrackResponse(  # as much more is lost as the coil has squares
        complex(more * alone.real, alone.imag), complex(more * off.real, off.imag), more * linear, more * quadratic
    )


@lru_cache(maxsize=16)
def _filaments(coil: Coil, highest: float) -> tuple[tuple[Modes, ...], bool]:
    """Return modes of a coarse and a fine division for a highest frequency [Hz]; whether they are fewer than asked."""
    rings, delta = standing_rings(coil), skin_depth(highest, metals()["copper"].conductivity)
    cells = [filaments_along(side, delta) for side in (coil.track_width, coil.track_thickness)]
    asked = list(cells)
    while 4 * math.prod(cells) * rings.radius.size > _MOST and max(cells) > 2:
        cells[int(np.argmax(cells))] -= 1
    count = 4 * math.prod(cells) * rings.radius.size
    check_seconds((_PAIR + _MODE * count) * count**2, f"uneven current in a coil of {rings.radius.size} turns")
    both = tuple(
        kept(
            ("tracks in fields", rings, (n * cells[0], n * cells[1])),
            partial(_modes, rings, (n * cells[0], n * cells[1])),
            lambda own: {"tau": own.tau, "coupling": own.coupling}, lambda arrays: Modes(**arrays), __name__,
        )
        for n in (1, 2)
    )
    return both, cells != asked


def _series(rings: Sections, modes: Modes, frequency: float) -> tuple[complex, Complex, Complex]:
    """Return the impedance, m and Q of all turns in series with one division, as `TrackResponse`."""
    n, omega, signs = rings.radius.size, 2.0 * np.pi * frequency, rings.signs  # the current in each turn
    (even, *_), C, E = np.split(modes.coupling, [1, 1 + n])
    A = Modes(modes.tau, modes.coupling[1:]).admittance(omega) / omega**2
    driven = np.linalg.solve(A[:n, :n], np.column_stack([signs, A[:n, n:]]))  # voltages of turns
    steady = signs @ np.linalg.solve(C @ C.T, signs)
    alone = signs @ driven[:, 0] - steady - 1j * omega * even**2 @ modes.tau
    linear = 1j * omega * (A[n:, :n] @ driven[:, 0] - E @ even)
    quadratic = omega**2 * (A[n:, n:] - A[n:, :n] @ driven[:, 1:])
    return complex(alone), linear, quadratic


def _modes(rings: Sections, cells: tuple[int, int]) -> Modes:
    """Return modes of copper filaments, seen by even current, by turns and by fields across these, up and outwards."""
    parts, n, copper = filaments_of(rings, cells), cells[0] * cells[1], metals()["copper"].conductivity
    R = ring_squares(parts.radius, parts.width) / (copper * parts.height)
    each = np.eye(rings.radius.size)
    share, around = np.repeat(each, n, axis=1), 2.0 * np.pi * parts.radius
    up = share * around * (parts.radius - np.repeat(rings.radius, n))
    outwards = -share * around * (parts.z - np.repeat(rings.z, n))
    even = R * np.repeat(rings.signs / (rings.width * rings.height), n) * parts.width * parts.height
    found = eddy_modes(ring_inductance(parts, points=(1, 1)), R, np.vstack([even, share, up, outwards]))
    return Modes(found.tau, found.coupling)


def filaments_of(rings: Sections, cells: tuple[int, int]) -> Sections:
    """Return each ring as cells[0] x cells[1] filaments, finest at its surfaces, ring after ring."""
    across, up = (-np.cos(np.pi * np.arange(n + 1) / n) / 2 for n in cells)
    x, z = np.meshgrid((across[1:] + across[:-1]) / 2, (up[1:] + up[:-1]) / 2, indexing="ij")
    w, h = np.meshgrid(np.diff(across), np.diff(up), indexing="ij")
    width, height = rings.width[:, None], rings.height[:, None]
    columns = (
        rings.radius[:, None] + width * x.ravel(), rings.z[:, None] + height * z.ravel(), width * w.ravel(),
        height * h.ravel(),
    )
    return Sections(*(column.ravel() for column in columns))


def filaments_along(side: float, delta: float) -> int:
    """Return the cells along a side, so that the outermost of the coarse division is about 0.7 skin depths."""
    return max(2, math.ceil(math.sqrt(2.5 * side / (0.7 * delta))))
