"""Calculate what the sensor shows over a grid of loads: the chain of simulate.py on every load, as one table."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.cases import Progress, Row, table
from sits_mech.chain.aimed import AimedRows, aimed_rows, status_of
from sits_mech.chain.goal import Goal
from sits_mech.chain.gradient import SlopedModel, numbers_of
from sits_mech.chain.gradient_grid import WithSlopes
from sits_mech.chain.interpolate import INTERPOLATED, loads_of
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.omissions import Shown, beside_errors, omissions
from sits_mech.chain.plan import leaving
from sits_mech.chain.pose_errors import Reading, poses_of, read_poses, signal_weights, signals_at
from sits_mech.chain.temperature import CHAINED, slopes_by_temperature
from sits_mech.labels import labelled
from sits_mech.mechanics.loads import ERRORS, kept_key, shared_of
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import POSE, WRENCH, Array, Impedance, MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.readout.signals import Signals, signal_changes, signals
from sits_mech.scene.parameters import Parameter
from sits_mech.scene.sensor import SceneError, Sensor, known_stretch, provenance
from sits_mech.scene.thermal import CAUSES, unknown_coefficients
from sits_mech.silicone.stability import renewed_notes
from sits_mech.status import ANSWERED, OK, flags_of, marked
from sits_mech.units import shown

if TYPE_CHECKING:
    import xarray as xr

_UNTILTED = {"dL_x": "dL_x_untilted", "dL_y": "dL_y_untilted", "L_h_percent": "L_h_untilted_percent"}
_SAME = 1e-9  # of the largest value of a component: what is closer is twice the same
_MOST = 100_000  # loads: minutes to fill in between those that are solved

Loads = float | Sequence[float]
"""Values of a component of a load [N, N m]: many are a dimension of the table, one number is the same for all of it."""


def calibrate(
    sensor: Sensor,
    *,
    F_x: Loads = 0.0,
    F_z: Loads = 0.0,
    M: Loads = 0.0,
    F_y: Loads = 0.0,
    M_x: Loads = 0.0,
    M_z: Loads = 0.0,
    tolerance: float = 1e-2,
    mechanics: str = "auto",
    magnetics: str = "auto",
    progress: Progress | None = None,
    folder: Path | None = None,
    drift: bool = False,
    best: bool = True,
) -> xr.Dataset:
    """Return what the sensor shows over a grid of loads.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    F_x, F_z, M, F_y, M_x, M_z : float or sequence of float
        Components of the loads, as of `Wrench` [N, N m]. A sequence is a dimension of the table, of one value as well;
        a number is a coordinate without dimension where it is not zero. F_x and F_z are dimensions in any case.
    tolerance : float
        Asked error of the signals, over the largest range that any of them has.
    mechanics, magnetics
        As for `simulate`; one model answers all loads.
    progress : callable, optional
        Called with the number of loads done and of all.
    folder : Path, optional
        Where finished loads are kept, one file each, and looked for first.
    drift : bool
        Whether slopes by temperature are asked for: ``slope_T_L``, ``slope_T_d_h``, ... (chain/temperature.py).
    best : bool
        Whether a tolerance that cannot be reached for these loads is answered with what is; it is refused otherwise.

    Returns
    -------
    Dataset, dims (F_x, F_z) and what else is a sequence, in the order of `WRENCH`
        Pose, impedance, signals, each with ``error_``; ``status`` and ``flags`` (status.py), ``reason``, ``notes``,
        ``seconds``, ``min_J`` and ``stretch`` as of `SolveReport`, NaN where not known, the latter straight from solved
        load to solved load. Of the pose d_y, alpha_x and alpha_z only where a load leaves the plane. A load that fails
        has NaN and says why. Attributes hold scene, hash, request, version, ``unit_L``, and in ``notes`` what
        conductors change of the model; ``planned`` seconds of processor time and error over the full scale as the
        largest load's first meshes show them, and the error that was ``reached``.

    Raises
    ------
    SceneError
        When a model cannot hold the scene or a component, a list of forces is empty, has a value twice or one that is
        not finite, there are too many loads, or without `best` a tolerance cannot be reached.

    Examples
    --------
    >>> models = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sm.load_sensor("biorob2018"), F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> dict(data["L_v_percent"].sizes), data["status"].values.ravel()[0]
    ({'F_x': 3, 'F_z': 3}, 'ok')
    """
    given = dict(zip(WRENCH, (F_x, F_z, M, F_y, M_x, M_z), strict=True))
    axes = {name: _checked(name, values) for name, values in given.items()}
    grid = {name: axes[name] for name in WRENCH if name in ("F_x", "F_z") or np.ndim(given[name])}
    fixed = {name: values[0] for name, values in axes.items() if name not in grid and values[0] != 0.0}
    count = math.prod(len(values) for values in axes.values())
    if count > _MOST:
        raise SceneError(f"loads: must be at most {_MOST} of a table; got {count}: take fewer values of a component")
    loads = loads_of(axes)
    _, by_field = loaded_model(sensor, magnetics, tolerance, loads)
    layer, by_layer = mechanical_model(sensor, mechanics, tolerance, loads)
    request = {"mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance, **grid, **fixed}
    numbers = _by_temperature(sensor, by_layer.name, layer) if drift else ([], [])
    layer = WithSlopes(layer, tuple(numbers[1])) if drift else layer
    keep = (folder, kept_key(sensor, by_layer.name, tolerance, drift=drift))
    found = aimed_rows(
        sensor, layer, axes, (by_layer.name, magnetics), tolerance,
        symmetry=symmetry_of(sensor), keep=keep, progress=progress, best=best,
    )
    more = None if not drift else partial(
        slopes_by_temperature, sensor, (found.field, by_field.name, found.asked), numbers=numbers
    )
    rows = [found.rows[load] for load in loads]
    reading, done = _read_rows(sensor, found.field, _shown(rows, loads), more)
    done = [row | _marks(sensor, found.goal, own, tolerance) for row, own in zip(done, rows, strict=True)]
    coils = [coil.name for coil in sensor.coils]
    data = table(grid, done).assign_coords({"coil": coils, "coil_2": coils, **fixed})
    data = data.assign_coords(thermal_cause=list(CAUSES)) if drift else data
    data["L0"] = (("coil", "coil_2"), reading.L0)
    said = (*by_field.notes, *(f"left out: {item.text}" for item in by_field.left_out))
    said += _beside(sensor, (by_layer.name, by_field.name), done, reading)
    attributes: dict[str, Any] = {"temperature": sensor.temperature, "frequency": sensor.frequency}
    attributes |= {"unit_L": reading.unit_L, "request": json.dumps(request)}
    attributes |= {"notes": "; ".join(said)} | _promised(found)
    return labelled(data.assign_attrs(**provenance(sensor), **attributes))


def _promised(found: AimedRows) -> dict[str, Any]:
    """Return planned seconds and error over full scale, and the error reached, where known."""
    if found.planned is None:
        return {}
    return {"planned": [found.planned.seconds, found.planned.error], "reached": found.reached}


def _beside(sensor: Sensor, names: tuple[str, str], rows: Sequence[Row], found: Impedance) -> tuple[str, ...]:
    """Name what sections leave out beside the errors, at the pose whose inductances change most."""
    done = [row for row in rows if row["status"] in ANSWERED]
    if not done:
        return ()
    most = np.argmax(np.abs(found.L - found.L0).max(axis=(1, 2)), keepdims=True)
    own = {name: getattr(found, name)[most] for name in ("L", "R", "error_L", "error_R")}
    shown = Shown(Pose.of(poses_of(done)[0].components[most]), replace(found, **own, shared_L=None))
    size, unknown = beside_errors(omissions(sensor, (), *names, shown))
    parts = [f"what sections neglect, {size:.2g} of the largest change, is not in the errors"] if size > 0.0 else []
    return (*parts, *(f"{name}: not estimated, not in the errors" for name in unknown))


def _checked(name: str, values: Loads) -> list[float]:
    """Return the values of a component in ascending order; raise SceneError for bad ones."""
    try:
        given = np.sort(np.atleast_1d(np.asarray(values, dtype=float)))
    except (TypeError, ValueError):
        given = np.full(1, np.nan)
    largest = np.max(np.abs(given), initial=0.0)
    if given.ndim > 1 or not given.size or not np.all(np.isfinite(given)) or np.any(np.diff(given) <= _SAME * largest):
        what = "moments [N m]" if name.startswith("M") else "forces [N]"
        raise SceneError(f"{name} must be one or more different finite {what}; got {shown(values)}")
    rounded = (given != -given[::-1]) & (np.abs(given + given[::-1]) <= _SAME * largest)  # two images are one solve
    return [float(f"{value:.14g}") if own else float(value) for value, own in zip(given, rounded, strict=True)]


def _marks(sensor: Sensor, goal: Goal | None, row: Row, tolerance: float) -> dict[str, str]:
    """Return status and flags of a load from its errors over the signals' full scale."""
    status, _ = status_of(sensor, row)
    if status != OK:
        return marked([status])
    error = 0.0 if goal is None else goal.of(np.array([row[name] for name in ERRORS]), shared_of(row))
    notes, stretch = row["notes"], row["stretch"]
    if sensor.elastomer is not None and np.isfinite(stretch):
        notes = renewed_notes(notes, sensor.elastomer.silicone, stretch)
    flags = flags_of(error, tolerance, stretch, known_stretch(sensor), interpolated=INTERPOLATED in notes)
    return {"notes": notes} | marked(flags)


def _shown(rows: Sequence[Row], loads: Sequence[Wrench]) -> list[Row]:
    """Return the rows of loads without states, and without out-of-plane components where no load has any."""
    beside = () if leaving(loads) else POSE[3:]
    hidden = {"state", "unknowns", *beside, *(f"error_{name}" for name in beside)}
    return [{name: item for name, item in row.items() if name not in hidden} for row in rows]


def _by_temperature(
    sensor: Sensor, name: str, layer: MechanicalModel
) -> tuple[list[Parameter], list[Parameter]]:
    """Return the parameters of the sensor's temperature, and those of them that move the target."""
    if not isinstance(layer, SlopedModel):
        raise SceneError(f"drift: must be asked of the mechanics block, planar or linear; got {name}")
    said = unknown_coefficients(sensor)
    if said:
        raise SceneError(f"drift: {said}")
    return numbers_of(sensor, CHAINED)


def _read_rows(
    sensor: Sensor, model: MagneticModel, rows: Sequence[Row], more: Callable[..., dict[str, Array]] | None = None
) -> tuple[Impedance, list[Row]]:
    """Return the impedance of all converged rows, and the rows with impedances, signals and `more`."""
    checked = [row | dict(zip(("status", "reason"), status_of(sensor, row), strict=True)) for row in rows]
    good = [row for row in checked if row["status"] == OK]
    poses, errors, parts = poses_of(good)
    reading = read_poses(sensor, model, poses, errors, parts)
    found, coils, shared = reading.impedance, ("coil", "coil_2"), _shared(sensor, reading, parts)
    share = found.report.seconds / max(len(good), 1)
    beside = {} if more is None else more(found, poses, rows=good)
    own = {"slope_T_L": ("coil",), "slope_T_L_by": ("thermal_cause", "coil")}
    more_dims = {name: own.get(name, ()) for name in beside}
    numbers = iter(range(len(good)))
    done = []
    for row in checked:
        shown: dict[str, Any] = dict.fromkeys((*reading.signals.known, *_untilted(reading.untilted)), np.nan)
        shown |= {name: (coils, np.full(found.L0.shape, np.nan)) for name in ("L", "R", "error_L", "error_R")}
        shown |= {name: _entry(more_dims[name], np.full(part.shape[1:], np.nan)) for name, part in beside.items()}
        if row["status"] == OK:
            i = next(numbers)
            shown = {name: (coils, getattr(found, name)[i]) for name in ("L", "R", "error_L", "error_R")}
            shown |= signals_at(reading.signals, i).known | _untilted(signals_at(reading.untilted, i))
            shown |= {name: _entry(dims, values[i]) for name, (dims, values) in shared.items()}
            shown |= {name: _entry(more_dims[name], part[i]) for name, part in beside.items()}
            shown |= {"error_magnetics": found.report.estimated_error, "seconds": row["seconds"] + share}
        done.append({name: item for name, item in row.items() if name not in ("shared", "slopes")} | shown)
    return found, done


def _entry(dims: tuple[str, ...], values: Any) -> Any:
    """Return an entry of a row: an array with its dimensions, or a number."""
    return (dims, values) if dims else float(values)


def _untilted(found: Signals) -> dict[str, Any]:
    """Return the shear signals without rotation, under the names of a table."""
    return {name: found.known[key] for key, name in _UNTILTED.items() if key in found.known}


def _shared(sensor: Sensor, reading: Reading, parts: Array) -> dict[str, tuple[tuple[str, ...], Array]]:
    """Return errors of L as variables of a table, shape (p, ...).

    Signed parts that loads share, the magnetic model's last, those of each load alone, and errors of what the rotation
    does to a signal.
    """
    weights, L0 = signal_weights(sensor), np.diagonal(reading.impedance.L0)
    own, level = (signal_changes(change, L0, weights) for change in (reading.shared, reading.shared_untilted))
    shared = {name: values.T for name, values in own.items()}
    shared |= {name: level[key].T for key, name in _UNTILTED.items() if key in level}
    poses = np.pad(parts, ((0, len(reading.shared) - len(parts)), (0, 0), (0, 0)))  # magnetics moves nothing
    shared |= {name: poses[..., k].T for k, name in enumerate(POSE)}
    turned = signals(np.broadcast_to(L0, (len(reading.turned), len(L0))), L0, weights, reading.turned).known
    found: dict[str, tuple[tuple[str, ...], Array]] = {
        f"shared_{name}": (("part",), values) for name, values in shared.items()
    }
    found["shared_L"] = ("part", "coil"), reading.shared.swapaxes(0, 1)
    found["alone_L"] = ("cause", "coil"), reading.alone.swapaxes(0, 1)
    known = {name: np.asarray(turned[f"error_{name}"]) for name in _UNTILTED if name in turned}
    return found | {f"error_{name.removesuffix('_percent')}_turned": ((), values) for name, values in known.items()}
