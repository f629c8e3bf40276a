"""Resistance of the coils' tracks at one frequency, solved directly, closed forms beside it, and the package's own.

What `coils.resistance` finds for many frequencies from its modes. Every turn is a ring, divided into filaments f of
height h_f from radius a_f to b_f that share the turn's voltage v_t:

    (R_f + j omega L_fg) i_g = v_t(f),    R_f = 2 pi / (sigma h_f ln(b_f / a_f)),    L_fg by `loops`,

and with P the map of filaments to turns, ``Y = P^T (R + j omega L)^-1 P`` links turn voltages to turn currents, so
that ``Z = Y^-1`` is turn by turn and a coil in series shows ``Z_coil = sum_tu Z_tu = R_ac + j omega L``.

Twice as many filaments along both sides and ``(4 fine - coarse) / 3`` give the answer, its step from `fine` the error.

Closed forms, with ``gamma = (1 + j) / delta``, per metre: a round wire of radius a has the internal impedance
``gamma / (2 pi a sigma) I0(gamma a) / I1(gamma a)``; a foil of thickness h with the field on one face only has
``R / R_dc = Re[gamma h coth(gamma h)]``.

Range: tracks of copper, non-magnetic; a turn closes on itself (no pitch, no vias). Neglected: displacement current, so
that nothing is said near a coil's own resonance; eddy currents that the target drives in the tracks.
Source: Dowell, Proc. IEE 113 (1966) 1387 (foil); any text on the internal impedance of round wires.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ive

from sits_mech.geometry.tracks import ring_squares
from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import ring_inductance
from sits_mech.magnetics.coils.resistance import filaments_along, filaments_of, track_resistance, track_response
from sits_mech.magnetics.modes import skin_depth
from sits_mech.quantities import Array, Complex
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Coil

_MOST = 6000  # filaments: half a gigabyte


@dataclass(frozen=True)
class CoilLosses:
    """A coil's own series impedance at a frequency, without target.

    Attributes
    ----------
    frequency : float
        [Hz].
    R, L : float
        Resistance [ohm] and inductance [H] with skin and proximity effect.
    error_R, error_L : float
        Estimated absolute errors [ohm, H].
    """

    frequency: float
    R: float
    L: float
    error_R: float
    error_L: float


@dataclass(frozen=True)
class TrackSpectrum:
    """A coil's own series impedance over f frequencies, without target."""

    R: Array  # (f,) with skin and proximity effect [ohm]
    shift: Array  # (f,) what the uneven current takes from the inductance: L(f) - L(0) [H]
    error_R: Array  # (f,) estimated absolute error of R
    error_shift: Array  # (f,) the same of `shift` [H]


def track_spectrum(coil: Coil, frequencies: Sequence[float]) -> TrackSpectrum:
    """Return what `track_response` says of a coil alone at frequencies [Hz], by filaments for the highest."""
    hertz = np.asarray(frequencies, dtype=float)
    each, omega = [track_response(coil, f, float(hertz.max())) for f in hertz.tolist()], 2.0 * np.pi * hertz
    alone, error = np.array([(one.alone, one.error) for one in each]).T
    return TrackSpectrum(track_resistance(coil) + alone.real, alone.imag / omega, error.real, error.imag / omega)


def coil_losses(coil: Coil, frequency: float) -> CoilLosses:
    """Return a coil's alternating-current resistance and inductance, as rings in free space.

    Raises
    ------
    ValueError
        If the frequency is not positive, or its skin depth asks for more filaments than fit.
    """
    if not (frequency > 0.0 and np.isfinite(frequency)):
        raise ValueError(f"frequency: must be a positive number of hertz; got {frequency}")
    delta = skin_depth(frequency, _copper())
    rings = coil_sections(coil)
    cells = (filaments_along(coil.track_width, delta), filaments_along(coil.track_thickness, delta))
    if 4 * cells[0] * cells[1] * rings.radius.size > _MOST:
        raise ValueError(
            f"frequency: {frequency:g} Hz with {rings.radius.size} turns asks for more than {_MOST} filaments; "
            "lower the frequency"
        )
    coarse, fine = (
        complex(turn_impedance(rings, frequency, _copper(), cells=(n * cells[0], n * cells[1])).sum()) for n in (1, 2)
    )
    step = (fine - coarse) / 3
    omega = 2.0 * np.pi * frequency
    value = fine + step
    return CoilLosses(frequency, value.real, value.imag / omega, abs(step.real), abs(step.imag) / omega)


def turn_impedance(rings: Sections, frequency: float, conductivity: float, *, cells: tuple[int, int]) -> Complex:
    """Return the turn-by-turn impedance of coaxial rings with uneven current [ohm].

    Parameters
    ----------
    rings : Sections
        n turns.
    frequency, conductivity : float
        [Hz, S/m].
    cells : tuple of int
        Filaments along each turn's width and height.

    Returns
    -------
    ndarray, complex, shape (n, n)
    """
    parts = filaments_of(rings, cells)
    turn = np.repeat(np.arange(rings.radius.size), cells[0] * cells[1])
    return filament_impedance(parts, turn, frequency, conductivity)


def filament_impedance(filaments: Sections, turn: NDArray[np.int_], frequency: float, conductivity: float) -> Complex:
    """Return the impedance of turns made of filaments of any arrangement [ohm], shape (n, n).

    Parameters
    ----------
    filaments : Sections
        m filaments.
    turn : ndarray of int, shape (m,)
        The turn that each belongs to, 0 to n - 1.
    frequency, conductivity : float
        [Hz, S/m].
    """
    R = ring_squares(filaments.radius, filaments.width) / (conductivity * filaments.height)
    system = np.diag(R) + 2j * np.pi * frequency * ring_inductance(filaments, points=(1, 1))
    P = np.zeros((R.size, int(turn.max()) + 1))
    P[np.arange(R.size), turn] = 1.0
    return np.asarray(np.linalg.inv(P.T @ np.linalg.solve(system, P)))


def round_wire_impedance(radius: float, frequency: float, conductivity: float) -> complex:
    """Return the internal impedance of a straight round wire [ohm/m]; Bessel functions, no overflow."""
    gamma = (1 + 1j) / skin_depth(frequency, conductivity)
    bessel = ive(np.array([0.0, 1.0]), np.full(2, gamma * radius))
    ratio = complex(bessel[0] / bessel[1])
    return gamma / (2 * math.pi * radius * conductivity) * ratio


def foil_resistance_ratio(thickness: float, frequency: float, conductivity: float) -> float:
    """Return R / R_dc of a wide foil whose field is on one face only."""
    y = (1 + 1j) / skin_depth(frequency, conductivity) * thickness
    return (y / cmath.tanh(y)).real


def _copper() -> float:
    """Conductivity of the tracks [S/m]."""
    return metals()["copper"].conductivity
