"""A coil's own losses at many frequencies from one division of its tracks.

The filaments of `losses` at the highest frequency serve every lower one. Their eigenproblem ``L v = tau R v`` gives the
turn-by-turn admittance (P: filaments to turns)

    Y(omega) = C diag(1 / (1 + j omega tau)) C^T,    C = P^T v,

a coil's series impedance is the sum of the entries of Y^-1, and its inductance at rest, current by resistance alone,

    L(0) = u^T C diag(tau) C^T u,    u = (C C^T)^-1 1.

Error, range and what is neglected: as for `losses`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.windings import turn_radii
from sits_mech.magnetics.coils.loops import Sections, coil_sections, ring_inductance
from sits_mech.magnetics.coils.losses import divided
from sits_mech.magnetics.modes import Modes, eddy_modes
from sits_mech.magnetics.skin import skin_depth
from sits_mech.quantities import Array
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Coil

_MOST = 4000  # filaments: an eigenproblem of ten seconds


@dataclass(frozen=True)
class TrackSpectrum:
    """A coil's own series impedance over frequency, without target.

    Attributes
    ----------
    R : ndarray, shape (f,)
        Resistance with skin and proximity effect [ohm].
    shift : ndarray, shape (f,)
        What the uneven current takes from the inductance: L(f) - L(0) [H].
    error_R, error_shift : ndarray, shape (f,)
        Estimated absolute errors.
    """

    R: Array
    shift: Array
    error_R: Array
    error_shift: Array


def track_spectrum(coil: Coil, frequencies: Sequence[float]) -> TrackSpectrum:
    """Return a coil's own resistance and change of inductance at each frequency [Hz], as rings in free space.

    Raises
    ------
    ValueError
        If a frequency is not positive, or the highest one's skin depth asks for more filaments than fit.
    """
    hertz = np.asarray(frequencies, dtype=float)
    if hertz.size == 0 or not np.all((hertz > 0.0) & np.isfinite(hertz)):
        raise ValueError(f"frequency: must be positive numbers of hertz; got {list(frequencies)}")
    delta = skin_depth(float(hertz.max()), metals()["copper"].conductivity)
    sides = (coil.track_width, coil.track_thickness)
    cells = [max(2, math.ceil(math.sqrt(2.5 * side / (0.7 * delta)))) for side in sides]  # as in `losses`
    turns = coil.layers * turn_radii(coil).size
    if 4 * cells[0] * cells[1] * turns > _MOST:
        raise ValueError(
            f"frequency: {hertz.max():g} Hz with {turns} turns asks for more than {_MOST} filaments of track; "
            "lower the frequency"
        )
    coarse, fine = (_series(coil_sections(coil), (n * cells[0], n * cells[1]), hertz) for n in (1, 2))
    step = (fine - coarse) / 3
    value = fine + step
    return TrackSpectrum(value[0], value[1], np.abs(step[0]), np.abs(step[1]))


def _series(rings: Sections, cells: tuple[int, int], hertz: Array) -> Array:
    """R and L(f) - L(0) of all turns in series with one division, shape (2, f)."""
    modes = _modes(rings, cells)
    C, ones = modes.coupling, np.ones(rings.radius.size)
    rest = C.T @ np.linalg.solve(C @ C.T, ones)
    L_rest = float(rest**2 @ modes.tau)
    found = np.empty((2, hertz.size))
    for k, omega in enumerate(2.0 * np.pi * hertz):
        Z = complex(ones @ np.linalg.solve(modes.admittance(omega) / omega**2, ones))
        found[:, k] = Z.real, Z.imag / omega - L_rest
    return found


def _modes(rings: Sections, cells: tuple[int, int]) -> Modes:
    """Modes of the filaments, seen by turns."""
    parts = divided(rings, cells)
    R = 2.0 * np.pi * parts.radius / (metals()["copper"].conductivity * parts.width * parts.height)
    share = np.repeat(np.eye(rings.radius.size), cells[0] * cells[1], axis=1)
    return eddy_modes(ring_inductance(parts, points=(1, 1)), R, share)
