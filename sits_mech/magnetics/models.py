"""Describe the magnetic models: what each holds, what it leaves out with sizes, what it costs.

Sections are per metre of depth and leave out the ends along y of coils and plates. Beforehand their size is the first
term of a straight pair of tracks that ends: of length l, a distance d apart,

    M = mu0 l/(2 pi) [ln(2 l/d) - 1 + d/l - ...],

of which the logarithms give the section's answer and d/l is left out: for a coil of width D at the gap g

    size = (D + 2 g)/l,

with l the shortest straight track across the section, or the target where that is shorter; round coils have none, and
no size. Afterwards it is the difference from a coarse answer in space (`omitted/ends.py`). Rings stand for spirals by
the difference of both in space, beforehand by that of their inductances. Idle coils: `coils/idle.py`.

Where a model does not know the metal's field in the tracks, uneven current stays as it is without metal, Z_alone; to
first order in what metal changes of Z (`tracks`), of which it leaves out

    size = 2 |Z_alone| / (omega L0).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from sits_mech.description import Description, Question, Refusal, Rung, function
from sits_mech.geometry.plates import not_cut
from sits_mech.geometry.tracks import crossing
from sits_mech.geometry.windings import unnamed
from sits_mech.magnetics.axis.coaxial import on_axis
from sits_mech.magnetics.coils.idle import coupling, idle_bound, idle_share
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Sensor, metal_parts

_UNMOVED = ("d_v", "alpha_z")  # what may change of a target that stays on a coil's axis
_ROOM = "sits_mech.magnetics."


def _in_section(model: str, refusal: str, sensor: Sensor, question: Question) -> Refusal | None:
    """Return why a model in section does not hold: what leaves the plane, or its own `refusal` of the scene."""
    if nonzero := question.out_of_plane:
        return Refusal(", ".join(nonzero), f"be zero for {model}, which is plane", "other values")
    return _by(refusal, sensor, question)


def _by(refusal: str, sensor: Sensor, question: Question) -> Refusal | None:
    """Return a model's own refusal of a scene."""
    found: Refusal | None = function(_ROOM + refusal)(sensor)
    return found


def _on_axis(model: str, refusal: str, sensor: Sensor, question: Question) -> Refusal | None:
    """Return why a model of one axis does not hold: its refusal of the scene, or what takes the disc off the axis."""
    found, coil, moves = _by(refusal, sensor, question), sensor.coils[0], question.moves
    if found is not None or sensor.target is None:
        return found
    if moves is not None and not set(moves) <= set(_UNMOVED):
        return Refusal("load", f"leave the disc on the coil's axis for {model}", ", ".join(moves))
    if moves is not None and coil.centre != (0.0, 0.0):
        return Refusal(f"coils.{coil.name}.centre", f"be that of the disc for {model}", f"{coil.centre}")
    if question.pose is not None and not on_axis(coil, question.pose):
        return Refusal("pose", f"keep the disc on the coil's axis for {model}", "a shift or a tilt")
    return None


def _of_section(sensor: Sensor, question: Question) -> tuple[Omission, ...]:
    """Return the ends that a section leaves out, and the fixed parts that it does not cut."""
    target, size = sensor.target, math.nan
    numbers = (
        ("disc", target is not None and target.is_round),
        ("round", any(coil.is_round for coil in sensor.coils)),
    )
    if target is None and not sensor.conductors:
        return (Omission(OmissionKind.PLATE_ENDS, size, Relative.FREE, numbers=numbers), *_idle(sensor, question))
    if question.answer is not None:
        from sits_mech.magnetics.omitted.ends import ends_of_plates  # space, for who asks for its size

        ends = ends_of_plates(sensor, *question.answer)
        size = math.nan if ends is None else ends.size
    elif target is not None:
        size = _ends_beforehand(sensor, question.pose)
    missed = [Omission(OmissionKind.NOT_CUT, math.nan, numbers=(("name", name),)) for name in not_cut(sensor)]
    tracks = _tracks(sensor)
    return (Omission(OmissionKind.PLATE_ENDS, size, numbers=numbers), *missed, *tracks, *_idle(sensor, question))


def _ends_beforehand(sensor: Sensor, pose: Pose | None) -> float:
    """Return (D + 2 g)/l of the module docstring; NaN of coils without straight tracks."""
    target, straight = sensor.target, min(map(_straight, sensor.coils))
    if target is None or straight == 0.0:
        return math.nan
    gap = _gap_at_rest(sensor) if pose is None else float(np.max(pose.d_v))
    width = max(coil.extent[0] for coil in sensor.coils)
    return (width + 2.0 * gap) / min(straight, target.extent[1]) if math.isfinite(gap) else math.nan


def _gap_at_rest(sensor: Sensor) -> float:
    """Return the height of the target before any load [m]; infinite without a layer."""
    return math.inf if sensor.elastomer is None else sensor.elastomer.standoff + sensor.elastomer.thickness


def _straight(coil: Coil) -> float:
    """Return the length of the shortest straight track across y = 0 [m]; 0 of a round coil."""
    if coil.is_round:
        return 0.0
    _, cut, step, _ = crossing(coil)
    return float(np.abs(step[:, 1]).min()) if cut.any() else 0.0


def _of_air(sensor: Sensor, question: Question) -> tuple[Omission, ...]:
    """Return what an integral model in space spares; its plates have no net current."""
    found = [Omission(OmissionKind.NO_TARGET)] if sensor.target is None else []
    if sensor.target is not None and sensor.target.net_current == "free":
        found.append(Omission(OmissionKind.RETURN_CURRENT, math.nan))
    return (*found, Omission(OmissionKind.AIR), *_idle(sensor, question))


def _of_sheets(sensor: Sensor, question: Question) -> tuple[Omission, ...]:
    """Return what space leaves out: of permeable parts the field in the tracks, half of a ring's losses."""
    permeable = [(name, part) for name, part in metal_parts(sensor) if part.metal.susceptibility != 0.0]
    found = [*_tracks(sensor)] if permeable else []
    pose = question.pose or Pose(0.0, _gap_at_rest(sensor))
    for name, part in permeable:
        if part.shape == "ring":
            from sits_mech.magnetics.space.plates import around_share  # space, for who asks for its size

            known = part is not sensor.target or math.isfinite(np.max(pose.d_v))
            size = around_share(sensor, part, pose) if known else math.nan
            numbers = (("name", name),)
            found.append(Omission(OmissionKind.AROUND, size, Relative.IMPEDANCE, included=True, numbers=numbers))
    return (*found, *_of_air(sensor, question))


def _tracks(sensor: Sensor) -> tuple[Omission, ...]:
    """Return what the metal's field would change of uneven current in the tracks, by the module docstring."""
    from sits_mech.magnetics.coils.loops import free_inductances
    from sits_mech.magnetics.coils.resistance import rough_alone

    free, f = 2.0 * np.pi * sensor.frequency * np.diag(free_inductances(sensor.coils)), sensor.frequency
    share = [abs(rough_alone(coil, f)) / X for coil, X in zip(unnamed(sensor.coils), free.tolist(), strict=True)]
    return (
        Omission(OmissionKind.TRACKS, 2.0 * max(share), Relative.IMPEDANCE, included=True, numbers=(("frequency", f),)),
    )


def _of_planar(sensor: Sensor, question: Question) -> tuple[Omission, ...]:
    """Return what bars in section leave out."""
    return (Omission(OmissionKind.AIR), *_of_section(sensor, question))


def _of_axisymmetric(sensor: Sensor, question: Question, *, air: bool = False) -> tuple[Omission, ...]:
    """Return what rings leave out of spirals, and unless elements mesh it the air."""
    found = tuple(item for item in _of_air(sensor, question) if not air or item.kind != OmissionKind.AIR)
    spiral = any(coil.is_round and coil.winding == "spiral" for coil in sensor.coils)
    return (Omission(OmissionKind.PITCH, _pitch(sensor, question)), *found) if spiral else found


def _pitch(sensor: Sensor, question: Question) -> float:
    """Return the error of rings for spirals, over the change: of space's coarsest answers, else of L0."""
    if question.answer is not None and sensor.target is not None:
        from sits_mech.magnetics.omitted.ends import pitch_of_spirals

        return pitch_of_spirals(sensor, *question.answer)
    from sits_mech.magnetics.coils.loops import free_inductances

    spirals, rings = (np.diag(free_inductances(sensor.coils, kind)) for kind in ("spiral", "rings"))
    return float(np.abs(spirals / rings - 1.0).max())


def _idle(sensor: Sensor, question: Question) -> tuple[Omission, ...]:
    """Return what idle coils would change of the answer, each coil alone driven: no error of it."""
    if len(sensor.coils) < 2:
        return ()
    idle = sensor.readout.idle_coil
    size = 0.0 if idle == "open" else math.nan
    if idle == "shorted" and question.answer is not None:
        size = (idle_bound if question.pose is None else idle_share)(question.answer[1])
    elif idle == "live" and question.answer is not None:
        size = coupling(question.answer[1])
    bound, numbers = question.pose is None, (("open", idle == "open"),)
    return (Omission(OmissionKind.IDLE, size, Relative.FREE, bound, counts=False, numbers=numbers),)


AXISYMMETRIC = Description(
    "axisymmetric", f"{_ROOM}rings:axisymmetric", partial(_on_axis, "axisymmetric", "rings:not_representable"),
    _of_axisymmetric,
    (Rung(1e-2, 120, 2, 0.03, 2e-6), Rung(1e-3, 500, 4, 1.0, 2e-6), Rung(0.0, 700, 5, 1.5, 2e-6)), 4e-7, fresh=False,
    even=True,
)
PLANAR = Description(
    "planar", f"{_ROOM}bars:planar_bars", partial(_in_section, "planar", "bars:not_representable"), _of_planar,
    (
        Rung(1e-2, 500, 3, 0.04, 1e-5), Rung(1e-3, 700, 3, 0.1, 2e-5), Rung(1e-4, 1500, 3, 0.5, 2e-5),
        Rung(0.0, 3000, 3, 3.2, 6e-5),
    ),
    3e-6, fresh=False, per_metre=True, even=True,
)
SHEETS = Description(
    "sheets", f"{_ROOM}sheets:sheets", partial(_by, "sheets:not_representable"), _of_sheets,
    (
        Rung(1e-1, 600, 5, 0.5, 2e-4), Rung(1e-2, 2200, 5, 2.0, 2e-4), Rung(5e-3, 3400, 5, 3.5, 2e-4),
        Rung(2e-3, 4800, 5, 12.0, 2e-4), Rung(0.0, 6500, 5, 20.0, 2e-4),
    ),
    5e-4, fresh=False, share=1.0, even=True,
)
AXISYMMETRIC_FEM = Description(
    "axisymmetric-fem", f"{_ROOM}axis_fem:axisymmetric_fem",
    partial(_on_axis, "axisymmetric-fem", "axis_fem:not_representable"), partial(_of_axisymmetric, air=True),
    (Rung(1e-2, 15_000, 2, 0.1, 0.4), Rung(1e-3, 20_000, 2, 0.1, 0.6), Rung(0.0, 60_000, 4, 0.1, 3.0)),
    1e-6, power=2.0, even=True,
)
PLANAR_FEM = Description(
    "planar-fem", f"{_ROOM}field:planar_fem", partial(_in_section, "planar-fem", "field:not_representable"),
    _of_section,
    (
        Rung(1e-2, 20_000, 2, 0.1, 0.12), Rung(1e-3, 40_000, 4, 0.2, 0.22), Rung(1e-4, 90_000, 6, 0.1, 0.75),
        Rung(0.0, 250_000, 8, 0.1, 3.2),
    ),
    1e-6, power=2.0, per_metre=True, even=True,
)
MODELS = (AXISYMMETRIC, PLANAR, SHEETS, AXISYMMETRIC_FEM, PLANAR_FEM)
