"""Solve the overload of a design: is it carried, and how far is the silicone strained, over what is known of it?

Linear theory comes first. The faces of a pad of thickness t are sheared at the rim by the target's way along, s, and by
the silicone that flows out as a parabola under what sinks by e and tilts by g at its ends [thicknesses], a from the
middle,

    gamma = s + n (e + g) a/t,   n = 3 of a disc, 6 of a strip,      lambda - 1 = gamma/2 + sqrt(1 + gamma^2/4) - 1,

and of the load's corners those are solved that come near the largest. A design whose silicone is to be strained beyond
its data is solved under a part of the load first: as the strain rises with the load, too much there is too much.

Linear theory strains too much: a confined pad of thickness t (1 - e) is stiffer by (1 - e)^-3, and silicones stiffen.
At the end lambda_1 of the data gamma_1 = lambda_1 - 1/lambda_1, e_1 = (e + g) gamma_1/gamma, and the load that brings a
pad there is no more than

    m (2 - e_1)/(2 (1 - e_1)^2),      m = max G(gamma)/G(0) over gamma <= gamma_1,

times that of linear theory, G the secant modulus in shear: where linear theory has more than so many times gamma_1, no
data hold, and a design is left out without a solve. Derivatives of the strain are its own size times those of linear
theory, relative; what they miss the next solved designs correct.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from sits_mech.analysis.limits import corners
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.rests import image_at_rest
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.mechanics.closed_form import plain_pad
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.models import strain_bound, strains_of
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import WRENCH, Equilibrium, SolveFailed, Wrench
from sits_mech.readout.loads import load_words
from sits_mech.scene.sensor import Sensor, known_stretch, silicones_of
from sits_mech.silicone.homogeneous import shear_secant

_SQUEEZED = 0.9  # e_1 at most
_STRAINS = 16  # at which the secant modulus is looked at
_NEAR = 0.7  # of the largest strain by linear theory: corners below it are solved for an answer, not in a search
_HARD = 1.3  # strain that a design is given that does not carry the overload, at least
_MORE = 2.0  # times the load, from one part of it to the next


class Overload(NamedTuple):
    """Result of an overload."""

    reason: str  # why it is not carried; "" where it is
    strain: float  # largest, over the silicone's known range; nan where that is not known
    error: float  # of the strain
    load: Wrench  # of the largest strain


def linear_strain(sensor: Sensor, load: Wrench) -> float:
    """Return the largest strain by linear theory over what is known of the silicone; nan where either is not known."""
    gamma, _ = _sheared(sensor, load)
    pad, made = sensor.elastomer, silicones_of(sensor)
    shares = [
        _strained(gamma * (pad.shear_modulus / each.shear_modulus)) / (each.known_stretch - 1.0)
        for each in made if pad is not None
    ]
    return float(np.fmax.reduce([math.nan, *shares]))


def strain_at_end(sensor: Sensor, load: Wrench) -> float:
    """Return `linear_strain` of so much of a load that a pad is surely strained to the end of its silicone's data."""
    gamma, squeezed = _sheared(sensor, load)
    stretch, made = known_stretch(sensor), silicones_of(sensor)
    if len(made) != 1 or not gamma > 0.0 or not stretch > 1.0:
        return math.nan
    silicone = made[0]
    last = stretch - 1.0 / stretch
    e = min(squeezed * last / gamma, _SQUEEZED)
    secants = (shear_secant(silicone.law, silicone.constants, x) for x in np.linspace(0.0, last, _STRAINS + 1)[1:])
    m = max(1.0, max(secants) / silicone.shear_modulus)
    return _strained(float(m) * (2.0 - e) / (2.0 * (1.0 - e) ** 2) * last) / (stretch - 1.0)


def _sheared(sensor: Sensor, load: Wrench) -> tuple[float, float]:
    """Return gamma and e + g by linear theory; nan where it does not hold."""
    plain = plain_pad(sensor)
    if plain is None:
        return math.nan, math.nan
    (sink, shear, edge), sides = strains_of(*plain, load), tuple(map(min, *(part.extent for part in plain)))
    n = 3.0 * (2.0 - min(sides) / max(sides))
    return shear + n * (sink + edge) * 0.5 * min(sides) / plain[1].thickness, sink + edge


def _strained(gamma: float) -> float:
    """Return lambda - 1 of a shear."""
    return 0.5 * gamma + math.sqrt(1.0 + 0.25 * gamma**2) - 1.0


def overload_of(
    sensor: Sensor, ranges: Mapping[str, tuple[float, float]], tolerance: float, *, finely: bool
) -> Overload:
    """Return what comes of the corners of some loads [N, N m]: on a model's first meshes, or as finely as is asked."""
    loads = corners(sensor, ranges)
    each = {load: linear_strain(sensor, load) for load in loads}
    loads.sort(key=lambda load: (-np.nan_to_num(each[load]), -np.abs(load.components).sum()))
    if not finely:
        loads = [load for load in loads if not each[load] < _NEAR * each[loads[0]]]
    found = []
    for load in loads:
        one = _under(sensor, load, tolerance, each[load], finely=False)
        if one.reason:
            return one
        found.append(one)
    worst = max(found, key=lambda one: one.strain)
    if finely and worst.strain:  # by small strain nothing finer is known; where no finer mesh gets there, the first one
        finer = _under(sensor, worst.load, tolerance, 0.0, finely=True)
        return worst if finer.reason else finer
    return worst


def _under(sensor: Sensor, load: Wrench, tolerance: float, expected: float, *, finely: bool) -> Overload:
    """Return what comes of one load, of a part of it first where it is expected to be too much."""
    part = 1.0 if not expected > 1.0 else 1.0 / expected
    start: Equilibrium | None = None
    while True:
        some = Wrench(*(part * load.components).tolist())
        try:
            start, strain, error = _strain(sensor, some, tolerance, start, finely=finely)
        except SolveFailed as failure:
            return Overload(f"overload: {failure}", _hard(failure, sensor, load), math.nan, load)
        except Collision as failure:
            return Overload(f"overload: {failure}", _HARD, math.nan, load)
        if part >= 1.0:
            return Overload("", strain, error, load)
        if strain > 1.0:
            return Overload(beyond(sensor, load, strain, part), max(strain / part, _HARD), math.nan, load)
        part = min(_MORE * part, 1.0)


def beyond(sensor: Sensor, load: Wrench, strain: float, part: float) -> str:
    """Return in words that the strain under a part of a load is beyond what is known of the silicone."""
    names = [silicone.name for silicone in silicones_of(sensor)]
    name = names[0] if len(names) == 1 and names[0] else "the silicone"
    words = load_words({n: f for n, f in zip(WRENCH, load.components.tolist(), strict=True) if f})
    share = f"{100.0 * part:.2g} % of " if part < 1.0 else ""
    return f"overload: {name} is strained to {strain:.2g} times its data by {share}{words}"


def _strain(
    sensor: Sensor, load: Wrench, tolerance: float, start: Equilibrium | None, *, finely: bool
) -> tuple[Equilibrium, float, float]:
    """Return the rest under a load, the largest strain over the silicone's known range there, and its error."""
    layer, _ = mechanical_model(sensor, "auto", tolerance, [load])
    layer = layer.rough if isinstance(layer, RefinedModel) and not finely else layer
    found, _ = image_at_rest(symmetry_of(sensor), layer, load, start)
    known = known_stretch(sensor) - 1.0
    known = np.inf if np.isnan(known) else known
    check_clearance(sensor, found.pose)
    stretch, error = found.report.stretch, found.report.error_stretch
    if stretch is None:
        return found, 0.0, strain_bound(sensor, [load]) / known  # small strain: no more is known than that
    return found, (stretch - 1.0) / known, (stretch - 1.0 if error is None else error) / known


def _hard(error: SolveFailed, sensor: Sensor, load: Wrench) -> float:
    """Return a strain over the known range for a load that is not carried.

    The largest of `_HARD`, the last state on the way, and the load over the largest one that is carried.
    """
    strain = ((error.report.stretch or 1.0) - 1.0) / (known_stretch(sensor) - 1.0)
    carried = 0.0 if error.carried is None else float(np.linalg.norm(error.carried[0].components))
    over = float(np.linalg.norm(load.components)) / carried if carried else 0.0
    return float(np.nanmax([_HARD, strain, over]))
