"""Draw the picture of a request: the layer for a load, the field for a pose, scene or space when asked for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sits_mech.chain.models import mechanical_model
from sits_mech.geometry.tracks import section_refusal
from sits_mech.quantities import Pose, Wrench, refuse_out_of_plane
from sits_mech.report.pictures.asked import Kind
from sits_mech.report.pictures.drawing import scene_drawing
from sits_mech.report.pictures.section import field_view, load_view
from sits_mech.report.pictures.spatial import renders, spatial_view
from sits_mech.report.pictures.style import save_figure
from sits_mech.scene.sensor import SceneError, Sensor


@dataclass(frozen=True)
class PictureSettings:
    """Settings of a picture."""

    wrench: Wrench  # not used where a pose is given
    pose: Pose | None
    frequency: float  # [Hz]
    driven: str = ""  # coil that carries current
    show: str = "displacement"  # or "stretch": what colours a layer


def draw(kind: Kind, sensor: Sensor, request: PictureSettings, path: Path) -> None:
    """Draw a picture and write it; raise ValueError, saying why it cannot be drawn, or SolveFailed."""
    if kind == "field":
        refuse_out_of_plane("planar-fem, and --kind field", request.pose or request.wrench)
        if any(coil.centre[1] != 0.0 and coil.shape != "path" for coil in sensor.coils):
            raise SceneError("--kind field: must have every coil on y = 0; --kind spatial draws them at any place")
        if refusal := section_refusal(sensor.coils):
            raise SceneError(f"--kind field: {refusal}; --kind spatial draws them all")
    if kind == "spatial":
        renders()  # before anything is solved
    if kind == "scene":
        figure = scene_drawing(sensor)
    elif kind == "layer":
        figure = load_view(sensor, request.wrench, show=request.show)
    else:
        seen = field_view if kind == "field" else spatial_view
        figure = seen(sensor, resting_pose(sensor, request), request.frequency, request.driven)
    save_figure(figure, path)


def resting_pose(sensor: Sensor, request: PictureSettings) -> Pose:
    """Return the pose that is asked for, or where the target comes to rest under the load."""
    if request.pose is not None or sensor.target is None:
        return request.pose or Pose(0.0, 0.0)
    loads = [request.wrench] if request.wrench.out_of_plane else ()
    return mechanical_model(sensor, loads=loads)[0].equilibrium(request.wrench).pose
