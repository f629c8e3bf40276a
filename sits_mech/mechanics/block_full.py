"""From all six components of a wrench to all six of the pose: the whole pad in three dimensions.

The target is exactly rigid: a bonded point X of its lower face goes to ``c + R X``, c the centre's place, R a rotation.
Per unit of virtual work, with f the pad's forces on the bonded nodes and x = R X,

    forces     sum f = F,             moments     sum x x f = M + (R h) x F,          h = (0, 0, load height),

F a dead force, M a dead moment about the fixed axes. Newton's method turns R by ``exp([w])``, so that nothing is
singular at any rotation: with ``du = dc + w x x`` on the bonded nodes the tangent is that of the pad between those
fields, and what the turned arms add to the moments, in matrices of vector products: ``sum [f][x] - [F][R h]`` by w.
It is not symmetric, as a moment about fixed axes has no potential; a target at rest counts as stable where the
symmetric part of the stiffness that it feels is positive definite: no small push then does negative work.

The pad is that of block.py: both halves of it, the same elements, two meshes, the same extrapolation; where a mesh does
not carry a load, one with a guard on J is tried. Unknowns: nodal displacements and c in thicknesses, w in radians;
scales of block_mesh.py. Range: boxes and cylinders under rectangles and discs. Contact is not solved: where a free face
folds, it is named, and what its contact is worth (full_contact.py) is in the error, unless the scene wants none.
Components follow the right hand; ``M_y > 0`` turns clockwise in the x-z picture, like `M`.
"""

from __future__ import annotations

import time
from dataclasses import astuple, dataclass, replace

import numpy as np
from scipy import sparse
from skfem import MeshHex, MeshHex2
from skfem.assembly import Dofs

from sits_mech.mechanics.answer import law_notes, load_words
from sits_mech.mechanics.block_forms import BRICK, solid_mesh
from sits_mech.mechanics.block_mesh import (
    Solid,
    bonded_block,
    box_lines,
    edge_notes,
    flush,
    fold_notes,
    outlines,
    pad_parts,
    solid,
    solid_folds,
    within,
)
from sits_mech.mechanics.forms import Indices, Section
from sits_mech.mechanics.full_contact import contact_worth
from sits_mech.mechanics.newton import solved
from sits_mech.mechanics.path import REASONS
from sits_mech.meshing.bricks import Outline, box_bricks
from sits_mech.quantities import Array, SolveFailed, SolveReport
from sits_mech.sensor import Sensor

_LADDER = ((1e-2, (2, 1)), (0.0, (3, 2)))  # asked error of the pose -> cells through the thickness, fine and coarse
# Grading towards the target's edge and guard on J, in the order they are tried; the first not for flush pads.
_KINDS = ((2.0, 0.0), (1.5, 0.0), (2.0, 5.0))
_PATIENCE = (0.2, 1e-2)  # smallest increment of the load where another mesh waits, and where none does
_SETTLED = 1e-9
_ITERATIONS = 14
_EASY = 5  # iterations up to which the next increment grows
_NEAR = 1e-3  # residual from which one more step leaves the target's stiffness as it is
_SHARE = 0.25  # of the worst component's error that every component owns to
_FOLDING = 1.5  # order that the error of flush pads is told with, as in block.py


@dataclass(frozen=True)
class FullWrench:
    """Dead forces [N], downwards F_z positive, and moments [N m] about the fixed axes through where the force acts."""

    F_x: float = 0.0
    F_y: float = 0.0
    F_z: float = 0.0
    M_x: float = 0.0
    M_y: float = 0.0
    M_z: float = 0.0


@dataclass(frozen=True)
class FullPose:
    """Where the target rests.

    Attributes
    ----------
    wrench : FullWrench
        Under what.
    centre : ndarray, shape (3,)
        Centre of its lower face [m].
    rotation : ndarray, shape (3,)
        Rotation vector [rad].
    error : ndarray, shape (6,)
        Estimated absolute errors of both [m, rad].
    report : SolveReport
    """

    wrench: FullWrench
    centre: Array
    rotation: Array
    error: Array
    report: SolveReport


@dataclass(frozen=True)
class _Place:
    """A pad's state: nodal displacements, pressures, the target's centre and rotation; whether it stands stable."""

    u: Array
    p: Array
    c: Array
    R: Array
    residual: float = np.inf
    iterations: int = 0
    min_J: float = 1.0
    stable: bool = True


@dataclass(frozen=True)
class _Path:
    """The last place at rest on the way to a load, how much of it that is, what ended it as of `path.Outcome`."""

    place: _Place
    reached: float
    reason: str = ""


def full_equilibrium(sensor: Sensor, wrench: FullWrench, tolerance: float = 1e-2) -> FullPose:
    """Return where a pad's target rests under all six components of a load.

    Parameters
    ----------
    sensor : Sensor
        With a rectangle or a disc on a box or a cylinder of elastomer.
    wrench : FullWrench
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
    forces = np.array(astuple(wrench), dtype=float)
    if not np.all(np.isfinite(forces)):
        raise ValueError(f"wrench: must be finite numbers, got {load_words(vars(wrench))}")
    load = forces * [1.0, 1.0, -1.0, 1.0 / t, 1.0 / t, 1.0 / t] / (mu * t**2)
    pair = next(cells for least, cells in _LADDER if tolerance >= least)
    solids, (fine, coarse) = _carried(sensor, wrench, load, pair)
    places = [np.concatenate([place.c * t, _vector(place.R)]) for place in (fine, coarse)]
    apart, finer = places[0] - places[1], solids[0].fineness / solids[1].fineness
    lever = np.repeat([1.0, float(max(target.extent)) / 2.0], 3)
    best = places[0] + apart / (finer**2 - 1.0)
    at_end = np.abs(apart) * lever / (finer ** (_FOLDING if solids[0].under.size > 0 else 2.0) - 1.0)
    at_end = np.maximum(at_end, _SHARE * at_end.max())
    notes = (*law_notes(sensor, solids[0].body, fine.u), *fold_notes(solids[0], fine.u, fine.c, fine.R))
    if elastomer.contact != "never" and solid_folds(solids[0], fine.u, fine.c, fine.R).touch:
        worth, note = contact_worth(sensor, forces, best, tolerance)
        at_end, notes = at_end + worth * lever, (*notes, note)
    size = float(np.max(np.abs(best) * lever))
    error = float(at_end.max()) / size if size > 0.0 else 0.0
    missed = (f"the estimated error is above the tolerance {tolerance:g}",) if error > tolerance else ()
    report = SolveReport(
        "block", len(solids[0].body.free) + 6, fine.iterations + coarse.iterations, fine.residual, error,
        time.perf_counter() - began, notes=(*notes, *edge_notes(sensor), *missed), min_J=fine.min_J,
    )
    return FullPose(wrench, best[:3] + (0.0, 0.0, elastomer.standoff + t), best[3:], at_end / lever, report)


def whole_block(sensor: Sensor, cells: int, grading: float, guard: float) -> Solid:
    """Return both halves of a box or a cylinder with its target, meshed and scaled; arguments as of `bonded_block`."""
    target, elastomer = pad_parts(sensor)
    plate, pad = outlines(target, elastomer)
    if elastomer.mesh is not None:
        raise ValueError("elastomer.mesh: must not be given under F_y, M_x or M_z; boxes and cylinders are held")
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
    found = solid(sensor, section, np.stack([height < 1e-9, top, np.zeros_like(top)]), (guard, fineness), basis)
    below = np.logical_and(within(plate, section.nodes, 1e-3), height < 1.0 - 1e-9)
    return replace(found, under=found.faces[below[found.faces]])


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


def _carried(
    sensor: Sensor, wrench: FullWrench, load: Array, cells: tuple[int, int]
) -> tuple[tuple[Solid, Solid], tuple[_Place, _Place]]:
    """The first pair of meshes that carries a load, and its rest on both; SolveFailed where none does."""
    began = time.perf_counter()
    kinds = _KINDS[1:] if flush(*outlines(*pad_parts(sensor))) else _KINDS
    for kind in kinds:
        patience = _PATIENCE[kind is kinds[-1]]
        fine, coarse = (whole_block(sensor, count, *kind) for count in cells)
        first = _followed(coarse, load, patience)
        second = _followed(fine, load, patience) if first.reached == 1.0 else first
        if second.reached == 1.0:
            return (fine, coarse), (second.place, first.place)
    why = (*law_notes(sensor, (coarse if second is first else fine).body, second.place.u), REASONS[second.reason])
    report = SolveReport(
        "block", len(fine.body.free) + 6, second.place.iterations, second.place.residual, np.inf,
        time.perf_counter() - began, "load path ended", notes=(*why, f"reached {second.reached:.1%} of the path"),
        min_J=second.place.min_J,
    )
    raise SolveFailed(_ended(sensor, wrench, second, why), report)


def _ended(sensor: Sensor, wrench: FullWrench, way: _Path, why: tuple[str, ...]) -> str:
    """Say where a load path ended, and why."""
    reached = {name: way.reached * value for name, value in vars(wrench).items()}
    moved = 1e3 * pad_parts(sensor)[1].thickness * way.place.c
    place, turn = (", ".join(f"{x:.5f}" for x in own) for own in (moved, _vector(way.place.R)))
    return (
        f"wrench: the pad could be followed to {load_words(reached)} ({way.reached:.1%} of the path), not to "
        f"{load_words(vars(wrench))}; there the target had moved by {place} mm and turned by {turn} rad (x, y, z), "
        f"smallest volume ratio {way.place.min_J:.3g}; {'; '.join(why)}"
    )


def _followed(pad: Solid, load: Array, smallest: float) -> _Path:
    """The way from rest to a load, in steps as small as they need be down to the smallest."""
    mesh = pad.body.mesh
    here = _Place(np.zeros(mesh.nodes.size), np.zeros(mesh.chi.shape[:2]), np.zeros(3), np.eye(3))
    at, increment, spent, reason = 0.0, 1.0, 0, ""
    while at < 1.0 and increment >= smallest:
        part = min(1.0, at + increment)
        trial = _newton(pad, here, part * load)
        spent += trial.iterations
        if trial.residual <= _SETTLED and trial.stable:
            here, at = trial, part
            increment *= 2.0 if trial.iterations <= _EASY else 1.0
        else:
            reason = "buckled" if trial.residual <= _SETTLED else "lost"
            increment *= 0.5
    return _Path(replace(here, iterations=spent), at, reason)


def _newton(pad: Solid, start: _Place, load: Array) -> _Place:
    """Iterate to rest under one load; the result's residual says whether it settled."""
    body, here = pad.body, start
    top = body.bonded[:, 0] // 3
    X = body.mesh.nodes[top] * (1.0, 1.0, 0.0)
    size, stable, n = max(float(np.linalg.norm(load)), 1e-5 * body.K), start.stable, len(body.free)
    pushes = np.vstack([np.zeros((n, 6)), np.eye(6)])
    for count in range(_ITERATIONS + 1):
        found = body.element.tangent(body.mesh, body.law, body.K, here.u, here.p)
        x, f = X @ here.R.T, found.forces.reshape(-1, 3)[top]
        arm = body.height * here.R[:, 2]
        T = np.concatenate([np.broadcast_to(np.eye(3), (len(x), 3, 3)), -_cross(x)], axis=2)
        P = _map(body.free, top, T, len(here.u))
        gradient = P.T @ found.forces
        gradient[-6:] -= np.concatenate([load[:3], load[3:] + np.cross(arm, load[:3])])
        left = float(np.linalg.norm(gradient)) / size
        left = left if left > _SETTLED or np.isfinite(found.energy) else np.inf  # beyond its law's locking stretch
        here = _Place(here.u, here.p, here.c, here.R, left, count, found.min_J)
        if here.residual <= _SETTLED or not np.isfinite(here.residual) or count == _ITERATIONS:
            break
        K = sparse.csr_matrix((found.stiffness.ravel(), (body.rows, body.columns)), shape=(len(here.u),) * 2)
        turning = np.einsum("aij,ajk->ik", _cross(f), _cross(x)) + _cross(load[None, :3])[0] @ -_cross(arm[None])[0]
        add = sparse.coo_matrix((turning.ravel(), tuple(n + 3 + np.indices((3, 3)).reshape(2, -1))), (n + 6, n + 6))
        ways = solved((P.T @ K @ P + add).tocsc(), np.column_stack([-gradient, pushes]))
        if ways is None:
            break
        stable = _stable(ways[-6:, 1:]) if here.residual <= _NEAR else stable
        moved = _moved(pad, here, ways[:, 0], (P, X, top))
        if moved is None:
            break
        here = moved
    return replace(here, stable=stable)


def _stable(compliance: Array) -> bool:
    """Say whether a target with this compliance withstands every small push, see the module docstring."""
    return bool(np.all(np.linalg.eigvalsh(0.5 * (compliance + compliance.T)) > 0.0))


def _moved(pad: Solid, here: _Place, step: Array, maps: tuple[sparse.csr_matrix, Array, Indices]) -> _Place | None:
    """State after the longest part of a step that keeps every quadrature point well above inversion."""
    body, (P, X, top) = pad.body, maps
    linear = P @ step
    F, J = body.element.deformation(body.mesh, here.u)
    B, dofs = body.mesh.B, body.mesh.dofs
    dF = (B.reshape(len(J), -1, dofs.shape[1]) @ linear[dofs][:, :, None]).reshape(F.shape)
    volume = J - 1.0 + np.einsum("eqi,eqi->eq", body.element.cofactor(F), dF)
    p_full = body.K * np.einsum("emq,eq->em", body.mesh.chi, volume)
    part = 1.0
    while part > 1e-3:
        c, R = here.c + part * step[-6:-3], rotation_matrix(part * step[-3:]) @ here.R
        u = here.u + part * linear
        u.reshape(-1, 3)[top] = c + X @ (R - np.eye(3)).T
        least = float(body.element.deformation(body.mesh, u)[1].min())
        if least > 0.2 * min(here.min_J, 1.0):
            return _Place(u, here.p + part * (p_full - here.p), c, R, min_J=least)
        part *= 0.5
    return None


def _map(free: Indices, top: Indices, T: Array, n: int) -> sparse.csr_matrix:
    """From the unknowns to the nodal displacements."""
    count = len(free)
    rows = 3 * top[:, None, None] + np.arange(3)[:, None] + np.zeros(6, dtype=int)
    columns = np.broadcast_to(count + np.arange(6), rows.shape)
    values, at = np.concatenate([np.ones(count), T.ravel()]), np.concatenate([free, rows.ravel()])
    return sparse.csr_matrix((values, (at, np.concatenate([np.arange(count), columns.ravel()]))), shape=(n, count + 6))


def _cross(v: Array) -> Array:
    """Matrices of the vector products with v, shape (n, 3) -> (n, 3, 3)."""
    found = np.zeros((len(v), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[:, i, j], found[:, j, i] = -v[:, k], v[:, k]
    return found


def rotation_matrix(w: Array) -> Array:
    """Return the rotation matrix, shape (3, 3), of a rotation vector, shape (3,) [rad]."""
    angle = float(np.linalg.norm(w))
    W = _cross(w[None])[0]
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * W + 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2 * W @ W)


def _vector(R: Array) -> Array:
    """Rotation vector of a rotation by less than half a turn."""
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(axis))
    return axis * (np.arctan2(sine, 0.5 * (np.trace(R) - 1.0)) / sine if sine > 0.0 else 1.0)
