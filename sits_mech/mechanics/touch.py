"""From a touch to a wrench: what presses on a rigid target anywhere on its top face, and the pose that it leads to.

A rigid indenter meets a rigid plane at one point: Hertz's area, of radius (3 F r/(4 E*))^(1/3), is zero where E* is
infinite, and with steel on copper (E* = 95 GPa) 34 um under 1 N and r = 5 mm; its pressure is even about its middle, so
that it adds no moment at any size. So a touch is exactly a wrench. About the middle P of the top face, with R the
target's rotation and n = R e_z the normal of that face,

    F,    M = r x F,         r from P to the point of contact.

Sticking: F keeps its direction, and what has a radius rho rolls on the target to where its surface is parallel to it,

    r = R (x - rho n_x, y - rho n_y, 0),           F = (F_x, F_y, -F_z).

Without friction: F is normal to the face, so that it pushes the target aside as it turns, and F_z is its upright part.
What is guided keeps its middle above (x, y) in space and touches at n's own point; a pressure stays on the target:

    F = -F_z/n_z n,
    r + P = (x - rho n_x, y - rho n_y, .) in the plane of the face,    or  r = R (x, y, 0) of a pressure.

A cylinder's holder swivels about the middle of its axis, a punch's about that of its face, so that neither gives a
moment; there a cylinder is a sphere and a punch one of no radius. Sources: K. L. Johnson, Contact Mechanics (1985),
section 4.2; the rest is statics.

The pose q follows from W(q), and W from the pose: q = Q(W(q)), Q a mechanical model; the height plays no part. The
difference g = Q(W(q)) - q is brought to zero by Broyden's method from the touch at rest, B = -1/J = 1 at first. What
the pose changes of the wrench moves a pad of thickness t, modulus mu and area A by about

    t/(mu A) |dF| + |dM|/|M| theta w/2,

theta its tilt under M and w the target's side; twice as much, or |g| where that is less, counts as error, and ends the
search where it is a fifth of the model's own. A rest is held where 1/B = 1 - dQ/dW dW/dq, which is 1 without load,
has not gone through zero: det B > 0. A touch in the middle that turns nothing leaves W as it is: one solve.

Loads: a wrench on a touched target is taken about the touched point; one with moments touches elsewhere,
``x - x_0 = M/F_z, y - y_0 = -M_x/F_z``, so that symmetry.py turns and mirrors touches as it does wrenches.

On a cover (`[cover]`) a touch is no wrench: contact is solved with the pad (faces/rigid.py), in one solve, and a load
about the middle says by its moments where it presses.

Left out: friction between the two, the way to the load, an indenter or a target that gives.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, cast

import numpy as np

from sits_mech.mechanics.loads import RefinedModel
from sits_mech.quantities import TOUCH, WRENCH, Array, Equilibrium, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.parts.metal import Target
from sits_mech.scene.parts.touch import Touch, check_place, is_on
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.units import SLACK
from sits_mech.units import millimetres as mm

STEPS = 15
"""Of Broyden's method, or of secants; stable pads take 2 to 5."""
LEFT = 0.2
"""Of a model's own error, what may be left."""
_MARGIN = 2.0  # times what a change of the wrench is expected to move
_LEAST = 1e-7  # of the target's half width, the same of a model without an error
_FORCES = np.array([name.startswith("F") for name in WRENCH])
_TURN, _PLACE = [4, 2, 5], [0, 3]  # of a pose: its rotation vector, its place along x and y


class RefinedLayer(RefinedModel, MechanicalModel, Protocol):
    """A mechanical model of several meshes."""


Answer = Callable[[MechanicalModel, Sensor, Wrench, Equilibrium | None], Equilibrium]
"""What makes an equilibrium under a load about the touched point by a model, from a start."""


@dataclass(frozen=True)
class Touched:
    """A mechanical model of a target that is touched."""

    layer: MechanicalModel
    sensor: Sensor
    answer: Answer

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under a load about the touched point; raises as `touched` says."""
        return self.answer(self.layer, self.sensor, wrench, start)


@dataclass(frozen=True)
class RefinedTouched:
    """The same of a model with several meshes; see `RefinedModel`."""

    layer: RefinedLayer
    sensor: Sensor
    answer: Answer

    @property
    def rough(self) -> Touched:
        """The model on the first meshes."""
        return Touched(self.layer.rough, self.sensor, self.answer)

    def towards(self, goal: Array | None, tolerance: float, deepest: int = 99) -> Touched:
        """Return the model refined to a goal."""
        return Touched(self.layer.towards(goal, tolerance, deepest), self.sensor, self.answer)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under a load about the touched point; raises as `touched` says."""
        return self.answer(self.layer, self.sensor, wrench, start)


def answering(layer: MechanicalModel, sensor: Sensor, answer: Answer) -> MechanicalModel:
    """Return a mechanical model, of several meshes where the layer's is, whose equilibria are those of `answer`."""
    if isinstance(layer, RefinedModel):
        return RefinedTouched(cast(RefinedLayer, layer), sensor, answer)
    return Touched(layer, sensor, answer)


def touched(layer: MechanicalModel, sensor: Sensor) -> MechanicalModel:
    """Return a mechanical model whose loads are of a scene's touch; the model itself without one.

    Its `equilibrium` takes a load about the touched point, with moments one about another, and finds the pose with the
    wrench that the touch is at this pose. It raises SceneError for a place beside the target or shear without friction,
    SolveFailed as the model does, and where the touch slides off the target or is not followed.
    """
    return layer if sensor.touch is None else answering(layer, sensor, _followed)


def bare(layer: MechanicalModel) -> MechanicalModel:
    """Return the model without touch that the states of a model's equilibria belong to."""
    return layer.layer if isinstance(layer, Touched | RefinedTouched) else layer


def check_untouched(sensor: Sensor, purpose: str) -> None:
    """Refuse a touch for what follows a wrench, not a pose."""
    if sensor.touch is not None:
        raise SceneError(f"touch: must be left out of the scene for {purpose}; got a {sensor.touch.words}")


def check_force(touch: Touch | None, purpose: str) -> None:
    """Refuse the depth of a touch where forces are asked for."""
    if touch is not None and touch.depth is not None:
        raise SceneError(f"touch.depth: must be left out for {purpose}; got {mm(touch.depth)}")


def touched_place(load: Wrench) -> tuple[float, float]:
    """Return where a load about the middle of the top face presses it without moment [m]."""
    return load.M / load.F_z, -load.M_x / load.F_z


def on_target(sensor: Sensor, loads: Sequence[Wrench]) -> tuple[Wrench, ...]:
    """Return loads about the middle of the top face of a target at rest [N, N m]: themselves without touch."""
    if sensor.touch is None:
        return tuple(loads)
    return tuple(touch_wrench(sensor, load, np.zeros(6)) for load in loads)


def check_places(sensor: Sensor, axes: Mapping[str, Sequence[float]]) -> None:
    """Refuse values of a grid's components by name that a touch cannot have: places without a touch, or beside one."""
    given = [name for name in TOUCH if name in axes]
    if sensor.touch is None:
        if given:
            raise SceneError(f"touch: must be a table of the scene for {', '.join(given)}; it is missing")
        return
    held = {name: axes.get(name, [0.0]) for name in WRENCH}
    shears = any((*held["F_x"], *held["F_y"]))
    if given and (moments := [name for name in ("M", "M_x") if any(held[name])]):
        raise SceneError(f"{', '.join(moments)}: must be left out with a touch's places, which give moments; got some")
    if given and shears and 0.0 in held["F_z"]:
        raise SceneError("F_z: must not be 0 where a touch has several places and shears; got 0 N")
    if sensor.touch.friction == "none" and (shears or any(held["M_z"]) or min(held["F_z"]) < 0.0):
        words = "" if sensor.cover is None else ", which only a pressure is on a cover,"
        raise SceneError(f'touch.friction: must be "sticking"{words} for shear, torsion or a pull (F_z < 0); '
                         'got "none"')
    if any(held["M_z"]) and sensor.cover is not None:
        raise SceneError(f"M_z: must be 0 for a {sensor.touch.words}, which does not turn a cover; got some")
    x, y = (axes.get(name, [own]) for name, own in zip(TOUCH, sensor.touched_point, strict=True))
    for place in itertools.product(x, y):
        check_place(sensor.touch, (_target(sensor), sensor.cover, sensor.elastomer), place)
    _check_radius(sensor, sensor.touch, max(held["F_z"]))


def _check_radius(sensor: Sensor, touch: Touch, force: float) -> None:
    """Refuse a round shape, thinner than the cover, far beyond the force that lets it sink in by its radius.

    On a half space of mu that force is 16/3 mu R^2 of a sphere, pi mu R l of a cylinder (Hertz's areas as wide as they
    are); ten times as much leaves room for the target below, and for what strains add.
    """
    cover, pad, R = sensor.cover, sensor.elastomer, touch.radius
    if cover is None or pad is None or R is None or R >= cover.thickness:
        return
    mu, power = cover.silicone.shear_modulus, 2 if touch.length is None else 1
    least = 16.0 / 3.0 * mu * R**2 if power == 2 else math.pi * mu * R * max(cover.extent(_target(sensor), pad))
    if force > 10.0 * least:
        needed = mm(R * (force / least) ** (1.0 / power), 2)
        raise SceneError(f"touch.radius: must be some {needed} or more under {force:g} N, or what presses sinks into "
                         f"the cover by its radius, as under {least:.2g} N; got {mm(R)}")


def touch_wrench(sensor: Sensor, load: Wrench, pose: Array) -> Wrench:
    """Return the wrench about the middle of the top face that a load is at a pose (6,)."""
    r, R = _arm(sensor, load, pose)
    n, touch = R[:, 2], _touch(sensor)
    F = np.array([load.F_x, load.F_y, -load.F_z]) if touch.friction == "sticking" else -load.F_z / n[2] * n
    M = np.cross(r, F) + 0.0
    return Wrench(F_x=float(F[0]) + 0.0, F_z=load.F_z, M=float(M[1]), F_y=float(F[1]) + 0.0, M_x=float(M[0]),
                  M_z=float(M[2]) + load.M_z)


def contact_point(
    sensor: Sensor, load: Wrench, pose: Pose, sunk: tuple[float, float] | None = None
) -> tuple[Array, Array]:
    """Return where a load touches at a pose, x, y, z in space [m], and the normal of the target's face there.

    On a cover it is the lowest point of what presses, upright, `sunk` as of the equilibrium; a pressure moves with the
    target.
    """
    target = _target(sensor)
    if sensor.cover is None or sensor.elastomer is None:
        r, R = _arm(sensor, load, pose.components)
        return pose.centre + target.thickness * R[:, 2] + r, R[:, 2]
    low = float(pose.d_v) if sunk is None else sensor.elastomer.standoff + sensor.elastomer.thickness - sunk[0]
    return np.array([*_place(sensor, load), low + target.thickness + sensor.cover.thickness]), np.array([0.0, 0.0, 1.0])


def _arm(sensor: Sensor, load: Wrench, pose: Array) -> tuple[Array, Array]:
    """Return where a load touches from the middle of the top face, shape (3,) [m], and the target's rotation."""
    touch, place = _touch(sensor), np.array(_place(sensor, load))
    R = rotation_matrix(pose[_TURN])
    n = R[:, 2]
    rolled = place - (touch.radius or 0.0) * n[:2]
    if touch.friction == "sticking" or touch.shape == "pressure":
        return R @ [*rolled, 0.0], R
    across = rolled - pose[_PLACE] - _target(sensor).thickness * n[:2]
    return np.array([*across, -(n[:2] @ across) / n[2]]), R


def _place(sensor: Sensor, load: Wrench) -> tuple[float, float]:
    """Return where a load about the touched point touches a target at rest [m]."""
    x, y = _touch(sensor).place
    if load.F_z == 0.0:
        return x, y
    across, along = touched_place(load)
    return x + across, y + along


def _touch(sensor: Sensor) -> Touch:
    """Return the touch of a scene that has one."""
    if sensor.touch is None:
        raise SceneError(f"{sensor.name}: touch: must be given; it is missing")
    return sensor.touch


def _target(sensor: Sensor) -> Target:
    """Return the target of a scene that has one."""
    if sensor.target is None:
        raise SceneError(f"{sensor.name}: target: must be given for a touch; it is missing")
    return sensor.target


def _followed(layer: MechanicalModel, sensor: Sensor, load: Wrench, start: Equilibrium | None) -> Equilibrium:
    """Return the equilibrium under the wrench that a touch is at its own pose; raises as `touched`."""
    _check(sensor, load)
    if sensor.cover is not None:
        return _on_cover(layer, sensor, load, start)
    half = 0.5 * max(_target(sensor).extent)
    lever = np.array([1.0, 0.0, half, 1.0, half, half])  # to displacements, without the height
    q, B = np.zeros(6), np.eye(6)
    if start is not None:
        q = start.pose.components * (lever > 0.0)
        start = replace(start, wrench=touch_wrench(sensor, start.wrench, start.pose.components))
    last, seconds, iterations = None, 0.0, 0
    for _ in range(STEPS):
        W = touch_wrench(sensor, load, q)
        found = layer.equilibrium(W, start=start)
        seconds, iterations = seconds + found.report.seconds, iterations + found.report.iterations
        g = found.pose.components * (lever > 0.0) - q
        there = touch_wrench(sensor, load, found.pose.components)
        same = _alike(W, there, half)
        left = min(float(np.abs(g * lever).max()), _moves(sensor, found.pose.components, W, there))
        if float(np.linalg.det(B)) <= 0.0:
            break
        if same or left <= max(LEFT * float(np.abs(found.error.components * lever).max()), _LEAST * half):
            found = replace(found, report=replace(found.report, seconds=seconds, iterations=iterations))
            found = replace(found, acting=W if same else there)
            return _at_rest(sensor, load, found, 0.0 if same else left, np.where(lever > 0.0, lever, 1.0))
        if last is not None:
            dq, df = (q - last[0]) * lever, (g - last[1]) * lever
            B = B - np.outer(dq + B @ df, dq @ B) / (dq @ B @ df)
        last, start = (q, g), found
        q = q + np.divide(B @ (g * lever), lever, out=np.zeros(6), where=lever > 0.0)
    report = replace(found.report, status="touch not held")
    raise SolveFailed("touch: no stable pose was found whose own wrench leads to it", report, found)


def _on_cover(layer: MechanicalModel, sensor: Sensor, load: Wrench, start: Equilibrium | None) -> Equilibrium:
    """Return the equilibrium under a touch on a cover, whose model takes it about the middle, moments for its place."""
    start = None if start is None else replace(start, wrench=touch_wrench(sensor, start.wrench, np.zeros(6)))
    return replace(layer.equilibrium(touch_wrench(sensor, load, np.zeros(6)), start=start), wrench=load)


def _moves(sensor: Sensor, pose: Array, W: Wrench, there: Wrench) -> float:
    """Return about how far a target at a pose (6,) moves from one wrench to another [m], with a margin."""
    own, pad = W.components, sensor.elastomer
    change = there.components - own
    M, dM, tilt = (float(np.linalg.norm(each)) for each in (own[_TURN], change[_TURN], pose[_TURN[:2]]))
    if pad is None or (M == 0.0 and dM > 0.0):
        return math.inf
    shift = float(np.linalg.norm(change[_PLACE])) * pad.thickness / (pad.shear_modulus * math.prod(pad.extent))
    turn = dM / M * tilt * 0.5 * max(_target(sensor).extent) if M else 0.0
    return _MARGIN * (shift + turn)


def _at_rest(sensor: Sensor, load: Wrench, found: Equilibrium, left: float, lever: Array) -> Equilibrium:
    """Return the equilibrium of a load with what is left [m] in its error; refuse one that has slid off the target."""
    r, R = _arm(sensor, load, found.pose.components)
    x, y, _ = (R.T @ r).tolist()
    if not is_on(_touch(sensor), _target(sensor), (x, y)):
        report = replace(found.report, status="touch slid off")
        raise SolveFailed(f"touch: slides off the target, to x = {mm(x, 3)}, y = {mm(y, 3)} on it", report, found)
    own = found.error.components
    return replace(found, wrench=load, error=Pose.of(own + np.where(own > 0.0, left / lever, 0.0)))


def _check(sensor: Sensor, load: Wrench) -> None:
    """Refuse a place beside the target, and forces that the touch does not have."""
    x, y = _place(sensor, load)
    own = {name: [value] for name, value in vars(load).items() if name not in ("M", "M_x")}
    check_places(sensor, own | {"touch_x": [x], "touch_y": [y]} if load.F_z else own)


def _alike(first: Wrench, second: Wrench, half: float) -> bool:
    """Return whether two wrenches are the same but for rounding, moments by those of forces at half a target [m]."""
    own, other = first.components, second.components
    force = float(np.abs(own[_FORCES]).max())
    near = np.abs(own - other) <= SLACK * np.where(_FORCES, force, force * half)
    return bool(np.all(near))
