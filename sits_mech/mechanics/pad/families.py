"""Meshes of a pad in space: families of levels, without and with a guard, without and with contact.

A base whose cells are divided, with further layers at the bonded edges (shapes.py), or a mesh of the user's (user.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np

from sits_mech.mechanics.element.prolongation import Prolongation, along_family
from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.levels.family import EARLY, Levels, Line, cache_changes, contact_depth, of_one_pad
from sits_mech.mechanics.pad.shapes import GRADING, cells_of, crosses
from sits_mech.mechanics.pad.solid import Solid, bonded_block, moved_block, pad_parts, pad_scales, pad_shape
from sits_mech.mechanics.pad.stack import PRESSED
from sits_mech.mechanics.pad.user import meshed_family, meshed_share
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Sensor

FINENESS = ((1, 0), (2, 0), (2, 1), (4, 0), (4, 1), (6, 1))
"""Parts of a base cell and further layers at edges, by level."""
_GUARDS = (0.0, 5.0)  # on J, in the order they are tried
_RESTED = 4  # levels for a load at finite strain; finer ones take minutes a load
_INSIDE = 3.0  # order away from the edges: of elements 4, seen of pressures on m = 1 to 4 in films and under discs
_SHARE = 0.25  # least error of a component over the worst one's: the tilt of a load near its P-Delta limit
_OPENS = 50.0  # times (sink/t)**2: what edges that a press opens add beyond their power, and as its error (family.py)
_WITHIN = 1.0  # times what two levels add sideways where the target's edge is within the face (family.py)
_LEAST = 0.03  # least edge's term on two levels, over the displacement: its parts may cancel (family.py)


def meshes_in_line(sensor: Sensor, tolerance: float, *, whole: bool) -> Line:
    """Return the families of meshes of a pad in the order they are tried.

    Raise ValueError for half a user's mesh where the whole pad is asked for.
    """
    target, elastomer = pad_parts(sensor)
    depths = {"never": (0.0,), "always": (PRESSED,), "auto": (0.0, PRESSED)}[elastomer.contact]
    if elastomer.mesh is not None:
        families, share = [partial(meshed_family, sensor, guard, _SHARE) for guard in _GUARDS], meshed_share(sensor)
        if whole and share < 1.0:
            raise ValueError(f"{elastomer.mesh}: must be of the whole pad under F_y, M_x or M_z; got half of it")
    else:
        families, share = [partial(_family, sensor, guard, whole) for guard in _GUARDS], 1.0 if whole else 0.5
    makers = [partial(family, depth) for depth in depths for family in families]
    return Line(sensor, pad_scales(sensor, share), makers, tolerance)


def pad_family(sensor: Sensor, *, whole: bool = False) -> tuple[Levels, float]:
    """Return the first family of meshes, without contact, of half a pad, or all; or a user's mesh; and its share."""
    _, elastomer = pad_parts(sensor)
    if elastomer.mesh is not None:
        return meshed_family(sensor, 0.0, _SHARE), meshed_share(sensor)
    return _family(sensor, 0.0, whole, 0.0), 1.0 if whole else 0.5


@of_one_pad
def _family(sensor: Sensor, guard: float, whole: bool, depth: float) -> Levels:
    """Make a family with or without a guard; coarser meshes have a larger contact depth."""
    shape = pad_shape(sensor)
    chosen = [each for each in FINENESS if not (each[1] and crosses(shape))]
    sizes, _ = zip(*chosen, strict=True)

    def made_of(scene: Sensor, level: int) -> Solid:
        """Make a level of a scene."""
        parts, more = chosen[level]
        own = contact_depth(depth, sizes, level)
        pressed = contact_depth(PRESSED, sizes, level)
        return bonded_block(scene, parts, GRADING, guard, own, whole=whole, layers=more, pressed=pressed)

    made = cache(partial(made_of, sensor))

    @cache
    def carrier(level: int) -> Prolongation | None:
        """Carry states from the level before."""
        coarse, fine = made(level - 1), made(level)
        if coarse.division is None or fine.division is None:
            return None
        return along_family(coarse.body.mesh, fine.body.mesh, (coarse.division, fine.division))

    def changed(other: Sensor, level: int) -> Bonded | None:
        """Make a level of a changed scene."""
        own, (parts, more) = made(level).body, chosen[level]
        if not own.parts:
            return moved_block(own, other, (parts, GRADING, more), guard)
        body = made_of(other, level).body
        return body if np.array_equal(body.mesh.cells, own.mesh.cells) else None

    def cells(level: int) -> tuple[int, ...]:
        """Return the cells along each axis."""
        parts, more = chosen[level]
        along, across, through = cells_of(shape, parts, GRADING, more)
        return along, (2 if whole else 1) * across, through

    sideways = EARLY if shape.flush or crosses(shape) else _WITHIN
    return Levels(
        terms_of(chosen, shape.exponent), cells, lambda level: made(level).body, carrier, _SHARE,
        cache_changes(changed), _RESTED, _OPENS, sideways, _LEAST, shape.flush
    )


def terms_of(fineness: Sequence[tuple[int, int]], exponent: float) -> Array:
    """Return the terms of levels at edges, by the displacements' exponent there, and away from them: `Levels.terms`."""
    split, layers = np.array(fineness, dtype=float).T
    return np.column_stack([(split * 2.0**layers) ** (-2.0 * GRADING * exponent), split**-_INSIDE])
