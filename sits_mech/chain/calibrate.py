"""Calculate what the sensor shows over a grid of loads: the chain of simulate.py on every load, as one table."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.cases import Progress, no_progress
from sits_mech.chain.columns import Columns, of_readings, of_rests, over_grid
from sits_mech.chain.derivatives.gradient import SlopedModel, scene_numbers
from sits_mech.chain.derivatives.gradient_grid import WithSlopes
from sits_mech.chain.derivatives.temperature import CHAINED, slopes_by_temperature
from sits_mech.chain.interpolate import LayerGrid, checked_values, loads_of
from sits_mech.chain.models import loaded_model
from sits_mech.chain.omitted.mechanical import with_omissions
from sits_mech.chain.plans.aimed import AimedLoads, aimed_loads, aimed_mechanics, status_of
from sits_mech.chain.plans.goal import answer_error
from sits_mech.chain.propagation import Direct, poses_of, read_poses
from sits_mech.labels import labelled
from sits_mech.maps.grid import Axes
from sits_mech.mechanics.loads import Settled, kept_key
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.mechanics.touch import check_force, check_places, check_untouched
from sits_mech.notes import NoteKind, packed, packed_omissions
from sits_mech.quantities import TOUCH, WRENCH, Equilibrium, Impedance, MechanicalModel
from sits_mech.scene.parameters import Parameter
from sits_mech.scene.sensor import SceneError, Sensor, known_stretch, provenance, silicones_of
from sits_mech.scene.thermal import CAUSES, unknown_coefficients
from sits_mech.silicone.stability import renewed_notes
from sits_mech.status import OK, flags_of, marked
from sits_mech.units import checked_tolerance

if TYPE_CHECKING:
    import xarray as xr

_MOST = 100_000  # loads: minutes to fill in between those that are solved

Loads = float | Sequence[float]
"""Values of a component of a load [N, N m]: many are a dimension of the table, one number is the same for all of it."""


@checked_arguments
def calibrate(
    sensor: Sensor, *, F_x: Loads = 0.0, F_z: Loads = 0.0, M: Loads = 0.0, F_y: Loads = 0.0, M_x: Loads = 0.0,
    M_z: Loads = 0.0, touch_x: Loads | None = None, touch_y: Loads | None = None, tolerance: float = 1e-2,
    mechanics: str = "auto", magnetics: str = "auto", progress: Progress = no_progress, folder: Path | None = None,
    drift: bool = False, best: bool = True,
) -> xr.Dataset:
    """Return what the sensor shows over a grid of loads.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    F_x, F_z, M, F_y, M_x, M_z : float or sequence of float
        Components of the loads, as of `Wrench` [N, N m]. A sequence is a dimension of the table, of one value as well;
        a number is a coordinate without dimension where it is not zero. F_x and F_z are dimensions in any case.
    touch_x, touch_y : float or sequence of float, optional
        Where the scene's touch presses on the target at rest, in place of its own `x` and `y` [m].
    tolerance : float
        Requested error of the signals, over the largest range that any of them has.
    mechanics, magnetics
        As for `simulate`; one model answers all loads.
    progress : callable, optional
        Called with the number of loads done and of all.
    folder : Path, optional
        Where finished loads are kept, one file each, and looked for first.
    drift : bool
        Whether slopes by temperature are asked for: ``slope_T_L``, ``slope_T_d_h``, ... (derivatives/temperature.py).
    best : bool
        Whether a tolerance that cannot be reached is answered as well as possible; without it models of several meshes
        refuse it.

    Returns
    -------
    Dataset, dims (F_x, F_z) and what else is a sequence, in the order of `WRENCH`
        Pose, impedance, signals, each with ``error_``; ``status`` and ``flags`` (status.py), ``reason``, ``notes``
        (kinds and numbers as JSON, which `notes.unpacked` reads), ``seconds``, ``min_J`` and ``stretch`` as of
        `SolveReport`, NaN where not known, the latter straight from solved load to solved load. Of the pose d_y,
        alpha_x and alpha_z only where a load leaves the plane. A load that fails has NaN and says why. Attributes hold
        scene, hash, request, version, ``unit_L``, and in ``left_out`` what counts of what the models leave out, with
        sizes, as JSON; ``planned`` seconds of processor time and error over the full scale as the largest load's first
        meshes show them, the error that was ``reached``, and the whole ``error``, with what is left out.

    Raises
    ------
    SceneError
        When a model cannot hold the scene or a component, a list of forces is empty, has a value twice or one that is
        not finite, there are too many loads, a place is beside the target or comes with moments or without a touch, or
        without `best` a tolerance cannot be reached.

    Examples
    --------
    >>> models = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sm.load_sensor("biorob2018"), F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> dict(data["L_v_percent"].sizes), data["status"].values.ravel()[0]
    ({'F_x': 3, 'F_z': 3}, 'above tolerance')
    """
    check_force(sensor.touch, "a table over forces")
    given, tolerance = dict(zip(WRENCH, (F_x, F_z, M, F_y, M_x, M_z), strict=True)), checked_tolerance(tolerance)
    given |= {name: each for name, each in zip(TOUCH, (touch_x, touch_y), strict=True) if each is not None}
    axes = {name: checked_values(name, values) for name, values in given.items()}
    check_places(sensor, axes)
    grid = {name: axes[name] for name in axes if name in ("F_x", "F_z") or np.ndim(given[name])}
    fixed = {name: own[0] for name, own in axes.items() if name not in grid and (own[0] != 0.0 or name in TOUCH)}
    count = math.prod(len(values) for values in axes.values())
    if count > _MOST:
        raise SceneError(f"loads: must be at most {_MOST} of a table; got {count}: take fewer values of a component")
    loads = loads_of(axes, sensor.touched_point)
    _, by_field = loaded_model(sensor, magnetics, tolerance, loads)
    layer, by_layer = aimed_mechanics(sensor, mechanics, tolerance, loads, magnetics)
    numbers = _by_temperature(sensor, by_layer.name, layer) if drift else None
    own = layer if numbers is None else WithSlopes(layer, tuple(numbers[1]))
    keep = (folder, kept_key(sensor, by_layer.name, by_layer.asked(tolerance), drift=drift))
    every = LayerGrid(sensor, own, axes, symmetry_of(sensor), tolerance, keep, progress)
    found = aimed_loads(every, magnetics, best=best, whole=partial(with_omissions, sensor, name=by_layer.name))
    request = {"mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance, **grid, **fixed}
    by_name = found.field, by_field.name, found.asked
    slopes = partial(slopes_by_temperature, sensor, by_name, numbers) if numbers else None
    return tabulated(sensor, found, request, (grid, fixed), slopes=slopes)


def tabulated(
    sensor: Sensor, found: AimedLoads, request: Mapping[str, Any], axes: tuple[Axes, Mapping[str, float]],
    *, slopes: Callable[[Impedance, Sequence[Equilibrium]], Columns] | None = None,
    direct: Direct | None = None,
) -> xr.Dataset:
    """Return the table of loads that have come to rest, as `calibrate` does.

    `request` names models and tolerance; `axes` are the components of loads that are dimensions, and those that are
    not; `slopes` makes the columns by temperature; `direct` as of `read_poses`.
    """
    import xarray as xr

    grid, fixed = axes
    columns, read, shown, error = _read(sensor, found, axes, request, slopes, direct)
    coils = sensor.coil_names
    coords = {**grid, "coil": coils, "coil_2": coils, **fixed} | ({"thermal_cause": list(CAUSES)} if slopes else {})
    data = xr.Dataset(columns, coords)
    data["L0"] = (("coil", "coil_2"), shown.L0)
    left_out = (*(read[0].report.left_out if read else ()), *shown.report.left_out)
    attributes: dict[str, Any] = {"temperature": sensor.temperature, "frequency": sensor.frequency}
    attributes |= {} if sensor.touch is None else {"touch": list(sensor.touched_point)}
    attributes |= shown.convention | {"request": json.dumps(request), "magnetics_tolerance": found.asked}
    attributes |= {"notes": "", "left_out": packed_omissions(left_out)} | _promised(found, error)
    return labelled(data.assign_attrs(**provenance(sensor), **attributes))


def _read(
    sensor: Sensor, found: AimedLoads, axes: tuple[Axes, Mapping[str, float]], request: Mapping[str, Any],
    slopes: Callable[[Impedance, Sequence[Equilibrium]], Columns] | None, direct: Direct | None,
) -> tuple[Columns, list[Equilibrium], Impedance, float]:
    """Return the columns of all loads, rests and impedances of those with a reading, and the largest error of these.

    It is over the signals' full scale, with all that is left out.
    """
    grid, fixed = axes
    places = [name for name in TOUCH if name in grid or name in fixed]
    every = {name: grid.get(name, [fixed.get(name, 0.0)]) for name in (*WRENCH, *places)}
    loads = loads_of(every, sensor.touched_point)
    settled = [found.settled[load] for load in loads]
    status = [status_of(sensor, one) for one in settled]
    good = [word == OK for word, _ in status]
    at_rest = [one.rest for one in settled if one.rest]
    known = iter(with_omissions(sensor, at_rest, request["mechanics"], adapted=direct is not None))
    settled = [replace(one, rest=next(known)) if one.rest else one for one in settled]
    rests = [one.rest for one in settled]
    read = [rest for rest, fine in zip(rests, good, strict=True) if rest and fine]
    poses = poses_of(read)
    reading = read_poses(sensor, found.field, poses, direct=direct)
    shown = reading.impedance
    share = shown.report.seconds / max(len(read), 1)
    seconds = {"seconds": ((), np.array([one.seconds for one in settled]) + np.array(good) * share)}
    errors = [0.0 if one is None else answer_error(found.goal, one, shown.report.left_out) for one in rests]
    words = _words(sensor, settled, status, errors, (request["tolerance"], shown))
    own = over_grid(grid, np.ones(len(loads)), words | seconds)
    of_read = of_readings(sensor, reading, poses) | ({} if slopes is None else slopes(shown, read))
    of_read |= {"error_magnetics": ((), np.full(len(read), shown.report.estimated_error))}
    carried = of_rests(list(filter(None, rests)), leaves=any(load.out_of_plane for load in loads))
    columns = over_grid(grid, [rest is not None for rest in rests], carried) | over_grid(grid, good, of_read) | own
    order = ("status", "reason", *carried, "notes", "seconds", *of_read, "flags")
    largest = max((error for error, fine in zip(errors, good, strict=True) if fine), default=np.nan)
    return {name: columns[name] for name in order}, read, shown, largest


def _words(
    sensor: Sensor, settled: Sequence[Settled], status: Sequence[tuple[str, str]], errors: Sequence[float],
    asked: tuple[float, Impedance],
) -> Columns:
    """Return status, notes, flags and reason of all loads."""
    words = [word for word, _ in status]
    marks = [_marks(sensor, one, word, error, asked) for one, word, error in zip(settled, words, errors, strict=True)]
    own: Columns = {name: ((), [mark[name] for mark in marks]) for name in ("status", "notes", "flags")}
    return own | {"reason": ((), [why for _, why in status])}


def _promised(found: AimedLoads, error: float) -> dict[str, Any]:
    """Return planned seconds and error over full scale, the error reached and the whole one, where known."""
    if found.planned is None:
        return {}
    return {"planned": [found.planned.seconds, found.planned.error], "reached": found.reached, "error": error}


def _marks(
    sensor: Sensor, settled: Settled, status: str, error: float, asked: tuple[float, Impedance]
) -> dict[str, str]:
    """Return status, flags and notes of a load from its error over the signals' full scale."""
    rest = settled.rest
    notes = () if rest is None else rest.report.notes
    if rest is None or status != OK:
        return marked([status]) | {"notes": packed(notes)}
    tolerance, left_out = asked[0], asked[1].report.left_out
    stretch = np.nan if rest.report.stretch is None else rest.report.stretch
    made = silicones_of(sensor)
    if len(made) == 1 and np.isfinite(stretch):  # which of layers are stretched so far is not known between loads
        notes = renewed_notes(notes, made[0], stretch)
    bounded = not any(item.unbounded for item in (*rest.report.left_out, *left_out))
    between = any(note.kind is NoteKind.INTERPOLATED for note in notes)
    flags = flags_of(error, tolerance, stretch, known_stretch(sensor), interpolated=between, bounded=bounded)
    return {"notes": packed(notes)} | marked(flags)


def _by_temperature(sensor: Sensor, name: str, layer: MechanicalModel) -> tuple[list[Parameter], list[Parameter]]:
    """Return the parameters of the sensor's temperature, and those of them that move the target."""
    check_untouched(sensor, "drift")
    if not isinstance(layer, SlopedModel):
        raise SceneError(f"drift: must be asked of the mechanics block, planar, axisymmetric or linear; got {name}")
    missing = unknown_coefficients(sensor)
    if missing:
        raise SceneError(f"drift: {missing}")
    return scene_numbers(sensor, CHAINED)
