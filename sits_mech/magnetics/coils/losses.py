"""Resistance of the coils' tracks: direct current, and alternating current with skin and proximity effect.

Every turn is a ring, divided into filaments f of section w_f h_f that share the turn's voltage v_t:

    (R_f + j omega L_fg) i_g = v_t(f),    R_f = 2 pi r_f / (sigma w_f h_f),    L_fg by `loops`,

and with P the map of filaments to turns, ``Y = P^T (R + j omega L)^-1 P`` links turn voltages to turn currents, so
that ``Z = Y^-1`` is turn by turn and a coil in series shows ``Z_coil = sum_tu Z_tu = R_ac + j omega L``.

Filaments are graded to the surfaces; twice as many along both sides and ``(4 fine - coarse) / 3`` give the answer, its
step from `fine` the error.

Closed forms beside it: `skin`.

Range: tracks of copper, non-magnetic; a turn closes on itself (no pitch, no vias). Neglected: displacement current, so
that nothing is said near a coil's own resonance; eddy currents that the target drives in the tracks.
Source: Dowell, Proc. IEE 113 (1966) 1387 (foil); any text on the internal impedance of round wires.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sits_mech.magnetics.coils.loops import Sections, coil_sections, ring_inductance
from sits_mech.magnetics.skin import skin_depth
from sits_mech.quantities import Complex
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
    cells = (_cells(coil.track_width, delta), _cells(coil.track_thickness, delta))
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
    parts = divided(rings, cells)
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
    R = 2.0 * np.pi * filaments.radius / (conductivity * filaments.width * filaments.height)
    system = np.diag(R) + 2j * np.pi * frequency * ring_inductance(filaments, points=(1, 1))
    P = np.zeros((R.size, int(turn.max()) + 1))
    P[np.arange(R.size), turn] = 1.0
    return np.asarray(np.linalg.inv(P.T @ np.linalg.solve(system, P)))


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


def _copper() -> float:
    """Conductivity of the tracks [S/m]."""
    return metals()["copper"].conductivity


def _cells(side: float, delta: float) -> int:
    """Cells along a side, so that the outermost of the coarse division is about 0.7 skin depths."""
    return max(2, math.ceil(math.sqrt(2.5 * side / (0.7 * delta))))
