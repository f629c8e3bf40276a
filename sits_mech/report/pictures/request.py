"""Check and draw the picture of a request: the layer for a load, the field for a pose, else the scene or space."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from sits_mech.quantities import Pose, Wrench, refuse_out_of_plane
from sits_mech.scene.sensor import SceneError, Sensor

Kind = Literal["scene", "layer", "field", "spatial"]


def kind_of_picture(asked: Kind | None, wrench: Wrench, pose: Pose | None) -> Kind:
    """Return the kind asked for, else "field" for a pose and "layer" for a load.

    Raise SceneError for a pose and a load together, a layer at a pose, or the scene at either.
    """
    if asked == "scene" and (pose is not None or wrench.components.any()):
        raise SceneError("--kind scene: must have neither a load nor a pose: it shows the target at rest, unsolved")
    if pose is not None and wrench.components.any():
        raise SceneError("--dv: must not be given together with a load, which leads to a pose of its own")
    if pose is not None and asked == "layer":
        raise SceneError("--kind layer: must have a load (--fx, --fz), which the layer answers; got a pose (--dv)")
    return asked or ("layer" if pose is None else "field")


def check_options(kind: Kind, **given: str | None) -> None:
    """Refuse options of another kind of picture."""
    taken = {"scene": "", "layer": "show"}.get(kind, "frequency driven")
    for name, value in given.items():
        if value is not None and name not in taken:
            raise SceneError(f"--{name}: must be left out with --kind {kind}; got {value}")


def driven_coil(sensor: Sensor, driven: str | None) -> str:
    """Return the name of the coil that is driven, the last one by default; raise SceneError when there is no such."""
    names = sensor.coil_names
    if driven is not None and driven not in names:
        raise SceneError(f"--driven: must be one of {', '.join(names)}; got {driven!r}")
    return names[-1] if driven is None else driven


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
    from sits_mech.geometry.tracks import section_refusal
    from sits_mech.report.pictures.drawing import scene_drawing
    from sits_mech.report.pictures.section import field_view, load_view
    from sits_mech.report.pictures.spatial import renders, spatial_view
    from sits_mech.report.pictures.style import save_figure

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
    from sits_mech.chain.models import mechanical_model

    if request.pose is not None or sensor.target is None:
        return request.pose or Pose(0.0, 0.0)
    loads = [request.wrench] if request.wrench.out_of_plane else ()
    return mechanical_model(sensor, loads=loads)[0].equilibrium(request.wrench).pose
