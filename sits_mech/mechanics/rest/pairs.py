"""How does a layer solved on two meshes become a pose with its errors?

The bonded corners are singular, so the pose converges slower than the elements could; what two meshes differ by says
how far the finer one is off, by the order between them, which whoever made the pair knows (pad/): a share of the
difference may be added to the finer one's pose, and a share of it is called its error. No component is called better
than a share of the worst, an angle counted at the target's end. Of forces that hold the target, likewise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sits_mech.geometry.collision import ground_notes
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.faces.face_contact import face_notes
from sits_mech.mechanics.rest.body import Bonded, State, packed, rest, unpacked
from sits_mech.mechanics.rest.control import Control
from sits_mech.mechanics.rest.newton import Held
from sits_mech.mechanics.rest.path import Outcome, follow
from sits_mech.quantities import WRENCH, Array, Equilibrium, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.silicone.stability import layer_notes

_STRETCHED = 0.001  # share of the silicone that may be stretched more than what is called its largest stretch


@dataclass(frozen=True)
class Scales:
    """What scaled motions and loads stand for.

    Attributes
    ----------
    thickness : float
        Of the layer [m].
    force : float
        That is one in the body's scales [N]; moments in it times the thickness.
    standoff : float
        Below the layer [m].
    share : float
        Of the pad that is meshed: a half, or 1; the loads on the body are that of the target's.
    """

    thickness: float
    force: float
    standoff: float
    share: float = 1.0

    @property
    def lengths(self) -> Array:
        """Of the components of q [m, rad]."""
        t = self.thickness
        return np.array([t, t, 1.0, t, 1.0, 1.0])

    @property
    def loads(self) -> Array:
        """Of the components of a load on the body [N, N m]."""
        t = self.thickness
        return self.force / self.share * np.array([1.0, 1.0, t, 1.0, t, t])

    def load(self, wrench: Wrench) -> Array:
        """Return a load on the body, shape (6,)."""
        return np.asarray(wrench.components / self.loads)

    def wrench(self, load: Array) -> Wrench:
        """Return the target's load in SI, from that on the body, shape (3,) or (6,)."""
        return Wrench(*(float(value) for value in load * self.loads[: len(load)]))

    def pose(self, q: Array) -> Pose:
        """Return the pose in SI of a motion, shape (3,) or (6,)."""
        found = q * self.lengths[: len(q)]
        found[1] += self.standoff + self.thickness
        return Pose.of(found)


class Pair(NamedTuple):
    """Two meshes of a layer: that of the answer, and that of the error estimate.

    Of what their poses differ by, `added` goes to the finer one's pose and `owned` is its error; `share` of the worst
    component's error is what every component owns to.
    """

    fine: Bonded
    coarse: Bonded
    added: float
    owned: float
    share: float

    @property
    def size(self) -> int:
        """Length of the packed states of both."""
        return self.fine.size + self.coarse.size


class Solved(NamedTuple):
    """The last equilibrium on the way to what is given, how much of the way that is, and what ended it."""

    found: Equilibrium
    part: float
    reason: str = ""


def solve_pair(
    sensor: Sensor, pair: Pair, scales: Scales, start: Equilibrium | None, control: Control, *, smallest: float,
    most: float = np.inf,
) -> Solved:  # fmt: skip
    """Follow the way to what is given on both meshes, the coarse one first: it is the first to give up.

    Parameters
    ----------
    sensor : Sensor
    pair : Pair
    scales : Scales
    start : Equilibrium or None
        On the same meshes; from rest where it is None.
    control : Control
    smallest : float
        Smallest increment of the path.
    most : float
        Iterations that a path is given, times unknowns.
    """
    bodies, states = (pair.fine, pair.coarse), starts(pair, scales, start)
    held, end = aim(pair.fine, scales, control)
    begin = np.where(held, states[0].q, states[0].load)

    def followed(number: int, goal: Array, spend: float) -> Outcome:
        return follow(
            bodies[number], states[number], (begin, goal), smallest=smallest, held=held, beside=control.held[3:],
            most=spend,
        )  # fmt: skip

    coarse = followed(1, end, most / len(bodies[1].free))
    midway = begin + coarse.reached * (end - begin)
    fine = followed(0, midway, most / len(bodies[0].free))
    part, reason = coarse.reached * fine.reached, fine.reason or coarse.reason
    if fine.reached < 1.0:  # both must rest under one goal for the error to mean something
        coarse = followed(1, begin + part * (end - begin), np.inf)
    found = _answer(sensor, pair, scales, control, (fine.state, coarse.state))
    if part == 1.0:
        given = {name: value for name in WRENCH if (value := getattr(control, name)) is not None}
        found = replace(found, wrench=replace(found.wrench, **given))
    return Solved(found, part, reason)


def aim(body: Bonded, scales: Scales, control: Control) -> tuple[Held, Array]:
    """Return which places of the target's motion are given, and what is given, scaled; shape (k,) each.

    A whole body is kept in the plane where nothing that is given leaves it: a mesh of the user's need not be its own
    mirror image to the last digit.
    """
    k, held = body.components, control.held
    if k == 6 and not control.beside:
        held[3:] = True
    return held[:k], control.goal(scales.lengths, scales.loads)[:k]


def starts(pair: Pair, scales: Scales, start: Equilibrium | None) -> list[State]:
    """Return where both meshes start: at an equilibrium on them, or at rest."""
    bodies = (pair.fine, pair.coarse)
    if start is None:
        return [rest(body) for body in bodies]
    load = scales.load(start.wrench)[: pair.fine.components]
    halves = np.split(start.state, [pair.fine.size])
    return [unpacked(body, half, load) for body, half in zip(bodies, halves, strict=True)]


def levers(body: Bonded, thickness: float) -> Array:
    """Return what turns errors of a motion's components in SI into those at the target's end, shape (6,) [1, m]."""
    x, y = (float(reach) for reach in np.abs(body.X[:, :2]).max(axis=0) * thickness)
    return np.array([1.0, 1.0, x, 1.0, y or x, max(x, y)])


def errors_of(difference: Array, lever: Array, share: float) -> Array:
    """Return errors of components, none better than a share of the worst; an angle counts at the target's end."""
    floor = share * np.max(difference * lever) / lever
    return np.asarray(np.maximum(difference, floor))


def relative(error: Array, moved: Array, lever: Array) -> float:
    """Return the largest error over the size of the displacement, an angle counted at the target's end."""
    size = float(np.max(np.abs(moved) * lever))
    return float(np.max(error * lever)) / size if size > 0.0 else 0.0


def largest_stretch(body: Bonded, u: Array) -> float:
    """Return the largest principal stretch, or reciprocal of one, that all but 0.1 % of the silicone stays below."""
    F, J = deformation(body.mesh, u)
    if F.shape[-1] == 4:
        half = 0.5 * (F**2).sum(axis=-1)
        greater = np.sqrt(half + np.sqrt(np.maximum(half**2 - J**2, 0.0)))
        smaller = J / greater
    else:
        smaller, _, greater = np.moveaxis(np.linalg.svd(F.reshape(*J.shape, 3, 3), compute_uv=False), -1, 0)[::-1]
    stretch = np.maximum(greater, 1.0 / smaller).ravel()
    order = np.argsort(stretch)
    below = np.cumsum(body.mesh.inside.weights.ravel()[order])
    return max(1.0, float(stretch[order][np.searchsorted(below, (1.0 - _STRETCHED) * below[-1])]))


def law_notes(sensor: Sensor, body: Bonded, u: Array) -> tuple[str, ...]:
    """Return what is to be said of the silicone's law in a deformed state: its stability, the range of its data."""
    return () if sensor.elastomer is None else layer_notes(sensor.elastomer.silicone, largest_stretch(body, u))


def load_words(load: Mapping[str, float]) -> str:
    """Return a load in words, from its components [N, N m]; what leaves the plane only where it is not zero."""
    shown = {name: value for name, value in load.items() if name in WRENCH[:3] or value != 0.0}
    return ", ".join(f"{name} = {value:.6g} N{' m' * name.startswith('M')}" for name, value in shown.items())


def _answer(
    sensor: Sensor, pair: Pair, scales: Scales, control: Control, found: tuple[State, State]
) -> Equilibrium:
    """Equilibrium with its errors from the two meshes."""
    (fine, coarse), body = found, pair.fine
    k, t = body.components, scales.thickness
    lengths, lever, (held, _) = scales.lengths[:k], levers(body, t)[:k], aim(body, scales, control)
    apart = (fine.q - coarse.q) * lengths
    error = errors_of(np.where(held, 0.0, pair.owned * np.abs(apart)), lever, pair.share)
    error = np.where(held, 0.0, error)
    best = fine.q + pair.added * np.where(held, 0.0, apart) / lengths
    beneath = ground_notes(sensor, scales.pose(best))
    if beneath:  # the true target is held there: the error is the whole displacement
        error = np.where(held, 0.0, np.maximum(error, np.max(np.abs(best * lengths) * lever) / lever))
    off = relative(error, best * lengths, lever)
    if held.any():
        weight = 1.0 / (levers(body, 1.0)[:k])
        forces = pair.owned * float(np.max(np.abs(fine.load - coarse.load) * weight))
        off = max(off, forces / max(float(np.max(np.abs(fine.load) * weight)), 1e-300))
    plate = sensor.target.thickness / t if sensor.target is not None else 0.0
    notes = face_notes(body.faces, body.mesh, body.parts, fine.u, fine.q, plate)
    notes = (*notes, *beneath, *law_notes(sensor, body, fine.u))
    report = SolveReport(
        "", len(body.free) + k, fine.iterations + coarse.iterations, fine.residual, float(off), 0.0, notes=notes,
        min_J=fine.min_J,
    )
    state = np.concatenate([packed(fine), packed(coarse)])
    return Equilibrium(scales.wrench(fine.load), scales.pose(best), Pose.of(error), state, report)
