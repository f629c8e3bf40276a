"""Guess what went wrong where readings fit no sensor of the kind: columns swapped, signs turned, units mixed up.

Each slip is made undone in the readings, and the unknowns fitted anew; named is the one whose readings such a sensor
would show, if it is far likelier than the readings as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from sits_mech.analysis.bench import other_way
from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.comparison import Comparison
from sits_mech.analysis.built.fit import ParameterFit
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.measured import Measured
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


def mistake(prior: Prior, measured: Measured, found: Adaptation | None, **noise: Any) -> str:
    """Return what probably went wrong with readings, in words, "" where nothing known explains them.

    `found` is what they tell as they are, None where that is nothing; `noise` as of `adapt`.
    """
    best, words = max(STRANGE if found is None else found.p_value, _LIKELY), ""
    for text, other in _mended(prior, measured):
        try:
            p = adapt(prior, other, **noise).p_value
        except (SceneError, ValueError):
            continue
        if p > best:
            best, words = p, text
    return words


def as_read(
    sensor: Sensor, data: xr.Dataset | None, source: object, fitted: Callable[[str], Fitted],
    otherwise: Callable[[], str] = str,
) -> Fitted:
    """Return the fit of readings with idle coils as `sensor` has them; `fitted` makes it of what idle coils are.

    `data` is the table that is fitted, None without one. Raises SceneError where the readings of `source` are rather of
    idle coils the other way, and as `fitted`, then with what else may be wrong, in words.
    """
    own = sensor.readout.idle_coil
    try:
        found = fitted(own)
    except SceneError as error:
        again = _other_fit(sensor, data, fitted)
        said = otherwise() if again is None or again.p_value < STRANGE else other_way(own)[1]
        if not said:
            raise
        raise SceneError(f"{error}; {said}") from None
    again = _other_fit(sensor, data, fitted)
    if again is not None and found.fit.chi_square - again.chi_square > _CLEARLY * again.variance:
        raise SceneError(f"{source}: {other_way(own)[1]}")
    return found


def _other_fit(
    sensor: Sensor, data: xr.Dataset | None, fitted: Callable[[str], Fitted]
) -> ParameterFit | None:
    """Return the fit with idle coils the other way, None where there is none or both ways are one."""
    if len(sensor.coils) < 2 or (data is not None and data.attrs["unit_L"] != "H"):
        return None
    try:
        return fitted(other_way(sensor.readout.idle_coil)[0]).fit
    except ValueError:
        return None


def _mended(prior: Prior, measured: Measured) -> Iterator[tuple[str, Measured]]:
    """Give the slips in words, and the readings with each undone."""
    yield from _swapped("L", prior.sensor.coil_names, measured)
    for k, name in enumerate(prior.forces):
        sign = np.where(np.arange(len(prior.forces)) == k, -1.0, 1.0)
        yield f"{name} seems to have the other sign", replace(measured, forces=sign * measured.forces)
    yield from _swapped("forces", prior.forces, measured)
    for factor, text in _FACTORS.items():
        yield f"the forces seem off by {text}", replace(measured, forces=factor * measured.forces)


def _swapped(key: str, names: Sequence[str], measured: Measured) -> Iterator[tuple[str, Measured]]:
    """Give readings with each two columns the other way round."""
    for a, b in combinations(range(len(names)), 2):
        columns = getattr(measured, key).copy()
        columns[:, [a, b]] = columns[:, [b, a]]
        yield f"{names[a]} and {names[b]} seem swapped", replace(measured, **{key: columns})
