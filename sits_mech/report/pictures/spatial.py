"""Draw the sensor in space: coils as spirals, the target at its pose, and lines of its eddy current.

Between two neighbouring lines runs the same current through the plate's thickness (stream.py), shown at the
instant when it is largest; colour is its density. pyvista is imported here alone and renders off screen. Where OpenGL
is missing a first render may end the process that tries it: a process of its own tries it before.
"""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sits_mech.geometry.collision import as_plate
from sits_mech.geometry.meshing.unstructured import DEBIAN_PACKAGES
from sits_mech.geometry.outline import target_outline
from sits_mech.geometry.tracks import coil_lines
from sits_mech.quantities import Array, Pose
from sits_mech.report.pictures.cuts import target_points
from sits_mech.report.pictures.fields import CURRENT, driven_currents, written_frequency
from sits_mech.report.pictures.stream import Stream, plate_stream
from sits_mech.report.pictures.style import label_bar, new_figure
from sits_mech.scene.sensor import Coil, Conductor, SceneError, Sensor, Target
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINES = 14  # of current on the target
_FAINT = 0.02  # smallest density of the scale over the largest
_SHOWN = 0.95  # of the lines' length lies within the scale: the density has no limit at an edge
_SIZE = (1800, 1150)  # of the rendered picture [pixels]
_COPPER, _DRIVEN, _IDLE = "#c98a4b", "#d55e00", "#5f7388"
_PROBE = (
    "import pyvista\n"
    "plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))\n"
    "plotter.add_mesh(pyvista.Sphere())\n"
    "plotter.screenshot(None, return_img=True)\n"
)


def spatial_view(sensor: Sensor, pose: Pose, frequency: float, driven: str) -> Figure:
    """Plot coils, target and eddy currents in space; the `driven` coil has 1 mA; frequency [Hz].

    Raise SceneError for coils that are not flat or a missing renderer; Collision of target and coils.
    """
    if sensor.substrate_radius is not None:
        raise SceneError("substrate_radius: the view in space draws flat coils only; ask for --kind field")
    target = sensor.target
    stream = None
    if target is not None and target.metal.relative_permeability == 1.0:
        stream = plate_stream(sensor, pose, frequency, driven_currents(sensor, driven))
    renders()
    picture, density = _rendered(sensor, pose, driven, stream)
    neglected = "\nlines of current without the fixed metal" if sensor.conductors and stream is not None else ""
    driven_by = f"{driven} (orange) carries {1e3 * CURRENT:g} mA, {written_frequency(frequency)}"
    return _framed(picture, density, f"eddy current: {driven_by}; grid 1 mm{neglected}")


@cache
def renders() -> None:
    """Try in a separate process whether pyvista renders off screen; raise SceneError with the packages to install."""
    if find_spec("pyvista") is None:
        raise SceneError("views in space need pyvista: pip install '.[view]' in a clone")
    tried = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, text=True, timeout=120, check=False)
    if tried.returncode != 0:
        lines = tried.stderr.strip().splitlines()
        reason = lines[-1] if lines else f"signal {-tried.returncode}"
        raise SceneError(
            f"views in space need OpenGL (on Debian: apt-get install {DEBIAN_PACKAGES}); a first render ended: {reason}"
        )


def _rendered(sensor: Sensor, pose: Pose, driven: str, stream: Stream | None) -> tuple[NDArray[np.uint8], Array]:
    """Return pixels, and the range of the current density in them [A/m]."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    plotter = pyvista.Plotter(off_screen=True, window_size=list(_SIZE))
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    for coil in sensor.coils:
        plotter.add_mesh(_winding(pyvista, coil), color=_DRIVEN if coil.name == driven else _IDLE, specular=0.3)
    plotter.add_mesh(_ground(pyvista, sensor), style="wireframe", color="#d0d0d0", line_width=1.5, lighting=False)
    density = np.zeros(2)
    if sensor.target is not None:
        plotter.add_mesh(_plate(pyvista, sensor.target, pose), color=_COPPER, opacity=0.55, specular=0.4)
    if sensor.target is not None and stream is not None:
        lines = _lines(pyvista, sensor.target, pose, stream)
        density = float(np.quantile(lines["density"], _SHOWN)) * np.array([_FAINT, 1.0])
        shades = {"scalars": "density", "cmap": "plasma", "clim": list(density), "log_scale": True}
        plotter.add_mesh(lines, **shades, show_scalar_bar=False, lighting=False)
    for part in sensor.conductors:
        plotter.add_mesh(_fixed(pyvista, part), color="#808080", opacity=0.4)
    plotter.camera_position = [(0.55, -1.0, 0.62), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    plotter.reset_camera()
    picture = np.asarray(plotter.screenshot(None, return_img=True))
    plotter.close()
    drawn = np.any(picture < 250, axis=2)  # the white around is cut off
    rows, columns = (np.flatnonzero(drawn.any(axis=axis)) for axis in (1, 0))
    return picture[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], density


def _ground(pyvista: Any, sensor: Sensor) -> Any:
    """Return a grid of 1 mm below the coils [mm]."""
    places = np.array([coil.centre for coil in sensor.coils])
    radius = max(coil.outer_diameter for coil in sensor.coils) / 2
    low, high = np.floor(MM * (places.min(0) - radius)) - 1, np.ceil(MM * (places.max(0) + radius)) + 1
    middle, size = (low + high) / 2, high - low
    depth = -MM * max(coil.height for coil in sensor.coils)
    across, along = size
    centre = (*middle, depth - 0.1)
    return pyvista.Plane(center=centre, i_size=across, j_size=along, i_resolution=int(across), j_resolution=int(along))


def _winding(pyvista: Any, coil: Coil) -> Any:
    """Return a coil's track as a tube [mm]."""
    tubes = pyvista.MultiBlock([
        pyvista.lines_from_points(MM * line).tube(radius=MM * 0.42 * width, n_sides=8)
        for line, width in coil_lines(coil, "spiral")
    ])
    return tubes.combine()


def _fixed(pyvista: Any, part: Conductor) -> Any:
    """Return a fixed plate as a solid [mm]."""
    x, y, z = np.array(part.centre) - part.turn[:, 2] * part.thickness / 2
    turned = {"alpha": part.alpha, "alpha_x": part.alpha_x, "alpha_z": part.alpha_z}
    return _plate(pyvista, as_plate(part), Pose(float(x), float(z), d_y=float(y), **turned))


def _plate(pyvista: Any, target: Target, pose: Pose) -> Any:
    """Return a plate as a solid with its holes, in the place of a target [mm]."""
    loops = target_outline(target).turned
    starts = np.cumsum([0, *map(len, loops)])
    flat = np.vstack(loops)
    corners = MM * target_points(np.column_stack([flat, np.zeros(len(flat))]), pose)
    rims = [np.r_[len(loop) + 1, start + np.arange(len(loop)), start]
            for loop, start in zip(loops, starts[:-1], strict=True)]
    up = target_points(np.array([[0.0, 0.0, target.thickness]]), pose) - target_points(np.zeros((1, 3)), pose)
    face = pyvista.PolyData(corners, lines=np.concatenate(rims)).triangulate_contours()
    return face.extrude(MM * up[0], capping=True)


def _lines(pyvista: Any, target: Target, pose: Pose, stream: Stream) -> Any:
    """Return lines of current on the target's top face [mm], with the current density [A/m]."""
    largest = stream.psi[np.argmax(np.abs(stream.psi))]
    psi = (stream.psi * np.conj(largest) / abs(largest)).real
    a, b, c, d = stream.cells.T
    triangles = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])[c != d]])
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    flat = pyvista.PolyData(np.column_stack([stream.nodes, np.zeros(len(stream.nodes))]), faces=faces)
    flat["psi"] = psi
    slope = flat.compute_derivative(scalars="psi", gradient="slope")
    flat["density"] = np.linalg.norm(slope["slope"], axis=1)
    step = np.ptp(psi) / _LINES
    lines = flat.contour(psi.min() + step * (np.arange(_LINES) + 0.5), scalars="psi")
    height = np.full(lines.n_points, 1.02 * target.thickness + 2e-5)
    lines.points = MM * target_points(np.column_stack([lines.points[:, :2], height]), pose)
    return lines.tube(radius=MM * 4e-5)


def _framed(picture: NDArray[np.uint8], density: Array, title: str) -> Figure:
    """Frame pixels with a title and a scale of the current density, one paper column wide."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    with new_figure(picture.shape[0] / picture.shape[1] + 0.19 + 0.04 * title.count("\n")) as (figure, (axes,)):
        axes.imshow(picture)
        axes.set_axis_off()
        axes.set_title(title)
        if density[1] > 0.0:
            shades = ScalarMappable(norm=LogNorm(*density), cmap="plasma")
            bar = figure.colorbar(shades, ax=axes, location="bottom", shrink=0.6, aspect=30, pad=0.02, extend="both")
            label_bar(bar, "eddy current through the thickness [A/m]")
            bar.ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            bar.ax.xaxis.set_major_formatter(FormatStrFormatter("%g"))
            bar.ax.xaxis.set_minor_formatter(NullFormatter())
    return figure
