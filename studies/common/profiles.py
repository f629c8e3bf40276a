"""What a measurement itself says of one parameter of a fit: the least chi^2 for each of its values, all others fitted.

Less the parameter's own term it is the measurement's information on it, flat where there is none. Source: D. M. Bates,
D. G. Watts, Nonlinear Regression Analysis and Its Applications, Wiley 1988, ch. 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from sits_mech.analysis.built.comparison import Comparison
from sits_mech.analysis.built.fit import Free, Model, fit_parameters
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError


def profile(found: Comparison, name: str, points: int = 9, reach: float = 1.5) -> tuple[Array, Array]:
    """Return values of a parameter, and the rise of chi^2 without its own term there, over the fit's variance.

    Values go `reach` half-widths to both sides of the best. Raises SceneError when the noise is not known, or the
    measurement does not determine the parameter.
    """
    place = found.fit.names.index(name)
    best, width = float(found.fit.values[place]), float(found.fit.half_widths[place])
    if found.noise is None or not np.isfinite(width):
        raise SceneError(f"profile: {name}: must have a half-width, and the noise be given; got none")
    values = best + width * np.linspace(-reach, reach, points)
    return values, rise(found.model, found.measured.L, found.free, name, found.noise, values) / found.fit.variance


def rise(model: Model, y: Array, free: Sequence[Free], name: str, noise: float, values: Array) -> Array:
    """Return the least chi^2, less its own term, for each value (k,) of a parameter `name`, above the least of them.

    NaN where another parameter would have to go beyond its end, or the others at their start leave nothing to read.
    """
    place = [each.name for each in free].index(name)
    others = [each for each in free if each.name != name]

    def least(value: float) -> float:
        """Return chi^2 with this parameter held."""

        def held(P: Array) -> Array:
            return model(np.insert(P, place, value, axis=-1))

        if not others:
            return float(np.nansum(((held(np.zeros((1, 0)))[0] - y) / noise) ** 2))
        with suppress(ValueError):
            return fit_parameters(held, y, others, noise=noise).chi_square
        return float("nan")

    found = np.array([least(value) for value in values.tolist()])
    return found - np.nanmin(found)
