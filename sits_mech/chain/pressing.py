"""Find the force by which a touch presses as deep as its scene says, and what it is off by.

    d(F) = D,    d the depth at rest under F (mechanics/depth.py).

d grows with F as a power 1/p: p is 1 on a bonded layer, 3/2 of a sphere on a thick cover (Hertz). Secants of log F over
log d find F, on the first two meshes of a model, then on those that its tolerance takes, where two forces or so are
left; on finer ones where the errors at that depth, which hold those of contact, are larger than the tolerance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from sits_mech.arguments import checked_arguments
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.omitted.mechanical import mechanical_omissions, within_omissions
from sits_mech.chain.propagation import unloaded_pose
from sits_mech.mechanics.depth import Depth, TouchLoad, at_depth, depth_of
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.touch import LEFT, STEPS
from sits_mech.quantities import Array, Equilibrium, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.scene.parts.touch import Touch
from sits_mech.scene.sensor import SceneError, Sensor, shape_on_cover, stack_of
from sits_mech.scene.thermal import at_temperature
from sits_mech.units import SLACK
from sits_mech.units import millimetres as mm


class _Try(NamedTuple):
    """A rest under a force."""

    force: float
    depth: float
    off: float  # error of the depth
    found: Equilibrium


class _Slopes(NamedTuple):
    """How force and pose go with the depth; before any is known the one alone."""

    power: float = 1.5  # p
    per_depth: Array | None = None  # dq/dd [1, rad/m]

    def force(self, tried: _Try, D: float) -> float:
        """Return the force that leads to a depth, from a rest near it."""
        return tried.force * math.exp(self.power * math.log(D / tried.depth))


@checked_arguments
def touch_load(sensor: Sensor, *, tolerance: float = 1e-2, mechanics: str = "auto", rough: bool = False) -> TouchLoad:
    """Return the load of a scene's touch: its force, or that by which it presses to its depth.

    Parameters
    ----------
    sensor : Sensor
        With a touch that has a force or a depth.
    tolerance : float
        Requested relative error of the pose under the force of the touch.
    mechanics : str
        Name of the model.
    rough : bool
        Whether its first meshes will do, as for a plan.

    Raises
    ------
    SceneError
        Without a force or a depth, for a depth that no force leads to, and when the model cannot hold the scene.

    Examples
    --------
    >>> touch = 'touch={shape="sphere", radius="10 mm", depth="0.1 mm"}'
    >>> result = sm.touch_load(sm.load_sensor("biorob2018-w15", [touch]), mechanics="linear", tolerance=0.1)
    >>> round(result.wrench.F_z, 2), round(result.found.error_F_z, 2)
    (2.02, 0.23)
    """
    touch = sensor.touch
    if touch is None or touch.force is touch.depth is None:
        raise SceneError(f"{sensor.name}: touch: must be given with a force or a depth; got none")
    if touch.depth is None:
        return TouchLoad(Wrench(F_z=touch.force or 0.0))
    swollen = [each.free_stretch for each in stack_of(at_temperature(sensor)) if each.free_stretch != 1.0]
    if swollen:  # its height without load is no number of the scene
        raise SceneError(f"touch.depth: must be a force on silicone that is warm or swollen; got a free stretch of "
                         f"{swollen[0]:.6g}")
    return _sought(sensor, touch, touch.depth, mechanics, tolerance, rough=rough)


def _sought(sensor: Sensor, touch: Touch, D: float, mechanics: str, tolerance: float, *, rough: bool) -> TouchLoad:
    """Return the load of a touch that presses to a depth."""
    force, rest = _first_force(sensor, touch, D), float(unloaded_pose(sensor).d_v)
    (whole, _), tried, slopes = _models(sensor, mechanics, tolerance, force), None, _Slopes()
    if isinstance(whole, RefinedModel):
        tried, slopes = _pressed(whole.rough, sensor, (force, D, rest), slopes, near=tolerance)
        force = slopes.force(tried, D)
    if tried is not None and rough:
        return _ended(sensor, tried, slopes, (D, rest))
    whole, layer = _models(sensor, mechanics, tolerance, force)
    tried, slopes = _pressed(layer, sensor, (force, D, rest), slopes, tried)
    found, before = _ended(sensor, tried, slopes, (D, rest)), 0
    while (missed := _error(found)) > tolerance and isinstance(whole, RefinedModel) and _size(tried) > before:
        before = _size(tried)
        finer = whole.towards(None, tried.found.report.estimated_error * tolerance / missed)
        tried, slopes = _pressed(finer, sensor, (slopes.force(tried, D), D, rest), slopes, tried)
        found = _ended(sensor, tried, slopes, (D, rest))
    return found


def _models(sensor: Sensor, mechanics: str, tolerance: float, force: float) -> tuple[MechanicalModel, MechanicalModel]:
    """Return the mechanical model for a force, and with numerics to what a tolerance leaves beside its omissions."""
    loads = [Wrench(F_z=force)]
    layer, choice = mechanical_model(sensor, mechanics, tolerance, loads)
    left_out = mechanical_omissions(sensor, choice.name, loads, bent=choice.bent)
    return layer, within_omissions(layer, choice, tolerance, left_out)


def _first_force(sensor: Sensor, touch: Touch, D: float) -> float:
    """Return a force [N] of about that size: of a pad that is free to bulge, or of what presses on a half space.

    Of mu and a depth D these are 3 mu A D/t, and 16/3 mu (R D^3)^(1/2), pi mu l D, 8 mu a D of a sphere, a cylinder of
    length l and a punch of half width a.
    """
    target, pad, cover, R = sensor.target, sensor.elastomer, sensor.cover, touch.radius or 0.0
    if target is None or pad is None:
        raise SceneError(f"{sensor.name}: target, elastomer: must be given for a touch to a depth; one is missing")
    of_pad = 3.0 * pad.shear_modulus * min(math.prod(target.extent), math.prod(pad.extent)) * D / pad.thickness
    if cover is None:
        return of_pad
    a = 0.5 * (touch.diameter or min(touch.width or math.inf, touch.length or math.inf))
    each = {"sphere": 16.0 / 3.0 * math.sqrt(R * D), "cylinder": math.pi * max(cover.extent(target, pad))}
    return min(of_pad, cover.silicone.shear_modulus * D * each.get(touch.shape, 8.0 * a))


def _pressed(
    layer: MechanicalModel, sensor: Sensor, aim: tuple[float, float, float], slopes: _Slopes,
    start: _Try | None = None, *, near: float = 0.0,
) -> tuple[_Try, _Slopes]:
    """Return the rest that is as deep as is aimed at, but for a share of its error or `near` of it, and slopes there.

    `aim`: the first force [N], the depth, and the height of the target without load [m]; `start`: a rest by a rougher
    model.
    """
    (force, D, rest), most, own = aim, math.inf, None
    for _ in range(STEPS):
        try:
            found = layer.equilibrium(Wrench(F_z=force), start=None if start is None else start.found)
        except SolveFailed as failure:
            most = min(most, force)
            force = _nearer(sensor, failure, (force, D, rest), start, slopes)
            continue
        d, off, _ = depth_of(sensor, found, rest)
        before, own = own, _Try(force, d, off, found)
        start, slopes = own, slopes if before is None else _slopes(before, own)
        if abs(d - D) <= max(LEFT * off, near * D, SLACK * D):
            return own, slopes
        force = slopes.force(own, D)
        force = force if force < most else math.sqrt(own.force * most)
    raise SceneError(f"touch.depth: must be one that a force leads to; got {mm(D)}: {force:.4g} N after {STEPS} tries")


def _nearer(
    sensor: Sensor, failure: SolveFailed, aim: tuple[float, float, float], start: _Try | None, slopes: _Slopes
) -> float:
    """Return the force to try after one that is not carried; raise SceneError where the way to it was too short."""
    force, D, rest = aim
    last = _last(sensor, failure, rest)
    if last is not None and last.depth >= D:
        return slopes.force(last, D)
    if start is None and last is None:
        return 0.5 * force
    far = "" if start is None else f", {start.force:.4g} N press {mm(start.depth, 4)} deep"
    raise SceneError(f"touch.depth: must be less{far}; got {mm(D)}: {failure}") from failure


def _last(sensor: Sensor, failure: SolveFailed, rest: float) -> _Try | None:
    """Return the last rest on the way to a force that is not carried, if there is one."""
    last = failure.last
    if last is None or last.wrench.F_z <= 0.0 or (shape_on_cover(sensor) is not None and last.sunk is None):
        return None
    d, off, _ = depth_of(sensor, last, rest)
    return _Try(last.wrench.F_z, d, off, last)


def _slopes(first: _Try, second: _Try) -> _Slopes:
    """Return the slopes between two rests."""
    power = math.log(second.force / first.force) / math.log(second.depth / first.depth)
    moved = second.found.pose.components - first.found.pose.components
    return _Slopes(power, moved / (second.depth - first.depth))


def _error(load: TouchLoad) -> float:
    """Return the error of the pose at a depth, over the displacement."""
    return 0.0 if load.found is None else load.found.report.estimated_error


def _size(tried: _Try) -> int:
    """Return the unknowns of a rest."""
    return tried.found.report.unknowns


def _ended(sensor: Sensor, tried: _Try, slopes: _Slopes, aim: tuple[float, float]) -> TouchLoad:
    """Return the load by which a touch presses to a depth; `aim` holds that, and the height without load [m]."""
    (D, rest), d = aim, tried.depth
    moved = (tried.found.pose.components - Pose(0.0, rest).components) / d
    per_depth = moved if slopes.per_depth is None else slopes.per_depth
    depth = Depth(D, rest, per_depth, slopes.power * tried.force / d, tried.off + abs(d - D))
    return TouchLoad(Wrench(F_z=tried.force), depth, at_depth(sensor, tried.found, depth))
