"""From wrench to pose: the silicone layer in plane strain, at finite strain (`planar`) or small strain (`linear`).

The layer of width W and thickness t, bonded to the rigid ground over its whole width, carries an exactly rigid target
bonded over the middle of its top face; the wrench is a dead load in newtons, spread over the elastomer's length in y.
Equations: forms.py (layer), target.py (rigid target), contact.py (free faces), newton.py and path.py (solution).
Pose: ``d_v = standoff + t - sink``. Any mix of forces and places of the target can be given (control.py).

Meshes. Several pairs stand in line, each tougher and a little less accurate than the one before (ladder.py). The
first that gets there, J positive at every quadrature point and node, with an error near the tolerance gives the answer,
or else the one with the smallest error. The error is that between the two meshes of a pair (answer.py).

Contact of the free faces with the ground and the target (scene key `elastomer.contact`) is "never" solved, "always",
or, "auto", where it matters: a load whose free faces fold onto the ground or the target is solved again with contact,
and where that moves the target by more than 1 % of its displacement, or the layer could not be followed without, it
is the answer; otherwise its effect is part of the error. The notes say which.

Range: plane strain (the true pad is softer by its ends). Neglected: viscosity, gravity, friction.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.answer import Pair, errors_of, nearly_settled, pose_of, relative, settled, unpacked
from sits_mech.mechanics.body import Bonded, rest
from sits_mech.mechanics.closed_form import finite_strain_model
from sits_mech.mechanics.control import Control, under
from sits_mech.mechanics.edges import Edges, edge_effect, edge_notes
from sits_mech.mechanics.folds import folds
from sits_mech.mechanics.forms import Indices, deformation
from sits_mech.mechanics.ladder import STRONG, cells_through, meshes_in_line
from sits_mech.mechanics.newton import compliance, correction
from sits_mech.mechanics.pad import Fineness, bonded_body, force_unit, scaled_load
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench, refuse_beside
from sits_mech.sensor import Sensor

_LENIENCE = 2.0  # the estimate is on the safe side: up to so many tolerances no other mesh is tried
_PATIENCE = (0.25, 0.02, 1e-3)  # smallest increment of the load path: meshes wait, one does, none does
_EFFECT = 0.01  # of the displacement: what contact may be worth and still be left out


@dataclass(frozen=True)
class PlanarLayer:
    """The layer at finite strain; made by `planar_layer`.

    Attributes
    ----------
    sensor : Sensor
    tolerance : float
        Asked error of the pose over the size of the displacement.
    meshes : tuple of Pair
        Mesh of the answer and of its error estimate, in the order in which they are tried.
    touching : int
        How many at the end have contact: the last of those before them once more, and one that is tougher still.
    edges : Edges or None
        What the fillets of `elastomer.edge_radius` do (edges.py); None for sharp edges.
    """

    sensor: Sensor
    tolerance: float
    meshes: tuple[Pair, ...]
    touching: int = 0
    edges: Edges | None = None

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench` [N, N m], reached from `start` or from rest.

        Raises
        ------
        SolveFailed
            If the load path ends before the wrench; its `last` is the last equilibrium on the way.
        """
        _check_load(wrench)
        refuse_beside("planar", wrench, "block")
        return self.controlled(under(wrench), start=start)

    def controlled(self, control: Control, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium with forces or places of the target given, reached from `start` or from rest.

        Its `wrench` holds the forces, given or found; `report.estimated_error` covers the forces found too. Errors as
        of `equilibrium`.
        """
        began = time.perf_counter()
        last, part = _first_good(self, range(len(self.meshes) - self.touching), start, control)
        if self.touching and (part < 1.0 or _touches(self, last)):
            last, part = _in_contact(self, (last, part), start, control)
        report = replace(last.report, seconds=time.perf_counter() - began)
        if part == 1.0:
            report = replace(report, notes=(*report.notes, *_edge_notes(self.sensor, self.edges, last.wrench)))
            if report.estimated_error > self.tolerance:
                missed = f"estimated error {report.estimated_error:.2g}: the tolerance {self.tolerance:g} is missed"
                report = replace(report, notes=(*report.notes, missed))
            return replace(last, report=report)
        report = replace(report, status="load path ended", notes=(*report.notes, f"reached {part:.1%} of the path"))
        raise SolveFailed(_ended(last, control, part), report, replace(last, report=report))


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
    edges: Edges | None = None

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose under `wrench` by linear elasticity; `start` plays no part.

        The error is that of the mesh and the first Newton correction towards finite strain.

        Raises
        ------
        SolveFailed
            Where that error is as large as the displacement: the load is none for a linear layer.
        """
        began = time.perf_counter()
        _check_load(wrench)
        refuse_beside("linear", wrench, "block")
        load = scaled_load(self.sensor, wrench)
        force = np.array([load[0], -load[1], load[2] + self.body.height * load[0]])
        q = self.compliance @ force
        t = _thickness(self.sensor)
        size, reach = np.array([t, t, 1.0]), self.body.X.max() * t
        away, min_J = correction(self.body, load)
        error = errors_of((np.abs((self.compliance - self.coarse) @ force) + np.abs(away)) * size, reach)
        report = SolveReport(
            "linear", len(self.body.free) + 3, 1, 0.0, relative(error, q * size, reach), time.perf_counter() - began,
            notes=_edge_notes(self.sensor, self.edges, wrench), min_J=min_J,
        )
        if not report.estimated_error < 1.0:
            report = replace(report, status="strains too large")
            ask = f"ask for {finite_strain_model(self.sensor)}"
            raise SolveFailed(f"wrench: strains are too large for one compliance, got {wrench}: {ask}", report)
        return Equilibrium(wrench, pose_of(self.sensor, q * size), Pose(*error), q, report)


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
    return PlanarLayer(sensor, tolerance, *meshes_in_line(sensor, tolerance), edge_effect(sensor))


def linear_layer(sensor: Sensor, tolerance: float = 1e-2) -> LinearLayer:
    """Return the small-strain model of a sensor's layer; arguments and errors as of `planar_layer`."""
    bodies = [bonded_body(sensor, Fineness(count, STRONG)) for count in cells_through(tolerance)]
    fine, coarse = (compliance(body, rest(body), np.zeros(3)) for body in bodies)
    return LinearLayer(sensor, bodies[0], fine, coarse, edge_effect(sensor))


def deformed_mesh(model: PlanarLayer, equilibrium: Equilibrium) -> tuple[Array, Indices, Array]:
    """Return the deformed layer for pictures.

    Returns
    -------
    points : ndarray, shape (n, 2)
        Nodes x, z in the sensor's coordinates [m].
    quads : ndarray, shape (m, 4)
        Corners of the cells, counter-clockwise; of a triangle one of them twice.
    J : ndarray, shape (m,)
        Mean volume ratio of each cell.
    """
    elastomer = model.sensor.elastomer
    t, standoff = (elastomer.thickness, elastomer.standoff) if elastomer is not None else (0.0, 0.0)
    fine = model.meshes[int(equilibrium.state[0])].fine
    mesh, u = fine.mesh, equilibrium.state[1 : 1 + fine.mesh.nodes.size]
    points = (mesh.nodes + u.reshape(-1, 2)) * t
    points[:, 1] += standoff
    corners = mesh.nodes[mesh.cells[:, :4]]
    turn = np.argsort(np.arctan2(*(corners - corners.mean(axis=1, keepdims=True)).T[::-1]).T, axis=1)
    quads = np.take_along_axis(mesh.cells[:, :4], turn, axis=1)
    return points, quads, deformation(mesh, u)[1].mean(axis=1)


def stored(model: PlanarLayer, equilibrium: Equilibrium) -> float:
    """Return the energy of a layer at rest [J], that of its contacts included: the work of the target's forces."""
    body, elastomer = model.meshes[int(equilibrium.state[0])].fine, model.sensor.elastomer
    t = elastomer.thickness if elastomer is not None else 0.0
    state = unpacked(body, equilibrium.state[1:])
    parts = sum(part(state.u, state.q).energy for part in body.parts)
    return force_unit(model.sensor) * t * (body.element.tangent(body.mesh, body.law, body.K, state.u).energy + parts)


def _first_good(
    layer: PlanarLayer, numbers: range, start: Equilibrium | None, control: Control
) -> tuple[Equilibrium, float]:
    """Of some pairs of meshes, the first good answer, or else the farthest and best."""
    best: tuple[Equilibrium, float] | None = None
    waiting = [len(layer.meshes) - 1 - number for number in numbers]
    for number, left in zip(numbers, waiting, strict=True):
        pair, own = layer.meshes[number], None
        if best is not None and best[1] == 1.0 and pair.fine.guarded:
            continue
        if start is not None and start.state.size == 1 + pair.size and start.state[0] == number:
            own = replace(start, state=start.state[1:])
        found, part = settled(layer.sensor, pair, own, control, _PATIENCE[max(0, 2 - left)])
        found = replace(found, state=np.concatenate([[number], found.state]))
        if best is None or (part, -found.report.estimated_error) > (best[1], -best[0].report.estimated_error):
            best = found, part
        if best[1] == 1.0 and best[0].report.estimated_error <= _LENIENCE * layer.tolerance:
            break
        if best[1] == 1.0 and number < len(layer.meshes) - layer.touching and layer.touching and _touches(layer, found):
            break
    if best is None:
        raise ValueError("meshes: there must be at least one pair")
    return best


def _in_contact(
    layer: PlanarLayer, free: tuple[Equilibrium, float], start: Equilibrium | None, control: Control
) -> tuple[Equilibrium, float]:
    """The answer with contact, or the one without it where contact is worth little."""
    found, part = free
    count = len(layer.meshes)
    twin = int(found.state[0]) + layer.touching - 1
    if part == 1.0 and twin >= count - layer.touching:
        bodies = layer.meshes[int(found.state[0])].fine, layer.meshes[twin].fine
        changes = nearly_settled(layer.sensor, bodies, replace(found, state=found.state[1:]), control)
        if changes is not None and _negligible(layer, found, changes):
            return _without(layer, found, changes), 1.0
        begin = replace(found, state=np.concatenate([[twin], found.state[1:]]))
        other, reached = _first_good(layer, range(twin, count), begin, control)
        if reached == 1.0:
            return _chosen(layer, free, (other, reached))
    return _chosen(layer, free, _first_good(layer, range(count - layer.touching, count), start, control))


def _touches(layer: PlanarLayer, found: Equilibrium) -> bool:
    """Whether a free face lies on or behind a plane."""
    body = layer.meshes[int(found.state[0])].fine
    return folds(body, unpacked(body, found.state[1:])).touch


def _chosen(
    layer: PlanarLayer, free: tuple[Equilibrium, float], touching: tuple[Equilibrium, float]
) -> tuple[Equilibrium, float]:
    """With or without contact: the farther; of two that arrive, the one without only where contact is worth little."""
    (one, part), (other, farther) = free, touching
    if part < 1.0 or farther < 1.0:
        return (other, farther) if farther >= part else (one, part)
    changes = _places(other)[0] - _places(one)[0], _places(other)[1] - _places(one)[1]
    return (_without(layer, one, changes), 1.0) if _negligible(layer, one, changes) else (other, 1.0)


def _places(found: Equilibrium) -> tuple[Array, Array]:
    """Pose and wrench as arrays."""
    pose, wrench = found.pose, found.wrench
    return np.array([pose.d_h, pose.d_v, pose.alpha]), np.array([wrench.F_x, wrench.F_z, wrench.M])


def _effect(layer: PlanarLayer, found: Equilibrium, changes: tuple[Array, Array]) -> float:
    """What contact changes, over the target's displacement or the forces, the larger share."""
    pose, forces = _places(found)
    t = _thickness(layer.sensor)
    size = np.array([1.0, 1.0, layer.meshes[0].fine.X.max() * t])
    away = (pose - [0.0, pose_of(layer.sensor, np.zeros(3)).d_v, 0.0] + changes[0]) * size
    moved = float(np.max(np.abs(changes[0] * size))) / max(float(np.max(np.abs(away))), 1e-300)
    with_contact = float(np.max(np.abs(forces + changes[1])[:2]))
    return max(moved, float(np.max(np.abs(changes[1][:2]))) / max(with_contact, 1e-300))


def _negligible(layer: PlanarLayer, found: Equilibrium, changes: tuple[Array, Array]) -> bool:
    """Whether contact changes little."""
    return _effect(layer, found, changes) <= _EFFECT


def _without(layer: PlanarLayer, found: Equilibrium, changes: tuple[Array, Array]) -> Equilibrium:
    """An answer that leaves contact out, what that changes added to its errors."""
    effect = _effect(layer, found, changes)
    notes = (*found.report.notes, f"contact would change this by {effect:.2g}, which is in the estimated error")
    error = np.array([found.error.d_h, found.error.d_v, found.error.alpha]) + np.abs(changes[0])
    report = replace(found.report, notes=notes, estimated_error=found.report.estimated_error + effect)
    return replace(found, error=Pose(*(float(value) for value in error)), report=report)


def _edge_notes(sensor: Sensor, edges: Edges | None, wrench: Wrench) -> tuple[str, ...]:
    """What the fillets do to the pose under a wrench."""
    return () if edges is None else edge_notes(edges, scaled_load(sensor, wrench), _thickness(sensor))


def _ended(last: Equilibrium, control: Control, part: float) -> str:
    """Say where a load path ended."""
    asked = ", ".join(f"{name} = {value:.6g}" for name, value in vars(control).items() if value is not None)
    return (
        f"wrench: the layer could be followed to F_x = {last.wrench.F_x:.6g} N, F_z = {last.wrench.F_z:.6g} N, "
        f"M = {last.wrench.M:.6g} N m ({part:.1%} of the path), not to {asked} [N, N m, m, rad]; "
        f"smallest volume ratio there {last.report.min_J:.3g}"
    )


def _thickness(sensor: Sensor) -> float:
    """Thickness of the layer [m]."""
    return sensor.elastomer.thickness if sensor.elastomer is not None else 0.0


def _check_load(wrench: Wrench) -> None:
    """Refuse a wrench that is not a number."""
    if not np.all(np.isfinite(wrench.components)):
        raise ValueError(f"wrench: must be finite numbers, got {wrench}")
