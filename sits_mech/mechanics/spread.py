"""How does a touch of several cells spread over silicone: shares of its force at points, and other ways.

On silicone the force of a rigid shape spreads over a part that depends on all below. On even ground that is known at
both ends, of a sphere of radius R and an axisymmetric pressure on r < a

    half-space          p ~ (1 - r^2/a^2)^1/2,   a^3 = 3 F R/(4 E*)       Hertz
    bonded film b       p ~ (1 - r^2/a^2)^2,     a^6 = 32 F R b^3/(pi mu)  incompressible, b << a

with E* = 4 mu (3 K + mu)/(3 K + 4 mu), and of a cylinder, by the force f a length, a^2 = 4 f R/(pi E*). A cover on its
target is stiffer than both: the half-space leaves out the bond, the film all shear but that of its flow. So the mean of
r^2, 2 a^2/5 or a^2/4, is at most the smaller one: that is taken, and a point in the middle is the other end. A punch
lies between even on its face and all at its border. On uneven ground, a target's rim nearer than a and the depth of
silicone, a guided shape may press on one half alone, whose middle of force is 3 a/8 away: that counts, along x and y.
Ways that are not taken are an omission with their size.

Film: with u the flow that a sinking top pushes out, q = -b^3/(3 mu) grad p, div q = d - r^2/2R, p and p' zero at a.
Source: K. L. Johnson, Contact Mechanics (1985), sections 4.2 and 5.8.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from sits_mech.quantities import Array
from sits_mech.scene.cells import Cells
from sits_mech.scene.sensor import silicones_of
from sits_mech.scene.touch import Touch
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm

Spread = tuple[Array, Array]
"""Points (p, 2) from the middle of the pad [m] and shares (p,) of the force."""
_COUNT = 48  # points of a side
_HALF = 0.375  # of a: the middle of force of half of Hertz' pressure
_POINT = np.zeros((1, 2)), np.ones(1)


def spreads(cells: Cells, F: float) -> list[Spread]:
    """Return the way in which a scene's touch by a force [N] lies on cells, and others within which it may be.

    Raise SceneError where a rigid shape meets a bare target beside the silicone that it presses, or sinks in whole.
    """
    touch, place = cells.touched, np.array(cells.touched.place)
    if cells.pressed_target is not None:
        found = [_POINT]
    elif touch.radius is None:
        edge = np.concatenate([np.linspace(*ends, _COUNT) for ends in pairwise([*touch.border, touch.border[0]])])
        even = touch.shape == "pressure"
        found = [_patch(touch, 0.0, 0.0), *([] if even else [(edge, np.full(len(edge), 1.0 / len(edge)))])]
    else:
        found = _curved(cells, touch, F)
    return [(points + place, share) for points, share in found]


def _patch(touch: Touch, a: float, power: float) -> Spread:
    """Return the face of a touch, or of a curved one what is within `a` of its lowest part, p ~ (1 - r^2/a^2)^power."""
    border = np.abs(touch.border).max(axis=0)
    even = (2.0 * np.arange(_COUNT) + 1.0) / _COUNT - 1.0
    each = np.meshgrid(*(even * size for size in np.where(border > 0.0, border, a)), indexing="ij")
    points = np.stack(each, axis=-1).reshape(-1, 2)
    across = np.linalg.norm(points * (border == 0.0), axis=1) / a if touch.radius else np.zeros(len(points))
    within = (across < 1.0) & ((touch.diameter is None) | (np.linalg.norm(points, axis=1) <= border[0]))
    share = (1.0 - across[within] ** 2) ** power
    return points[within], share / share.sum()


def _curved(cells: Cells, touch: Touch, F: float) -> list[Spread]:
    """Return the ways of a sphere or cylinder from its place."""
    (target, pad), cover, R = cells.parts, cells.sensor.cover, touch.radius or 0.0
    soft = min(silicones_of(cells.sensor), key=lambda each: each.shear_modulus)
    mu, K = soft.shear_modulus, soft.bulk_modulus
    E, line, turned = 4.0 * mu * (3.0 * K + mu) / (3.0 * K + 4.0 * mu), touch.length is not None, touch.border == 0.0
    a = math.sqrt(4.0 * F * R / (math.pi * E * touch.length)) if touch.length else (0.75 * F * R / E) ** (1.0 / 3.0)
    if a > R:
        raise SceneError(f"touch.force must be less for a {touch.words}, which sinks in as a whole; got {F:g} N")
    deep = a**2 / R
    met = [name for name, h in zip(cells.names, cells.heights_over(touch), strict=True) if h <= target.thickness + deep]
    if cover is None and met:
        raise SceneError(f"touch must lie on one target or on the silicone beside all, which a {touch.words} sinks "
                         f"{mm(deep)} into under {F:g} N; it meets targets.{met[0]}")
    b = pad.thickness if cover is None else cover.thickness
    half = 0.5 * np.array(target.extent) - np.abs(touch.border).max(axis=0) - a - b
    even = cover is not None and bool(np.any(np.all(np.abs(cells.centres - touch.place) <= half, axis=1)))
    own = _patch(touch, a, 0.5)
    if even and not line:
        film = (32.0 * F * R * b**3 / (math.pi * mu)) ** (1.0 / 6.0)
        own = own if 0.4 * a**2 < 0.25 * film**2 else _patch(touch, film, 2.0)
    found = [own, _patch(touch, 1e-3 * a, 0.0)]
    if not even:
        way = _HALF * a * np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
        found += [(own[0] + each, own[1]) for each in way if np.all(turned.all(axis=0) | (each == 0.0))]
    return found
