"""Define the silicone pad of a sensor: a box, a cylinder, or pillars on a pitch, of one silicone or of layers.

It stands centred between the rigid ground and the target, bonded to both where it lies under the target. Pillars are
round, all alike, on a square grid that fills a field of ``width`` by ``length``, as many as there is room for,

    n = 1 + floor((size - diameter)/pitch) along each side,    middles at (k - (n - 1)/2) pitch,  k = 0 .. n - 1,

those of them that stand wholly under the target: the others would carry nothing. Lengths [m].

Layers lie one on the other from the ground up, bonded, all of the pad's outline. In series, as they are sheared and
compressed, n of thickness t_i in t have the moduli t/sum(t_i/mu_i) and t/sum(t_i/K_i).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate
from typing import Any, ClassVar, Literal

from pydantic import BaseModel, SerializerFunctionWrapHandler, model_serializer, model_validator

from sits_mech.inputs import FORM
from sits_mech.scene.bounds import (
    BESIDE_SILICONE,
    Friction,
    Length,
    Offset,
    SiliconeOrName,
    Stretch,
    check_sizes,
    extent_of,
)
from sits_mech.scene.materials import silicones
from sits_mech.silicone.material import Silicone
from sits_mech.units import SLACK, SceneError, shown, si_value
from sits_mech.units import millimetres as mm

Shape = Literal["box", "cylinder", "pillars"]
Place = tuple[float, float]
_OF_EACH = ("material", "thickness", "free_stretch")  # keys of one silicone, which layers have each
NOT_WITH_LAYERS = dict.fromkeys(_OF_EACH, "each of which has its own") | {
    "edge_radius": "whose edges are sharp", "mesh": "which are meshed here",
}
"""Keys that a pad of layers may not have, and why."""
THINNEST = 1e-3
"""Of a pad's thickness, the least that a layer has."""
_SIZES: dict[Shape, tuple[str, ...]] = {
    "box": ("width", "length"),
    "cylinder": ("diameter",),
    "pillars": ("width", "length", "diameter", "pitch"),
}


class Layer(BaseModel):
    """One silicone of a pad, bonded to what lies under and over it.

    Attributes
    ----------
    material : str or Silicone
        A silicone of the catalogue, or one of the scene's own.
    thickness : float
        [m]
    free_stretch : float
        As of the pad, of this silicone.
    """

    model_config = FORM
    elsewhere: ClassVar[dict[str, str]] = BESIDE_SILICONE
    material: SiliconeOrName
    thickness: Length
    free_stretch: Stretch = 1.0

    @property
    def silicone(self) -> Silicone:
        """What it is made of."""
        return self.material if isinstance(self.material, Silicone) else silicones()[self.material]


class Elastomer(BaseModel):
    """The silicone pad, centred between substrate and target, bonded to both.

    Attributes
    ----------
    material : str or Silicone or None
        A silicone of the catalogue, or one of the scene's own; None of a pad of layers.
    layers : tuple of Layer
        From the ground up, each with `material`, `thickness` and `free_stretch`, in place of the pad's own.
    shape : str or None
        "box" (width, length), "cylinder" (diameter) or "pillars" (pitch, diameter; `width` and `length` of the field
        that they fill, in a scene by default the target's; 3D models only). By default a box or, with a diameter, a
        cylinder.
    width, length : float or None
        Of a box, which needs both, or of a field of pillars, along x and y [m].
    diameter : float or None
        Of a cylinder, or of each pillar [m].
    pitch : float or None
        Between the middles of neighbouring pillars, along x and y alike [m].
    thickness, standoff : float
        Height of the pad, of all layers; rigid film between ``z = 0`` and the pad, no thicker than the pad [m].
    contact : str
        Whether free faces that fold onto the ground or the target are held there, "never", "always" or, "auto", where
        it matters: wherever a free face touches something.
    friction : float
        Coefficient of Coulomb's friction of free faces on ground and target, zero for none. The answer then depends on
        the load path (models at finite strain); contact may not be "never".
    edge_radius : float or None
        Planar and axisymmetric models: radius of the fillets with which the free side faces meet the plates; they are
        drawn in by half of it, bonded widths stay. By default corners are sharp, and singular [m].
    free_stretch : float
        Of each length of the silicone if nothing held it, over the scene's sizes, which are those of what it is bonded
        to: above 1 where it has expanded or swollen, below 1 where it has shrunk in its mould. Layers have their own.
    mesh, weld : str or None, bool
        File of a mesh of the layer in those sizes, with the groups `ground`, `target`, `free` (3D models only); whether
        its duplicated nodes are merged, not refused.
    """

    model_config = FORM
    elsewhere: ClassVar[dict[str, str]] = BESIDE_SILICONE
    material: SiliconeOrName | None
    layers: tuple[Layer, ...] = ()
    shape: Shape | None = None
    width: Length | None = None
    length: Length | None = None
    diameter: Length | None = None
    pitch: Length | None = None
    thickness: Length
    standoff: Offset = 0.0
    contact: Literal["auto", "always", "never"] = "auto"
    friction: Friction = 0.0
    edge_radius: Length | None = None
    free_stretch: Stretch = 1.0
    mesh: str | None = None
    weld: bool = False

    @model_validator(mode="before")
    @classmethod
    def _of_layers(cls, given: Any) -> Any:
        """Give a pad of layers their thickness; refuse what they have themselves, or what stands for one silicone."""
        layers = given.get("layers") if isinstance(given, Mapping) else None
        if not layers:
            return given
        for key, why in NOT_WITH_LAYERS.items():
            if given.get(key) is not None:
                raise SceneError(f"{key} must be left out beside layers, {why}; got {shown(given[key])}")
        each = layers if isinstance(layers, list | tuple) else ()
        return {**given, "material": None, "thickness": sum(map(_thickness, each)) or 1.0}

    @model_validator(mode="after")
    def _whole(self) -> Elastomer:
        """Refuse sizes of another shape, pillars that overlap, a film thicker than the pad, no mesh to weld."""
        check_sizes(self, _SIZES[self.kind], "pillars" if self.kind == "pillars" else f"a {self.kind}")
        if self.pitch is not None and self.diameter is not None and not self.pitch > self.diameter:
            raise SceneError(f"pitch must be larger than diameter ({mm(self.diameter)}); got {mm(self.pitch)}")
        if self.standoff > self.thickness:
            raise SceneError(
                f"standoff must be a film no thicker than the layer (thickness {mm(self.thickness)}); got "
                f"{mm(self.standoff)}"
            )
        if self.friction > 0.0 and self.contact == "never":
            raise SceneError(f'friction must be 0 where contact is "never"; got {self.friction:g}')
        if self.weld and self.mesh is None:
            raise SceneError("weld must be false without a mesh; got true")
        return self

    @model_validator(mode="after")
    def _resolved(self) -> Elastomer:
        """Refuse layers that no mesh resolves."""
        for number, layer in enumerate(self.layers):
            if layer.thickness < THINNEST * self.thickness:
                least = f"at least {THINNEST:g} of the pad's, {mm(self.thickness)}"
                raise SceneError(f"layers.{number}.thickness must be {least}; got {mm(layer.thickness)}")
        return self

    @model_serializer(mode="wrap")
    def _written(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Write layers, or what a pad of one silicone has in their place."""
        table: dict[str, Any] = write(self)
        unsaid = (*_OF_EACH,) if self.layers else ("layers",)
        return {key: item for key, item in table.items() if key not in unsaid}

    @property
    def kind(self) -> Shape:
        """The shape, as given or as the sizes imply."""
        return self.shape or ("box" if self.diameter is None else "cylinder")

    @property
    def is_round(self) -> bool:
        """Whether it is a cylinder."""
        return self.kind == "cylinder"

    @property
    def stack(self) -> tuple[Layer, ...]:
        """Its layers, from the ground up; itself, where it is of one silicone."""
        return self.layers or (Layer.model_construct(
            material=self.material, thickness=self.thickness, free_stretch=self.free_stretch
        ),)

    @property
    def interfaces(self) -> tuple[float, ...]:
        """Heights of its layers' interfaces above its lower face [m]."""
        return tuple(accumulate(layer.thickness for layer in self.stack[:-1]))

    @property
    def words(self) -> str:
        """Its silicones by name for a reader, of layers from the ground up; empty where one has no name."""
        names = [layer.silicone.name for layer in self.stack]
        if not self.layers:
            return names[0]
        return ", ".join(
            f"{mm(layer.thickness)} {name or 'own silicone'}" for layer, name in zip(self.stack, names, strict=True)
        )

    @property
    def places(self) -> dict[str, Silicone]:
        """Its silicones by the keys under which a scene has them, from the ground up."""
        keys = [f"elastomer.layers.{number}" for number in range(len(self.layers))] or ["elastomer"]
        return {key: layer.silicone for key, layer in zip(keys, self.stack, strict=True)}

    @property
    def silicone(self) -> Silicone:
        """What it is made of; SceneError where it is of layers, whose answers need more than one silicone."""
        if len(self.layers) > 1:
            raise SceneError(f"elastomer.layers: must be of one silicone for this; got {len(self.layers)} layers")
        return self.stack[0].silicone

    @property
    def shear_modulus(self) -> float:
        """Modulus of its layers in series [Pa]."""
        return self._in_series([layer.silicone.shear_modulus for layer in self.stack])

    @property
    def bulk_modulus(self) -> float:
        """Modulus of its layers in series [Pa]."""
        return self._in_series([layer.silicone.bulk_modulus for layer in self.stack])

    def _in_series(self, moduli: Sequence[float]) -> float:
        """Return the modulus of layers in series."""
        if len(moduli) == 1:
            return moduli[0]
        return self.thickness / sum(layer.thickness / own for layer, own in zip(self.stack, moduli, strict=True))

    def remade(self, change: Callable[[Layer], Mapping[str, Any]], **own: Any) -> Elastomer:
        """Return the pad with each layer changed by what is returned of it, and with some keys of its own."""
        made = tuple(layer.model_copy(update=dict(change(layer))) for layer in self.stack)
        if self.layers:
            return self.model_copy(update=own | {"layers": made, "thickness": sum(each.thickness for each in made)})
        return self.model_copy(update=own | {key: getattr(made[0], key) for key in _OF_EACH})

    def of_thickness(self, thickness: float) -> Elastomer:
        """Return the pad with another thickness [m], of all layers in proportion."""
        return self.remade(lambda layer: {"thickness": thickness * (layer.thickness / self.thickness)})

    @property
    def extent(self) -> tuple[float, float]:
        """Size along x and y [m]; of pillars, that of their field."""
        return extent_of(self.width, self.length, self.diameter if self.is_round else None)


def _thickness(layer: Any) -> float:
    """Return the thickness of a layer as it is written [m]; zero where it is none, which its own check refuses."""
    try:
        return si_value(layer.thickness if isinstance(layer, Layer) else layer["thickness"], "m")
    except (SceneError, KeyError, TypeError):
        return 0.0


def pillar_middles(elastomer: Elastomer, extent: Place, is_round: bool) -> tuple[Place, ...]:
    """Return the middles x, y of the pillars that stand wholly under a target of a given extent [m].

    `is_round` tells that the target is a disc. Raises SceneError when no pillar does.
    """
    d, pitch = elastomer.diameter or 0.0, elastomer.pitch or 1.0
    along = [_row(size, d, pitch) for size in elastomer.extent]
    found = tuple((x, y) for x in along[0] for y in along[1] if _under(x, y, 0.5 * d, extent, is_round))
    if not found:
        raise SceneError(
            f"elastomer: must have a pillar of diameter {mm(d)} wholly under the target, {mm(extent[0])} x "
            f"{mm(extent[1])}, and within its field, {mm(elastomer.extent[0])} x {mm(elastomer.extent[1])}; it has none"
        )
    return found


def pad_volume(elastomer: Elastomer, extent: Place, is_round: bool) -> float:
    """Return the volume of a layer without load, of all pillars under the target [m^3].

    Raises SceneError when no pillar stands under the target.
    """
    if elastomer.kind == "box":
        return math.prod(elastomer.extent) * elastomer.thickness
    pillars = 1 if elastomer.is_round else len(pillar_middles(elastomer, extent, is_round))
    return pillars * 0.25 * math.pi * (elastomer.diameter or 0.0) ** 2 * elastomer.thickness


def _row(size: float, diameter: float, pitch: float) -> tuple[float, ...]:
    """Return the middles of the pillars along one side of their field."""
    count = 1 + math.floor((size - diameter) / pitch + SLACK)
    return tuple((k - 0.5 * (count - 1)) * pitch for k in range(count))


def _under(x: float, y: float, radius: float, extent: Place, is_round: bool) -> bool:
    """Return whether a circle lies within a rectangle or a disc."""
    if is_round:
        return math.hypot(x, y) + radius <= 0.5 * extent[0] * (1.0 + SLACK)
    return all(abs(at) + radius <= 0.5 * size * (1.0 + SLACK) for at, size in zip((x, y), extent, strict=True))
