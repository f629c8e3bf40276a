"""Differentiate inductances by the pose, by differences of answers from one batch.

Central ones of fourth order, or, `quick`, one answer a component: of the plate's coarsest division where it has several
(`sheets`), whose slopes s are made those of the answer by what both find of each coil's own change,

    dL_cd = r_c r_d s_cd,    r_c^2 = Delta L_cc / (Delta L_cc of the coarsest division),

and R likewise: a percent off where the plate is close, for what errors of a pose are worth.

Among fixed plates the gap to these changes with every component, and with it the preparations that share an answer. By
how much two of them differ is within the error of L, but is half of the slope of two coils' sum by d_h, where these
change against each other: all steps of a pose are served by the same ones (`Sheets.prepared_at`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from sits_mech.geometry.collision import room
from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.magnetics.space.lift import Lift
from sits_mech.maps.differences import CENTRAL, FIRST, Stencil
from sits_mech.quantities import POSE, Array, Impedance, MagneticModel, Pose
from sits_mech.scene.sensor import Sensor

STEP = 0.01
"""Of the room around the target; of ln f."""

_ROUGH = 1e-2  # tolerance of what bends
_QUICK = -0.1  # of that, towards the coils, where slopes are steeper


class KnownImpedance(NamedTuple):
    """The impedance at p poses, and its quick slopes by some components, L and R (p, n, n) each."""

    impedance: Impedance
    slopes: dict[str, tuple[Array, Array]]


def pose_slopes(
    sensor: Sensor, model: MagneticModel, pose: Pose, frequency: float, components: Sequence[str], *,
    quick: bool = False, stencil: Stencil = CENTRAL, known: KnownImpedance | None = None,
) -> tuple[Impedance, Array, Array]:
    """Return the impedance at p poses, and derivatives of L and R by components, (p, n, n, k) [per m or rad].

    What is `known` is not solved for.
    """
    if known is not None and known.slopes and components:
        every, new = known.slopes, [name for name in components if name not in known.slopes]
        if new:
            asked = KnownImpedance(known.impedance, {})
            _, *more = pose_slopes(sensor, model, pose, frequency, new, quick=quick, stencil=stencil, known=asked)
            every = every | {name: (more[0][..., k], more[1][..., k]) for k, name in enumerate(new)}
        each = [np.stack([every[name][k] for name in components], axis=-1) for k in (0, 1)]
        return known.impedance, each[0], each[1]
    whole = None if known is None else known.impedance
    stencil, coarse = (FIRST, _coarse(model)) if quick else (stencil, None)
    places, steps = _moved(sensor, pose, components, stencil, _QUICK if quick else 1.0)
    bare = coarse or _steady(inner_model(model, (Tracked,)), pose)
    near = bare.impedance(Pose.of(places), frequency)
    if whole is None:
        found = near if bare is model else model.impedance(Pose.of(places[:1]), frequency)
        shared = None if found.shared_L is None else found.shared_L[:, 0]
        parts = {name: getattr(found, name)[0] for name in ("L", "R", "error_L", "error_R")}
        whole = replace(found, **parts, shared_L=shared)
    by_pose = []
    for values, there, free in ((near.L, whole.L, whole.L0), (near.R, whole.R, 0.0)):
        slope = _slopes(values, stencil, steps)
        if coarse is not None and (free is whole.L0 or not whole.uneven):  # R of tracks is beside that of the plate
            shares = _shares(there - free, values[0] - (near.L0 if free is whole.L0 else 0.0))
        by_pose.append(slope if coarse is None else slope * shares[..., None])
    return whole, by_pose[0], by_pose[1]


def lift_slopes(
    sensor: Sensor, pose: Pose, shapes: Callable[[Array], Array], planes: Array, sizes: Array
) -> Array:
    """Return how coils see the target lifted by K shapes over how they see it lifted by the first of them, (K, n).

    `shapes` and `planes` as of `Lift`; `sizes` (K,) are the largest of each [1, m]. By differences of `sheets` on its
    coarsest division, without fixed plates, spirals as rings: 20 to 80 times faster, 1 % off; raises as that.
    """
    coils = tuple(coil.model_copy(update={"winding": "rings"}) for coil in sensor.coils)
    alone = sensor.model_copy(update={"conductors": (), "coils": coils})
    each = abs(_QUICK) * STEP * room(alone, pose) * np.diag(1.0 / sizes)
    lift = Lift(shapes, planes, np.concatenate([each, -each]))
    model = replace(sheets(alone, _ROUGH).varied(alone, single=True), lift=lift)
    found = model.impedance(Pose.of(np.tile(pose.components, (len(lift.sizes), 1))), sensor.frequency)
    up, down = np.split(np.diagonal(found.L, axis1=1, axis2=2), 2)
    changed = up - down
    return np.asarray(changed / changed[0] * sizes[:, None] / sizes[0])


def _moved(
    sensor: Sensor, pose: Pose, components: Sequence[str], stencil: Stencil, factor: float
) -> tuple[Array, Array]:
    """Return poses and those beside them, component by component, (m, p, 6), and the steps (k, p)."""
    index = [POSE.index(name) for name in components]
    steps = _steps(sensor, pose)[index] * factor if index else np.zeros((0, len(pose.components)))
    moves = [(k, h, place) for k, h in zip(index, steps, strict=True) for place in stencil.places if place]
    places = np.repeat(pose.components[None], 1 + len(moves), axis=0)
    for row, (k, h, place) in zip(places[1:], moves, strict=True):
        row[:, k] += place * h
    return places, steps


def _slopes(values: Array, stencil: Stencil, steps: Array) -> Array:
    """Return derivatives (p, n, n, k) from values at the poses of `_moved`."""
    ways = [place for place in stencil.places if place]
    each = values[1:].reshape(len(steps), len(ways), *values.shape[1:])
    slope = np.zeros((*values.shape[1:], len(steps)))
    for k, (h, one) in enumerate(zip(steps, each, strict=True)):
        slope[..., k] = stencil.slope({0: values[0]} | dict(zip(ways, one, strict=True)), h[:, None, None])
    return slope


def solver_of(model: Any) -> Any:
    """Return what answers for a scene: the model itself, or the one that it adds errors to."""
    model = inner_model(model)
    if not hasattr(model, "sensor"):
        raise ValueError(f"lengths: need a model that can be made for another scene, got {type(model).__name__}")
    return model


def inner_model(model: Any, kept: tuple[type, ...] = ()) -> Any:
    """Return the model that another adds errors to; itself, if it adds none, or is of a kind that is kept."""
    while hasattr(model, "model") and not isinstance(model, kept):
        model = model.model
    return model


def _steady(model: Any, pose: Pose) -> Any:
    """Return a model that is prepared for all steps from some poses as for these; itself where it needs none."""
    inner = inner_model(model)
    if not isinstance(inner, Sheets):
        return model
    steady = inner.prepared_at(pose)
    return model if steady is inner else replace(model, model=steady) if isinstance(model, Tracked) else steady


def _coarse(model: Any) -> Sheets | None:
    """Return the model by a plate's coarsest division; None of one that has no other."""
    model = inner_model(model)
    if not isinstance(model, Sheets) or model.single:
        return None
    found = model.varied(model.sensor, single=True)
    return found if found.single else None


def _shares(whole: Array, coarse: Array) -> Array:
    """Return r_c r_d of the module docstring, shape (p, n, n)."""
    own, other = (np.abs(np.diagonal(part, axis1=-2, axis2=-1)) for part in (whole, coarse))
    r = np.sqrt(own / np.where(other > 0.0, other, 1.0))
    return r[..., None] * r[..., None, :]


def _steps(sensor: Sensor, pose: Pose) -> Array:
    """Return steps h of all components, shape (6, p) [m, rad]."""
    if sensor.target is None:
        raise ValueError("target: the scene has none whose pose could change")
    way = STEP * room(sensor, pose)
    turn = way / (0.5 * max(sensor.target.extent))
    return np.stack([way, way, turn, way, turn, turn])
