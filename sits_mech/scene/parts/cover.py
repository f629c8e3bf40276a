"""Define the cover of a sensor: silicone on the target's top, around its rim and on the pad beside it, bonded to all.

The target is a rigid inclusion then. With the target's thickness h the cover reaches from the pad's upper face to
``h + thickness`` above it, over the target's outline and `overhang` beyond it; its top is flat. Along a direction in
which the target reaches the pad's sides the cover ends with both. Lengths [m].
"""

from __future__ import annotations

import math

from sits_mech.scene.bounds import Length
from sits_mech.scene.parts.elastomer import THINNEST, Elastomer, Layer
from sits_mech.scene.parts.metal import Target
from sits_mech.scene.parts.outlines import Loop, circle
from sits_mech.units import SLACK, SceneError, shown

_CLEAR = 0.95  # of the room on a pad of another outline, where cells beside the cover would have no width


class Cover(Layer):
    """A silicone bonded on the target's top and rim, and on the pad around it.

    Attributes
    ----------
    thickness : float
        Above the target's top face; beside the target it is that much and the target's thickness high [m].
    overhang : float
        How far it reaches beyond the target's rim, at most to the pad's sides; not at all where these end with it [m].
    """

    overhang: Length

    def extent(self, target: Target, elastomer: Elastomer) -> tuple[float, float]:
        """Return its size along x and y [m]: of the pad where that ends with the target."""
        x, y = (
            own + 2.0 * self.overhang * (size - own > SLACK * size)
            for own, size in zip(target.extent, elastomer.extent, strict=True)
        )
        return x, y

    def rim(self, target: Target, elastomer: Elastomer) -> Loop:
        """Return the corners of its outline around its middle, of a round one of the polygon that stands for it [m]."""
        a, b = (0.5 * size for size in self.extent(target, elastomer))
        return circle(a) if target.is_round else ((-a, -b), (a, -b), (a, b), (-a, b))

    @property
    def words(self) -> str:
        """Its silicone by name for a reader; empty where it has none."""
        return self.silicone.name


def check_cover(cover: Cover, target: Target | None, elastomer: Elastomer | None) -> None:
    """Refuse a cover that has nothing to be bonded on, or that no mesh resolves."""
    if target is None or elastomer is None:
        missing = "target" if target is None else "elastomer"
        raise SceneError(f"cover must have a target and an elastomer to be bonded on; {missing} is missing")
    _check_pad(target, elastomer)
    room = _room(target, elastomer)
    if cover.overhang > room * (1.0 + SLACK):
        raise SceneError(f"cover.overhang must be at most {room:g} m, or it reaches beyond the pad; got "
                         f"{cover.overhang:g} m")
    least = THINNEST * elastomer.thickness
    sizes = {"cover.thickness": cover.thickness, "cover.overhang": cover.overhang, "target.thickness": target.thickness}
    for key, size in sizes.items():
        if size < least:
            raise SceneError(f"{key} must be at least {THINNEST:g} of the pad's thickness, {least:g} m, with a cover; "
                             f"got {size:g} m")


def _check_pad(target: Target, elastomer: Elastomer) -> None:
    """Refuse a pad and a target that take no cover."""
    if target.loops:
        raise SceneError(f"target.shape must be 'rectangle' or 'disc' under a cover; got {shown(target.shape)}")
    if elastomer.kind == "pillars":
        raise SceneError("elastomer.shape must be 'box' or 'cylinder' under a cover; got 'pillars'")
    for key in ("mesh", "edge_radius"):
        if getattr(elastomer, key) is not None:
            raise SceneError(f"elastomer.{key} must be left out under a cover; got {shown(getattr(elastomer, key))}")
    if not 0.0 < _room(target, elastomer) < math.inf:
        sizes = [" x ".join(f"{size:g}" for size in part.extent) for part in (target, elastomer)]
        raise SceneError(f"cover must have pad around the target to be bonded on; a target of {sizes[0]} m covers one "
                         f"of {sizes[1]} m")


def _room(target: Target, elastomer: Elastomer) -> float:
    """Return the largest overhang that a pad has room for [m]; infinite of a flush target, not above 0 of a wider."""
    (a, b), (A, B) = ([0.5 * size for size in part.extent] for part in (target, elastomer))
    if target.is_round == elastomer.is_round:
        margins = ((A - a) / A, A - a), ((B - b) / B, B - b)
        return min((gap for share, gap in margins if abs(share) > SLACK), default=math.inf)
    if target.is_round:
        return _CLEAR * (min(A, B) - a)
    return _CLEAR * 0.5 * (math.sqrt(max(2.0 * A**2 - (a - b) ** 2, 0.0)) - a - b)  # a corner on the circle
