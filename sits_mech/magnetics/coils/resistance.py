"""Resistance of the coils' tracks, direct and with skin and proximity effect, at many frequencies from one division.

Every turn is a ring, divided into filaments f of height h_f from radius a_f to b_f that share the turn's voltage v_t:

    (R_f + j omega L_fg) i_g = v_t(f),    R_f = 2 pi / (sigma h_f ln(b_f / a_f)),    L_fg by `loops`.

Filaments are graded to the surfaces; those for the highest frequency serve every lower one. Their eigenproblem
``L v = tau R v`` gives the turn-by-turn admittance (P: filaments to turns)

    Y(omega) = C diag(1 / (1 + j omega tau)) C^T,    C = P^T v,

a coil's series impedance is the sum of the entries of Y^-1, and its inductance at rest, current by resistance alone,

    L(0) = u^T C diag(tau) C^T u,    u = (C C^T)^-1 1.

Coils that are not round are taken as rings of their turns, length and pitch (`geometry.tracks.standing_rings`): an
estimate, of uneven current along their straight tracks too.

Twice as many filaments along both sides and ``(4 fine - coarse) / 3`` give the answer, its step from `fine` the error.

Range: tracks of copper, non-magnetic; a turn closes on itself (no pitch, no vias). Neglected: displacement current, so
that nothing is said near a coil's own resonance; eddy currents that the target drives in the tracks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.disk_cache import kept
from sits_mech.geometry.tracks import ring_squares, standing_rings, track_squares
from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.coils.loops import ring_inductance
from sits_mech.magnetics.modes import Modes, eddy_modes, skin_depth
from sits_mech.memory import check_seconds
from sits_mech.quantities import Array
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Coil

_MOST = 4000  # filaments: an eigenproblem of ten seconds
_PAIR, _MODE = 1.1e-6, 1.9e-10  # s that a pair of filaments takes, and the modes of n over n^3: 16 s of 3264


def track_conductivity(coil: Coil) -> float:
    """Return the conductivity of a coil's tracks, copper's unless the scene gives another [S/m]."""
    return coil.conductivity or metals()["copper"].conductivity


def track_resistance(coil: Coil) -> float:
    """Return the direct-current resistance of a coil's tracks [ohm]."""
    return track_squares(coil) / (track_conductivity(coil) * coil.track_thickness)


@dataclass(frozen=True)
class TrackSpectrum:
    """A coil's own series impedance over f frequencies, without target."""

    R: Array  # (f,) with skin and proximity effect [ohm]
    shift: Array  # (f,) what the uneven current takes from the inductance: L(f) - L(0) [H]
    error_R: Array  # (f,) estimated absolute error of R


def track_spectrum(coil: Coil, frequencies: Sequence[float]) -> TrackSpectrum:
    """Return a coil's own resistance and change of inductance at each frequency [Hz], in free space.

    ValueError if a frequency is not positive, or the highest one's skin depth asks for more filaments than fit.
    """
    hertz = np.asarray(frequencies, dtype=float)
    if hertz.size == 0 or not np.all((hertz > 0.0) & np.isfinite(hertz)):
        raise ValueError(f"frequency: must be positive numbers of hertz; got {list(frequencies)}")
    delta = skin_depth(float(hertz.max()), track_conductivity(coil))
    cells = [filaments_along(side, delta) for side in (coil.track_width, coil.track_thickness)]
    rings = standing_rings(coil)
    count = 4 * cells[0] * cells[1] * rings.radius.size
    if count > _MOST:
        words = f"{hertz.max():g} Hz with {rings.radius.size} turns asks for more than {_MOST} filaments of track"
        raise ValueError(f"frequency: {words}; lower the frequency")
    check_seconds((_PAIR + _MODE * count) * count**2, f"uneven current in a coil of {rings.radius.size} turns")
    coarse, fine = (_series(rings, (n * cells[0], n * cells[1]), hertz, track_conductivity(coil)) for n in (1, 2))
    step = (fine - coarse) / 3
    R, shift = fine + step
    more = 1.0 if coil.is_round else track_squares(coil) / ring_squares(rings.radius, rings.width).sum()
    return TrackSpectrum(more * R, shift, np.abs(more * step[0]))  # as much more as the coil's tracks have squares


def _series(rings: Sections, cells: tuple[int, int], hertz: Array, conductivity: float) -> Array:
    """Return R and L(f) - L(0) of all turns in series with one division, shape (2, f)."""
    asked = rings, cells, conductivity
    modes = kept(
        ("tracks", asked), lambda: _modes(*asked), lambda own: {"tau": own.tau, "coupling": own.coupling},
        lambda arrays: Modes(**arrays),
    )
    C, ones = modes.coupling, rings.signs  # the current in each turn
    rest = C.T @ np.linalg.solve(C @ C.T, ones)
    omega = 2.0 * np.pi * hertz
    Z = np.array([ones @ np.linalg.solve(modes.admittance(each) / each**2, ones) for each in omega])
    return np.array([Z.real, Z.imag / omega - rest**2 @ modes.tau])


def _modes(rings: Sections, cells: tuple[int, int], conductivity: float) -> Modes:
    """Return modes of the filaments, seen by turns."""
    parts = divided(rings, cells)
    R = ring_squares(parts.radius, parts.width) / (conductivity * parts.height)
    share = np.repeat(np.eye(rings.radius.size), cells[0] * cells[1], axis=1)
    return eddy_modes(ring_inductance(parts, points=(1, 1)), R, share)


def divided(rings: Sections, cells: tuple[int, int]) -> Sections:
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
