"""Define cells on one pad: a scene whose target, with its coils, stands at several places.

`[[targets]]` of a scene file says where; all other keys are those of one cell, its coils about their target's centre.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, model_validator

from sits_mech.arguments import checked_arguments
from sits_mech.inputs import FORM, checked
from sits_mech.quantities import Array
from sits_mech.scene.apart import check_parts
from sits_mech.scene.bounds import Name, Point
from sits_mech.scene.coils import Coil
from sits_mech.scene.sensor import Elastomer, Sensor, Target, scene_tables, sensor_from
from sits_mech.scene.touch import Touch, is_on
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

_LEFT_OUT = ("conductors", "touch", "substrate_radius")  # of one cell
_MOST = 9  # cells of a pad
_CLEAR = 1e-3  # thicknesses between two targets, so that there are cells between them


class Cell(BaseModel):
    """Where a target stands on the pad.

    Attributes
    ----------
    name : str
        One name per cell.
    centre : (x, y)
        Of the target, from the middle of the pad [m].
    """

    model_config = FORM
    name: Name
    centre: Point


class Cells(BaseModel):
    """Two to nine alike cells on one pad; read by `load_cells`.

    Attributes
    ----------
    sensor : Sensor
        One cell alone, in the middle of the pad.
    targets : tuple of Cell
        Where its target stands, with its coils.
    touch : Touch or None
        What presses on them, its place from the middle of the pad [m]: a pressure on any part of the upper face, or a
        rigid shape on one target, on the silicone beside all, or on the cover, which reaches beyond the outer targets.
    """

    model_config = FORM
    sensor: Sensor
    targets: tuple[Cell, ...]
    touch: Touch | None = None

    @property
    def names(self) -> list[str]:
        """The names of the cells in their order."""
        return [cell.name for cell in self.targets]

    @property
    def centres(self) -> Array:
        """Where the targets stand, shape (n, 2) [m]."""
        return np.array([cell.centre for cell in self.targets])

    @property
    def parts(self) -> tuple[Target, Elastomer]:
        """Target and pad; SceneError where these are no rectangles on a box in one piece."""
        target, pad = self.sensor.target, self.sensor.elastomer
        if target is None or pad is None:
            missing = "target" if target is None else "elastomer"
            raise SceneError(f"{missing} must be given for cells on a pad; it is missing")
        if target.shape != "rectangle":
            raise SceneError(f'target.shape must be "rectangle" where several stand on one pad; got "{target.shape}"')
        if pad.kind != "box" or pad.mesh is not None:
            got = pad.kind if pad.mesh is None else f"mesh {pad.mesh}"
            raise SceneError(f"elastomer must be a box under several targets; got {got}")
        return target, pad

    @property
    def cover_ends(self) -> Array:
        """The least and the largest x and y of the cover, (2, 2) [m], to the pad's sides; (0, 2) without one."""
        cover, (target, pad) = self.sensor.cover, self.parts
        if cover is None:
            return np.zeros((0, 2))
        ends = np.stack([self.centres.min(axis=0), self.centres.max(axis=0)])
        ends += (0.5 * np.array(target.extent) + cover.overhang) * np.array([[-1.0], [1.0]])
        half = 0.5 * np.array(pad.extent)
        return np.where(np.abs(ends) > half - _CLEAR * pad.thickness, np.sign(ends) * half, ends)

    @property
    def touched(self) -> Touch:
        """The touch; SceneError where there is none."""
        if self.touch is None:
            raise SceneError("touch must be given to press on cells; it is missing")
        return self.touch

    @property
    def pressed_target(self) -> int | None:
        """Which bare target a rigid touch is on as a whole; None of a pressure, and on silicone."""
        touch, (target, _) = self.touched, self.parts
        if self.sensor.cover is not None or touch.shape == "pressure":
            return None
        return next((k for k, at in enumerate(self.centres) if is_on(touch, target, touch.place - at)), None)

    def coils_at(self, place: Array, name: str = "") -> tuple[Coil, ...]:
        """Return the coils of a cell whose target's centre is at a place (x, y) [m]; `name` goes before theirs."""
        return tuple(
            coil.model_copy(update={"name": name + coil.name, "centre": tuple((place + coil.centre).tolist())})
            for coil in self.sensor.coils
        )

    @model_validator(mode="after")
    def _fits_together(self) -> Cells:
        """Refuse cells that cannot stand on one pad."""
        for key in _LEFT_OUT:
            if getattr(self.sensor, key):
                raise SceneError(f"{key} must be left out with [[targets]]; it is there")
        if not 2 <= len(self.targets) <= _MOST:
            raise SceneError(f"targets must be two to {_MOST}; got {len(self.targets)}")
        twice = [name for name in self.names if self.names.count(name) > 1]
        if twice:
            raise SceneError(f"targets must have a name of their own each; got {twice[0]!r} twice")
        _check_places(self.targets, *self.parts)
        every = [self.coils_at(np.array(cell.centre), f"{cell.name}.") for cell in self.targets]
        check_parts([coil for coils in every for coil in coils], None, None, (), None)
        self._check_cover()
        if self.touch is not None:
            self._check_touch(self.touch)
        return self

    def _check_cover(self) -> None:
        """Refuse a cover that reaches beyond the pad, but where targets do so far."""
        cover, (target, pad) = self.sensor.cover, self.parts
        room = 0.5 * np.subtract(pad.extent, target.extent) - np.abs(self.centres).max(axis=0)
        most = float(np.where(room > SLACK * pad.thickness, room, np.inf).min()) * (1.0 + SLACK)
        if cover is not None and cover.overhang > most:
            raise SceneError(f"cover.overhang must be at most {mm(most)} beyond the outer targets, or it reaches "
                             f"beyond the pad; got {mm(cover.overhang)}")

    def _check_touch(self, touch: Touch) -> None:
        """Refuse a touch beside the upper face, or a rigid one over the rim of a bare target."""
        half, got = 0.5 * np.array(self.parts[1].extent), f"got a {touch.words} at {', '.join(map(mm, touch.place))}"
        what, (low, high) = ("pad", (-half, half)) if self.sensor.cover is None else ("cover", self.cover_ends)
        border, slack = touch.border + touch.place, SLACK * half
        if np.any((border < low - slack) | (border > high + slack)):
            sides = " x ".join(map(mm, (high - low).tolist()))
            raise SceneError(f"touch must lie on the {what}, {sides}, as a whole; {got}")
        at, thick = int(self.heights_over(touch).argmin()), self.parts[0].thickness
        if self.sensor.cover is None and touch.shape != "pressure" and self.pressed_target is None and (
            self.heights_over(touch)[at] <= thick
        ):
            raise SceneError(f"touch must lie on one target or on the silicone beside all, of bare targets {mm(thick)} "
                             f"thick, and not over the rim of targets.{self.names[at]}; {got}")

    def heights_over(self, touch: Touch) -> Array:
        """Return how far a touch's nearest part over each target is above its lowest point, (n,) [m]; inf beside it."""
        half, R = 0.5 * np.array(self.parts[0].extent) + np.abs(touch.border).max(axis=0), touch.radius or 0.0
        away = np.linalg.norm(np.maximum(np.abs(self.centres - touch.place) - half, 0.0), axis=1)
        return np.where(away <= R, R - np.sqrt(np.maximum(R**2 - away**2, 0.0)), np.inf)


def _check_places(cells: Sequence[Cell], target: Target, pad: Elastomer) -> None:
    """Refuse targets beside the pad and those that overlap."""
    size = np.array(target.extent)
    apart = size + _CLEAR * pad.thickness
    for cell in cells:
        over = np.abs(cell.centre) + size / 2.0 - np.array(pad.extent) / 2.0
        if over.max() > 1e-9 * size.max():
            raise SceneError(
                f"targets.{cell.name} must lie on the pad, {' x '.join(map(mm, pad.extent))}; got a target that "
                f"reaches {mm(float(over.max()), 3)} over its side along {'xy'[int(over.argmax())]}"
            )
    for one, other in combinations(cells, 2):
        away = np.abs(np.subtract(one.centre, other.centre))
        if np.all(away < apart):
            (x, y), got = map(mm, apart.tolist()), " and ".join(map(mm, away.tolist()))
            raise SceneError(
                f"targets.{one.name} and targets.{other.name} overlap: their centres must be at least {x} apart along "
                f"x or {y} along y; got {got}"
            )


@checked_arguments
def load_cells(source: str | Path, overrides: Sequence[str] = ()) -> Cells:
    """Read a scene of several cells on one pad: a scene file with a table `[[targets]]` for each.

    Parameters
    ----------
    source, overrides
        As of `load_sensor`, such as ``'targets.B.centre.0="11 mm"'``; raises as it does.

    Examples
    --------
    >>> places = '[{name="A", centre=["-5 mm", "0 mm"]}, {name="B", centre=["5 mm", "0 mm"]}]'
    >>> small = ['coils.C1.turns=4', 'coils.C2.turns=4', 'coils.C1.inner_diameter="1 mm"',
    ...          'coils.C2.inner_diameter="1 mm"', 'coils.C1.centre.0="-2 mm"', 'coils.C2.centre.0="2 mm"']
    >>> sm.load_cells("biorob2018", [f"targets={places}", *small]).names
    ['A', 'B']
    """
    tables = scene_tables(source, overrides)
    if "targets" not in tables:
        raise SceneError(f"{source}: targets must be given, [[targets]] with name and centre of each; it is missing")
    given: dict[str, Any] = {key: tables.pop(key) for key in ("targets", "touch") if key in tables}
    return checked(Cells, given | {"sensor": sensor_from(tables, str(source))}, "scene", str(source))
