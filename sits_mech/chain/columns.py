"""Make the columns of a table of loads: of all loads, of those with a rest, of those with a reading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.chain.propagation import PoseReadings, signal_weights
from sits_mech.quantities import POSE, Bounded, Equilibrium
from sits_mech.readout.signals import signal_changes, signals
from sits_mech.scene.sensor import Sensor

Columns = dict[str, tuple[tuple[str, ...], Any]]  # dimensions and values by name
_UNTILTED = {"dL_x": "dL_x_untilted", "dL_y": "dL_y_untilted", "L_h_percent": "L_h_untilted_percent"}


def over_grid(axes: Mapping[str, Sequence[float]], known: ArrayLike, columns: Columns) -> Columns:
    """Return columns over all loads of a grid from columns over those that are `known`, (p,); NaN or "" elsewhere."""
    sizes, chosen = tuple(len(values) for values in axes.values()), np.asarray(known, dtype=bool)
    found: Columns = {}
    for name, (dims, values) in columns.items():
        own = np.asarray(values)
        text = own.dtype.kind in "UO"
        every = np.full((len(chosen), *own.shape[1:]), "" if text else np.nan, dtype=object if text else float)
        every[chosen] = own
        found[name] = (*axes, *dims), every.reshape(*sizes, *own.shape[1:])
    return found


def of_rests(rests: Sequence[Equilibrium], *, leaves: bool) -> Columns:
    """Return pose, error and report of rests; components out of the plane where any load `leaves` it."""
    found: Columns = {}
    for prefix, kind in (("", "pose"), ("error_", "error")):
        each = np.array([getattr(rest, kind).components for rest in rests]).reshape(-1, len(POSE))
        found |= {f"{prefix}{name}": ((), each[:, k]) for k, name in enumerate(POSE if leaves else POSE[:3])}
    report = {"min_J": "min_J", "stretch": "stretch", "error_mechanics": "estimated_error", "iterations": "iterations"}
    for name, own in report.items():
        found[name] = (), np.array([getattr(rest.report, own) for rest in rests], dtype=float)
    return found


def of_readings(sensor: Sensor, reading: PoseReadings, poses: Bounded) -> Columns:
    """Return impedances and signals of p readings, with the parts of their errors.

    Signed parts that loads share, the magnetic model's last, those of each load alone, and errors of what the rotation
    does to a signal.
    """
    weights, L0 = signal_weights(sensor), np.diagonal(reading.impedance.L0)
    found: Columns = {
        name: (("coil", "coil_2"), getattr(reading.impedance, name)) for name in ("L", "R", "error_L", "error_R")
    }
    found |= {name: ((), value) for name, value in reading.signals.known.items()}
    found |= {_UNTILTED[key]: ((), value) for key, value in reading.untilted.known.items() if key in _UNTILTED}
    own, untilted = (signal_changes(change, L0, weights) for change in (reading.shared, reading.shared_untilted))
    shared = {name: values.T for name, values in own.items()}
    shared |= {name: untilted[key].T for key, name in _UNTILTED.items() if key in untilted}
    parts = np.pad(poses.shared, ((0, len(reading.shared) - len(poses.shared)), (0, 0), (0, 0)))  # magnetics: none
    shared |= {name: parts[..., k].T for k, name in enumerate(POSE)}
    found |= {f"shared_{name}": (("part",), values) for name, values in shared.items()}
    found["shared_L"] = ("part", "coil"), reading.shared.swapaxes(0, 1)
    found["alone_L"] = ("cause", "coil"), reading.alone.swapaxes(0, 1)
    turned = signals(np.broadcast_to(L0, (len(reading.turned), len(L0))), L0, weights, reading.turned).known
    return found | {
        f"error_{name.removesuffix('_percent')}_turned": ((), turned[f"error_{name}"]) for name in _UNTILTED
        if name in turned
    }
