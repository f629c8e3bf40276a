"""How does a touch of several cells spread over silicone: shares of its force at points, and other ways.

On silicone the force of a sphere of radius R spreads over a part that depends on all below. A half-space of the softest
silicone is softer than any pad, so that its circle r < a is the largest and a point in the middle the smallest,

    p ~ (1 - r^2/a^2)^1/2,      a^3 = 3 F R/(4 E*),      E* = 4 mu (3 K + mu)/(3 K + 4 mu)     Hertz.

The first is taken. On uneven ground, a target's rim nearer than a and the depth of silicone, the sphere, guided, may
press on one half alone, whose middle of force is 3 a/8 away: that counts, along x and y. A punch lies between even on
its face and all at its border. Ways that are not taken are an omission with their size.

Source: K. L. Johnson, Contact Mechanics (1985), section 4.2.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array
from sits_mech.scene.cells import Cells
from sits_mech.scene.parts.touch import Touch
from sits_mech.scene.sensor import silicones_of
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm

Spread = tuple[Array, Array]
"""Points (p, 2) from the middle of the pad [m] and shares (p,) of the force."""


def spreads(cells: Cells, F: float) -> list[Spread]:
    """Return the way in which a scene's touch by a force [N] lies on cells, and others within which it may be.

    Raise SceneError for a cylinder on silicone, a sphere that sinks in whole or meets a bare target beside silicone.
    """
    touch = cells.touched
    if cells.pressed_target is not None:
        found = [(np.zeros((1, 2)), np.ones(1))]
    elif touch.shape == "pressure":
        found = [_patch(touch, 0.0)]
    elif touch.shape == "punch":
        edge = np.linspace(touch.border, np.roll(touch.border, -1, axis=0), 48, endpoint=False).reshape(-1, 2)
        found = [_patch(touch, 0.0), (edge, np.full(len(edge), 1.0 / len(edge)))]
    else:
        found = _sphere(cells, touch, F)
    return [(points + touch.place, share) for points, share in found]


def _patch(touch: Touch, a: float) -> Spread:
    """Return the face of a touch, evenly, or the circle of a sphere as in the module docstring."""
    flat = np.abs(touch.border).max(axis=0) if touch.radius is None else np.full(2, a)
    each = np.meshgrid(*(((2.0 * np.arange(48) + 1.0) / 48 - 1.0) * size for size in flat), indexing="ij")
    points = np.stack(each, axis=-1).reshape(-1, 2)
    left = 1.0 - np.sum((points / flat) ** 2, axis=1)
    share = np.sqrt(np.maximum(left, 0.0)) if touch.radius else np.where(left > 0.0, 1.0, touch.diameter is None)
    return points, share / share.sum()


def _sphere(cells: Cells, touch: Touch, F: float) -> list[Spread]:
    """Return the ways of a sphere on silicone, from its place."""
    pad, cover, R = cells.pad, cells.sensor.cover, touch.radius or 0.0
    mu, K = min((each.shear_modulus, each.bulk_modulus) for each in silicones_of(cells.sensor))
    a = (0.75 * F * R * (3.0 * K + 4.0 * mu) / (4.0 * mu * (3.0 * K + mu))) ** (1.0 / 3.0)
    if touch.length is not None or a > R:
        raise SceneError(f"touch must be a pressure, a punch or a sphere that does not sink in whole on silicone; got "
                         f"a {touch.words}, {F:g} N")
    low = int((over := cells.heights_over(touch) - cells.thicknesses).argmin())
    if cover is None and over[low] <= a**2 / R:
        raise SceneError(f"touch must lie on one target or on the silicone beside all, which a {touch.words} sinks "
                         f"{mm(a**2 / R, 3)} into under {F:g} N; it meets targets.{cells.names[low]}")
    (lowest, highest), inside = np.moveaxis(cells.ends, 1, 0), a + (pad if cover is None else cover).thickness
    within = (lowest + inside <= touch.place) & (touch.place <= highest - inside)
    even = cover is not None and np.any(np.all(within, axis=1))
    points, share = _patch(touch, a)
    away = 0.375 * a * np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
    return [(points, share), (points[:1] * 0.0, np.ones(1)), *((points + each, share) for each in away[4 * even :])]
