"""Layers of a pad in its meshes: lines at their interfaces, and the law of each cell.

Layers lie at heights from z_0 = 0 to z_n = 1, in thicknesses of the pad. No cell crosses an interface, so that the laws
of a mesh are constant in each cell (element/kernel.py). Where an interface of two silicones meets a free face strains
are singular: its displacements go as ``r**k``, k from 1 of one silicone to that of a clamped corner, 0.5946, where one
is far stiffer, so that lines closer to the interface from both sides, as at a clamped corner, keep the order of the
pad's meshes (shapes.py). An interface within one silicone is not singular and has a line alone.

Source: D. B. Bogy, J. Appl. Mech. 38 (1971) 377, corners of two bonded media.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.kernel import Laws, law_of
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.quantities import Integers
from sits_mech.scene.sensor import Elastomer

GUARD_SHARE = 0.005
"""Of the bulk modulus that may act pointwise."""


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


def layer_of_cells(elastomer: Elastomer, mesh: MixedMesh) -> Integers | None:
    """Return the number of the layer that each cell of a pad's mesh lies in, (e,); None where there is one."""
    between = [each.height for each in interfaces(elastomer)]
    return np.searchsorted(between, mesh.nodes[mesh.cells][..., -1].mean(axis=1)) if between else None


def laws_of(elastomer: Elastomer, of: Integers | None, guard: float = 0.0, apart: float = 0.0) -> Laws:
    """Return the laws of a pad's cells, `of` the layer of each.

    `guard` [shear moduli] is in the laws, a part of K of each at most; `apart` [those of the pad] acts elsewhere.
    """
    return Laws(tuple(
        law_of(layer.silicone, guard, elastomer.shear_modulus, layer.free_stretch**3, share=GUARD_SHARE, apart=apart)
        for layer in elastomer.stack
    ), of)
