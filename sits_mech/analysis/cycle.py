"""Simulate a load cycle: hysteresis by the silicone's rate and softening.

    load s(t) --(viscosity, softening: silicone/history.py)--> elastic share s_e(t) --(chain)--> pose, L, signals

All loads are shares s of one peak wrench, so that pose, inductance and signals are functions of the elastic share
alone: they are solved at a few shares, and a cubic spline carries them through time. Their errors are those of the
chain, plus what the spline changes when every second share is left out.

A loop's width is the largest difference of a signal between loading and unloading at one load, in percent of the range
that the signal covers in that loop. Both branches are one function of the elastic share, whose errors stretch the loop
but open none: the width's error is its own size times that of the range.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline, make_interp_spline

from sits_mech.chain.models import loaded_model
from sits_mech.chain.omitted.mechanical import with_omissions
from sits_mech.chain.plans.aimed import aim_at, aimed_mechanics
from sits_mech.chain.plans.goal import farthest, flags_over
from sits_mech.chain.propagation import PoseReadings, poses_of, read_poses
from sits_mech.geometry.collision import check_clearance
from sits_mech.labels import labelled
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.mechanics.symmetry import symmetrised, symmetry_of
from sits_mech.notes import Note, NoteKind, packed, packed_omissions
from sits_mech.quantities import POSE, Array, Bounded, Pose, Wrench
from sits_mech.readout.signals import changes, shown_signals
from sits_mech.scene.parts.elastomer import pad_volume
from sits_mech.scene.sensor import SceneError, Sensor, provenance, silicone_of
from sits_mech.silicone.history import ElasticCurve, elastic_curve, relaxed_share, softened_share
from sits_mech.status import joined, marked


@dataclass(frozen=True)
class Programme:
    """A load over time, as a share of the peak wrench, linear in between."""

    time: Array  # (n,), not descending; twice the same is a step [s]
    share: Array  # (n,), 0 to 1 [-]


def triangle(period: float, cycles: int = 2, samples: int = 200) -> Programme:
    """Return a load that rises and falls evenly, with `period` from minimum to minimum [s].

    `samples` of each cycle is even. Raises SceneError for values that make no cycle.
    """
    if not 0.0 < period < np.inf:
        raise SceneError(f"period must be a positive time [s]; got {period}")
    if cycles < 1 or samples < 4 or samples % 2:
        raise SceneError(f"cycles must be 1 or more and samples even, from 4 on; got {cycles} and {samples}")
    phase = np.arange(cycles * samples + 1) / samples
    return Programme(phase * period, 1.0 - np.abs(2.0 * (phase % 1.0) - 1.0))


def load_cycle(
    sensor: Sensor, peak: Wrench, programme: Programme, *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto", points: int = 17,
) -> xr.Dataset:
    """Return pose, inductance and signals under a load cycle up to `peak`, as a Dataset over time.

    ``share``, ``elastic_share``; pose, ``L`` (coil, coil_2) and the signals, each with ``error_``. Attributes: scene,
    request, ``notes``, ``unit_L``, ``status``, ``flags``, ``error``, the largest one over the signals' full scale, and
    of each signal that is shown ``loop_L_v_percent`` and the like: widths of its loops in percent of its range, one for
    each cycle, with ``error_``; NaN where the range is within the signal's error. A silicone without ``prony`` and
    ``mullins`` shows no loop. `points`, odd and at least 5, loads are solved. Raises SceneError for a scene or
    programme that cannot be solved, Collision where the target touches the coil plane, SolveFailed without an
    equilibrium on the way.
    """
    LoadHistory(programme.time, np.multiply.outer(programme.share, peak.components))
    if not np.all((programme.share >= 0.0) & (programme.share <= 1.0)):
        raise SceneError(f"share must lie between 0 and 1; got {programme.share.min():g} to {programme.share.max():g}")
    field, by_field = loaded_model(sensor, magnetics, tolerance, [peak])
    layer, by_layer = aimed_mechanics(sensor, mechanics, tolerance, [peak], magnetics)
    curve = elastic_curve(layer, peak, height=layer_parts(sensor)[0].load_height, points=points)
    symmetry = symmetry_of(sensor)
    found = [symmetrised(item, symmetry, item.wrench) for item in curve.found]
    curve = replace(curve, found=tuple(with_omissions(sensor, found, by_layer.name)))
    for item in curve.found:
        check_clearance(sensor, item.pose)
    poses = _poses(curve)
    aim = aim_at(sensor, magnetics, tolerance, [peak], farthest(Pose.of(poses.value)))
    field, goal = (field, None) if aim is None else (aim.field, aim.goal)
    reading = read_poses(sensor, field, poses)
    elastic = _elastic_share(sensor, programme, curve)
    columns = {"share": ("time", programme.share), "elastic_share": ("time", elastic)}
    columns |= _carried(curve, poses, reading, elastic)
    pose, error = (np.stack([columns[f"{kind}{name}"][1] for name in POSE], axis=-1) for kind in ("", "error_"))
    stretch = np.interp(elastic, curve.share, np.array([each.report.stretch for each in curve.found], dtype=float))

    left_out = (*curve.found[-1].report.left_out, *reading.impedance.report.left_out)
    marks, worst = flags_over(sensor, goal, Bounded.of(pose, error), stretch, tolerance, left_out)
    names = sensor.coil_names
    data = xr.Dataset(columns, coords={"time": programme.time, "coil": names, "coil_2": names})
    data["L0"] = (("coil", "coil_2"), reading.impedance.L0)
    request = {"peak": vars(peak), "mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance}
    data = data.assign_attrs(
        **provenance(sensor), notes=packed(_notes(sensor)), left_out=packed_omissions(left_out),
        request=json.dumps(request), frequency=sensor.frequency, **reading.impedance.convention,
        **marked(joined(marks["flags"])), error=worst,
        **{key: item for name in shown_signals(data) for key, item in loop_widths(data, name).items()},
    )
    return labelled(data)


def _notes(sensor: Sensor) -> tuple[Note, ...]:
    """Note why there is no loop, where the silicone can show none, and that friction is left out."""
    silicone = silicone_of(sensor)
    rough = sensor.elastomer is not None and sensor.elastomer.friction > 0.0
    none = silicone is not None and not silicone.has_history
    return (Note(NoteKind.NO_LOOP),) * none + (Note(NoteKind.SLIP_LEFT_OUT),) * rough


def _poses(curve: ElasticCurve) -> Bounded:
    """Return the poses of a curve, each with its error alone, shape (p, 6)."""
    found = poses_of(curve.found)
    return Bounded.of(found.value, np.array([item.error.components for item in curve.found]))


def _elastic_share(sensor: Sensor, programme: Programme, curve: ElasticCurve) -> Array:
    """Return the share of the virgin elastic response that the pad shows."""
    if (silicone := silicone_of(sensor)) is None:
        return programme.share.copy()
    relaxed, (target, pad) = relaxed_share(silicone, programme.time, programme.share), layer_parts(sensor)
    volume = pad_volume(pad, target.extent, target.is_round)
    return softened_share(silicone.mullins, curve.energy, np.clip(relaxed, 0.0, 1.0), volume=volume)


def _carried(curve: ElasticCurve, poses: Bounded, reading: PoseReadings, elastic: Array) -> dict[str, Any]:
    """Return pose, inductance and signals over time, each with its error, as columns of a table."""
    found, shown = reading.impedance, reading.signals
    values: dict[str, tuple[Any, Any]] = {name: (poses.value[:, k], poses.error[:, k]) for k, name in enumerate(POSE)}
    values |= {"L": (found.L, found.error_L)}
    known = shown.known
    values |= {name: (item, known[f"error_{name}"]) for name, item in known.items() if f"error_{name}" in known}
    columns = {}
    for name, (value, own) in values.items():
        dims = ("time", "coil", "coil_2")[: np.ndim(value)]
        here = CubicSpline(curve.share, value)(elastic)
        thinned = CubicSpline(curve.share[::2], value[::2])(elastic)
        columns[name] = (dims, here)
        columns[f"error_{name}"] = (dims, make_interp_spline(curve.share, own, k=1)(elastic) + abs(here - thinned))
    return columns


def loop_widths(data: xr.Dataset, name: str) -> dict[str, list[float]]:
    """Return the widths of all loops of a signal over ``share`` in percent of its range, and their errors, by key."""
    share, signal, error = (data[key].to_numpy() for key in ("share", name, f"error_{name}"))
    found = [_loop(share[part], signal[part], error[part]) for part in cycles_of(share)]
    widths, errors = zip(*found, strict=True) if found else ((), ())
    return {f"loop_{name}": list(widths), f"error_loop_{name}": list(errors)}


def cycles_of(share: Array) -> list[slice]:
    """Return the slices of a load from minimum to minimum."""
    way = np.sign(np.diff(share))
    moving = np.flatnonzero(way)
    turns = moving[1:][way[moving][1:] > way[moving][:-1]]  # from falling to rising
    ends = [0, *turns.tolist(), share.size - 1]
    return [slice(a, b + 1) for a, b in zip(ends[:-1], ends[1:], strict=True) if {-1.0, 1.0} <= set(way[a:b])]


def _loop(share: Array, signal: Array, error: Array) -> tuple[float, float]:
    """Return width and error of one loop in percent of the signal's range; NaN for a range within its error."""
    top = int(np.argmax(share))
    low = max(share[0], share[-1])
    grid = np.linspace(low, share[top], 201)
    down = np.interp(grid, share[top:][::-1], signal[top:][::-1])
    width = float(np.max(np.abs(np.interp(grid, share[: top + 1], signal[: top + 1]) - down)))
    span, uncertainty = float(np.ptp(signal)), float(np.max(error))
    if not changes(signal, error):
        return float("nan"), float("nan")
    return 100.0 * width / span, 200.0 * width * uncertainty / span**2
