"""Stream function of a plate's eddy currents at one pose and frequency, to draw lines of current.

The current through the whole thickness t has no divergence in the plate's plane: ``(K_x, K_y) = (d_y, -d_x) psi``, psi
= 0 on the rim and one value on the rim of each hole; between two lines of equal psi runs the same current [A].
Taken as even over the thickness,

    (R + j omega L) psi = -j omega g,    R_ij = (1/sigma t) <K_i, K_j>,    L_ij = mu0/(4 pi t^2) << K_i, K_j / r >>,

on the cells of one sheet (`loops`, `prisms`), with g the coils' flux in each element of psi.

Range: one non-magnetic plate over flat coils. Made for pictures: on the published sensor Delta L is about 1 % low at
5 kHz and 8 % at 5 MHz. Neglected: the skin depth (currents crowd at the faces of a thick plate, and R at 5 MHz is three
times too small), other metal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0

from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.outline import outline_plan, target_outline
from sits_mech.geometry.sheet_plan import CellPlan, Grading
from sits_mech.geometry.tracks import check_frequency
from sits_mech.magnetics.coils.ring_field import coil_potential
from sits_mech.magnetics.space.fields import Prisms
from sits_mech.magnetics.space.loops import plan_sums
from sits_mech.magnetics.space.prisms import prism_means
from sits_mech.quantities import Array, Complex, Integers, Pose
from sits_mech.report.pictures.cuts import target_points
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import Sensor, Target


@dataclass(frozen=True)
class Stream:
    """Stream function of a plate's eddy currents."""

    nodes: Array  # (n, 2) in the target's own axes, from its centre [m]
    cells: Integers  # (m, 4) corners; triangles repeat their last one
    psi: Complex  # (n,) [A]
    change: complex  # what these currents give back to the driven coils: sum of I_c Delta Z_cd I_d [V A]


def plate_stream(sensor: Sensor, pose: Pose, frequency: float, currents: Array, *, cells: int = 32) -> Stream:
    """Return the stream function of a non-magnetic target's eddy currents over flat coils of `currents` [A].

    `cells` are the largest along the narrower side. Collision at the coil plane; ValueError if the frequency [Hz] is
    not positive or beyond the coils', the scene has no target, or its outline cannot be divided.
    """
    target = sensor.target
    if target is None:
        raise ValueError("target: must be given for eddy currents to run in; it is missing")
    check_frequency(sensor.coils, frequency)
    check_clearance(sensor, pose)
    plan = _plan(target, cells)
    loops = plan_sums(plan, 0.0).flows(plan.characters[0]).loops(np.array([target.thickness]), 1)
    low = np.full(plan.cells.shape[0], -target.thickness / 2)
    prisms = Prisms(plan.nodes[plan.cells], low, -low)
    G = prism_means(prisms, prisms, symmetric=True)
    x, y, uneven = (operator.toarray().real for operator in (*loops.moments[:2], loops.uneven))
    sigma = target.metal.conductivity
    L = mu_0 / (4 * np.pi) * (x.T @ G @ x + y.T @ G @ y)
    R = (x.T @ (x / loops.volume[:, None]) + y.T @ (y / loops.volume[:, None]) + uneven.T @ uneven) / sigma
    A = _potential(sensor, pose, plan, currents)
    g = x.T @ A[:, 0] + y.T @ A[:, 1]
    omega = 2.0 * np.pi * frequency
    found = np.asarray(np.linalg.solve(R + 1j * omega * L, -1j * omega * g), dtype=complex)
    return Stream(plan.nodes, plan.cells, _at_nodes(plan, found), complex(1j * omega * g @ found))


def _plan(target: Target, cells: int) -> CellPlan:
    """Return cells of the whole outline, graded to the rim."""
    outline = target_outline(target)
    size = float(np.ptp(outline.rim, axis=0).min())
    return outline_plan(outline, Grading(size / (4 * cells), 2.0, size / cells))


def _potential(sensor: Sensor, pose: Pose, plan: CellPlan, currents: Array) -> Array:
    """Return coils' vector potential at the cells' middles, in the target's own axes, shape (m, 3) [V s/m]."""
    height = 0.0 if sensor.target is None else sensor.target.thickness / 2
    corners = plan.nodes[plan.cells]
    triangle = np.all(corners[:, 2] == corners[:, 3], axis=1)
    middle = np.where(triangle[:, None], corners[:, :3].mean(axis=1), corners.mean(axis=1))
    points = target_points(np.column_stack([middle, np.full(middle.shape[0], height)]), pose)
    A = np.zeros(points.shape)
    for coil, current in zip(sensor.coils, currents, strict=True):
        if current != 0.0:
            A += current * coil_potential(coil, points, float(points[:, 2].min()))
    return A @ rotation_matrix(pose.rotation)


def _at_nodes(plan: CellPlan, found: Complex) -> Complex:
    """Return unknowns at all nodes: zero on the rim, one value on the rim of each hole."""
    psi = np.zeros(plan.nodes.shape[0], dtype=complex)
    inner = plan.loop < 0
    count = int(inner.sum())
    psi[inner] = found[:count]
    hole = plan.loop > 0
    psi[hole] = found[count + plan.loop[hole] - 1]
    return psi
