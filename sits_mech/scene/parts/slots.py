"""Define slots in the pad under several targets, and walls that fill them: straight, from side to side of the pad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from pydantic import BaseModel, model_validator

from sits_mech.inputs import FORM
from sits_mech.quantities import Array
from sits_mech.scene.bounds import Coordinate, Length
from sits_mech.scene.parts.elastomer import Elastomer
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

CLEAR = 1e-3
"""Thicknesses between two targets or slots, so that there are cells between them."""


class Slot(BaseModel):
    """A straight slot in the pad, from side to side, or a wall that fills it.

    Attributes
    ----------
    x, y : float or None
        Where its middle is: a slot along y by `x`, one along x by `y`, from the middle of the pad [m].
    width : float
        Of the slot [m].
    depth : float or None
        From the upper face, through the pad unless given [m].
    wall : bool
        Whether a rigid wall that stands on the ground fills it as high as the pad, bonded to the silicone.
    """

    model_config = FORM
    x: Coordinate | None = None
    y: Coordinate | None = None
    width: Length
    depth: Length | None = None
    wall: bool = False

    @model_validator(mode="after")
    def _placed(self) -> Slot:
        """Refuse a slot without its place, with two, or a wall that ends above the ground."""
        if (self.x is None) == (self.y is None):
            got = "neither" if self.x is None else "both"
            raise SceneError(f"x or y must be given, of a slot along y or along x; got {got}")
        if self.wall and self.depth is not None:
            raise SceneError(f"depth must be left out of a wall, which stands on the ground; got {mm(self.depth)}")
        return self

    @property
    def axis(self) -> int:
        """Along which axis it is `width` wide: 0 of x, 1 of y."""
        return 0 if self.y is None else 1

    @property
    def ends(self) -> Array:
        """Where it begins and ends along that axis, (2,) [m]."""
        middle = (self.x or 0.0) + (self.y or 0.0)
        return middle + 0.5 * self.width * np.array([-1.0, 1.0])

    def bottom(self, pad: Elastomer) -> float:
        """Return the height of its bottom, 0 where it goes through the pad [thicknesses]."""
        return 0.0 if self.depth is None else max(1.0 - self.depth / pad.thickness, 0.0)

    @property
    def words(self) -> str:
        """Where it is, for a message: ``a slot from x = -0.5 mm to 0.5 mm``."""
        low, high = map(mm, self.ends.tolist())
        return f"a {'wall' if self.wall else 'slot'} from {'xy'[self.axis]} = {low} to {high}"

    def meets(self, low: Array, high: Array, clear: float = 0.0) -> bool:
        """Return whether what lies between `low` and `high`, (2,) each, is in it, or nearer to it than `clear` [m]."""
        k, room = self.axis, clear - SLACK * self.width
        return bool(low[k] < self.ends[1] + room and high[k] > self.ends[0] - room)


def check_slots(slots: Sequence[Slot], pad: Elastomer, targets: Mapping[str, Array]) -> None:
    """Refuse slots through a target, which is between ends (2, 2) [m], beside the pad, below it or into each other."""
    clear = CLEAR * pad.thickness
    for number, slot in enumerate(slots):
        _check_sizes(f"slots.{number}", slot, pad)
        for name, ends in targets.items():
            if slot.meets(ends[0], ends[1], clear * slot.wall):
                met = "at or through" if slot.wall else "through"
                raise SceneError(f"slots.{number} must lie beside all targets; got {slot.words}, {met} targets.{name}")
    for (one, first), (other, second) in combinations(enumerate(slots), 2):
        apart = 0.5 * (first.width + second.width) + clear
        if first.axis == second.axis and abs(first.ends.mean() - second.ends.mean()) < apart:
            raise SceneError(f"slots.{one} and slots.{other} must lie beside each other; got {first.words} and "
                             f"{second.words}")


def _check_sizes(key: str, slot: Slot, pad: Elastomer) -> None:
    """Refuse a slot that reaches beyond the pad or is too narrow to be meshed."""
    clear, t = CLEAR * pad.thickness, pad.thickness
    if max(abs(slot.ends)) > 0.5 * pad.extent[slot.axis] - clear:
        raise SceneError(f"{key} must lie within the pad, {' x '.join(map(mm, pad.extent))}; got {slot.words}")
    if slot.width < clear:
        raise SceneError(f"{key}.width must be at least {mm(clear)}, {CLEAR:g} of the pad's thickness; got "
                         f"{mm(slot.width)}")
    if slot.depth is not None and slot.depth > t * (1.0 + SLACK):
        raise SceneError(f"{key}.depth must be at most the pad's thickness, {mm(t)}; got {mm(slot.depth)}")
