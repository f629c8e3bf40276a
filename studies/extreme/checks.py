"""What must hold of a layer or pad, whatever is asked of it?

    work = energy      int F dx over the way against the energy stored on the mesh at its end
    moment identity    with the moment that holds a block's tilt by symmetry, the solved tilt vanishes
    path               back at a load, back at its pose
    refinement         a hundredth of the tolerance moves the pose by no more than both stated errors
    half and whole     a load in the plane of symmetry, on half the pad and on all of it: within both stated errors
    a quarter turn     a square pad does not know x from y

A way is driven by one number s: a share of a load, whose pose is found, or a place of the target, whose force is found,

    W = s y(s) - int y ds,  y the place along the load     or     W = int y ds,  y the force along the place,

y a spline through the points of the way. Places are those of the mesh whose energy is taken.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from common.energy import stored
from extreme.rows import DONE, Row
from scipy.interpolate import CubicSpline

from sits_mech.mechanics.block import BlockPad, block_pad, solved_body
from sits_mech.mechanics.element.kernel import element_forces
from sits_mech.mechanics.layer import PlanarLayer, planar_layer
from sits_mech.quantities import Array, Equilibrium, MechanicalModel, SolveReport, Wrench
from sits_mech.report.notes import sentences
from sits_mech.scene.sensor import Elastomer, Sensor

REST = Wrench()


class Way(NamedTuple):
    """Where a layer was led: the direction of its load or place, the points s on it, what was found at each."""

    unit: tuple[float, float, float]
    by_place: bool
    points: list[float]
    path: list[Equilibrium]


def scaled(wrench: Wrench, share: float) -> Wrench:
    """Return a share of a wrench."""
    return Wrench(share * wrench.F_x, share * wrench.F_z, share * wrench.M)


def forces(wrench: Wrench) -> Array:
    """Return F_x, F_z, M."""
    return np.array([wrench.F_x, wrench.F_z, wrench.M])


def elastomer_of(model: PlanarLayer | BlockPad) -> Elastomer:
    """Return the elastomer of a model, which has one."""
    assert model.sensor.elastomer is not None
    return model.sensor.elastomer


def places(model: PlanarLayer | BlockPad, found: Equilibrium) -> Array:
    """Return d_h, sink, alpha of the mesh that answers, in 3D before extrapolation."""
    elastomer = elastomer_of(model)
    if isinstance(model, PlanarLayer):
        pose = found.pose
        return np.array([pose.d_h, elastomer.standoff + elastomer.thickness - pose.d_v, pose.alpha], dtype=float)
    n = solved_body(model, found).mesh.nodes.size
    return found.state[1 + n : 4 + n] * [elastomer.thickness, -elastomer.thickness, 1.0]


def energy_of(model: PlanarLayer | BlockPad, found: Equilibrium) -> float:
    """Return the energy stored on the mesh that answers [J]."""
    if isinstance(model, PlanarLayer):
        return stored(model, found, limit=True)
    elastomer, body = elastomer_of(model), solved_body(model, found)
    u = found.state[1 : 1 + body.mesh.nodes.size]
    energy, share = element_forces(body.mesh, body.laws, u).energy, model.half.scales.share
    return float(elastomer.shear_modulus * elastomer.thickness**3 * energy / share)


def work(way: Way, model: PlanarLayer | BlockPad) -> tuple[float, float]:
    """Return the work over a way, and how far it is from that through every second point."""
    unit, s = np.array(way.unit), np.array(way.points)
    found = [forces(item.wrench) if way.by_place else places(model, item) for item in way.path]
    y = np.array([item @ unit for item in found])
    thin = sorted({*range(0, len(s), 2), len(s) - 1})
    areas = [float(CubicSpline(s[i], y[i]).integrate(0.0, s[-1])) for i in (list(range(len(s))), thin)]
    whole, rough = areas if way.by_place else (s[-1] * y[-1] - area for area in areas)
    return whole, abs(whole - rough)


def energy_row(model: PlanarLayer | BlockPad, way: Way) -> Row:
    """Return work against energy at the end of a way; allowed: what the spline of the way is good for."""
    last = way.path[-1]
    energy, (done, rough) = energy_of(model, last), work(way, model)
    changed = len({item.state[0] for item in way.path[1:]}) > 1  # of mesh, on the way
    uncertainty = 2.0 * max(item.report.estimated_error for item in way.path) if changed or touching(model) else 0.0
    report, violation = last.report, abs(done / energy - 1.0)
    allowed = 1e-4 + rough / energy + uncertainty
    return Row("", "", DONE, _least(report), violation, allowed, report.estimated_error, remark=_remark(report))


def touching(model: PlanarLayer | BlockPad) -> bool:
    """Say whether a model may answer with contact or without."""
    return isinstance(model, PlanarLayer) and model.line.auto


def _remark(report: SolveReport) -> str:
    """Notes in one line."""
    return "; ".join(sentences(report.notes))


def _least(report: SolveReport) -> float:
    """Smallest volume ratio; nan where there is none."""
    return np.nan if report.min_J is None else report.min_J


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
    return Row("", "", DONE, _least(report), away, allowed, report.estimated_error, remark=_remark(report))


def half_and_whole(sensor: Sensor, wrench: Wrench) -> Row:
    """Return how far the pose of the whole pad is from that of half of it, in sums of both stated errors."""
    half = block_pad(sensor, 1e-2).equilibrium(wrench)
    whole = block_pad(sensor, 1e-2).equilibrium(replace(wrench, F_y=1e-12))
    one, error = (np.array([part.d_h, part.d_v, part.alpha], dtype=float) for part in (half.pose, half.error))
    other = whole.pose.components[:3]
    uncertainty = error + whole.error.components[:3]
    report = whole.report
    violation = float(np.max(np.abs(one - other) / np.maximum(uncertainty, 1e-15)))
    return Row("", "", DONE, _least(report), violation, 1.0, report.estimated_error, remark=_remark(report))


def quarter_turned(sensor: Sensor, load: Wrench) -> Row:
    """Return how far a load turned by a quarter about z is from the turned pose, of the displacement."""
    turned = Wrench(-load.F_y, load.F_z, load.M_x, load.F_x, -load.M, load.M_z)
    first, second = block_pad(sensor, 1e-2).equilibrium(load), block_pad(sensor, 1e-2).equilibrium(turned)
    rest = np.array([0.0, 0.0, block_pad(sensor, 1e-2).equilibrium(Wrench()).pose.d_v])
    moved = [np.concatenate([found.pose.centre - rest, found.pose.rotation * 1e-3]) for found in (first, second)]
    back = moved[1][[1, 0, 2, 4, 3, 5]] * [1.0, -1.0, 1.0, 1.0, -1.0, 1.0]
    report = second.report
    away = float(np.abs(back - moved[0]).max() / np.abs(moved[0]).max())
    return Row("", "", DONE, _least(report), away, 1e-6, report.estimated_error, remark=_remark(report))


def refined(sensor: Sensor, wrench: Wrench, finer: float = 1e-4) -> Row:
    """Return how far the pose moves when a hundredth of the tolerance is asked, in sums of both stated errors."""
    coarse, fine = (planar_layer(sensor, tolerance).equilibrium(wrench) for tolerance in (1e-2, finer))
    names = ("d_h", "d_v", "alpha")
    away = np.array([abs(float(getattr(coarse.pose, name)) - float(getattr(fine.pose, name))) for name in names])
    uncertainty = np.array([float(getattr(coarse.error, name)) + float(getattr(fine.error, name)) for name in names])
    report = fine.report
    violation = float(np.max(away / np.maximum(uncertainty, 1e-15)))
    remark = f"{coarse.report.estimated_error:.1e} asked for 1e-2, {report.estimated_error:.1e} for {finer:g}"
    return Row("", "", DONE, _least(report), violation, 1.0, report.estimated_error, remark=remark)


def nothing(layer: MechanicalModel, rest: float) -> Row:
    """Return how far no load moves a layer."""
    found = layer.equilibrium(REST)
    away = max(abs(float(found.pose.d_h)), abs(float(found.pose.d_v) - rest), abs(float(found.pose.alpha)) * rest)
    return Row("", "", DONE, _least(found.report), away / rest, 1e-12, found.report.estimated_error)


def identity(sensor: Sensor, wrench: Wrench) -> Row:
    """Return the tilt, as a share of the motion, under the moment that holds a symmetric block's tilt at zero."""
    layer, found = planar_layer(sensor, 1e-3), None
    assert sensor.target is not None and sensor.elastomer is not None
    d_h, gap = 0.0, sensor.elastomer.thickness
    for _ in range(12):
        M = -0.5 * (wrench.F_x * gap + wrench.F_z * d_h)  # the plates carry equal moments, at any strain
        found = layer.equilibrium(replace(wrench, M=M), start=found)
        moved, (d_h, gap) = abs(float(found.pose.d_h) - d_h), (float(found.pose.d_h), float(found.pose.d_v))
        if moved < 1e-9 * gap:
            break
    tilt = abs(float(found.pose.alpha)) * 0.5 * sensor.target.extent[0]
    size = max(abs(d_h), abs(sensor.elastomer.thickness - gap))
    report = found.report
    return Row("", "", DONE, _least(report), tilt / size, 1e-6, report.estimated_error)
