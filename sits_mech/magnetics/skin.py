"""How deep does an alternating field go into metal? The skin depth; and two closed forms that have it alone.

With ``exp(+j omega t)`` and ``gamma = (1 + j) / delta``, per metre: a round wire of radius a has the internal impedance
``gamma / (2 pi a sigma) I0(gamma a) / I1(gamma a)``; a foil of thickness h with the field on one face only has
``R / R_dc = Re[gamma h coth(gamma h)]``.

Source: Dowell, Proc. IEE 113 (1966) 1387 (foil); any text on the internal impedance of round wires.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from scipy.constants import mu_0
from scipy.special import ive


def skin_depth(frequency: float, conductivity: float, relative_permeability: float = 1.0) -> float:
    """Return delta = 1 / sqrt(pi f mu sigma) [m]."""
    return float(1.0 / np.sqrt(np.pi * frequency * mu_0 * relative_permeability * conductivity))


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
