"""Divide a permeable plate's surface: how finely, by the field that it sees, and what that takes.

Of windings at a distance d, whose field changes over a length l, the slope bends at their ends by 1/l within d. Linear
functions on cells h long are h^2/(l d) off there: the finer cells follow sqrt(l d). Only where they are about as short
as d do two divisions show it; else the estimated error grows like (h/d)^2.

At a thick rim the potential goes like r^q, q from 2/3: what cells there leave falls like h^(2 q) only. Of that alone,
by the best slopes, two divisions leave 0.7 to 0.8 of the stated error where the cells at the rim are a tenth of the
largest, 1.1 to 1.3 at a fifth, 1.9 to 2.2 at two fifths. What the middle leaves may cancel it in the step, that of half
a height in 2 and 4 cells above all, 2e-3 to 3e-3 of the energy at its edge: of ferrite 0.4 mm thick twice the stated
error. In 4 and 8 cells it is 5e-4 to 1.3e-3, and 0.3 to 0.8 of what is stated.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sits_mech.geometry.sheet_plan import CellPlan, Grading, disc_plan, graded_axis, rectangle_plan
from sits_mech.magnetics.coils.ring_field import check_straight
from sits_mech.magnetics.permeable.shells import HalfSurface, shell_classes, surface
from sits_mech.magnetics.space.divisions import target_plan
from sits_mech.magnetics.space.rungs import PlateRung, TooLarge
from sits_mech.magnetics.space.sources import Sources
from sits_mech.memory import GIB, MEMORY, beyond_memory, check_seconds
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil, Conductor, Target

_ALONG = Grading(first=0.4, growth=3.0, largest=1.0)  # first over the thickness, largest over the field's length
_LEVELS = {"smooth": (4, 2), "outline": (3, 2)}  # parts of the cells of two divisions, the finer first
_LEFT = 1.0, 0.2  # estimated error over what is extrapolated, of outlines and of smooth maps
_MIDDLE, _PER_DIGIT = 8.0, 0.2  # digits of a rung, by which cells shrink
_SHOWN = 2.5  # cells over d from which (h/d)^2 counts: 0.026 of it were missed at most of the step
_WIDEST, _RIM = 0.25, 0.1  # the largest over the half width, of rings their breadth; that at the rim over it, at most
_SECTORS, _MORE = 32, 3  # of a disc on the coarser division, and at most times as many where it is wide
_PAIR, _CUBE = 6e-7, 6e-10  # s that two triangles take, and a class, over its triangles' cube
_FEW, _UNBOUNDED = 3, 1e9  # cells along the longer half side of a plate far away; its permeability


def divided_surfaces(
    plate: Target, rung: PlateRung, scale: tuple[float, tuple[float, float], float], sources: Sources | None
) -> tuple[list[HalfSurface], tuple[int, ...], float]:
    """Return two divisions of a plate's surface, the finer first, their cells' parts, and the error over the last step.

    `scale` is the distance to the coils, how far from the middle these call for small cells, and the length on which
    their field changes [m]. TooLarge where they do not fit, SceneError where they take too long.
    """
    (distance, (reach, far), length), smooth = scale, plate.shape != "outline"
    half, finest = min(plate.extent) / 2, math.exp(_PER_DIGIT * (_MIDDLE - rung.terms))
    counts = _LEVELS["smooth" if smooth else "outline"]
    finer = counts[1] / counts[0]
    whole = min(_ALONG.largest * length, math.sqrt(length * distance) / finer, _WIDEST * half) * finest
    largest = min(whole, _WIDEST * (half - plate.hole / 2) * finest)
    first = min(_ALONG.first * plate.thickness, _RIM * largest)
    along = replace(_ALONG, first=first, largest=largest, reach=reach, far=far)
    plans = _plans(plate, along, counts, whole)
    heights = replace(_ALONG, first=first, largest=plate.thickness / 4)
    surfaces = [surface(plan, graded_axis(plate.thickness / 2, heights.coarser(counts[1], parts)))
                for plan, parts in zip(plans, counts, strict=True)]
    _check(surfaces[0], sources)
    return surfaces, counts, _LEFT[smooth] * max(1.0, finer * largest / (_SHOWN * distance)) ** 2


def _plans(plate: Target, along: Grading, counts: tuple[int, ...], whole: float) -> list[CellPlan]:
    """Return the divisions of a plate's face; a disc's angular orders go by the coarser one's sectors.

    Sectors go by the largest cell of a `whole` disc [m]. What a polygon leaves is over a ring's breadth b, like
    R / (b n^2): n is multiplied by sqrt(R / b). Orders do not need that where the coils stay within the hole.
    """
    sizes, orders = [along.coarser(counts[1], parts) for parts in counts], 0
    if plate.is_round:
        wide = math.pi * min(plate.extent[0] / 2, along.reach) / (_SECTORS / 2 * whole)
        more = int(np.clip(math.ceil(wide), 1, _MORE))
        turns = min(_MORE, more * round(math.sqrt(plate.extent[0] / (plate.extent[0] - plate.hole))))
        own = (1, turns) if plate.hole else (more, 1)  # a ring's breadth may hold no more than two cells
        sizes = [replace(along.coarser(own[0] * counts[1], own[0] * parts), turns=own[1]) for parts in counts]
        sectors = len(disc_plan(plate.extent[0], sizes[1], orders=0, inner=plate.hole).group)
        orders = sectors // (2 if along.far > plate.hole / 2 else 2 * own[1]) - 1
    return [target_plan(plate, each, orders) for each in sizes]


def _check(part: HalfSurface, sources: Sources | None) -> None:
    """Refuse a surface whose matrices do not fit, or take too long."""
    t, n, images, classes = len(part.triangles), len(part.nodes), len(part.images), 2 * len(part.plan.characters)
    complex_too = 1 + np.iscomplex(part.plan.characters).any()
    needed = 8.0 * (images * (t * t + t * n + n * n) + complex_too * (6.0 * t * t + 12.0 * classes * n * n)) + 1e8
    if beyond := beyond_memory(needed):
        text = f"memory: the surface of a permeable plate in {t * images} triangles takes {beyond}"
        size = {name: 2e3 * float(np.abs(part.nodes[:, k]).max()) for k, name in enumerate(("width", "length"))}
        raise TooLarge(text, {"cells": float(t * images), **size, "needed": needed, "limit": MEMORY.get() * GIB})
    what = f"sheets: the surface of a permeable plate in {t * images} triangles"
    check_seconds(_PAIR * images * t * t + _CUBE * classes * complex_too * t**3, what)
    if sources is not None:
        check_straight(sources.coils, sources.windings, sources.distance, part.points[0].size // 3)


def added_inductance(plate: Target | Conductor, coils: tuple[Coil, ...], middle: tuple[float, float, float]) -> Array:
    """Return what a plate of unbounded permeability, or a rectangle around it, adds to each self-inductance [H].

    In few even cells: some percent less than in finer ones, of plates no nearer to the coils than they are wide.
    """
    half = np.array([*plate.extent, plate.thickness]) / 2
    size = float(half[:2].max()) / _FEW
    part = surface(rectangle_plan(*plate.extent, Grading(size, 1.0 + 1e-6, size)), np.array([0.0, half[2]]))
    points, sources = part.points[0], Sources(coils, "rings", middle, float(half.max()))
    loads = part.loads(sources.potential(points.reshape(-1, 3)).reshape(*points.shape, -1))
    found = np.zeros(len(coils))
    for own in shell_classes(part):
        b = own.projected(loads)
        found += np.einsum("fc,fc->c", b, own.response(_UNBOUNDED * own.inner) @ b)
    return found
