"""Guess what went wrong where readings fit no sensor of the kind: columns swapped, signs turned, units mixed up.

Each slip is made undone in the readings, and the unknowns fitted anew; named is the one whose readings such a sensor
would show, if it is far likelier than the readings as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.bench import other_way
from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.fit import ParameterFit
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.measured import Measured
from sits_mech.scene.sensor import SceneError, Sensor

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


def other_convention(
    sensor: Sensor, data: xr.Dataset | None, found: ParameterFit | None, fitted: Callable[[str], ParameterFit]
) -> str:
    """Return in words that readings are rather of idle coils the other way, "" where they are not.

    `data` is the table that is fitted, if it is one; `found` the fit of the readings as `sensor` has its idle coils,
    None where there is none, and `fitted` gives that with idle coils as they are named.
    """
    own = sensor.readout.idle_coil
    other = other_way(own)
    if len(sensor.coils) < 2 or (data is not None and data.attrs["unit_L"] != "H"):  # then both ways are one
        return ""
    try:
        again = fitted(other)
    except ValueError:
        return ""
    gain = 0.0 if found is None else (found.chi_square - again.chi_square) / again.variance
    if again.p_value < STRANGE if found is None else gain < _CLEARLY:
        return ""
    return f"the readings are rather with idle coils {other} than {own}: --idle {other}"


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
