"""Impedance that a readout sees at a coil's terminals: idle coils shorted or open, leads, parallel capacitance.

With the coils' own series resistance and the leads on the diagonal, ``Z = R + j omega L`` (n x n) links voltages and
currents, V = Z I. One coil is driven at a time. An open idle coil carries no current: the driven one shows Z_ii. A
shorted one has V_j = 0, and eliminating all of them leaves

    Z_i = Z_ii - Z_ij (Z_jj)^-1 Z_ji = 1 / (Z^-1)_ii,    j = the idle coils.

A capacitance across the terminals gives ``Z_i / (1 + j omega C Z_i)``, which is real, and the tank at resonance, at

    omega_0^2 = 1 / (L C) - (R / L)^2.

Neglected: currents of an open idle coil through its own capacitance; the sensor's distributed capacitance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sits_mech.quantities import Complex
from sits_mech.scene.sensor import Readout


def terminal_impedance(Z: ArrayLike, R_coil: ArrayLike, readout: Readout, omega: float) -> Complex:
    """Return the impedance of each coil at the end of its leads, before the capacitance, shape (..., n) [ohm].

    Z (..., n, n) is without the coils' own resistances R_coil (n,), direct or alternating; omega [rad/s]. ValueError if
    Z is not square or R_coil does not fit it.
    """
    Z, R_coil = np.asarray(Z, dtype=complex), np.asarray(R_coil, dtype=float)
    n = Z.shape[-1] if Z.ndim >= 2 else 0
    if n == 0 or Z.shape[-2] != n or R_coil.shape != (n,):
        raise ValueError(f"Z: must be (..., n, n) with R_coil (n,); got {Z.shape} and {R_coil.shape}")
    lead = readout.lead_resistance + 1j * omega * readout.lead_inductance
    whole = Z + np.diag(R_coil + lead)
    if readout.idle_coil == "open":
        return np.asarray(np.diagonal(whole, axis1=-2, axis2=-1))
    return np.asarray(1.0 / np.diagonal(np.linalg.inv(whole), axis1=-2, axis2=-1))


def with_capacitance(Z: ArrayLike, capacitance: float, omega: float) -> Complex:
    """Return impedances [ohm] with a capacitance [F] across their terminals."""
    Z = np.asarray(Z, dtype=complex)
    return np.asarray(Z / (1.0 + 1j * omega * capacitance * Z))


def tank_frequency(Z: ArrayLike, capacitance: float, omega: float) -> NDArray[np.float64]:
    """Return where coils of impedance Z [ohm] at `omega` resonate with a capacitance [F] across them [Hz].

    With the L and R of that `omega`; NaN for a coil that is damped too much to resonate.
    """
    Z = np.asarray(Z, dtype=complex)
    L = Z.imag / omega
    square = 1.0 / (L * capacitance) - (Z.real / L) ** 2
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)) / (2.0 * np.pi))
