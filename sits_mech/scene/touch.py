"""Define what touches the target: its shape, where it presses, and how it is held.

On the bare target, which is rigid, what touches is rigid as well: a sphere meets it at one point, a cylinder along a
line, a punch or a pressure over an area. Only the force and its place matter; that of an area is its middle.
"""

from __future__ import annotations

from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, model_validator

from sits_mech.inputs import FORM
from sits_mech.quantities import Array
from sits_mech.scene.bounds import Coordinate, Length, PressingForce, check_sizes
from sits_mech.scene.outlines import circle, polygon
from sits_mech.scene.parts import Target
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

_SIZES = {"sphere": ("radius",), "cylinder": ("radius", "length", "axis")}
_FACE = ("width", "length", "diameter")
_KEYS = ("radius", "axis", *_FACE)


class Touch(BaseModel):
    """What presses on the target's top face, in place of a force in its middle.

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
        direction; a sphere or cylinder rolls there.
    force : float or None
        By which it presses where a command names no load [N].
    radius, width, length, diameter : float or None
        Of the sphere or cylinder; of the area, width and the other length along x and y; of a cylinder along it [m].
    axis : str or None
        Along which a cylinder lies, "x" or "y".
    """

    model_config = FORM
    shape: Literal["sphere", "cylinder", "punch", "pressure"]
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    friction: Literal["none", "sticking"] = "none"
    force: PressingForce | None = None
    radius: Length | None = None
    width: Length | None = None
    length: Length | None = None
    diameter: Length | None = None
    axis: Literal["x", "y"] | None = None

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        """Refuse a shape without its sizes, or with those of another."""
        needed = _SIZES.get(self.shape, ("diameter",) if self.diameter is not None else ("width", "length"))
        check_sizes(self, needed, f"a {self.shape}", _KEYS)
        return self

    @property
    def place(self) -> tuple[float, float]:
        """Where it touches the target at rest [m]."""
        return self.x, self.y

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


def check_touch(touch: Touch, target: Target | None, *, covered: bool) -> None:
    """Refuse what touches without a bare target, beside it, over its rim or in a hole, or a force at another height."""
    if target is None:
        raise SceneError("touch: must come with a target that it presses on; target is missing")
    if covered:
        raise SceneError("touch: must press on a bare target, contact with a cover is not solved; got a cover")
    if target.load_height != target.thickness:
        height = mm(target.load_height)
        raise SceneError(f"target.load_height must be left out with touch, which presses on the top face; got {height}")
    check_on_target(touch, target, touch.place)


def check_on_target(touch: Touch, target: Target, place: tuple[float, float]) -> None:
    """Raise SceneError where what touches at a place (x, y) on the target [m] is not on it as a whole."""
    if is_on(touch, target, place):
        return
    sizes = " x ".join(map(mm, target.extent)) if not target.is_round else f"{mm(target.extent[0])} across"
    x, y = place
    got = f"{touch.words} at x = {mm(x)}, y = {mm(y)}"
    raise SceneError(f"touch: must lie on the target, a {target.shape} {sizes}, as a whole; got a {got}")


def is_on(touch: Touch, target: Target, place: tuple[float, float]) -> bool:
    """Return whether what touches at a place (x, y) on the target [m] is on it as a whole."""
    border = touch.border + place
    if target.loops:
        import shapely

        plate = polygon(target.loops).buffer(SLACK * max(target.extent))
        return bool(plate.covers(shapely.MultiPoint(border).convex_hull))
    half = 0.5 * np.array(target.extent) * (1.0 + SLACK)
    if target.is_round:
        return bool(np.all(np.hypot(*border.T) <= half[0]))
    return bool(np.all(np.abs(border) <= half))
