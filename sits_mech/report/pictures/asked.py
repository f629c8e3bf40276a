"""Choose and check the kind of picture before what solves and draws is imported."""

from __future__ import annotations

from typing import Literal

from sits_mech.quantities import Pose, Wrench
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
