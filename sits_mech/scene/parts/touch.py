"""Define what touches the target, or its cover: its shape, where it presses, and how it is held.

What touches is rigid. On the bare target, which is rigid as well, a sphere meets it at one point, a cylinder along a
line, a punch or a pressure over an area. Only the force and its place matter; that of an area is its middle. A cover
gives way below it, so that the shape matters, too.
"""

from __future__ import annotations

from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, model_validator

from sits_mech.inputs import FORM
from sits_mech.quantities import Array, Mask
from sits_mech.scene.bounds import Coordinate, Length, PressingForce, check_sizes
from sits_mech.scene.parts.cover import Cover
from sits_mech.scene.parts.elastomer import Elastomer
from sits_mech.scene.parts.metal import Target
from sits_mech.scene.parts.outlines import circle, polygon
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

_SIZES = {"sphere": ("radius",), "cylinder": ("radius", "length", "axis")}
_FACE = ("width", "length", "diameter")
_KEYS = ("radius", "axis", *_FACE)

Touchable = tuple[Target, Cover | None, Elastomer | None]
"""A target, its cover, and the pad below."""


class Touch(BaseModel):
    """What presses on the top face of the target, or of its cover, in place of a force in the middle.

    Attributes
    ----------
    shape : str
        "sphere" (radius), "cylinder" (radius, length, axis), "punch" with a flat face, or a uniform "pressure" (each
        width and length, or diameter).
    x, y : float
        Where it touches the target at rest: the lowest point, or the middle of a line or an area [m].
    friction : str
        "none": it is guided, slides on the target and presses along the normal of its face, which turns with it; a
        pressure stays where it is on the target. "sticking": it keeps its place on the target and the force its
        direction; a sphere or cylinder rolls there. On a cover shapes are guided, without friction, and a pressure
        keeps its direction whatever is given.
    force : float or None
        By which it presses where a command names no load [N].
    depth : float or None
        How far it is pushed in from where it first touches, in place of the force, which is found [m].
    radius, width, length, diameter : float or None
        Of the sphere or cylinder; of the area, width and the other length along x and y; of a cylinder along it [m].
    axis : str or None
        Along which a cylinder lies, "x" or "y".
    edge_radius : float or None
        By which the edge of a punch is rounded, that one which presses on a cover needs [m].
    """

    model_config = FORM
    shape: Literal["sphere", "cylinder", "punch", "pressure"]
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    friction: Literal["none", "sticking"] = "none"
    force: PressingForce | None = None
    depth: Length | None = None
    radius: Length | None = None
    width: Length | None = None
    length: Length | None = None
    diameter: Length | None = None
    axis: Literal["x", "y"] | None = None
    edge_radius: Length | None = None

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        """Refuse a shape without its sizes, or with those of another, and a depth beside a force, or of a pressure."""
        if self.depth is not None and self.force is not None:
            raise SceneError(f"depth must be left out beside force, of which one is given; got {mm(self.depth)}, "
                             f"{self.force:g} N")
        if self.depth is not None and self.shape == "pressure":
            raise SceneError(f"depth must be left out of a pressure, which has no shape; got {mm(self.depth)}")
        needed = _SIZES.get(self.shape, ("diameter",) if self.diameter is not None else ("width", "length"))
        check_sizes(self, needed, f"a {self.shape}", _KEYS)
        if self.edge_radius is None:
            return self
        if self.shape != "punch":
            got = mm(self.edge_radius)
            raise SceneError(f"edge_radius must be left out of a {self.shape}, which has no edge; got {got}")
        half = 0.5 * min(each for each in (self.width, self.length, self.diameter) if each is not None)
        if self.edge_radius > half:
            raise SceneError(f"edge_radius must be at most half the punch, {mm(half)}; got {mm(self.edge_radius)}")
        return self

    @property
    def place(self) -> tuple[float, float]:
        """Where it touches the target at rest [m]."""
        return self.x, self.y

    @property
    def is_round(self) -> bool:
        """Whether it is its own image by any turn about its place."""
        return self.shape == "sphere" or self.diameter is not None

    @property
    def border(self) -> Array:
        """The border of what it touches about its place, shape (n, 2) [m]: one point of a sphere."""
        if self.diameter is not None:
            return np.array(circle(0.5 * self.diameter))
        sizes = self.width or 0.0, self.length or 0.0
        if self.shape == "cylinder":
            sizes = (self.length or 0.0, 0.0) if self.axis == "x" else (0.0, self.length or 0.0)
        corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * sizes
        return np.unique(corners, axis=0) if 0.0 in sizes else corners

    @property
    def words(self) -> str:
        """What it is, for a message: ``punch 4 mm x 4 mm``."""
        if self.radius is not None:
            along = f", {mm(self.length)} long along {self.axis}" if self.length is not None else ""
            return f"{self.shape} of radius {mm(self.radius)}{along}"
        sides = " x ".join(mm(each) for each in (self.width, self.length) if each is not None)
        return f"{self.shape} {sides}" if sides else f"{self.shape} {mm(self.diameter or 0.0)} across"


def check_touch(touch: Touch, target: Target | None, cover: Cover | None, pad: Elastomer | None) -> None:
    """Refuse what touches without a target, beside it or its cover, over a rim or in a hole, or at another height."""
    if target is None:
        raise SceneError("touch: must come with a target that it presses on; target is missing")
    if target.load_height != target.thickness:
        height = mm(target.load_height)
        raise SceneError(f"target.load_height must be left out with touch, which presses on the top face; got {height}")
    if cover is not None and pad is not None:
        _check_on_silicone(touch, cover, pad)
    if touch.depth is not None and pad is not None:
        _check_depth(touch, touch.depth, cover, pad)
    check_place(touch, (target, cover, pad), touch.place)


def _check_depth(touch: Touch, depth: float, cover: Cover | None, pad: Elastomer) -> None:
    """Refuse a depth that no silicone has room for, or by which a shape is sunk."""
    rooms = [(pad.thickness, "the pad")] if cover is None else [(cover.thickness, "the cover")]
    rooms += [(touch.radius, "the radius")] if cover is not None and touch.radius is not None else []
    room, what = min(rooms)
    if depth >= room:
        raise SceneError(f"touch.depth must be less than {what}, {mm(room)}; got {mm(depth)}")


def _check_on_silicone(touch: Touch, cover: Cover, pad: Elastomer) -> None:
    """Refuse a touch that a cover, or the pad below, is not solved under."""
    if pad.friction > 0.0:
        raise SceneError(f"elastomer.friction must be 0 with a touch on a cover; got {pad.friction:g}")
    if touch.friction == "sticking" and touch.shape != "pressure":
        raise SceneError('touch.friction must be "none" on a cover, but for a pressure; got "sticking"')
    least = cover.thickness / 50.0  # meshes resolve no sharper edge
    if touch.shape == "punch" and (touch.edge_radius or 0.0) < least:
        got = "none" if touch.edge_radius is None else mm(touch.edge_radius, 3)
        raise SceneError(f"touch.edge_radius must be at least {mm(least, 3)} on this cover, whose meshes resolve no "
                         f"sharp edge; got {got}")


def check_place(touch: Touch, on: Touchable, place: tuple[float, float]) -> None:
    """Raise SceneError where what touches at a place (x, y) of a target, or its cover on a pad, [m] is not on it.

    A target takes it as a whole, as a cover takes a pressure; there the lowest point of a shape must be on it, and a
    cylinder goes on beyond it.
    """
    target, cover, pad = on
    got = f"got a {touch.words} at x = {mm(place[0])}, y = {mm(place[1])}"
    if cover is None or pad is None:
        if not is_on(touch, target, place):
            words = _words(target.shape, target.extent, target.is_round)
            raise SceneError(f"touch: must lie on the target, {words}, as a whole; {got}")
        return
    size, is_round = cover.extent(target, pad), target.is_round
    border, words = touch.border + place, _words(target.shape, size, is_round)
    on_it = _inside(border if touch.shape == "pressure" else np.array([place]), size, is_round)
    if not on_it.all():
        must = "as a whole" if touch.shape == "pressure" else "with its lowest point"
        raise SceneError(f"touch: must lie on the cover, {words}, {must}; {got}")
    if touch.shape == "cylinder":
        along = 0 if touch.axis == "x" else 1
        if np.abs(border[:, along]).min() < 0.5 * size[along]:
            must = f"reach beyond the cover, {words}, on both sides along {touch.axis}"
            raise SceneError(f"touch.length must {must}; {got}")


def _words(shape: str, size: tuple[float, float], is_round: bool) -> str:
    """Name a face of a target or a cover."""
    return f"a {shape} {mm(size[0])} across" if is_round else f"a {shape} {' x '.join(map(mm, size))}"


def _inside(points: Array, size: tuple[float, float], is_round: bool) -> Mask:
    """Whether points (n, 2) lie on a rectangle, or a disc, of some sizes [m]."""
    half = 0.5 * np.array(size) * (1.0 + SLACK)
    return np.asarray(np.hypot(*points.T) <= half[0] if is_round else np.all(np.abs(points) <= half, axis=1))


def is_on(touch: Touch, target: Target, place: tuple[float, float]) -> bool:
    """Return whether what touches at a place (x, y) on the target [m] is on it as a whole."""
    border = touch.border + place
    if target.loops:
        import shapely

        plate = polygon(target.loops).buffer(SLACK * max(target.extent))
        return bool(plate.covers(shapely.MultiPoint(border).convex_hull))
    return bool(_inside(border, target.extent, target.is_round).all())
