"""Draw a section of the sensor: the deformed layer under a load, the field around a pose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.chain.models import mechanical_model
from sits_mech.magnetics.field import planar_fem
from sits_mech.mechanics.block import BlockPad
from sits_mech.mechanics.element.mesh import DeformedSection
from sits_mech.mechanics.layer import PlanarLayer, deformed_mesh
from sits_mech.mechanics.touch import bare, contact_point, on_target
from sits_mech.quantities import WRENCH, Array, Equilibrium, MechanicalModel, Pose, Wrench, shown_unit
from sits_mech.report.pictures.cuts import Plane, coil_cut, conductor_cut, names_cut, target_cut
from sits_mech.report.pictures.fields import (
    COPPER,
    CURRENT,
    CURRENT_HEIGHT,
    METAL,
    draw_current,
    draw_potential,
    driven_currents,
    part_handles,
    potential_height,
    written_frequency,
)
from sits_mech.report.pictures.indenter import draw_from_the_side, height_shown
from sits_mech.report.pictures.pad import deformed_section
from sits_mech.report.pictures.style import TRACKS, add_polygons, label_bar, new_figure
from sits_mech.scene.sensor import SceneError, Sensor, shape_on_cover
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Frame = tuple[tuple[float, float], tuple[float, float]]
_SHRUNK = 0.9  # volume ratio below which it is shown: of a silicone as good as incompressible it is one
_EDGE = 0.1  # thicknesses from a bonded edge, to which strain grows as r**(0.5946 - 1): 2.5 times by then
_INTERFACE, _ON = "#c2185b", 1e-6  # colour; of the height, within which a node is on an interface
_LINE = 0.15  # height of a further line of text [in]
_SHOWN = {"displacement": "displacement [mm]", "stretch": "largest principal stretch, or its reciprocal [-]"}


def layer_view(
    sensor: Sensor, equilibrium: Equilibrium, mesh: DeformedSection | None = None, angle: float = 0.0,
    show: str = "displacement",
) -> Figure:
    """Plot an upright section under a load, `angle` [rad] from x, with the coils that it cuts."""
    plane = Plane(angle)
    tracks = [coil_cut(coil, plane, sensor.substrate_radius) for coil in sensor.coils]
    plates = [] if sensor.target is None else [(target_cut(sensor.target, equilibrium.pose, plane), COPPER)]
    plates += [(conductor_cut(part, plane), METAL) for part in sensor.conductors]
    points = [corners.reshape(-1, 2) for corners, _ in (*tracks, *plates)]
    layer, around = (None, 0.32) if mesh is None else (mesh.points[mesh.quads], 0.44)
    (left, right), (bottom, top) = _frame(sensor, points, layer)
    top += 0.0 if sensor.touch is None else height_shown(sensor.touch) / MM
    frame = (left, right), (bottom, top)
    height = 0.85 * (top - bottom) / (right - left) + around  # of the axes and what is around
    with new_figure(height) as (figure, (axes,)):
        interfaces = list[Any]()
        if mesh is not None:
            _draw_layer(figure, axes, mesh, show, _bonded_edges(sensor, mesh, plane))
            interfaces = _draw_interfaces(axes, sensor, mesh)
        for corners, sign in tracks:
            add_polygons(axes, MM * corners, facecolors=np.where(sign > 0, *TRACKS).tolist(), linewidth=0)
        for corners, shade in plates:
            add_polygons(axes, MM * corners, facecolors=shade, edgecolors="0.2", linewidth=0.4)
        _dress(axes, equilibrium, frame, plane)
        touch = list[Any]()
        if sensor.touch is not None:
            place, normal = contact_point(sensor, equilibrium.wrench, equilibrium.pose, equilibrium.sunk)
            touch = [draw_from_the_side(axes, sensor.touch, place, normal, plane)]
        missed = names_cut(sensor, plane)[1]
        not_cut = f"; not cut: {', '.join(missed)}" if missed else ""
        axes.annotate(
            f"section {plane.words}{not_cut}", (0.0, 1.0), (0, 2), xycoords="axes fraction", textcoords="offset points",
            fontsize=6,
        )
        handles = [*part_handles(sensor.target is not None, bool(sensor.conductors), plane.angle != 0.0), *interfaces,
                   *touch]
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 3), handlelength=1.0)
        lines = (len(handles) - 1) // 3 + figure.axes[-1].get_xlabel().count("\n")
        figure.set_figheight(figure.get_figheight() + _LINE * lines)
    return figure


def _draw_interfaces(axes: Axes, sensor: Sensor, mesh: DeformedSection) -> list[Any]:
    """Draw where layers of a deformed pad, or it and its cover, meet, edges of two cells; return lines for a legend."""
    from matplotlib.collections import LineCollection

    sides, lines = np.stack([mesh.quads, np.roll(mesh.quads, -1, axis=1)], axis=-1).reshape(-1, 2), []
    sides, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    sides, up, pad = sides[count == 2], mesh.rest[:, 1] - mesh.rest[:, 1].min(), sensor.elastomer
    heights = [] if pad is None else [*pad.interfaces, *([pad.thickness] if sensor.cover is not None else [])]
    for height in heights:
        on = np.abs(up - height) < _ON * up.max()
        edges = list(MM * mesh.points[sides[on[sides].all(axis=1)]])
        lines.append(LineCollection(edges, color=_INTERFACE, linewidth=1.2, label="interface of layers"))
        axes.add_collection(lines[-1])
    return lines[:1]


def _draw_layer(figure: Figure, axes: Axes, mesh: DeformedSection, show: str, edges: Array) -> None:
    """Draw the deformed layer with its outline, coloured by what is shown, with the scale; say where it shrinks."""
    from matplotlib.ticker import MaxNLocator

    corners = mesh.points[mesh.quads]
    moved = MM * np.linalg.norm(mesh.points - mesh.rest, axis=1)
    values = mesh.stretch if show == "stretch" else moved[mesh.quads].mean(axis=1)
    add_polygons(axes, MM * corners, facecolors="0.1", edgecolors="0.1", linewidth=1.6)  # what stands out of the fill
    layer = add_polygons(axes, MM * corners, cmap="cividis", edgecolor="0.25", linewidth=0.15, array=values)
    if show != "stretch":
        layer.set_clim(0.0, values.max() or None)
    bar = figure.colorbar(layer, ax=axes, location="bottom", shrink=0.7, aspect=35)
    bar.locator = MaxNLocator(5)
    bar.update_ticks()
    most = values.max() if show == "stretch" else moved[mesh.quads].max()
    away = np.linalg.norm(mesh.rest[mesh.quads][:, :, None] - edges, axis=-1).min(axis=(1, 2))
    near = np.isin(mesh.J, mesh.J[away < _EDGE * np.ptp(mesh.rest[:, 1])])  # the quarters of a cell share its J
    least = mesh.J[~near].min(initial=1.0)
    shrunk = f"\nsmallest volume ratio, away from bonded edges, {least:.3f}" if least < _SHRUNK else ""
    label_bar(bar, f"{_SHOWN[show]}, at most {most:.3g}{shrunk}")


def _bonded_edges(sensor: Sensor, mesh: DeformedSection, plane: Plane) -> Array:
    """Return where the free faces meet ground and target in a section at rest, shape (n, 2) [m]."""
    bottom, top, rims = mesh.rest[:, 1].min(), mesh.rest[:, 1].max(), [0.0]
    if sensor.cover is not None and sensor.target is not None:
        top -= sensor.target.thickness + sensor.cover.thickness
        rims += [sensor.target.thickness]
    ends = [mesh.rest[:, 0].min(), mesh.rest[:, 0].max()]
    plate = np.array([]) if sensor.target is None else target_cut(sensor.target, Pose(0.0, top), plane)[..., 0].ravel()
    return np.array([*((x, z) for x in ends for z in (bottom, top)), *((x, top + z) for x in plate for z in rims)])


def load_view(
    sensor: Sensor, wrench: Wrench, tolerance: float = 1e-2, mechanics: str = "auto", known: Equilibrium | None = None,
    show: str = "displacement",
) -> Figure:
    """Plot the layer under a load, by the known equilibrium, the model, or a solve, coloured as in `layer_view`.

    The section is y = 0; of a load that leaves this plane the one along its shear force, or across its moment. Raise
    SceneError without target or elastomer, or where the model keeps no section of such a load; SolveFailed.
    """
    for part in ("target", "elastomer"):
        if getattr(sensor, part) is None:
            raise SceneError(f"{sensor.name}: {part}: must be given for a picture of the layer; it is missing")
    (acting,) = on_target(sensor, [wrench])
    chosen_by_load = mechanics != "auto" or acting.out_of_plane or shape_on_cover(sensor) is not None
    model, _ = mechanical_model(sensor, mechanics, tolerance, [wrench] if chosen_by_load else ())
    equilibrium = model.equilibrium(wrench) if known is None else known
    if acting.out_of_plane and equilibrium.state.size == 0:
        needed = "needs a load in the plane y = 0 (--fx, --fz, --moment)"
        names = ", ".join(acting.out_of_plane)
        raise SceneError(f"picture of the layer: {needed}; got {names} too: ask for --kind spatial")
    angle = load_angle(acting)
    return layer_view(sensor, equilibrium, _deformed(bare(model), equilibrium, angle), angle, show)


def load_angle(wrench: Wrench) -> float:
    """Return the angle from x of the upright plane that a load acts in, by its shear, else its moment [rad]."""
    sheared = wrench.F_x != 0.0 or wrench.F_y != 0.0
    along, across = (wrench.F_x, wrench.F_y) if sheared else (wrench.M, -wrench.M_x)
    angle = float(np.arctan2(across, along)) % np.pi
    return angle - np.pi if angle > 0.5 * np.pi + 1e-9 else angle


def _deformed(model: MechanicalModel, equilibrium: Equilibrium, angle: float) -> DeformedSection | None:
    """Return the deformed layer in a section, where the model has one."""
    if isinstance(model, BlockPad):
        return deformed_section(model, equilibrium, angle)
    return deformed_mesh(model, equilibrium) if isinstance(model, PlanarLayer) else None


def field_view(sensor: Sensor, pose: Pose, frequency: float, driven: str) -> Figure:
    """Plot flux lines at a pose above the target's current density; the `driven` coil has 1 mA.

    Raise SceneError where nothing but coils conducts, ValueError as `planar_fem`, SolveFailed.
    """
    currents = driven_currents(sensor, driven)
    field = planar_fem(sensor).field(pose, frequency)
    if field is None:
        raise SceneError(f"{sensor.name}: target: must be given for a picture of the field; no metal acts on it")
    heights = (potential_height(field), CURRENT_HEIGHT)
    with new_figure(sum(heights) + 0.06, rows=2, shares=heights) as (figure, (lines, density)):
        draw_potential(lines, field, currents)
        draw_current(density, field, currents)
        lines.set_title(f"flux lines: {driven} carries {1e3 * CURRENT:g} mA, {written_frequency(frequency)}")
        density.set_title(f"current density in {field.plates[0].name}")
        handles = part_handles(True, len(field.plates) > 1)
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), handlelength=1.0)
    return figure


def _frame(sensor: Sensor, parts: list[Array], layer: Array | None) -> Frame:
    """Return what the picture shows, along the section and z [m]."""
    places = np.vstack([*parts, *([] if layer is None else [layer.reshape(-1, 2)]), [[0.0, 0.0]]])
    reach = float(np.abs(places[:, 0]).max())
    depth = max(coil.height for coil in sensor.coils)
    return (-1.12 * reach, 1.12 * reach), (min(-depth, places[:, 1].min()) - 0.3e-3, places[:, 1].max() + 0.4e-3)


def _dress(axes: Axes, equilibrium: Equilibrium, frame: Frame, plane: Plane) -> None:
    """Give axes, title and the substrate's surface."""
    across, up = frame
    axes.axhline(0.0, color="0.4", linewidth=0.4)
    axes.set(xlim=[MM * x for x in across], ylim=[MM * z for z in up], aspect="equal", ylabel="$z$ [mm]")
    axes.set_xlabel("$x$ [mm]" if plane.angle == 0.0 else "along the section [mm]")
    axes.grid(False)
    shown = ("F_x", "F_z", *(name for name in WRENCH[2:] if getattr(equilibrium.wrench, name) != 0.0))
    load = ((name, getattr(equilibrium.wrench, name)) for name in shown)
    words = ", ".join(f"${name}$ = {value:.3g} {shown_unit(name)}" for name, value in load)
    axes.set_title(f"layer by {equilibrium.report.model}, {words}", pad=12)
