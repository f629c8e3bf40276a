"""What is read and printed of a target that all six components of a load have moved?

Keys beside those of a load in the plane: ``F_y``, ``M_x``, ``M_z`` of the wrench, ``d_y``, ``alpha_x``, ``alpha_z`` of
the pose. (alpha_x, alpha, alpha_z) is the rotation vector: the axis that the target has turned about by the right hand,
as long as the angle [rad]. SI throughout.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from sits_mech.full_chain import FullSimulation
from sits_mech.mechanics.block_full import FullPose, FullWrench
from sits_mech.omissions import Omission
from sits_mech.quantities import Array, Pose
from sits_mech.report.records import Record, impedance_record, report_record, texts_of
from sits_mech.report.tables import key_table, report_lines, volume_lines, with_error

_NAMES = ("d_h", "d_y", "d_v", "alpha_x", "alpha", "alpha_z")


def full_pose_record(found: FullPose, left_out: tuple[str, ...] = ()) -> Record:
    """Return where the target rests: pose, its error, wrench, report."""
    return {
        "pose": _named(np.concatenate([found.centre, found.rotation])),
        "error": _named(found.error),
        "wrench": _wrench(found.wrench),
        "report": report_record(found.report, left_out),
    }


def full_simulation_record(found: FullSimulation, left_out: Sequence[Omission] = ()) -> Record:
    """Return the whole chain at one load; ``report`` has one part for each physics, with what was left out of it."""
    layer = full_pose_record(found.pose, texts_of(left_out, "mechanics"))
    d_h, _, d_v = (float(value) for value in found.pose.centre)
    place = Pose(d_h, d_v, float(found.pose.rotation[1]))
    coils = impedance_record(place, found.impedance, texts_of(left_out, "magnetics"))
    reports = {"mechanics": layer["report"], "magnetics": coils["report"]}
    return coils | layer | {"signals": vars(found.signals), "report": reports}


def full_pose_table(found: FullPose) -> Table:
    """Return pose with errors, and how it came about."""
    lines = []
    values = np.concatenate([found.centre, found.rotation])
    for name, value, error in zip(_NAMES, values, found.error, strict=True):
        scale, unit = (1e6, "um") if name.startswith("d") else (1e3, "mrad")
        lines.append((name, f"{with_error(scale * float(value), scale * float(error))} {unit}"))
    units = {name: "N m" if name.startswith("M") else "N" for name in _wrench(found.wrench)}
    load = [f"{name} = {value:.4g} {units[name]}" for name, value in _wrench(found.wrench).items()]
    lines.append(("under", ", ".join(load)))
    return key_table("pose", lines + volume_lines(found.report) + report_lines(found.report))


def _named(six: Array) -> Record:
    """Six components by name; those of a pose in the plane first."""
    found = dict(zip(_NAMES, (float(value) for value in six), strict=True))
    return {name: found[name] for name in ("d_h", "d_v", "alpha", "d_y", "alpha_x", "alpha_z")}


def _wrench(load: FullWrench) -> dict[str, float]:
    """A load by name; what is in the plane first, ``M`` as there."""
    return {"F_x": load.F_x, "F_z": load.F_z, "M": load.M_y, "F_y": load.F_y, "M_x": load.M_x, "M_z": load.M_z}
