"""Move several rigid targets that are bonded on one pad, at small strain.

About the undeformed state the motions of n targets and the wrenches on them are one linear system,

    q_i = sum_j C_ij f_j,      C = (T^T K T)^-1,      C_ij = C_ji^T,

K the stiffness that is left when all displacements but the bonded ones are eliminated, T = du_bonded/dq, six columns a
target (element/target.py). C_ij with i != j is what the silicone carries from cell to cell: what a press pushes out
under the sides of a target lifts those around it, by 11 % of its sinking half a thickness away, by 2 % two thicknesses.

Mesh: a tensor grid on the box (pad/cell_lines.py), of which the cells in slots and beside a cover are left out. Its
levels are those of one pad (pad/families.py): one target in the middle has the same mesh. A wall's faces are held as
the ground is. Unknowns: displacements of the whole pad [thicknesses]. Error: of the levels' limit (levels/family.py).

Neglected: finite strain, whose first correction `softening` returns; contact of free faces. A load by which the faces
of a slot come together by its width, by their motion at small strain, is more than one compliance holds for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from sits_mech.geometry.meshing.bricks import PlateOutline, box_bricks
from sits_mech.geometry.meshing.inclusion import hollowed
from sits_mech.mechanics.cells.pressed import Level, followed, touch_forces
from sits_mech.mechanics.cells.spread import Spread, spreads
from sits_mech.mechanics.element.mesh import BRICK, solid_mesh
from sits_mech.mechanics.element.target import bonded_tangent, work_of_load
from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.levels.family import Levels
from sits_mech.mechanics.levels.refine import refinements
from sits_mech.mechanics.pad.cell_lines import ONE, cell_lines, in_slots, inside_of, scaled_ends
from sits_mech.mechanics.pad.families import FINENESS, terms_of
from sits_mech.mechanics.pad.solid import numbered, pad_scales, solid
from sits_mech.mechanics.pad.stack import covering
from sits_mech.quantities import Array, Mask, Wrench
from sits_mech.scene.cells import Cells
from sits_mech.threads import one_thread
from sits_mech.units import checked_tolerance


@dataclass(frozen=True, eq=False)
class CellsPad:
    """The compliances of several targets on one pad, and what a touch does; made by `cells_pad`."""

    cells: Cells
    levels: Levels
    compliances: tuple[Array, ...]
    """Of each level d(pose)/d(wrench), (n, 6, n, 6), in the order of `Pose` and `Wrench` [m, rad per N, N m]."""
    moved: tuple[Array, ...]
    """Of each level the change of the poses by the scene's touch, (n, 6) [m, rad]: none without a force."""
    spread: Array
    """What other ways in which the touch may lie on silicone change of it, (n, 6)."""
    second: Array
    """What Newton's second step adds to it, (n, 6): finite strain to first order; infinite where it is not bounded."""

    @one_thread
    def softening(self, F_z: float) -> float:
        """Return Newton's second step of how far a press [N] moves a cell, over the first one; the largest of all."""
        kinds = sorted(set(self.cells.kinds))
        each = [(first[k, 1], more[k, 1]) for k in kinds for first, more in [self.steps(k, Wrench(F_z=F_z))]]
        return max(float(abs(more / first)) for first, more in each)

    @one_thread
    def steps(self, k: int, wrench: Wrench) -> tuple[Array, Array]:
        """Return Newton's first and second step of the poses under a wrench on cell k, (n, 6), on the coarsest mesh."""
        level, n, scales = self._coarse, len(self.cells.targets), pad_scales(self.cells.sensor, 1.0)
        P, none = np.zeros((n, 6)), np.zeros(level.body.mesh.nodes.size)
        P[k] = work_of_load(scales.load(wrench), self.cells.plates[k].load_height / scales.thickness, np.zeros(6))
        q = level.flexibility @ P.ravel()
        more = _second(self.cells, level, level.displaced(q, none), P.ravel(), none)
        first, second = (part.reshape(n, 6) * scales.lengths for part in (q, more))
        return first, second

    @cached_property
    def _coarse(self) -> Level:
        """The coarsest mesh, factored."""
        return cells_level(self.cells, self.levels.coarse)


@one_thread
def cells_pad(
    cells: Cells, tolerance: float = 1e-2, force: float | None = None, seen: Array | None = None,
    most: int = len(FINENESS),
) -> CellsPad:
    """Return the compliances of a scene's targets, and how its touch by a force [N] moves these.

    Levels are added until the targets' own compliances are exact to `tolerance`, or what is `seen` (..., n, 6) of their
    motions by the touch, of the largest, or there are as many as `most`. Raise ValueError where memory does not
    hold two levels, and as `spreads`.
    """
    asked, levels = checked_tolerance(tolerance), _levels(cells)
    scales, ways = pad_scales(cells.sensor, 1.0), [] if force is None else spreads(cells, force)
    scale = scales.thickness, (force or 0.0) / scales.force
    own = (cells_level(cells, levels.maker(level)) for level in range(len(levels)))
    for found in refinements(levels, (_measured(cells, each, ways, scale, k == 0) for k, each in enumerate(own)), most):
        if _relative_error(levels, found, force is not None, seen) <= asked:
            break
    compliances, moved, spread, more = zip(*found, strict=True)
    return CellsPad(cells, levels, compliances, moved, spread[-1], more[0])


def _measured(
    cells: Cells, own: Level, ways: Sequence[Spread], scale: tuple[float, float], first: bool
) -> tuple[Array, ...]:
    """Return compliance, the poses' change, what other ways do to it, and on the first level the second step."""
    n, f = len(cells.targets), [touch_forces(own, way, *scale) for way in ways]
    each = np.array([own.flexibility @ own.work(part) for part in f] or np.zeros((1, 6 * n)))
    q, more = each[0], np.zeros(6 * n)
    if first and ways:
        u = own.displaced(q, f[0])
        more = _second(cells, own, u, 0.0 * q, followed(own, u, cells.touched, ways[0], scale))
    found = q, np.abs(each - q).max(axis=0), more
    lengths = pad_scales(cells.sensor, 1.0).lengths
    return _compliance(cells, own), *(part.reshape(n, 6) * lengths for part in found)


def _second(cells: Cells, level: Level, u: Array, P: Array, f: Array) -> Array:
    """Return Newton's second step of all motions, as `Level.second`; infinite where u closes a slot."""
    mesh, t = level.body.mesh, cells.pad.thickness
    for slot in cells.slots:
        sides = [np.abs(mesh.nodes[:, slot.axis] - end) < 2.0 * ONE for end in slot.ends / t]
        low, high = (u.reshape(-1, 3)[on, slot.axis] for on in sides)
        if low.max() - high.min() > slot.width / t:
            return np.full_like(P, np.inf)
    return level.second(u, P, f)


def _relative_error(levels: Levels, found: Sequence[tuple[Array, ...]], touched: bool, seen: Array | None) -> float:
    """Return the largest error of own compliances, each over itself, or of motions or what is seen, over the most."""
    if not touched:
        limit = levels.limit([np.diag(C.reshape(C.shape[0] * C.shape[1], -1)) for C, *_ in found])
        return float(np.max(limit.error / np.abs(limit.value)))
    limit = levels.limit([q if seen is None else np.sum(seen * q, axis=(-2, -1)) for _, q, *_ in found])
    return float(np.max(limit.error) / np.max(np.abs(limit.value)))


def _levels(cells: Cells) -> Levels:
    """Return the meshes of a pad with its targets."""

    def count(level: int) -> tuple[int, ...]:
        """Return the cells of a level along each axis."""
        x, y, z = map(len, cell_lines(cells, *FINENESS[level]))
        return x - 1, y - 1, z - 1

    def made(level: int) -> Bonded:
        """Make a level."""
        return cells_body(cells, *FINENESS[level])

    return Levels(terms_of(FINENESS, 0.5), count, made, lambda level: None, share=0.0)  # sides within a face


def cells_level(cells: Cells, body: Bonded) -> Level:
    """Return one mesh of a pad to be solved for the motions of its targets."""
    shapes = np.zeros((*body.bonded.shape, len(cells.targets), 6))
    for k, own in enumerate(scaled_ends(cells)):
        on = inside_of(own, body.X)
        shapes[on, :, k] = bonded_tangent(body.X[on] - [*own.mean(axis=0), 0.0], np.zeros(6))
    covered = covering(cells.sensor)
    return Level(body, shapes.reshape(*body.bonded.shape, -1), 1.0 if covered is None else covered.levels[1])


def cells_body(cells: Cells, split: int, layers: int) -> Bonded:
    """Return the whole pad with all its targets bonded; parts of a base cell and layers as in `bonded_block`."""
    t, ends, covered = cells.pad.thickness, scaled_ends(cells), covering(cells.sensor)
    mesh, division = box_bricks(*cell_lines(cells, split, layers))
    high, over = 1.0 if covered is None else covered.levels[0], cells.cover_ends / t

    def inside(places: Array) -> Mask:
        """Whether places (n, 3) are within a target seen from above."""
        return np.asarray(np.any([inside_of(own, places) for own in ends], axis=0))

    if covered is not None:
        mesh, _ = hollowed(mesh, division, lambda at: (at[:, 2] < 1.0) | (
            inside_of(over, at) & (~inside(at) | (at[:, 2] > high))
        ))
    elif cells.slots:
        cut = partial(in_slots, cells.slots, cells.pad)
        mesh, _ = hollowed(mesh, division, lambda at: ~cut(at))
    own, basis = solid_mesh(mesh, BRICK)
    z = own.nodes[:, 2]
    bonded = (z > 1.0 - 1e-9) & (z < high + 1e-9) & inside(own.nodes)
    held = (z < 1e-9) | in_slots([each for each in cells.slots if each.wall], cells.pad, own.nodes, 2.0 * ONE)
    where = np.stack([held, bonded, np.zeros(len(z), dtype=bool)])
    half_x, half_y = np.ptp(ends[0], axis=0) / 2.0
    plate, hidden = PlateOutline(half_x, half_y, False), covered is not None
    mesh_of_all = numbered(own, where, basis, plate, half=False, convex=not cells.slots, covered=hidden)
    return replace(solid(cells.sensor, mesh_of_all, 0.0, 0.0).body, components=0)


def _compliance(cells: Cells, level: Level) -> Array:
    """Return d(pose)/d(wrench) of all targets on one level, (n, 6, n, 6)."""
    n, t, scales = len(cells.targets), cells.pad.thickness, pad_scales(cells.sensor, 1.0)
    C = level.flexibility.reshape(n, 6, n, 6).copy()
    for k, plate in enumerate(cells.plates):
        work = np.stack([work_of_load(unit, plate.load_height / t, np.zeros(6)) for unit in np.eye(6)], axis=1)
        C[:, :, k] = C[:, :, k] @ (work / scales.loads)
    return C * scales.lengths[:, None, None]
