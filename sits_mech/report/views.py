"""What does the loaded sensor look like? Deformed layer, target and coils in the section y = 0."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sits_mech.geometry.windings import coil_bars
from sits_mech.quantities import Array, Equilibrium, Pose
from sits_mech.report.curves import add_polygons, new_figure
from sits_mech.sensor import Sensor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Mesh = tuple[Array, NDArray[np.int64], Array]
_MM = 1e3


def layer_view(sensor: Sensor, equilibrium: Equilibrium, mesh: Mesh | None = None) -> Figure:
    """Return a picture of the section y = 0 under a load.

    Parameters
    ----------
    sensor : Sensor
        With a target.
    equilibrium : Equilibrium
        The load and where the target rests.
    mesh : tuple of ndarray, optional
        The deformed layer: points (n, 2) [m], quadrilaterals (m, 4), volume ratio of each (m,).
    """
    (left, right), (bottom, top) = _frame(sensor, equilibrium)
    height = 0.85 * (top - bottom) / (right - left) + (0.2 if mesh is None else 0.33)  # of the axes and what is around
    with new_figure(height) as (figure, (axes,)):
        if mesh is not None:
            points, quads, J = mesh
            corners = _MM * points[quads]
            layer = add_polygons(axes, corners, cmap="cividis", edgecolor="0.25", linewidth=0.15, array=J)
            bar = figure.colorbar(layer, ax=axes, location="bottom", shrink=0.7, aspect=35)
            bar.set_label("volume ratio $J$ [-]", fontsize=7)
            bar.ax.tick_params(labelsize=6)
        for coil in sensor.coils:
            bars = coil_bars(coil)
            corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (bars.width / 2, bars.thickness / 2)
            boxes = np.stack([bars.x, bars.z], axis=1)[:, None, :] + corners
            shades = np.where(bars.sign > 0, "tab:red", "tab:blue")
            add_polygons(axes, _MM * boxes, facecolors=list(shades), linewidth=0)
        if sensor.target is not None:
            plate = _MM * target_corners(sensor, equilibrium.pose)[None]
            add_polygons(axes, plate, facecolors="#b87333", edgecolors="0.2", linewidth=0.4)
        _dress(axes, sensor, equilibrium)
    return figure


def target_corners(sensor: Sensor, pose: Pose) -> Array:
    """Return the corners of the target's section at one pose [m], shape (4, 2): bottom left, then counter-clockwise."""
    target = sensor.target
    if target is None:
        return np.empty((0, 2))
    half, height = target.extent[0] / 2, target.thickness
    xi, eta = np.array([-half, half, half, -half]), np.array([0.0, 0.0, height, height])
    cos, sin = np.cos(pose.alpha), np.sin(pose.alpha)
    return np.stack([pose.d_h + xi * cos + eta * sin, pose.d_v - xi * sin + eta * cos], axis=1)


def _frame(sensor: Sensor, equilibrium: Equilibrium) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return what the picture shows, along x and z [m]."""
    reach = max(abs(coil.centre[0]) + coil.outer_diameter / 2 for coil in sensor.coils)
    if sensor.elastomer is not None:
        reach = max(reach, sensor.elastomer.extent[0] / 2)
    depth = max(coil.height for coil in sensor.coils)
    top = float(np.max(target_corners(sensor, equilibrium.pose)[:, 1], initial=float(equilibrium.pose.d_v)))
    return (-1.12 * reach, 1.12 * reach), (-depth - 0.3e-3, top + 0.4e-3)


def _dress(axes: Axes, sensor: Sensor, equilibrium: Equilibrium) -> None:
    """Give axes, title and the substrate's surface."""
    across, up = _frame(sensor, equilibrium)
    axes.axhline(0.0, color="0.4", linewidth=0.4)
    axes.set_xlim(*(_MM * x for x in across))
    axes.set_ylim(*(_MM * z for z in up))
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlabel("$x$ [mm]")
    axes.set_ylabel("$z$ [mm]")
    load = equilibrium.wrench
    axes.set_title(f"$F_x$ = {load.F_x:.3g} N, $F_z$ = {load.F_z:.3g} N", fontsize=8)
