"""From all six components of a wrench to all six of the pose: the whole pad in three dimensions.

The pad is that of block.py: both halves of it, the same elements, two meshes, the same extrapolation; where a mesh does
not carry a load, one with a guard on J is tried. How it comes to rest: full_newton.py. Contact (block_contact.py) as
there: from the rest without it where a free face folds, or else along a path of its own; where neither gets there, the
answer is that without contact, and its error the whole displacement. Range: boxes and cylinders under rectangles and
discs, and whole meshes of the user's. Components follow the right hand; ``M_y > 0`` turns clockwise in the x-z picture,
like `M`.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from skfem import MeshHex, MeshHex2
from skfem.assembly import Dofs

from sits_mech.geometry.turns import rotation_vector
from sits_mech.mechanics.answer import law_notes, load_words
from sits_mech.mechanics.block_folds import LEFT_OUT, fold_notes, solid_folds
from sits_mech.mechanics.block_forms import BRICK, solid_mesh
from sits_mech.mechanics.block_mesh import (
    Solid,
    bonded_block,
    box_lines,
    edge_notes,
    flush,
    outlines,
    pad_parts,
    shares,
    solid,
    within,
)
from sits_mech.mechanics.block_user import meshed_pad
from sits_mech.mechanics.forms import Section
from sits_mech.mechanics.full_newton import Way, eased, followed
from sits_mech.mechanics.path import REASONS
from sits_mech.meshing.bricks import Outline, box_bricks
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.sensor import Sensor
from sits_mech.threads import one_thread

_LADDER = ((1e-2, (2, 1)), (0.0, (3, 2)))  # asked error of the pose -> cells through the thickness, fine and coarse
# Grading towards the target's edge and guard on J, in the order they are tried; the first not for flush pads.
_KINDS = ((2.0, 0.0), (1.5, 0.0), (2.0, 5.0))
_PATIENCE = (0.2, 1e-2)  # smallest increment of the load where another mesh waits, and where none does
_SHARE = 0.25  # of the worst component's error that every component owns to
_ORDER = np.array([0, 3, 1, 4, 2, 5])  # of the components of a wrench or a pose along x, y, z, and about them
_GIVE = 1e-4  # thicknesses over which the pressure of contact builds up


@one_thread
def whole_equilibrium(sensor: Sensor, wrench: Wrench, tolerance: float = 1e-2) -> Equilibrium:
    """Return where a pad's target rests under all six components of a load.

    Parameters
    ----------
    sensor : Sensor
        With a rectangle or a disc on a box, a cylinder or a whole mesh of elastomer.
    wrench : Wrench
        [N, N m].
    tolerance : float
        Asked error of the pose; two rungs, 1 % and what is finer.

    Raises
    ------
    ValueError
        For another scene, or a load that is not finite.
    SolveFailed
        If the load cannot be reached.
    """
    began = time.perf_counter()
    target, elastomer = pad_parts(sensor)
    t, mu = elastomer.thickness, elastomer.silicone.shear_modulus
    forces = wrench.components[_ORDER]
    if not np.all(np.isfinite(forces)):
        raise ValueError(f"wrench: must be finite numbers, got {load_words(vars(wrench))}")
    load = forces * [1.0, 1.0, -1.0, 1.0 / t, 1.0 / t, 1.0 / t] / (mu * t**2)
    found = _rested(sensor, load, next(cells for least, cells in _LADDER if tolerance >= least))
    if found.reached < 1.0:
        raise _ended(sensor, wrench, found, time.perf_counter() - began)
    pad, fine = found.pads[0], found.ways[0].place
    places = [np.concatenate([way.place.c * t, rotation_vector(way.place.R)]) for way in found.ways]
    apart = places[0] - places[1]
    lever = np.repeat([1.0, float(max(target.extent)) / 2.0], 3)
    added, owned = shares(*found.pads)
    best, at_end = places[0] + added * apart, owned * np.abs(apart) * lever
    size = float(np.max(np.abs(best) * lever))
    at_end = np.maximum(at_end, size if found.left_out else _SHARE * at_end.max())
    error = float(at_end.max()) / size if size > 0.0 else 0.0
    seen = fold_notes(pad, fine.u, fine.c, fine.R, target.thickness / t)
    notes = (*law_notes(sensor, pad.body, fine.u), *seen, *edge_notes(sensor))
    if found.left_out:
        notes = (*notes, LEFT_OUT)
    if error > tolerance:
        notes = (*notes, f"the estimated error is above the tolerance {tolerance:g}")
    report = SolveReport(
        "block", len(pad.body.free) + 6, sum(way.place.iterations for way in found.ways), fine.residual, error,
        time.perf_counter() - began, notes=notes, min_J=fine.min_J,
    )
    back = np.argsort(_ORDER)
    best[2] += elastomer.standoff + t
    return Equilibrium(wrench, Pose.of(best[back]), Pose.of((at_end / lever)[back]), np.zeros(0), report)


def whole_block(sensor: Sensor, cells: int, grading: float, guard: float, give: float = 0.0) -> Solid:
    """Return both halves of a box or a cylinder with its target, meshed and scaled; arguments as of `bonded_block`."""
    target, elastomer = pad_parts(sensor)
    plate, pad = outlines(target, elastomer)
    if plate.is_round or pad.is_round:
        half = bonded_block(sensor, cells, grading, guard)
        mesh, fineness = both_halves(half.body.mesh), half.fineness
    else:
        x, _, z = box_lines(plate, pad, cells, grading)
        turned = [Outline(own.half_y, own.half_x, own.is_round) for own in (plate, pad)]
        y, *_ = box_lines(turned[0], turned[1], cells, grading)
        mesh, fineness = box_bricks(x, y, z), len(z) - 1.0
    section, basis = solid_mesh(mesh, BRICK)
    height = section.nodes[:, 2]
    top = np.logical_and(height > 1.0 - 1e-9, within(plate, section.nodes, 1e-9))
    where = np.stack([height < 1e-9, top, np.zeros_like(top)])
    return solid(sensor, section, where, (guard, fineness), basis, give)


def both_halves(half: Section) -> MeshHex2:
    """Return a mesh of 27-node bricks on y >= 0 with its mirror image, whose bricks are numbered alike."""
    corners, place = half.cells[:, :8], half.nodes[half.cells]
    points = half.nodes[: corners.max() + 1]
    own = points[:, 1] > 1e-9
    image = np.where(own, len(points) - 1 + np.cumsum(own), np.arange(len(points)))
    flip = np.array([1.0, -1.0, 1.0])
    whole = MeshHex2.from_mesh(
        MeshHex(np.vstack([points, points[own] * flip]).T, np.vstack([corners, image[corners]]).T)
    )
    nodes = whole.doflocs.copy()
    nodes[:, Dofs(whole, BRICK).element_dofs.T] = np.moveaxis(np.concatenate([place, place * flip]), -1, 0)
    return MeshHex2(nodes, whole.t)


class _Rest(NamedTuple):
    """A fine and a coarse pad, how far each was followed, of what kind they are; whether contact is left out."""

    pads: tuple[Solid, Solid]
    ways: tuple[Way, Way]
    kind: tuple[float, float]
    left_out: bool = False

    @property
    def reached(self) -> float:
        """How much of the way to the load both got."""
        return min(way.reached for way in self.ways)


def _rested(sensor: Sensor, load: Array, cells: tuple[int, int]) -> _Rest:
    """The pad at rest, or the last rest on the way to a load; with contact where it counts."""
    _, elastomer = pad_parts(sensor)
    if elastomer.contact == "always":
        return _carried(sensor, load, cells, _GIVE)
    free = _carried(sensor, load, cells, 0.0, waits=elastomer.contact == "auto")
    if elastomer.contact == "never" or not _touches(free):
        return free
    if free.reached == 1.0:
        pads = _pads(sensor, cells, free.kind, _GIVE)
        fine, coarse = (eased(pad, way.place, load) for pad, way in zip(pads, free.ways, strict=True))
        if fine.reached == coarse.reached == 1.0:
            return _Rest(pads, (fine, coarse), free.kind)
    held = _carried(sensor, load, cells, _GIVE)
    if held.reached < 1.0 and free.reached < 1.0:
        free = _carried(sensor, load, cells, 0.0)
    return held if held.reached >= free.reached else free._replace(left_out=True)


def _carried(sensor: Sensor, load: Array, cells: tuple[int, int], give: float, waits: bool = False) -> _Rest:
    """The first kind of meshes that carries a load, or else the farthest; where contact waits, the first that folds."""
    target, elastomer = pad_parts(sensor)
    kinds = _KINDS[1:] if elastomer.mesh is not None or flush(*outlines(target, elastomer)) else _KINDS
    found: list[_Rest] = []
    for kind in kinds:
        patience = _PATIENCE[kind is kinds[-1]]
        fine, coarse = pads = _pads(sensor, cells, kind, give)
        first = followed(coarse, load, patience)
        if first.reached < 1.0:
            found.append(_Rest((coarse, coarse), (first, first), kind))
        else:
            found.append(_Rest(pads, (followed(fine, load, patience), first), kind))
        if found[-1].reached == 1.0 or (waits and _touches(found[-1])):
            return found[-1]
    return max(found, key=lambda rest: rest.reached)


def _touches(found: _Rest) -> bool:
    """Whether a free face lies on or behind ground or target."""
    place = found.ways[0].place
    return solid_folds(found.pads[0], place.u, place.c, place.R).touch


def _pads(sensor: Sensor, cells: tuple[int, int], kind: tuple[float, float], give: float) -> tuple[Solid, Solid]:
    """Two pads of one kind; the coarse one gives over twice the length."""
    if sensor.elastomer is None or sensor.elastomer.mesh is None:
        return whole_block(sensor, cells[0], *kind, give), whole_block(sensor, cells[1], *kind, 2.0 * give)
    pads = meshed_pad(sensor, kind[1], give)
    if pads[0].share < 1.0:
        raise ValueError(f"{sensor.elastomer.mesh}: must be of the whole pad under F_y, M_x or M_z; got half of it")
    return pads


def _ended(sensor: Sensor, wrench: Wrench, found: _Rest, seconds: float) -> SolveFailed:
    """Return what says where a load path ended, and why."""
    pad, way = found.pads[0], found.ways[0]
    place, part = way.place, f"{found.reached:.1%} of the path"
    why = (*law_notes(sensor, pad.body, place.u), REASONS[way.reason])
    report = SolveReport(
        "block", len(pad.body.free) + 6, place.iterations, place.residual, np.inf, seconds, "load path ended",
        notes=(*why, f"reached {part}"), min_J=place.min_J,
    )
    reached = {name: found.reached * value for name, value in vars(wrench).items()}
    moved = 1e3 * pad_parts(sensor)[1].thickness * place.c
    shift, turn = (", ".join(f"{x:.5f}" for x in own) for own in (moved, rotation_vector(place.R)))
    message = (
        f"wrench: the pad could be followed to {load_words(reached)} ({part}), not to {load_words(vars(wrench))}; "
        f"there the target had moved by {shift} mm and turned by {turn} rad (x, y, z), smallest volume ratio "
        f"{place.min_J:.3g}; {'; '.join(why)}"
    )
    return SolveFailed(message, report)
