"""Fit the constants of a law to a tensile test: least squares restricted to stable constants.

Incompressible, stretch ``lambda = 1 + engineering strain``, engineering stress P of homogeneous.py in the uniaxial and,
where there are data, the planar and the biaxial test. Unknown: the law's constants x. Minimised:

    sum over tests, over points:  w (P(x) - P_measured)^2,    w = the point's share of its test's strain range

so that neither sampling rate nor number of points plays a part. Constants are accepted only where they are stable:

    P linear in x           over all uniaxial and planar states whose I1 is within the data's (the biaxial ones are
                            among them) Drucker's tangent stays positive and uniaxial P rises: linear inequalities
    a sum of terms m a(x)   m > 0, and x within limits at which such a term is stable

Which of these a law is, and its limits, its file says (laws/). A sum of terms has several minima: all choices out of a
list of x are solved for m >= 0, the best few refined.

Confidence: 95 % half-widths from the Jacobian. The residual of a law is systematic misfit that varies slowly, not
noise; so a run of residuals of one sign counts as two independent points, however densely it was sampled. (With noise
that stays for eight points at a time, 90 to 93 in 100 such intervals held the truth, 93 to 95 with white noise.) A
constant that a condition holds, or that the data do not determine, has none.

The data are one pull to failure: rate, history, softening and volume change are neglected, and strain taken from
crosshead travel includes what the grips let through.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sits_mech.analysis.material.least_squares import Answer, Points, fit_constants
from sits_mech.analysis.material.tensile import TensileTest
from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import engineering_stress, principal_stretches
from sits_mech.silicone.laws import known_law
from sits_mech.silicone.material import Silicone
from sits_mech.silicone.stability import stability


@dataclass(frozen=True)
class Fit:
    """Constants of a law fitted to a tensile test.

    `confidence`: 95 % half-widths; None for a constant held by a condition or not determined by the data.
    """

    law: str
    constants: dict[str, float | tuple[float, ...]]
    confidence: dict[str, float | None | tuple[float | None, ...]]
    max_strain: float  # largest engineering strain used
    rms: float  # of the engineering stress [Pa]
    stable: bool  # Drucker stable in tension and compression, uniaxial stress rises
    source: str  # file of the data
    modes: tuple[str, ...] = ("uniaxial",)  # tests used
    notes: tuple[str, ...] = ()


def fit_law(test: TensileTest, law: str, max_strain: float = 1.0, *, terms: int = 2) -> Fit:
    """Fit a law to the part of a tensile test, other modes included, up to `max_strain`.

    `terms`: 1 to 4, fewer come back if the data need no more. `stable` is the check of the answer. Raise ValueError for
    an unknown law, wrong terms, fewer than 5 points of a test, or a stress that is not positive at its end and on
    average.
    """
    known_law(law)
    if terms not in (1, 2, 3, 4):
        raise ValueError(f"terms: must be 1, 2, 3 or 4; got {terms!r}")
    tests = [_used(one, max_strain) for one in (test, *test.others)]
    points = _points(tests)
    answer = fit_constants(known_law(law), points, terms)
    return Fit(
        law=law,
        constants=answer.constants,
        confidence=answer.confidence,
        max_strain=max(float(one.strain[-1]) for one in tests),
        rms=answer.rms,
        stable=_stable(law, answer, points),
        source=Path(test.source).name,
        modes=tuple(one.mode for one in tests),
        notes=answer.notes,
    )


def _used(test: TensileTest, max_strain: float) -> TensileTest:
    """Return the part of a test between zero and the largest strain."""
    used = (test.strain > 0.0) & (test.strain <= max_strain)
    if np.count_nonzero(used) < 5:
        raise ValueError(
            f"max_strain: must leave at least 5 points of {test.source} ({test.mode}), which reaches "
            f"{test.strain[-1]:.3g}; got {max_strain:g} with {np.count_nonzero(used)} points"
        )
    strain, stress = test.strain[used], test.stress[used]
    if not (stress[-1] > 0.0 and np.trapezoid(stress * strain, strain) > 0.0):
        raise ValueError(f"{test.source}: must be a pull with positive stress; got {stress[-1]:g} Pa at its end")
    return TensileTest(strain, stress, test.source, test.mode)


def _points(tests: list[TensileTest]) -> Points:
    """Return the states of all tests in one row."""
    return Points(
        stretches=np.vstack([principal_stretches(test.mode, 1.0 + test.strain) for test in tests]),
        stress=np.concatenate([test.stress for test in tests]),
        weight=np.concatenate([_weights(test.strain) for test in tests]),
    )


def _weights(strain: Array) -> Array:
    """Return square roots of each point's share of the strain range, independent of the sampling rate."""
    edges = np.concatenate([np.zeros(1), 0.5 * (strain[1:] + strain[:-1]), strain[-1:]])
    weights: Array = np.sqrt(np.diff(edges) / strain[-1])
    return weights


def _stable(law: str, answer: Answer, points: Points) -> bool:
    """Whether constants are stable over uniaxial and planar states with I1 within the data's."""
    silicone = Silicone("", law, answer.constants, 1.0)
    ends = points.ends()
    found = all(stability(silicone, ends[mode], (mode,)).stable for mode in ends)
    stretch = np.geomspace(*ends["uniaxial"], 401)
    rises = np.diff(engineering_stress(law, silicone.constants, stretch - 1.0)) > 0.0
    return found and bool(rises.all())
