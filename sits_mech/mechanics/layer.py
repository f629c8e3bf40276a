"""From wrench to pose: the silicone layer in plane strain, at finite strain (`planar`) or small strain (`linear`).

The layer of width W and thickness t, bonded to the rigid ground over its whole width, carries an exactly rigid target
bonded over the middle of its top face; the wrench is a dead load in newtons, spread over the elastomer's length in y.
Equations: forms.py (layer), target.py (rigid target), path.py (solution). Pose: ``d_v = standoff + t - sink``.

Meshes. Small strain wants a strong grading towards the singular corners. At finite strain that resolves corners which
then crease, or turn inside out. So several meshes stand in line, each tougher and a little less accurate than the
one before: strongly graded, mildly graded, and mildly graded with a guard on J. The first whose load path gets there
with an error near the tolerance gives the answer, or else the one with the smallest error.

Error. Every pose is solved on two meshes. The corner singularity makes it converge as h^1.2 to h^1.8 on these
gradings; the error is extrapolated from the difference as if it were h, to be on the safe side, and no component is
called better than a twentieth of the worst. `report.estimated_error` is the largest over the target's displacement.

Range: plane strain (the true pad is softer by its ends); no contact: a free face that folds onto the ground or the
target is found and named in the notes. Neglected: viscosity, gravity.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.forms import Indices, deformation
from sits_mech.mechanics.pad import Fineness, bonded_body, scaled_load, wrench_between
from sits_mech.mechanics.path import Bonded, State, compliance, correction, follow, packed, rest
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.sensor import Sensor

_STRONG, _MILD, _GUARDED = (2.5, 0.0), (1.5, 0.0), (1.5, 5.0)  # grading towards the corners, guard on J
# Asked error of the pose -> cells through the thickness, fine and coarse; meshes in the order they are tried.
_LADDER = (
    (2e-2, ((4, 2), (_MILD, _GUARDED))),
    (1e-2, ((6, 4), (_MILD, _GUARDED))),
    (1e-3, ((8, 4), (_STRONG, _MILD, _GUARDED))),
    (1e-4, ((16, 8), (_STRONG, _MILD, _GUARDED))),
)
_SHARE = 0.05  # of the worst component's error that every component owns to
_LENIENCE = 2.0  # the estimate is on the safe side: up to so many tolerances no other mesh is tried
_PATIENCE = (0.25, 1e-4)  # smallest increment of the load path where another mesh waits, and where none does
_BUCKLES = "beyond this load the layer buckles: its rest is not stable"


@dataclass(frozen=True)
class PlanarLayer:
    """The layer at finite strain; made by `planar_layer`.

    Attributes
    ----------
    sensor : Sensor
    tolerance : float
        Asked error of the pose over the size of the displacement.
    meshes : tuple of (Bonded, Bonded)
        The mesh of the answer and that of its error estimate, in the order in which they are tried.
    """

    sensor: Sensor
    tolerance: float
    meshes: tuple[tuple[Bonded, Bonded], ...]

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench` [N, N m], reached from `start` or from rest.

        Raises
        ------
        SolveFailed
            If the load path ends before the wrench; its `last` is the last equilibrium on the way.
        """
        began = time.perf_counter()
        _check_load(wrench)
        last, part = _tried(self, 0, start, wrench)
        for number in range(1, len(self.meshes)):
            if part == 1.0 and last.report.estimated_error <= _LENIENCE * self.tolerance:
                break
            other = _tried(self, number, start, wrench)
            if (other[1], -other[0].report.estimated_error) > (part, -last.report.estimated_error):
                last, part = other
        report = replace(last.report, seconds=time.perf_counter() - began)
        if part == 1.0:
            return replace(last, report=report)
        report = replace(report, status="load path ended", notes=(*report.notes, f"reached {part:.1%} of the path"))
        raise SolveFailed(_ended(last, wrench, part), report, replace(last, report=report))


@dataclass(frozen=True)
class LinearLayer:
    """The layer at small strain: one compliance; made by `linear_layer`.

    Attributes
    ----------
    sensor : Sensor
    body : Bonded
    compliance, coarse : ndarray, shape (3, 3)
        d(d_h, d_z, alpha) / d(F_x, F_z downwards, moment about the bonded face), scaled; on two meshes.
    """

    sensor: Sensor
    body: Bonded
    compliance: Array
    coarse: Array

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose under `wrench` by linear elasticity; `start` plays no part.

        The error is that of the mesh and the first Newton correction towards finite strain.
        """
        began = time.perf_counter()
        _check_load(wrench)
        load = scaled_load(self.sensor, wrench)
        force = np.array([load[0], -load[1], load[2] + self.body.height * load[0]])
        q = self.compliance @ force
        t = _thickness(self.sensor)
        size, reach = np.array([t, t, 1.0]), self.body.X.max() * t
        away, min_J = correction(self.body, load)
        error = _errors((np.abs((self.compliance - self.coarse) @ force) + np.abs(away)) * size, reach)
        notes = () if np.all(np.isfinite(error)) else ("strains too large for a linear layer: use the planar one",)
        report = SolveReport(
            "linear", len(self.body.free) + 3, 1, 0.0, _relative(error, q * size, reach), time.perf_counter() - began,
            notes=notes, min_J=min_J,
        )
        return Equilibrium(wrench, _pose(self.sensor, q * size), Pose(*error), q, report)


def planar_layer(sensor: Sensor, tolerance: float = 1e-2) -> PlanarLayer:
    """Return the finite-strain model of a sensor's layer.

    Parameters
    ----------
    sensor : Sensor
        With a target and an elastomer.
    tolerance : float
        Asked error of the pose over the size of the displacement; picks the mesh.

    Raises
    ------
    ValueError
        For a scene without target or elastomer, or a tolerance outside (0, 1).
    """
    (fine, coarse), kinds = _rung(tolerance)
    pairs = (tuple(bonded_body(sensor, Fineness(cells, *kind)) for cells in (fine, coarse)) for kind in kinds)
    return PlanarLayer(sensor, tolerance, tuple((first, second) for first, second in pairs))


def linear_layer(sensor: Sensor, tolerance: float = 1e-2) -> LinearLayer:
    """Return the small-strain model of a sensor's layer; arguments and errors as of `planar_layer`."""
    cells, _ = _rung(tolerance)
    bodies = [bonded_body(sensor, Fineness(count, *_STRONG)) for count in cells]
    return LinearLayer(sensor, bodies[0], *(compliance(body, rest(body), np.zeros(3)) for body in bodies))


def deformed_mesh(model: PlanarLayer, equilibrium: Equilibrium) -> tuple[Array, Indices, Array]:
    """Return the deformed layer for pictures.

    Returns
    -------
    points : ndarray, shape (n, 2)
        Nodes x, z in the sensor's coordinates [m].
    quads : ndarray, shape (m, 4)
        Corners of the cells, counter-clockwise.
    J : ndarray, shape (m,)
        Mean volume ratio of each cell.
    """
    t = _thickness(model.sensor)
    fine = model.meshes[int(equilibrium.state[0])][0]
    state, mesh = _unpacked(fine, equilibrium.state[1:]), fine.mesh
    points = (mesh.nodes + state.u.reshape(-1, 2)) * t
    points[:, 1] += _standoff(model.sensor)
    corners = mesh.nodes[mesh.cells[:, :4]]
    turn = np.argsort(np.arctan2(*(corners - corners.mean(axis=1, keepdims=True)).T[::-1]).T, axis=1)
    quads = np.take_along_axis(mesh.cells[:, :4], turn, axis=1)
    return points, quads, deformation(mesh, state.u)[1].mean(axis=1)


def _standoff(sensor: Sensor) -> float:
    """Height of the layer's bottom face above the coils [m]."""
    return sensor.elastomer.standoff if sensor.elastomer is not None else 0.0


def _tried(layer: PlanarLayer, number: int, start: Equilibrium | None, wrench: Wrench) -> tuple[Equilibrium, float]:
    """The last equilibrium towards a wrench on one pair of meshes, and how much of the path that is."""
    sensor, meshes = layer.sensor, layer.meshes[number]
    patience = _PATIENCE[number == len(layer.meshes) - 1]
    states, before = tuple(rest(body) for body in meshes), Wrench()
    if start is not None and start.state.size == 1 + _size(meshes) and start.state[0] == number:
        first, second = np.split(start.state[1:], [_size(meshes[:1])])
        states, before = (_unpacked(meshes[0], first), _unpacked(meshes[1], second)), start.wrench
    loads = (scaled_load(sensor, before), scaled_load(sensor, wrench))
    fine = follow(meshes[0], states[0], loads, smallest=patience)
    midway = loads[0] + fine.reached * (loads[1] - loads[0])
    coarse = follow(meshes[1], states[1], (loads[0], midway), smallest=patience)
    part = fine.reached * coarse.reached
    if coarse.reached < 1.0:  # both must rest under one load for the error to mean something
        fine = follow(meshes[0], states[0], (loads[0], loads[0] + part * (loads[1] - loads[0])), smallest=patience)
    found = _answer(sensor, meshes, wrench_between(before, wrench, part), (fine.state, coarse.state))
    notes = (*found.report.notes, _BUCKLES) if part < 1.0 and (fine.buckled or coarse.buckled) else found.report.notes
    report = replace(found.report, notes=notes)
    return replace(found, report=report, state=np.concatenate([[number], found.state])), part


def _answer(sensor: Sensor, meshes: tuple[Bonded, Bonded], wrench: Wrench, found: tuple[State, State]) -> Equilibrium:
    """Equilibrium with its errors from the two meshes."""
    (body, companion), (fine, coarse) = meshes, found
    t = _thickness(sensor)
    size, reach = np.array([t, t, 1.0]), body.X.max() * t
    ratio = np.sqrt(len(body.mesh.cells) / len(companion.mesh.cells))
    error = _errors(np.abs(fine.q - coarse.q) * size / (ratio - 1.0), reach)
    report = SolveReport(
        "planar", len(body.free) + 3, fine.iterations + coarse.iterations, fine.residual,
        _relative(error, fine.q * size, reach), 0.0, notes=_folds(body, fine, sensor), min_J=fine.min_J,
    )
    state = np.concatenate([packed(fine), packed(coarse)])
    return Equilibrium(wrench, _pose(sensor, fine.q * size), Pose(*error), state, report)


def _ended(last: Equilibrium, wrench: Wrench, part: float) -> str:
    """Say where a load path ended."""
    return (
        f"wrench: the layer could be followed to F_x = {last.wrench.F_x:.6g} N, F_z = {last.wrench.F_z:.6g} N, "
        f"M = {last.wrench.M:.6g} N m ({part:.1%} of the path), not to F_x = {wrench.F_x:.6g} N, "
        f"F_z = {wrench.F_z:.6g} N, M = {wrench.M:.6g} N m; smallest volume ratio there {last.report.min_J:.3g}"
    )


def _thickness(sensor: Sensor) -> float:
    """Thickness of the layer [m]."""
    return sensor.elastomer.thickness if sensor.elastomer is not None else 0.0


def _rung(tolerance: float) -> tuple[tuple[int, int], tuple[tuple[float, float], ...]]:
    """Cells through the thickness, and kinds of meshes, for a tolerance."""
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance: must lie between 0 and 1, got {tolerance}")
    return next((rung for error, rung in _LADDER if tolerance >= error), _LADDER[-1][1])


def _check_load(wrench: Wrench) -> None:
    """Refuse a wrench that is not a number."""
    if not np.all(np.isfinite([wrench.F_x, wrench.F_z, wrench.M])):
        raise ValueError(f"wrench: must be finite numbers, got {wrench}")


def _pose(sensor: Sensor, q: Array) -> Pose:
    """Pose from the target's displacement (d_h, d_z) [m] and rotation."""
    return Pose(float(q[0]), float(_standoff(sensor) + _thickness(sensor) + q[1]), float(q[2]))


def _errors(difference: Array, reach: float) -> tuple[float, float, float]:
    """Errors of d_h, d_v, alpha, none better than a share of the worst; an angle counts at the target's end."""
    lever = np.array([1.0, 1.0, reach])
    floor = _SHARE * np.max(difference * lever) / lever
    d_h, d_v, alpha = np.maximum(difference, floor)
    return float(d_h), float(d_v), float(alpha)


def _relative(error: tuple[float, float, float], q: Array, reach: float) -> float:
    """Largest error over the size of the displacement, an angle counted at the target's end."""
    lever = np.array([1.0, 1.0, reach])
    size = float(np.max(np.abs(q) * lever))
    return float(np.max(np.array(error) * lever)) / size if size > 0.0 else 0.0


def _size(bodies: tuple[Bonded, ...]) -> int:
    """Length of the packed states of some meshes."""
    return sum(2 * len(body.mesh.nodes) + 3 + 3 * len(body.mesh.cells) for body in bodies)


def _unpacked(body: Bonded, array: Array) -> State:
    """State from one array."""
    n, cells = 2 * len(body.mesh.nodes), len(body.mesh.cells)
    _, J = deformation(body.mesh, array[:n])
    return State(array[:n], array[n : n + 3], array[n + 3 :][: 3 * cells].reshape(-1, 3), min_J=float(J.min()))


def _folds(body: Bonded, state: State, sensor: Sensor) -> tuple[str, ...]:
    """Sentences about free faces that passed the ground or the target's bottom face."""
    target = sensor.target
    if target is None:
        return ()
    sides, top = _free_faces(body)
    place = body.mesh.nodes + state.u.reshape(-1, 2)
    notes = []
    if np.any(place[sides, 1] < -1e-6):
        notes.append("a free face folds onto the ground: contact is not modelled, the true layer is stiffer")
    cos, sin = np.cos(state.q[2]), np.sin(state.q[2])
    x, z = (place[np.concatenate([sides, top])] - [state.q[0], 1.0 + state.q[1]]).T
    along, above = x * cos - z * sin, x * sin + z * cos
    if np.any((above > 1e-6) & (np.abs(along) < body.X.max() * (1 - 1e-9))):
        notes.append("a free face folds onto the target: contact is not modelled, the true layer is stiffer")
    return tuple(notes)


def _free_faces(body: Bonded) -> tuple[Indices, Indices]:
    """Nodes of the two sides, and of the top face beside the target."""
    x, z = body.mesh.nodes.T
    half = body.mesh.x[-1]
    side = np.flatnonzero((np.abs(x) > half - 1e-9) & (z > 1e-9) & (z < 1.0 - 1e-9))
    return side, np.flatnonzero((z > 1.0 - 1e-9) & (np.abs(x) > body.X.max() + 1e-9))
