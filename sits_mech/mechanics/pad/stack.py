"""Layers of a pad and its cover in its meshes: lines at their interfaces, sizes, and the law of each cell.

Layers lie at heights from z_0 = 0 to z_n = 1, in thicknesses of the pad. No cell crosses an interface, so that the laws
of a mesh are constant in each cell (element/kernel.py). Where an interface of two silicones meets a free face strains
are singular: its displacements go as ``r**k``, k from 1 of one silicone to that of a clamped corner, 0.5946, where one
is far stiffer, so that lines closer to the interface from both sides, as at a clamped corner, keep the order of the
pad's meshes (shapes.py). An interface within one silicone is not singular and has a line alone.

A cover lies above z_n = 1, the target within it from there to the height of its rim: no cell is there, and what bounds
the gap is bonded to the target. Strains are singular at the edges of the target, where silicone is clamped around three
quarters of a turn, and at the foot of the cover, a free notch of as much: displacements go as ``r**0.5445`` at both, of
one incompressible silicone. Where the target is thin its two edges are one from further away, the tip of a rigid line,
``r**0.5``; two silicones are between that and the 0.5946 of one far stiffer than the other. Orders are those of 0.5.

Sources: M. L. Williams, J. Appl. Mech. 19 (1952) 526, corners; D. B. Bogy, J. Appl. Mech. 38 (1971) 377, corners of two
bonded media.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.kernel import Laws, law_of
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.mechanics.faces.rigid import Press
from sits_mech.mechanics.faces.surface import Surface, edge_points
from sits_mech.quantities import Integers
from sits_mech.scene.sensor import Elastomer, Sensor, shape_on_cover, stack_of

GUARD_SHARE = 0.005
"""Of the bulk modulus that may act pointwise."""
PRESSED = 1e-4
"""Thicknesses over which the pressure of contact in space, and of a shape on a cover, builds up."""
_CONTACT, _AREA = 2, 24  # points along an edge of a face, of a shape's contact and of an area that ends within it
_FLUSH = 1e-4  # thicknesses between the rims of target and layer up to which the two are flush


class Interface(NamedTuple):
    """Where two layers of a pad meet."""

    height: float  # [thicknesses]
    singular: bool  # at free faces: two silicones meet


def interfaces(elastomer: Elastomer) -> tuple[Interface, ...]:
    """Return the interfaces of a pad from the ground up."""
    stack = elastomer.stack
    heights = (height / elastomer.thickness for height in elastomer.interfaces)
    pairs = zip(stack[:-1], stack[1:], strict=True)
    differ = [(a.silicone, a.free_stretch) != (b.silicone, b.free_stretch) for a, b in pairs]
    return tuple(map(Interface, heights, differ))


class Covering(NamedTuple):
    """A cover over its target [thicknesses of the pad]."""

    half_x: float  # half its sizes
    half_y: float
    rim: float  # height of the target
    thickness: float  # over the target

    @property
    def levels(self) -> tuple[float, float]:
        """Heights of the target's top and of the cover's."""
        return 1.0 + self.rim, 1.0 + self.rim + self.thickness


def covering(sensor: Sensor) -> Covering | None:
    """Return the cover of a scene, up to the pad's sides where no cell has room beside it; None without one."""
    cover, target, elastomer = sensor.cover, sensor.target, sensor.elastomer
    if cover is None or target is None or elastomer is None:
        return None
    t, pad = elastomer.thickness, elastomer.extent
    each = zip(cover.extent(target, elastomer), pad, strict=True)
    x, y = (widened(min(own, size) / (2.0 * t), size / (2.0 * t)) for own, size in each)
    return Covering(x, y, target.thickness / t, cover.thickness / t)


def press_on(sensor: Sensor, depth: float, top: Callable[[Covering, int], Surface]) -> Press | None:
    """Return what presses on a scene's cover with a depth of contact [thicknesses]; None without.

    `top` makes so many points along each edge of the faces of its top.
    """
    touch, cover, over = shape_on_cover(sensor), sensor.cover, covering(sensor)
    if touch is None or cover is None or over is None or sensor.elastomer is None:
        return None
    t, points = sensor.elastomer.thickness, _AREA if touch.shape == "pressure" else _CONTACT
    room = min(cover.thickness, touch.radius or math.inf) / t
    return Press(touch, top(over, _CONTACT), top(over, points), depth, over.levels[1], room, t)


@lru_cache(maxsize=8)
def top_points(mesh: MixedMesh, cover: Covering, count: int) -> Surface:
    """Return so many points on each edge of the top of a cover in section."""
    x, z = mesh.nodes.T
    line = np.flatnonzero(np.abs(z - cover.levels[1]) < 1e-9)
    return edge_points(mesh, [line[np.argsort(x[line])]], count)


class Pressed(NamedTuple):
    """What of a cover's top is pressed on about the axis [thicknesses of the pad]."""

    near: float = 0.0  # half the width that a round shape may meet, where cells are divided
    ends: tuple[float, ...] = ()  # where a flat one, or a pressure, ends: lines

    def among(self, breaks: Sequence[float]) -> list[float]:
        """Return lines with those ends that a cell has room beside."""
        return sorted([*breaks, *(end for end in self.ends if min(abs(end - each) for each in breaks) > _FLUSH)])


def pressed_part(sensor: Sensor) -> Pressed:
    """Return what of a cover's top is pressed on; nothing without.

    A round shape that is sunk by half its room d meets less than ``(2 R d)^(1/2)``.
    """
    touch, cover, over = shape_on_cover(sensor), sensor.cover, covering(sensor)
    if touch is None or cover is None or over is None or sensor.elastomer is None:
        return Pressed()
    t, half = sensor.elastomer.thickness, 0.5 * (touch.diameter or touch.width or 0.0)
    if touch.radius is None:
        edge = (half - (touch.edge_radius or 0.0)) / t
        return Pressed(ends=(-edge, edge) if 0.0 < widened(edge, over.half_x) < over.half_x else ())
    return Pressed(math.sqrt(touch.radius * min(cover.thickness, touch.radius)) / t)


def widened(half: float, half_layer: float) -> float:
    """Return half the size of a target or a cover; its layer's where no cell has room between [thicknesses]."""
    return half_layer if 0.0 < half_layer - half < _FLUSH else half


def layer_of_cells(sensor: Sensor, mesh: MixedMesh) -> Integers | None:
    """Return the number of the layer that each cell of a pad's mesh lies in, (e,), its cover's last; None of one."""
    elastomer = sensor.elastomer
    between = [] if elastomer is None else [each.height for each in interfaces(elastomer)]
    between += [1.0] if sensor.cover is not None else []
    return np.searchsorted(between, mesh.nodes[mesh.cells][..., -1].mean(axis=1)) if between else None


def laws_of(sensor: Sensor, of: Integers | None, guard: float = 0.0, apart: float = 0.0) -> Laws:
    """Return the laws of a pad's cells, `of` the layer of each.

    `guard` [shear moduli] is in the laws, a part of K of each at most; `apart` [those of the pad] acts elsewhere.
    """
    mu = 1.0 if sensor.elastomer is None else sensor.elastomer.shear_modulus
    return Laws(tuple(
        law_of(layer.silicone, guard, mu, layer.free_stretch**3, share=GUARD_SHARE, apart=apart)
        for layer in stack_of(sensor)
    ), of)
