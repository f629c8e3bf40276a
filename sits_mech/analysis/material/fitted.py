"""Fit a law to a tensile test by least squares restricted to stable constants, and join it with rate and softening.

Incompressible, stretch ``lambda = 1 + engineering strain``, engineering stress P of silicone/homogeneous.py in the
uniaxial and, where there are data, the planar and the biaxial test. Unknown: the law's constants x. Minimised:

    sum over tests, over points:  w (P(x) - P_measured)^2,    w = the point's share of its test's strain range
                                                              over the number of specimens of its mode

so that neither sampling rate nor number of points or specimens plays a part. Constants are accepted only where they are
stable:

    P linear in x           over all uniaxial and planar states whose I1 is within the data's (the biaxial ones are
                            among them) Drucker's tangent stays positive and uniaxial P rises: linear inequalities
    a sum of terms m a(x)   m > 0, and x within limits at which such a term is stable

Which of these a law is, and its limits, its file says (laws/). A sum of terms has several minima: all choices out of a
list of x are solved for m >= 0, the best few refined.

Confidence: 95 % half-widths from the Jacobian. The residual of a law is systematic misfit that varies slowly, not
noise; so a run of residuals of one sign counts as two independent points, however densely it was sampled. (With noise
that stays for eight points at a time, 90 to 93 in 100 such intervals held the truth, 93 to 95 with white noise.) Where
each mode has several specimens, what they differ by is added, by Student's t of their number. A constant that a
condition holds, or that the data do not determine, has none. Of one pull history and volume change are neglected, and
strain taken from crosshead travel includes what the grips let through.

The constants of a material are those of slow load. A pull is quick: where a relaxation test is beside it, the stresses
of the law are multiplied by what that test shows of them after a long time, its ``factor``. The softening is then
fitted with the branches found, so that what relaxes in a cyclic test does not count as softened.

Without a pull of its own the law is that of the cyclic test's envelope. Where branches are known and the pull, or the
envelope, has a time, the law is fitted again, to stresses multiplied by what the model says of elastic over whole
stress there, until it settles: what relaxes during the pull does not bend the law. Confidence is of each fit alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.analysis.material.alike import LawWithConstants, as_good, central_law, largest_factor
from sits_mech.analysis.material.least_squares import Answer, fit_constants
from sits_mech.analysis.material.points import MeasuredPoints
from sits_mech.analysis.material.relaxing import Relaxation, fit_relaxation
from sits_mech.analysis.material.softening import CyclicFit, fit_softening, virgin_curve
from sits_mech.analysis.material.tensile import Record, Sizes, TensileTest, read_record, read_tensile
from sits_mech.analysis.material.uniaxial import uniaxial_stress
from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import engineering_stress, principal_stretches
from sits_mech.silicone.laws import LAWS, known_law
from sits_mech.silicone.material import Silicone, table_of
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
    mode_spread: float | None = None  # as in silicone/material.py; None: not looked for, or a law that ends before


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
        modes=tuple(dict.fromkeys(one.mode for one in tests)),
        notes=(*test.notes, *answer.notes),
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


def _points(tests: list[TensileTest]) -> MeasuredPoints:
    """Return the states of all tests in one row."""
    modes = [test.mode for test in tests]
    several = min(map(modes.count, modes)) > 1
    return MeasuredPoints(
        stretches=np.vstack([principal_stretches(test.mode, 1.0 + test.strain) for test in tests]),
        stress=np.concatenate([test.stress for test in tests]),
        weight=np.concatenate([
            _weights(test.strain) / np.sqrt(modes.count(test.mode)) for test in tests
        ]),
        specimen=np.repeat(np.arange(len(tests)) * several, [len(test.strain) for test in tests]),
    )


def _weights(strain: Array) -> Array:
    """Return square roots of each point's share of the strain range, independent of the sampling rate."""
    edges = np.concatenate([np.zeros(1), 0.5 * (strain[1:] + strain[:-1]), strain[-1:]])
    weights: Array = np.sqrt(np.diff(edges) / strain[-1])
    return weights


def _stable(law: str, answer: Answer, points: MeasuredPoints) -> bool:
    """Whether constants are stable over uniaxial and planar states with I1 within the data's."""
    silicone = Silicone("", law, answer.constants, 1.0)
    ends = points.ends()
    found = all(stability(silicone, ends[mode], (mode,)).stable for mode in ends)
    stretch = np.geomspace(*ends["uniaxial"], 401)
    rises = np.diff(engineering_stress(law, silicone.constants, stretch - 1.0)) > 0.0
    return found and bool(rises.all())


_DIGITS = 5  # of what is pasted
_CLEARLY = 0.8  # of a law's own distance from others, from where on another one is preferred
_ROUNDS = 12  # of law and rate
_SETTLED = 1e-3  # of the law's stress from one round to the next
_LOOK = np.array([0.1, 0.5, 1.0])  # shares of the largest strain, where that is looked at


@dataclass(frozen=True)
class Fitted:
    """Fits of the tests of one silicone; None for what had no test."""

    test: TensileTest | None  # tensile test, or envelope of a cyclic one
    fit: Fit | None  # constants as the pull shows them
    relaxation: Relaxation | None
    cyclic: CyclicFit | None

    @property
    def table(self) -> dict[str, Any]:
        """Known keys of a material table; none of the tests shows a bulk modulus."""
        silicone = _silicone(self.fit, self.relaxation, self.cyclic)
        table = {} if silicone is None else table_of(silicone)
        law = () if self.fit is None else ("law", *self.fit.constants)
        wanted = (*law, "fitted_range", "mode_spread", "prony", "mullins")
        return {key: _rounded(table[key]) for key in wanted if key in table}

    @property
    def record(self) -> dict[str, Any]:
        """All results for a program: keys of the fit, ``prony``, ``mullins``, what is known of these, ``material``."""
        found = {} if self.fit is None else asdict(self.fit)
        if self.relaxation is not None:
            entry = asdict(self.relaxation)
            found["prony"] = [{"weight": weight, "time": time} for weight, time in entry.pop("prony")]
            entry["confidence"] = [{"weight": weight, "time": time} for weight, time in entry["confidence"]]
            found["relaxation"] = entry
        if self.cyclic is not None:
            entry = asdict(self.cyclic)
            found["mullins"] = entry.pop("mullins")
            found["cyclic"] = entry
        return found | {"material": self.table}


def fit_tests(
    tensile: Path | None, relaxation: Path | None, cyclic: Path | None, *, law: str = "yeoh", max_strain: float = 1.0,
    terms: int = 2, given: Sizes | None = None,
) -> Fitted:
    """Fit the tests of one silicone, files for `read_tensile` and `read_record`, at least one; sizes as `given`.

    Without a tensile test the law is fitted to the envelope of the cyclic one. Raise ValueError for no or unsuitable
    tests.
    """
    if tensile is None and relaxation is None and cyclic is None:
        raise ValueError("fit: must be given a tensile test, --relaxation or --cyclic; got none of them")
    cycles = None if cyclic is None else read_record(cyclic, given, timed=False)
    hold = None if relaxation is None else read_record(relaxation, given)
    test = read_tensile(tensile, given) if tensile is not None else None if cycles is None else virgin_curve(cycles)

    def fitted(test: TensileTest | None) -> Fitted:
        """Fit law, rate and softening, in this order."""
        fit = None if test is None else fit_law(test, law, max_strain, terms=terms)
        relaxed = None if hold is None else fit_relaxation(hold, _silicone(fit, None, None))
        silicone = _silicone(fit, relaxed, None)
        softened = None if cycles is None or silicone is None else fit_softening(cycles, silicone)
        return Fitted(test, fit, relaxed, softened)

    found = fitted(test)
    pull = cycles if tensile is None or test is None else _pull(tensile, test, given or Sizes())
    relaxes = found.relaxation is not None and found.relaxation.prony
    return _compared(_settled(fitted, found, pull) if pull and pull.timed and relaxes else found, max_strain)


def _compared(found: Fitted, max_strain: float) -> Fitted:
    """Return the fits with how far the law is from others that fit as well, where a pad is strained."""
    fit, test = found.fit, found.test
    if fit is None or test is None:
        return found
    others = as_good(_points([_used(one, max_strain) for one in test.all]))
    spread = largest_factor(LawWithConstants(fit.law, fit.constants), others) - 1.0
    names = ", ".join(dict.fromkeys(each.name for each in others))
    if not np.isfinite(spread):
        return _noted(found, f"the law ends within the strains of pads; laws that fit well there: {names}")
    best, least = central_law(others)
    what = f"laws that fit as well ({names}) give loads of pads within {100.0 * spread:.2g} % of this one's"
    found = _noted(replace(found, fit=replace(fit, mode_spread=float(f"{spread:.2g}"))), what)
    near = f"{best.name} is preferred: within {100.0 * (least - 1.0):.2g} % of all of them"
    return found if least - 1.0 > _CLEARLY * spread else _noted(found, near)


def _pull(path: Path, test: TensileTest, given: Sizes) -> Record | None:
    """Return a tensile test as a record over time, up to its largest stress; None unless it is one test alone."""
    if test.others or test.mode != "uniaxial":
        return None
    try:
        record = read_record(path, replace(given, slack=test.slack), timed=False)
    except ValueError:
        return None  # it is a tensile test all the same, whose strain or time is of no use as a path
    last = int(np.argmax(record.stress)) + 1
    first = int(np.argmax(record.strain >= 0.0)) if test.slack else 0
    used = slice(first, last)
    return replace(record, time=record.time[used], strain=record.strain[used], stress=record.stress[used])


def _settled(fitted: Callable[[TensileTest], Fitted], found: Fitted, pull: Record) -> Fitted:
    """Return the fits with viscosity removed from the law's pull; the last ones, with a note, if they do not settle."""
    last = np.zeros(0)
    for _ in range(_ROUNDS):
        silicone = _silicone(found.fit, found.relaxation, found.cyclic)
        if silicone is None or found.fit is None:
            break
        now = engineering_stress(silicone.law, silicone.constants, _LOOK * found.fit.max_strain)
        if last.size and np.abs(now / last - 1.0).max() < _SETTLED:
            break
        whole = uniaxial_stress(silicone, pull.time, pull.strain)
        elastic = engineering_stress(silicone.law, silicone.constants, pull.strain)
        share = np.divide(elastic, whole, out=np.ones_like(whole), where=whole != 0.0)
        last, found = now, fitted(virgin_curve(replace(pull, stress=pull.stress * share)))
    else:
        return _noted(found, f"the law did not settle within {_SETTLED:g} between rate and pull")
    return _noted(found, "of slow load: what relaxes during the pull is taken out of its stress")


def _noted(found: Fitted, note: str) -> Fitted:
    """Add a note to a fit of the law."""
    return found if found.fit is None else replace(found, fit=replace(found.fit, notes=(*found.fit.notes, note)))


def _silicone(fit: Fit | None, relaxation: Relaxation | None, cyclic: CyclicFit | None) -> Silicone | None:
    """Return the silicone of slow load that the fits describe, bulk modulus unknown."""
    prony = () if relaxation is None else relaxation.prony
    if fit is None:
        return None if relaxation is None else Silicone("", "neo-hookean", {"shear_modulus": 1.0}, np.inf, prony=prony)
    factor = 1.0 if relaxation is None or not relaxation.factor else relaxation.factor
    constants = LAWS[fit.law].rescaled(fit.constants, lambda value: factor * value)
    softening = None if cyclic is None else cyclic.mullins
    return Silicone("", fit.law, constants, np.inf, fitted_range=(0.0, fit.max_strain), mode_spread=fit.mode_spread,
                    prony=prony, mullins=softening)


def _rounded(value: Any) -> Any:
    """Round a result for pasting."""
    if isinstance(value, Mapping):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
