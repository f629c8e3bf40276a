"""How does a layer solved on two meshes become a pose with its errors?

The corner singularity makes the pose converge as h^1.2 to h^3 on these gradings; the error is extrapolated from the
difference of the two meshes with the order that the caller names, lower than that to be on the safe side, and no
component is called better than a twentieth of the worst. Of forces that hold the target, likewise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.body import Bonded, State, packed, rest
from sits_mech.mechanics.control import Control
from sits_mech.mechanics.folds import fold_notes
from sits_mech.mechanics.forms import deformation
from sits_mech.mechanics.newton import newton
from sits_mech.mechanics.pad import force_unit
from sits_mech.mechanics.path import REASONS, Outcome, follow
from sits_mech.quantities import WRENCH, Array, Equilibrium, Pose, SolveReport, Wrench
from sits_mech.sensor import Sensor
from sits_mech.silicone.stability import layer_notes

_SHARE = 0.05  # of the worst component's error that every component owns to
_NEARLY = 1e-2  # residual at which a small change is known to some percent of it
_TOUCHED = 0.001  # share of the layer's section that may be stretched more than what is called its largest stretch


class Pair(NamedTuple):
    """Two meshes of a layer: that of the answer, that of the error estimate, and the order between them."""

    fine: Bonded
    coarse: Bonded
    order: float = 1.0

    @property
    def size(self) -> int:
        """Length of the packed states of both."""
        return _size(self.fine) + _size(self.coarse)


def settled(
    sensor: Sensor, pair: Pair, start: Equilibrium | None, control: Control, patience: float
) -> tuple[Equilibrium, float]:
    """Return the last equilibrium on the way to what is given, and how much of the way that is.

    Parameters
    ----------
    sensor : Sensor
    pair : Pair
    start : Equilibrium or None
        On the same meshes, or from rest.
    control : Control
    patience : float
        Smallest increment of the path.
    """
    states = _states(sensor, pair, start)
    held, unit, t = control.held, force_unit(sensor), _thickness(sensor)
    end = control.goal(t, unit)
    begins = [np.where(held, state.q, state.load) for state in states]
    fine = follow(pair.fine, states[0], (begins[0], end), smallest=patience, held=held)
    midway = begins[0] + fine.reached * (end - begins[0])
    coarse = follow(pair.coarse, states[1], (begins[1], midway), smallest=patience, held=held)
    part = fine.reached * coarse.reached
    if coarse.reached < 1.0:  # both must rest under one goal for the error to mean something
        midway = begins[0] + part * (end - begins[0])
        again = follow(pair.fine, states[0], (begins[0], midway), smallest=patience, held=held)
        fine = Outcome(again.state, part, coarse.reason)
    found = _answer(sensor, pair, control, (fine.state, coarse.state))
    if part < 1.0:
        notes = (*found.report.notes, REASONS[fine.reason or coarse.reason])
        return replace(found, report=replace(found.report, notes=notes)), part
    given = (control.F_x, control.F_z, control.M)
    reached = (found.wrench.F_x, found.wrench.F_z, found.wrench.M)
    exact = Wrench(*(own if own is not None else other for own, other in zip(given, reached, strict=True)))
    return replace(found, wrench=exact), part


def nearly_settled(
    sensor: Sensor, bodies: tuple[Bonded, Bonded], found: Equilibrium, control: Control
) -> tuple[Array, Array] | None:
    """Return how far an equilibrium's target and forces move on another body of the same mesh, nearly at rest there.

    Parameters
    ----------
    sensor : Sensor
    bodies : (Bonded, Bonded)
        That of the equilibrium, and the other one.
    found : Equilibrium
    control : Control
        What is given.

    Returns
    -------
    pose : ndarray, shape (3,)
        Changes of d_h, d_v, alpha [m, rad].
    forces : ndarray, shape (3,)
        Changes of F_x, F_z, M [N, N m].
        None where Newton's method does not get there at once.
    """
    t, unit = _thickness(sensor), force_unit(sensor)
    load = np.array([found.wrench.F_x, found.wrench.F_z, found.wrench.M / t]) / unit
    here = replace(unpacked(bodies[0], found.state), load=load)
    there, _ = newton(bodies[1], here, control.goal(t, unit), control.held, until=_NEARLY)
    if not there.residual <= _NEARLY:
        return None
    return (there.q - here.q) * [t, t, 1.0], (there.load - here.load) * unit * [1.0, 1.0, t]


def errors_of(difference: Array, reach: float) -> tuple[float, float, float]:
    """Return errors of d_h, d_v, alpha, none better than a share of the worst; an angle counts at the target's end."""
    lever = np.array([1.0, 1.0, reach])
    floor = _SHARE * np.max(difference * lever) / lever
    d_h, d_v, alpha = np.maximum(difference, floor)
    return float(d_h), float(d_v), float(alpha)


def relative(error: tuple[float, float, float], q: Array, reach: float) -> float:
    """Return the largest error over the size of the displacement, an angle counted at the target's end."""
    lever = np.array([1.0, 1.0, reach])
    size = float(np.max(np.abs(q) * lever))
    return float(np.max(np.array(error) * lever)) / size if size > 0.0 else 0.0


def pose_of(sensor: Sensor, q: Array) -> Pose:
    """Return the pose from the target's displacement (d_h, d_z) [m] and rotation."""
    standoff = sensor.elastomer.standoff if sensor.elastomer is not None else 0.0
    return Pose(float(q[0]), float(standoff + _thickness(sensor) + q[1]), float(q[2]))


def unpacked(body: Bonded, array: Array) -> State:
    """Return a state from the beginning of an array."""
    n, last = body.mesh.nodes.size, _size(body)
    _, J = deformation(body.mesh, array[:n])
    return State(array[:n], array[n : n + 3], array[n + 3 : last].reshape(-1, 3), min_J=float(J.min()))


def largest_stretch(body: Bonded, u: Array) -> float:
    """Return the largest principal stretch, or reciprocal of one, that all but 0.1 % of the silicone stays below."""
    F, J = body.element.deformation(body.mesh, u)
    if F.shape[-1] == 4:
        half = 0.5 * (F**2).sum(axis=-1)
        greater = np.sqrt(half + np.sqrt(np.maximum(half**2 - J**2, 0.0)))
        smaller = J / greater
    else:
        smaller, _, greater = np.moveaxis(np.linalg.svd(F.reshape(*J.shape, 3, 3), compute_uv=False), -1, 0)[::-1]
    stretch = np.maximum(greater, 1.0 / smaller).ravel()
    order = np.argsort(stretch)
    below = np.cumsum(body.mesh.weights.ravel()[order])
    return max(1.0, float(stretch[order][np.searchsorted(below, (1.0 - _TOUCHED) * below[-1])]))


def law_notes(sensor: Sensor, body: Bonded, u: Array) -> tuple[str, ...]:
    """Return what is to be said of the silicone's law in a deformed state: its stability, the range of its data."""
    return () if sensor.elastomer is None else layer_notes(sensor.elastomer.silicone, largest_stretch(body, u))


def load_words(load: Mapping[str, float]) -> str:
    """Return a load in words, from its components [N, N m]; what leaves the plane only where it is not zero."""
    shown = {name: value for name, value in load.items() if name in WRENCH[:3] or value != 0.0}
    return ", ".join(f"{name} = {value:.6g} N{' m' * name.startswith('M')}" for name, value in shown.items())


def _answer(sensor: Sensor, pair: Pair, control: Control, found: tuple[State, State]) -> Equilibrium:
    """Equilibrium with its errors from the two meshes."""
    (fine, coarse), body = found, pair.fine
    t, unit, held = _thickness(sensor), force_unit(sensor), control.held
    size, reach = np.array([t, t, 1.0]), body.X.max() * t
    ratio = np.sqrt(len(body.mesh.cells) / len(pair.coarse.mesh.cells)) ** pair.order
    error = errors_of(np.abs(fine.q - coarse.q) * size / (ratio - 1.0), reach)
    error_d_h, error_d_v, error_alpha = (0.0 if own else value for own, value in zip(held, error, strict=True))
    error = (error_d_h, error_d_v, error_alpha)
    off = relative(error, fine.q * size, reach)
    if held.any():
        lever = np.array([1.0, 1.0, 1.0 / body.X.max()])
        forces = float(np.max(np.abs(fine.load - coarse.load) * lever)) / (ratio - 1.0)
        off = max(off, forces / max(float(np.max(np.abs(fine.load) * lever)), 1e-300))
    notes = fold_notes(body, fine, sensor.target.thickness / t if sensor.target is not None else 0.0)
    notes = (*notes, *law_notes(sensor, body, fine.u))
    report = SolveReport(
        "planar", len(body.free) + 3, fine.iterations + coarse.iterations, fine.residual, float(off), 0.0, notes=notes,
        min_J=fine.min_J,
    )
    F_x, F_z, M = (float(value) for value in fine.load * unit * [1.0, 1.0, t])
    state = np.concatenate([packed(fine), packed(coarse)])
    return Equilibrium(Wrench(F_x, F_z, M), pose_of(sensor, fine.q * size), Pose(*error), state, report)


def _states(sensor: Sensor, pair: Pair, start: Equilibrium | None) -> list[State]:
    """Where both meshes start."""
    if start is None:
        return [rest(pair.fine), rest(pair.coarse)]
    t, unit = _thickness(sensor), force_unit(sensor)
    load = np.array([start.wrench.F_x, start.wrench.F_z, start.wrench.M / t]) / unit
    halves = np.split(start.state, [_size(pair.fine)])
    bodies = (pair.fine, pair.coarse)
    return [replace(unpacked(body, half), load=load) for body, half in zip(bodies, halves, strict=True)]


def _thickness(sensor: Sensor) -> float:
    """Thickness of the layer [m]."""
    return sensor.elastomer.thickness if sensor.elastomer is not None else 0.0


def _size(body: Bonded) -> int:
    """Length of a packed state."""
    return body.mesh.nodes.size + 3 + 3 * len(body.mesh.cells)
