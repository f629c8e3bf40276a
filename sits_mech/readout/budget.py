"""One error of a force that is read: what is not known of map, table, silicone and reading, through the inverse.

With F the force of a reading L and A = dF/dL the inverse there, the standard deviations of F are

    map            e A / 2               e the largest error of a load that is left out, of each coil
    table          A m / 2, A r / 2      m the parts of the errors of L that all loads share, with signs; r a coil's own
    silicone       |F| s                 s the deviation of its modulus's logarithm: F is proportional to the modulus;
                                         by its sources, and by the laws that fit its tests as well
    noise          A sigma               of each coil
    temperature    e / 2                 e what a correction for it leaves

An estimated error is two deviations. The parts are independent, and so are the coils in map, own parts and noise: their
squares add up. 90 % of the forces of a normal distribution lie within 1.645 deviations. What shared parts move alike in
several coils, such as the layer's stiffness, A takes together: signs count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import SURE, Array
from sits_mech.readout.calibration import Calibration

_TWO = 2.0  # deviations that an estimated error stands for


@dataclass(frozen=True)
class Budget:
    """Standard deviations of forces by their causes, each of shape (..., d) [N, N m]."""

    parts: dict[str, Array]

    @property
    def total(self) -> Array:
        """Half of the width that holds 90 % of the true forces, shape (..., d) [N, N m]."""
        return SURE * np.sqrt(sum(part**2 for part in self.parts.values()))


def budget(cal: Calibration, forces: ArrayLike, *, temperature: ArrayLike | None = None) -> Budget:
    """Return what is not known of forces (..., d) that a calibration reads [N, N m].

    `temperature` (..., d) is what a correction for it leaves in each force. Parts that are not known are left out.
    """
    at = np.asarray(forces, dtype=float)
    F = at.reshape(-1, at.shape[-1])
    A = cal.answers(F)
    parts = {"map": _joined(A, cal.map.error / _TWO)}
    if cal.table_errors is not None:
        shared, own = cal.table_errors.at(F)
        common = np.einsum("mdn,kmn->kmd", A, shared / _TWO)
        parts["table"] = np.sqrt(np.sum(common**2, axis=0) + _joined(A, own / _TWO) ** 2)
        if cal.table_errors.modulus:
            parts["silicone"] = np.abs(F) * cal.table_errors.modulus
    if cal.noise is not None:
        parts["noise"] = _joined(A, cal.noise)
    if temperature is not None:
        parts["temperature"] = np.reshape(temperature, F.shape) / _TWO
    return Budget({name: part.reshape(at.shape) for name, part in parts.items()})


def _joined(A: Array, deviations: Array) -> Array:
    """Return deviations of forces (m, d) by independent ones of the coils, (n,) or (m, n)."""
    each = np.broadcast_to(deviations, (len(A), A.shape[-1]))
    return np.asarray(np.sqrt(np.einsum("mdn,mn->md", A**2, each**2)))
