"""What do the free faces of a pad do in three dimensions: lie on the ground, rise at the target, touch themselves?

As in the plane (folds.py): where contact is solved, a face lies on its plane within the length over which the contact
gives; where it is not, it may have gone through. Self-contact and the target's top face are solved nowhere: they are
found here, and named.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sits_mech.mechanics.block_contact import SolidContact
from sits_mech.mechanics.block_forms import solid_deformation
from sits_mech.mechanics.block_mesh import Solid, within
from sits_mech.mechanics.folds import Folds, fold_words
from sits_mech.mechanics.self_contact import crosses_itself, is_monotone
from sits_mech.quantities import Array

LEFT_OUT = "contact could not be followed to this load: the estimated error is the whole displacement"
"""What is said of an answer without the contact that it needs."""

_SEEN = 1e-6  # thicknesses behind a plane that count
_PRESSED = 1e-14  # energy of a contact that counts [shear modulus times thickness cubed]


def solid_folds(solid: Solid, u: Array, centre: Array, turn: Array) -> Folds:
    """Return where the free faces of a deformed pad are, but whether they touch themselves.

    Parameters
    ----------
    solid : Solid
    u : ndarray, shape (3 n,)
        Nodal displacements [thicknesses].
    centre, turn : ndarray, shape (3,) and (3, 3)
        How far the target's centre moved [thicknesses], and its rotation.
    """
    place = solid.body.mesh.nodes + u.reshape(-1, 3)
    seen = (place - centre - (0.0, 0.0, 1.0)) @ turn
    above = seen[:, 2] > _SEEN
    sides = np.setdiff1d(solid.faces, solid.under)
    inside = np.logical_and(within(solid.target, seen[sides], -_SEEN), above[sides])
    behind = {
        "ground": bool(np.any(place[solid.faces, 2] < -_SEEN)),
        "plane": bool(np.any(above[solid.under])),
        "wall": bool(np.any(inside)),
    }
    for part in solid.body.parts:
        if isinstance(part, SolidContact):
            behind[part.plane] |= part.push(u, centre, turn).energy > _PRESSED
    rise = float(seen[sides][inside, 2].max()) if np.any(inside) else 0.0
    return Folds(behind["ground"], behind["plane"], behind["wall"], rise, itself=False)


def fold_notes(solid: Solid, u: Array, centre: Array, turn: Array, plate: float) -> tuple[str, ...]:
    """Return sentences about the free faces under a target of thickness `plate`; the others as of `solid_folds`."""
    solved = any(isinstance(part, SolidContact) for part in solid.body.parts)
    found = replace(solid_folds(solid, u, centre, turn), itself=_crosses(solid, u))
    return fold_words(found, plate, solved)


def _crosses(solid: Solid, u: Array) -> bool:
    """Whether free faces pass through one another."""
    if solid.convex and is_monotone(solid_deformation(solid.body.mesh, u)[0]):
        return False
    plane = min(0.0, float(solid.body.mesh.nodes[:, 1].min())) if solid.share < 1.0 else -np.inf
    return crosses_itself(solid.skin, solid.body.mesh.nodes + u.reshape(-1, 3), plane)
