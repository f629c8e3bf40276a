"""From wrench to pose in three dimensions: a box of silicone under a rectangular target, at finite strain (`block`).

The box, width x length x thickness, is bonded to the rigid ground over its whole lower face and carries an exactly
rigid target bonded centred on its upper face. A wrench (F_x, F_z, M) leaves the plane y = 0 a plane of symmetry: half
the box is meshed, the target moves by (d_h, d_z) and turns by alpha about y. Equations: block_forms.py (pad),
target.py (rigid target), path.py (solution). Pose: ``d_v = standoff + t - sink``.

Meshes. Lines shrink towards the target's edges and the upper face, where the bonded corner is singular: the i-th of m
lines of a segment of length l lies ``l (i/m)**beta`` from the edge. Where such a mesh does not carry a load at once, a
milder one is tried, and at last a guarded one (energy.py), in steps as small as it needs.

Error. Every pose is solved on two meshes; their difference is extrapolated as if it went with the size of the cells,
and no component is called better than a twentieth of the worst. `report.estimated_error` is the largest over the
target's displacement, an angle counted at the target's end.

Range: boxes with rectangles, laws of the invariants; no contact: a face that folds onto the ground or the target is
named in the notes. Neglected: viscosity, gravity, loads out of the plane of symmetry.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.block_energy import cofactor, solid_energy
from sits_mech.mechanics.block_forms import BRICK, solid_deformation, solid_mesh, solid_tangent
from sits_mech.mechanics.pad import wrench_between
from sits_mech.mechanics.path import Bonded, Element, State, follow, packed, rest
from sits_mech.meshing.bricks import box_bricks
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.sensor import Elastomer, Sensor, Target

SOLID = Element(solid_tangent, solid_deformation, cofactor)
"""Three dimensions, block_forms.py."""

_KINDS = ((2.5, 0.0), (2.0, 0.0), (2.0, 5.0))  # grading towards the target's edge, guard on J; in this order
_LADDER = ((2e-2, (2, 1)), (0.0, (3, 2)))  # asked error of the pose -> cells through the thickness, fine and coarse
_STRETCH = 4.0  # thicknesses of half target that one cell more than through the thickness is worth
_REACH = 1.25  # thicknesses beside the target within which the pad is stressed: one cell does beyond
_GUARD_SHARE = 0.005  # of the bulk modulus that may act pointwise
_OUTER = 0.3  # of the outermost cell beside the target along x, split off: the tilt under shear hangs on it
_SHARE = 0.05  # of the worst component's error that every component owns to
_PATIENCE = (0.6, 1e-2)  # smallest increment of the load path where another mesh waits, and where none does


@dataclass(frozen=True)
class BlockPad:
    """The pad at finite strain; made by `block_pad`.

    Attributes
    ----------
    sensor : Sensor
    meshes : tuple of (Bonded, Bonded)
        The mesh of the answer and that of its error estimate, in the order in which they are tried.
    """

    sensor: Sensor
    meshes: tuple[tuple[Bonded, Bonded], ...]

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench` [N, N m], reached from `start` or from rest.

        Raises
        ------
        SolveFailed
            If the load path ends before the wrench; its `last` is the last equilibrium on the way.
        """
        began = time.perf_counter()
        if not np.all(np.isfinite([wrench.F_x, wrench.F_z, wrench.M])):
            raise ValueError(f"wrench: must be finite numbers, got {wrench}")
        last, part = _tried(self, 0, start, wrench)
        for number in range(1, len(self.meshes)):
            if part == 1.0:
                break
            other, farther = _tried(self, number, start, wrench)
            if farther > part:
                last, part = other, farther
        report = replace(last.report, seconds=time.perf_counter() - began)
        if part == 1.0:
            return replace(last, report=report)
        report = replace(report, status="load path ended", notes=(*report.notes, f"reached {part:.1%} of the path"))
        message = (
            f"wrench: the pad could be followed to {last.wrench} ({part:.1%} of the path), not to {wrench}; "
            f"smallest volume ratio there {report.min_J:.3g}"
        )
        raise SolveFailed(message, report, replace(last, report=report))


def block_pad(sensor: Sensor, tolerance: float = 2e-2) -> BlockPad:
    """Return the finite-strain model of a box of silicone under a rectangular target.

    Parameters
    ----------
    sensor : Sensor
        With a rectangular target and an elastomer of width and length.
    tolerance : float
        Asked error of the pose over the size of the displacement; picks the mesh. Two rungs: 2 % and what is finer.

    Raises
    ------
    ValueError
        For a scene without target or elastomer, of another shape or law, or a tolerance outside (0, 1).
    """
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance: must lie between 0 and 1, got {tolerance}")
    pair = next(cells for error, cells in _LADDER if tolerance >= error)
    bodies = [[bonded_block(sensor, cells, *kind) for cells in pair] for kind in _KINDS]
    return BlockPad(sensor, tuple((fine, coarse) for fine, coarse in bodies))


def bonded_block(sensor: Sensor, cells: int, grading: float, guard: float) -> Bonded:
    """Return half the pad (y >= 0) with its target, meshed and scaled.

    Parameters
    ----------
    sensor : Sensor
    cells : int
        Cells through the thickness.
    grading : float
        Power of the lines' spacing towards the target's edge and the upper face; 1 is uniform.
    guard : float
        Part of the bulk modulus that acts pointwise against inversion [shear moduli].
    """
    target, elastomer = _parts(sensor)
    t = elastomer.thickness
    pad, plate = ([length / (2 * t) for length in part.extent] for part in (elastomer, target))
    x_lines = _half_lines(plate[0], pad[0], cells, grading, _OUTER)
    y_lines = _half_lines(plate[1], pad[1], cells, grading, 0.0)
    z_lines = 1.0 - (np.arange(cells, -1, -1) / cells) ** grading
    mesh, _ = solid_mesh(box_bricks(np.concatenate([-x_lines[:0:-1], x_lines]), y_lines, z_lines), BRICK)
    x, y, z = mesh.nodes.T
    top = (z > 1.0 - 1e-9) & (np.abs(x) < plate[0] + 1e-9) & (y < plate[1] + 1e-9)
    held = np.repeat(((z < 1e-9) | top)[:, None], 3, axis=1)
    held[:, 1] |= y < 1e-9
    silicone = elastomer.silicone
    K = silicone.bulk_modulus / silicone.shear_modulus
    guard = min(guard, _GUARD_SHARE * K)
    rows, columns = np.repeat(mesh.dofs, 81, axis=1).ravel(), np.tile(mesh.dofs, (1, 81)).ravel()
    bonded = 3 * np.flatnonzero(top)[:, None] + np.array([0, 2])
    law, free = solid_energy(silicone, guard), np.flatnonzero(~held.ravel())
    return Bonded(mesh, law, K - guard, target.load_height / t, free, bonded, x[top], rows, columns, SOLID)


def _half_lines(edge: float, end: float, cells: int, grading: float, outer: float) -> Array:
    """Lines from the middle to the end of the pad, closer towards the target's edge; `outer` splits the last cell."""
    inner = cells + int(np.ceil(edge / _STRETCH))
    lines = edge * (1.0 - (np.arange(inner, -1, -1) / inner) ** grading)
    if end - edge < 1e-9:
        return np.asarray(lines)
    far = end - edge > 1.5 * _REACH
    beside = (np.arange(cells + 1) / cells) ** grading
    if outer > 0.0 and not far:
        beside = np.insert(beside, cells, 1.0 - outer * (1.0 - beside[-2]))
    lines = np.concatenate([lines, edge + (_REACH if far else end - edge) * beside[1:]])
    return np.append(lines, end) if far else lines


def _parts(sensor: Sensor) -> tuple[Target, Elastomer]:
    """Target and elastomer of a scene that this model can hold."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        missing = "target" if target is None else "elastomer"
        raise ValueError(f"{missing}: must be given for a force to move the target; it is missing")
    if target.shape != "rectangle":
        raise ValueError(f"target.shape: must be 'rectangle' for the model 'block', got {target.shape!r}")
    if elastomer.diameter is not None:
        raise ValueError("elastomer: must be a box (width, length) for the model 'block', got a diameter")
    if any(own > pad * (1.0 + 1e-9) for own, pad in zip(target.extent, elastomer.extent, strict=True)):
        raise ValueError(f"target: must lie on the pad {elastomer.extent} [m], got {target.extent} [m]")
    return target, elastomer


def _tried(pad: BlockPad, number: int, start: Equilibrium | None, wrench: Wrench) -> tuple[Equilibrium, float]:
    """The last equilibrium towards a wrench on one pair of meshes, and how much of the path that is."""
    meshes, patience = pad.meshes[number], _PATIENCE[number == len(pad.meshes) - 1]
    states, before = [rest(body) for body in meshes], Wrench()
    if start is not None and start.state.size == 1 + sum(map(_size, meshes)) and start.state[0] == number:
        first, second = np.split(start.state[1:], [_size(meshes[0])])
        states, before = [_unpacked(meshes[0], first), _unpacked(meshes[1], second)], start.wrench
    begin, end = _scaled(pad.sensor, before), _scaled(pad.sensor, wrench)
    coarse = follow(meshes[1], states[1], (begin, end), smallest=patience)
    end = begin + coarse.reached * (end - begin)
    fine = follow(meshes[0], states[0], (begin, end), smallest=patience)
    part = coarse.reached * fine.reached
    if fine.reached < 1.0:  # both must rest under one load for the error to mean something
        end = begin + fine.reached * (end - begin)
        coarse = follow(meshes[1], states[1], (begin, end), smallest=patience)
    found = _answer(pad.sensor, meshes, (fine.state, coarse.state), wrench_between(before, wrench, part))
    return replace(found, state=np.concatenate([[number], found.state])), part


def _answer(
    sensor: Sensor, meshes: tuple[Bonded, Bonded], found: tuple[State, State], wrench: Wrench
) -> Equilibrium:
    """Equilibrium with its errors from the two meshes."""
    (body, companion), (fine, coarse) = meshes, found
    _, elastomer = _parts(sensor)
    t = elastomer.thickness
    size, lever = np.array([t, t, 1.0]), np.array([1.0, 1.0, float(body.X.max()) * t])
    ratio = (len(body.mesh.cells) / len(companion.mesh.cells)) ** (1.0 / 3.0)
    at_end = np.abs(fine.q - coarse.q) * size * lever / (ratio - 1.0)
    at_end = np.maximum(at_end, _SHARE * at_end.max())
    displaced = float(np.max(np.abs(fine.q) * size * lever))
    report = SolveReport(
        "block", len(body.free) + 3, fine.iterations + coarse.iterations, fine.residual,
        float(at_end.max()) / displaced if displaced > 0.0 else 0.0, 0.0, notes=_folds(body, fine), min_J=fine.min_J,
    )
    d_h, d_z, alpha = (float(value) for value in fine.q * size)
    error = Pose(*(float(value) for value in at_end / lever))
    state = np.concatenate([packed(fine), packed(coarse)])
    return Equilibrium(wrench, Pose(d_h, elastomer.standoff + t + d_z, alpha), error, state, report)


def _folds(body: Bonded, state: State) -> tuple[str, ...]:
    """Sentences about free faces that passed the ground or the target's bottom face."""
    X, Y, Z = body.mesh.nodes.T
    x, y, z = (body.mesh.nodes + state.u.reshape(-1, 3)).T
    half = np.array([body.X.max(), Y[body.bonded[:, 0] // 3].max()])
    side = (X.max() - np.abs(X) < 1e-9) | (Y.max() - Y < 1e-9)
    beside = (Z > 1.0 - 1e-9) & ((np.abs(X) > half[0] + 1e-9) | (half[1] + 1e-9 < Y))
    notes = []
    if np.any(z[side & (Z > 1e-9)] < -1e-6):
        notes.append("a free face folds onto the ground: contact is not modelled, the true pad is stiffer")
    cos, sin = np.cos(state.q[2]), np.sin(state.q[2])
    x, z = x - state.q[0], z - 1.0 - state.q[1]
    along, above = x * cos - z * sin, x * sin + z * cos
    under = (np.abs(along) < half[0] * (1 - 1e-9)) & (y < half[1] * (1 - 1e-9))
    free = beside | (side & (Z > 1e-9) & (Z < 1.0 - 1e-9))
    if np.any(free & under & (above > 1e-6)):
        notes.append("a free face folds onto the target: contact is not modelled, the true pad is stiffer")
    return tuple(notes)


def _scaled(sensor: Sensor, wrench: Wrench) -> Array:
    """F_x, F_z, M on half the pad in the body's scales."""
    _, elastomer = _parts(sensor)
    t, mu = elastomer.thickness, elastomer.silicone.shear_modulus
    return np.array([wrench.F_x, wrench.F_z, wrench.M / t]) / (2.0 * mu * t**2)


def _size(body: Bonded) -> int:
    """Length of a packed state."""
    return body.mesh.nodes.size + 3 + 4 * len(body.mesh.cells)


def _unpacked(body: Bonded, array: Array) -> State:
    """State from one array."""
    u, q, p = np.split(array, [body.mesh.nodes.size, body.mesh.nodes.size + 3])
    return State(u, q, p.reshape(-1, 4), min_J=float(solid_deformation(body.mesh, u)[1].min()))
