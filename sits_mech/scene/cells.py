"""Define cells on one pad: targets with their coils at several places, alike or not, and slots between them.

`[[targets]]` of a scene file says where each stands, and in what it differs: which of the coils are its own, its sizes.
All other keys are those of each cell, its coils about their target's centre. `[[slots]]` are cut into the pad from
above, straight and from side to side; one through the pad parts it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import BaseModel, model_validator

from sits_mech.arguments import checked_arguments
from sits_mech.inputs import FORM, checked, unknown
from sits_mech.quantities import Array
from sits_mech.scene.apart import check_parts
from sits_mech.scene.bounds import Length, Name, Point
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.parts.slots import CLEAR, Slot, check_slots
from sits_mech.scene.parts.touch import Touch, is_on
from sits_mech.scene.sensor import Elastomer, Sensor, Target, scene_tables, sensor_from
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

_LEFT_OUT = ("conductors", "touch", "substrate_radius")  # of one cell
_MOST = 9  # cells of a pad
_SIZES = ("width", "length", "thickness")  # of a target that may be a cell's own


class Cell(BaseModel):
    """Where a target stands on the pad, and in what it differs from `[target]`.

    Attributes
    ----------
    name : str
        One name per cell.
    centre : (x, y)
        Of the target, from the middle of the pad [m].
    coils : tuple of str or None
        Names of its coils among those of the scene, about the target's centre; all unless given. Cells may name the
        same one: each has its own.
    width, length, thickness : float or None
        Of its target, those of `[target]` unless given [m].
    """

    model_config = FORM
    name: Name
    centre: Point
    coils: tuple[Name, ...] | None = None
    width: Length | None = None
    length: Length | None = None
    thickness: Length | None = None

    @property
    def sizes(self) -> dict[str, float]:
        """The sizes that are its target's own [m]."""
        return {key: size for key in _SIZES if (size := getattr(self, key)) is not None}


class Places(BaseModel):
    """What stands where on a pad of several cells, as it is written; `Cells` says what each is."""

    model_config = FORM
    targets: tuple[Cell, ...]
    slots: tuple[Slot, ...] = ()
    touch: Touch | None = None

    @model_validator(mode="after")
    def _named(self) -> Self:
        """Refuse too few cells, or too many, and names that are no cell's own."""
        if not 2 <= len(self.targets) <= _MOST:
            raise SceneError(f"targets must be two to {_MOST}; got {len(self.targets)}")
        twice = [name for name in self.names if self.names.count(name) > 1]
        if twice:
            raise SceneError(f"targets must have a name of their own each; got {twice[0]!r} twice")
        return self

    @property
    def names(self) -> list[str]:
        """The names of the cells in their order."""
        return [cell.name for cell in self.targets]

    @property
    def centres(self) -> Array:
        """Where the targets stand, shape (n, 2) [m]."""
        return np.array([cell.centre for cell in self.targets])


class Cells(Places):
    """Two to nine cells on one pad; read by `load_cells`.

    Attributes
    ----------
    targets : tuple of Cell
        Where each target stands, with its coils.
    slots : tuple of Slot
        In the pad between them.
    touch : Touch or None
        What presses on them, its place from the middle of the pad [m]: a pressure on any part of the upper face, or a
        rigid shape on one target, on the silicone beside all, or on the cover, which reaches beyond the outer targets.
    sensors : tuple of Sensor
        Each cell alone, in the middle of the pad.
    """

    sensors: tuple[Sensor, ...]

    @property
    def sensor(self) -> Sensor:
        """The first cell alone; pad, cover, frequency and readout are those of all."""
        return self.sensors[0]

    @property
    def kinds(self) -> list[int]:
        """Of each cell the number of the first one like it."""
        return [self.sensors.index(own) for own in self.sensors]

    @property
    def coil_names(self) -> list[str]:
        """The names of all coils of cells, each once."""
        return list(dict.fromkeys(name for own in self.sensors for name in own.coil_names))

    @property
    def plates(self) -> list[Target]:
        """The targets; SceneError where one is no rectangle."""
        found = []
        for own in self.sensors:
            if own.target is None:
                raise SceneError("target must be given for cells on a pad; it is missing")
            if own.target.shape != "rectangle":
                got = own.target.shape
                raise SceneError(f'target.shape must be "rectangle" where several stand on one pad; got "{got}"')
            found.append(own.target)
        return found

    @property
    def pad(self) -> Elastomer:
        """The pad; SceneError where it is no box in one piece."""
        pad = self.sensor.elastomer
        if pad is None:
            raise SceneError("elastomer must be given for cells on a pad; it is missing")
        if pad.kind != "box" or pad.mesh is not None:
            got = pad.kind if pad.mesh is None else f"mesh {pad.mesh}"
            raise SceneError(f"elastomer must be a box under several targets; got {got}")
        return pad

    @property
    def ends(self) -> Array:
        """The least and the largest x and y of each target, shape (n, 2, 2) [m]."""
        half = 0.5 * np.array([plate.extent for plate in self.plates])
        return np.stack([self.centres - half, self.centres + half], axis=1)

    @property
    def thicknesses(self) -> Array:
        """Of the targets, (n,) [m]."""
        return np.array([plate.thickness for plate in self.plates])

    @property
    def gaps(self) -> Array:
        """The distances of targets from each other, (n, n) [m]; infinite of each from itself."""
        low, high = np.moveaxis(self.ends, 1, 0)
        aside = np.maximum(low[:, None] - high, low - high[:, None])
        apart = np.linalg.norm(np.maximum(aside, 0.0), axis=2)
        return np.where(np.eye(len(apart), dtype=bool), np.inf, np.round(apart, 12))

    @property
    def cover_ends(self) -> Array:
        """The least and the largest x and y of the cover, (2, 2) [m], to the pad's sides; (0, 2) without one."""
        cover, pad = self.sensor.cover, self.pad
        if cover is None:
            return np.zeros((0, 2))
        ends = np.stack([self.ends[:, 0].min(axis=0), self.ends[:, 1].max(axis=0)])
        ends += cover.overhang * np.array([[-1.0], [1.0]])
        half = 0.5 * np.array(pad.extent)
        return np.where(np.abs(ends) > half - CLEAR * pad.thickness, np.sign(ends) * half, ends)

    @property
    def touched(self) -> Touch:
        """The touch; SceneError where there is none."""
        if self.touch is None:
            raise SceneError("touch must be given to press on cells; it is missing")
        return self.touch

    @property
    def pressed_target(self) -> int | None:
        """Which bare target a rigid touch is on as a whole; None of a pressure, and on silicone."""
        touch = self.touched
        if self.sensor.cover is not None or touch.shape == "pressure":
            return None
        each = enumerate(zip(self.plates, self.centres, strict=True))
        return next((k for k, (plate, at) in each if is_on(touch, plate, touch.place - at)), None)

    def coils_at(self, k: int, place: Array, name: str = "") -> tuple[Coil, ...]:
        """Return the coils of cell k, its target's centre at a place (x, y) [m]; `name` goes before theirs."""
        return tuple(
            coil.model_copy(update={"name": name + coil.name, "centre": tuple((place + coil.centre).tolist())})
            for coil in self.sensors[k].coils
        )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        """Refuse cells that cannot stand on one pad."""
        for key in _LEFT_OUT:
            if getattr(self.sensor, key):
                raise SceneError(f"{key} must be left out with [[targets]]; it is there")
        _check_places(self)
        each = enumerate(self.targets)
        every = [coil for k, cell in each for coil in self.coils_at(k, np.array(cell.centre), f"{cell.name}.")]
        check_parts(every, None, None, (), None)
        self._check_cover()
        if self.slots and self.sensor.cover is not None:
            raise SceneError(f"slots must be left out under a cover, which would bridge them; got {len(self.slots)}")
        check_slots(self.slots, self.pad, dict(zip(self.names, self.ends, strict=True)))
        if self.touch is not None:
            self._check_touch(self.touch)
        return self

    def _check_cover(self) -> None:
        """Refuse a cover on targets of several thicknesses, or beyond the pad, but where targets reach so far."""
        cover, pad, (first, *others) = self.sensor.cover, self.pad, self.plates
        if cover is None:
            return
        for name, plate in zip(self.names[1:], others, strict=True):
            if plate.thickness != first.thickness:
                raise SceneError(f"targets.{name} must be as thick as all under one cover, {mm(first.thickness)}; got "
                                 f"{mm(plate.thickness)}")
        room = 0.5 * np.array(pad.extent) - np.abs(self.ends).max(axis=(0, 1))
        most = float(np.where(room > SLACK * pad.thickness, room, np.inf).min()) * (1.0 + SLACK)
        if cover.overhang > most:
            raise SceneError(f"cover.overhang must be at most {mm(most)} beyond the outer targets, or it reaches "
                             f"beyond the pad; got {mm(cover.overhang)}")

    def _check_touch(self, touch: Touch) -> None:
        """Refuse a touch beside the upper face, or a rigid one over the rim of a bare target."""
        half, got = 0.5 * np.array(self.pad.extent), f"got a {touch.words} at {', '.join(map(mm, touch.place))}"
        what, (low, high) = ("pad", (-half, half)) if self.sensor.cover is None else ("cover", self.cover_ends)
        border, slack = touch.border + touch.place, SLACK * half
        if np.any((border < low - slack) | (border > high + slack)):
            sides = " x ".join(map(mm, (high - low).tolist()))
            raise SceneError(f"touch must lie on the {what}, {sides}, as a whole; {got}")
        for number, slot in enumerate(self.slots):
            if slot.meets(border.min(axis=0), border.max(axis=0)):
                raise SceneError(f"touch must lie beside slots.{number}, {slot.words}; {got}")
        over = self.heights_over(touch) - self.thicknesses
        at = int(over.argmin())
        if self.sensor.cover is None and touch.shape != "pressure" and self.pressed_target is None and over[at] <= 0.0:
            raise SceneError(f"touch must lie on one target or on the silicone beside all, of bare targets "
                             f"{mm(self.plates[at].thickness)} thick, and not over the rim of targets."
                             f"{self.names[at]}; {got}")

    def heights_over(self, touch: Touch) -> Array:
        """Return how far a touch's nearest part over each target is above its lowest point, (n,) [m]; inf beside it."""
        reach, R, place = np.abs(touch.border).max(axis=0), touch.radius or 0.0, np.array(touch.place)
        low, high = np.moveaxis(self.ends, 1, 0)
        away = np.linalg.norm(np.maximum(np.maximum(low - place, place - high) - reach, 0.0), axis=1)
        return np.where(away <= R, R - np.sqrt(np.maximum(R**2 - away**2, 0.0)), np.inf)


def _check_places(cells: Cells) -> None:
    """Refuse targets beside the pad and those that overlap."""
    pad, extents = cells.pad, [np.array(plate.extent) for plate in cells.plates]
    for cell, size in zip(cells.targets, extents, strict=True):
        over = np.abs(cell.centre) + size / 2.0 - np.array(pad.extent) / 2.0
        if over.max() > 1e-9 * size.max():
            raise SceneError(
                f"targets.{cell.name} must lie on the pad, {' x '.join(map(mm, pad.extent))}; got a target that "
                f"reaches {mm(float(over.max()), 3)} over its side along {'xy'[int(over.argmax())]}"
            )
    for (one, size), (other, its) in combinations(zip(cells.targets, extents, strict=True), 2):
        away, apart = np.abs(np.subtract(one.centre, other.centre)), (size + its) / 2.0 + CLEAR * pad.thickness
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
    >>> places = '[{name="A", centre=["-5 mm", "0 mm"]}, {name="B", centre=["5 mm", "0 mm"], length="6 mm"}]'
    >>> small = ['coils.C1.turns=4', 'coils.C2.turns=4', 'coils.C1.inner_diameter="1 mm"',
    ...          'coils.C2.inner_diameter="1 mm"', 'coils.C1.centre.0="-2 mm"', 'coils.C2.centre.0="2 mm"']
    >>> sm.load_cells("biorob2018", [f"targets={places}", *small]).names
    ['A', 'B']
    """
    tables = scene_tables(source, overrides)
    if "targets" not in tables:
        raise SceneError(f"{source}: targets must be given, [[targets]] with name and centre of each; it is missing")
    return cells_from(tables, str(source))


def cells_from(tables: Mapping[str, Any], where: str) -> Cells:
    """Return the checked cells that a scene's tables describe; raises as `load_sensor`, `where` first."""
    keys = tuple(Places.model_fields)
    places = checked(Places, {key: tables[key] for key in keys if key in tables}, "scene", where)
    shared = {key: part for key, part in tables.items() if key not in keys}
    sensors = [sensor_from(_alone(shared, own, where), where) for own in places.targets]
    for name in map(_name_of, shared["coils"]):
        if not any(cell.coils is None or name in cell.coils for cell in places.targets):
            raise SceneError(f"{where}: coils.{name} must be of a cell, in coils of one of the targets; it is in none")
    return checked(Cells, {**dict(places), "sensors": sensors}, "scene", where)


def _alone(shared: Mapping[str, Any], own: Cell, where: str) -> dict[str, Any]:
    """Return the tables of one cell alone."""
    found, coils = dict(shared), shared.get("coils")
    if own.sizes and isinstance(shared.get("target"), Mapping):
        found["target"] = {**shared["target"], **own.sizes}
    if own.coils is not None and isinstance(coils, list | tuple):
        names, key = list(map(_name_of, coils)), f"{where}: targets.{own.name}.coils"
        found["coils"] = [coils[names.index(name)] for name in own.coils if name in names]
        known = list(map(str, names))
        for name in own.coils:
            if name not in known:
                raise SceneError(f"{key} {unknown(name, known)}")
        if len(set(own.coils)) < max(len(own.coils), 1):
            named = ", ".join(own.coils) or "none"
            raise SceneError(f"{key} must name one coil of the scene or more, each once; got {named}")
    return found


def _name_of(coil: Any) -> Any:
    """Return the name of a coil as it is written; None without one."""
    return coil.get("name") if isinstance(coil, Mapping) else None
