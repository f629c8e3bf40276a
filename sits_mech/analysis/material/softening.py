"""Fit Ogden's and Roxburgh's constants r, m and beta to a cyclic test, on the primary curve of a law.

The engineering stress of a specimen that is strained, let go and strained further, is taken as

    c P(t; r, m, beta),    eta = 1 - erf((W_max - W)/(m + beta W_max))/r

with P of uniaxial.py, the law's energy W and c the stress of this specimen over that of the law. Minimised over c
(linear) and 1/r, m, beta: the squared residual over all points, each weighed by its share of the way in strain, so that
neither sampling rate nor holds play a part. Where the silicone has a Prony series and the record a time, P has its
viscosity.

m and beta differ only in how they go with W_max: from one peak m and beta cannot be separated, and m = 0 is taken. From
several, a constant whose 95 % interval reaches zero is none, and the others are fitted without it. A softening whose
depth 1/r is within its interval is none. Confidence as in fitted.py.

The primary curve may be that of the record itself: `virgin_curve` are its points beyond all strains before, a pull.

Source: R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455 (1999) 2861. Neglected: permanent set, and what differs between
unloading and loading again beyond the viscosity.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from sits_mech.analysis.material.least_squares import half_widths
from sits_mech.analysis.material.tensile import Record, TensileTest
from sits_mech.analysis.material.uniaxial import uniaxial_stress
from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import energy_density, principal_stretches
from sits_mech.silicone.material import Silicone, Softening

_BELOW = 0.9  # of the largest energy: a record that goes lower has left a peak
_NEW = 1.1  # of a peak's energy: the next peak is another one
_NAMES = ("r", "m", "beta")
_STARTS = ((0.3, 0.0, 0.3), (0.7, 0.1, 0.1), (0.5, 0.3, 1.0), (0.3, 0.02, 0.02))  # 1/r, m over the largest W, beta
_MOST = 100.0  # of m over the largest energy, and of beta
_STEP = 1e-6  # of differences
_ROUNDING = 1e-9  # of the stress


@dataclass(frozen=True)
class CyclicFit:
    """A softening fitted to a cyclic test.

    `confidence`: 95 % half-widths of r, m, beta; None for one that is not identified.
    """

    mullins: Softening | None  # m of the law's energy [Pa]; None: no softening seen
    confidence: dict[str, float | None]
    factor: float  # stress of the specimen over that of the law
    peaks: int  # number of different peak strains
    max_strain: float  # largest absolute engineering strain
    rms: float  # of the engineering stress [Pa]
    source: str  # file of the data
    notes: tuple[str, ...] = ()  # what is not identified, and its substitute


@dataclass(frozen=True)
class _Cycles:
    """A record with the law it is compared with."""

    record: Record
    silicone: Silicone
    weight: Array  # square root of each point's weight
    largest: float  # energy [Pa]

    def softening(self, x: Array) -> Softening:
        """Return the constants from 1/r, m over the largest energy, and beta."""
        return Softening(1.0 / max(float(x[0]), 1e-12), float(x[1]) * self.largest, float(x[2]))

    def stress(self, x: Array) -> Array:
        """Return the law's stress with these constants [Pa]."""
        soft = replace(self.silicone, mullins=self.softening(x))
        return uniaxial_stress(soft, self.record.time, self.record.strain)

    def solved(self, x: Array) -> tuple[float, Array, Array]:
        """Return c, the law's stress with it, and the residual [Pa]."""
        stress = self.stress(x)
        c = float(np.sum(self.weight**2 * stress * self.record.stress) / np.sum((self.weight * stress) ** 2))
        return c, c * stress, c * stress - self.record.stress


def virgin_curve(record: Record) -> TensileTest:
    """Return the points of a cyclic test beyond all strains before, as a pull.

    Raise ValueError for fewer than 5, as in compression.
    """
    beyond = record.strain > np.maximum.accumulate(np.r_[0.0, record.strain[:-1]])
    if np.count_nonzero(beyond) < 5:
        raise ValueError(
            f"{record.source}: must have 5 points of tension beyond all strains before, or a tensile test beside; got "
            f"{np.count_nonzero(beyond)}"
        )
    return TensileTest(record.strain[beyond], record.stress[beyond], record.source)


def fit_softening(record: Record, silicone: Silicone) -> CyclicFit:
    """Fit the constants of the softening to a cyclic test with rising peaks, timed if viscosity counts.

    `silicone`: law of the primary curve, with its ``prony`` if known. Raise ValueError if the record never goes back or
    its stress has not the sign of its strain.
    """
    cycles, peaks = _cycles(record, silicone)
    free = np.array([True, peaks > 1, True])
    notes = [] if peaks > 1 else ["m is not identified: one peak does not tell it from beta; 0 is taken"]
    while True:
        x = _refined(cycles, free)
        c, widths, residual = _widths(cycles, x, free)
        share = np.array([np.inf if width is None else width for width in widths]) / np.maximum(x, 1e-12)
        rms = float(np.sqrt(np.average(residual**2, weights=cycles.weight**2)))
        share = np.where(rms > _ROUNDING * np.abs(record.stress).max(), share, 0.0)
        if not (free[1] and free[2] and share[1:].max() >= 1.0):
            break
        gone = 1 + int(np.argmax(share[1:]))
        free[gone] = False
        notes.append(f"{_NAMES[gone]} is not identified: the data are described as well without; 0 is taken")
    sizes = (1.0 / float(x[0]) ** 2 if x[0] else 1.0, cycles.largest, 1.0)
    confidence = {
        name: None if width is None else width * size for name, width, size in zip(_NAMES, widths, sizes, strict=True)
    }
    soft: Softening | None = cycles.softening(x)
    if not share[0] < 1.0:
        soft, notes = None, [f"no softening beyond what the data leave: a depth of {x[0]:.2g}"]
        confidence = dict.fromkeys(_NAMES)
    most = float(np.abs(record.strain).max())
    return CyclicFit(soft, confidence, c, peaks, most, rms, Path(record.source).name, tuple(notes))


def _cycles(record: Record, silicone: Silicone) -> tuple[_Cycles, int]:
    """Return a record with weights and law, and its number of peaks; refuse one that is no cyclic test."""
    energy = energy_density(silicone.law, silicone.constants, principal_stretches("uniaxial", 1.0 + record.strain))
    so_far, peaks, last = np.maximum.accumulate(energy), 0, 0.0
    for now, most in zip(energy.tolist(), so_far.tolist(), strict=True):
        if now < _BELOW * most and most > _NEW * last:
            peaks, last = peaks + 1, most
    if not peaks:
        raise ValueError(f"{record.source}: must be let go after a peak; its strain rises to {record.strain[-1]:g}")
    steps = np.abs(np.diff(record.strain))
    weight = np.sqrt(np.r_[steps, 0.0] + np.r_[0.0, steps])
    if not np.sum(weight**2 * record.stress * record.strain) > 0.0:
        raise ValueError(f"{record.source}: stress must have the sign of the strain; on average it has not")
    plain = replace(silicone, mullins=None, prony=silicone.prony if record.timed else ())
    return _Cycles(record, plain, weight, float(so_far[-1])), peaks


def _refined(cycles: _Cycles, free: Array) -> Array:
    """Return 1/r, m over the largest energy and beta of least residual, zero where not free."""
    scale, upper = np.abs(cycles.record.stress).max(), np.array([0.999, _MOST, _MOST])[free]

    def whole(part: Array) -> Array:
        """Return all three constants."""
        found = np.zeros(3)
        found[free] = part
        return found

    def left(part: Array) -> Array:
        """Return the weighted residual."""
        return np.asarray(cycles.solved(whole(part))[2] * cycles.weight / scale)

    best = None
    for start in _STARTS:
        first = np.maximum(np.array(start)[free], 1e-2)
        found = least_squares(
            left, first, bounds=(np.zeros(len(first)), upper), x_scale=np.maximum(first, 0.1),
            xtol=1e-11, ftol=1e-13, gtol=1e-13, max_nfev=60,
        )
        best = found if best is None or found.cost < best.cost else best
    return whole(best.x) if best is not None else np.zeros(3)


def _widths(cycles: _Cycles, x: Array, free: Array) -> tuple[float, list[float | None], Array]:
    """Return c, half-widths of 1/r, m over the largest energy and beta, and the residual [Pa]."""
    c, stress, residual = cycles.solved(x)
    slopes = [stress / c]
    for k in np.flatnonzero(free):
        step = _STEP * max(float(x[k]), 1e-2)
        slopes.append(c * (cycles.stress(x + step * np.eye(3)[k]) - stress / c) / step)
    select = np.eye(3)[:, free]
    widths = half_widths(np.stack(slopes, axis=1), np.column_stack([np.zeros(3), select]), residual, cycles.weight)
    return c, widths, residual
