"""Plates of any outline: their division, mesh files, and the model against rectangles and closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.constants import mu_0
from scipy.sparse import vstack
from scipy.sparse.linalg import spsolve

from sits_mech.geometry.outline import Outline, outline_plan, widest_angles
from sits_mech.geometry.sheet_plan import Grading, plan_seams
from sits_mech.geometry.tracks import TrackBars
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.coils.ring_field import coil_potential, filament_counts
from sits_mech.magnetics.coils.straight import track_potential
from sits_mech.magnetics.section.kernels import gauss_rule
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.boxes import box_means
from sits_mech.magnetics.space.classes import problems, stacked
from sits_mech.magnetics.space.fields import Prisms, gauss_points
from sits_mech.magnetics.space.loops import plan_sums
from sits_mech.magnetics.space.prisms import base_potential, prism_means
from sits_mech.magnetics.space.rungs import ImpedanceLimit, PlateRung
from sits_mech.quantities import Pose
from sits_mech.scene.parts.outlines import read_loops, signed_area
from sits_mech.scene.sensor import Sensor, load_sensor

MESHES = Path(__file__).parents[2] / "meshes"
SQUARE = Outline((((-4e-3, -4e-3), (4e-3, -4e-3), (4e-3, 4e-3), (-4e-3, 4e-3)),))


def circle(radius: float, corners: int) -> tuple[tuple[float, float], ...]:
    """A regular polygon with the circle's area."""
    angle = 2 * np.pi * np.arange(corners) / corners
    r = radius * np.sqrt(2 * np.pi / corners / np.sin(2 * np.pi / corners))
    return tuple((float(r * np.cos(a)), float(r * np.sin(a))) for a in angle)


def drawn(outline: Outline) -> str:
    """Keys of a target of an outline."""
    points, *holes = ([list(point) for point in loop] for loop in outline.loops)
    return f'shape="outline", points={points}, holes={holes}'


def one_loop(thickness: float, sigma: float, outline: Outline) -> Sensor:
    """One turn of 20 mm radius over a plate."""
    coil = (
        'coils=[{name="C1", centre=["0 mm","0 mm"], layers=1, turns=1, inner_diameter="39.9 mm", '
        'track_width="0.1 mm", track_thickness="35 um"}]'
    )
    plate = f'conductivity={sigma}, relative_permeability=1, thickness={thickness}, {drawn(outline)}'
    return load_sensor("biorob2018", [coil, f"target={{{plate}}}"])


def of_outline(outline: Outline) -> Sensor:
    """The catalogue's sensor with a target of another outline."""
    return load_sensor("biorob2018", [f'target={{material="copper", thickness="0.2 mm", {drawn(outline)}}}'])


def test_potential_and_mean_in_a_cube() -> None:
    """Known integrals over the unit cube: 1/r from its centre, and the mean of 1/r between two of its points.

    The former is by slopes of W, 2 int over the half height of W'' = 2 W'(1/2).
    """
    corners = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    zero, one = np.zeros(1), np.ones(1)
    W = base_potential(np.full((2, 2), 0.5), corners.repeat(2, axis=0), 0.5 + 1e-4 * np.array([1.0, -1.0]))
    assert (W[0] - W[1]) / 1e-4 == pytest.approx(2.380077, rel=1e-6)
    unit = np.array([0.0, 1.0])
    assert box_means(unit, unit, unit)[0, 0, 0, 0, 0] == pytest.approx(1.8823126444, rel=1e-9)
    cube = Prisms(corners, zero, one)
    assert prism_means(cube, cube, points=5)[0, 0] == pytest.approx(1.8823126444, rel=1e-5)


def test_prisms_as_boxes() -> None:
    x, z = np.array([0.0, 0.5, 1.0, 1.3, 1.4]), np.array([0.0, 0.07, 0.1])
    i, j, k = (n.ravel() for n in np.meshgrid(range(4), range(4), range(2), indexing="ij"))
    corners = np.stack([np.stack([x[i + p], x[j + q]], -1) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)
    prisms = Prisms(corners, z[k], z[k + 1])
    error = prism_means(prisms, prisms, symmetric=True) / box_means(x, x, z)[0, 0, 0] - 1.0
    assert np.sqrt((error**2).mean()) < 2e-3
    assert np.abs(error).max() < 2e-2


@pytest.mark.parametrize("outline", [SQUARE, Outline((circle(4e-3, 40), circle(1.5e-3, 24)))])
def test_division_fills_the_outline(outline: Outline) -> None:
    plan = outline_plan(outline, Grading(0.1e-3, 2.0, 1e-3))
    area = signed_area(plan.nodes[plan.cells])
    loops = [signed_area(np.array(loop)) for loop in outline.loops]
    assert area.min() > 0.0
    assert area.sum() == pytest.approx(loops[0] - sum(loops[1:]), rel=1e-9)
    edges = plan.nodes.shape[0] + plan.cells.shape[0] + len(loops) - 2  # Euler: V - E + F = 2 - loops
    assert len(plan_seams(plan).edges) == edges - int((plan.loop >= 0).sum())


def test_resistance_around_a_hole_converges() -> None:
    """Between rims closer than cells may be wide: R = 2 pi / (sigma t ln(b/a)), of second order in the cells' size."""
    rims, found = Outline((circle(8.0, 24), circle(3.9, 20))), []
    for parts in (2, 4, 6):
        plan = outline_plan(rims, Grading(0.006, 34.0, 3.86, parts, reach=4.4))
        loops = next(problems(plan, np.array([0.0, 1.0]), 0.0))[1].loops
        each = [*(m.real.multiply(1.0 / np.sqrt(loops.volume)[:, None]) for m in loops.moments), loops.uneven.real]
        rows = vstack(each).tocsc()
        hole = int((plan.loop < 0).sum())  # its unknown: after those of the nodes inside
        free = np.arange(rows.shape[1]) != hole
        others = rows[:, np.flatnonzero(free)]
        left = rows @ (np.arange(free.size) == hole)
        left = left - others @ spsolve((others.T @ others).tocsc(), others.T @ left)
        found.append(float(left @ left) * np.log(8.0 / 3.9) / (2 * np.pi) - 1.0)
    coarse, fine = -np.diff(found)
    assert coarse / fine == pytest.approx((1 / 4 - 1 / 16) / (1 / 16 - 1 / 36), rel=0.1)
    assert abs(found[2] - 0.8 * fine) < 1e-3  # polygons for circles: 7e-4, and 8e-5 of twice the corners


def test_levels_of_an_outline_are_parts_of_the_same_cells() -> None:
    """Nodes of a division are nodes of one in twice as many parts; no piece of an L's rim is halved for a lattice."""
    corners = ((-4.0, -4.0), (4.0, -4.0), (4.0, 0.0), (0.0, 0.0), (0.0, 4.0), (-4.0, 4.0))
    coarse, fine = (outline_plan(Outline((corners,)), Grading(0.6, 8.0, 4.95, parts)) for parts in (3, 6))
    assert (len(fine.cells), (fine.loop == 0).sum()) == (4 * len(coarse.cells), 2 * (coarse.loop == 0).sum())
    inside = coarse.cells[coarse.cells[:, 2] == coarse.cells[:, 3]].ravel()
    apart = np.linalg.norm(coarse.nodes[inside, None] - fine.nodes, axis=2)
    assert apart.min(axis=1).max() < 1e-9
    assert (coarse.loop == 0).sum() == 24


def test_corners_own_to_their_order() -> None:
    """Those into the metal where current crowds, and those out of it."""
    corners = Outline((((0.0, 0.0), (2e-3, 0.0), (2e-3, 1e-3), (1e-3, 1e-3), (1e-3, 2e-3), (0.0, 2e-3)),))
    for outline, quarters in ((corners, (3, 3)), (SQUARE, (2, 3)), (Outline((*SQUARE.loops, *corners.loops)), (3, 3))):
        part = of_outline(outline).target
        assert part is not None
        assert widest_angles(part) == pytest.approx(np.array(quarters) * np.pi / 2, rel=1e-9)
    for along, orders in (((3, 4, 6), (4 / 3, 2.0)), ((4, 5, 6), (2.0, 4 / 3))):
        Z = [np.array([[(1.0 + 1.0j) * (1.0 - 0.1 / m ** (4 / 3))]]) for m in (*along[::-1], 4, 4)]
        off, error = (
            abs((forms[0] - 1.0 - 1.0j).item().imag) / limit.errors(forms).item().imag
            for limit in (ImpedanceLimit(PlateRung(along, (3, 4, 5), 7.0), 1e3, 1e3, corners=own)
                          for own in ((2.0, 2.0), orders))
            for forms in (limit.forms(Z),)
        )
        assert error < 1.0 < off


@pytest.mark.parametrize("mirror", [1, -1])
def test_no_loop_links_a_gradient(mirror: int) -> None:
    """A = grad(x), grad(y), grad(xz), grad(yz) drives nothing: these fields are exact with one value a cell."""
    plan = outline_plan(Outline((circle(1.0, 12), circle(0.3, 8))), Grading(0.1, 2.0, 0.4))
    heights = np.array([0.05, 0.03, 0.02])
    loops = plan_sums(plan, 0.2).flows(np.ones(1, complex)).loops(heights, mirror)
    prisms = stacked(plan, np.concatenate([[0.0], np.cumsum(heights)]))
    points, weights = gauss_points(prisms, 3)
    x, y, z = np.einsum("mpd,mp->dm", points, weights)
    zero, one = np.zeros(x.size), np.ones(x.size)
    fields = [(z, zero, x), (zero, z, y)] if mirror < 0 else [(one, zero, zero), (zero, one, zero)]
    for field in fields:
        flux = sum(m.T @ a for m, a in zip(loops.moments, field, strict=True))
        size = sum(abs(m).T @ np.abs(a) for m, a in zip(loops.moments, field, strict=True))
        assert np.abs(flux).max() < 1e-9 * size.max()


@pytest.mark.parametrize("name, corners, area", [("cross", 12, 39e-6), ("slotted_disc", 51, None)])
def test_outline_of_a_mesh_file(name: str, corners: int, area: float | None) -> None:
    outline = Outline(read_loops(MESHES / f"{name}.msh"))
    assert len(outline.loops) == 1
    assert len(outline.rim) == corners
    if area is not None:
        assert abs(signed_area(outline.rim)) == pytest.approx(area, rel=1e-9)


@pytest.mark.slow
def test_square_outline_as_rectangle() -> None:
    """Triangles against the structured division; the resistive regime is the harder for the inductance."""
    sensor = load_sensor("biorob2018")
    free, tensor = (sheets(each, 1e-1).impedance(Pose(0.0, 2e-3), 5e3) for each in (of_outline(SQUARE), sensor))
    change = np.abs(free.L - tensor.L)[0, 0]
    assert change < 8e-2 * abs(tensor.L - tensor.L0)[0, 0]
    assert free.R[0, 0] == pytest.approx(tensor.R[0, 0], rel=4e-2, abs=0.0)


@pytest.mark.slow
def test_resistive_ring_in_axial_field() -> None:
    """A hole carries its own net current: R = pi sigma t omega^2 B^2 (b^4 - a^4) / 8 between radii a and b."""
    a, b, t, sigma, f, d = 0.4e-3, 1e-3, 0.2e-3, 1e6, 1e3, 10e-3
    sensor = one_loop(t, sigma, Outline((circle(b, 16), circle(a, 12))))
    z = sheets(sensor, 1e-1).impedance(Pose(0.0, d), f)
    c, h = 20e-3, d + t / 2 + 17.5e-6
    B = mu_0 * c**2 / 2 / (c**2 + h**2) ** 1.5
    exact = np.pi * sigma * t * (2 * np.pi * f * B) ** 2 * (b**4 - a**4) / 8
    assert z.R[0, 0] == pytest.approx(exact, rel=2e-2, abs=0.0)


@pytest.mark.slow
def test_slot_stops_the_current() -> None:
    slot = ((4e-3, 0.2e-3), (0.0, 0.2e-3), (0.0, -0.2e-3), (4e-3, -0.2e-3))
    slotted = Outline(((*SQUARE.loops[0][:2], *slot[::-1], *SQUARE.loops[0][2:]),))
    cut, whole = (
        sheets(one_loop(0.2e-3, 1e6, o), 1e-1).impedance(Pose(0.0, 10e-3), 1e3).R[0, 0] for o in (slotted, SQUARE)
    )
    assert 0.1 * whole < cut < 0.7 * whole


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slotted_disc", "cross"])
def test_outlines_of_the_example_meshes(name: str) -> None:
    model = sheets(of_outline(Outline(read_loops(MESHES / f"{name}.msh"))), 2e-2)
    z = model.impedance(Pose(0.0, 2e-3), 5e6)
    plate = sheets(load_sensor("biorob2018"), 2e-2).impedance(Pose(0.0, 2e-3), 5e6)
    change, whole = ((v.L - v.L0)[0, 0] for v in (z, plate))
    assert whole < change < 0.0  # less metal screens less
    assert np.linalg.eigvalsh(z.R).min() > 0.0


@pytest.mark.slow
def test_spiral_beside_rings() -> None:
    sensor = load_sensor("biorob2018")
    points = np.array([[-4e-3, 1e-3, 20e-3], [0.0, 5e-3, 15e-3]])
    angle = np.linspace(0.0, 2 * np.pi, 2001)
    coil = sensor.coils[0].model_copy(update={"layers": 1, "turns": 1})
    radius, z = coil.inner_diameter / 2 + coil.track_width / 2, -coil.track_thickness / 2
    loop = np.column_stack([-4e-3 + radius * np.cos(angle), radius * np.sin(angle), np.full(angle.size, z)])
    track = TrackBars(loop[:-1], loop[1:], *np.full((2, 2000), coil.track_width))
    A = track_potential(track, *map(gauss_rule, filament_counts(coil, 15e-3)))(points.T[None])[0].T
    assert A == pytest.approx(coil_potential(coil, points, 15e-3)[:, :2], rel=1e-5, abs=1e-16)
    L = free_inductances(sensor.coils, windings="spiral")
    assert L[0, 0] == pytest.approx(2.5076e-6, rel=1e-2)  # as rings; a spiral of so many turns is close to them
    assert L[0, 1] == pytest.approx(-47.43e-9, rel=3e-2)


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="cross"):
        outline_plan(Outline((((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)),)), Grading(0.01, 2.0, 0.2))
    broken = tmp_path / "broken.msh"
    broken.write_text("no mesh")
    with pytest.raises(ValueError, match="mesh file"):
        Outline(read_loops(broken))
