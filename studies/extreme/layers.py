"""How far can a layer be pressed, pulled, sheared and tilted, and is what it answers consistent?

Layers in plane strain (a metre long, force at the bonded face) and 3D pads, neo-Hookean but for one of Gent's law. Held
against

    work = energy      int s dx over the load path against the energy stored on the mesh at its end
    moment identity    with the moment that holds a block's tilt by symmetry, the solved tilt vanishes
    path               back at a load, back at its pose
    refinement         a tenth of the tolerance moves the pose by no more than both stated errors
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from extreme.rows import DONE, Row, measured
from scipy.interpolate import CubicSpline

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.closed_form import compression_modulus, holding_moment, shear_stiffness
from sits_mech.mechanics.layer import PlanarLayer, planar_layer, stored
from sits_mech.quantities import Equilibrium, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.sensor import Sensor, load_sensor

MM, MU = 1e-3, 3e4
REST = Wrench()
LOADS = ((100.0, 1000.0), (267.0, 4050.0), (600.0, 0.0), (0.0, 6000.0))  # F_x, F_z [N/m]


def pad(W: float, w: float, t: float, *, mu: float = MU, ratio: float = 1e3, j_m: float | None = None) -> Sensor:
    """Return a pad a metre long [mm, Pa]: newtons are newtons per metre."""
    law = 'law="neo-hookean"' if j_m is None else f'law="gent", j_m={j_m}'
    material = f"elastomer.material={{{law}, shear_modulus={mu}, bulk_modulus={mu * ratio}}}"
    sizes = [f'elastomer.width="{W} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{w} mm"']
    return load_sensor("biorob2018", ["elastomer.length=1.0", "target.load_height=0", material, *sizes])


def scaled(wrench: Wrench, share: float) -> Wrench:
    """Return a share of a wrench."""
    return Wrench(share * wrench.F_x, share * wrench.F_z, share * wrench.M)


def way(peak: Wrench, pose: Pose, thickness: float) -> float:
    """Return the work of a whole wrench, acting at the bonded face, from rest to a pose."""
    return float(peak.F_x * pose.d_h + peak.F_z * (thickness - pose.d_v) + peak.M * pose.alpha)


def energy_row(layer: PlanarLayer, peak: Wrench, shares: Sequence[float], path: Sequence[Equilibrium]) -> Row:
    """Return work against energy at the end of a proportional path; allowed: what the spline of the way is good for."""
    elastomer, last = layer.sensor.elastomer, path[-1]
    assert elastomer is not None
    ways = np.array([way(peak, found.pose, elastomer.thickness) for found in path])
    s = np.asarray(shares, dtype=float)
    thin = sorted({*range(0, len(s), 2), len(s) - 1})
    parts = (list(range(len(s))), thin)
    work, rough = (s[-1] * ways[-1] - float(CubicSpline(s[i], ways[i]).integrate(0.0, s[-1])) for i in parts)
    energy = stored(layer, last)
    allowed = 1e-4 + abs(work - rough) / energy + 2.0 * max(found.report.estimated_error for found in path)
    report = last.report
    min_J = np.nan if report.min_J is None else report.min_J
    remark = "; ".join(report.notes)
    return Row("", "", DONE, min_J, abs(work / energy - 1.0), allowed, report.estimated_error, remark=remark)


def combined(sensor: Sensor, *, press: float = 0.05, shear: float = 0.1, points: int = 9) -> Row:
    """Return the row of a layer under shear and compression, by its closed forms; work against energy."""
    layer, elastomer, target = planar_layer(sensor, 1e-2), sensor.elastomer, sensor.target
    assert elastomer is not None and target is not None
    t, w, silicone = elastomer.thickness, target.extent[0], elastomer.silicone
    mu, K = silicone.shear_modulus, silicone.bulk_modulus
    F_x = shear * t * shear_stiffness(mu, max(w, 0.5 * t), t)
    peak = Wrench(F_x, press * w * (compression_modulus(mu, K, 0.5 * w / t) + 4.0 * mu))
    shares, path = np.linspace(0.0, 1.0, points), [layer.equilibrium(REST)]
    for share in shares[1:]:
        path.append(layer.equilibrium(scaled(peak, share), start=path[-1]))
    return energy_row(layer, peak, shares.tolist(), path)


def drive(
    sensor: Sensor, unit: Wrench, measure: Callable[[Pose], float], goals: Sequence[float], step: float
) -> Iterator[tuple[float, Callable[[], Row]]]:
    """Yield goals of a measure with what to ask for each, the load growing along one direction from goal to goal."""
    layer = planar_layer(sensor, 1e-2)
    shares, path = [0.0], [layer.equilibrium(REST)]
    state = {"ended": None}

    def reach(goal: float) -> Row:
        if state["ended"] is not None:
            raise state["ended"]
        try:
            climb(goal)
        except SolveFailed as failed:
            reached = measure(path[-1].pose if failed.last is None else failed.last.pose)
            notes = (f"stopped at {reached:.3g}", *failed.report.notes)
            state["ended"] = SolveFailed(str(failed), replace(failed.report, notes=notes), failed.last)
            raise state["ended"] from None
        return energy_row(layer, unit, shares, path)

    def climb(goal: float) -> None:
        while measure(path[-1].pose) < 0.999 * goal:
            here = measure(path[-1].pose)
            following = min(here + step, goal)
            if len(path) == 1:
                share = first_load(layer, unit, measure, step)
            else:
                slope = (shares[-1] - shares[-2]) / max(here - measure(path[-2].pose), 1e-9)
                share = shares[-1] + slope * max(following - here, 0.02 * step)
            path.append(layer.equilibrium(scaled(unit, share), start=path[-1]))
            shares.append(share)

    for goal in goals:
        yield goal, lambda goal=goal: reach(goal)


def first_load(layer: PlanarLayer, unit: Wrench, measure: Callable[[Pose], float], step: float) -> float:
    """Return how much of a unit load makes a step, from the layer's answer to a small one."""
    share = 1e-3 * MU * MM * (MM if unit.M else 1.0)
    return share * step / measure(layer.equilibrium(scaled(unit, share)).pose)


def to_and_fro(layer: MechanicalModel, wrench: Wrench, reach: float) -> Row:
    """Return how far a load, its opposite and the load again end from where the load ended first."""
    first = layer.equilibrium(wrench)
    other = layer.equilibrium(Wrench(-wrench.F_x, 0.2 * wrench.F_z, -wrench.M), start=first)
    again = layer.equilibrium(wrench, start=other)
    size = np.array([1.0, 1.0, reach])
    poses = (np.array([item.pose.d_h, item.pose.d_v, item.pose.alpha], dtype=float) * size for item in (first, again))
    there, back = poses
    rest = np.array([0.0, layer.equilibrium(REST).pose.d_v, 0.0])
    report = again.report
    away = float(np.abs(back - there).max() / np.abs(there - rest).max())
    same = first.state[0] == again.state[0]  # on the same mesh
    allowed = 1e-6 if same else 2.0 * (first.report.estimated_error + report.estimated_error)
    return Row("", "", DONE, report.min_J or np.nan, away, allowed, report.estimated_error)


def refined(sensor: Sensor, wrench: Wrench) -> Row:
    """Return how far the pose moves when a tenth of the tolerance is asked, in sums of both stated errors."""
    coarse, fine = (planar_layer(sensor, tolerance).equilibrium(wrench) for tolerance in (1e-2, 1e-3))
    names = ("d_h", "d_v", "alpha")
    away = np.array([abs(float(getattr(coarse.pose, name)) - float(getattr(fine.pose, name))) for name in names])
    doubt = np.array([float(getattr(coarse.error, name)) + float(getattr(fine.error, name)) for name in names])
    report = fine.report
    violation = float(np.max(away / np.maximum(doubt, 1e-15)))
    remark = f"{coarse.report.estimated_error:.1e} asked for 1e-2, {report.estimated_error:.1e} for 1e-3"
    return Row("", "", DONE, report.min_J or np.nan, violation, 1.0, report.estimated_error, remark=remark)


def nothing(layer: MechanicalModel, rest: float) -> Row:
    """Return how far no load moves a layer."""
    found = layer.equilibrium(REST)
    away = max(abs(float(found.pose.d_h)), abs(float(found.pose.d_v) - rest), abs(float(found.pose.alpha)) * rest)
    return Row("", "", DONE, found.report.min_J or np.nan, away / rest, 1e-12, found.report.estimated_error)


def identity(sensor: Sensor, wrench: Wrench) -> Row:
    """Return the tilt, as a share of the motion, under the moment that holds a symmetric block's tilt at zero."""
    layer, found = planar_layer(sensor, 1e-3), None
    assert sensor.target is not None and sensor.elastomer is not None
    d_h, gap = 0.0, sensor.elastomer.thickness
    for _ in range(12):
        M = holding_moment(wrench, d_h, gap)
        found = layer.equilibrium(replace(wrench, M=M), start=found)
        moved, (d_h, gap) = abs(float(found.pose.d_h) - d_h), (float(found.pose.d_h), float(found.pose.d_v))
        if moved < 1e-9 * gap:
            break
    tilt = abs(float(found.pose.alpha)) * 0.5 * sensor.target.extent[0]
    size = max(abs(d_h), abs(sensor.elastomer.thickness - gap))
    report = found.report
    return Row("", "", DONE, report.min_J or np.nan, tilt / size, 1e-6, report.estimated_error)


def layers(coarse: bool) -> Iterator[Row]:
    """Yield the rows of the layers."""

    def ask(case: str, question: Callable[[], Row], must: bool = True) -> Row:
        return measured("mechanics", case, question, must)

    for ratio in (10.0, 1e7) if coarse else (10.0, 1e2, 1e3, 1e5, 1e7):
        yield ask(f"K/mu = {ratio:g}", lambda ratio=ratio: combined(pad(20, 15, 2, ratio=ratio)))
    for S in (0.3,) if coarse else (0.3, 0.5, 1, 3, 8, 25):
        t, ratio = 7.5 / S, 1e5 if S > 8 else 1e3
        yield ask(f"S = {S:g}, flush", lambda t=t, ratio=ratio: combined(pad(15, 15, t, ratio=ratio), press=0.03))
    for mu in (1e3, 1e7):
        yield ask(f"mu = {mu:g} Pa", lambda mu=mu: combined(pad(20, 15, 2, mu=mu)))
    for t in (20.0,) if coarse else (0.1, 20.0):
        yield ask(f"t = {t:g} mm", lambda t=t: combined(pad(20, 15, t, ratio=1e5), press=0.02))
    for name, sizes in (("overhanging 20/15/2", (20, 15, 2)), ("flush 15/15/3", (15, 15, 3))):
        yield from driven(name, pad(*sizes), coarse)
    locking = pad(15, 15, 3, j_m=2.0)
    goals = (0.5,) if coarse else (0.5, 1.0, 1.3)
    for goal, question in drive(locking, Wrench(F_x=1.0), lambda pose: float(pose.d_h) / (3 * MM), goals, 0.1):
        yield ask(f"Gent j_m = 2 (locks at shear 1.41), shear {goal:.0%}", question, goal < 1.0)
    thin, block = planar_layer(pad(20, 15, 2)), pad(15, 15, 3)
    yield ask("no load", lambda: nothing(thin, 2 * MM))
    yield ask("load to and fro", lambda: to_and_fro(thin, Wrench(200.0, 2000.0, 1.0), 7.5 * MM))
    yield ask("moment identity, pressed and sheared", lambda: identity(block, Wrench(100.0, 400.0)))
    yield ask("moment identity, sheared by half", lambda: identity(block, Wrench(F_x=200.0)))
    pads = {"overhanging 20/15/2": thin.sensor, "flush 15/15/3": block}
    for F_x, F_z in LOADS[:1] if coarse else LOADS:
        for name, sensor in pads.items():
            load, case = Wrench(F_x, F_z), f"{name}, refined at {F_x:g} and {F_z:g} N/m"
            yield ask(case, lambda load=load, sensor=sensor: refined(sensor, load), F_z == 1000.0)
    if not coarse:
        yield ask("100 times too much, pressed", lambda: combined(thin.sensor, press=5.0, points=5), False)
        yield ask("100 times too much, sheared", lambda: combined(thin.sensor, press=0.0, shear=10.0, points=5), False)
        solid = block_pad(load_sensor("biorob2018", ["target.load_height=0"]), 2e-2)
        yield ask("3D pad, no load", lambda: nothing(solid, 2 * MM))
        yield ask("3D pad, to and fro", lambda: to_and_fro(solid, Wrench(0.1, 0.3), 4 * MM))
        yield ask("3D pad, 100 times too much", lambda: to_and_fro(solid, Wrench(0.0, 1e3), 4 * MM), False)


def driven(name: str, sensor: Sensor, coarse: bool) -> Iterator[Row]:
    """Yield the rows of a layer that is pressed, pulled, sheared and tilted further and further."""
    assert sensor.elastomer is not None
    t = sensor.elastomer.thickness
    modes: list[tuple[str, Wrench, Callable[[Pose], float], Sequence[float], float]] = [
        ("pressed", Wrench(F_z=1.0), lambda pose: 1.0 - float(pose.d_v) / t, (0.1, 0.2, 0.3, 0.4, 0.6), 0.02),
        ("pulled", Wrench(F_z=-1.0), lambda pose: float(pose.d_v) / t - 1.0, (0.1, 0.3, 0.5), 0.02),
        ("sheared", Wrench(F_x=1.0), lambda pose: float(pose.d_h) / t, (0.5, 1.0, 1.5, 3.0), 0.1),
        ("tilted", Wrench(M=1.0), lambda pose: float(np.degrees(pose.alpha)), (2.0, 5.0, 10.0, 20.0), 0.5),
    ]
    for mode, unit, measure, goals, step in modes[2:3] if coarse else modes:
        for goal, question in drive(sensor, unit, measure, goals[:1] if coarse else goals, step):
            amount = f"{goal:g} degrees" if unit.M else f"{goal:.0%}"
            yield measured("mechanics", f"{name}, {mode} {amount}", question, goal == goals[0])
