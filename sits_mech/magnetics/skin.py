"""Depth to which an alternating field goes into metal."""

from __future__ import annotations

import numpy as np
from scipy.constants import mu_0


def skin_depth(frequency: float, conductivity: float, relative_permeability: float = 1.0) -> float:
    """Return delta = 1 / sqrt(pi f mu sigma) [m]."""
    return float(1.0 / np.sqrt(np.pi * frequency * mu_0 * relative_permeability * conductivity))
