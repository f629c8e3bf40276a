"""Guess what went wrong where readings fit no sensor of the kind: columns swapped, signs turned, units mixed up.

Each slip is undone in the readings. What no sensor could show as it was read, by what is known beforehand
(`predictive`), is refused before any fit; where a fit fails, the likeliest slips are fitted, and the one named whose
readings such a sensor would show, if it is far likelier than the readings as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, NamedTuple, TypeVar

import numpy as np
import xarray as xr
from scipy.stats import norm

from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.comparison import Comparison
from sits_mech.analysis.built.fit import ParameterFit
from sits_mech.analysis.built.predictive import Predictive, row_step
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.readings.bench import other_way
from sits_mech.analysis.readings.measured import Measured
from sits_mech.scene.sensor import SceneError, Sensor

Fitted = TypeVar("Fitted", Adaptation, Comparison)
STRANGE = 0.01
"""Probability of readings below which they are doubted."""
_CLEARLY = 16.0  # of chi^2 over its variance, by which idle coils the other way fit readings better: four deviations
_LIKELY = 0.05  # probability of readings that are mended
_GRAVITY = 9.80665  # [m/s^2]
_FACTORS = {
    _GRAVITY: f"a factor of {_GRAVITY:.3g}: kilograms?", 1.0 / _GRAVITY: f"a factor of 1/{_GRAVITY:.3g}?",
    1e-3 * _GRAVITY: f"a factor of {1e-3 * _GRAVITY:.3g}: grams?", 1e-3: "a factor of 1000: millinewtons?",
}
_UNITS = {
    factor: f"the inductances seem a {many} times too {size}" for factor, many, size in (
        (1e-3, "thousand", "large: nH given as uH?"), (1e3, "thousand", "small: mH given as uH?"),
        (1e-6, "million", "large: uH given as H?"), (1e6, "million", "small"))
}
_FAR = 6.0  # deviations of one number: further than a fit follows two unknowns to their ends at once (`setup._WIDE`)
_CLEAR = float(np.log(1e6))  # ln of B: one in a million right readings is refused at most
_AS_CLEAR = float(np.log(10.0))  # below the best one: causes that are named together
_WELL = 0.5  # p of `predictive` above which no slip is looked for
_POSSIBLE = 1e-3  # p of `predictive` of readings that a slip explains
_TRIED = 2  # slips that are fitted
_TWO_SIDED = float(norm.isf(0.025))
_NO_CAUSE = "a unit is wrong, or the readings are of another sensor"


def refuse_unlikely(prior: Prior, measured: Measured, load_noise: float | None = None) -> None:
    """Raise SceneError for readings that no such sensor shows, with the farthest number, its range and what is wrong.

    Before any fit (`predictive`): for a number beyond `_FAR` deviations, whatever else was read, and where a slip makes
    all of them `_CLEAR` times as likely. Loads that are not known are left out.
    """
    known, seen = Predictive(prior, load_noise), np.isfinite(measured.forces).all(axis=1)
    if not np.any(seen):
        return
    forces, L = measured.forces[seen], measured.L[seen]
    (low, high), found = known.ends(forces, _FAR), known.likeliest(forces, L)
    off, where = np.abs(L - 0.5 * (low + high)) / (high - low), "between"
    beyond = bool(np.any(off > 0.5))
    if not beyond and found.p > _WELL:
        return
    slips = _likely(known, measured)
    best = max((one.evidence for one in slips), default=-np.inf)
    if not beyond and best - found.evidence < _CLEAR:
        return
    causes = [one.words for one in slips if best - one.evidence < _AS_CLEAR]
    if not beyond:
        off, where = np.abs(found.off), "by the numbers before it between"
        low, high = (found.mean + way * _TWO_SIDED * found.deviation for way in (-1.0, 1.0))
    row, k = np.unravel_index(int(np.argmax(off)), off.shape)
    step = 1 if beyond else row_step(len(L))
    span = f"{1e6 * low[row, k]:.6g} and {1e6 * high[row, k]:.6g} uH"
    place = f"row {int(np.flatnonzero(seen)[step * row]) + 1}, {prior.sensor.coil_names[k]}"
    came = f"{1e6 * L[step * row, k]:.6g} uH: {' or '.join(causes) or _NO_CAUSE}"
    raise SceneError(f"{measured.source}: {place}: must be what such a sensor shows, {where} {span}; got {came}")


class _Slip(NamedTuple):
    """A slip in words, the readings with it undone, and the density of what was read if it was made (`predictive`)."""

    words: str
    mended: Measured
    evidence: float


def _likely(known: Predictive, measured: Measured) -> list[_Slip]:
    """Return slips without which readings are likely beforehand, the likeliest first."""
    prior, found = known.prior, []
    tables = [(text, other, prior.table) for text, other in _mended(prior, measured)]
    if _two_ways(prior.sensor, prior.data):
        way, text = other_way(prior.sensor.readout.idle_coil)
        tables.append((text, measured, prior.read_by(way).table))
    for text, other, table in tables:
        seen = np.isfinite(other.forces).all(axis=1)
        one = known.likeliest(other.forces[seen], other.L[seen], table)
        if one.p > _POSSIBLE:
            wider = one.off.size * float(np.log(other.L[0, 0] / measured.L[0, 0])) * (text in _UNITS.values())
            found.append(_Slip(text, other, one.evidence + wider))
    return sorted(found, key=lambda one: -round(one.evidence, 6))  # those of mirror images are equal


def mistake(prior: Prior, measured: Measured, found: Adaptation | None, **noise: Any) -> str:
    """Return what probably went wrong with readings, in words, "" where nothing known explains them.

    `found` is what they tell as they are, None where that is nothing; `noise` as of `adapt`. Fitted are the `_TRIED`
    likeliest beforehand; of a sensor with coils in mirror image a sign and coils swapped are the same.
    """
    least, causes = max(STRANGE if found is None else found.p_value, _LIKELY), []
    slips = [one for one in _likely(Predictive(prior, noise.get("load_noise")), measured) if one.mended is not measured]
    for text, other, _ in slips[:_TRIED]:
        try:
            p = adapt(prior, other, **noise).p_value
        except (SceneError, ValueError):
            continue
        if p > least:
            causes.append(text)
    return " or ".join(causes)


def as_read(
    sensor: Sensor, data: xr.Dataset | None, source: object, fitted: Callable[[str], Fitted],
    otherwise: Callable[[], str] = str,
) -> Fitted:
    """Return the fit of readings with idle coils as `sensor` has them; `fitted` makes it of what idle coils are.

    `data` is the table that is fitted, None without one; the fit names what idle coils may be as well. Raises
    SceneError where the readings of `source` are rather of idle coils the other way, and as `fitted`, then with what
    else may be wrong, in words.
    """
    own = sensor.readout.idle_coil
    try:
        found = fitted(own)
    except SceneError as error:
        again = _other_fit(sensor, data, fitted)
        reason = otherwise() if again is None or again.p_value < STRANGE else other_way(own)[1]
        if not reason:
            raise
        raise SceneError(f"{error}; {reason}") from None
    again = _other_fit(sensor, data, fitted)
    if again is None:
        return found
    if found.fit.chi_square - again.chi_square > _CLEARLY * again.variance:
        raise SceneError(f"{source}: {other_way(own)[1]}")
    alike = again.chi_square - found.fit.chi_square <= _CLEARLY * found.fit.variance
    return replace(found, other_idle=other_way(own)[0]) if alike else found


def _other_fit(
    sensor: Sensor, data: xr.Dataset | None, fitted: Callable[[str], Fitted]
) -> ParameterFit | None:
    """Return the fit with idle coils the other way, None where there is none or both ways are one."""
    if not _two_ways(sensor, data):
        return None
    try:
        return fitted(other_way(sensor.readout.idle_coil)[0]).fit
    except ValueError:
        return None


def _two_ways(sensor: Sensor, data: xr.Dataset | None) -> bool:
    """Return whether it matters to readings by a table what idle coils are."""
    return len(sensor.coils) > 1 and (data is None or data.attrs["unit_L"] == "H")


def _mended(prior: Prior, measured: Measured) -> Iterator[tuple[str, Measured]]:
    """Give the slips in words, and the readings with each undone."""
    yield from _swapped("L", prior.sensor.coil_names, measured)
    for k, name in enumerate(prior.forces):
        sign = np.where(np.arange(len(prior.forces)) == k, -1.0, 1.0)
        yield f"{name} seems to have the other sign", replace(measured, forces=sign * measured.forces)
    yield from _swapped("forces", prior.forces, measured)
    for factor, text in _FACTORS.items():
        yield f"the forces seem off by {text}", replace(measured, forces=factor * measured.forces)
    for factor, text in _UNITS.items():
        yield text, replace(measured, L=factor * measured.L)


def _swapped(key: str, names: Sequence[str], measured: Measured) -> Iterator[tuple[str, Measured]]:
    """Give readings with each two columns the other way round."""
    for a, b in combinations(range(len(names)), 2):
        columns = getattr(measured, key).copy()
        columns[:, [a, b]] = columns[:, [b, a]]
        yield f"{names[a]} and {names[b]} seem swapped", replace(measured, **{key: columns})
