"""Compare plane strain with a pad of finite length: ratio of their stiffnesses at small strain.

    factor = k_planar / k_3D,    k in shear (tilt locked), in compression and in tilt, about the bonded face's centre.

The planar model spreads a force over the elastomer's length, a target that is shorter or narrower than its pad makes it
too stiff by the factor. Both are extrapolated from families of meshes (linear.py). What goes on at the ends of a long
pad does not depend on its length: beyond 20 thicknesses and three of the target's widths only the ends are meshed, and
the middle is plane strain. Under a target wider than 30 thicknesses the pad is lubricated: with ``K t^2`` kept the
factors depend on t/w by the edges alone, so that they are found at 1/24 and 1/16 of the width and extrapolated along a
straight line; the step that this adds counts as error as well. Neglected: finite strain, where the factors shrink or
grow with the load; meshes of the user's own.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sits_mech.mechanics.linear import linear_layer, linear_pad
from sits_mech.mechanics.pad.solid import pad_parts
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Sensor, Target
from sits_mech.threads import one_thread

_LONG = (20.0, 3.0)  # thicknesses, widths of the target
_THIN = 30.0  # thicknesses of a target's smaller side from which on thicker pads stand for a thin one,
_THICKER = (24.0, 16.0)  # those with so many


@dataclass(frozen=True)
class FiniteLength:
    """Planar stiffness over stiffness in three dimensions, at small strain."""

    shear: float
    compression: float
    tilt: float
    error: float  # estimated relative error of the factors
    seconds: float  # wall time


@lru_cache(maxsize=8)
@one_thread
def finite_length_factor(sensor: Sensor) -> FiniteLength:
    """Return the factors by which plane strain is too stiff for a sensor's pad.

    Raise ValueError for a scene without target or elastomer, or shapes other than a rectangle or disc on a box or
    cylinder.
    """
    began = time.perf_counter()
    target, elastomer = pad_parts(sensor)
    width, t = min(*target.extent, *elastomer.extent), elastomer.thickness
    if width <= _THIN * t:
        factors, error = _factors(sensor)
    else:
        near, far = (width / count for count in _THICKER)
        (first, error), (second, _) = (_factors(_thicker(sensor, each)) for each in (near, far))
        factors = first + (first - second) * (t - near) / (near - far)
        error += float(np.abs(factors / first - 1.0).max())
    shear, compression, tilt = (float(factor) for factor in factors)
    return FiniteLength(shear, compression, tilt, error, time.perf_counter() - began)


def _factors(sensor: Sensor) -> tuple[Array, float]:
    """Return the factors in shear, compression and tilt, and their error."""
    _, elastomer = pad_parts(sensor)
    sharp = Elastomer.model_validate(elastomer.model_dump() | {"edge_radius": None})
    long, _ = linear_layer(sensor.model_copy(update={"elastomer": sharp})).stiffness
    short, cut = _shortened(sensor)
    solid, error = linear_pad(short).stiffness
    solid = solid + long * (cut / elastomer.extent[1])
    return np.diag(long) / np.diag(solid), error


def _thicker(sensor: Sensor, thickness: float) -> Sensor:
    """Return a scene with a thicker pad of the same ``K t^2`` and shear modulus."""
    _, elastomer = pad_parts(sensor)
    mu, ratio = elastomer.silicone.shear_modulus, elastomer.thickness / thickness
    law = {"law": "neo-hookean", "shear_modulus": mu, "bulk_modulus": elastomer.silicone.bulk_modulus * ratio**2}
    given = elastomer.model_dump() | {"thickness": thickness, "material": law, "edge_radius": None}
    return sensor.model_copy(update={"elastomer": Elastomer.model_validate(given)})


def _shortened(sensor: Sensor) -> tuple[Sensor, float]:
    """Cut the irrelevant middle out of pad and target alike; return the scene and the length cut [m]."""
    target, elastomer = pad_parts(sensor)
    (width, length), t = map(min, target.extent, elastomer.extent), elastomer.thickness
    cut = length - max(_LONG[0] * t, _LONG[1] * width)
    if target.length is None or elastomer.length is None or cut <= 0.0:
        return sensor, 0.0
    plate = Target.model_validate(target.model_dump() | {"length": target.length - cut})
    pad = Elastomer.model_validate(elastomer.model_dump() | {"length": elastomer.length - cut})
    return sensor.model_copy(update={"target": plate, "elastomer": pad}), cut
