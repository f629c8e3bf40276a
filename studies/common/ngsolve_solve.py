"""How is a reference pose found and how sure is it? Meshes and orders of a case, the limit of its poses, its error."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from common.ngsolve_fans import fanned
from common.ngsolve_mesh import family_lines, graded, product_plan, ring_mesh, section_mesh, side, solid_mesh
from common.ngsolve_pad import Law, Pad
from common.ngsolve_wave import wave_stiffness
from common.reference_cases import SECTIONS, Case
from scipy.optimize import brentq

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.quantities import Array


class Ladder(NamedTuple):
    """Order of the elements and of those beside them, first and last number of layers, ratio, layers of the others."""

    order: int
    other: int
    first: int
    last: int
    ratio: float
    others: int


LADDERS = {
    ("plane", False): Ladder(6, 5, 2, 4, 0.4, 4), ("plane", True): Ladder(8, 7, 3, 5, 0.2, 5),
    ("round", False): Ladder(6, 5, 2, 4, 0.4, 4), ("round", True): Ladder(8, 7, 3, 5, 0.2, 5),
    ("box", True): Ladder(3, 4, 1, 3, 0.2, 1),
}
# Parts of the bulk modulus that act at every point [shear moduli]; the one with the smaller error is taken
POINTWISE = {"plane": (0.0, 5.0), "round": (0.0, 5.0), "box": (0.0,)}


class Reference(NamedTuple):
    """A pose (d_h, sink [mm], alpha), its relative error and how it came about."""

    pose: Array
    error: float
    words: str


def reference(case: Case, last: int | None = None) -> Reference:
    """Return the pose of a case, from meshes of up to `last` layers."""
    if case.twist:
        alpha_z = 2.0 * 1e3 * case.twist * case.thickness / (np.pi * case.mu * (0.5 * case.target[0]) ** 4)
        return Reference(np.array([0.0, 0.0, alpha_z]), 0.0, "closed form: Saint-Venant's torsion of a cylinder")
    if case.fanned:
        return fan_reference(case)
    if case.on_family:
        return family_limit(case, *(family_row(case, order, last) for order in case.meshes))
    ladder = LADDERS[case.kind, case.linear]
    found = [one for share in POINTWISE[case.kind] for one in climbed(case, ladder, last or ladder.last, share)]
    if not found:
        return reference(replace(case, milder=True, meshes=SECTIONS), last)
    return min(found, key=lambda one: one.error)


def fan_reference(case: Case) -> Reference:
    """Return the pose of one ring about the corners, as sure as what it adds, or twice as many prisms change."""
    poses = []
    for rings, parts in ((0, 1), (0, 2), (1, 1)):
        q = fanned(case, rings, parts).solve(1e3 * np.array(case.load) / case.mu, 2)
        poses.append(np.array([q[0], -q[1], q[2]]))
    first, more, value = poses
    lever = np.array([1.0, 1.0, 0.5 * case.target[0]])
    ring, prisms = (float(np.max(np.abs(q - first) * lever) / np.max(np.abs(value) * lever)) for q in (value, more))
    words = f"Q4/Q2, prisms in the corners and a ring about them: it adds {ring:.1e}, twice as many prisms {prisms:.1e}"
    return Reference(value, max(ring, prisms), words)


def family_row(case: Case, order: int, last: int | None) -> tuple[list[int], list[Array]]:
    """Return the meshes of a family that carry the load, no finer than `last`, and their poses."""
    sizes, row = case.meshes[order], []
    for size in sizes if last is None else sizes[: last + 1 - sizes[0]]:
        q = displaced(case, order, size, 0.0)
        if q is None:
            break
        row.append(q)
    return list(sizes[: len(row)]), row


def family_limit(case: Case, first: tuple[list[int], list[Array]], others: tuple[list[int], list[Array]]) -> Reference:
    """Return the limit of a family by the order it shows, and how far that of the other elements is from it.

    What an error of order p leaves on the last two of meshes m is ``(q_2 - q_1)/((m_2/m_1)^p - 1)``. The error is also
    what is left by the order that the singular edge should show, 2, in place of the measured one. Of a family that is
    meant to have two meshes 2, or of flush pads 2.38, stands for the measured order, and 2.38, or 2, for the other: of
    flush pads that are sheared 1.5, since how slowly their corners converge is not known from two meshes. One mesh of
    the other elements is taken as it is: what it leaves is in the difference.
    """
    flush = case.pad[0] <= case.bond[0] or case.pad[1] <= case.bond[1]
    lever, found = np.array([1.0, 1.0, 0.5 * case.target[0]]), []
    for (order, meant), (sizes, row) in zip(case.meshes.items(), (first, others), strict=True):
        if len(row) < min(3, len(meant)):
            raise ArithmeticError(f"{case.name}: Q{order} carried the load on {len(row)} meshes of {len(meant)}")
        orders = (2.38, 1.5 if case.load[0] else 2.0) if flush else (2.0, 2.38)
        if len(row) > 2:
            orders = (measured_order(sizes[-3:], [one * lever for one in row[-3:]]), 2.0)
        if len(row) == 1:
            found.append((row * 2, f"Q{order}/P{order - 1}, base cells in {sizes[0]} part"))
            continue
        ends = [row[-1] + (row[-1] - row[-2]) / ((sizes[-1] / sizes[-2]) ** p - 1.0) for p in orders]
        words = f"Q{order}/P{order - 1}, base cells in {sizes[-3:][0]} to {sizes[-1]} parts, order {orders[0]:.2g}"
        found.append((ends, words))
    (value, other), words = found[0]
    size = float(np.max(np.abs(value) * lever))
    away = [float(np.max(np.abs(value - q) * lever)) / size for q in (found[1][0][0], other)]
    words += f"; {found[1][1]}: differs by {away[0]:.1e}, by order {orders[1]:.3g} {away[1]:.1e}"
    return Reference(value, max(away), words)


def measured_order(sizes: Sequence[int], row: Sequence[Array]) -> float:
    """Return the order that three poses show, by the component that moves most; none outside 0.5 to 8."""
    far, near = row[1] - row[0], row[2] - row[1]
    lead = int(np.argmax(np.abs(far)))
    a, b, c = (float(size) for size in sizes)

    def missed(p: float) -> float:
        return float(near[lead] / far[lead] - (b**-p - c**-p) / (a**-p - b**-p))

    if missed(0.5) * missed(8.0) > 0.0:
        raise ArithmeticError(f"differences {far[lead]:.2g} and {near[lead]:.2g} show no order")
    return float(brentq(missed, 0.5, 8.0))


def climbed(case: Case, ladder: Ladder, last: int, pointwise: float) -> Iterator[Reference]:
    """Yield the limit of the meshes that carry the load, if there are two and one of the other order."""
    row: list[Array] = []
    for layers in range(ladder.first, last + 1):
        q = displaced(case, ladder.order, layers, pointwise)
        if q is None:
            break
        row.append(q)
    if len(row) < 2:
        return
    for layers in range(min(ladder.first + len(row) - 1, ladder.others), ladder.first - 1, -1):
        other = displaced(case, ladder.other, layers, pointwise)
        if other is not None:
            further = ladder.first + len(row) - 1 - layers
            yield limit(case, row, np.abs(other - row[layers - ladder.first]), ladder, further)
            return


def displaced(case: Case, order: int, layers: int, pointwise: float) -> Array | None:
    """Return the pose on one mesh, and print it; None where the mesh does not carry the load."""
    began, mesh = time.process_time(), f"{case.name}: Q{order}, {layers} layers, {pointwise:g}"
    try:
        q = pose(case, order, layers, pointwise)
    except (ArithmeticError, np.linalg.LinAlgError) as failure:
        print(f"   {mesh}: {failure}", flush=True)
        return None
    print(f"   {mesh}: {q.tolist()}, {time.process_time() - began:.1f} s", flush=True)
    return q


def limit(case: Case, row: list[Array], others: Array, ladder: Ladder, further: int = 0) -> Reference:
    """Return the limit of poses on refined meshes and its error.

    `others` is what the other order changes, on a mesh that is `further` steps from the finest: it shrinks like the
    differences of the meshes, both stem from the edges.
    """
    lever = np.array([1.0, 1.0, 0.5 * case.target[0]])
    value, last, added = row[-1].copy(), np.abs(row[-1] - row[-2]), np.zeros(3)
    words = f"Q{ladder.order}, {len(row)} meshes of {ladder.first} to {ladder.first + len(row) - 1} layers"
    if len(row) > 2:
        far, near = row[-2] - row[-3], row[-1] - row[-2]
        lead = int(np.argmax(np.abs(far) * lever))
        ratio = float(near[lead] / far[lead]) if far[lead] != 0.0 else 0.0
        words += f", differences shrink by {ratio:.2g}"
        if 0.0 < ratio < 0.75:
            added = near * ratio / (1.0 - ratio)
            last, others = np.abs(added), others * ratio**further
    value = value + added
    size = float(np.max(np.abs(value) * lever))
    words += f", Q{ladder.other} differs by {np.max(others * lever) / size:.1e}"
    return Reference(value, float(np.max(np.maximum(last, others) * lever)) / size, words)


def pose(case: Case, order: int, layers: int, pointwise: float) -> Array:
    """Return d_h, sink [mm] and alpha of a case on one mesh."""
    load = 1e3 * np.array(case.load) / case.mu  # kPa = mN/mm^2
    if case.kind == "plane":
        load *= 1e-3  # N/m = mN/mm
    if case.linear:
        moment = load[2] + case.height * load[0]
        k = stiffness(case, order, layers)
        d_h, alpha = np.linalg.solve(k[np.ix_([0, 2], [0, 2])], [load[0], moment]) if load[0] or moment else (0.0, 0.0)
        return np.array([d_h, load[1] / k[1, 1] if load[1] else 0.0, alpha])
    straight = load[0] == 0.0 and load[2] == 0.0
    pad = discrete(case, order, layers, straight)
    pad = replace(pad, pointwise=pointwise, seconds=600.0 if case.on_family and not case.milder else 60.0)
    q = pad.solve(load, 2)
    return np.array([q[0], -q[1], q[2]])


def discrete(case: Case, order: int, layers: int, straight: bool, odd: bool = False) -> Pad:
    """Return the discrete pad of a case; of a load straight down the part that symmetry leaves."""
    law, t, wide = Law(case.energy, case.K), case.thickness, case.bond[0]
    solid = case.kind in ("box", "mixed")
    ratio = LADDERS["box" if solid else case.kind, solid or case.linear].ratio
    flush = case.pad[0] <= wide * (1.0 + 1e-9)
    z = graded(0.0, t, (layers if flush else 1, layers), t, ratio)
    size = across(case)
    if case.kind == "box" or (case.on_family and not case.milder):
        x = side(wide, case.pad[0], layers, size, ratio, whole=not straight and not odd)
        y = side(case.bond[1], case.pad[1], layers, size, ratio, whole=False)
        if case.on_family:
            x, y, z = family_lines(case.pad, case.bond, t, layers)
            x = x[x > -1e-9] if straight or odd else x
        if case.kind == "box":
            mesh = solid_mesh(product_plan(x, y, (0.5 * wide, 0.5 * case.bond[1])), z)
        else:
            outline = PlateOutline(0.5 * case.pad[0], 0.5 * case.pad[1], case.kind == "round")
            mesh = ring_mesh(wide, outline, t, layers, whole=not straight and not odd)
        share = 0.25 if straight or odd else 0.5
        motion = (0, 2) if odd else (1,) if straight else (0, 1, 2)
        return Pad("solid", mesh, order, law, share, motion, case.height, odd, complete=case.on_family)
    x = side(wide, case.pad[0], layers, size, ratio, whole=case.kind == "plane" and not straight)
    if case.milder:
        x, _, z = family_lines(case.pad, case.bond, t, layers)
        x = x[x > -1e-9] if straight else x
    mesh = section_mesh(x, z, 0.5 * wide)
    if case.kind == "round":
        return Pad("axisymmetric", mesh, order, law, 0.5 / np.pi, (1,), case.height)
    return Pad("plane", mesh, order, law, 0.5 if straight else 1.0, (1,) if straight else (0, 1, 2), case.height)


def across(case: Case) -> float:
    """Length of the cells in the middle: some thicknesses, of a film what the pressure's fall at the edge asks."""
    t, wide = case.thickness, case.bond[0]
    fall = t * np.sqrt(case.K / 12.0)
    return float(max(t, min(1.5 * fall, wide / 12.0)) if wide > 50.0 * t else t)


def stiffness(case: Case, order: int, layers: int) -> Array:
    """Return the stiffness (3, 3) for (d_h, d_z, alpha) about the target's lower face, what the load needs of it."""
    F_x, F_z, M = case.load
    k, alone = np.full((3, 3), np.nan), replace(case, name="", load=(0.0, 0.0, 0.0), turned=False)
    if F_z:
        k[1, 1] = down(alone, order, layers)
    if F_x or M:
        k[np.ix_([0, 2], [0, 2])] = sideways(alone, order, layers)
    return k


@cache
def down(case: Case, order: int, layers: int) -> float:
    """Return the stiffness of a pad at rest along z."""
    return float(discrete(case, order, layers, straight=True).at_rest()[0, 0])


@cache
def sideways(case: Case, order: int, layers: int) -> Array:
    """Return the stiffness (2, 2) of a pad at rest for (d_h, alpha)."""
    if case.kind == "round":
        return wave_stiffness(discrete(case, order, layers, straight=True).mesh, order, case.K)
    found = discrete(case, order, layers, straight=False, odd=True).at_rest()
    return found[np.ix_([0, -1], [0, -1])]  # a layer in plane strain is whole, its motion along z beside them
