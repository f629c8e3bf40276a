"""Define the metal of a sensor besides its coils (coils.py): target and other conductors.

Every part is frozen, checked when it is made, and holds SI numbers under the scene file's own keys. Lengths [m];
x is shear, y out of plane, z up, ``z = 0`` the top face of the uppermost track layer.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, model_validator

from sits_mech.inputs import FORM
from sits_mech.quantities import Array
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.bounds import (
    Angle,
    Coefficient,
    Conductivity,
    Coordinate,
    Length,
    LossTangent,
    MetalName,
    Modulus,
    Name,
    Offset,
    Permeability,
    Point,
    PoissonsRatio,
    check_sizes,
    extent_of,
)
from sits_mech.scene.materials import Metal, metals
from sits_mech.scene.parts.outlines import Loop, check_rims, circle, with_rims_of_mesh
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm


@dataclass(frozen=True)
class BoxedPart:
    """A box around a part in its p places; p = 1 if it does not move."""

    name: str  # as in the scene
    half: Array  # (3,) half sizes [m]
    turns: Array  # (p, 3, 3) rotations
    places: Array  # (p, 3) of the middle [m]

    @classmethod
    def level(cls, name: str, size: tuple[float, ...], place: tuple[float, ...]) -> BoxedPart:
        """Return a box along x, y and z that does not move, by its sizes and its middle [m]."""
        return cls(name, np.array(size) / 2, np.eye(3)[None], np.array([place]))


def separation(first: BoxedPart, second: BoxedPart) -> Array:
    """Return the width of the widest slab between two boxes, negative where they overlap; one a pose [m].

    At most their distance, and positive exactly where there is one (separating axes: the boxes' and their products).
    """
    first_axes, second_axes = np.broadcast_arrays(np.swapaxes(first.turns, 1, 2), np.swapaxes(second.turns, 1, 2))
    products = np.cross(first_axes[:, :, None], second_axes[:, None]).reshape(-1, 9, 3)
    length = np.linalg.norm(products, axis=2, keepdims=True)
    products = np.where(length > 1e-9, products / np.maximum(length, 1e-9), first_axes[:, :1])
    axes = np.concatenate([first_axes, second_axes, products], axis=1)
    apart = np.abs(np.einsum("pai,pi->pa", axes, first.places - second.places))
    for solid, own in ((first, first_axes), (second, second_axes)):
        apart = apart - np.abs(np.einsum("pai,pji->paj", axes, own)) @ solid.half
    return np.asarray(apart.max(1))


_METAL = (
    "conductivity", "relative_permeability", "temperature_coefficient", "permeability_coefficient", "expansion",
    "youngs_modulus", "poissons_ratio",
)
_METALLIC = 1e6  # S/m, that only metals conduct; inks and filled rubbers have a tenth at most
_LEAST_MODULUS = 1.6e10  # Pa, lead's, the least of metals that parts are made of (Kaye and Laby, section 2.2.2)
_POISSON = 0.33  # where it is not known: of metals from 0.28 to 0.44, so that 1/(1 - nu^2) is within 11 %
PLATE_SIZES = {
    "rectangle": ("width", "length"), "disc": ("diameter",), "ring": ("diameter", "inner_diameter"),
    "outline": ("points",),
}
"""Sizes that plates of a shape need, beside the thickness."""


class Plate(BaseModel):
    """What targets and conductors have in common; `Target` says what each is."""

    model_config = FORM
    material: MetalName | None = None
    conductivity: Conductivity | None = None
    relative_permeability: Permeability | None = None
    temperature_coefficient: Coefficient | None = None
    permeability_coefficient: Coefficient | None = None
    expansion: Coefficient | None = None
    shape: Literal["rectangle", "disc", "ring", "outline"]
    width: Length | None = None
    length: Length | None = None
    diameter: Length | None = None
    inner_diameter: Length | None = None
    points: tuple[Point, ...] | None = None
    holes: tuple[tuple[Point, ...], ...] = ()
    thickness: Length

    @model_validator(mode="after")
    def _whole(self) -> Self:
        """Refuse a plate without metal, without the sizes of its shape, with those of another, or impossible rims."""
        if self.material is None and self.conductivity is None:
            raise SceneError("material (or conductivity) must be given; it is missing")
        check_sizes(self, PLATE_SIZES[self.shape], f"a{'n' if self.shape == 'outline' else ''} {self.shape}")
        outer, inner = self.diameter or 0.0, self.inner_diameter or 0.0
        if inner >= outer > 0.0:
            raise SceneError(f"inner_diameter must be smaller than the diameter, {mm(outer)}; got {mm(inner)}")
        check_rims(self.points, self.holes)
        return self

    @property
    def metal(self) -> Metal:
        """The catalogue's metal with the scene's own numbers in place of the catalogue's.

        A coefficient of the catalogue is dropped where the scene gives its own conductivity or permeability.
        """
        found = metals()[self.material] if self.material is not None else Metal("", 0.0)
        if self.conductivity is not None:
            found = replace(found, temperature_coefficient=None)
        if self.relative_permeability is not None:
            found = replace(found, permeability_coefficient=0.0 if self.relative_permeability == 1.0 else None)
        changes: dict[str, Any] = {key: number for key in _METAL if (number := getattr(self, key, None)) is not None}
        return replace(found, **changes, source="the scene") if changes else found

    @property
    def is_round(self) -> bool:
        """Whether the outer rim is a circle."""
        return self.diameter is not None

    @property
    def hole(self) -> float:
        """Diameter of a ring's hole, 0 of all other shapes [m]."""
        return self.inner_diameter or 0.0

    @property
    def loops(self) -> tuple[Loop, ...]:
        """Rims of a plate that is no rectangle or disc, as corners from its centre, the outer one first [m]."""
        if self.points is not None:
            return (self.points, *self.holes)
        rims = (self.diameter, self.inner_diameter)
        return tuple(circle(size / 2) for size in rims if size is not None and self.inner_diameter is not None)

    @property
    def extent(self) -> tuple[float, float]:
        """Size along x and y [m]; of an outline, twice its reach from the plate's centre."""
        if self.points is not None:
            x, y = zip(*self.points, strict=True)
            return 2.0 * max(map(abs, x)), 2.0 * max(map(abs, y))
        return extent_of(self.width, self.length, self.diameter)


class Target(Plate):
    """The conducting plate on the elastomer. It is solved as rigid, what it bends is sized (chain/omitted/bending.py).

    Attributes
    ----------
    material : str or None
        A metal of the catalogue.
    conductivity, relative_permeability : float or None
        Instead of the catalogue's numbers, at 20 degC [S/m, -].
    temperature_coefficient, permeability_coefficient, expansion : float or None
        Likewise: of the resistivity, of the permeability and of lengths [1/K].
    shape : str
        "rectangle" (width along x, length along y), "disc" (diameter), "ring" (diameter and inner_diameter) or
        "outline" (points, from the target's centre, or a file `mesh`: the border of the cells in its group
        `mesh_group`, by default "target").
    width, length, diameter, inner_diameter, thickness : float
        [m].
    points : tuple of (x, y)
        Corners of the outline in order, not closed [m].
    holes : tuple of tuple of (x, y)
        Corners of each hole in an outline [m].
    youngs_modulus, poissons_ratio : float or None
        Instead of the catalogue's, to tell how it bends [Pa, -].
    backing_thickness, backing_modulus : float or None
        Of a plate that is glued on its top and stiffens it, such as 0.8 mm of FR-4 with 22 GPa; the load acts at
        `load_height` all the same [m, Pa].
    net_current : str
        Planar models only: "zero" (isolated plate) or "free" (the current returns at `planar_boundary_radius`).
    load_height : float
        Where the force acts, above the bottom face [m]; the thickness unless given.
    planar_boundary_radius : float or None
        Where the vector potential vanishes, for "free" [m].
    """

    elsewhere: ClassVar[dict[str, str]] = {"centre": "the target rests at x = y = 0; move coils.NAME.centre"}

    youngs_modulus: Modulus | None = None
    poissons_ratio: PoissonsRatio | None = None
    backing_thickness: Length | None = None
    backing_modulus: Modulus | None = None
    net_current: Literal["zero", "free"] = "zero"
    load_height: Offset
    planar_boundary_radius: Length | None = None

    @model_validator(mode="before")
    @classmethod
    def _loaded(cls, given: Any) -> Any:
        """Take corners and holes from a mesh file; put the force on the top face unless the scene says otherwise."""
        if not isinstance(given, Mapping):
            return given
        height = given.get("thickness") if given.get("load_height") is None else given["load_height"]
        return dict(with_rims_of_mesh(given)) | ({} if height is None else {"load_height": height})

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        """Refuse a target without the boundary that its current returns at."""
        if self.net_current == "free" and self.planar_boundary_radius is None:
            raise SceneError('planar_boundary_radius must be given with net_current = "free"; it is missing')
        return self

    @model_validator(mode="after")
    def _backed(self) -> Self:
        """Refuse a backing without its thickness or its modulus."""
        given = {key: getattr(self, key) for key in ("backing_thickness", "backing_modulus")}
        missing = [key for key, value in given.items() if value is None]
        if len(missing) == 1:
            raise SceneError(f"{missing[0]} must be given for a backing; it is missing")
        return self

    @property
    def poisson(self) -> float:
        """Poisson's ratio of its metal, a usual one where it is not known."""
        known = self.metal.poissons_ratio
        return _POISSON if known is None else known

    @property
    def least_modulus(self) -> float | None:
        """Young's modulus, or the least of metals where a metal's own is not known [Pa]; None of what is no metal."""
        known = self.metal.youngs_modulus
        return _LEAST_MODULUS if known is None and self.metal.conductivity >= _METALLIC else known

    @property
    def bare(self) -> bool:
        """Whether nothing is glued on it."""
        return self.backing_thickness is None

    @property
    def bending_stiffness(self) -> float | None:
        """Of it with its backing, D = int E z^2 dz / (1 - nu^2) about the neutral plane [N m]; None where not known."""
        if (E := self.least_modulus) is None:
            return None
        moduli, ends = self._layers(E)
        return float(moduli @ np.diff((ends - self.neutral_plane) ** 3)) / 3.0 / (1.0 - self.poisson**2)

    @property
    def neutral_plane(self) -> float:
        """Height above its bottom face of what bending does not stretch [m]."""
        moduli, ends = self._layers(self.least_modulus or 1.0)
        return float(moduli @ np.diff(ends**2)) / 2.0 / float(moduli @ np.diff(ends))

    def _layers(self, E: float) -> tuple[Array, Array]:
        """Return the moduli of metal and backing [Pa], and where they begin and end above the bottom face [m]."""
        ends = np.cumsum([0.0, self.thickness, self.backing_thickness or 0.0])
        return np.array([E, self.backing_modulus or 0.0]), ends


class _Named(BaseModel):
    """What has a name, which comes first."""

    name: Name


class Conductor(Plate, _Named):
    """A fixed plate of metal or ferrite near the sensor, parallel to the coils unless it is turned.

    Attributes
    ----------
    name : str
        One name per conductor.
    material, conductivity, relative_permeability, temperature_coefficient, permeability_coefficient, expansion
        As for the target.
    loss_tangent : float
        Of the permeability; magnetic losses of ferrite [-].
    shape : str
        "rectangle" (width along x, length along y), "disc" (diameter), "ring" (diameter and inner_diameter; model
        `sheets`) or "outline" (points and holes; model `sheets`).
    centre : tuple of float
        x, y, z of the plate's middle [m]; a scene may leave y out.
    alpha, alpha_x, alpha_z : float
        By which the plate is turned about its middle, as a pose has them: about y, x and z; where several are given,
        about the axis (alpha_x, alpha, alpha_z) by its length. Model `sheets`, except for a disc's alpha_z [rad].
    width, length, diameter, inner_diameter, thickness : float
        [m].
    points, holes
        As of the target, from `centre` [m].
    """

    loss_tangent: LossTangent = 0.0
    centre: tuple[Coordinate, Coordinate, Coordinate]
    alpha: Angle = 0.0
    alpha_x: Angle = 0.0
    alpha_z: Angle = 0.0

    @model_validator(mode="before")
    @classmethod
    def _in_the_middle(cls, given: Any) -> Any:
        """Put ``y = 0`` into a centre of two entries."""
        centre = given.get("centre") if isinstance(given, Mapping) else None
        if isinstance(centre, list | tuple) and len(centre) == 2:
            return dict(given) | {"centre": (centre[0], 0.0, centre[1])}
        return given

    @model_validator(mode="after")
    def _lossy(self) -> Self:
        """Refuse magnetic losses of metal that is not magnetic."""
        if self.loss_tangent > 0.0 and self.metal.relative_permeability == 1.0:
            raise SceneError(f"loss_tangent must be 0 where relative_permeability is 1; got {self.loss_tangent:g}")
        return self

    @property
    def is_turned(self) -> bool:
        """Whether it does not lie as its sizes are given."""
        return (self.alpha, self.alpha_x, self.alpha_z) != (0.0, 0.0, 0.0)

    @property
    def turn(self) -> Array:
        """Its rotation, shape (3, 3)."""
        return rotation_matrix(np.array([self.alpha_x, self.alpha, self.alpha_z]))

    @property
    def box(self) -> BoxedPart:
        """The box around it, sides along its own axes."""
        half = np.array([*self.extent, self.thickness]) / 2
        return BoxedPart(f"conductors.{self.name}", half, self.turn[None], np.array([self.centre]))

    @property
    def span(self) -> tuple[float, float]:
        """Height of its lowest and highest point, of the box around it where it is turned [m]."""
        up = float(np.abs(self.turn[2]) @ self.box.half) if self.is_turned else self.thickness / 2
        return self.centre[2] - up, self.centre[2] + up

    @property
    def metal(self) -> Metal:
        """The metal of the conductor, with the losses of ferrite."""
        found = super().metal
        return replace(found, loss_tangent=self.loss_tangent) if self.loss_tangent else found
