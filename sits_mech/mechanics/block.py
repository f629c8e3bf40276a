"""From wrench to pose in three dimensions: a box or a cylinder of silicone under a plate, at finite strain (`block`).

The pad is bonded to the rigid ground over its whole lower face and carries an exactly rigid target, a rectangle or a
disc, bonded centred on its upper face. A wrench (F_x, F_z, M) leaves the plane y = 0 a plane of symmetry: half the pad
is meshed, the target moves by (d_h, d_z) and turns by alpha about y. Equations: block_forms.py (pad), target.py (rigid
target), path.py (solution). Pose: ``d_v = standoff + t - sink``.

Meshes: block_mesh.py, graded towards the bonded corners. Where such a mesh does not carry a load at once, a milder one
is tried, and at last a guarded one (block_energy.py), in steps as small as it needs.

Error. Every pose is solved on two meshes of graded cells and extrapolated from both, as if the error went with the
square of the size of the cells; what that adds to the finer mesh's pose is called its error, that of order 1.5 with
contact and of flush pads, which may fold, and no component is called better than a quarter of the worst.
`report.estimated_error` is the largest over the target's displacement, an angle counted at the target's end.
Deformation and `min_J` are those of the finer mesh. On a mesh of the user's own the two are one mesh with linear and
with constant pressures: one too stiff, the other too soft, in every case that was tried; the pose is their mean, of
hexahedra the stiffer one, and half their difference, with contact all of it, its error (block_user.py).

Contact of the free faces with ground and target (scene key `elastomer.contact`, block_contact.py) is "never" solved,
"always", or, "auto", where a free face folds onto one of them: from the rest without contact, or else along a path of
its own; where neither gets there, the answer is that without, and its error the whole displacement. The notes say
which.

Range: boxes, cylinders and meshes of the user's under rectangles and discs, every law. Neglected: viscosity, gravity,
friction, loads out of the plane of symmetry, faces that touch themselves.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from scipy.spatial import cKDTree

from sits_mech.mechanics.answer import law_notes, load_words
from sits_mech.mechanics.block_contact import placed, softened
from sits_mech.mechanics.block_folds import LEFT_OUT, fold_notes, solid_folds
from sits_mech.mechanics.block_forms import solid_deformation
from sits_mech.mechanics.block_full import whole_equilibrium
from sits_mech.mechanics.block_mesh import (
    Solid,
    bonded_block,
    edge_notes,
    flush,
    outlines,
    pad_parts,
    shares,
)
from sits_mech.mechanics.block_user import meshed_pad
from sits_mech.mechanics.forms import Indices
from sits_mech.mechanics.pad import wrench_between
from sits_mech.mechanics.path import REASONS, Bonded, State, follow, packed, rest
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.sensor import Sensor
from sits_mech.threads import one_thread
from sits_mech.units import checked_tolerance

# Grading towards the target's edge and guard on J, in the order they are tried; beside the target, and flush with it.
_KINDS = ((2.5, 0.0), (1.5, 0.0), (2.0, 5.0))
_FLUSH = ((2.0, 0.0), (1.5, 0.0), (2.0, 5.0))
_GUARDS = (0.0, 5.0)  # on J, on a mesh of the user's own
# Asked error of the pose -> cells through the thickness, fine and coarse.
_LADDER = ((1e-2, (2, 1)), (3e-3, (3, 2)), (0.0, (4, 3)))
_SHARE = 0.25  # of the worst component's error that every component owns to: the tilt of a load near its P-Delta limit
_WORK = 1.5e6  # iterations times unknowns that a load path is given: a minute on the largest mesh
_PATIENCE = (0.6, 1e-2)  # smallest increment of the load path where another mesh waits, and where none does
_GIVE = 1e-4  # thicknesses over which the pressure of contact builds up
_SOFTER = (100.0, 10.0)  # times that, on the way from rest without contact


class Meshes:
    """Pairs of meshes, that of the answer and that of its error estimate: the first made at once, to refuse what has
    none, the others when they are asked for.
    """

    def __init__(self, makers: Iterable[Callable[[], tuple[Solid, Solid]]]) -> None:
        self._made = [cache(maker) for maker in makers]
        self._made[0]()

    def __len__(self) -> int:
        return len(self._made)

    def __getitem__(self, number: int) -> tuple[Solid, Solid]:
        return self._made[number]()


@dataclass(frozen=True)
class BlockPad:
    """The pad at finite strain; made by `block_pad`.

    Attributes
    ----------
    sensor : Sensor
    tolerance : float
        Asked error of the pose over the size of the displacement; an answer that misses it says so.
    meshes : Meshes
        In the order in which they are tried.
    touching : int
        How many at the end have contact: those before them once more; 0 where that is the same for all.
    """

    sensor: Sensor
    tolerance: float
    meshes: Meshes
    touching: int = 0

    @one_thread
    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench` [N, N m], reached from `start` or from rest.

        Raises
        ------
        SolveFailed
            If the load path ends before the wrench; its `last` is the last equilibrium on the way.
        """
        began = time.perf_counter()
        if not np.all(np.isfinite(wrench.components)):
            raise ValueError(f"wrench: must be finite numbers, got {load_words(vars(wrench))}")
        if wrench.beside:
            return whole_equilibrium(self.sensor, wrench, self.tolerance)
        last, part = _reached(self, start, wrench)
        report = replace(last.report, seconds=time.perf_counter() - began)
        if part == 1.0:
            missed = report.estimated_error > self.tolerance
            notes = (f"the estimated error is above the tolerance {self.tolerance:g}",) if missed else ()
            return replace(last, report=replace(report, notes=(*report.notes, *notes)))
        report = replace(report, status="load path ended", notes=(*report.notes, f"reached {part:.1%} of the path"))
        message = (
            f"wrench: the pad could be followed to {load_words(vars(last.wrench))} ({part:.1%} of the path), "
            f"not to {load_words(vars(wrench))}; smallest volume ratio there {report.min_J:.3g}; {_why(self, last)}"
        )
        raise SolveFailed(message, report, replace(last, report=report))


def block_pad(sensor: Sensor, tolerance: float = 2e-2) -> BlockPad:
    """Return the finite-strain model of a box or cylinder of silicone under a rectangular or round target.

    Parameters
    ----------
    sensor : Sensor
        With a target, a rectangle or a disc, and an elastomer.
    tolerance : float
        Asked error of the pose over the size of the displacement; picks the mesh. Three rungs: 1 %,
        0.3 %, and what is finer: six times the unknowns of the first, 1.5 GB and a minute a load for a wide pad.

    Raises
    ------
    ValueError
        For a scene without target or elastomer, a target of another shape, or a tolerance outside (0, 1).
    """
    checked_tolerance(tolerance)
    pair = next(cells for error, cells in _LADDER if tolerance >= error)
    target, elastomer = pad_parts(sensor)
    gives = {"never": (0.0,), "always": (_GIVE,), "auto": (0.0, _GIVE)}[elastomer.contact]
    makers: list[Callable[[float], tuple[Solid, Solid]]]
    if elastomer.mesh is not None:
        makers = [partial(meshed_pad, sensor, guard) for guard in _GUARDS]
    else:
        kinds = _FLUSH if flush(*outlines(target, elastomer)) else _KINDS
        makers = [partial(_pair, sensor, pair, kind) for kind in kinds]
    meshes = Meshes(partial(maker, give) for give in gives for maker in makers)
    return BlockPad(sensor, tolerance, meshes, len(makers) if elastomer.contact == "auto" else 0)


def deformed_section(model: BlockPad, equilibrium: Equilibrium) -> tuple[Array, Indices, Array]:
    """Return the deformed pad in the plane y = 0 for pictures.

    Returns
    -------
    points : ndarray, shape (n, 2)
        x, z in the sensor's coordinates [m].
    quads : ndarray, shape (m, 4)
        Corners of the quarters of the cells' faces in that plane, in order; of a triangle the last one twice.
    J : ndarray, shape (m,)
        Mean volume ratio of each one's cell.
    """
    _, elastomer = pad_parts(model.sensor)
    solid = model.meshes[int(equilibrium.state[0])][0]
    section = solid.body.mesh
    u = equilibrium.state[1 : 1 + section.nodes.size].reshape(-1, 3)
    points = (section.nodes + u)[:, [0, 2]] * elastomer.thickness + (0.0, elastomer.standoff)
    mean = solid_deformation(section, u.ravel())[1].mean(axis=1)
    bent = solid.middle[:, 3] != solid.middle[:, 4]
    quarters = _quarters(section.nodes, solid.middle[bent, 1:])
    quads = np.concatenate([quarters, solid.middle[~bent, 1:]])
    return points, quads, mean[np.concatenate([np.repeat(solid.middle[bent, 0], 4), solid.middle[~bent, 0]])]


def _quarters(nodes: Array, faces: Indices) -> Indices:
    """Quarters of quadrilateral faces in the plane y = 0, with the nodes between their corners: they may be bent."""
    own = np.flatnonzero(np.abs(nodes[:, 1]) < 1e-9)
    tree = cKDTree(nodes[own][:, [0, 2]])
    corners = nodes[faces][..., [0, 2]]
    beside = own[tree.query(0.5 * (corners + np.roll(corners, -1, axis=1)))[1]]
    middle = own[tree.query(corners.mean(axis=1))[1]]
    parts = [faces, beside, np.repeat(middle[:, None], 4, axis=1), np.roll(beside, 1, axis=1)]
    return np.stack(parts, axis=-1).reshape(-1, 4)


def _pair(sensor: Sensor, cells: tuple[int, int], kind: tuple[float, float], give: float) -> tuple[Solid, Solid]:
    """Two meshes of one kind; the coarse one gives over twice the length."""
    fine, coarse = cells
    return bonded_block(sensor, fine, *kind, give), bonded_block(sensor, coarse, *kind, 2.0 * give)


def _reached(pad: BlockPad, start: Equilibrium | None, wrench: Wrench) -> tuple[Equilibrium, float]:
    """The last equilibrium towards a wrench, with contact where it counts, and how much of the path that is."""
    free, count = len(pad.meshes) - pad.touching, len(pad.meshes)
    if start is not None and free <= start.state[0] < count:  # a neighbour in contact
        last, part = _tried(pad, int(start.state[0]), start, wrench)
        if part == 1.0:
            return last, part
    last, part = _farthest(pad, range(free), start, wrench)
    if not (pad.touching and _touches(pad, last)):
        return last, part
    twin = free + int(last.state[0])
    if part == 1.0 and twin < count - 1:  # the last mesh may be one that only a pad without contact needs
        other, farther = _tried(pad, twin, _eased(pad, twin, last), wrench)
        if farther == 1.0:
            return other, farther
    other, farther = _farthest(pad, range(free, count), start, wrench)
    return (other, farther) if farther >= part else (_without_contact(pad, last), part)


def _without_contact(pad: BlockPad, found: Equilibrium) -> Equilibrium:
    """An answer that needs contact and has none: its error is the whole displacement."""
    target, elastomer = pad_parts(pad.sensor)
    lever, pose = 0.5 * target.extent[0], found.pose
    moved = (pose.d_h, pose.d_v - elastomer.standoff - elastomer.thickness, lever * pose.alpha)
    size = max(abs(float(value)) for value in moved)
    report = replace(found.report, estimated_error=1.0, notes=(*found.report.notes, LEFT_OUT))
    return replace(found, error=Pose(size, size, size / lever), report=report)


def _eased(pad: BlockPad, number: int, found: Equilibrium) -> Equilibrium:
    """An equilibrium without contact as a start with it, let in softly: faces stand deep behind planes at first."""
    states = []
    goal = _scaled(pad.sensor, found.wrench) * pad.meshes[number][0].share
    halves = np.split(found.state[1:], [_size(pad.meshes[number][0].body)])
    for solid, half in zip(pad.meshes[number], halves, strict=True):
        state = _unpacked(solid.body, half)
        for factor in _SOFTER:
            body = replace(solid.body, parts=softened(solid.body.parts, factor))
            state = follow(body, state, (goal, goal), smallest=1.0).state
        states.append(packed(state))
    return replace(found, state=np.concatenate([[number], *states]))


def _farthest(pad: BlockPad, numbers: range, start: Equilibrium | None, wrench: Wrench) -> tuple[Equilibrium, float]:
    """Of some pairs of meshes, the first that gets there, or else the farthest."""
    last, part = _tried(pad, numbers[0], start, wrench)
    for number in numbers[1:]:
        if part == 1.0:
            break
        other, farther = _tried(pad, number, start, wrench)
        if farther > part:
            last, part = other, farther
    return last, part


def _touches(pad: BlockPad, found: Equilibrium) -> bool:
    """Whether a free face lies on or behind ground or target."""
    solid = pad.meshes[int(found.state[0])][0]
    state = _unpacked(solid.body, found.state[1 : 1 + _size(solid.body)])
    return solid_folds(solid, state.u, *placed(state.q)).touch


def _why(pad: BlockPad, last: Equilibrium) -> str:
    """What may have ended a load path: the law, by its notes, and how the path ended."""
    body = pad.meshes[int(last.state[0])][0].body
    u = last.state[1 : 1 + body.mesh.nodes.size]
    return "; ".join((*law_notes(pad.sensor, body, u), last.report.notes[-1]))


def _tried(pad: BlockPad, number: int, start: Equilibrium | None, wrench: Wrench) -> tuple[Equilibrium, float]:
    """The last equilibrium towards a wrench on one pair of meshes, and how much of the path that is."""
    solids, count = pad.meshes[number], len(pad.meshes)
    patience = _PATIENCE[number + 1 in (count, count - pad.touching)]
    bodies = (solids[0].body, solids[1].body)
    states, before = [rest(body) for body in bodies], Wrench()
    if start is not None and start.state.size == 1 + sum(map(_size, bodies)) and start.state[0] == number:
        first, second = np.split(start.state[1:], [_size(bodies[0])])
        states, before = [_unpacked(bodies[0], first), _unpacked(bodies[1], second)], start.wrench
    share = solids[0].share
    begin, end = _scaled(pad.sensor, before) * share, _scaled(pad.sensor, wrench) * share
    coarse = follow(bodies[1], states[1], (begin, end), smallest=patience, most=_WORK / len(bodies[1].free))
    end = begin + coarse.reached * (end - begin)
    fine = follow(bodies[0], states[0], (begin, end), smallest=patience, most=_WORK / len(bodies[0].free))
    part, reason = coarse.reached * fine.reached, fine.reason or coarse.reason
    if fine.reached < 1.0:  # both must rest under one load for the error to mean something
        end = begin + fine.reached * (end - begin)
        coarse = follow(bodies[1], states[1], (begin, end), smallest=patience)
    found = _answer(pad.sensor, solids, (fine.state, coarse.state), wrench_between(before, wrench, part))
    found = replace(found, state=np.concatenate([[number], found.state]))
    if part < 1.0:
        found = replace(found, report=replace(found.report, notes=(*found.report.notes, REASONS[reason])))
    return found, part


def _answer(sensor: Sensor, solids: tuple[Solid, Solid], found: tuple[State, State], wrench: Wrench) -> Equilibrium:
    """Equilibrium with its errors from the two meshes."""
    body, (fine, coarse) = solids[0].body, found
    _, elastomer = pad_parts(sensor)
    t = elastomer.thickness
    size, lever = np.array([t, t, 1.0]), np.array([1.0, 1.0, float(body.X.max()) * t])
    added, owned = shares(*solids)
    apart = fine.q - coarse.q
    at_end = owned * np.abs(apart) * size * lever
    at_end = np.maximum(at_end, _SHARE * at_end.max())
    q = fine.q + added * apart
    displaced = float(np.max(np.abs(q) * size * lever))
    report = SolveReport(
        "block", len(body.free) + 3, fine.iterations + coarse.iterations, fine.residual,
        float(at_end.max()) / displaced if displaced > 0.0 else 0.0, 0.0,
        notes=(*_notes(sensor, solids[0], fine), *edge_notes(sensor)), min_J=fine.min_J,
    )
    d_h, d_z, alpha = (float(value) for value in q * size)
    error = Pose(*(float(value) for value in at_end / lever))
    state = np.concatenate([packed(fine), packed(coarse)])
    return Equilibrium(wrench, Pose(d_h, elastomer.standoff + t + d_z, alpha), error, state, report)


def _notes(sensor: Sensor, solid: Solid, state: State) -> tuple[str, ...]:
    """Sentences about the free faces and the law."""
    target, elastomer = pad_parts(sensor)
    seen = fold_notes(solid, state.u, *placed(state.q), target.thickness / elastomer.thickness)
    return (*seen, *law_notes(sensor, solid.body, state.u))


def _scaled(sensor: Sensor, wrench: Wrench) -> Array:
    """F_x, F_z, M in the body's scales."""
    _, elastomer = pad_parts(sensor)
    t, mu = elastomer.thickness, elastomer.silicone.shear_modulus
    return np.array([wrench.F_x, wrench.F_z, wrench.M / t]) / (mu * t**2)


def _size(body: Bonded) -> int:
    """Length of a packed state."""
    return int(body.mesh.nodes.size + 3 + np.prod(body.mesh.chi.shape[:2]))


def _unpacked(body: Bonded, array: Array) -> State:
    """State from one array."""
    u, q, p = np.split(array, [body.mesh.nodes.size, body.mesh.nodes.size + 3])
    return State(u, q, p.reshape(body.mesh.chi.shape[:2]), min_J=float(solid_deformation(body.mesh, u)[1].min()))
