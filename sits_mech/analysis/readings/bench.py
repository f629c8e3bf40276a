"""Convert a table to what a bench measures: henries at the terminals, settings of the converter, forces.

A table in henry is taken as it is. Of a table per metre of depth only the relative change holds, so that

    L_i = L0_i l_i / l0_i,    R_i = L0_i r_i / l0_i,

with l, r, l0 per metre and L0 of the coil's rings in free space [H]; idle coils, whose coupling a planar model
overstates, are then left out (in space they are worth some 3.5e-4 of L0). Tracks (with skin and proximity effect) and
leads are added in series.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.spectrum import at_terminals
from sits_mech.arguments import Idle, checked_arguments
from sits_mech.chain.propagation import diagonals, signal_weights
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.quantities import POSE, Array, Impedance, Mask, SolveReport, tensor_grid
from sits_mech.readout.calibration import Calibration, calibration
from sits_mech.readout.converter import FrontEnd, code_of, converter, tank_frequency
from sits_mech.readout.front_end import front_end
from sits_mech.readout.loads import answered, varied
from sits_mech.readout.table_errors import TableErrors, table_errors
from sits_mech.scene.sensor import SceneError, Sensor, check_provenance, silicones_of
from sits_mech.scene.thermal import at_temperature, clock_factor

_IDLE = "idle coils: left out, a model per metre overstates their coupling"


def self_inductances(sensor: Sensor) -> Array:
    """Return the inductance of each coil without target, by its rings, shape (n,) [H]."""
    return np.array(np.diagonal(free_inductances(at_temperature(sensor).coils)))


def henries(sensor: Sensor, unit_L: str, L0: Array) -> Array:
    """Return henries per unit of inductances whose matrix in free space is L0 (n, n), shape (n,)."""
    return np.ones(len(L0)) if unit_L == "H" else self_inductances(sensor) / np.diagonal(L0)


def absolute(sensor: Sensor, found: Impedance) -> tuple[Impedance, tuple[str, ...]]:
    """Return an impedance in henry and ohm, and what had to be left out."""
    if found.unit_L == "H":
        return found, ()
    n = len(sensor.coils)
    scale = henries(sensor, found.unit_L, found.L0)
    parts: dict[str, Any] = {}
    for name in ("L", "R", "L0", "error_L", "error_R"):
        matrix = np.asarray(getattr(found, name), dtype=float)
        parts[name] = np.zeros_like(matrix)
        parts[name][..., range(n), range(n)] = diagonals(matrix) * scale
    return replace(found, **parts, R_dc=scale * found.R_dc, unit_L="H"), ((_IDLE,) if n > 1 else ())


def table_impedance(data: xr.Dataset, leading: tuple[str, ...] | None = None) -> Impedance:
    """Return the impedance of a table, with its varied dimensions, or others, as leading axes; NaN where one failed."""
    order = (*(varied(data) if leading is None else leading), "coil", "coil_2")
    L, R, error_L, error_R = (data[name].transpose(*order).to_numpy() for name in ("L", "R", "error_L", "error_R"))
    L0 = data["L0"].to_numpy()
    report = SolveReport("table", 0, 0, 0.0, 0.0, 0.0)
    unit, frequency = str(data.attrs["unit_L"]), float(data.attrs["frequency"])
    none, uneven = np.zeros(len(L0)), data.attrs.get("tracks") == "uneven"
    return Impedance(frequency, L, R, L0, none, error_L, error_R, unit, report, uneven=uneven)


def terminals(sensor: Sensor, data: xr.Dataset) -> tuple[xr.Dataset, tuple[str, ...]]:
    """Return ``L`` [H] and ``R`` [ohm] at the end of the leads, dims (*varied(data), coil), and what is left out.

    Raises SceneError when the tracks' losses cannot be computed.
    """
    sensor = at_temperature(sensor)
    found, missing = absolute(sensor, table_impedance(data))
    good = _converged(data)
    seen, reasons = at_terminals(sensor, replace(found, L=found.L[good], R=found.R[good]))
    if seen is None:
        raise SceneError(f"{sensor.name}: {'; '.join(reasons)}")
    shape = (*good.shape, len(sensor.coils))
    L, R = np.full((2, *shape), np.nan)
    L[good], R[good] = seen.L, seen.R
    return _over_loads(sensor, data, L=L, R=R), missing


def table_inductances(sensor: Sensor, data: xr.Dataset) -> xr.Dataset:
    """Return the inductance of each coil, driven alone, in henry, dims (*varied(data), coil).

    ``L`` and ``error_L`` [H], NaN where a load has no result; ``L0`` (coil) [H]; where the table has them the signed
    parts of the errors, ``shared_L`` (part, ...) and ``alone_L`` (cause, ...) [H], and ``slope_T_L`` and
    ``slope_T_L_by`` (thermal_cause, ...) [H/K].
    """
    found, good = absolute(sensor, table_impedance(data))[0], _converged(data)[..., None]
    L, error_L, L0 = (diagonals(part) for part in (found.L, found.error_L, found.L0))
    each = {name: np.where(good, part, np.nan) for name, part in (("L", L), ("error_L", error_L))}
    scale = ("coil", L0 / np.diagonal(data["L0"].to_numpy()))
    parts = {name: data[name] for name in ("shared_L", "alone_L", "slope_T_L", "slope_T_L_by") if name in data}
    own = _over_loads(sensor, data, **each).assign(L0=("coil", L0), scale=scale)
    return own.assign({name: part * own["scale"] for name, part in parts.items()}).drop_vars("scale")


def loads_over(low: Array, high: Array, count: int) -> Array:
    """Return `count` even values of each component of a load, all combinations, shape (m, d)."""
    axes = [np.linspace(a, b, count) for a, b in zip(low, high, strict=True)]
    return tensor_grid(*axes).reshape(-1, len(axes))


def table_poses(data: xr.Dataset, prefix: str = "") -> Array:
    """Return poses of a table, or by the prefix of their names their errors, (n, 6); missing components are zero."""
    found, dims = np.zeros((data["status"].size, len(POSE))), data["status"].dims
    for k, name in enumerate(POSE):
        if f"{prefix}{name}" in data:
            found[:, k] = data[f"{prefix}{name}"].transpose(*dims).to_numpy().ravel()
    return found


def _converged(data: xr.Dataset) -> Mask:
    """Return which loads of a table have a result, in the order of `varied`."""
    return answered(data).transpose(*varied(data)).to_numpy()


def _over_loads(sensor: Sensor, data: xr.Dataset, **each: Array) -> xr.Dataset:
    """Return values of every coil at every load, shape (*sizes, n), under the names of loads and coils."""
    loads = varied(data)
    coords = {**{name: data[name] for name in loads}, "coil": sensor.coil_names}
    return xr.Dataset({name: ((*loads, "coil"), values) for name, values in each.items()}, coords)


@checked_arguments
def sensor_calibration(sensor: Sensor, data: xr.Dataset) -> Calibration:
    """Return the calibration of a sensor in henry, each coil driven alone, without leads.

    Its `codes` are those of the scene's converter (`code_calibration`), made when they are first asked for.

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`, in henry or per metre.

    Raises
    ------
    ValueError
        When the table holds too few loads, or is of other coils, another target or layer.

    Examples
    --------
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> known = sm.sensor_calibration(sensor, data)
    >>> known.forces
    ('F_x', 'F_z')
    >>> known.inverse(known.forward(F_x=0.1, F_z=0.4)).forces.round(3).tolist()
    [0.1, 0.4]
    """
    check_provenance(sensor, data.attrs)
    free, noise = None if data.attrs["unit_L"] == "H" else self_inductances(sensor).tolist(), None
    with suppress(ValueError):  # no converter, or none that can follow: all coils count alike
        noise = sensor_front_end(sensor, data)[0].noise.tolist()
    found, own = calibration(data, free, noise), table_inductances(sensor, data)
    return replace(
        found, model_error=_largest(own), table_errors=_table_errors(sensor, own, found.forces),
        in_codes=partial(code_calibration, sensor, data),
    )


def _table_errors(sensor: Sensor, own: xr.Dataset, forces: Sequence[str]) -> TableErrors:
    """Return the errors of `table_inductances`, with what the silicone's sources differ by."""
    modulus = max((each.modulus_deviation or 0.0 for each in silicones_of(sensor)), default=0.0)
    return table_errors(_without_single(own), forces, modulus)


def with_idle(sensor: Sensor, idle: str | None) -> Sensor:
    """Return a sensor whose idle coils are "open", "shorted" or "live", by None as they are."""
    readout = sensor.readout.model_copy(update={} if idle is None else {"idle_coil": idle})
    return sensor.model_copy(update={"readout": readout})


def other_way(idle: str) -> tuple[str, str]:
    """Return what idle coils that are taken for `idle` may be instead, and in words that they rather are."""
    other = "shorted" if idle == "open" else "open"
    return other, f"the readings are rather with idle coils {other} than {idle}: --idle {other}"


def convention(sensor: Sensor, read: str = "L at the terminals", other_idle: str = "") -> str:
    """Return in words what readings of a sensor are, and what idle coils explain them as well."""
    alike = f"; {other_idle} ones fit as well" if other_idle else ""
    return f"{read}, idle coils {sensor.readout.idle_coil}{alike}"


def with_terminals(sensor: Sensor, data: xr.Dataset) -> xr.Dataset:
    """Return a table with ``L_coil`` [its unit], each coil alone, and in henry ``L_terminal`` [H], (*varied, coil).

    The latter is what a converter or a meter reads: with leads, idle coils as the scene says. A table per metre of
    depth has none, its model knows nothing of idle coils. NaN where a load has no result.
    """
    found = table_impedance(data)
    each = {"L_coil": diagonals(found.L)}
    if found.unit_L == "H":
        each["L_terminal"] = terminals(sensor, data)[0]["L"].to_numpy()
    return data.assign({name: ((*varied(data), "coil"), values) for name, values in each.items()})


@checked_arguments
def terminal_calibration(sensor: Sensor, data: xr.Dataset, idle: Idle | None = None) -> Calibration:
    """Return the calibration of what a converter or a meter reads [H]: at the terminals, with leads and idle coils.

    These are "open", "shorted" or "live" by `idle`, else as the scene says. Raises ValueError when the table holds too
    few loads.

    Examples
    --------
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> known = sm.terminal_calibration(sensor, data)
    >>> known.inverse(known.forward(F_x=0.1, F_z=0.4)).forces.round(3).tolist()
    [0.1, 0.4]
    """
    known, as_read = sensor_calibration(sensor, data), with_idle(sensor, idle)
    found = absolute(as_read, table_impedance(data))[0]
    none = np.zeros_like(found.L0)
    free, _ = at_terminals(as_read, replace(found, L=found.L0, R=none, error_L=none, error_R=none))
    L = terminals(as_read, data)[0]["L"]
    L0 = known.L0 + sensor.readout.lead_inductance if free is None else free.L
    table = data[["status"]].assign(L=L, L0=("coil", L0)).assign_attrs(unit_L="H")
    shown = calibration(table, noise=None if known.noise is None else known.noise.tolist())
    return replace(shown, model_error=known.model_error, table_errors=known.table_errors)


def code_calibration(sensor: Sensor, data: xr.Dataset, *, clock: float | None = None) -> Calibration:
    """Return the calibration of a sensor in codes of its converter, not rounded, with idle coils and leads.

    `clock` is external [Hz], by default the part's greatest. Raises SceneError without a converter, ValueError when it
    has no settings for this sensor or the table holds too few loads.
    """
    front, _ = sensor_front_end(sensor, data, clock=clock)
    seen = terminals(sensor, data)[0]
    codes = _terminal_codes(sensor, seen, front)
    whole = ((codes + front.below) / seen["L"]).to_numpy()
    rate = 0.5 * np.nanmax(whole.reshape(-1, len(front.noise)), axis=0)  # code over L^(-1/2)
    table = data[["status"]].assign(L=codes).assign_attrs(unit_L="code")
    found, own = calibration(table, noise=(rate * front.noise).tolist()), table_inductances(sensor, data)
    errors = _table_errors(sensor, own, found.forces).scaled(rate)
    return replace(found, model_error=rate * _largest(own), table_errors=errors)


def codes_of(sensor: Sensor, front: FrontEnd, L: Array, R: Array) -> Array:
    """Return the unrounded codes of L [H] and R [ohm] at the terminals, (..., n); NaN where there is none."""
    C, reference = at_temperature(sensor).readout.parallel_capacitance, clock_factor(sensor) * front.reference
    f = tank_frequency(np.where(np.isfinite(L), L, np.inf), C, R)
    return code_of(f, front.part, reference, front.input_divider, gain=front.gain, offset=front.offset)


def table_codes(sensor: Sensor, data: xr.Dataset, front: FrontEnd) -> xr.DataArray:
    """Return the unrounded codes of a table, dims (*varied(data), coil)."""
    return _terminal_codes(sensor, terminals(sensor, data)[0], front)


def _terminal_codes(sensor: Sensor, seen: xr.Dataset, front: FrontEnd) -> xr.DataArray:
    """Return the unrounded codes of what `terminals` gives, in its dims."""
    return seen["L"].copy(data=codes_of(sensor, front, *(seen[name].to_numpy() for name in ("L", "R"))))


def coil_table(sensor: Sensor, data: xr.Dataset) -> xr.Dataset:
    """Return `table_inductances` for `quality`: without loads of one value, with ``weights`` (signal, coil)."""
    own = table_inductances(sensor, data).assign(weights=(("signal", "coil"), signal_weights(sensor)))
    return _without_single(own)


def _without_single(own: xr.Dataset) -> xr.Dataset:
    """Return `table_inductances` without loads of one value."""
    return own.isel({name: 0 for name in varied(own) if own.sizes[name] == 1}, drop=True)


def model_errors(sensor: Sensor, data: xr.Dataset) -> Array:
    """Return the largest estimated error of each coil's inductance over a table, shape (n,) [H]."""
    return _largest(table_inductances(sensor, data))


def _largest(own: xr.Dataset) -> Array:
    """Return the largest error of each coil over `table_inductances`, shape (n,) [H]."""
    return np.asarray(np.nanmax(own["error_L"].to_numpy().reshape(-1, own.sizes["coil"]), axis=0))


def sensor_front_end(
    sensor: Sensor, data: xr.Dataset, *, clock: float | None = None, rcount: int = 0xFFFF
) -> tuple[FrontEnd, tuple[str, ...]]:
    """Return the settings of the scene's converter for all loads of a table, and what was left out.

    `clock` and `rcount` as for `front_end`. Raises SceneError without a converter, ValueError when it has no
    such settings.
    """
    if sensor.readout.converter == "none":
        raise SceneError(f'{sensor.name}: readout.converter must be a part, such as "LDC1614"; got "none"')
    seen, missing = terminals(sensor, data)
    flat = [seen[name].to_numpy().reshape(-1, len(sensor.coils)) for name in ("L", "R")]
    good = np.isfinite(flat[0]).all(axis=-1)
    part, C = converter(sensor.readout.converter), at_temperature(sensor).readout.parallel_capacitance
    found = front_end(part, flat[0][good], flat[1][good], C, clock=clock, rcount=rcount)
    return found, (*missing, f"R is taken at {sensor.frequency:.4g} Hz{found.off(sensor.frequency)}")


def branches(sensor: Sensor, data: xr.Dataset) -> tuple[Array, Array]:
    """Return inductances at the same loads while the last cycle rises and falls, shape (m, n) [H] each.

    `data` is from `load_cycle`, its last cycle starting and ending without load; loads are even from none to the peak.
    """
    L = diagonals(data["L"].transpose("time", "coil", "coil_2").to_numpy())
    L = L * henries(sensor, data.attrs["unit_L"], data["L0"].to_numpy())
    share = data["share"].to_numpy()
    last = int(np.flatnonzero(share == share.max())[-1])
    first = int(np.flatnonzero(share[:last] == share.min())[-1])
    grid = np.linspace(share[first], share[last], 41)
    ways = (slice(first, last + 1), slice(None, last - 1 if last else None, -1))
    rising, falling = ([np.interp(grid, share[way], coil[way]) for coil in L.T] for way in ways)
    return np.array(rising).T, np.array(falling).T


@dataclass(frozen=True)
class Readings:
    """Readings at each load of a table, in the order of `varied`; NaN where a load has no result."""

    L: Array  # (*sizes, n) [H]
    error_L: Array  # estimated [H]
    L0: Array  # (n,), without target [H]
    front: FrontEnd | None  # settings of the converter; None without one that fits
    codes: Array | None  # (*sizes, n), not rounded
    left_out: tuple[str, ...]  # what the codes leave out, or why there are none


def readings(sensor: Sensor, data: xr.Dataset) -> Readings:
    """Return inductances and codes over a calibration."""
    own = table_inductances(sensor, data)
    L, error, L0 = (own[name].to_numpy() for name in ("L", "error_L", "L0"))
    if sensor.readout.converter == "none":
        return Readings(L, error, L0, None, None, ("the scene has no converter",))
    try:
        front, missing = sensor_front_end(sensor, data)
    except ValueError as reason:
        return Readings(L, error, L0, None, None, (str(reason),))
    return Readings(L, error, L0, front, table_codes(sensor, data, front).to_numpy(), missing)
