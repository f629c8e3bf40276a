"""Which meshes does a tolerance ask of the planar layer, and in which order are they tried?

Small strain wants a strong grading towards the singular corners. At finite strain the corners open, which
cells split into triangles follow (fan.py). So several pairs of meshes stand in line, each tougher and a little less
accurate than the one before: strongly graded; with split corners; mildly graded; with a guard on J; even, with a
stronger guard. For a tolerance of 1e-3 the unguarded split ones stand there half as fine again, too, as far as they
have no more than 7,500 unknowns. The guarded ones only follow where the others do not arrive.

What a pair's difference says about the error of its finer mesh rests on the order of convergence. Graded whole corners
converge at small strain as h^2 or better, and 1.5 is on the safe side. Where corners open, the free face at the edge of
the target is compressed and creases, which ever finer cells follow further: from 8 to 12 and from 12 to 16 cells the
sink of a 20/15/2 mm layer under 1810 N/m grows by 1.7e-3 and 0.85e-3 (graded 1.5; by 1.9e-3 and 1.1e-3 graded 2.0), its
tilt under 1.75 N m/m by 2.5e-3 and 1.4e-3 (graded 2.5 by 1.8e-3 and 0.76e-3). That is order one, and all split meshes
are taken to have it: the sharp edge is what keeps such loads at some 3e-3. A crease that contact closes costs less: the
sink of a flush 15/3 mm layer under 709 N/m changes by 1.1e-4 from 12 to 16 cells.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.pad.section import Fineness, bonded_body, layer_scales
from sits_mech.mechanics.rest.pairs import Pair
from sits_mech.mechanics.rest.retry import Line
from sits_mech.scene.sensor import Sensor
from sits_mech.units import checked_tolerance

STRONG = 2.5
"""Grading towards the corners for small strain."""

_MILD = 1.5
_DEPTH = 1e-5  # thicknesses over which the pressure of contact builds up
_SHARE = 0.05  # of the worst component's error that every component owns to
_MOST = 7500  # unknowns of a mesh that is finer than its neighbours in the line
_LENIENCE = 2.0  # the estimate is on the safe side: up to so many tolerances no other mesh is tried
_SMALLEST = (1e-3, 0.02, 0.25)  # increment of the load path: no mesh waits, one does, more do
_EFFECT = 0.01  # of the displacement: what contact may be worth and still be left out


class _Kind(NamedTuple):
    """Grading, whether corners are split, guard, order that the error is extrapolated with, how much finer."""

    grading: float
    split: bool
    guard: float
    order: float
    finer: float = 1.0


_SHARP, _SPLIT = _Kind(STRONG, False, 0.0, 1.5), _Kind(STRONG, True, 0.0, 1.0)
_TOUGH = _Kind(_MILD, True, 0.0, 1.0)
_FINE_SPLIT, _FINE_TOUGH = _SPLIT._replace(finer=1.5), _TOUGH._replace(finer=1.5)
_GUARDED, _EVEN = _Kind(_MILD, True, 0.5, 1.0), _Kind(1.0, True, 5.0, 1.0)
# Asked error of the pose -> cells through the thickness, fine and coarse; meshes in the order they are tried.
_LADDER: tuple[tuple[float, tuple[tuple[int, int], tuple[_Kind, ...]]], ...] = (
    (2e-2, ((4, 2), (_TOUGH, _GUARDED))),
    (1e-2, ((6, 4), (_TOUGH, _GUARDED))),
    (1e-3, ((8, 4), (_SHARP, _SPLIT, _FINE_SPLIT, _TOUGH, _FINE_TOUGH, _GUARDED))),
    (1e-4, ((14, 8), (_SHARP, _SPLIT, _TOUGH, _GUARDED))),
)


def cells_through(tolerance: float) -> tuple[int, int]:
    """Return the cells through the thickness, fine and coarse, for an asked error of the pose."""
    return _rung(tolerance)[0]


def meshes_in_line(sensor: Sensor, tolerance: float) -> Line:
    """Return pairs of meshes in the order they are tried.

    Without contact they end with a guarded even one; in "auto" the same split ones once more with contact,
    and that even one with it. Layers with fillets have no sharp corners to resolve.
    """
    cells, kinds = _rung(tolerance)
    elastomer = sensor.elastomer
    contact = elastomer.contact if elastomer is not None else "never"
    kinds = kinds if elastomer is None or elastomer.edge_radius is None else tuple(kind for kind in kinds if kind.split)
    kinds = tuple(kind for kind in kinds if kind.finer == 1.0 or _fits(sensor, cells, kind))
    last = (*(kind for kind in kinds if kind.split), _EVEN)
    tried = {"always": [(kind, _DEPTH) for kind in last], "never": [(kind, 0.0) for kind in (*kinds, _EVEN)]}.get(
        contact, [*((kind, 0.0) for kind in kinds), *((kind, _DEPTH) for kind in last)]
    )
    twins = tuple(len(kinds) + last.index(kind) if kind in last else None for kind in kinds)
    makers = [partial(_pair, sensor, cells, kind, depth) for kind, depth in tried]
    makers[0]()  # refuses a scene that has no mesh
    twins = twins if contact == "auto" else (None,) * len(tried)
    return Line(sensor, layer_scales(sensor), makers, twins, _SMALLEST, _LENIENCE * tolerance, _EFFECT)


def _fits(sensor: Sensor, cells: tuple[int, int], kind: _Kind) -> bool:
    """Say whether the finer mesh of a kind has no more unknowns than one is given."""
    return len(_pair(sensor, cells, kind, 0.0).fine.free) <= _MOST


def _pair(sensor: Sensor, cells: tuple[int, int], kind: _Kind, depth: float) -> Pair:
    """Two meshes of one kind; the coarse one has twice the contact depth."""
    fine, coarse = (
        bonded_body(sensor, Fineness(round(kind.finer * count), kind.grading, kind.split, kind.guard, soft * depth))
        for count, soft in zip(cells, (1.0, 2.0), strict=True)
    )
    ratio = np.sqrt(len(fine.mesh.cells) / len(coarse.mesh.cells)) ** kind.order
    return Pair(fine, coarse, 0.0, float(1.0 / (ratio - 1.0)), _SHARE)


def _rung(tolerance: float) -> tuple[tuple[int, int], tuple[_Kind, ...]]:
    """Cells through the thickness, and kinds of meshes, for a tolerance."""
    checked_tolerance(tolerance)
    return next((rung for error, rung in _LADDER if tolerance >= error), _LADDER[-1][1])
