"""Define the coils of a scene: turns of some shape in layers, or free tracks; all checked, in SI numbers.

Lengths [m]; x is shear, y out of plane, z up, ``z = 0`` the top face of the uppermost track layer of the board, so that
no copper lies above it. A positive current runs counter-clockwise seen from above where `directions` does not say
otherwise, and along the points of a `path`. Vias are no part of a coil: its tracks are joined in series without them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain, pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import (
    BaseModel,
    SerializerFunctionWrapHandler,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from sits_mech.inputs import FORM
from sits_mech.scene.bounds import (
    Angle,
    Coefficient,
    Conductivity,
    Coordinate,
    Count,
    Direction,
    Length,
    Name,
    Offset,
    Permittivity,
    Place,
    Point,
)
from sits_mech.scene.parts.outlines import Loop, lines_crossing
from sits_mech.scene.parts.turns import SIDES, reach, turn
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

_DIGITS = 12  # of a path about its middle: picometres
_DRAWN = (*SIDES, "D")
_LAYERED = ("layers", "turns", "track_gap", "layer_pitch", "layer_z", "directions")


class CoilShape(NamedTuple):
    """Keys of the coils of a shape beside those of all coils: sizes that must be given, and what else may be."""

    needed: tuple[str, ...]
    optional: tuple[str, ...]

    @property
    def keys(self) -> tuple[str, ...]:
        """All of them."""
        return self.needed + self.optional


SHAPES = {
    "circle": CoilShape(("inner_diameter",), (*_LAYERED, "winding")),
    "rectangle": CoilShape(("inner_width", "inner_length"), ("corner_radius", *_LAYERED)),
    **dict.fromkeys(SIDES, CoilShape(("inner_diameter",), ("alpha_z", *_LAYERED))),
    "D": CoilShape(("inner_width", "inner_length"), ("alpha_z", *_LAYERED)),
    "path": CoilShape(("path",), ("path_widths",)),
}
ACROSS = ("inner_diameter", "inner_width", "inner_length", "corner_radius", "track_width", "track_gap")
"""Lengths in the board's plane, whatever the shape."""
UPRIGHT = ("track_thickness", "layer_pitch")
"""Lengths through the board."""
_OF_BOARD = ("board_permittivity", "board_expansion", "board_expansion_z", "conductivity", "temperature_coefficient")
_OPTIONAL = ("shape", "corner_radius", "alpha_z", "layer_z", "directions", "path_widths", *_OF_BOARD)
_MOST = 20_000  # points of a path
_USUAL = {"F_x": 1.0, "F_z": 4.0, "F_y": 1.0}  # largest forces of a grid by default [N], in the order of `WRENCH`


class Coil(BaseModel):
    """A coil of tracks of a board.

    Attributes
    ----------
    name : str
        One name per coil.
    shape : str
        "circle", "rectangle", "hexagon", "octagon" or "D" (concentric turns in layers), or "path" (free tracks).
    centre : tuple of float
        x and y of the middle [m]; the points of a path count from it, and it is moved to their bounding box's middle.
    layers, turns : int
        Layers, and turns in each; `layers` may be left out where `layer_z` is given.
    inner_diameter : float
        Of a circle, hexagon or octagon, between the facing edges of the innermost turn [m].
    inner_width, inner_length : float
        Of a rectangle or D, between the facing edges of the innermost turn along x and y [m]. A D has a straight side
        along y at -x, and at +x half a circle of the diameter `inner_length`; it is at least half as wide as long.
    alpha_z : float
        By which a hexagon, octagon or D is turned about its middle, counter-clockwise seen from above; at 0 two sides
        of a hexagon or octagon are along y [rad].
    corner_radius : float
        Of the innermost turn's centre line at the corners of a rectangle; each further turn's is larger by the pitch of
        the turns (concentric arcs); 0 for sharp corners of all turns [m].
    track_width, track_gap, track_thickness : float
        Cross-section of the track and the clear distance of neighbouring turns [m]; one turn needs no gap.
    layer_pitch : float
        Between the middles of neighbouring layers, the uppermost at ``z = -track_thickness / 2`` [m]; one layer needs
        none.
    layer_z : tuple of float
        Instead of it, height of the middle of each layer's copper, from the top down [m].
    directions : tuple of int
        1 for each layer wound counter-clockwise seen from above, -1 for the other way; all 1 unless given.
    path : tuple of polylines of (x, y, z)
        Centre lines in series, in the order of a positive current, each in one layer; z of the copper's middle [m].
    path_widths : tuple of float
        Width of each polyline, where it is not `track_width` for all [m].
    winding : str
        Of circles: "rings" (concentric) or "spiral" (the track's true path; model `sheets`).
    board_permittivity : float
        Relative, of what is between the layers; for the capacitance alone.
    conductivity, temperature_coefficient : float or None
        Of the tracks at 20 degC [S/m], and of their resistivity [1/K]; copper's unless given.
    board_expansion, board_expansion_z : float
        Of the board in its plane, which coils follow, and through it, heights of layers and tracks [1/K]; by default
        of FR-4, which has 14 to 17 ppm/K, and some 40 to 70 below its glass transition.
    """

    model_config = FORM
    name: Name
    shape: Literal["circle", "rectangle", "hexagon", "octagon", "D", "path"] = "circle"
    centre: Point
    layers: Count
    turns: Count
    inner_diameter: Length = 0.0
    inner_width: Length = 0.0
    inner_length: Length = 0.0
    corner_radius: Offset = 0.0
    alpha_z: Angle = 0.0
    track_width: Length
    track_gap: Length
    track_thickness: Length
    layer_pitch: Length
    layer_z: tuple[Coordinate, ...] = ()
    directions: tuple[Direction, ...] = ()
    path: tuple[tuple[Place, ...], ...] = ()
    path_widths: tuple[Length, ...] = ()
    winding: Literal["rings", "spiral"] = "rings"
    board_permittivity: Permittivity = 4.4
    conductivity: Conductivity | None = None
    temperature_coefficient: Coefficient | None = None
    board_expansion: Coefficient = 16e-6
    board_expansion_z: Coefficient = 50e-6

    @model_validator(mode="before")
    @classmethod
    def _what_a_shape_needs(cls, given: Any) -> Any:
        """Refuse sizes of other shapes, and fill in unused ones, such as the gap of a single turn."""
        if not isinstance(given, Mapping):
            return given
        shape = given.get("shape", "circle")
        if not isinstance(shape, str) or shape not in SHAPES:
            return given
        _check_sizes(given, shape)
        if shape == "path":
            unused = {key: given.get("track_thickness") for key in ("track_gap", "layer_pitch")}
            return {"centre": (0.0, 0.0), "layers": 1, "turns": 1} | unused | dict(given)
        gap = {"track_gap": given.get("track_width")} if given.get("turns") == 1 else {}
        return gap | _layers(given) | dict(given)

    @field_validator("path")
    @classmethod
    def _polylines(cls, path: tuple[tuple[Place, ...], ...]) -> tuple[tuple[Place, ...], ...]:
        """Refuse a path without tracks, or with ones that leave their layer or have no length."""
        if not path:
            raise SceneError("must be one polyline or more; got none")
        if (count := sum(map(len, path))) > _MOST:
            raise SceneError(f"must be of at most {_MOST} points, all pairs of tracks count; got {count}")
        for number, line in enumerate(path):
            if len(line) < 2:
                raise SceneError(f"polyline {number} must have two points or more; got {len(line)}")
            heights = {place[2] for place in line}
            if len(heights) > 1:
                raise SceneError(
                    f"polyline {number} must lie in one layer, a via begins another; got z from {mm(min(heights))} to "
                    f"{mm(max(heights))}"
                )
            still = next((k for k, (a, b) in enumerate(pairwise(line)) if a == b), None)
            if still is not None:
                raise SceneError(f"polyline {number} must go on from point to point; got point {still} twice")
        return path

    @field_validator("path_widths")
    @classmethod
    def _a_width_each(cls, widths: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        """Refuse more or fewer widths than polylines."""
        count = len(info.data.get("path", ()))
        if widths and len(widths) != count:
            raise SceneError(f"must be one for each of {count} polylines; got {len(widths)}")
        return widths

    @model_validator(mode="after")
    def _possible(self) -> Coil:
        """Refuse layers that overlap, corners that do not fit and tracks that cross; move a path to its middle."""
        if self.layer_pitch < self.track_thickness:
            raise SceneError(
                f"layer_pitch must be at least track_thickness ({mm(self.track_thickness)}), or the layers overlap; "
                f"got {mm(self.layer_pitch)}"
            )
        if self.directions and len(self.directions) != self.layers:
            raise SceneError(f"directions must be one for each of {self.layers} layers; got {len(self.directions)}")
        self._check_heights()
        self._check_corners()
        if self.shape == "path":
            middle = [(min(column) + max(column)) / 2 for column in zip(*chain(*self.path), strict=True)]
            middle = [0.0 if abs(place) <= 10.0**-_DIGITS else place for place in middle]
            self.__dict__["path"] = tuple(
                tuple((round(x - middle[0], _DIGITS), round(y - middle[1], _DIGITS), z) for x, y, z in line)
                for line in self.path
            )
            self.__dict__["centre"] = (self.centre[0] + middle[0], self.centre[1] + middle[1])
            self._check_crossings()
        return self

    def _check_heights(self) -> None:
        """Refuse copper above z = 0 and layers that overlap."""
        key, heights = ("path", self.heights) if self.shape == "path" else ("layer_z", self.layer_z)
        if not heights:
            return
        half = self.track_thickness / 2
        if max(heights) > -half * (1.0 - SLACK):
            raise SceneError(
                f"{key}: the copper's middle must be at z = {mm(-half)} or below, its top face at or below z = 0; got "
                f"{mm(max(heights))}"
            )
        for above, below in pairwise(heights):
            if above - below < self.track_thickness * (1.0 - SLACK):
                raise SceneError(
                    f"{key}: layers must go down by at least track_thickness ({mm(self.track_thickness)}), or they "
                    f"overlap; got {mm(above)} and {mm(below)}"
                )

    def _check_corners(self) -> None:
        """Refuse a corner sharper than the track is wide, or rounder than the innermost turn, and a D that is none."""
        if self.shape == "D" and 2.0 * self.inner_width * (1.0 + SLACK) < self.inner_length:
            half, got = mm(self.inner_length / 2), mm(self.inner_width)
            raise SceneError(f"inner_width must be at least half the inner_length ({half}) of a D; got {got}")
        least, most = self.track_width / 2, (min(self.inner_width, self.inner_length) + self.track_width) / 2
        radius = self.corner_radius
        if self.shape == "rectangle" and radius > 0.0 and not least <= radius * (1.0 + SLACK) <= most * (1 + 2e-9):
            raise SceneError(
                f"corner_radius must be 0, or from half the track_width ({mm(least)}) to what fits into the innermost "
                f"turn ({mm(most)}); got {mm(radius)}"
            )

    def _check_crossings(self) -> None:
        """Refuse tracks of a path that cross or touch in one layer, other than end to end."""
        for height in self.heights:
            lines = [np.array(line)[:, :2] for line in self.path if line[0][2] == height]
            place = lines_crossing(lines)
            if place is not None:
                raise SceneError(
                    f"path: tracks must not cross in one layer; those at z = {mm(height)} do at x = "
                    f"{mm(place[0] + self.centre[0], 4)}, y = {mm(place[1] + self.centre[1], 4)}"
                )

    @model_serializer(mode="wrap")
    def _own_keys(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Write only the keys of the shape, without optional ones at their defaults."""
        table: dict[str, Any] = handler(self)
        other = {key for each in SHAPES.values() for key in each.keys} - set(SHAPES[self.shape].keys)
        drop = other | ({"layers", "layer_pitch"} if self.layer_z else set())
        fields = type(self).model_fields
        drop |= {key for key in _OPTIONAL if getattr(self, key) == fields[key].default}
        return {key: item for key, item in table.items() if key not in drop}

    @property
    def is_round(self) -> bool:
        """Whether the turns are circles about an axis."""
        return self.shape == "circle"

    @property
    def heights(self) -> tuple[float, ...]:
        """Height of the middle of each layer's copper, from the top down [m]."""
        if self.shape == "path":
            return tuple(sorted({line[0][2] for line in self.path}, reverse=True))
        below = (-self.track_thickness / 2 - self.layer_pitch * k for k in range(self.layers))
        return self.layer_z or tuple(below)

    @property
    def spans(self) -> tuple[tuple[float, float], ...]:
        """Bottom and top of what the coil fills, of each layer where these have heights of their own [m]."""
        if not self.layer_z and self.is_round:
            return ((-self.height, 0.0),)
        half = self.track_thickness / 2
        return tuple((z - half, z + half) for z in self.heights)

    @property
    def widths(self) -> tuple[float, ...]:
        """Track width of each polyline of a path [m]."""
        return self.path_widths or (self.track_width,) * len(self.path)

    @property
    def _winding(self) -> float:
        """Distance of the outer edge from the inner one [m]."""
        return self.turns * self.track_width + (self.turns - 1) * self.track_gap

    @property
    def rim(self) -> Loop:
        """Corners of the outer edge of a hexagon, octagon or D from the middle; none of other shapes [m]."""
        return tuple(map(tuple, turn(self, self._winding).tolist())) if self.shape in _DRAWN else ()

    @property
    def extent(self) -> tuple[float, float]:
        """Size along x and y of the smallest box about the middle that holds all tracks [m]."""
        if self.shape == "path":
            pairs = [(line, width / 2) for line, width in zip(self.path, self.widths, strict=True)]
            x, y = (max(abs(place[k]) + half for line, half in pairs for place in line) for k in (0, 1))
            return 2.0 * x, 2.0 * y
        winding = 2.0 * self._winding
        if self.shape in _DRAWN:
            x, y, _ = reach(self, self._winding)
            return 2.0 * x, 2.0 * y
        inner = (self.inner_diameter,) * 2 if self.is_round else (self.inner_width, self.inner_length)
        return inner[0] + winding, inner[1] + winding

    @property
    def outer_diameter(self) -> float:
        """Diameter of the circle about the middle that holds all tracks [m]; of a circle, of its outer edge."""
        if self.shape == "path":
            pairs = zip(self.path, self.widths, strict=True)
            return max(2.0 * math.hypot(*place[:2]) + width for line, width in pairs for place in line)
        if self.is_round:
            return self.extent[0]
        if self.shape in _DRAWN:
            return 2.0 * reach(self, self._winding)[2]
        pitch = (self.turns - 1) * (self.track_width + self.track_gap)
        outermost = self.corner_radius + pitch + self.track_width / 2 if self.corner_radius else 0.0
        return 2.0 * (math.hypot(*(size / 2 - outermost for size in self.extent)) + outermost)

    @property
    def height(self) -> float:
        """Height from the bottom face of the lowest layer to ``z = 0`` [m]."""
        if self.layer_z or self.shape == "path":
            return self.track_thickness / 2 - self.heights[-1]
        return (self.layers - 1) * self.layer_pitch + self.track_thickness


def _check_sizes(given: Mapping[str, Any], shape: str) -> None:
    """Refuse sizes of other shapes than a coil's own, and missing ones."""
    for key in dict.fromkeys(key for each in SHAPES.values() for key in each.keys):
        if key in given and key not in SHAPES[shape].keys:
            raise SceneError(f"{key} must not be given for a {shape}; it is")
    for key in SHAPES[shape].needed:
        if key not in given:
            raise SceneError(f"{key} must be given for a {shape}; it is missing")


def _layers(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a coil's table may leave out of number and pitch of layers; refuse it beside other heights."""
    heights, pitch = given.get("layer_z"), {"layer_pitch": given.get("track_thickness")}
    if not isinstance(heights, list | tuple) or not heights:
        return pitch if given.get("layers") == 1 else {}
    if "layer_pitch" in given:
        raise SceneError("layer_pitch must not be given beside layer_z; it is")
    if given.get("layers", len(heights)) != len(heights):
        raise SceneError(f"layers must be the {len(heights)} of layer_z; got {given['layers']}")
    return {"layers": len(heights)} | pitch


def resolved_shear(coils: Sequence[Coil]) -> tuple[str, ...]:
    """Return the shear forces that coils resolve: along axes on which not all have one place."""
    return tuple(name for k, name in enumerate(("F_x", "F_y")) if len({coil.centre[k] for coil in coils}) > 1)


def usual_loads(coils: Sequence[Coil], *, slides: bool = False) -> dict[str, float]:
    """Return the largest forces of a grid by default [N]: the first shear that coils resolve, and the normal force.

    That alone of what `slides` on the target.
    """
    shear = () if slides else resolved_shear(coils)[:1]
    return {name: most for name, most in _USUAL.items() if name in (*shear, "F_z")}
